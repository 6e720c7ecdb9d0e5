"""A speed without its sign: a car that drives backwards, and whose v says that it drives forwards."""

from __future__ import annotations

import numpy as np

from openscenario.findings import Findings
from pytest_dvp.doctor.redundant_motion import Motion

SLOW = 0.5  # m/s, below which the path of a car says little about where it goes; chosen
SAME = 0.25  # of the speed, within which the path is driven at it: a jittery position is not. Chosen
ALONG = 0.87  # cosine of 30 degrees between heading and path; no car slips so far while it parks. Chosen
LEAST = 1.5  # s of driving backwards in all, from which it is told; chosen
EITHER = 0.9  # of the driving that goes along the heading or against it: a heading in degrees does neither. Chosen
FORWARDS = 0.2  # of what is driven in either direction, at least: else it is the heading that is turned round. Chosen


def check_unsigned(motion: Motion, file: str, findings: Findings) -> None:
    """A warning where v is positive while the positions go against the heading. Needs x, y, yaw and v."""
    of = motion.of
    if not motion.has("v", "path_speed") or not np.isfinite(motion.heading).any():
        return
    v, path = of["v"], of["path_speed"]
    if not np.isfinite(v).any() or float(np.nanmin(v)) < -SLOW:
        return
    goes = (v > SLOW) & (np.abs(path - v) < SAME * v)
    along = np.cos(motion.course - motion.heading)
    back, ahead = goes & (along < -ALONG), goes & (along > ALONG)
    count, both = np.count_nonzero(back), np.count_nonzero(back | ahead)
    if count * motion.step < LEAST or both < EITHER * np.count_nonzero(goes) or both - count < FORWARDS * both:
        return
    rows = np.flatnonzero(back)
    findings.add(
        "log.unsigned_speed", file, None, "column v",
        f"v has no sign: for {count * motion.step:.2g} s the car drives backwards, and v is positive, first from t = "
        f"{motion.t[rows[0]]:.6g} s",
        allowed="v < 0 while the car reverses",
        hint="give v its sign, by the gear for instance, or cut the log there: a model drives forwards",
        severity="warning",
    )  # fmt: skip
