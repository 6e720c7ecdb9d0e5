"""An EnvironmentAction reaches the car: friction its brakes, fog and rain the range of its sensors."""

from __future__ import annotations

import math
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from openscenario.model import Environment, Fog, Precipitation, RoadCondition, Sun, TimeOfDay, Wind
from openscenario.model import Weather as Air
from openscenario.model.kinds import At
from pytest_dvp import run
from pytest_dvp.drive.ego_model import shipped
from pytest_dvp.drive.weather import Weather, weather_notes
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import LogEvent
from tests.unit.harness.conftest import OneTrick, coast
from vehicle.messages import Command, Observation, Surroundings
from vehicle.model.model_file import read_model
from vehicle.model.wind import air_coefficients
from vehicle.sensors.air import (
    camera_range,
    extinction_of_fog,
    extinction_of_precipitation,
    lidar_range,
)
from vehicle.sensors.light import is_dark, sunlight
from vehicle.sensors.suite import default_sensors

Write = Callable[..., Path]
G = 9.80665
AT = At("x.xosc", 1, "Environment")
CAR = np.array([[0.0, 0.0, 0.75, 0.0, 4.5, 1.8, 1.5, 0.0, 0.0]])


def environment(**parts: object) -> Environment:
    return Environment(name="wet", at=AT, **parts)  # type: ignore[arg-type]


def road(scale: float) -> RoadCondition:
    return RoadCondition(friction_scale_factor=scale, at=AT)


def action(inside: str) -> tuple[str, str]:
    """The replacement that puts an EnvironmentAction into Init."""
    start = '<Private entityRef="Ego">'
    given = f'<GlobalAction><EnvironmentAction><Environment name="wet">{inside}</Environment></EnvironmentAction>'
    return start, f"{given}</GlobalAction>{start}"


def brake(observation: Observation) -> Command:
    return Command(observation.t, 0.0, -5.0, 0.0, 1.0)


@pytest.mark.parametrize("friction", [0.15, 0.25])
def test_on_a_slippery_road_the_car_brakes_with_mu_g(scenario: Write, friction: float) -> None:
    """Within 4 %, which are its drag and the slope of its speed over two samples."""
    path = scenario(action(f'<RoadCondition frictionScaleFactor="{friction}"/>'))
    log = run(path, ads=OneTrick(brake), duration=2.0).log
    speed = log["v"]
    assert (speed[80] - speed[130]) / 0.5 == pytest.approx(friction * G, rel=0.04)
    (event,) = (each for each in log.events if each.kind == "environment")
    told = f"friction coefficient {friction}, which brakes with {9.80665 * friction:.3g} m/s^2 at most"
    assert (event.t, event.text) == (0.0, told)


@pytest.mark.parametrize(("friction", "hits"), [(0.6, False), (0.4, False), (0.25, True)])
def test_an_emergency_stop_brakes_with_mu_g_and_hits_where_that_is_too_little(
    scenarios_dir: Path, tmp_path: Path, friction: float, hits: bool
) -> None:
    """The shipped scenario and stack: on the dry road it brakes with 6.8 m/s^2 and stops 1.8 m short."""
    (tmp_path / "urban.xodr").write_bytes((scenarios_dir / "urban.xodr").read_bytes())
    shutil.copytree(scenarios_dir / "catalogs", tmp_path / "catalogs")
    text = (scenarios_dir / "emergency_stop.xosc").read_text()
    path = tmp_path / "stop.xosc"
    road = f'<RoadCondition frictionScaleFactor="{friction}"/>'
    place, wet = action(road)
    assert place in text
    path.write_text(text.replace(place, wet, 1))
    result = run(path)
    hardest = -np.gradient(result.log["v"], result.log["t"]).min()
    assert hardest == pytest.approx(friction * G, rel=0.02)
    assert (result.metrics["collision"] > 0.0) is hits


@pytest.mark.parametrize("factor", ["1.0", "1.5"])
def test_the_road_of_the_model_holds_what_it_held_before(scenario: Write, factor: str) -> None:
    dry = run(scenario(), ads=OneTrick(brake), duration=0.5).log
    told = run(
        scenario(action(f'<RoadCondition frictionScaleFactor="{factor}"/>')), ads=OneTrick(brake), duration=0.5
    ).log
    assert np.array_equal(dry["x"], told["x"])


def test_rain_alone_does_not_make_the_road_slippery_and_parts_that_are_left_out_stay() -> None:
    weather = Weather()
    assert weather.look(environment(road_condition=road(0.4)))
    rain = Precipitation(precipitation_type="rain", precipitation_intensity=20.0, at=AT)
    assert weather.look(environment(weather=Air(precipitation=rain, at=AT)))
    assert weather.friction == pytest.approx(0.4)
    assert weather.extinction == pytest.approx(extinction_of_precipitation("rain", 20.0))
    weather.look(environment(road_condition=road(1.0), weather=Air(at=AT)))
    assert (weather.friction, weather.extinction) == (None, extinction_of_precipitation("rain", 20.0))
    none = Precipitation(precipitation_type="dry", precipitation_intensity=0.0, at=AT)
    fog = Fog(visual_range=60.0, at=AT)
    weather.look(environment(weather=Air(fog=fog, precipitation=none, at=AT)))
    assert weather.extinction == pytest.approx(extinction_of_fog(60.0))
    weather.look(environment(weather=Air(wind=Wind(speed=3.0, direction=0.0, at=AT), at=AT)))
    assert (weather.extinction, weather.wind) == (pytest.approx(extinction_of_fog(60.0)), (3.0, 0.0))


def test_fog_and_rain_add_up() -> None:
    weather = Weather()
    rain = Precipitation(precipitation_type="rain", precipitation_intensity=20.0, at=AT)
    weather.look(environment(weather=Air(fog=Fog(visual_range=60.0, at=AT), precipitation=rain, at=AT)))
    assert weather.extinction == pytest.approx(extinction_of_fog(60.0) + extinction_of_precipitation("rain", 20.0))


@pytest.mark.parametrize("visual_range", [20.0, 60.0, 79.0])
def test_over_the_visual_range_five_per_cent_are_left_and_the_camera_sees_no_farther(visual_range: float) -> None:
    extinction = extinction_of_fog(visual_range)
    assert math.exp(-extinction * visual_range) == pytest.approx(0.05)
    assert camera_range(80.0, extinction) == pytest.approx(visual_range)
    assert camera_range(0.5 * visual_range, extinction) == 0.5 * visual_range


@pytest.mark.parametrize("visual_range", [10.0, 50.0, 500.0])
def test_the_weakest_echo_of_a_lidar_is_that_of_its_reach_in_clear_air(visual_range: float) -> None:
    extinction = extinction_of_fog(visual_range)
    found = lidar_range(80.0, extinction)
    assert math.exp(-2.0 * extinction * found) / found**2 == pytest.approx(1.0 / 80.0**2)
    assert found < 80.0


def test_rain_of_1_mm_an_hour_takes_1_076_decibels_a_kilometre() -> None:
    left = math.exp(-1000.0 * extinction_of_precipitation("rain", 1.0))
    assert 10.0 * math.log10(left) == pytest.approx(-1.076)
    assert extinction_of_precipitation("dry", 50.0) == 0.0
    assert extinction_of_precipitation("snow", 5.0) > extinction_of_precipitation("rain", 5.0)


@pytest.mark.parametrize(
    ("kind", "intensity", "decibels"),
    [
        ("rain", 10.0, 5.0330),  # 1.076 * 10^0.67 = 1.076 * 4.6774
        ("rain", 50.0, 14.795),  # 1.076 * 50^0.67 = 1.076 * 13.750
        ("snow", 1.0, 3.8781),  # 0.0001023 * 905 + 3.7855466
        ("snow", 5.0, 12.356),  # 3.8781 * 5^0.72 = 3.8781 * 3.1861
        ("snow", 10.0, 20.353),  # 3.8781 * 10^0.72 = 3.8781 * 5.2481
    ],
)
def test_rain_and_snow_take_decibels_a_kilometre_as_the_table_says(
    kind: str, intensity: float, decibels: float
) -> None:
    left = math.exp(-1000.0 * extinction_of_precipitation(kind, intensity))
    assert -10.0 * math.log10(left) == pytest.approx(decibels, rel=1e-4)


def seen(distance: float, extinction: float) -> tuple[bool, bool]:
    """Whether LiDAR and camera see a car `distance` [m] ahead of theirs; half a second of looks."""
    sensors = default_sensors()
    running = sensors.start([0.0] * 12, 7)
    box = CAR.copy()
    box[0, 0] = distance
    around = Surroundings(box, np.zeros(1, dtype=np.int64), ("a",), extinction=extinction)
    lidar = camera = False
    for k in range(20):
        observation = running.observe(0.05 * k, around)
        lidar = lidar or (observation.lidar is not None and len(observation.lidar.points) > 0)
        camera = camera or (observation.camera is not None and len(observation.camera.boxes) > 0)
    return lidar, camera


@pytest.mark.parametrize("visual_range", [30.0, 45.0])
def test_detections_end_where_the_model_says(visual_range: float) -> None:
    """A metre short of its range each sensor sees the nearer face of a car, a metre beyond no part of it."""
    extinction = extinction_of_fog(visual_range)
    sensors = default_sensors()
    assert sensors.lidar is not None
    assert sensors.camera is not None
    lidar = sensors.lidar.mount.x + lidar_range(sensors.lidar.reach, extinction)
    camera = sensors.camera.mount.x + camera_range(sensors.camera.reach, extinction)
    assert [seen(lidar + 2.25 + d, extinction)[0] for d in (-1.0, 1.0)] == [True, False]
    assert [seen(camera + d, extinction)[1] for d in (-3.3, 3.3)] == [True, False]
    assert seen(60.0, 0.0) == (True, True)


@pytest.mark.parametrize(("direction", "towards"), [(math.pi, -1.0), (0.0, 1.0)])
def test_wind_along_the_road_slows_or_carries_the_car(scenario: Write, direction: float, towards: float) -> None:
    """Of two coasting cars the one in the wind has lost k ((v - w)^2 - v^2) t more, k that of its size or model."""
    calm = run(scenario(), ads=OneTrick(coast), duration=1.0).log
    told = scenario(action(f'<Weather><Wind direction="{direction}" speed="9"/></Weather>'))
    windy = run(told, ads=OneTrick(coast), duration=1.0).log
    v = float(np.mean(calm["v"]))
    k = air_coefficients(read_model(shipped("models/tabby_evo.toml")))[0]
    lost = k * (abs(v - 9.0 * towards) * (v - 9.0 * towards) - v * v)
    assert calm["v"][-1] - windy["v"][-1] == pytest.approx(lost, rel=0.1)
    (event,) = (each for each in windy.events if each.kind == "environment")
    assert event.text == f"wind 9 m/s towards {direction:.3g} rad"


@pytest.mark.parametrize(
    ("inside", "text"),
    [
        ('<TimeOfDay animation="false" dateTime="2026-12-21T23:00:00"/>', "darkness"),
        ('<TimeOfDay animation="false" dateTime="2026-06-21T12:00:00"/>', "dry road, clear air"),
        ('<Weather><Sun azimuth="1.57" elevation="0.03" illuminance="20000"/></Weather>', "glare within"),
    ],
)
def test_sun_and_time_of_day_are_told(scenario: Write, inside: str, text: str) -> None:
    log = run(scenario(action(inside)), ads=OneTrick(coast), duration=0.1).log
    (event,) = (each for each in log.events if each.kind == "environment")
    assert event.text.startswith(text)


def test_an_animated_day_goes_on() -> None:
    weather = Weather()
    clock = TimeOfDay(animation=True, date_time="2026-03-22T17:00:00", at=AT)
    weather.look(evening := environment(time_of_day=clock), 0.0)
    assert weather.light is not None
    assert not is_dark(weather.light)
    assert not weather.look(evening, 2.0 * 3600.0)
    assert is_dark(weather.light)


@pytest.mark.parametrize(
    ("given", "held"),
    [
        ('<Throttle active="true" value="0.4"/>', {"throttle": 0.4, "brake": 0.0}),
        ('<Brake active="true" value="0.7"/>', {"brake": 0.7, "steer": 0.0}),
        ('<SteeringWheel active="true" value="0.8"/>', {"steer": 0.05}),
        ('<Clutch active="true" value="1"/>', {"throttle": 0.0}),
    ],
)
def test_the_scenario_takes_pedals_and_wheel_from_the_stack(
    scenario: Write, given: str, held: dict[str, float]
) -> None:
    """The stack asks for 0.2 of the throttle all the time; from 1 s on the scenario holds what it names."""
    start = '<Private entityRef="Ego">'
    override = (
        "<PrivateAction><ControllerAction><OverrideControllerValueAction>"
        f"{given}</OverrideControllerValueAction></ControllerAction></PrivateAction>"
    )
    path = scenario((start, f"{start}{override}"))
    log = run(path, ads=OneTrick(lambda o: Command(o.t, 0.0, 0.5, 0.2, 0.0)), duration=0.5).log
    for name, value in held.items():
        assert log[f"{name}_cmd"][-1] == pytest.approx(value)


@pytest.mark.parametrize(
    ("declared", "given", "told"),
    [
        ("false", ("true",), ["true"]),
        ("true", ("false",), ["false"]),
        ("true", ("true",), []),
        ("false", ("true", "false"), []),  # within one instant: nothing is seen of it
    ],
)
def test_changes_of_monitors_are_events_of_the_log(
    scenario: Write, declared: str, given: tuple[str, ...], told: list[str]
) -> None:
    monitor = f'<MonitorDeclarations><MonitorDeclaration name="seen" value="{declared}"/></MonitorDeclarations>'
    start = '<Private entityRef="Ego">'
    raised = "".join(
        f'<GlobalAction><SetMonitorAction monitorRef="seen" value="{value}"/></GlobalAction>' for value in given
    )
    path = scenario(("<CatalogLocations/>", f"{monitor}<CatalogLocations/>"), (start, f"{raised}{start}"))
    log = run(path, ads=OneTrick(coast), duration=0.2).log
    assert [(each.element, each.text) for each in log.events if each.kind == "monitor"] == [("seen", x) for x in told]


def test_what_of_the_weather_changes_nothing_is_said(scenario: Write) -> None:
    image = '<Weather><DomeImage><DomeFile filepath="sky.hdr"/></DomeImage></Weather>'
    notes = run(scenario(action(image)), ads=OneTrick(coast), duration=0.1).notes
    assert [note.partition("no effect here: ")[2] for note in notes if "no effect here" in note] == [
        "DomeImage of an environment (nothing is drawn from the scenario while it runs)"
    ]


@pytest.mark.parametrize(("oktas", "direct"), [("zero", 1.0), ("four", 0.5), ("eight", 0.0), ("nine", 0.0)])
def test_clouds_let_through_what_they_do_not_cover(oktas: str, direct: float) -> None:
    """Nine oktas: the sky cannot be seen (WMO code table 2700)."""
    weather = Weather()
    air = Air(fractional_cloud_cover=f"{oktas}Oktas", sun=Sun(azimuth=0.0, elevation=1.0, illuminance=1e5))  # type: ignore[arg-type]
    weather.look(environment(weather=air), 0.0)
    assert weather.light is not None
    assert weather.light == sunlight(0.0, 1.0, 1e5, 1.0 - direct)


def test_the_last_second_of_the_calendar_lasts() -> None:
    weather = Weather()
    day = TimeOfDay(animation=True, date_time="9999-12-31T23:59:59", at=AT)
    weather.look(environment(time_of_day=day), 0.0)
    weather.look(environment(time_of_day=day), 60.0)
    assert weather.light is not None


def test_notes_tell_the_first_changes_that_limit_the_car() -> None:
    """Fair weather is none; of many changes, as on a road of changing friction, the first three and a count."""
    texts = ["dry road, clear air", *(f"friction coefficient 0.{k}" for k in range(1, 6))]
    log = Log(
        {"t": np.zeros(1)}, events=tuple(LogEvent(float(k), "environment", "wet", x) for k, x in enumerate(texts))
    )
    assert weather_notes(log) == (
        "environment wet from t=1.00 s: friction coefficient 0.1",
        "environment wet from t=2.00 s: friction coefficient 0.2",
        "environment wet from t=3.00 s: friction coefficient 0.3",
        "environment: 2 further changes, see the report",
    )


def test_a_text_says_what_the_numbers_do(scenario: Write) -> None:
    """0.4 g is 3.92 m/s^2; in fog alone the visual range is the file's."""
    path = scenario(action('<Weather><Fog visualRange="60"/></Weather><RoadCondition frictionScaleFactor="0.4"/>'))
    notes = run(path, ads=OneTrick(brake), duration=0.1).notes
    assert [each.split(": ")[1] for each in notes if each.startswith("environment")] == [
        "friction coefficient 0.4, which brakes with 3.92 m/s^2 at most, visual range 60 m (extinction 0.0499 1/m)"
    ]


def test_a_sun_that_stands_in_degrees_shines_from_there() -> None:
    """60 is no angle within half a turn: 60 degrees, at which the sky is bright."""
    weather = Weather()
    weather.look(environment(weather=Air(sun=Sun(azimuth=90.0, elevation=60.0), at=AT)))
    stated = Weather()
    stated.look(environment(weather=Air(sun=Sun(azimuth=math.pi / 2.0, elevation=math.pi / 3.0), at=AT)))
    assert weather.light is not None
    assert not is_dark(weather.light)
    assert weather.light == stated.light
