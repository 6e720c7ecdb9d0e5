"""Reading a scenario: the model that comes out, versions, and the finding for each kind of defect."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from xosc_samples import Spoil, line_of

from openscenario.findings import Finding, ScenarioError
from openscenario.model import (
    CustomCommandAction,
    LaneChangeAction,
    LanePosition,
    TeleportAction,
    TransitionDynamics,
    Vehicle,
)
from openscenario.read import check_scenario, read_scenario


def findings_of(path: Path) -> tuple[Finding, ...]:
    with pytest.raises(ScenarioError) as caught:
        read_scenario(path)
    return caught.value.findings


def test_the_model_is_named_as_the_standard(spoil: Spoil) -> None:
    path = spoil()
    scenario = read_scenario(path)
    ego = scenario.entities[0]
    assert (ego.name, ego.kind, ego.category) == ("Ego", "vehicle", "car")
    assert isinstance(ego.entity, Vehicle)
    assert ego.entity.axles.front_axle is not None
    assert ego.entity.axles.front_axle.position_x == 2.8
    assert scenario.road_network.logic_file == path.parent / "road.xodr"
    teleport = scenario.storyboard.init.actions.privates[0].private_actions[0]
    assert teleport == TeleportAction(LanePosition("1", -1, 50.0))
    event = scenario.storyboard.stories[0].acts[0].maneuver_groups[0].maneuvers[0].events[0]
    assert isinstance(event.actions[0].action, LaneChangeAction)
    assert event.actions[0].action.lane_change_action_dynamics == TransitionDynamics("sinusoidal", "time", 3.0)


def test_elements_know_their_place_and_do_not_compare_by_it(spoil: Spoil) -> None:
    path = spoil()
    event = read_scenario(path).storyboard.stories[0].acts[0].maneuver_groups[0].maneuvers[0].events[0]
    assert (event.at.file, event.at.line) == (str(path), line_of(path, "<Event "))
    assert event.at.element.endswith("Maneuver[maneuver]/Event[event]")
    moved = spoil("<Entities>", "\n\n<Entities>")
    assert read_scenario(moved).storyboard.stories[0].acts[0].maneuver_groups[0].maneuvers[0].events[0] == event


@pytest.mark.parametrize("minor", ["0", "1", "2", "3"])
def test_versions_1_0_to_1_3_are_read(spoil: Spoil, minor: str) -> None:
    assert read_scenario(spoil('revMinor="2"', f'revMinor="{minor}"')).file_header.rev_minor == int(minor)


@pytest.mark.parametrize("word", ["overwrite", "override"])
def test_the_priority_has_two_spellings_and_one_meaning(spoil: Spoil, word: str) -> None:
    scenario = read_scenario(spoil('priority="overwrite"', f'priority="{word}"'))
    assert scenario.storyboard.stories[0].acts[0].maneuver_groups[0].maneuvers[0].events[0].priority == "override"


@pytest.mark.parametrize(
    ("elevation", "wrong"), [("1.5708", False), ("-3.1416", False), ("3.1416", False), ("60", True), ("-10.00", True)]
)
def test_a_sun_in_degrees_is_warned_of(spoil: Spoil, elevation: str, wrong: bool) -> None:
    """Taken as radians, 60 is below the horizon: a camera would see as in the night."""
    sun = f'<Sun azimuth="0" elevation="{elevation}" illuminance="100000"/>'
    weather = f'<Environment name="e"><Weather>{sun}</Weather></Environment>'
    action = f"<GlobalAction><EnvironmentAction>{weather}</EnvironmentAction></GlobalAction>"
    found = check_scenario(spoil("<Actions>", f"<Actions>{action}"))
    element = "OpenSCENARIO/Storyboard/Init/Actions/GlobalAction/EnvironmentAction/Environment[e]/Weather/Sun@elevation"
    expected = [("value.out_of_range", element, "warning")] * wrong
    assert [(each.code, each.element, each.severity) for each in found] == expected


def test_a_future_version_lists_the_known_ones_and_nothing_else(spoil: Spoil) -> None:
    (finding,) = findings_of(spoil('revMinor="2"', 'revMinor="99"'))
    assert (finding.code, finding.element) == ("version.unsupported", "OpenSCENARIO/FileHeader@revMinor")
    assert "1.0, 1.1, 1.2, 1.3" in finding.message


def test_the_hash_changes_with_the_file(spoil: Spoil) -> None:
    first = read_scenario(spoil()).sha256
    assert read_scenario(spoil()).sha256 == first
    assert read_scenario(spoil('value="3.0"', 'value="3.1"')).sha256 != first


@pytest.mark.parametrize(
    ("old", "new", "code", "element"),
    [
        ('entityRef="Ego">', 'entityRef="Eco">', "reference_control.resolvable_entity_references", "Private@entityRef"),
        ('roadId="1"', 'roadId="2"', "ref.unknown_road", "LanePosition@roadId"),
        ('laneId="-1"', 'laneId="1"', "ref.unknown_lane", "LanePosition@laneId"),
        ('laneId="-1"', 'laneId="x"', "value.not_a_number", "LanePosition@laneId"),
        ('laneId="-1"', 'laneId="-1.5"', "value.not_an_integer", "LanePosition@laneId"),
        ('s="50.0"', 's="600"', "road.s_out_of_range", "LanePosition@s"),
        ('s="50.0"', 's="-1"', "value.out_of_range", "LanePosition@s"),
        ('s="50.0"', 's="${10/0}"', "expr.division_by_zero", "LanePosition@s"),
        ('s="50.0"', "", "xml.missing_attribute", "LanePosition@s"),
        ('s="50.0"', 's="50.0" lane="1"', "xml.unknown_attribute", "LanePosition@lane"),
        ('value="$EgoSpeed"', 'value="NaN"', "value.not_finite", "AbsoluteTargetSpeed@value"),
        ('value="$EgoSpeed"', 'value="-inf"', "value.not_finite", "AbsoluteTargetSpeed@value"),
        ('value="3.0"', 'value="-3.0"', "value.out_of_range", "LaneChangeActionDynamics@value"),
        ('"sinusoidal"', '"sinus"', "value.not_allowed", "LaneChangeActionDynamics@dynamicsShape"),
        ('positionX="2.8"', 'positionX="0.0"', "value.out_of_range", "FrontAxle@positionX"),
        ('length="4.5"', 'length="-4.5"', "value.out_of_range", "Dimensions@length"),
        ('wheelDiameter="0.6"', 'wheelDiameter="0"', "value.out_of_range", "FrontAxle@wheelDiameter"),
        ('vehicleCategory="car"', 'vehicleCategory="cart"', "value.not_allowed", "@vehicleCategory"),
        ('selectTriggeringEntities="false"', 'selectTriggeringEntities="no"', "value.not_a_boolean", "Actors@select"),
        ('delay="0"', 'delay="-1"', "value.out_of_range", "[later]@delay"),
        ("<AbsoluteTargetLane ", "<AbsoluteTragetLane ", "xml.unknown_element", "LaneChangeTarget/AbsoluteTragetLane"),
        ('<AbsoluteTargetLane value="-1"/>', "", "xml.missing_element", "LaneChangeAction/LaneChangeTarget"),
        (
            '<SimulationTimeCondition value="1.0" rule="greaterThan"/>',
            "",
            "xml.missing_element",
            "[later]/ByValueCondition",
        ),
        (
            '<PrivateAction><TeleportAction><Position>\n            <LanePosition roadId="1" laneId="-1" s="50.0"/>\n'
            "          </Position></TeleportAction></PrivateAction>",
            "<PrivateAction/>",
            "xml.missing_element",
            "Private/PrivateAction",
        ),
        ("<Entities>", "<Entities>here they are:", "xml.unexpected_text", "OpenSCENARIO/Entities"),
        (
            '<LanePosition roadId="1" laneId="-1" s="50.0"/>',
            '<GeoPosition latitudeDeg="95" longitudeDeg="10"/>',
            "value.out_of_range",
            "GeoPosition@latitudeDeg",
        ),
        (
            "<Actions>",
            '<Actions><GlobalAction><ParameterAction parameterRef="EgoSpeed"><SetAction value="fast"/>'
            "</ParameterAction></GlobalAction>",
            "value.not_a_number",
            "SetAction@value",
        ),
        (
            '<SimulationTimeCondition value="1.0" rule="greaterThan"/>',
            '<ParameterCondition parameterRef="EgoSpeed" rule="equalTo" value="fast"/>',
            "value.not_a_number",
            "ParameterCondition@value",
        ),
        ('<EntityRef entityRef="Ego"/>', "", "reference_control.valid_actor_reference_in_private_actions", "[group]"),
        ('maximumExecutionCount="1"', 'maximumExecutionCount="0"', "value.out_of_range", "@maximumExecutionCount"),
        ('filepath="road.xodr"', 'filepath="raod.xodr"', "path.not_found", "LogicFile@filepath"),
        ('filepath="road.xodr"', 'filepath="../road.xodr"', "path.outside_root", "LogicFile@filepath"),
    ],
)
def test_one_defect_gives_one_finding_at_its_place(spoil: Spoil, old: str, new: str, code: str, element: str) -> None:
    path = spoil(old, new)
    (finding,) = findings_of(path)
    assert (finding.code, finding.severity, finding.file) == (code, "error", str(path))
    assert element in finding.element
    assert finding.line is not None
    assert element.split("@")[0].split("/")[-1].strip("[]") in path.read_text().splitlines()[finding.line - 1]


@pytest.mark.parametrize(
    ("old", "new", "hint"),
    [
        ('entityRef="Ego">', 'entityRef="Egi">', "'Ego'"),
        ("<AbsoluteTargetLane ", "<AbsoluteTragetLane ", "'AbsoluteTargetLane'"),
        ('"sinusoidal"', '"sinusodial"', "'sinusoidal'"),
        ('s="50.0"', 's="50.0" ofset="1"', "'offset'"),
        ('filepath="road.xodr"', 'filepath="rod.xodr"', "'road.xodr'"),
        ("<Storyboard>", "<Storyboards/><Storyboard>", "'Storyboard'"),
    ],
)
def test_the_nearest_name_is_offered(spoil: Spoil, old: str, new: str, hint: str) -> None:
    assert hint in findings_of(spoil(old, new))[0].hint


def test_all_findings_come_at_once_in_the_order_of_the_file(spoil: Spoil) -> None:
    path = spoil('length="4.5"', 'length="-4.5"')
    path.write_text(path.read_text().replace('"sinusoidal"', '"sinus"').replace('s="50.0"', 's="x"'))
    findings = findings_of(path)
    assert [finding.code for finding in findings] == ["value.out_of_range", "value.not_a_number", "value.not_allowed"]
    assert [finding.line for finding in findings] == sorted(finding.line or 0 for finding in findings)


def test_two_entities_of_one_name_are_found_at_the_second(spoil: Spoil) -> None:
    path = spoil()
    text = path.read_text()
    start, end = text.index("    <ScenarioObject"), text.index("  </Entities>")
    path.write_text(text[:end] + text[start:end] + text[end:])
    (finding,) = findings_of(path)
    assert (finding.code, finding.line) == ("name.duplicate", line_of(path, "</ScenarioObject>") + 1)


@pytest.mark.parametrize(
    ("kind", "name", "attribute"),
    [
        ("event", "evnt", "storyboardElementRef"),
        ("act", "event", "storyboardElementType"),
    ],
)
def test_a_condition_on_a_storyboard_element_that_is_not_there(
    spoil: Spoil, kind: str, name: str, attribute: str
) -> None:
    condition = (
        f'<StoryboardElementStateCondition storyboardElementType="{kind}" storyboardElementRef="{name}" '
        'state="completeState"/>'
    )
    (finding,) = findings_of(spoil('<SimulationTimeCondition value="1.0" rule="greaterThan"/>', condition))
    assert finding.code == "reference_control.resolvable_storyboard_element_reference"
    assert finding.element.endswith(f"StoryboardElementStateCondition@{attribute}")


@pytest.mark.parametrize("name", ["event", "maneuver::event", "story::act::group::maneuver::event"])
def test_a_storyboard_element_may_be_named_with_its_path(spoil: Spoil, name: str) -> None:
    condition = (
        f'<StoryboardElementStateCondition storyboardElementType="event" storyboardElementRef="{name}" '
        'state="completeState"/>'
    )
    read_scenario(spoil('<SimulationTimeCondition value="1.0" rule="greaterThan"/>', condition))


def test_an_action_without_content_does_nothing_and_is_a_warning(spoil: Spoil) -> None:
    path = spoil()
    text = path.read_text()
    start, end = text.index('<Action name="action">'), text.index("</Action>")
    path.write_text(text[:start] + '<Action name="action">' + text[end:])
    event = read_scenario(path).storyboard.stories[0].acts[0].maneuver_groups[0].maneuvers[0].events[0]
    assert event.actions[0].action == CustomCommandAction("")
    assert [finding.severity for finding in check_scenario(path)] == ["warning"]


def test_a_steering_angle_in_degrees_is_a_warning(spoil: Spoil) -> None:
    (finding,) = check_scenario(spoil('maxSteering="0.5"', 'maxSteering="30"'))
    assert (finding.severity, finding.element.split("/")[-1]) == ("warning", "FrontAxle@maxSteering")


def test_a_negative_rate_counts_as_its_magnitude_and_is_a_warning(spoil: Spoil) -> None:
    path = spoil('value="0.0" dynamicsDimension="time"', 'value="-4.0" dynamicsDimension="rate"')
    read_scenario(path)
    assert [(finding.code, finding.severity) for finding in check_scenario(path)] == [
        ("value.negative_rate", "warning")
    ]


@pytest.mark.parametrize(("rule", "said"), [("greaterThan", "true from the start"), ("lessOrEqual", "never true")])
def test_a_time_before_the_start_is_a_warning_that_says_what_it_means(spoil: Spoil, rule: str, said: str) -> None:
    written = f'<SimulationTimeCondition value="-5" rule="{rule}"/>'
    found = check_scenario(spoil('<SimulationTimeCondition value="1.0" rule="greaterThan"/>', written))
    # the event that never starts keeps the scenario from ending: a finding of its own
    (finding,) = [each for each in found if each.code != "storyboard.never_ends"]
    assert (finding.severity, finding.element.split("/")[-1]) == ("warning", "SimulationTimeCondition@value")
    assert said in finding.message


@pytest.mark.parametrize(
    ("root", "advice"),
    [("osm", "lanelet2"), ("commonRoad", "CommonRoad"), ("OpenDRIVE", "LogicFile"), ("OpenSCENARIOS", "OpenSCENARIO")],
)
def test_other_formats_are_refused_by_name(tmp_path: Path, root: str, advice: str) -> None:
    path = tmp_path / "x.xosc"
    path.write_text(f"<{root}/>")
    (finding,) = check_scenario(path)
    assert advice in finding.message


def test_the_scenario_language_is_refused_by_name(tmp_path: Path) -> None:
    path = tmp_path / "x.osc"
    path.write_text("import osc.standard.all")
    assert [finding.code for finding in check_scenario(path)] == ["format.unsupported"]


def test_a_file_without_findings_gives_none(spoil: Spoil) -> None:
    assert check_scenario(spoil()) == ()


def test_a_message_is_one_line_however_long_the_value(spoil: Spoil) -> None:
    (finding,) = findings_of(spoil('s="50.0"', 's="' + "9x" * 5000 + '"'))
    assert len(str(finding)) < 500
    assert "\n" not in str(finding)


def test_reading_imports_neither_numba_nor_pandas() -> None:
    program = (
        "import sys, openscenario.read, openscenario.write; "
        "print([m for m in ('numba', 'pandas', 'scipy', 'numpy') if m in sys.modules])"
    )
    assert subprocess.run([sys.executable, "-c", program], capture_output=True, text=True).stdout.strip() == "[]"


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ('<?xml version="1.0"?>\n<!-- a map -->\n<osm version="0.6"/>', "<osm>"),
        ("<OpenSCENARIO/>", "<OpenSCENARIO>"),
        ("a picture", "no XML"),
    ],
)
def test_a_logic_file_of_another_kind_is_one_finding_at_the_logic_file(spoil: Spoil, text: str, found: str) -> None:
    path = spoil()
    (path.parent / "road.xodr").write_text(text)
    (finding,) = findings_of(path)
    assert finding.code == "asam.net:xodr:1.0.0:xml.root_tag_is_opendrive"
    assert finding.element.endswith("LogicFile@filepath")
    assert (finding.file, finding.found, finding.allowed) == (str(path), found, "<OpenDRIVE>")


def test_a_road_with_a_doctype_is_refused_for_that(spoil: Spoil) -> None:
    path = spoil()
    road = path.parent / "road.xodr"
    road.write_text("<!DOCTYPE OpenDRIVE>\n" + road.read_text())
    (finding,) = findings_of(path)
    assert (finding.code, finding.file, finding.line) == ("xml.dtd_forbidden", str(road), 1)


def test_a_missing_road_shows_what_is_there_and_both_ways_out(spoil: Spoil) -> None:
    path = spoil('filepath="road.xodr"', 'filepath="rood.xodr"')
    (finding,) = findings_of(path)
    assert str(path.parent.resolve() / "rood.xodr") in finding.message
    assert f"looked in {path.parent.resolve()} only, there: road.xodr" in finding.message
    assert "copy the file beside the scenario" in finding.hint
    assert "--library" in finding.hint


def test_a_wrong_name_that_came_in_through_a_parameter_says_from_where(spoil: Spoil) -> None:
    """It shows where it is used, and is mended where the parameter got it."""
    path = spoil('<Private entityRef="Ego">', '<Private entityRef="$owner">')
    text = path.read_text()
    declared = '<ParameterDeclaration name="owner" parameterType="string" value="Eco"/>\n'
    at = "<ParameterDeclarations>"
    path.write_text(text.replace(at, f"{at}\n{declared}", 1))
    line = next(n for n, row in enumerate(path.read_text().splitlines(), start=1) if declared.strip() in row)
    found = next(each for each in check_scenario(path) if each.element.endswith("Private@entityRef"))
    assert f"(from $owner, line {line}; did you mean 'Ego'?)" in found.message
