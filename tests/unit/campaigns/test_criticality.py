"""The objective of a drive: least margin over scale; a collision by its gap before and its impact speed beyond."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from pytest_dvp.campaigns.criticality import criticality
from pytest_dvp.drive.result import RunResult
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import ObjectTrack
from pytest_dvp.verdicts.gate import Gate
from pytest_dvp.verdicts.judging import judge, overall


def drive(gap: float, speed: float = 5.0) -> Log:
    """A car 4 m long drives straight at `speed` for 2 s; another one stands `gap` m beyond the end of its way."""
    t = np.arange(0.0, 2.01, 0.1)
    x, zero = speed * t, np.zeros(len(t))
    other = x[-1] + 4.0 + gap
    columns = {"t": t, "x": x, "y": zero, "yaw": zero, "v": zero + speed, "on_road": zero + 1.0}
    size = {"kind": "vehicle", "length": 4.0, "width": 2.0, "height": 1.5}
    track = ObjectTrack(**size, t=t, x=zero + other, y=zero, z=zero, yaw=zero, vx=zero, vy=zero)
    meta: dict[str, Any] = {"stage": "dt", "ego": {"length": 4.0, "width": 2.0, "center_x": 0.0}}
    return Log(columns, objects={"Other": track}, meta=meta)


def result(log: Log, *gates: Gate, silent: tuple[str, ...] = ()) -> RunResult:
    verdicts = tuple(judge(gates, log))
    status = "INCONCLUSIVE" if silent and overall(verdicts) == "PASS" else overall(verdicts)
    return RunResult(
        log, verdicts, status, None, "x.xosc", 1, "dt", "test", 7, "stop", "the end", {}, "", {}, never_fired=silent
    )


def test_a_collision_counts_by_the_gap_before_it() -> None:
    found = criticality(result(drive(0.4), Gate("collision", max=0.0)))
    assert found.objective == pytest.approx(0.4)
    assert (found.object, found.vacuous) == ("Other", False)


def test_a_collision_counts_by_its_impact_speed() -> None:
    found = criticality(result(drive(-3.0), Gate("collision", max=0.0)))
    assert found.objective == pytest.approx(-5.0)


def test_a_margin_is_divided_by_the_bound() -> None:
    log = drive(2.5)  # 2.5 m at 5 m/s are 0.5 s: an inverse of 2 1/s; the bound of 8 leaves 6/8
    found = criticality(result(log, Gate("max_ttc_inverse", max=8.0)))
    assert found.objective == pytest.approx(0.75)
    assert criticality(result(log, Gate("max_ttc_inverse", max=8.0), Gate("collision", max=0.0))).objective == (
        pytest.approx(0.75)
    )  # the gap of 2.5 m is further away


def test_a_gate_that_counts_and_holds_has_no_distance() -> None:
    found = criticality(result(drive(0.4), Gate("road_departure", max=0.0)))
    assert found.objective is None


def test_a_vacuous_drive_has_no_objective() -> None:
    found = criticality(result(drive(0.4), Gate("collision", max=0.0), silent=("Brake",)))
    assert (found.objective, found.vacuous) == (None, True)


def test_two_gates_of_one_metric_and_bound_keep_a_margin_each() -> None:
    log = drive(0.4)
    gates = [Gate("tet", max=1.0, options={"critical": value}) for value in (0.5, 60.0)]
    margins = criticality(result(log, *gates)).margins
    assert list(margins) == ["tet(critical=0.5) <= 1.00 s", "tet(critical=60) <= 1.00 s"]
    few, many = margins.values()
    assert few is not None
    assert many is not None
    assert many < few
