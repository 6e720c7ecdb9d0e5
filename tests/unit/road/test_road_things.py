"""Crosswalks, signals and borders."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from road_files import cubic, lane, network, section, straight


def crosswalk(inside: str = "", **attributes: object) -> str:
    values = {"id": "z", "type": "crosswalk", "s": 40, "t": 0, "length": 7, "width": 3, **attributes}
    written = " ".join(f'{key}="{value}"' for key, value in values.items())
    return f"<object {written}>{inside}</object>"


def corners(outline: np.ndarray) -> list[tuple[float, float]]:
    return sorted((round(float(x), 6), round(float(y), 6)) for x, y in outline)


def test_crosswalk_without_outline_is_its_rectangle(tmp_path: Path) -> None:
    net = network(tmp_path, straight("1", 0, 0, 0, 100, objects=crosswalk(hdg=math.pi / 2)))
    (found,) = net.crosswalks
    assert corners(found.outline) == [(38.5, -3.5), (38.5, 3.5), (41.5, -3.5), (41.5, 3.5)]
    assert (found.s_from, found.s_to) == pytest.approx((38.5, 41.5))


def test_local_corners_are_in_the_objects_frame(tmp_path: Path) -> None:
    points = "".join(f'<cornerLocal u="{u}" v="{v}" z="0" height="0"/>' for u, v in ((0, 0), (2, 0), (2, 1)))
    text = crosswalk(f"<outline>{points}</outline>", hdg=math.pi / 2, t=1)
    (found,) = network(tmp_path, straight("1", 0, 0, 0, 100, objects=text)).crosswalks
    assert corners(found.outline) == [(39.0, 3.0), (40.0, 1.0), (40.0, 3.0)]


def test_road_corners_follow_the_road(tmp_path: Path) -> None:
    places = ((38, -4), (42, -4), (42, 4), (38, 4))
    points = "".join(f'<cornerRoad s="{s}" t="{t}" dz="0" height="0"/>' for s, t in places)
    text = crosswalk(f"<outlines><outline>{points}</outline></outlines>")
    (found,) = network(tmp_path, straight("1", 0, 0, math.pi / 2, 100, objects=text)).crosswalks
    assert corners(found.outline) == [(-4.0, 38.0), (-4.0, 42.0), (4.0, 38.0), (4.0, 42.0)]
    assert (found.s_from, found.s_to) == (38.0, 42.0)


def test_repeated_crosswalk_is_there_each_time(tmp_path: Path) -> None:
    text = crosswalk('<repeat s="20" length="40" distance="20" tStart="0" tEnd="0"/>')
    net = network(tmp_path, straight("1", 0, 0, 0, 100, objects=text))
    assert [found.s for found in net.crosswalks] == pytest.approx([20.0, 40.0, 60.0])


def test_other_objects_are_no_crosswalks(tmp_path: Path) -> None:
    net = network(tmp_path, straight("1", 0, 0, 0, 100, objects=crosswalk(type="tree")))
    assert net.crosswalks == ()


def test_signals_keep_their_road_and_value(tmp_path: Path) -> None:
    text = '<signal id="7" s="30" t="-4" type="274" subtype="50" value="50" unit="km/h" dynamic="no" orientation="+"/>'
    net = network(tmp_path, straight("1", 0, 0, 0, 100, signals=text))
    (signal,) = net.signals
    assert (signal.id, signal.road, signal.s, signal.value, signal.dynamic) == ("7", "1", 30.0, 50.0, False)


def test_borders_say_what_they_part(tmp_path: Path) -> None:
    lanes = section([lane(1), lane(2, 2.0, "sidewalk")], [lane(-1), lane(-2)])
    net = network(tmp_path, straight("1", 0, 0, 0, 100, lanes))
    kinds = [(border.kind, float(border.points[0, 1])) for border in net.boundaries()]
    assert kinds == [("edge", 3.5), ("centre", 0.0), ("lane", -3.5), ("edge", -7.0)]


def test_borders_follow_a_widening_lane(tmp_path: Path) -> None:
    net = network(tmp_path, straight("1", 0, 0, 0, 100, section((), [lane(-1, inside=cubic("width", 0.0, 3.0, 0.01))])))
    outer = net.boundaries(step=10.0)[-1].points
    assert outer.shape == (11, 2)
    assert outer[-1] == pytest.approx((100.0, -4.0))


def test_geo_reference_is_kept_as_written(tmp_path: Path) -> None:
    header = "<geoReference><![CDATA[+proj=utm +zone=32]]></geoReference>"
    assert network(tmp_path, straight("1", 0, 0, 0, 100), header=header).geo_reference == "+proj=utm +zone=32"


def test_borders_of_a_banked_slope_lie_on_its_surface(tmp_path: Path) -> None:
    parts = {"elevation": cubic("elevation", 0, 0, 0.1), "superelevation": cubic("superelevation", 0, 0.2, 0.001)}
    net = network(tmp_path, straight("1", 0, 0, 0.5, 100, **parts))
    outer = net.boundaries(step=10.0)[-1].points
    for number in range(11):
        pose = net.road_pose("1", 10.0 * number, -3.5)
        assert outer[number] == pytest.approx((pose.x, pose.y), abs=1e-9)


LIGHT = '<signal id="9" s="5" t="-30" dynamic="yes" orientation="-" type="1000001"/>'


def test_a_reference_is_the_signal_on_the_road_that_refers_to_it(tmp_path: Path) -> None:
    """ASAM OpenDRIVE 1.8, 14.5: a signalReference makes a signal of another road valid here as well."""
    reference = '<signalReference id="9" s="60" t="-6" orientation="+"><validity fromLane="-2" toLane="-1"/>'
    net = network(
        tmp_path,
        straight("1", 0, 0, 0, 100, signals=reference + "</signalReference>"),
        straight("2", 0, 50, 0, 100, signals=LIGHT),
    )
    here, there = net.signals
    assert (here.id, here.road, here.s, here.t, here.orientation) == ("9", "1", 60.0, -6.0, "+")
    assert (here.dynamic, here.type, here.validity) == (True, "1000001", ((-2, -1),))
    assert (there.road, there.s, there.orientation, there.validity) == ("2", 5.0, "-", ())


def test_a_reference_to_no_signal_names_nothing(tmp_path: Path) -> None:
    net = network(tmp_path, straight("1", 0, 0, 0, 100, signals='<signalReference id="7" s="60" t="0"/>'))
    assert net.signals == ()
    assert [finding.found for finding in net.file.repairs] == ["7"]


@pytest.mark.parametrize("word", ["true", "1", "Yes"])
def test_a_light_whose_file_writes_yes_in_another_way_is_dynamic(word: str, tmp_path: Path) -> None:
    net = network(tmp_path, straight("1", 0, 0, 0, 100, signals=LIGHT.replace('"yes"', f'"{word}"')))
    assert [signal.dynamic for signal in net.signals] == [True]
    assert [each.repair for each in net.file.repairs] == ["it is dynamic"]


def test_what_is_assumed_of_an_unknown_word_is_what_holds(tmp_path: Path) -> None:
    text = LIGHT.replace('"yes"', '"maybe"').replace('"-"', '"both"')
    net = network(tmp_path, straight("1", 0, 0, 0, 100, signals=text))
    assert [signal.dynamic for signal in net.signals] == [False]
    assert {each.repair for each in net.file.repairs} == {"it is not dynamic", "it is for both directions"}
