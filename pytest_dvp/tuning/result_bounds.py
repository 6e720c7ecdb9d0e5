"""What is to be reached at the end: the paper's 10th iteration passed, row by row."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

from pytest_dvp.tuning.held_out_judge import HeldOutScore
from pytest_dvp.tuning.iteration_plan import STAGES
from pytest_dvp.tuning.paper_result import TENTH
from pytest_dvp.tuning.stage_gap import Figure

SAMPLE, SEEN = 0.01, 0.05  # s, one sample of a log, and of what the stack saw
GAIN = 0.02  # greatest distance of the gain from 1 beside an MNCC
NOISES = 2.0  # times the noise of the measured position that the twin may be off after 2 s
LIKENESS = {"ego x": 0.9999, "ego y": 0.9999, "steer": 0.99, "velocity": 0.995, "object x": 0.995, "object y": 0.995}
"""Least MNCC between two stages."""
DRIVE = {
    "max TTC^-1": (0.37, "1/s"),
    "TET": (0.0, "s"),
    "max jerk": (1.8, "m/s^3"),
    "lateral RMSE, path": (0.30, "m"),
}
"""Greatest value on each stage, and its unit."""
EQUIVALENT = ("max TTC^-1", "TET", "max jerk", "completion time", "lateral RMSE, lane", "lateral RMSE, path")
"""Metrics in which the stages must be alike."""


@dataclasses.dataclass(frozen=True, slots=True)
class Bound:
    """One row: what, between or on which stages, the value with its interval, the worst drive, the bound in words,
    whether it holds, the paper's value, and the value of the beginning; margin: within which a difference and its
    interval must lie, None of a row that is no difference."""

    what: str
    where: str
    value: float | None
    half_width: float | None
    worst: float | None
    bound: str
    holds: bool
    paper: str
    first: float | None
    margin: float | None = None

    @property
    def undecided(self) -> bool:
        """It does not hold, but only because the repeats are too few to tell."""
        if self.holds or self.margin is None or self.value is None:
            return False
        return abs(self.value) - (self.half_width or 0.0) <= self.margin

    def as_dict(self) -> dict[str, Any]:
        """The fields as JSON holds them, and `undecided`."""
        return {**dataclasses.asdict(self), "undecided": self.undecided}


def bounds(first: HeldOutScore, last: HeldOutScore) -> list[Bound]:
    """Every row of it. Of MNCC, lag and gain the mean drive of each stage decides, of all else the mean over held-out
    drives; the worst variant, or drive, stands beside it."""
    rows = []
    driven = [stage for stage in STAGES if stage in last.gap.metrics]
    pairs = [pair for pair in ("dt-rw", "pe-rw") if set(pair.split("-")) <= set(driven)]
    for pair in pairs:
        for name, least in LIKENESS.items():
            now, then = last.gap.ensemble.get(pair, {}), first.gap.ensemble.get(pair, {})
            shown = f"{TENTH[name][0 if pair == 'dt-rw' else 2]:.4f}"  # its DT and its RW column
            rows.append(
                _row(f"MNCC {name}", pair, now.get(name), then.get(name), f">= {least:g}", least, shown, up=True)
            )
            lag = SEEN if name.startswith("object") else SAMPLE
            for part, most, unit in (("lag", lag, "s"), ("gain", GAIN, "")):
                text = f"<= {most:g} {unit}".rstrip()
                key = f"{name}.{part}"
                title = f"lag of {name}" if part == "lag" else f"gain of {name}, from 1"
                rows.append(_row(title, pair, now.get(key), then.get(key), text, most + 1e-9, ""))
    for name, (most, unit) in DRIVE.items():
        for k, stage in enumerate(STAGES):
            if stage not in driven:
                continue
            shown = f"{TENTH[name][k]:g}" if name in TENTH else ""
            now_row, then_row = last.gap.metrics[stage][name], first.gap.metrics[stage].get(name)
            rows.append(_row(name, stage, now_row, then_row, f"<= {most:g} {unit}", most, shown))
    rows.append(_position(first, last))
    rows += [_equivalent(name, pair, first, last) for pair in pairs for name in EQUIVALENT]
    return rows


def _row(
    what: str, where: str, now: Figure | None, then: Figure | None, text: str, bound: float, paper: str, *,
    up: bool = False,
) -> Bound:  # fmt: skip
    if now is None:
        return Bound(what, where, None, None, None, text, False, paper, then.mean if then else None)
    complete = now.mean is not None and now.known == now.count
    holds = complete and now.mean is not None and (now.mean >= bound if up else now.mean <= bound)
    return Bound(what, where, now.mean, now.half_width, now.worst, text, holds, paper, then.mean if then else None)


def _position(first: HeldOutScore, last: HeldOutScore) -> Bound:
    most = NOISES * last.position_noise
    holds = math.isfinite(last.position) and last.position <= most
    text = f"<= {most:.4f} m, {NOISES:g} times the noise of the measured position"
    return Bound("open-loop position after 2 s", "twin", last.position, None, None, text, holds, "", first.position)


def _equivalent(name: str, pair: str, first: HeldOutScore, last: HeldOutScore) -> Bound:
    """Alike: the 95 % interval of the difference, from the repeats, lies within GAIN of the metric's bound, of a metric
    without one within GAIN of its value in the second stage (two one-sided tests).

    Not whether the intervals of both stages meet: the fewer the repeats, the sooner they do.
    Source: Schuirmann, J. Pharmacokin. Biopharm. 15 (1987) 657.
    """
    what = f"{name}, between stages"
    apart, then = last.gap.difference[pair].get(name), first.gap.difference[pair].get(name)
    before = then.mean if then else None
    stages = [last.gap.metrics[stage].get(name) for stage in pair.split("-")]
    value = stages[-1]
    complete = all(each is not None and each.known == each.count for each in stages)
    if not complete or apart is None or apart.mean is None or value is None or value.mean is None:
        return Bound(what, pair, None, None, None, "defined in every drive", False, "", before)
    margin = GAIN * (DRIVE[name][0] if name in DRIVE else abs(value.mean))
    holds = apart.half_width is not None and abs(apart.mean) + apart.half_width <= margin + 1e-12
    text = f"its interval within {margin:.3g}, {GAIN:.0%} of the {'bound' if name in DRIVE else 'value'}"
    return Bound(what, pair, apart.mean, apart.half_width, apart.worst, text, holds, "", before, margin)
