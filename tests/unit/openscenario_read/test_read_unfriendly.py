"""Files that are unusual and legal, or wrong in what harms nobody: they are read, and say what was assumed."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path

import pytest
from xosc_samples import ROAD, Spoil, line_of

from openscenario.read import check_scenario, read_scenario
from openscenario.values import BadValue, moment, to_moment
from openscenario.xml import parse_xml

ENVIRONMENT = (
    '<Actions><GlobalAction><EnvironmentAction><Environment name="e">{}'
    "</Environment></EnvironmentAction></GlobalAction>"
)


def said(path: Path) -> list[tuple[str, str]]:
    return [(finding.severity, finding.code) for finding in check_scenario(path)]


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-le", "utf-16-be", "utf-8-sig", "utf-32"])
def test_the_road_of_a_scenario_may_have_any_encoding(spoil: Spoil, encoding: str) -> None:
    """Whether it is a road at all was once looked at as if its bytes were ASCII."""
    path = spoil()
    (path.parent / "road.xodr").write_bytes(f"<!-- Straße -->\n{ROAD}".encode(encoding))
    assert said(path) == []


def test_a_road_that_is_none_is_refused_in_any_encoding(spoil: Spoil) -> None:
    path = spoil()
    (path.parent / "road.xodr").write_bytes("<osm/>".encode("utf-16"))
    assert said(path) == [("error", "asam.net:xodr:1.0.0:xml.root_tag_is_opendrive")]


def test_a_scenario_without_catalog_locations_is_read_with_a_warning(spoil: Spoil) -> None:
    path = spoil("<CatalogLocations/>", "")
    assert said(path) == [("warning", "xml.valid_schema")]
    assert read_scenario(path).entities[0].name == "Ego"


def test_an_empty_logic_file_names_no_road(spoil: Spoil) -> None:
    path = spoil('<LogicFile filepath="road.xodr"/>', '<LogicFile filepath=""/>')
    assert said(path) == []
    assert read_scenario(path).road_network.logic_file is None


def test_a_reference_to_a_parameter_written_with_its_dollar_means_that_parameter(spoil: Spoil) -> None:
    action = (
        '<Actions><GlobalAction><ParameterAction parameterRef="$EgoSpeed"><SetAction value="7"/>'
        "</ParameterAction></GlobalAction>"
    )
    path = spoil("<Actions>", action)
    (finding,) = check_scenario(path)
    assert (finding.severity, finding.code, finding.found) == ("warning", "param.name", "$EgoSpeed")
    assert finding.line == line_of(path, "$EgoSpeed")
    assert read_scenario(path).storyboard.init.actions.global_actions[0].parameter_ref == "EgoSpeed"


def test_a_parameter_that_holds_the_name_of_another_stands_for_that_one(spoil: Spoil) -> None:
    action = (
        '<Actions><GlobalAction><ParameterAction parameterRef="$which"><SetAction value="7"/>'
        "</ParameterAction></GlobalAction>"
    )
    path = spoil("<Actions>", action)
    declared = '<ParameterDeclaration name="which" parameterType="string" value="EgoSpeed"/></ParameterDeclarations>'
    path.write_text(path.read_text().replace("</ParameterDeclarations>", declared))
    assert said(path) == []
    assert read_scenario(path).storyboard.init.actions.global_actions[0].parameter_ref == "EgoSpeed"


@pytest.mark.parametrize(
    ("text", "meant"),
    [
        ("2020-12-31T24:00:00", datetime.fromisoformat("2021-01-01T00:00:00")),
        ("2020-02-28T24:00:00.000Z", datetime.fromisoformat("2020-02-29T00:00:00+00:00")),
        ("2020-02-28T24:00:00+01:00", datetime.fromisoformat("2020-02-29T00:00:00+01:00")),
    ],
)
def test_midnight_at_the_end_of_a_day_is_the_start_of_the_next(text: str, meant: datetime) -> None:
    """W3C, XML Schema part 2, 3.2.7: `24:00:00` is permitted."""
    assert moment(text) == meant
    assert to_moment(text) == text


@pytest.mark.parametrize("text", ["2020-12-31T24:00:01", "2020-12-31T25:00:00", "9999-12-31T24:00:00"])
def test_what_is_no_moment_is_refused(text: str) -> None:
    with pytest.raises(BadValue):
        to_moment(text)


@pytest.mark.parametrize(("speed", "codes"), [("1000", []), ("1001", [("error", "value.out_of_range")])])
def test_wind_is_no_faster_than_the_car_can_be_computed_in(
    spoil: Spoil, speed: str, codes: list[tuple[str, str]]
) -> None:
    wind = f'<Weather><Wind direction="0" speed="{speed}"/></Weather>'
    assert said(spoil("<Actions>", ENVIRONMENT.format(wind))) == codes


def test_a_prefix_of_the_roots_own_namespace_is_no_part_of_the_tags() -> None:
    root = parse_xml(b'<x:a xmlns:x="http://x" xmlns:y="http://y"><x:b/><y:c/></x:a>', "x.xml").root
    assert [root.tag, *(child.tag for child in root.children)] == ["a", "b", "y:c"]
