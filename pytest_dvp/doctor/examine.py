"""examine: everything that is wrong with a log, as findings with what to do about each."""

from __future__ import annotations

import dataclasses

import numpy as np

from openscenario.findings import Finding, Findings
from pytest_dvp.doctor.angle_units import check_angles
from pytest_dvp.doctor.comparable_log import comparable
from pytest_dvp.doctor.dead_speed import check_dead_speed
from pytest_dvp.doctor.missing_values import check_missing
from pytest_dvp.doctor.position_drift import check_drift, check_lost_fix
from pytest_dvp.doctor.redundant_motion import Motion, motion_of
from pytest_dvp.doctor.repeated_values import check_repeats
from pytest_dvp.doctor.sensor_faults import check_echoes, check_sensors
from pytest_dvp.doctor.signs_and_axes import check_direction, check_turning
from pytest_dvp.doctor.speed_and_acceleration import check_acceleration, check_speed, check_wishes
from pytest_dvp.doctor.spikes import check_spikes
from pytest_dvp.doctor.time_base import check_commands, check_jumps, check_offsets, check_rate, check_stamps
from pytest_dvp.doctor.unheeded_commands import check_engaged, check_resting
from pytest_dvp.doctor.unsigned_speed import check_unsigned
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.table import findings_of


def examine(log: Log, *, file: str = "", line: int | None = None, output: bool = False) -> tuple[Finding, ...]:
    """Findings of the import and of the physical consistency of the log; an error means: do not compare with it.

    file  name for the messages; default: that of the import
    line  line of the second row of numbers, where the file has lines
    output  the log is what a model gave: no sensor is dead or saturated in it, and its ax may well be its command

    Limits: judges what at least two signals tell; needs about 5 s of motion, some turning for signs and axes, some
    speeding up or braking for ax. A delay between command and answer is no finding: that is for the model.
    """
    findings = Findings()
    findings.found.extend(findings_of(log))
    name = file or str(log.meta.get("import", {}).get("file", "log"))
    if len(log.t) < 3:
        if not findings.found:
            findings.add("log.too_short", name, None, "", f"{len(log.t)} rows are no log", allowed="3 or more")
        return findings.in_order()
    steps = np.diff(log.t)
    reversed_ = any(finding.code == "log.time_not_monotonic" for finding in findings.found)
    if not reversed_ and not np.all(steps >= 0):
        row = int(np.flatnonzero(~(steps >= 0))[0])
        findings.add(
            "log.time_not_monotonic", name, None, "column t", "time does not rise from row to row",
            found=f"{log.t[row + 1]:.6g} s after {log.t[row]:.6g} s", hint="split or sort the log there",
        )  # fmt: skip
        reversed_ = True
    if reversed_:
        check_jumps(log, name, findings)
        return findings.in_order()
    if np.any(steps == 0):
        kept = np.concatenate([[True], steps > 0])
        findings.add(
            "log.duplicate_stamps", name, None, "column t",
            f"{np.count_nonzero(~kept)} rows repeat the stamp before, first at t = {log.t[int(np.argmin(kept))]:.6g} s",
            hint="write each sample once", severity="warning",
        )  # fmt: skip
        log = dataclasses.replace(log, columns={key: values[kept] for key, values in log.columns.items()})
    if not check_rate(log, name, line, findings):
        return findings.in_order()
    check_stamps(log, name, findings)
    check_missing(log, name, findings)
    check_engaged(log, name, findings)
    if not output:
        check_dead_speed(log, name, findings)
        check_repeats(log, name, findings)
        check_spikes(log, name, findings)
    log = comparable(log) if not output else log  # no other check takes a spike for a jump, or a driver for a car
    before = len(findings.found)
    check_jumps(log, name, findings)
    check_lost_fix(log, name, findings)
    if not output and not any(f.code == "log.concatenated" for f in findings.found[before:]):
        check_drift(log, name, findings)
    if not output and log.meta.get("stage") != "dt":  # a twin without a steering of its own obeys to the letter
        check_echoes(log, name, findings)
    motion = motion_of(log)
    if motion is None or any(f.code == "log.concatenated" for f in findings.found[before:]):
        return findings.in_order()
    motion = check_speed(motion, name, findings)
    motion = check_direction(motion, name, findings)
    check_unsigned(motion, name, findings)
    motion = check_angles(log, motion, name, findings)
    if not output:
        check_sensors(log, motion, name, findings)
    check_acceleration(motion, name, findings)
    check_wishes(motion, name, findings)
    if not output:
        check_resting(log, motion, name, findings)
    check_turning(motion, name, findings)
    righted = _righted(motion, findings)
    check_offsets(righted, float(np.median(np.diff(log.t))), name, findings)
    check_commands(righted, name, findings)
    return findings.in_order()


def _righted(motion: Motion, findings: Findings) -> Motion:
    """The motion as it would be without the signs and axes that were found wrong, so that clocks can be judged."""
    of = dict(motion.of)
    for finding in findings.found:
        column = finding.element.removeprefix("column ")
        if finding.code == "log.axes_swapped" and column == "ax":
            of["ax"], of["ay"] = of["ay"], of["ax"]
        elif finding.code in ("log.sign_flipped", "log.axes_swapped") and column != "v":  # which is righted already
            witness = {"yaw": "turn", "x": "path_turn", "y": "path_turn"}.get(column, column)
            if witness in of:
                of[witness] = -of[witness]
    return dataclasses.replace(motion, of=of)
