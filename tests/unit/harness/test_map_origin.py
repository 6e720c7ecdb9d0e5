"""Where the map of a road file lies: from its geoReference, against PROJ, an independent implementation."""

from __future__ import annotations

import builtins
import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from openscenario.road.network import RoadNetwork, load_network
from pytest_dvp.drive import open_car
from pytest_dvp.drive.announced_cars import Adapter
from pytest_dvp.drive.guarded_car import guarded_car
from pytest_dvp.drive.map_origin import map_origin
from pytest_dvp.drive.run_spec import RunSpec
from vehicle.wire.geodetic import Origin, to_geodetic, to_map

ROAD = Path(__file__).parents[3] / "scenarios" / "hill.xodr"
TMERC = "+proj=tmerc +lat_0=48.137 +lon_0=11.575 +k=1 +x_0=0 +y_0=0 +ellps=WGS84 +units=m +no_defs"
SHIFTED = "+proj=tmerc +lat_0=48.137 +lon_0=11.575 +k_0=1 +x_0=500 +y_0=-200 +datum=WGS84"
UTM = "+proj=utm +zone=32 +datum=WGS84 +units=m +no_defs"
IN_MUNICH = '<offset x="691000" y="5335000" z="0" hdg="0"/>'  # UTM 32
AT_THE_EDGE = '<offset x="780000" y="5340000" z="0" hdg="0.3"/>'  # 280 km east of the middle of the zone


def roads(tmp_path: Path, reference: str, offset: str = "") -> RoadNetwork:
    """The street of hill.xodr, 180 m to the east, somewhere else."""
    text = ROAD.read_text().replace(
        'west="0" />', f'west="0"><geoReference>{reference}</geoReference>{offset}</header>'
    )
    path = tmp_path / "there.xodr"
    path.write_text(text)
    return load_network(path)


def error(origin: Origin, reference: str, x: float, y: float) -> float:
    """Distance [m] between x, y of the projection and where a receiver's latitude and longitude come out."""
    pyproj = pytest.importorskip("pyproj")
    back = pyproj.Transformer.from_crs(pyproj.CRS.from_user_input(reference), 4326, always_xy=True)
    longitude, latitude = back.transform(x, y)
    found = to_map(latitude, longitude, 520.0, origin)
    return math.dist(found[:2], (x, y))


@pytest.mark.parametrize(("reference", "x", "y"), [(TMERC, 0.0, 0.0), (SHIFTED, 500.0, -200.0)])
def test_a_plane_at_its_own_origin_is_read_without_pyproj(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, reference: str, x: float, y: float
) -> None:
    network = roads(tmp_path, reference)
    without_pyproj(monkeypatch)
    assert map_origin(network) == (Origin(48.137, 11.575, None, x, y), "")


@pytest.mark.parametrize(("away", "allowed"), [(0.0, 1e-6), (1000.0, 1e-4), (10_000.0, 0.02)])
@pytest.mark.parametrize("reference", [TMERC, SHIFTED])
def test_a_fix_comes_out_where_the_projection_has_it(
    tmp_path: Path, reference: str, away: float, allowed: float
) -> None:
    origin, _ = map_origin(roads(tmp_path, reference))
    assert origin is not None
    for x, y in ((origin.x + away, origin.y), (origin.x, origin.y - away)):
        assert error(origin, reference, x, y) <= allowed


@pytest.mark.parametrize(
    ("reference", "offset", "x", "y", "near", "far"),
    [
        (UTM, IN_MUNICH, 691_000.0, 5_335_000.0, 0.003, 0.25),
        (UTM, AT_THE_EDGE, 780_000.0, 5_340_000.0, 0.004, 0.4),
        ("EPSG:25832", IN_MUNICH, 691_000.0, 5_335_000.0, 0.003, 0.25),
        (TMERC, '<offset x="30000" y="0" z="0" hdg="0"/>', 30_000.0, 0.0, 0.001, 0.05),
    ],
)
def test_all_else_is_read_by_pyproj_with_grid_north_and_scale(
    tmp_path: Path, reference: str, offset: str, x: float, y: float, near: float, far: float
) -> None:
    """A kilometre and ten kilometres from the roads; without the turn of the grid it would be 31 m off at 1 km."""
    pytest.importorskip("pyproj")
    origin, why_not = map_origin(roads(tmp_path, reference, offset))
    assert origin is not None, why_not
    assert max(error(origin, reference, x + 1000.0, y), error(origin, reference, x, y - 1000.0)) <= near
    assert max(error(origin, reference, x + 10_000.0, y), error(origin, reference, x, y - 10_000.0)) <= far


def without_pyproj(monkeypatch: pytest.MonkeyPatch) -> None:
    there = builtins.__import__

    def importing(name: str, *rest: Any, **more: Any) -> Any:
        if name.startswith("pyproj"):
            raise ImportError(name)
        return there(name, *rest, **more)

    monkeypatch.setattr(builtins, "__import__", importing)


def test_what_cannot_be_read_is_said_in_one_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert map_origin(roads(tmp_path, "  ")) == (None, "")
    begin = "where the map lies is not known: geoReference"
    network = roads(tmp_path, "nonsense and more")
    pytest.importorskip("pyproj")
    origin, why_not = map_origin(network)
    assert (origin, why_not.partition(" (")[0]) == (None, f"{begin} 'nonsense' of the road file is no projection")
    without_pyproj(monkeypatch)
    assert map_origin(roads(tmp_path, UTM)) == (
        None,
        f"{begin} '+proj=utm' of the road file needs pyproj (pip install -e '.[geo]' from the checkout)",
    )


@pytest.mark.parametrize(
    "reference", [TMERC.replace("k=1", "k=0.9996"), TMERC.replace("WGS84", "bessel"), TMERC.replace("=m ", "=ft ")]
)
def test_a_plane_of_another_scale_ellipsoid_or_unit_is_none_of_ours(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, reference: str
) -> None:
    network = roads(tmp_path, reference)
    without_pyproj(monkeypatch)
    assert map_origin(network)[0] is None


@pytest.mark.parametrize(
    "more", ["+R=6371000", "+a=6378137 +b=6378137", "+alpha=30", "+lat_ts=70", "+gamma=30", "+towgs84=598,73,418"]
)
def test_a_plane_with_any_other_word_is_left_to_pyproj(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, more: str
) -> None:
    """A sphere's is 3 m off at 1 km."""
    network = roads(tmp_path, f"+proj=tmerc +lat_0=48 +lon_0=11 {more}")
    without_pyproj(monkeypatch)
    assert map_origin(network)[0] is None


@pytest.mark.parametrize("reference", ["EPSG:4326", "+proj=longlat +datum=WGS84 +no_defs", "EPSG:4978"])
def test_degrees_are_no_metres_of_a_map(tmp_path: Path, reference: str) -> None:
    """The start of a road at x = 180 m would lie at 180 degrees east."""
    pytest.importorskip("pyproj")
    origin, why_not = map_origin(roads(tmp_path, reference))
    assert (origin, why_not.partition(" of the road file ")[2]) == (None, "is no projection to a plane")


def test_a_projection_that_distorts_is_no_plane(tmp_path: Path) -> None:
    """Web Mercator is 0.7 % longer to the east than to the north: 6.7 m off at 1 km."""
    pytest.importorskip("pyproj")
    origin, why_not = map_origin(roads(tmp_path, "EPSG:3857"))
    assert (origin, why_not.partition(" of the road file ")[2]) == (None, "distorts the shape of the roads")


def test_a_place_that_the_earth_does_not_have_is_no_origin(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    network = roads(tmp_path, TMERC.replace("48.137", "95"))
    without_pyproj(monkeypatch)
    assert map_origin(network)[0] is None


@pytest.mark.parametrize("turn", [0.0, 0.4, -3.0])
def test_a_turned_map_is_exact_there_and_back(turn: float) -> None:
    origin = Origin(48.0, 11.0, 500.0, 300.0, -50.0, turn, 0.9996)
    place = (1200.0, -340.0, 20.0)
    assert to_map(*to_geodetic(*place, origin), origin) == pytest.approx(place, abs=1e-6)


def test_x_of_a_turned_map_points_where_it_is_said_to() -> None:
    """A quarter turn: the map's x axis points north."""
    latitude, longitude, _ = to_geodetic(1000.0, 0.0, 0.0, Origin(48.0, 11.0, 0.0, turn=math.pi / 2.0))
    assert (latitude > 48.008, longitude) == (True, pytest.approx(11.0))


def test_the_guard_of_a_real_car_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    opened: list[Any] = []
    monkeypatch.setattr(
        "vehicle.guard.process.GuardProcess",
        lambda opening, **_: opened.append(opening) or SimpleNamespace(punctuality=dict),
    )
    request: Any = SimpleNamespace(spec=RunSpec(vehicle="ros2_car:7", stage="pe"), path=Path("x.xosc"))
    log: Any = SimpleNamespace(record=None, wire=SimpleNamespace(record=None))
    guarded_car(request, roads(tmp_path, SHIFTED), None, log)
    assert (opened[0].origin, opened[0].why_not) == (Origin(48.137, 11.575, None, 500.0, -200.0), "")


def test_a_car_in_this_process_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    from vehicle.adapters.live import LiveCar

    told: list[Any] = []
    members = dict.fromkeys(("description", "reset", "observe", "apply", "step", "stop", "close"), print)
    car: Any = SimpleNamespace(**members, is_real=False, locate_map=lambda *what: told.append(what))
    monkeypatch.setattr(open_car, "find_adapter", lambda name: Adapter(name, lambda _: car, is_real=False))
    origin = Origin(48.0, 11.0)
    open_car.open_vehicle(RunSpec(vehicle="toy", stage="rw"), origin=(origin, "so"))
    assert told == [(origin, "so")]
    assert not hasattr(LiveCar, "locate_map")  # a surrogate's receiver has its own place on earth
