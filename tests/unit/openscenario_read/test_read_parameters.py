"""Parameters of a scenario: scopes, values from outside, constraints, and what the findings say."""

from __future__ import annotations

from typing import Any

import pytest
from xosc_samples import Spoil, line_of

from openscenario.findings import Finding, ScenarioError
from openscenario.model import AbsoluteTargetSpeed, ParameterDeclaration, Scenario, SpeedAction
from openscenario.read import check_scenario, read_declarations, read_scenario

DECLARED = '<ParameterDeclaration name="EgoSpeed" parameterType="double" value="10.0"/>'


def ego_speed(scenario: Scenario) -> float:
    action = scenario.storyboard.init.actions.privates[0].private_actions[1]
    assert isinstance(action, SpeedAction)
    assert isinstance(action.speed_action_target, AbsoluteTargetSpeed)
    return action.speed_action_target.value


def findings_of(path: Any, **options: Any) -> tuple[Finding, ...]:
    with pytest.raises(ScenarioError) as caught:
        read_scenario(path, **options)
    return caught.value.findings


def declared(name: str = "EgoSpeed", kind: str = "double", value: str = "10.0", inside: str = "") -> str:
    return f'<ParameterDeclaration name="{name}" parameterType="{kind}" value="{value}">{inside}</ParameterDeclaration>'


def constraint(*groups: list[tuple[str, str]]) -> str:
    return "".join(
        "<ConstraintGroup>"
        + "".join(f'<ValueConstraint rule="{rule}" value="{value}"/>' for rule, value in group)
        + "</ConstraintGroup>"
        for group in groups
    )


def test_a_reference_takes_the_declared_value(spoil: Spoil) -> None:
    assert ego_speed(read_scenario(spoil())) == 10.0


@pytest.mark.parametrize("given", [12.5, "12.5"])
def test_a_value_from_outside_overrides_the_declared_one(spoil: Spoil, given: object) -> None:
    scenario = read_scenario(spoil(), parameters={"EgoSpeed": given})  # type: ignore[dict-item]
    assert ego_speed(scenario) == 12.5
    assert scenario.parameter_declarations[0].value == "12.5"


def test_what_is_computed_from_a_parameter_follows_the_value_from_outside(spoil: Spoil) -> None:
    path = spoil(DECLARED, declared(value="${$kmh / 3.6}") + declared("kmh", value="36"))
    assert ego_speed(read_scenario(path)) == 10.0
    assert ego_speed(read_scenario(path, parameters={"kmh": 72})) == 20.0


def test_an_inner_scope_hides_the_outer_one(spoil: Spoil) -> None:
    story = '<Story name="story"><ParameterDeclarations>' + declared("lane", "int", "-1") + "</ParameterDeclarations>"
    path = spoil('<Story name="story">', story)
    text = path.read_text().replace(DECLARED, DECLARED + declared("lane", "int", "7"))
    path.write_text(text.replace('<AbsoluteTargetLane value="-1"/>', '<AbsoluteTargetLane value="$lane"/>'))
    action = (
        read_scenario(path).storyboard.stories[0].acts[0].maneuver_groups[0].maneuvers[0].events[0].actions[0].action
    )
    assert action.lane_change_target.value == -1  # type: ignore[union-attr]


def test_a_misspelt_reference_names_the_nearest_parameter(spoil: Spoil) -> None:
    path = spoil('"$EgoSpeed"', '"$EgoSped"')
    (finding,) = findings_of(path)
    assert (finding.code, finding.line) == ("param.undefined", line_of(path, "$EgoSped"))
    assert finding.element.endswith("AbsoluteTargetSpeed@value")
    assert "$EgoSpeed" in finding.message


def test_an_unknown_value_from_outside_names_the_nearest_parameter(spoil: Spoil) -> None:
    (finding,) = findings_of(spoil(), parameters={"ego_speed": 1.0})
    assert finding.code == "param.undefined"
    assert "EgoSpeed" in finding.message


@pytest.mark.parametrize(
    ("value", "code"),
    [
        ("", "value.not_a_number"),
        ("fast", "value.not_a_number"),
        ("10 m/s", "value.not_a_number"),
        ("nan", "value.not_finite"),
        ("INF", "value.not_finite"),
        ("1e308", "value.out_of_range"),
        ("1_0", "value.not_a_number"),
        ("١٠", "value.not_a_number"),
    ],
)
def test_a_value_that_is_no_number_is_found_at_its_declaration_and_nowhere_else(
    spoil: Spoil, value: str, code: str
) -> None:
    path = spoil(DECLARED, declared(value=value))
    (finding,) = findings_of(path)
    assert (finding.code, finding.line) == (code, line_of(path, '"EgoSpeed"'))
    assert finding.element.endswith("ParameterDeclaration[EgoSpeed]@value")


def test_parameters_that_depend_on_each_other_are_a_finding(spoil: Spoil) -> None:
    path = spoil(DECLARED, declared(value="$other") + declared("other", value="$EgoSpeed"))
    assert "param.cycle" in {finding.code for finding in findings_of(path)}


def test_the_same_name_with_two_values_is_a_finding(spoil: Spoil) -> None:
    path = spoil(DECLARED, declared() + declared(value="11.0"))
    assert [finding.code for finding in findings_of(path)] == ["name.duplicate"]


@pytest.mark.parametrize(("value", "allowed"), [(4.9, False), (5.0, True), (15.0, True), (15.1, False), (30.0, True)])
def test_a_value_meets_all_constraints_of_one_group(spoil: Spoil, value: float, allowed: bool) -> None:
    groups = constraint([("greaterOrEqual", "5.0"), ("lessOrEqual", "15.0")], [("equalTo", "30.0")])
    path = spoil(DECLARED, declared(inside=groups))
    if allowed:
        assert ego_speed(read_scenario(path, parameters={"EgoSpeed": value})) == value
    else:
        (finding,) = findings_of(path, parameters={"EgoSpeed": value})
        assert finding.code == "param.outside_constraint"
        assert ">= 5.0 and <= 15.0 or = 30.0" in finding.message


def test_declarations_can_be_read_alone(spoil: Spoil) -> None:
    path = spoil(DECLARED, declared(inside=constraint([("lessThan", "20")])))
    (declaration,) = read_declarations(path)
    assert isinstance(declaration, ParameterDeclaration)
    assert (declaration.name, declaration.parameter_type, declaration.value) == ("EgoSpeed", "double", "10.0")
    assert declaration.constraint_groups[0].value_constraints[0].rule == "lessThan"


@pytest.mark.parametrize(
    ("kind", "value", "code"),
    [
        ("integer", "1.5", "value.not_an_integer"),
        ("unsignedShort", "65536", "value.out_of_range"),
        ("unsignedInt", "-1", "value.out_of_range"),
        ("boolean", "maybe", "value.not_a_boolean"),
        ("dateTime", "yesterday", "value.not_a_moment"),
        ("number", "1", "value.not_allowed"),
    ],
)
def test_a_value_fits_the_type_of_its_declaration(spoil: Spoil, kind: str, value: str, code: str) -> None:
    assert [f.code for f in findings_of(spoil(DECLARED, DECLARED + declared("p", kind, value)))] == [code]


def test_a_parameter_declared_with_its_dollar_is_the_one_without(spoil: Spoil) -> None:
    path = spoil(DECLARED, declared("$EgoSpeed", value="12.5"))
    assert ego_speed(read_scenario(path)) == 12.5
    (finding,) = check_scenario(path)
    assert (finding.severity, finding.code, finding.found) == ("warning", "param.name", "$EgoSpeed")


@pytest.mark.parametrize(
    ("kind", "codes"),
    [("string", ["value.not_a_number"]), ("boolean", ["value.not_a_number"]), ("int", []), ("double", [])],
)
@pytest.mark.parametrize("rule", ['<AddValue value="1"/>', '<MultiplyByValue value="2"/>'])
@pytest.mark.parametrize("what", ["Parameter", "Variable"])
def test_only_a_number_is_calculated_with(spoil: Spoil, kind: str, codes: list[str], rule: str, what: str) -> None:
    """The run left a text as it was, and made a number of a boolean."""
    action = (
        f'<Actions><GlobalAction><{what}Action {what.lower()}Ref="p"><ModifyAction><Rule>'
        f"{rule}</Rule></ModifyAction></{what}Action></GlobalAction>"
    )
    variable = f'<VariableDeclaration name="p" variableType="{kind}" value="1"/>'
    path = spoil("<Actions>", action)
    text = path.read_text()
    if what == "Parameter":
        text = text.replace(DECLARED, DECLARED + declared("p", kind, "1"), 1)
    else:
        end = "</ParameterDeclarations>"
        text = text.replace(end, f"{end}<VariableDeclarations>{variable}</VariableDeclarations>", 1)
    path.write_text(text)
    found = [finding for finding in check_scenario(path) if finding.severity == "error"]
    assert [finding.code for finding in found] == codes
    for finding in found:
        assert finding.line == line_of(path, "<ModifyAction>")
        assert (finding.found, finding.allowed) == (kind, "double, int, unsignedInt, unsignedShort")
