"""The ground of a planned drive, its files, and the robot that plays it: numbers and lines by hand."""

from __future__ import annotations

import math
import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.manoeuvres import circle_manoeuvres
from pytest_dvp.gap.manoeuvres.discrimination import Evidence, _least, _tied
from pytest_dvp.gap.manoeuvres.driving_limits import Area, Envelope
from pytest_dvp.gap.manoeuvres.limit_violations import violations
from pytest_dvp.gap.manoeuvres.plan_folder import _commands
from pytest_dvp.gap.manoeuvres.trajectory_scenario import _after, road, scenario
from vehicle.model.car import make_car
from vehicle.model.model_file import parse_model

# --- the ground

GROUND = Area(-10.0, 90.0, -20.0, 40.0)


def test_what_is_asked_for_where_nothing_is_said() -> None:
    plain = Envelope()
    assert (plain.max_speed, plain.max_acceleration, plain.max_deceleration, plain.max_lateral) == (12.5, 2.0, 4.0, 4.0)
    assert (plain.length, plain.width, plain.max_steer, plain.steer_rate) == (100.0, 60.0, 0.45, 1.0)


@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf])
def test_a_limit_is_a_number_above_nought(value: float) -> None:
    with pytest.raises(ValueError, match=r"envelope: max_lateral is .*, expected more than 0"):
        Envelope(max_lateral=value)
    assert Envelope(max_lateral=1e-9).max_lateral == 1e-9


@pytest.mark.parametrize(
    ("x", "y", "yaw", "room"),
    [
        (0.0, 0.0, 0.0, 90.0),
        (0.0, 0.0, math.pi, 10.0),
        (0.0, 0.0, 0.5 * math.pi, 40.0),
        (0.0, 0.0, -0.5 * math.pi, 20.0),
        (60.0, 0.0, math.atan2(4.0, 3.0), 50.0),  # 40 m to the side by 4/5, 30 m along by 3/5
        (0.0, 0.0, math.atan2(-3.0, -4.0), 12.5),
        (95.0, 0.0, 0.0, -5.0),  # outside
        (0.0, 43.0, 1.0, -3.0),
        (-12.0, 0.0, 1.0, -2.0),
        (0.0, -21.0, 1.0, -1.0),
        (90.0, 0.0, 0.0, 0.0),
    ],
)
def test_the_way_straight_on_to_the_border(x: float, y: float, yaw: float, room: float) -> None:
    assert GROUND.room(x, y, yaw) == pytest.approx(room)


def test_a_strip_is_left_at_ends_and_sides() -> None:
    assert GROUND.inset(3.0, 5.0) == (-7.0, 87.0, -15.0, 35.0)


@pytest.mark.parametrize(
    ("area", "lanes"),
    [
        (GROUND, [(1, 38.25), (-1, 3.5), (-2, 18.25)]),  # less half of the lane of 3.5 m on either side
        (Area(-10.0, 90.0, -1.75, 40.0), [(1, 38.25), (-1, 3.5)]),
        (Area(-10.0, 90.0, -20.0, 1.84), [(-1, 3.5), (-2, 18.25)]),
        (Area(-10.0, 90.0, -1.86, 1.86), [(1, 0.11), (-1, 3.5), (-2, 0.11)]),
    ],
)
def test_lanes_fill_the_ground_about_that_of_the_start(area: Area, lanes: list[tuple[int, float]]) -> None:
    text = road(area)
    found = re.findall(r'<lane id="(-?\d+)" type="driving".*?a="([\d.]+)"', text)
    assert [(int(number), float(width)) for number, width in found] == lanes
    assert 'geometry s="0" x="-10.000" y="1.750" hdg="0" length="100.000"' in text
    assert f'north="{area.y_max:.3f}" south="{area.y_min:.3f}" east="90.000" west="-10.000"' in text


def drive(rows: int) -> Any:
    t = 0.02 * np.arange(float(rows))
    motion = np.column_stack([t, 2.0 * t, 3.0 * t, 4.0 * t, 0.0 * t, 0.0 * t, 0.0 * t])
    wishes = np.column_stack([5.0 * t, 6.0 * t, 7.0 * t])
    return SimpleNamespace(t=t, motion=motion, seconds=float(t[-1]), wishes=wishes,
                           manoeuvre=SimpleNamespace(title="A <test>"))  # fmt: skip


@pytest.mark.parametrize(("rows", "times"), [(11, ["0.00", "0.10", "0.20"]), (13, ["0.00", "0.10", "0.20", "0.24"]),
                                             (2, ["0.00", "0.02"])])  # fmt: skip
def test_a_path_has_a_vertex_each_tenth_of_a_second_and_at_its_end(rows: int, times: list[str]) -> None:
    car = make_car({"wheelbase": 2.5, "mass": 900.0, "height": 1.4, "wheel_radius": 0.3, "center_x": 1.2})
    text = scenario(drive(rows), car, Envelope(max_steer=0.4), "a.xodr", "says")
    assert re.findall(r'<Vertex time="([\d.]+)"', text) == times
    last = 0.02 * (rows - 1)
    assert f'x="{last:.4f}" y="{2.0 * last:.4f}" h="{3.0 * last:.5f}"' in text
    assert '<Center x="1.2" y="0" z="0.7"/><Dimensions width="1.8" length="4" height="1.4"/>' in text
    assert 'wheelDiameter="0.6" trackWidth="1.5" positionZ="0.3"' in text
    assert 'maxSpeed="12.5" maxAcceleration="2" maxDeceleration="4"' in text
    assert 'maxSteering="0.4"' in text
    assert (
        f'name="End" delay="0" conditionEdge="none"><ByValueCondition><SimulationTimeCondition value="{last + 1.0:g}"'
        in (text)
    )
    assert 'Story name="A &lt;test&gt;"' in text
    begins = re.findall(r'name="(\w+)" delay="0" conditionEdge="none"><ByValueCondition><Simulat\w+ value="0"', text)
    assert begins == ["AtOnce", "Begin"]
    assert 'value="2.5" rule="greaterOrEqual"' in _after("x", 2.5)


def test_commands_are_told_in_the_model_s_inputs_plainly_and_with_what_should_come_of_them() -> None:
    model = parse_model("[parameters]\nwheelbase = 2.5\n")
    one = drive(3)
    rows = _commands(SimpleNamespace(drive=one), model).splitlines()  # type: ignore[arg-type]
    header = rows[0].split(",")
    wanted = ["wanted_accel [m/s^2]", "wanted_steer [rad]", "wanted_speed [m/s]"]
    planned = ["planned_x [m]", "planned_y [m]", "planned_yaw [rad]", "planned_v [m/s]"]
    assert header[-7:] == [*wanted, *planned]
    assert {"t [s]", "steer_cmd [rad]", "accel_cmd [m/s^2]"} <= set(header)
    assert [float(cell) for cell in rows[3].split(",")[-7:]] == pytest.approx([0.2, 0.24, 0.28, 0.04, 0.08, 0.12, 0.16])


# --- what a drive exceeded


def driven(**changes: Any) -> tuple[str, ...]:
    """20 rows of 0.02 s at 5 m/s along x, the car standing 1.2 m ahead of its rear axle, 4 m by 1.8 m."""
    t = 0.02 * np.arange(20.0)
    base: dict[str, Any] = {"x": 5.0 * t, "y": 0.0 * t, "yaw": 0.0 * t, "v": np.full(20, 5.0), "rate": 0.0 * t,
                            "steer": 0.0 * t}  # fmt: skip
    base |= changes
    motion = np.column_stack([base[name] for name in ("x", "y", "yaw", "v", "rate")])
    car = make_car({"wheelbase": 2.5, "center_x": 1.2, "length": 4.0, "width": 1.8})
    area = Area(-1.0, 5.5, -1.0, 1.0)
    return violations(t, motion, base["steer"], Envelope(length=6.5, width=2.0, max_speed=6.0), area, car)


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({}, ()),
        ({"v": np.full(20, 6.0)}, ()),
        ({"v": np.full(20, 6.01)}, ("speed 6.01, at most 6 m/s",)),
        ({"v": np.full(20, -6.01)}, ("speed 6.01, at most 6 m/s",)),
        ({"v": 2.0 + 0.0402 * np.arange(20.0)}, ("acceleration 2.01, at most 2 m/s^2",)),  # 5 * 0.0402 / 0.1 s
        ({"v": 5.0 - 0.081 * np.arange(20.0)}, ("deceleration 4.05, at most 4 m/s^2",)),
        ({"rate": np.full(20, -0.81)}, ("lateral acceleration 4.05, at most 4 m/s^2",)),
        ({"steer": np.full(20, -0.46)}, ("steering 0.46, at most 0.45 rad",)),
        ({"y": np.full(20, 0.11)}, ("the area of 6.5 x 2 m, by 0.01 m",)),  # 0.9 m to its side
        ({"y": np.full(20, -0.11)}, ("the area of 6.5 x 2 m, by 0.01 m",)),
        ({"x": np.full(20, -0.25)}, ("the area of 6.5 x 2 m, by 0.05 m",)),  # its rear is 0.8 m behind
        ({"x": np.full(20, 2.35)}, ("the area of 6.5 x 2 m, by 0.05 m",)),  # its front 3.2 m ahead
        ({"v": np.full(20, math.nan)},
         ("speed nan, at most 6 m/s", "acceleration nan, at most 2 m/s^2", "deceleration nan, at most 4 m/s^2",
          "lateral acceleration nan, at most 4 m/s^2")),
    ],
)  # fmt: skip
def test_what_a_drive_exceeded_is_told(changes: Any, told: tuple[str, ...]) -> None:
    assert driven(**changes) == told


# --- circles


class Asked:
    """A driver that writes down what it is asked for. Lateral 4 m/s^2, wheelbase 2.5 m, turns within 6 m."""

    area, radius, wheelbase, lateral, top, slow, lock = GROUND, 6.0, 2.5, 4.0, 9.0, 2.0, 0.5

    def __init__(self, **changes: Any) -> None:
        self.asked: list[tuple[str, Any]] = []
        for name, value in changes.items():
            setattr(self, name, value)

    def __getattr__(self, name: str) -> Any:
        def write(*args: Any, **more: Any) -> Any:
            self.asked.append((name, (*args, *more.items())))
            return iter(())

        return write


def test_left_circles_are_as_wide_as_the_ground_and_grow_in_speed() -> None:
    """Half of 60 m less 1.6 times the 20 m to the right would be negative: as tight as it turns, 6 m."""
    for area, radius in ((GROUND, 6.0), (Area(-10.0, 90.0, -5.0, 55.0), 22.0)):
        driver: Any = Asked(area=area)
        list(circle_manoeuvres.circles_left(driver))
        assert [name for name, _ in driver.asked] == ["stand", *["circle"] * 4, "halt"]
        speeds = [min(math.sqrt(share * 4.0 * radius), 9.0) for share in (0.08, 0.3, 0.6, 0.9)]
        assert [args[0] for name, args in driver.asked if name == "circle"] == pytest.approx(speeds)
        assert all(args[1] == pytest.approx(math.atan(2.5 / radius)) and args[2] == ("seconds", 7.0)
                   for name, args in driver.asked if name == "circle")  # fmt: skip


def test_circles_to_both_sides_turn_about_between_them() -> None:
    """Of 60 m, 12 for the turn and 15 for three strips of 5 m leave 33: 16.5 m."""
    driver: Any = Asked(area=Area(-10.0, 90.0, -5.0, 55.0))
    list(circle_manoeuvres.circles_both(driver))
    assert [name for name, _ in driver.asked] == [
        "stand", *["circle"] * 4, "close_circle", "other_side", *["circle"] * 4, "halt",
    ]  # fmt: skip
    angles = [args[1] for name, args in driver.asked if name == "circle"]
    angle = math.atan(2.5 / 16.5)
    assert angles == pytest.approx([angle] * 4 + [-angle] * 4)


def test_tight_circles_are_at_walking_pace_to_both_sides() -> None:
    driver: Any = Asked()
    list(circle_manoeuvres.tight_circles(driver))
    radius = 1.1 * 2.5 / math.tan(0.45)
    circles = [args for name, args in driver.asked if name == "circle"]
    assert [args[0] for args in circles] == [2.0, 2.0]
    assert [args[1] for args in circles] == pytest.approx([math.atan(2.5 / radius), -math.atan(2.5 / radius)])
    slow: Any = Asked(lateral=0.5)
    list(circle_manoeuvres.tight_circles(slow))
    assert next(args[0] for name, args in slow.asked if name == "circle") == pytest.approx(math.sqrt(0.35 * radius))


# --- what logs say beside a drive


@pytest.mark.parametrize(
    ("samples", "left", "gap", "count", "repeats", "joint"),
    [
        (0, {}, 0.2, 100, 1, 0.2),
        (100, {}, 0.2, 100, 1, 0.1),
        (100, {}, 0.2, 100, 3, 0.15),
        (100, {"a": 10.0, "b": 30.0}, 0.2, 100, 1, 0.2),
        (100, {"a": 30.0, "b": 10.0}, 0.2, 100, 1, 0.1),  # what fits better is no gap
        (100, {"b": 20.0}, 0.0, 100, 1, 0.1),
        (0, {}, 0.2, 0, 1, 0.0),
    ],
)
def test_a_gap_of_logs_and_a_drive_together(
    samples: int, left: dict[str, float], gap: float, count: int, repeats: int, joint: float
) -> None:
    assert Evidence(samples, left).joint("a", "b", gap, count, repeats) == pytest.approx(joint)


def test_pairs_that_no_manoeuvre_tells_apart_do_not_count_unless_they_were_asked_about() -> None:
    one = {("a", "b"): 0.04, ("a", "c"): 0.049, ("a", "d"): 0.2}
    other = {("a", "b"): 0.01, ("a", "c"): 0.02, ("a", "d"): 0.01}
    tied = _tied({"a", "b"}, [one, other])
    assert tied == {("a", "c")}
    assert _least(one, tied) == 0.04
    assert _tied({"a", "b"}, [one, {**other, ("a", "c"): 0.05}]) == set()


def test_a_file_of_commands_is_played_by_its_clock(tmp_path: Path) -> None:
    from pytest_dvp.gap.manoeuvres.steering_robot import CommandPlayer

    file = tmp_path / "c.csv"
    file.write_text("t [s],wanted_accel [m/s^2],wanted_steer [rad]\n0,1,0.1\n0.5,-2,0.2\n1,-9,0.3\n")
    car: Any = SimpleNamespace(max_acceleration=4.0, max_deceleration=8.0)
    player = CommandPlayer(file, car)
    found = [player.tick(SimpleNamespace(t=t)) for t in (-1.0, 0.0, 0.45, 0.5, 9.0)]  # type: ignore[arg-type]
    assert [c.steer for c in found] == pytest.approx([0.1, 0.1, 0.1, 0.2, 0.3])
    assert [(c.throttle, c.brake) for c in found[2:]] == [
        pytest.approx(pedals) for pedals in ((0.25, 0.0), (0.0, 0.25), (0.0, 1.0))
    ]


def test_a_command_of_a_robot_is_the_mean_of_the_rows_of_its_tick(tmp_path: Path) -> None:
    """Rows each 0.02 s and a tick of 0.05 s: two rows and a half; so the sum over time is that of the plan."""
    from pytest_dvp.drive.loop import RATE
    from pytest_dvp.gap.manoeuvres.steering_robot import CommandPlayer
    from vehicle.messages import TICK

    file = tmp_path / "c.csv"
    rng = np.random.default_rng(1)
    steer = rng.uniform(-0.3, 0.3, 50)
    rows = "".join(f"{0.02 * k:.6g},{10.0 * one:.6g},{one:.6g}\n" for k, one in enumerate(steer))
    file.write_text("t [s],wanted_accel [m/s^2],wanted_steer [rad]\n" + rows)
    player = CommandPlayer(file, SimpleNamespace(max_acceleration=4.0, max_deceleration=8.0))  # type: ignore[arg-type]
    asked = [player.tick(SimpleNamespace(t=k / RATE)) for k in range(20)]  # type: ignore[arg-type]
    assert asked[0].steer == pytest.approx((steer[0] + steer[1] + 0.5 * steer[2]) / 2.5, abs=1e-5)
    assert asked[1].steer == pytest.approx((0.5 * steer[2] + steer[3] + steer[4]) / 2.5, abs=1e-5)
    assert sum(c.steer for c in asked) * TICK == pytest.approx(steer.sum() * 0.02, abs=1e-5)
    assert sum(c.accel for c in asked) * TICK == pytest.approx(10.0 * steer.sum() * 0.02, abs=1e-4)
