"""What is remembered of a test's runs of one scenario and stage, and what its summary says of them.

Imports the standard library only: it is loaded with the plugin.
"""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

from pytest_dvp.text.names import NOT_ASKED
from pytest_dvp.verdicts.broken_run import is_of_the_run
from pytest_dvp.verdicts.silent_events import is_of_events, missed, without_optional

_NOTHING = (9, 9, 0.0)  # the urgency of no gate


@dataclasses.dataclass
class RunSummary:
    """Runs of one scenario and stage in one test; results as `RunResult.as_dict` makes them.

    last, tightest  the run driven last, and of those before it the one nearest to its bounds
    driven          how many there were
    asked           gates (metric or label) that the test asked for; None: all, or none by the fixture `gate`
    optional        events that the test lets be
    silent          of a search, for each variant the events that never fired in it, those of `optional` too
    raised          `gate` did not let one pass
    steps           how often a test drove, or called `gate`
    """

    last: dict[str, Any]
    closest_to_bound: dict[str, Any] | None = None
    driven: int = 1
    asked: list[str] | None = None
    optional: list[str] = dataclasses.field(default_factory=list)
    silent: list[tuple[str, ...]] = dataclasses.field(default_factory=list)
    judged: bool = False
    raised: bool = False
    steps: int = 1

    def add_run(self, result: Mapping[str, Any]) -> None:
        """A further run."""
        self.closest_to_bound = self._tighter()
        self.last = dict(result)
        self.driven += 1
        self.steps += 1

    def count(self, result: Mapping[str, Any]) -> None:
        """Count a variant of a search, and the events that never fired in it."""
        self.silent.append(tuple(result.get("never_fired", ())))

    def add_request(self, metrics: Sequence[str] | None, optional: Sequence[str] = (), *, passed: bool) -> None:
        """The test asks for these gates, or for all, and lets these events be."""
        self.optional = list(dict.fromkeys([*self.optional, *optional]))
        every = metrics is None or (self.judged and self.asked is None)
        self.asked = None if every else list(dict.fromkeys([*(self.asked or ()), *(metrics or ())]))
        self.judged = True
        self.steps += 1
        self.raised = self.raised or not passed

    def reported_run(self, *, failed: bool) -> dict[str, Any]:
        """The run that stands for all: of a failed test the last one, which failed it; else the tightest.

        Keys besides those of the run: driven, tightest (True if it was chosen among several), of a passed test that
        gave none of the runs to `gate` `never_judged`: how many gates did not pass, and of a search
        `search`: variants, and never_fired {event: number of variants in which it did not}. Gates that did not pass
        and that the test left out are NOT_ASKED, and do not count in the status; a fault of the run does.
        """
        from pytest_dvp.verdicts.result_text import on_condition
        from pytest_dvp.verdicts.statuses import worst_status

        chosen = without_optional(self.last if failed else self._tighter(), self.optional)
        verdicts = [v if self._counts(v, failed=failed) else {**v, "status": NOT_ASKED} for v in chosen["verdicts"]]
        unsaid = missed(chosen) if failed and self.raised else None
        if unsaid is not None and all(v["status"] in ("PASS", NOT_ASKED) for v in verdicts):
            verdicts.append(unsaid)
        status = chosen["status"]
        if any(v["status"] == NOT_ASKED for v in verdicts):
            status = worst_status(verdicts)
        if failed and self.raised and status in ("PASS", NOT_ASKED):
            status = "INCONCLUSIVE"  # no gate of that name
        left_out = sum(v["status"] == NOT_ASKED for v in verdicts)
        return {
            **chosen,
            "verdicts": verdicts,
            "status": status,
            "replay": on_condition(chosen["replay"], metrics_of(self.asked or (), chosen["verdicts"]), self.optional),
            "driven": self.driven,
            "tightest": self.driven > 1 and not failed,
            **({"never_judged": left_out} if left_out and not (failed or self.judged) else {}),
            **({"search": self._search()} if self.silent else {}),
        }

    def _search(self) -> dict[str, Any]:
        counts = Counter(name for silent in self.silent for name in silent)
        return {"variants": len(self.silent), "never_fired": dict(counts.most_common())}

    def _counts(self, verdict: Mapping[str, Any], *, failed: bool) -> bool:
        if verdict["status"] == "PASS" or is_of_the_run(verdict):
            return True
        return failed and self._is_asked(verdict)

    def _is_asked(self, verdict: Mapping[str, Any]) -> bool:
        chosen = self.asked is None or verdict["metric"] in self.asked or verdict["gate"] in self.asked
        return chosen or is_of_events(verdict)

    def _tighter(self) -> dict[str, Any]:
        """The run whose worst gate of those asked for is the worse one; of two alike the one whose worst of all gates
        is: no collision tells nothing of how near it was. The earlier one if they are alike in that too."""
        from reports.verdicts import urgency

        def worst(result: Mapping[str, Any]) -> tuple[float, ...]:
            asked = map(urgency, filter(self._is_asked, result["verdicts"]))
            return *min(asked, default=_NOTHING), *min(map(urgency, result["verdicts"]), default=_NOTHING)

        earlier = self.closest_to_bound
        return self.last if earlier is None or worst(self.last) < worst(earlier) else earlier


def metrics_of(names: Sequence[str], verdicts: Sequence[Mapping[str, Any]]) -> list[str]:
    """The metrics that a test's choice of gates means: a gate may be named by its label; a slip means none."""
    if not names:
        return []
    from pytest_dvp.metrics import known_metrics

    labels = {verdict["gate"]: verdict["metric"] for verdict in verdicts}
    meant = [labels.get(name, name) for name in names]
    return [name for name in dict.fromkeys(meant) if name in known_metrics()]
