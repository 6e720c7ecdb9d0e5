"""A lateral distance in the coordinates of an entity: steering for a line beside it; from plane geometry.

The turning radius of speed v and lateral acceleration a is 1.5 v^2 / a: an S that is eased at both ends turns 1.5
times as hard at its peak as an even turn.
"""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from openscenario.storyboard.engine import Storyboard

from .conftest import Make, event, log, run, speed, story, teleport

AXIS = math.radians(30.0)  # where the other one heads
V = 8.0


def action(limits: str = "", side: str = "leftToReferencedEntity", *, continuous: bool = True) -> str:
    """3 m beside B."""
    return (
        f'<PrivateAction><LateralAction><LateralDistanceAction entityRef="B" continuous="{str(continuous).lower()}" '
        f'distance="3" freespace="false" displacement="{side}" coordinateSystem="entity">{limits}'
        "</LateralDistanceAction></LateralAction></PrivateAction>"
    )


def accelerating(limit: float) -> str:
    return f'<DynamicConstraints maxAcceleration="{limit}"/>'


def story_of(make: Make, do: str, along: float, across: float, heading: float, *, on_road: bool = False) -> Storyboard:
    """A at `along`, `across` [m] of B's axes, turned by `heading` [rad] against it, both under way."""
    c, s = math.cos(AXIS), math.sin(AXIS)
    x, y = 500.0 + along * c - across * s, along * s + across * c
    return make(
        A=[teleport(f'<WorldPosition x="{x}" y="{y}" h="{AXIS + heading}"/>'), speed(V)],
        B=[teleport(f'<WorldPosition x="500" y="0" h="{AXIS}"/>'), *([] if on_road else [speed(5.0)])],
        stories=story(event("e", do)),
        without_road=not on_road,
    )


def against(board: Storyboard) -> tuple[float, float, float]:
    """A along and across the axes of B [m], and its heading against B's [rad]."""
    a, b = board.entities["A"], board.entities["B"]
    c, s = math.cos(b.h), math.sin(b.h)
    dx, dy = a.x - b.x, a.y - b.y
    return c * dx + s * dy, c * dy - s * dx, math.remainder(a.h - b.h, math.tau)


@pytest.mark.parametrize("on_road", [False, True])
@pytest.mark.parametrize("heading", [0.0, 0.4, -1.0, 2.5])
@pytest.mark.parametrize(("side", "across"), [("leftToReferencedEntity", 3.0), ("rightToReferencedEntity", -3.0)])
def test_it_comes_onto_the_line_and_into_its_direction(
    make: Make, on_road: bool, heading: float, side: str, across: float
) -> None:
    board = story_of(make, action(accelerating(5.0), side), -20.0, 4.0, heading, on_road=on_road)
    run(board, 20.0)
    assert against(board)[1:] == pytest.approx((across, 0.0), abs=0.01)
    assert board.entities["A"].travelled == pytest.approx(V * 20.0)


def test_far_from_the_line_it_turns_to_it_and_goes_straight_there(make: Make) -> None:
    """A quarter turn at 1.5 v / R takes pi / 2 R / (1.5 v) s; then it heads straight across."""
    limit = 12.0
    radius = 1.5 * V**2 / limit
    board = story_of(make, action(accelerating(limit)), 0.0, -97.0, 0.0)
    turning = 0.5 * math.pi * radius / (1.5 * V)
    run(board, round(0.5 * turning, 2))
    assert against(board)[2] == pytest.approx(0.25 * math.pi, abs=1.5 * V * 0.01 / radius)
    run(board, 4.0)
    assert against(board)[2] == pytest.approx(0.5 * math.pi)


def test_it_never_turns_harder_than_one_and_a_half_times_its_radius(make: Make) -> None:
    limit = 6.0
    board = story_of(make, action(accelerating(limit)), 0.0, 40.0, 1.0)
    run(board, 0.0)
    hardest, before = 0.0, against(board)[2]
    for _ in range(1500):
        run(board, 0.01)
        now = against(board)[2]
        hardest, before = max(hardest, abs(math.remainder(now - before, math.tau))), now
    radius = 1.5 * V**2 / limit
    assert hardest == pytest.approx(1.5 * V * 0.01 / radius)
    assert hardest * V / 0.01 == pytest.approx(limit)  # v^2 / R x 1.5 is the limit itself


@pytest.mark.parametrize("on_road", [False, True])
def test_without_limits_it_is_there_at_once(make: Make, on_road: bool) -> None:
    board = story_of(make, action(), -20.0, 4.0, 0.5, on_road=on_road)
    run(board, 0.01)
    assert against(board)[1:] == pytest.approx((3.0, 0.0), abs=1e-6)
    run(board, 1.0)
    assert against(board)[1:] == pytest.approx((3.0, 0.0), abs=1e-6)


def test_a_limit_of_speed_is_that_to_the_side(make: Make) -> None:
    board = story_of(make, action('<DynamicConstraints maxSpeed="2"/>'), 0.0, -7.0, 0.0)
    run(board, 1.0)
    assert against(board)[1:] == pytest.approx((-5.0, math.asin(2.0 / V)), abs=1e-6)


@pytest.mark.parametrize(("across", "wanted"), [(4.0, 3.0), (-4.0, -3.0)])
def test_on_any_side_it_stays_where_it_is(make: Make, across: float, wanted: float) -> None:
    board = story_of(make, action(side="any"), 0.0, across, 0.0)
    run(board, 0.1)
    assert against(board)[1] == pytest.approx(wanted)


def test_not_continuous_it_is_over_on_the_line(make: Make) -> None:
    board = story_of(make, action(accelerating(5.0), continuous=False), -20.0, 4.0, 0.2)
    run(board, 20.0)
    assert [what for _, _, what in log(board, "event")][-1] == "endTransition"
    assert against(board)[1:] == pytest.approx((3.0, 0.0), abs=1e-3)


def test_the_last_step_of_it_takes_its_way_like_any_other(make: Make) -> None:
    """8 m/s, 10 ms: 0.08 m ahead each step, the one in which the action ends too."""
    board = story_of(make, action(accelerating(5.0), continuous=False), -20.0, 4.0, 0.2)
    run(board, 0.0)
    ahead, ends = [against(board)[0]], 0
    while not ends:
        run(board, 0.01)
        ahead.append(against(board)[0])
        ends = sum(what == "endTransition" for _, _, what in log(board, "action"))
        assert len(ahead) < 2000
    run(board, 0.03)
    b = 0.05 if board.entities["B"].speed else 0.0  # how far B drives meanwhile
    assert ahead[-2] - ahead[-3] == pytest.approx(0.08 - b, abs=1e-4)
    assert 0.0 <= ahead[-1] - ahead[-2] + b <= 0.0801


def test_a_limit_of_jerk_is_said_to_be_left_out(make: Make, road: Path) -> None:
    limits = '<DynamicConstraints maxAcceleration="5" maxAccelerationRate="1"/>'
    board = story_of(make, action(limits), -20.0, 4.0, 0.0)
    run(board, 0.1)
    assert any("jerk" in str(each) for each in board.report())


def test_it_may_leave_the_road(make: Make) -> None:
    """Beyond the road's end (x = 1000 m) there is open ground: it goes on as evenly as before."""
    board = make(
        A=[teleport('<WorldPosition x="985" y="-1.75" h="0"/>'), speed(V)],
        B=[teleport('<WorldPosition x="990" y="-1.75" h="0"/>')],
        stories=story(event("e", action(accelerating(5.0), "rightToReferencedEntity"))),
    )
    run(board, 0.0)
    a = board.entities["A"]
    for _ in range(600):
        x, y = a.x, a.y
        run(board, 0.01)
        assert math.hypot(a.x - x, a.y - y) == pytest.approx(V * 0.01, abs=1e-6)
    assert (a.x > 1025.0, a.y) == (True, pytest.approx(-4.75, abs=0.01))
