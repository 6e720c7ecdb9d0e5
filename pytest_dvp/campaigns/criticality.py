"""How near a drive came to breaking its tightest gate: one signed number for searches, and what it was about."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from pytest_dvp.logs.log_contents import FloatArray

if TYPE_CHECKING:
    from pytest_dvp.drive.result import RunResult
    from pytest_dvp.logs.log import Log
    from pytest_dvp.verdicts.judging import Verdict

DISTANCE_SCALE = 1.0
"""m of gap to another road user that count like using up a whole bound: about half the width of a free lane beside a
car, below which a pass is critical; a convention, which scales a search and changes no verdict."""
SPEED_SCALE = 1.0  # m/s of impact speed that count like exceeding a bound by all of it; the same convention
BROKEN = -1.0
"""What a drive counts whose stack or car broke, or whose failure has no measure: like a bound exceeded by all of it."""
LEAST = 1e-6  # of an objective below 0: a failure is told from a pass by its sign, even at an impact speed of 0


@dataclasses.dataclass(frozen=True)
class Criticality:
    """Of one drive.

    objective  least margin/scale over the gates, < 0 exactly for a failure; None: nothing was measured or it is vacuous
    gate       what the objective is of, as `max_jerk <= 4 m/s^3`; object: the other road user, "" if none
    margins    of each gate in its unit, None where it is not defined
    vacuous    an event of the storyboard never fired, so that the drive shows nothing
    """

    objective: float | None
    gate: str
    object: str
    margins: dict[str, float | None]
    vacuous: bool


def criticality(result: RunResult) -> Criticality:
    """The signed distance of a drive to failure.

    A gate's margin is divided by |bound|; where the bound is 0, by the metric's own `scale`. A collision counts by the
    smallest gap [m] before, and by the impact speed [m/s] beyond it. A gate that holds with a margin of exactly 0 is
    one that counts things (goal reached, departures): it has no distance and is left out, as is a gate that only says
    whether the test took place.
    """
    margins = {verdict.gate: verdict.margin for verdict in result.verdicts if verdict.metric}
    if result.status == "ERROR":
        return Criticality(BROKEN, "error", "", margins, False)
    vacuous = bool(result.never_fired) and result.status != "FAIL"
    parts = [part for verdict in result.verdicts if (part := _part(verdict, result.log)) is not None]
    if result.status == "FAIL" and not parts:
        return Criticality(BROKEN, next(v.gate for v in result.verdicts if v.status == "FAIL"), "", margins, False)
    if vacuous or not parts or (result.status == "INCONCLUSIVE"):
        return Criticality(None, "", "", margins, vacuous)
    value, gate, who = min(parts, key=lambda part: part[0])
    return Criticality(min(value, -LEAST) if result.status == "FAIL" else value, gate, who, margins, False)


def _part(verdict: Verdict, log: Log) -> tuple[float, str, str] | None:
    from pytest_dvp.metrics import find_metric

    if not verdict.metric or verdict.margin is None or verdict.bound is None:
        return None
    if verdict.status == "INCONCLUSIVE" or find_metric(verdict.metric).miss == "INCONCLUSIVE":
        return None  # it says whether the test took place, not how well
    if verdict.metric == "collision" and verdict.bound == 0.0:
        if verdict.status == "FAIL":
            return -max(impact_speed(log, verdict.object, verdict.t) / SPEED_SCALE, LEAST), verdict.gate, verdict.object
        gap, who = least_gap(log)
        return (gap / DISTANCE_SCALE, verdict.gate, who) if np.isfinite(gap) else None
    if verdict.margin == 0.0 and verdict.status == "PASS":
        return None
    scale = abs(verdict.bound) or find_metric(verdict.metric).scale
    return verdict.margin / scale, verdict.gate, verdict.object


def least_gap(log: Log) -> tuple[float, str]:
    """Smallest distance [m] between the ego's box and that of another road user, and who that is; inf in an empty
    world or where no size is known."""
    from pytest_dvp.logs.undefined import Undefined
    from pytest_dvp.metrics._ego_box import pair_boxes

    least, who = np.inf, ""
    for name, track in log.objects.items():
        try:
            _, ego, box = pair_boxes(log, name, track)
        except Undefined:
            continue
        if len(ego) and (gap := float(box_gap(ego, box).min())) < least:
            least, who = gap, name
    return least, who


def impact_speed(log: Log, name: str, t: float | None) -> float:
    """Speed [m/s] of the ego relative to a road user at time t [s]; 0 if either is not known."""
    from pytest_dvp.logs.undefined import Undefined
    from pytest_dvp.metrics._ego_box import pair_boxes

    if t is None or name not in log.objects:
        return 0.0
    try:
        times, ego, box = pair_boxes(log, name, log.objects[name])
    except Undefined:
        return 0.0
    # The sample before the touch: behind it the world may have stopped both.
    at = max(int(np.searchsorted(times, t, side="left")) - 1, 0)
    return float(np.hypot(*(ego[at, 5:7] - box[at, 5:7]))) if len(times) else 0.0


def box_gap(one: FloatArray, other: FloatArray) -> FloatArray:
    """Distance (n,) [m] between rectangles (n, 7) of x, y [m], yaw [rad], length, width [m], ...; 0 if a corner of one
    lies in the other. Two rectangles that do not overlap are nearest at a corner of one of them."""
    return np.minimum(_corners_to(one, other), _corners_to(other, one))


def _corners_to(one: FloatArray, box: FloatArray) -> FloatArray:
    least = np.full(len(one), np.inf)
    cos, sin = np.cos(one[:, 2]), np.sin(one[:, 2])
    c, s = np.cos(box[:, 2]), np.sin(box[:, 2])
    signs: Sequence[tuple[float, float]] = ((1, 1), (1, -1), (-1, 1), (-1, -1))
    for a, b in signs:
        along, across = 0.5 * a * one[:, 3], 0.5 * b * one[:, 4]
        dx = one[:, 0] + along * cos - across * sin - box[:, 0]
        dy = one[:, 1] + along * sin + across * cos - box[:, 1]
        x = np.maximum(np.abs(dx * c + dy * s) - 0.5 * box[:, 3], 0.0)
        y = np.maximum(np.abs(dy * c - dx * s) - 0.5 * box[:, 4], 0.0)
        least = np.minimum(least, np.hypot(x, y))
    return least
