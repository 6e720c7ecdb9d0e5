"""One step of what a gearbox does to the drive, by hand: see `tests/unit/vehicle/test_effects_by_hand.py`."""

from __future__ import annotations

from math import sqrt, tanh
from types import SimpleNamespace
from typing import Any

import pytest

from vehicle.model.effect_catalogue import find_effect

SHIFTS = {"T": 0.4, "v1": 3.0, "step": 1.8, "demand": 0.1, "cut": 0.8, "fall": 0.0}
FALLS = {**SHIFTS, "T": 0.0, "fall": 0.5}
OIL = {"ratio": 2.0, "stall": 1.5, "J": 0.0, "lock": 10.0, "idle": 0.0}
HEAVY = {**OIL, "ratio": 1.0, "stall": 1.0, "J": 0.1}
DRIVES = {"t": 7.0, "t_start": 0.0, "settle": 0.0, "dt": 0.1, "accel_lead": 0.0}
ROLLS = {"dt": 0.1, "accel_lead": 0.0}
STOOD = {"u": 0.0, "a": 0.0}
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
    # a force that falls with the root of the ratio: 1 in gear 0, 1/sqrt(1.8) in gear 1, 1/sqrt(1.8^2/1.1) in gear 2
    ("gear_changes", FALLS, {**DRIVES, "vx": 1.0, "accel": 2.0, "accel_lead": 1.0}, {"gear": 0.0, "left": 0.0},
     {"accel": 2.0, "accel_lead": 1.0}, {"gear": 0.0}),
    ("gear_changes", FALLS, {**DRIVES, "vx": 4.0, "accel": 2.0, "accel_lead": 1.0}, {"gear": 1.0, "left": 0.0},
     {"accel": 2.0 / sqrt(1.8), "accel_lead": 1.0 / sqrt(1.8)}, {"gear": 1.0}),
    ("gear_changes", FALLS, {**DRIVES, "vx": 7.0, "accel": 1.0}, {"gear": 2.0, "left": 0.0},
     {"accel": sqrt(1.1) / 1.8}, {"gear": 2.0}),
    ("gear_changes", FALLS, {**DRIVES, "vx": 3.2, "accel": 2.0, "accel_lead": 1.0}, {"gear": 0.0, "left": 0.0},
     {"accel": 1.0 + 1.0 / sqrt(1.8), "accel_lead": 2.0 - 1.0 / sqrt(1.8)}, {"gear": 1.0}),  # half a step in each
    ("gear_changes", FALLS, {**DRIVES, "vx": 4.0, "accel": -2.0}, {"gear": 1.0, "left": 0.0}, {"accel": -2.0}, {}),
    # a converter that doubles the torque of a standing car; at 3 m/s the engine turns as if at sqrt(3^2 + 1.5^2 2)
    ("torque_converter", OIL, {**ROLLS, "vx": 0.0, "accel": 2.0}, STOOD, {"accel": 4.0, "accel_lead": 0.0},
     {"u": 1.5 * sqrt(2.0), "a": 4.0}),
    ("torque_converter", OIL, {**ROLLS, "vx": 3.0, "accel": 2.0}, STOOD,
     {"accel": 2.0 * (2.0 - 3.0 / (0.85 * sqrt(13.5))), "accel_lead": 0.0}, {"u": sqrt(13.5)}),
    ("torque_converter", OIL, {**ROLLS, "vx": 8.0, "accel": 1.0}, STOOD, {"accel": 1.0, "accel_lead": 0.0}, {}),
    ("torque_converter", OIL, {**ROLLS, "vx": 0.0, "accel": 2.0, "accel_lead": -1.0}, STOOD,
     {"accel": 4.0, "accel_lead": -2.0}, {}),
    ("torque_converter", OIL, {**ROLLS, "vx": 10.0, "accel": 2.0, "accel_lead": 0.5}, STOOD,
     {"accel": 2.0, "accel_lead": 0.5}, {"u": 10.0, "a": 2.0}),  # bridged
    ("torque_converter", OIL, {**ROLLS, "vx": 9.95, "accel": 2.0}, {"u": 9.95, "a": 2.0}, {"accel": 2.0},
     {"u": 10.05}),  # from the middle of the step on
    ("torque_converter", OIL, {**ROLLS, "vx": 2.0, "accel": -3.0, "accel_lead": 0.5}, STOOD,
     {"accel": -3.0, "accel_lead": 0.5}, {"u": 2.0}),
    # an engine that idles as if at 0.75 m/s pushes with 2 (0.75/1.5)^2 against the brakes, and with less at 0.3 m/s
    ("torque_converter", {**OIL, "idle": 0.75}, {**ROLLS, "vx": 0.0, "accel": -1.0}, STOOD,
     {"accel": -0.5, "accel_lead": 0.0}, {"u": 0.75}),
    ("torque_converter", {**OIL, "idle": 0.75}, {**ROLLS, "vx": 0.3, "accel": 0.0}, STOOD,
     {"accel": (0.75**2 - 0.3**2) / 1.5**2 * (2.0 - 0.3 / (0.85 * 0.75))}, {}),
    ("torque_converter", {**HEAVY, "idle": 0.5}, {**ROLLS, "vx": 0.0, "accel": -1.0}, {"u": 0.5, "a": 0.0},
     {"accel": -0.75, "accel_lead": 0.0}, {"u": 0.5}),
    # an engine of inertia: 0.1 u' = 1 - u^2 is u = tanh(10 t), and 0.1 u' = -u^2 is u = 1/(1 + 10 t)
    ("torque_converter", HEAVY, {**ROLLS, "vx": 0.0, "accel": 1.0}, STOOD,
     {"accel": 1.0 - tanh(1.0), "accel_lead": tanh(1.0) - 1.0}, {"u": tanh(1.0)}),
    ("torque_converter", HEAVY, {**ROLLS, "vx": 0.0, "accel": 0.0}, {"u": 1.0, "a": 0.0},
     {"accel": 0.5, "accel_lead": 0.5}, {"u": 0.5}),
    ("torque_converter", HEAVY, {**ROLLS, "vx": 5.0, "accel": 0.0}, {"u": 1.0, "a": 0.0},
     {"accel": 0.0, "accel_lead": 0.0}, {"u": 5.0}),  # the wheels turn it along
    ("torque_converter", HEAVY, {**ROLLS, "vx": -1.0, "accel": 0.0}, {"u": 0.0, "a": 0.0},
     {"accel": 0.0, "accel_lead": 0.0}, {"u": 0.0}),
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
