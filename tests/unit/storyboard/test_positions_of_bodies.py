"""Places beside a trajectory, relative to an object and on the earth, on a road."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import pytest

from openscenario import model
from openscenario.storyboard.entity import Entity
from openscenario.storyboard.positions import _geo, _relative_object, _relative_world, _trajectory
from openscenario.storyboard.unsupported import Unsupported

from .conftest import Make, lane_position, teleport


def test_a_place_beside_a_trajectory_lies_to_the_left_of_its_direction(make: Make) -> None:
    """3 m along x, then 4 m up."""
    board: Any = make(A=[], without_road=True)
    points = (model.WorldPosition(0.0, 0.0), model.WorldPosition(3.0, 0.0), model.WorldPosition(3.0, 4.0))
    shape = model.Polyline(tuple(model.Vertex(point) for point in points))
    trajectory = model.Trajectory("t", False, shape)
    for s, t, x, y, h in ((1.0, 0.5, 1.0, 0.5, 0.0), (5.0, 0.5, 2.5, 2.0, 0.5 * math.pi)):
        for orientation, turn in ((None, 0.0), (model.Orientation(h=0.2, type="relative"), 0.2)):
            position: Any = SimpleNamespace(trajectory=trajectory, s=s, t=t, orientation=orientation)
            found = _trajectory(position, board)()
            assert (found.x, found.y, found.h) == pytest.approx((x, y, h + turn))
            assert found.has_heading
    arc = model.Trajectory("t", False, model.Clothoid(0.0, 0.0, 5.0, model.WorldPosition(1.0, 2.0, h=0.5)))
    found = _trajectory(SimpleNamespace(trajectory=arc, s=2.0, t=1.0, orientation=None), board)()  # type: ignore[arg-type]
    assert (found.x, found.y) == pytest.approx(
        (1.0 + 2.0 * math.cos(0.5) - math.sin(0.5), 2.0 + 2.0 * math.sin(0.5) + math.cos(0.5))
    )


TILTS = [("relative", 0.25, 0.16), ("absolute", 0.15, 0.06), (None, 0.1, 0.1)]  # beside an object at 0.1, 0.1


@pytest.mark.parametrize(("kind", "pitch", "roll"), TILTS)
def test_a_place_of_the_world_beside_an_object_has_the_pitch_and_roll_that_are_given(
    make: Make, kind: Any, pitch: float, roll: float
) -> None:
    board: Any = make(A=[], without_road=True)
    other: Entity = board.entities["A"]
    other.put(10.0, 20.0, 1.0, 0.5)
    other.pitch, other.roll = 0.1, 0.1
    turn = None if kind is None else model.Orientation(h=0.2, p=0.15, r=0.06, type=kind)
    found = _relative_world(SimpleNamespace(entity_ref="A", dx=2.0, dy=1.0, dz=0.5, orientation=turn), board)()  # type: ignore[arg-type]
    assert (found.x, found.y, found.z) == pytest.approx((12.0, 21.0, 1.5))
    assert (found.pitch, found.roll) == pytest.approx((pitch, roll))


@pytest.mark.parametrize(("kind", "pitch"), [each[:2] for each in TILTS])
def test_a_place_beside_a_trajectory_has_the_pitch_and_roll_that_are_given(make: Make, kind: Any, pitch: float) -> None:
    """It falls by tan 0.1, and does not lean."""
    board: Any = make(A=[], without_road=True)
    ends = (model.WorldPosition(0.0, 0.0, z=5.0), model.WorldPosition(10.0, 0.0, z=5.0 - 10.0 * math.tan(0.1)))
    trajectory = model.Trajectory("t", False, model.Polyline(tuple(model.Vertex(point) for point in ends)))
    turn = None if kind is None else model.Orientation(h=0.2, p=0.15, r=0.06, type=kind)
    found = _trajectory(SimpleNamespace(trajectory=trajectory, s=4.0, t=0.0, orientation=turn), board)()  # type: ignore[arg-type]
    assert found.pitch == pytest.approx(pitch)
    assert found.roll == pytest.approx(0.0 if kind is None else 0.06)


@pytest.mark.parametrize(("kind", "h", "p", "r"), [("relative", 0.7, 0.25, 0.16), ("absolute", 0.2, 0.15, 0.06)])
def test_a_place_relative_to_an_object_turns_with_it(make: Make, kind: Any, h: float, p: float, r: float) -> None:
    board: Any = make(A=[], without_road=True)
    other: Entity = board.entities["A"]
    other.put(10.0, 20.0, 1.0, 0.5)
    other.pitch, other.roll = 0.1, 0.1
    turn = model.Orientation(h=0.2, p=0.15, r=0.06, type=kind)
    plain: Any = SimpleNamespace(entity_ref="A", dx=0.0, dy=0.0, dz=0.0, orientation=turn)
    found = _relative_object(plain, board)()
    assert (found.x, found.y, found.z) == pytest.approx((10.0, 20.0, 1.0))
    assert (found.h, found.pitch, found.roll) == pytest.approx((h, p, r))
    other.pitch = other.roll = 0.0
    aside: Any = SimpleNamespace(entity_ref="A", dx=2.0, dy=1.0, dz=0.5, orientation=None)
    found = _relative_object(aside, board)()
    c, s = math.cos(0.5), math.sin(0.5)
    assert (found.x, found.y, found.z) == pytest.approx((10.0 + 2.0 * c - s, 20.0 + 2.0 * s + c, 1.5))
    assert found.h == pytest.approx(0.5)


def geo(**given: Any) -> Any:
    names = ("latitude_deg", "longitude_deg", "latitude", "longitude", "altitude", "height", "orientation")
    return SimpleNamespace(**dict.fromkeys(names) | given)


def test_a_place_on_the_earth_is_the_same_in_degrees_and_radians_and_has_a_height_and_an_orientation(
    make: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        "openscenario.storyboard.positions.projection", lambda reference: lambda lon, lat: (10.0 * lon, 2.0 * lat)
    )
    board: Any = make(A=[teleport(lane_position(10.0))])
    found = _geo(geo(latitude_deg=-0.875, longitude_deg=30.0, altitude=4.0, height=9.0), board)()
    assert (found.x, found.y, found.z) == pytest.approx((300.0, -1.75, 4.0))
    radians = geo(latitude=math.radians(-0.875), longitude=math.radians(30.0), height=9.0)
    found = _geo(radians, board)()
    assert (found.x, found.y, found.z) == pytest.approx((300.0, -1.75, 9.0))
    for kind, pitch, roll in (("absolute", 0.1, 0.05), ("relative", 0.1, 0.05)):  # the road is flat
        turn = model.Orientation(h=0.4, p=0.1, r=0.05, type=kind)
        found = _geo(geo(latitude_deg=0.0, longitude_deg=30.0, orientation=turn), board)()
        assert (found.h, found.pitch, found.roll) == pytest.approx((0.4, pitch, roll))
    for missing in ({"latitude_deg": 1.0}, {"longitude": 1.0}, {"latitude": 1.0}):
        with pytest.raises(Unsupported, match="latitude and longitude"):
            _geo(geo(**missing), board)
    with pytest.raises(Unsupported, match="no road network"):
        _geo(geo(), make(A=[], without_road=True))  # type: ignore[arg-type]
