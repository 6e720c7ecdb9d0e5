"""Triggers, condition groups and conditions with their edges and delays.

Source: ASAM OpenSCENARIO XML 1.3, sections "Triggers", "Condition edges" and "Condition delay": an edge needs two
evaluations, so the first evaluation of a condition with an edge is false; a delayed condition has the value it had
`delay` earlier, false before.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Collection

from openscenario.model import Condition

Test = Callable[[], bool]
NOBODY: Collection[str] = ()


class ConditionState:
    """One condition under observation."""

    __slots__ = (
        "_delay",
        "_edge",
        "_history",
        "_last",
        "_test",
        "entities",
        "ever",
        "model",
        "true_at_start",
        "value",
    )

    def __init__(self, condition: Condition, test: Test, entities: Collection[str] = NOBODY) -> None:
        """`entities`: the test leaves there for whom it was true last."""
        self.model = condition
        self.entities = entities
        self._test = test
        self._edge = condition.condition_edge
        self._delay = condition.delay
        self._last: bool | None = None
        self._history: deque[tuple[float, bool]] = deque()
        self.value = False
        self.ever = False  # was the bare condition ever true
        self.true_at_start = False  # at its first evaluation, where an edge cannot see it

    def evaluate(self, time: float) -> bool:
        """The condition's value now, edge and delay included; to be called once a step."""
        now = self._test()
        edge = self._edge
        last = self._last
        if edge == "none":
            out = now
        elif last is None:
            out = False
            self.true_at_start = now
        elif edge == "rising":
            out = now and not last
        elif edge == "falling":
            out = last and not now
        else:
            out = now != last
        self._last = now
        if now:
            self.ever = True
        if self._delay > 0.0:
            out = self._delayed(time, out)
        self.value = out
        return out

    def _delayed(self, time: float, out: bool) -> bool:
        history = self._history
        if not history or history[-1][1] != out:
            history.append((time, out))
        due = time - self._delay + 1e-9
        while len(history) > 1 and history[1][0] <= due:
            history.popleft()
        return history[0][1] if history[0][0] <= due else False

    def reset(self) -> None:
        """Forget what was true before, as if it had never been tested."""
        self._last = None
        self._history.clear()
        self.value = False


class TriggerState:
    """A trigger under observation: true if all conditions of one of its groups are.

    `entities`: those whose states made it true last; only groups that are true count (7.3.1).
    """

    __slots__ = ("entities", "groups")

    def __init__(self, groups: tuple[tuple[ConditionState, ...], ...]) -> None:
        self.groups = groups
        self.entities: tuple[str, ...] = ()

    def evaluate(self, time: float) -> bool:
        """Evaluate every condition (edges and delays need each step), then combine."""
        fired = False
        for group in self.groups:
            every = True
            for condition in group:
                if not condition.evaluate(time):
                    every = False
            if every and group:
                before = self.entities if fired else ()
                here = (name for condition in group for name in condition.entities)
                self.entities = tuple(dict.fromkeys((*before, *here)))
                fired = True
        return fired

    def reset(self) -> None:
        """Forget in all conditions what was true before."""
        for group in self.groups:
            for condition in group:
                condition.reset()
