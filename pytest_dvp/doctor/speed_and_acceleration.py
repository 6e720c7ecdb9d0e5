"""Speed and accelerations: their units, signs and axes, each against the others that tell the same motion."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from openscenario.findings import Findings
from pytest_dvp.doctor.redundant_motion import ALIKE, Motion, best_lag, correlation, slope
from pytest_dvp.doctor.signs_and_axes import shape_of, tell_sign
from pytest_dvp.logs.log_contents import FloatArray

LONGEST = 1.0  # [s] that a drive is late
STRONGER = 4.0  # dv/dt over its command: no gain of a drive that a model could have
WEAKER = 0.25  # of the wish is answered: below it a unit is wrong, no car brakes so weakly; chosen, not measured
HARDEST = 12.0  # m/s^2: more is asked for by no driver of a car on a road
SAME = 0.1  # of the speed over ground, within which v is that speed
GRIPS = 0.15  # of a drive in which v must be right, for what differs elsewhere to be slip
UNEVEN = 0.2  # of the median ratio, its spread from quarter to quarter: a unit gives the same ratio everywhere
VARIED = 1.4  # times the slow quarter of the wishes, above which the fast one can tell a unit from a limit
ALIKE_RATIOS = 0.15  # between the slow and the fast quarter: a unit gives one ratio for both
_SCALES = (  # ratio of what was read to what it should be -> what happened
    (3.6, "km/h stored as m/s", "km/h"), (2.23694, "mph stored as m/s", "mph"), (1.94384, "knots stored as m/s", "kn"),
    (1 / 3.6, "m/s stored as km/h", "m/s"),
)  # fmt: skip
_LENGTHS = (  # the same where a unit of length is wrong; `x` and not `v` where the positions are too large
    (1e3, "mm/s stored as m/s, or x and y in km", "mm/s"), (1e2, "cm/s stored as m/s", "cm/s"),
    (1 / 0.3048, "ft/s stored as m/s", "ft/s"),
)  # fmt: skip
_PLACES = ((1e-3, "mm"), (1e-2, "cm"), (0.3048, "ft"))
_ACCELERATIONS = (  # least and largest of what was read over what it should be -> what happened
    (0.08, 0.125, "g stored as m/s^2", "g"), (8.0, 12.5, "m/s^2 stored as g", "m/s^2"),
    (80.0, 125.0, "mg or cm/s^2 stored as m/s^2", "mg"), (0.008, 0.0125, "m/s^2 stored as mg or cm/s^2", "m/s^2"),
    (800.0, 1250.0, "mm/s^2 stored as m/s^2", "mm/s^2"),
)  # fmt: skip


def check_speed(motion: Motion, file: str, findings: Findings) -> Motion:
    """v against the way between positions; without them against ay and ax, both of which must say the same.

    Returns the motion with v righted, so that a wrong speed spoils no other check.
    """
    ratio, against = _speed_ratio(motion)
    if not math.isfinite(ratio) or 0.8 < ratio < 1.25:
        return motion
    nearest = min((*_SCALES, *_LENGTHS), key=lambda scale: abs(math.log(max(ratio, 1e-9) / scale[0])))
    text, unit = nearest[1:] if abs(ratio / nearest[0] - 1.0) < 0.1 else ("", "")
    place = next((place for value, place in _PLACES if abs(ratio / value - 1.0) < 0.05), "")
    if against != "the positions" and not unit:
        return motion  # accelerometers may have a scale of their own
    if against == "the positions" and _slips(motion):
        findings.add(
            "log.wheel_slip", file, None, "column v", "v fits the positions in parts of the drive only",
            found=f"v = {ratio:.3g} * distance over time in the median, the same in at least {GRIPS:.0%} of the drive",
            hint="wheels that lock or spin on a slippery road show another speed than the car has; a wrong unit would "
            "show everywhere", severity="warning",
        )  # fmt: skip
        return motion
    if place and against == "the positions":
        findings.add(
            "log.unit_suspect", file, None, "column x, y", f"x and y do not fit v: {place} stored as m",
            found=f"v = {ratio:.3g} * distance over time", allowed="0.8 to 1.25",
            hint=f"write `x [{place}]` and `y [{place}]`",
        )  # fmt: skip
        return dataclasses.replace(motion, of={**motion.of, "path_speed": motion.of["path_speed"] * ratio})
    findings.add(
        "log.unit_suspect",
        file,
        None,
        "column v",
        f"v does not fit {against}{': ' + text if text else ''}",
        found=f"v = {ratio:.3g} * {'distance over time' if against == 'the positions' else 'what they tell'}",
        allowed="0.8 to 1.25",
        hint=f"write `v [{unit}]`" if unit else "check the units of v, x, y and t",
    )
    if ratio < 1e-9:  # no speed at all beside that of the path
        return motion
    scaled: dict[str, FloatArray] = {name: motion.of[name] / ratio for name in ("v", "accel") if name in motion.of}
    return dataclasses.replace(motion, of={**motion.of, **scaled})


def _slips(motion: Motion) -> bool:
    """True if v is the speed over ground in a good part of the drive and another one, not in proportion, elsewhere."""
    of = motion.of
    at = motion.moving & (of["path_speed"] > 0) & np.isfinite(of["v"])
    if not at.any():
        return False
    ratio = np.abs(of["v"][at]) / of["path_speed"][at]
    low, middle, high = np.percentile(ratio, [25, 50, 75])
    return bool(np.mean(np.abs(ratio - 1.0) < SAME) >= GRIPS and high - low > UNEVEN * middle)


def _speed_ratio(motion: Motion) -> tuple[float, str]:
    """v over the true speed, and by what; NaN if nothing tells."""
    of = motion.of
    if motion.has("v", "path_speed"):
        speed, path = np.abs(of["v"]), of["path_speed"]
        at = motion.moving & (path > 0)
        if float(np.nanpercentile(path, 80)) < 0.5:  # the positions move by their noise only, or are in km
            at = np.isfinite(speed) & (path > 0)
            if float(np.nanpercentile(speed, 80)) < 0.5 or correlation(speed[at], path[at]) < ALIKE:
                return math.nan, ""
        if np.count_nonzero(at) < 20:
            return math.nan, ""
        return float(np.median(speed[at] / path[at])), "the positions"
    if not motion.has("v", "yaw_rate", "ax", "ay"):
        return math.nan, ""
    found = []
    for told, felt in ((of["v"] * of["yaw_rate"], of["ay"]), (of["accel"], of["ax"])):
        known = np.isfinite(told) & np.isfinite(felt)
        if abs(correlation(told[known], felt[known])) < 0.9:
            return math.nan, ""
        found.append(abs(slope(told[known], felt[known])))
    return (found[0], "ay and ax") if abs(found[0] / found[1] - 1.0) < 0.15 else (math.nan, "")


def check_acceleration(motion: Motion, file: str, findings: Findings) -> None:
    """ax against dv/dt, ay against v * yaw rate: swapped, turned round, in g."""
    of = motion.of
    if "v" not in of:
        return
    along = of["accel"]
    turn = next((name for name in ("yaw_rate", "turn", "path_turn") if name in of), None)
    lateral = of["v"] * of[turn] if turn is not None else np.zeros(len(along))
    known = np.isfinite(lateral) & np.isfinite(along)
    lateral, along = lateral[known], along[known]
    ax, ay = (of[name][known] if name in of else None for name in ("ax", "ay"))
    if ax is not None and ay is not None and np.std(lateral) > 0.1 and np.std(along) > 0.1:
        straight = abs(correlation(ax, along)) + abs(correlation(ay, lateral))
        crossed = abs(correlation(ax, lateral)) + abs(correlation(ay, along))
        if crossed > straight + 0.5 and crossed > 1.0:
            findings.add(
                "log.axes_swapped",
                file,
                None,
                "column ax",
                "ax and ay are swapped: ay goes with dv/dt, ax with v * yaw_rate",
                found=f"correlation {crossed / 2:.2f} crossed, {straight / 2:.2f} as named",
                hint="exchange the two names",
            )
            return
    for name, values, reference, what in (("ax", ax, along, "dv/dt"), ("ay", ay, lateral, "v * yaw_rate")):
        if values is None or np.std(reference) < 0.2 or abs(correlation(values, reference)) <= 0.8:
            continue
        ratio = abs(slope(values, reference))
        for least, most, text, unit in _ACCELERATIONS:
            if least < ratio < most:
                _tell_unit(name, text, f"{name} = {ratio:.3g} * {what}", unit, file, findings)
    for name, values in (("ax", ax), ("accel_cmd", of["accel_cmd"][known] if "accel_cmd" in of else None)):
        if values is not None and np.std(along) > 0.2 and shape_of(values, along, motion.step) < -0.6:
            tell_sign(name, "dv/dt", file, findings)


def check_wishes(motion: Motion, file: str, findings: Findings) -> None:
    """accel_cmd and speed_cmd against what the car did: another unit, or a pedal."""
    of = motion.of
    if motion.has("accel", "accel_cmd"):
        _check_accel_cmd(of["accel"], of["accel_cmd"], motion.step, file, findings)
    if motion.has("v", "speed_cmd"):
        at = motion.moving & np.isfinite(of["speed_cmd"]) & (np.abs(of["speed_cmd"]) > 0.5)
        if np.count_nonzero(at) < 50 or correlation(of["speed_cmd"][at], of["v"][at]) < 0.6:
            return
        _check_speed_cmd(of["speed_cmd"][at], of["v"][at], file, findings)


def _check_speed_cmd(wish: FloatArray, v: FloatArray, file: str, findings: Findings) -> None:
    """A commanded speed (n,) that is another one than the car has (n,), both in m/s: in another unit, or not reached. A
    unit gives the same ratio for slow and fast wishes; a car that cannot go faster follows the slow ones."""
    ratios = wish / np.where(v == 0.0, np.nan, v)
    ratio = float(np.nanmedian(ratios))
    slow, fast = np.percentile(wish, [25, 75])
    low, high = (float(np.nanmedian(ratios[rows])) for rows in (wish <= slow, wish >= fast))
    found = f"speed_cmd = {ratio:.3g} * v"
    for value, text, unit in _SCALES:
        # Miles and knots are told of measured speeds only: a controller may leave a car at half its wish.
        if not (abs(ratio / value - 1.0) < 0.15 and not 1.0 < value < 3.0):
            continue
        if value > 1.0 and not (fast > VARIED * slow and abs(high / low - 1.0) < ALIKE_RATIOS):
            top = float(np.percentile(v, 98))
            findings.add(
                "log.speed_not_reached", file, None, "column speed_cmd",
                f"the car does not reach the commanded speed, or it is {text}",
                found=f"{found} in the median, {low:.3g} for the slow and {high:.3g} for the fast quarter; v goes up "
                f"to {top:.3g} m/s", severity="warning",
                hint=f"if the unit is wrong, write `speed_cmd [{unit}]`; if the car cannot go faster, change nothing: "
                "that is the effect speed_limit or a part of speed_controller",
            )  # fmt: skip
        else:
            _tell_unit("speed_cmd", text, found, unit, file, findings)


def _check_accel_cmd(along: FloatArray, command: FloatArray, step: float, file: str, findings: Findings) -> None:
    lag, _ = best_lag(along, command, step, LONGEST)
    late = max(round(lag / step), 0)
    answer, wish = along[late:], command[: len(command) - late]
    known = np.isfinite(answer) & np.isfinite(wish)
    answer, wish = answer[known], wish[known]
    if len(wish) < 100 or np.std(answer) < 0.2 or abs(together := correlation(answer, wish)) < 0.7:
        return
    ratio = abs(slope(answer, wish)) / math.sqrt(abs(together))
    largest = float(np.percentile(np.abs(wish), 98))
    found = f"dv/dt = {ratio:.3g} * accel_cmd, which goes up to {largest:.3g} m/s^2"
    if ratio > STRONGER:
        if largest <= 1.0 and not 8.0 < ratio < 12.5:
            _tell_unit("accel_cmd", "a pedal from -1 to 1, or g, stored as m/s^2", found, "g", file, findings, _PEDAL)
        else:
            _tell_unit("accel_cmd", "g stored as m/s^2", found, "g", file, findings)
    elif ratio < WEAKER and largest > HARDEST:
        if 0.08 < ratio < 0.125:
            _tell_unit("accel_cmd", "m/s^2 stored as g", found, "m/s^2", file, findings)
        elif 0.008 < ratio < 0.0125:
            _tell_unit("accel_cmd", "cm/s^2 or percent stored as m/s^2", found, "cm/s^2", file, findings, _PEDAL)
        else:
            _tell_unit("accel_cmd", "percent stored as m/s^2", found, "", file, findings, _PEDAL)


_PEDAL = "a pedal is `throttle_cmd [%]` and `brake_cmd [%]`, or gets `scale` (m/s^2 for a full pedal) in a mapping"


def _tell_unit(name: str, text: str, found: str, unit: str, file: str, findings: Findings, also: str = "") -> None:
    hint = "; ".join(part for part in (f"write `{name} [{unit}]`" if unit else "", also) if part)
    findings.add("log.unit_suspect", file, None, f"column {name}", text, found=found, hint=hint)
