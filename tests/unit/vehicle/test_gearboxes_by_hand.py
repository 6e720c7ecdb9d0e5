"""One step of what a gearbox does to the drive, by hand: see `tests/unit/vehicle/test_effects_by_hand.py`."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from vehicle.model.effect_catalogue import find_effect

SHIFTS = {"T": 0.4, "v1": 3.0, "step": 1.8, "demand": 0.1, "cut": 0.8}
DRIVES = {"t": 7.0, "t_start": 0.0, "settle": 0.0, "dt": 0.1, "accel_lead": 0.0}
IDLES = {"a": 0.6, "v0": 3.0, "braking": 0.5}

Row = tuple[str, dict[str, Any], dict[str, Any], dict[str, Any], dict[str, Any], dict[str, Any]]
ROWS: tuple[Row, ...] = (
    # an idling gearbox: 0.6 m/s^2 at standstill, nothing at 3 m/s, so 0.4 at 1 m/s
    ("creep", IDLES, {"vx": 1.0, "accel": 0.0, "accel_lead": 0.0}, {}, {"accel": 0.4, "accel_lead": 0.0}, {}),
    ("creep", IDLES, {"vx": 1.0, "accel": 0.3, "accel_lead": 0.2}, {}, {"accel": 0.4, "accel_lead": 0.1}, {}),
    ("creep", IDLES, {"vx": 1.0, "accel": 0.5, "accel_lead": 0.0}, {}, {"accel": 0.5, "accel_lead": 0.0}, {}),
    ("creep", IDLES, {"vx": 1.0, "accel": -1.0, "accel_lead": -0.5}, {}, {"accel": -0.8, "accel_lead": -0.5}, {}),
    ("creep", IDLES, {"vx": 3.5, "accel": 0.0, "accel_lead": 0.0}, {}, {"accel": 0.0, "accel_lead": 0.0}, {}),
    ("creep", IDLES, {"vx": -1.0, "accel": 0.0, "accel_lead": 0.0}, {}, {"accel": 0.6, "accel_lead": 0.0}, {}),
    # a gearbox: up above 3 m/s at 1 m/s^2, a tenth later with each m/s^2 more, then above 1.8 and 1.8/1.1 times that
    ("gear_changes", SHIFTS, {**DRIVES, "vx": 3.2, "accel": 2.0, "accel_lead": 1.0}, {"gear": 0.0, "left": 0.0},
     {"accel": 1.2, "accel_lead": 1.8}, {"gear": 1.0, "left": 0.35}),  # 3.3 m/s are passed in the middle of the step,
    # which begins with the whole of 3 m/s^2
    ("gear_changes", SHIFTS, {**DRIVES, "vx": 3.09, "accel": 2.0}, {"gear": 0.0, "left": 0.0}, {"accel": 2.0},
     {"gear": 0.0, "left": 0.0}),
    ("gear_changes", SHIFTS, {**DRIVES, "vx": 4.95, "accel": 0.0}, {"gear": 1.0, "left": 0.0}, {"accel": 0.0},
     {"gear": 2.0, "left": 0.3}),  # above 5.4 less a tenth, since the pedal was released
    ("gear_changes", SHIFTS, {**DRIVES, "vx": 8.0, "accel": 0.0}, {"gear": 2.0, "left": 0.0}, {}, {"gear": 3.0}),
    ("gear_changes", SHIFTS, {**DRIVES, "vx": 7.9, "accel": 0.0}, {"gear": 2.0, "left": 0.0}, {}, {"gear": 2.0}),
    ("gear_changes", SHIFTS, {**DRIVES, "vx": 4.0, "accel": 1.0}, {"gear": 1.0, "left": 0.04},
     {"accel": 0.68, "accel_lead": -0.48}, {"gear": 1.0, "left": 0.0}),  # 0.8 of the drive missing for 0.4 of the step,
    # which begins with 0.2
    ("gear_changes", SHIFTS, {**DRIVES, "vx": 4.0, "accel": -1.0}, {"gear": 1.0, "left": 0.4}, {"accel": -1.0},
     {"left": 0.3}),
    ("gear_changes", SHIFTS, {**DRIVES, "vx": 1.75, "accel": 0.0}, {"gear": 1.0, "left": 0.0}, {"accel": 0.0},
     {"gear": 0.0, "left": 0.3}),  # back below 0.65 of 2.7, the change up without demand
    ("gear_changes", SHIFTS, {**DRIVES, "vx": 1.76, "accel": 0.0}, {"gear": 1.0, "left": 0.0}, {"accel": 0.0},
     {"gear": 1.0}),
    ("gear_changes", SHIFTS, {**DRIVES, "vx": 2.14, "accel": 2.0}, {"gear": 1.0, "left": 0.0}, {"accel": 0.4},
     {"gear": 0.0, "left": 0.3}),  # with 2 m/s^2 asked for below 0.65 of 3.3
    ("gear_changes", SHIFTS, {**DRIVES, "vx": 2.15, "accel": 2.0}, {"gear": 1.0, "left": 0.0}, {"accel": 2.0},
     {"gear": 1.0}),
    ("gear_changes", SHIFTS, {**DRIVES, "vx": 9.5, "accel": 0.5, "settle": 1.0}, {"gear": 0.0, "left": 0.0},
     {"accel": 0.5}, {"gear": 3.0, "left": 0.0}),  # a log begins in its gear
    ("gear_changes", SHIFTS, {**DRIVES, "vx": 9.5, "accel": 0.5, "t": 0.0}, {"gear": 0.0, "left": 0.0},
     {"accel": 0.5}, {"gear": 3.0, "left": 0.0}),
)  # fmt: skip


@pytest.mark.parametrize(
    ("name", "p", "bus", "memory", "after", "left"), ROWS, ids=[f"{i}-{row[0]}" for i, row in enumerate(ROWS)]
)
def test_a_step_of_a_gearbox(
    name: str, p: dict[str, Any], bus: dict[str, Any], memory: dict[str, Any], after: dict[str, Any],
    left: dict[str, Any],
) -> None:  # fmt: skip
    x, m = SimpleNamespace(**bus), SimpleNamespace(**memory)
    find_effect(name).function(x, SimpleNamespace(**p), m)
    assert {field: getattr(x, field) for field in after} == pytest.approx(after, rel=1e-12, abs=1e-12)
    assert {field: getattr(m, field) for field in left} == pytest.approx(left, rel=1e-12, abs=1e-12)
