"""The running storyboard as a tree of elements with states, as the standard's state machine has them.

Source: ASAM OpenSCENARIO XML 1.3, section "States and transitions of StoryboardElements".
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, NamedTuple

from openscenario.model import NOWHERE, At

if TYPE_CHECKING:
    from openscenario import model
    from openscenario.storyboard.triggers import TriggerState

Kind = Literal["storyboard", "story", "act", "maneuverGroup", "maneuver", "event", "action"]

INIT, STANDBY, RUNNING, COMPLETE = "initState", "standbyState", "runningState", "completeState"
TO_STANDBY, START, END, STOP, SKIP = (
    "initToStandbyTransition",
    "startTransition",
    "endTransition",
    "stopTransition",
    "skipTransition",
)


class Transition(NamedTuple):
    """One change of state: time [s], element and its kind, transition (`kind_of_change`), states, place in the
    file; names from the story down to the element, which tell apart what has the same name."""

    time: float
    element: str
    kind: str
    transition: str
    from_state: str
    to_state: str
    file: str
    line: int
    path: tuple[str, ...] = ()


class Node:
    """An element of the storyboard while it runs.

    `changes` tells for each transition the latest step it happened in and its number in the log; `executions` counts
    starts (of events skips too); `order` is its place in the file.
    """

    __slots__ = (
        "actors",
        "at",
        "changes",
        "children",
        "element",
        "executions",
        "kind",
        "maximum",
        "name",
        "order",
        "parent",
        "path",
        "priority",
        "start",
        "state",
        "stop",
        "waits",
    )

    def __init__(
        self,
        kind: Kind,
        name: str,
        parent: Node | None,
        at: At = NOWHERE,
        *,
        maximum: int = 1,
        priority: str = "",
        element: object = None,
    ) -> None:
        self.kind: Kind = kind
        self.name = name
        self.parent = parent
        self.at = at
        self.path: tuple[str, ...] = (
            (*parent.path, name) if parent is not None and parent.kind != "storyboard" else (name,)
        )
        self.children: list[Node] = []
        self.state = INIT
        self.changes: dict[str, tuple[int, int]] = {}
        self.executions = 0
        self.order = 0
        self.maximum = maximum
        self.priority = priority
        self.element = element
        self.start: TriggerState | None = None
        self.stop: TriggerState | None = None
        self.waits = kind == "event"  # goes to standby before it starts, even if nothing keeps it there
        self.actors: model.Actors | None = None
        if parent is not None:
            parent.children.append(self)

    def finished(self) -> bool:
        """Whether all children are complete; an element without children does not end by itself."""
        return bool(self.children) and all(child.state == COMPLETE for child in self.children)

    def event_running(self) -> bool:
        """Whether any event below is running."""
        return any(child.state == RUNNING for child in self.children)

    def reset(self) -> None:
        """Back to the initial state for another execution of the parent."""
        for child in self.children:
            child.reset()
        self.state = INIT
        self.executions = 0
        for trigger in (self.start, self.stop):
            if trigger is not None:
                trigger.reset()


def find(root: Node, kind: str, reference: str, near: Node) -> Node | None:
    """The element of `kind` that `reference` (`name` or `outer::name`) means: the closest to `near` in the tree.

    Source: ASAM OpenSCENARIO XML 1.3, section "Naming": a name that is not unique is qualified by its parents' names.
    """
    wanted = tuple(reference.split("::"))
    best: Node | None = None
    best_common = -1
    stack = [root]
    while stack:
        node = stack.pop()
        stack.extend(reversed(node.children))
        if node.kind != kind or node.path[-len(wanted) :] != wanted:
            continue
        common = 0
        for ours, theirs in zip(near.path, node.path, strict=False):
            if ours != theirs:
                break
            common += 1
        if common > best_common:
            best, best_common = node, common
    return best
