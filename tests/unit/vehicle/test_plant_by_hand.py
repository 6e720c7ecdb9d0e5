"""A car made ready to run: where it stands, what it is told, and how many rows there are; the kernel is a stub."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from vehicle.messages import TRACE_COLUMNS, VehicleState
from vehicle.model import plant as module
from vehicle.model.kernel import COMMAND_COLUMNS
from vehicle.model.model_file import parse_model
from vehicle.model.plant import SLIPPERY, Plant
from vehicle.model.wind import DENSITY, DRAG, FRONTAL, SIDE, air_coefficients

CAR = "[parameters]\nwheelbase = 2.5\ncg_to_front_axle = 1.1\nmass = 1000.0\nwidth = 2.0\nheight = 1.5\n"
MODEL = parse_model(CAR)
STATE = VehicleState(t=3.0, x=10.0, y=20.0, yaw=0.5, v=6.0, z=0.25, vy=0.1, yaw_rate=0.2, ax=0.7, ay=0.8, steer=0.05)


def test_a_new_car_stands_at_the_origin_at_time_nought() -> None:
    car = Plant(MODEL)
    assert car.row().tolist() == [0.0] * len(TRACE_COLUMNS)
    assert (car.time, car.until_row, car.dt, car.every) == (0.0, 10, 1e-3, 10)
    assert car._command.tolist() == [[0.0] * len(COMMAND_COLUMNS)]
    assert Plant(MODEL, every=7).until_row == 7


def test_a_car_is_put_where_a_state_says_with_its_sideways_speed_at_the_rear_axle() -> None:
    """The centre of gravity is 1.4 m ahead of the rear axle: 0.1 + 1.4 x 0.2 m/s sideways."""
    car = Plant(MODEL)
    car.reset(STATE)
    bus = car._bus[0]
    assert float(bus["vy"]) == pytest.approx(0.38)
    told = {"t_start": 3.0, "dt": 1e-3, "steer_cmd": 0.05, "vy_rear": 0.1}
    assert {name: float(bus[name]) for name in told} == told
    row = dict(zip(TRACE_COLUMNS, car.row().tolist(), strict=True))
    assert row == {"t": 3.0, "x": 10.0, "y": 20.0, "z": 0.25, "yaw": 0.5, "v": 6.0, "vx": 6.0, "vy": 0.1,
                   "yaw_rate": 0.2, "ax": 0.7, "ay": 0.8, "steer": 0.05}  # fmt: skip
    again = car.state
    assert (again.t, again.z, again.v, again.vx, again.vy) == (3.0, 0.25, 6.0, 6.0, 0.1)
    assert (again.yaw_rate, again.ax, again.ay, again.steer) == (0.2, 0.7, 0.8, 0.05)
    assert car._command[0].tolist() == [0.05, 0.0, 0.0, 0.0, 0.0, 6.0]
    assert car.time == 3.0


def test_a_reset_forgets_the_ground_the_wind_and_what_was_commanded() -> None:
    car = Plant(MODEL)
    car.command(0.1, 1.0, 0.2, 0.3, 4.0)
    car.road(2.0, 0.1, -0.2)
    car.wind(5.0, -3.0)
    car.friction(0.4)
    car.reset(VehicleState(t=0.0, x=0.0, y=0.0, yaw=0.0, v=0.0))
    bus = car._bus[0]
    assert car._command.tolist() == [[0.0] * 6]
    for name in ("z", "road_grade", "road_bank", "wind_x", "wind_y", "road_friction"):
        assert float(bus[name]) == 0.0, name


def test_memories_begin_empty_or_with_what_they_remember() -> None:
    car = Plant(MODEL)
    layout: Any = SimpleNamespace(starts=[(2, 3, "steer"), (7, 1, "x")])
    car._layout, car._memory = layout, np.full(10, 9.0)
    car.reset(STATE)
    assert car._memory.tolist() == [0.0, 0.0, 0.05, 0.05, 0.05, 0.0, 0.0, 10.0, 0.0, 0.0]


@pytest.mark.parametrize(
    ("z", "grade", "bank", "told"), [(1.0, 0.1, -0.2, (1.0, 0.1, -0.2)), (2.0, None, None, (2.0, 0.0, 0.0))]
)
def test_the_ground_under_a_car(z: float, grade: Any, bank: Any, told: tuple[float, ...]) -> None:
    car = Plant(MODEL)
    car.road(z) if grade is None else car.road(z, grade, bank)
    assert tuple(float(car._bus[0][name]) for name in ("z", "road_grade", "road_bank")) == told


@pytest.mark.parametrize(("friction", "told"), [(None, 0.0), (0.8, 0.8), (0.0, SLIPPERY), (5e-4, 1e-3), (2e-3, 2e-3)])
def test_a_road_has_a_thousandth_of_friction_at_least_and_none_means_enough(friction: Any, told: float) -> None:
    car = Plant(MODEL)
    car.friction(friction)
    assert float(car._bus[0]["road_friction"]) == told


def test_the_wind_takes_hold_of_the_front_and_of_the_side() -> None:
    """Half of the density times 0.81 x 2.0 x 1.5 m^2, over 1000 kg."""
    along, across = air_coefficients(MODEL)
    pressure = 0.5 * 1.225 * 0.81 * 3.0 / 1000.0
    assert (DENSITY, FRONTAL, DRAG, SIDE) == (1.225, 0.81, 0.3, 2.2)
    assert (along, across) == pytest.approx((0.3 * pressure, 2.2 * pressure))
    dragged = MODEL.with_effect("aero_drag", {"k": 5e-4})
    assert air_coefficients(dragged) == pytest.approx((5e-4, 2.2 * pressure))
    car = Plant(MODEL)
    car.wind(5.0, -3.0)
    bus = car._bus[0]
    assert (float(bus["wind_x"]), float(bus["wind_y"])) == (5.0, -3.0)
    assert (float(bus["wind_drag"]), float(bus["wind_side"])) == pytest.approx((along, across))


def test_a_sensor_shows_its_own_numbers_of_what_it_measures_and_the_true_rest() -> None:
    car = Plant(MODEL)
    car.reset(STATE)
    shown = {"meas_x": 1.0, "meas_y": 2.0, "meas_yaw": 3.0, "meas_v": 4.0, "meas_yaw_rate": 5.0, "meas_ax": 6.0,
             "meas_ay": 7.0}  # fmt: skip
    for name, value in shown.items():
        car._bus[name] = value
    row = dict(zip(TRACE_COLUMNS, car.shown_row().tolist(), strict=True))
    assert row == {"t": 3.0, "x": 1.0, "y": 2.0, "z": 0.25, "yaw": 3.0, "v": 4.0, "vx": 4.0, "vy": 0.1,
                   "yaw_rate": 5.0, "ax": 6.0, "ay": 7.0, "steer": 0.05}  # fmt: skip


# --- rows


class Kernel:
    """Notes what it is asked for and fills a row each `every` steps with its number."""

    def __init__(self) -> None:
        self.asked: list[tuple[Any, int, int, bool, int]] = []

    def __call__(self, *given: Any) -> int:
        *_, commands, hold, every, measured, trace = given
        self.asked.append((commands.copy(), hold, every, measured, len(trace)))
        rows: int = len(commands) * hold // every
        for k in range(rows):
            trace[k] = k
        return rows


@pytest.fixture
def kernel(monkeypatch: pytest.MonkeyPatch) -> Kernel:
    stub = Kernel()
    monkeypatch.setattr(module, "run", stub)
    return stub


@pytest.mark.parametrize(("steps", "room"), [(10, 64), (629, 64), (630, 64), (639, 64), (640, 65), (1000, 101)])
def test_there_is_room_for_a_row_each_ten_steps_and_one_more(kernel: Kernel, steps: int, room: int) -> None:
    car = Plant(MODEL)
    car.command(0.1, 1.0, 0.2, 0.3, 4.0)
    rows = car.advance(steps)
    commands, hold, every, measured, length = kernel.asked[0]
    assert commands.tolist() == [[0.1, 1.0, 0.2, 0.3, 4.0, 0.0]]
    assert (hold, every, measured, length) == (steps, 10, False, room)
    assert rows[:, 0].tolist() == list(range(steps // 10))
    assert rows.shape == (steps // 10, 12)
    car._trace[:] = -1.0  # what was returned is the caller's own
    assert (rows >= 0.0).all()


@pytest.mark.parametrize(("rows", "hold", "room"), [(3, 20, 7), (4, 5, 3), (1, 9, 1)])
@pytest.mark.parametrize("measured", [False, True])
def test_a_drive_holds_each_row_of_commands(kernel: Kernel, rows: int, hold: int, room: int, measured: bool) -> None:
    commands = np.arange(6.0 * rows).reshape(rows, 6)
    found = Plant(MODEL).drive(commands, hold, measured=measured)
    asked, held, every, shown, length = kernel.asked[0]
    assert (asked == commands).all()
    assert (held, every, shown, length) == (hold, 10, measured, room)
    assert len(found) == rows * hold // 10


@pytest.mark.parametrize(("count", "left"), [(0, 10), (1, 9), (9, 1), (10, 10), (25, 5)])
def test_a_row_comes_each_ten_steps(count: int, left: int) -> None:
    car = Plant(MODEL)
    car._bus["count"] = count
    assert car.until_row == left


def test_effects_that_do_nothing_are_left_out_unless_they_are_to_be_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    def layout(effects: Any) -> Any:
        names = [effect.name for effect in effects]
        return SimpleNamespace(names=names, starts=(), memory_size=3, parameters=lambda given: given)

    monkeypatch.setattr(module, "Layout", layout)
    monkeypatch.setattr(module, "body_kind", lambda model, switching: switching.names)
    idle = MODEL.with_effect("steer_ratio", {"g": 1.0}).with_effect("drive_gain", {"g": 0.9})
    car: Any = Plant(idle)
    assert car._layout.names == car._kind == ["drive_gain"]
    assert car._parameters == {"drive_gain": {"g": 0.9}}
    assert car._memory.tolist() == [0.0, 0.0, 0.0]
    kept: Any = Plant(idle, keep_neutral=True)
    assert kept._layout.names == ["steer_ratio", "drive_gain"]
    assert kept._kind == ["drive_gain"]  # what does nothing needs no tyres
