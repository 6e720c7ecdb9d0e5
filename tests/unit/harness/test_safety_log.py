"""What a run records for the safety metrics: stamps of commands, lane and limit, traffic lights and their lines."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from openscenario.road.network import load_network
from pytest_dvp.drive.run import run
from pytest_dvp.drive.stop_lines import stop_lines
from pytest_dvp.metrics import compute
from scenarios import path
from tests.unit.harness.conftest import OneTrick, coast
from vehicle.messages import Command

Write = Callable[..., Path]


def test_stop_line_is_where_the_signal_of_the_road_stands() -> None:
    """Signal 1 of the map: s = 130 for traffic with increasing s, whose only lane is 3.5 m wide to the right."""
    network = load_network(path("traffic_light.xosc").with_name("urban.xodr"))
    (line,) = stop_lines(network)
    signal = next(s for s in network.signals if s.id == "1")
    pose = network.lane_pose(signal.road, -1, 130.0)
    assert line["signal"] == "1"
    assert (line["x"], line["y"]) == (pytest.approx(pose.x), pytest.approx(pose.y))
    assert line["width"] == pytest.approx(network.lane_width(signal.road, -1, 130.0))
    assert np.cos(line["heading"] - pose.h) == pytest.approx(1.0)


ROAD = """<OpenDRIVE><header revMajor="1" revMinor="7"/>
<road id="1" length="200" junction="-1">
<planView><geometry s="0" x="0" y="0" hdg="0" length="200"><line/></geometry></planView>
<lanes><laneSection s="0"><center><lane id="0" type="none"/></center><right>{lanes}</right></laneSection></lanes>
<signals><signal id="L" s="120" t="-12" dynamic="yes" orientation="+" type="1000001">{validity}</signal></signals>
</road></OpenDRIVE>"""
LANES = "".join(
    f'<lane id="{-n}" type="driving"><width sOffset="0" a="3.5" b="0" c="0" d="0"/></lane>' for n in (1, 2, 3)
)


@pytest.mark.parametrize(
    ("ranges", "middles"),
    [
        ((), [(-5.25, 10.5)]),
        (((-2, -2),), [(-5.25, 3.5)]),
        (((-1, -1), (-3, -3)), [(-1.75, 3.5), (-8.75, 3.5)]),
        (((0, 0),), []),
    ],
)
def test_stop_line_lies_over_the_lanes_that_the_signal_is_valid_for(
    tmp_path: Path, ranges: tuple[tuple[int, int], ...], middles: list[tuple[float, float]]
) -> None:
    """Three lanes of 3.5 m to the right of y = 0; `validity` says for which of them a signal is."""
    validity = "".join(f'<validity fromLane="{low}" toLane="{high}"/>' for low, high in ranges)
    (tmp_path / "road.xodr").write_text(ROAD.format(lanes=LANES, validity=validity))
    lines = stop_lines(load_network(tmp_path / "road.xodr"))
    assert [(line["y"], line["width"]) for line in lines] == [pytest.approx(each) for each in middles]


@pytest.mark.parametrize("kind", ["onRamp", "bus", "bidirectional"])
def test_a_light_over_any_lane_that_cars_drive_on_has_a_stop_line(tmp_path: Path, kind: str) -> None:
    (tmp_path / "road.xodr").write_text(ROAD.format(lanes=LANES.replace("driving", kind), validity=""))
    (line,) = stop_lines(load_network(tmp_path / "road.xodr"))
    assert (line["y"], line["width"]) == pytest.approx((-5.25, 10.5))


def test_a_stale_command_has_its_age_in_the_log(scenario: Write) -> None:
    late = OneTrick(lambda o: Command(o.t - 0.1 if 1.0 <= o.t < 1.2 else o.t, 0.0, 0.0, 0.0, 0.0))
    found = compute("command_age", run(scenario(), ads=late).log)
    assert found.value == pytest.approx(0.1)
    assert 1.0 <= (found.t or 0.0) < 1.2


def test_lane_limit_and_states_of_lights_are_recorded() -> None:
    """The map says 30 km/h and lanes of 3.5 m; the scenario begins with a green light."""
    log = run(path("traffic_light.xosc"), ads=OneTrick(coast), duration=1.0).log
    assert [(e.t, e.element, e.text) for e in log.events if e.kind == "signal"] == [(0.0, "1", "green")]
    assert log["speed_limit"] == pytest.approx(30.0 / 3.6)
    assert log["lane_width"] == pytest.approx(3.5)
