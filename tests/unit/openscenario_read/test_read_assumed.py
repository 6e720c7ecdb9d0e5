"""What is taken for granted where a file errs and only one thing can be meant: a warning says so, and the file runs."""

from __future__ import annotations

from pathlib import Path

import pytest
from xosc_samples import Spoil

from openscenario.read import check_scenario, read_scenario
from openscenario.values import LARGEST, BadValue, to_limit

LANE = '<LanePosition roadId="1" laneId="-1" s="50.0"'


def said(path: Path) -> list[tuple[str, str]]:
    return [(finding.severity, finding.code) for finding in check_scenario(path)]


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('dynamicsShape="sinusoidal"', 'dynamicsShape="Sinusoidal"'),
        ('priority="overwrite"', 'priority="Overwrite"'),
        ('conditionEdge="rising"', 'conditionEdge="RISING"'),
        ('rule="greaterThan"', 'rule="GreaterThan"'),
        ('selectTriggeringEntities="false"', 'selectTriggeringEntities="False"'),
        ('parameterType="double"', 'parameterType="Double"'),
    ],
)
def test_a_word_in_another_letter_case_is_the_word(spoil: Spoil, old: str, new: str) -> None:
    path = spoil(old, new)
    assert said(path) == [("warning", "value.letter_case")]
    assert read_scenario(path) == read_scenario(spoil())


@pytest.mark.parametrize("text", ["", "None", "null", " "])
def test_an_optional_number_without_a_value_is_left_out(spoil: Spoil, text: str) -> None:
    path = spoil(LANE, f'{LANE} offset="{text}"')
    assert said(path) == [("warning", "value.not_given")]
    assert read_scenario(path) == read_scenario(spoil())


@pytest.mark.parametrize("text", ["", "None", "nan"])
def test_a_required_number_without_a_value_is_an_error(spoil: Spoil, text: str) -> None:
    assert ("error", "value.not_a_number") in said(spoil('s="50.0"', f's="{text}"')) or text == "nan"
    assert [each[0] for each in said(spoil('s="50.0"', f's="{text}"'))] == ["error"]


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('<Condition name="later"', "<Condition"),
        ('delay="0" conditionEdge="rising"', 'conditionEdge="rising"'),
        (' selectTriggeringEntities="false"', ""),
        (' maximumExecutionCount="1"', ""),
    ],
)
def test_attributes_that_can_mean_one_thing_may_be_missing(spoil: Spoil, old: str, new: str) -> None:
    path = spoil(old, new)
    assert said(path) == [("warning", "xml.missing_attribute")]
    group = read_scenario(path).storyboard.stories[0].acts[0].maneuver_groups[0]
    assert group.maximum_execution_count == 1
    assert not group.actors.select_triggering_entities
    assert group.maneuvers[0].events[0].start_trigger is not None


@pytest.mark.parametrize("gone", [' conditionEdge="rising"', ' rule="greaterThan"', ' dynamicsDimension="time"'])
def test_attributes_that_decide_what_happens_may_not(spoil: Spoil, gone: str) -> None:
    assert ("error", "xml.missing_attribute") in said(spoil(gone, ""))


def test_an_attribute_of_a_tools_own_is_left_out_where_things_are_described(spoil: Spoil) -> None:
    path = spoil('<ScenarioObject name="Ego"', '<ScenarioObject name="Ego" colour="red"')
    assert said(path) == [("warning", "xml.unknown_attribute")]
    assert read_scenario(path) == read_scenario(spoil())


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('vehicleCategory="car"', 'vehicleCategory="car" unit="km"'),
        ('<AbsoluteTargetSpeed value="$EgoSpeed"', '<AbsoluteTargetSpeed value="$EgoSpeed" unit="km/h"'),
        ('<Vehicle name="car"', '<Vehicle nam="car"'),
    ],
)
def test_but_not_where_it_may_change_a_motion_nor_if_it_is_a_slip(spoil: Spoil, old: str, new: str) -> None:
    severities = {code: severity for severity, code in said(spoil(old, new))}
    assert severities["xml.unknown_attribute"] == ("warning" if "category" in old.casefold() else "error")


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('<Private entityRef="Ego">', '<Private entityRef="Ego"/><Private entityRef="Ego">'),
        ("<Story ", '<Story name="b"/><Story '),
    ],
)
def test_an_element_that_asks_nothing_of_anybody_may_be_empty(spoil: Spoil, old: str, new: str) -> None:
    assert said(spoil(old, new)) == [("warning", "xml.missing_element")]


def test_elements_in_a_command_are_left_out(spoil: Spoil) -> None:
    command = '<CustomCommandAction type="x"><run what="it"/></CustomCommandAction>'
    path = spoil()
    text = path.read_text()
    start, end = text.index("<PrivateAction><LateralAction>"), text.index("</Action>")
    path.write_text(f"{text[:start]}<UserDefinedAction>{command}</UserDefinedAction>{text[end:]}")
    assert said(path) == [("warning", "xml.unknown_element")]


@pytest.mark.parametrize("text", ["INF", "1e309", "1.79769e308", "2e12"])
def test_a_limit_may_be_endless(spoil: Spoil, text: str) -> None:
    """W3C, XML Schema part 2, 3.2.5: INF is a double."""
    path = spoil('maxAcceleration="4.0"', f'maxAcceleration="{text}"')
    assert said(path) == []
    (ego,) = read_scenario(path).entities
    assert ego.entity.performance.max_acceleration == LARGEST


@pytest.mark.parametrize("text", ["-INF", "NaN", "1_0", "far", ""])
def test_what_is_no_limit_is_refused(text: str) -> None:
    with pytest.raises(BadValue):
        to_limit(text)


def test_a_calculation_without_its_braces_is_helped(spoil: Spoil) -> None:
    (finding,) = check_scenario(spoil('value="$EgoSpeed"', 'value="-$EgoSpeed"'))
    assert (finding.severity, finding.hint) == ("error", "calculations are written ${...}")


def test_a_file_that_declares_two_byte_characters_and_has_none_is_read(spoil: Spoil) -> None:
    path = spoil('encoding="UTF-8"', 'encoding="utf-16"')
    assert said(path) == []


def test_the_road_is_found_in_another_letter_case(spoil: Spoil) -> None:
    path = spoil('filepath="road.xodr"', 'filepath="maps/ROAD.XODR"')
    assert said(path) == [("warning", "path.found_elsewhere")]
    assert read_scenario(path).road_network.logic_file == path.with_name("road.xodr").resolve()


def test_a_directory_of_catalogues_may_be_the_path_of_one(spoil: Spoil) -> None:
    where = '<CatalogLocations><VehicleCatalog><Directory path="cats/cars.xosc"/></VehicleCatalog></CatalogLocations>'
    path = spoil("<CatalogLocations/>", where)
    text = path.read_text()
    start, end = text.index("<Vehicle "), text.index("</Vehicle>") + len("</Vehicle>")
    folder = path.parent / "cats"
    folder.mkdir()
    head = text[: text.index("<ParameterDeclarations>")]
    (folder / "cars.xosc").write_text(f'{head}<Catalog name="Cars">{text[start:end]}</Catalog></OpenSCENARIO>')
    path.write_text(text[:start] + '<CatalogReference catalogName="Cars" entryName="car"/>' + text[end:])
    assert said(path) == []
    assert read_scenario(path).entities[0].entity.name == "car"
