"""What `discover` answers."""

from __future__ import annotations

import dataclasses
from typing import Any, Literal

from pytest_dvp.gap.discover.term import Term

Verdict = Literal["LAW", "STAND_IN", "NO_LAW"]


@dataclasses.dataclass(frozen=True, slots=True)
class FoundTerm:
    """A term with the 95 % interval of its coefficient (SI), and other forms that these data cannot tell from it."""

    term: Term
    low: float
    high: float
    same: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """JSON-able."""
        term = self.term
        found: dict[str, Any] = {
            "point": term.point.name, "part": term.point.part, "form": term.form.text, "same": list(self.same),
            "c": {"value": term.coefficient, "low": self.low, "high": self.high, "unit": term.unit},
        }  # fmt: skip
        if term.form.filter:
            found["tau"] = {"value": term.tau, "unit": "s"}
        if term.has_threshold:
            found["v0"] = {"value": term.v0, "unit": "m/s"}
        return found


@dataclasses.dataclass(frozen=True, slots=True)
class Law:
    """A law, or why there is none. points: where it may act as well, as far as these data tell; before, after: chi^2/N
    on the data fitted and held out; reasons: why it is no firmer; decides: the drive that would tell more."""

    verdict: Verdict
    terms: tuple[FoundTerm, ...]
    points: tuple[str, ...]
    before: tuple[float, float]
    after: tuple[float, float]
    reasons: tuple[str, ...]
    decides: str = ""

    @property
    def removed(self) -> tuple[float, float]:
        """Share of the error beyond the noise that is gone, at most 1, on the data fitted and held out."""
        fit, held_out = (
            min((b - a) / (b - 1.0), 1.0) if b > 1.0 else 0.0 for b, a in zip(self.before, self.after, strict=True)
        )
        return fit, held_out

    def as_dict(self, file: str | None) -> dict[str, Any]:
        """The document of `discover --json`."""
        sides = {"fit": 0, "held_out": 1}
        return {
            "verdict": self.verdict,
            "points": list(self.points),
            "terms": [term.as_dict() for term in self.terms],
            "file": file,
            "error": {
                side: {"before": self.before[k], "after": self.after[k], "removed": self.removed[k]}
                for side, k in sides.items()
            },
            "reasons": list(self.reasons),
            "decides": self.decides,
        }
