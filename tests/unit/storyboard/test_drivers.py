"""Others with a controller that reacts to traffic follow by the intelligent driver model and keep their lane."""

from __future__ import annotations

import math

import pytest

from openscenario.interactive import is_interactive
from openscenario.model import Controller, Properties, Property
from openscenario.model.kinds import At

from .conftest import Make, event, lane_position, run, speed, story, teleport

AT = At("x.xosc", 1, "Controller")


def controller(name: str, set_speed: float | None = 20.0, time_gap: float | None = None, **on: bool) -> str:
    properties = "" if set_speed is None else f'<Property name="setSpeed" value="{set_speed}"/>'
    properties += "" if time_gap is None else f'<Property name="timeGap" value="{time_gap}"/>'
    active = " ".join(f'activate{domain.title()}="{str(each).lower()}"' for domain, each in on.items())
    return (
        f"<PrivateAction><ControllerAction><AssignControllerAction {active}>"
        f'<Controller name="{name}"><Properties>{properties}</Properties></Controller>'
        "</AssignControllerAction></ControllerAction></PrivateAction>"
    )


@pytest.mark.parametrize(("pace", "time_gap"), [(10.0, None), (15.0, None), (15.0, 1.0)])
def test_it_follows_at_the_gap_of_the_model(make: Make, pace: float, time_gap: float | None) -> None:
    """Where nobody accelerates, s = (s0 + v T) / sqrt(1 - (v / v0)^4): Treiber et al. 2000, eq. 5.

    The bodies reach from 1 m behind to 4 m ahead of their reference points.
    """
    acc = controller("ACCController", 20.0, time_gap, longitudinal=True)
    board = make(A=[teleport(lane_position(50.0)), speed(pace), acc], B=[teleport(lane_position(90.0)), speed(pace)])
    run(board, 50.0 if pace < 12.0 else 40.0, dt=0.05)
    a, b = board.entities["A"], board.entities["B"]
    gap = (2.0 + (time_gap or 1.5) * pace) / math.sqrt(1.0 - (pace / 20.0) ** 4)
    assert a.speed == pytest.approx(pace, abs=0.02)
    assert b.x - a.x - 5.0 == pytest.approx(gap, rel=0.01)


def test_it_starts_with_the_acceleration_of_the_model_on_a_free_road(make: Make) -> None:
    """a (1 - (v / v0)^4) with a = 1.5 m/s^2: at 10 of 20 m/s 1.406 m/s^2."""
    board = make(A=[teleport(lane_position(50.0)), speed(10.0), controller("interactiveDriver", longitudinal=True)])
    run(board, 0.1)
    assert board.entities["A"].speed == pytest.approx(10.0 + 0.1 * 1.5 * (1.0 - 0.5**4), abs=1e-3)


def test_it_stops_behind_who_stands(make: Make) -> None:
    """With s0 = 2 m between the bodies."""
    a = [teleport(lane_position(50.0)), speed(15.0), controller("ACC", 15.0, longitudinal=True)]
    board = make(A=a, B=[teleport(lane_position(200.0))])
    run(board, 60.0, dt=0.05)
    assert board.entities["A"].speed == pytest.approx(0.0, abs=0.1)
    assert board.entities["B"].x - board.entities["A"].x - 5.0 == pytest.approx(2.0, abs=0.5)


@pytest.mark.parametrize(
    ("name", "options"),
    [("ACCController", {}), ("DefaultDriver", {"longitudinal": True}), ("ACCController", {"longitudinal": False})],
)
def test_without_activation_or_with_another_controller_it_is_the_default_one(
    make: Make, name: str, options: dict[str, bool]
) -> None:
    board = make(A=[teleport(lane_position(50.0)), speed(10.0), controller(name, **options)])
    run(board, 2.0)
    assert board.entities["A"].speed == 10.0


def test_the_vehicle_under_test_has_none(make: Make) -> None:
    board = make(Ego=[teleport(lane_position(50.0)), speed(10.0), controller("ACCController", longitudinal=True)])
    run(board, 2.0)
    assert board.entities["Ego"].speed == 10.0


@pytest.mark.parametrize("offset", [0.8, -0.8, 0.3])
def test_lane_keeping_goes_back_to_the_middle_with_a_time_constant_of_two_seconds(make: Make, offset: float) -> None:
    start = [teleport(lane_position(50.0, offset=offset)), speed(20.0), controller("lane keeping", lateral=True)]
    board = make(A=start)
    run(board, 2.0)
    assert board.entities["A"].offset == pytest.approx(offset * math.exp(-1.0), rel=0.02)
    assert board.entities["A"].speed == 20.0


def test_an_action_takes_over_while_it_runs(make: Make) -> None:
    start = [teleport(lane_position(50.0)), speed(10.0), controller("ACCController", longitudinal=True)]
    board = make(A=start, stories=story(event("brake", speed(5.0, "linear", "time", 2.0))))
    run(board, 2.0)
    assert board.entities["A"].speed == pytest.approx(5.0, abs=0.05)
    run(board, 1.0)
    assert board.entities["A"].speed > 6.3


@pytest.mark.parametrize(
    ("name", "properties", "reacts"),
    [
        ("ACCController", {}, True),
        ("acc", {}, True),
        ("accelerate", {}, False),
        ("npc", {"module": "npc_vehicle_control"}, True),
        ("driver", {"esminiController": "InteractiveController"}, True),
        ("HeroAgent", {"module": "external_control"}, False),
        ("ALKSController", {}, False),
    ],
)
def test_which_controllers_react_to_traffic(name: str, properties: dict[str, str], reacts: bool) -> None:
    listed = tuple(Property(key, value, at=AT) for key, value in properties.items())
    assert is_interactive(Controller(name, properties=Properties(listed, at=AT), at=AT)) is reacts
