"""What a run leaves for its report: nets of the stack, crosswalks of the map, courses of what the stack believed."""

from __future__ import annotations

from pathlib import Path

import pytest

from ads.planning.nets import NETS
from pytest_dvp.drive.result import RunResult
from pytest_dvp.drive.run import run
from pytest_dvp.logs.log import Log
from scenarios import path
from vehicle.messages import Command, Observation


@pytest.fixture(scope="module")
def crossing(tmp_path_factory: pytest.TempPathFactory) -> RunResult:
    file = path("pedestrian_crossing.xosc")
    return run(file, rootdir=file.parent, duration=2.0, log_dir=tmp_path_factory.mktemp("runs"))


def page(result: RunResult) -> str:
    assert result.folder is not None
    return (result.folder / "report.html").read_text(encoding="utf-8")


def test_the_log_keeps_the_nets_with_every_place_and_transition(crossing: RunResult) -> None:
    assert crossing.folder is not None
    kept = Log.load(crossing.folder / "log.mcap").meta["nets"]
    assert {net["name"]: (len(net["places"]), len(net["transitions"])) for net in kept} == {
        net.name: (len(net.places), len(net.transitions)) for net in NETS
    }


def test_every_net_is_drawn(crossing: RunResult) -> None:
    text = page(crossing)
    assert [f'aria-label="Petri net {net.name}"' in text for net in NETS] == [True] * len(NETS)
    assert text.count("data-place=") >= sum(len(net.places) for net in NETS)


def test_the_page_shows_what_was_planned_and_believed(crossing: RunResult) -> None:
    text = page(crossing)
    assert "left of the planned path" in text
    assert "estimated \\u2212 true position" in text


def test_the_map_shows_its_crosswalk_where_the_pedestrian_crosses(crossing: RunResult) -> None:
    (zebra,) = [line["points"] for line in crossing.log.road if line["kind"] == "crosswalk"]
    walker = crossing.log.objects["Pedestrian"]
    assert zebra[:, 0].min() < walker.x[0] < zebra[:, 0].max()


class Plain:
    """A stack that tells nothing but its command."""

    def tick(self, observation: Observation) -> Command:
        return Command(observation.t, 0.0, 0.0, 0.0, 0.0)


def test_a_stack_that_tells_no_nets_has_none_drawn(tmp_path: Path) -> None:
    file = path("pedestrian_crossing.xosc")
    result = run(file, rootdir=file.parent, duration=1.0, ads=Plain, log_dir=tmp_path)
    assert "nets" not in result.log.meta
    assert "Decision nets" not in page(result)
