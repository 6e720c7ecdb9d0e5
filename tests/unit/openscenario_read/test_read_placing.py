"""Where entities are put: beside others that stand somewhere, on lanes that exist; and what only a check refuses."""

from __future__ import annotations

import pytest
from xosc_samples import SCENARIO, Spoil

from openscenario.findings import Finding
from openscenario.read import check_scenario, read_scenario

AT = '<LanePosition roadId="1" laneId="-1" s="10.0"/>'


def put(private: str, position: str) -> str:
    action = f"<PrivateAction><TeleportAction><Position>{position}</Position></TeleportAction></PrivateAction>"
    return f'<Private entityRef="{private}">{action}</Private>'


def beside(other: str, ds: float = 5.0, lanes: int = 0) -> str:
    return f'<RelativeLanePosition entityRef="{other}" dLane="{lanes}" ds="{ds}"/>'


def placed(spoil: Spoil, ego: str, other: str) -> list[tuple[str, str]]:
    """Errors, as code and last step of the element, of a scenario with two cars put so."""
    entity = SCENARIO[
        SCENARIO.index("<ScenarioObject") : SCENARIO.index("</ScenarioObject>") + len("</ScenarioObject>")
    ]
    path = spoil()
    text = path.read_text(encoding="utf-8").replace(entity, entity + entity.replace('"Ego"', '"Other"'), 1)
    start, end = text.index("<Actions>") + len("<Actions>"), text.index("</Actions>")
    path.write_text(text[:start] + put("Ego", ego) + put("Other", other) + text[end:], encoding="utf-8")
    return [(f.code, f.element.rpartition("/")[2]) for f in errors(check_scenario(path))]


def errors(found: tuple[Finding, ...]) -> list[Finding]:
    return [finding for finding in found if finding.severity == "error"]


def test_a_place_beside_another_car_is_fine(spoil: Spoil) -> None:
    assert placed(spoil, AT, beside("Ego")) == []


@pytest.mark.parametrize(
    ("ego", "other", "finding"),
    [
        (AT, beside("Ego", lanes=-3), ("ref.unknown_lane", "RelativeLanePosition@dLane")),
        (AT, beside("Ego", ds=5000.0), ("road.s_out_of_range", "RelativeLanePosition@ds")),
        (AT, beside("Ego", ds=-11.0), ("road.s_out_of_range", "RelativeLanePosition@ds")),
        (AT, beside("Other"), ("ref.circle", "RelativeLanePosition@entityRef")),
    ],
    ids=["lane", "ahead", "behind", "itself"],
)
def test_a_place_that_is_none_is_found(spoil: Spoil, ego: str, other: str, finding: tuple[str, str]) -> None:
    assert placed(spoil, ego, other) == [finding]


def test_two_cars_beside_each_other_stand_nowhere(spoil: Spoil) -> None:
    assert placed(spoil, beside("Other"), beside("Ego")) == [("ref.circle", "RelativeLanePosition@entityRef")] * 2


def test_a_date_that_is_none_is_an_error_of_a_file_that_runs(spoil: Spoil) -> None:
    path = spoil('date="2026-01-01T00:00:00"', 'date="yesterday"')
    (finding,) = errors(check_scenario(path))
    assert finding.element == "OpenSCENARIO/FileHeader@date"
    assert read_scenario(path).file_header.date == "yesterday"


def test_a_parameter_twice_with_the_same_value_is_an_error_of_a_file_that_runs(spoil: Spoil) -> None:
    row = '<ParameterDeclaration name="EgoSpeed" parameterType="double" value="10.0"/>'
    path = spoil(row, row + row)
    (finding,) = errors(check_scenario(path))
    assert finding.code == "name.duplicate"
    assert len(read_scenario(path).parameter_declarations) == 2


def test_both_ends_of_a_circle_of_parameters_are_named(spoil: Spoil) -> None:
    rows = '<ParameterDeclaration name="{}" parameterType="double" value="${}"/>'
    path = spoil("<ParameterDeclarations>", "<ParameterDeclarations>" + rows.format("a", "b") + rows.format("b", "a"))
    assert [finding.code for finding in errors(check_scenario(path))] == ["param.cycle"] * 2


def test_a_catalogue_folder_outside_is_refused_even_if_nothing_is_used_of_it(spoil: Spoil) -> None:
    location = '<VehicleCatalog><Directory path="../../../etc"/></VehicleCatalog>'
    path = spoil("<CatalogLocations/>", f"<CatalogLocations>{location}</CatalogLocations>")
    (finding,) = errors(check_scenario(path))
    assert (finding.code, finding.element.rpartition("/")[2]) == ("path.outside_root", "Directory@path")


def test_neither_or_one_of_two_distances_may_be_given(spoil: Spoil) -> None:
    """Class RelativeLanePosition (1.1 to 1.3.1): ds and dsLane both have cardinality 0..1."""
    assert placed(spoil, AT, '<RelativeLanePosition entityRef="Ego" dLane="0"/>') == []
    assert placed(spoil, AT, '<RelativeLanePosition entityRef="Ego" dLane="0" dsLane="3"/>') == []
    both = '<RelativeLanePosition entityRef="Ego" dLane="0" ds="3" dsLane="3"/>'
    assert placed(spoil, AT, both) == [("xml.choice", "RelativeLanePosition")]


def test_a_place_beside_another_car_needs_its_lane_there(spoil: Spoil) -> None:
    found = placed(spoil, AT, '<RelativeLanePosition entityRef="Ego" dLane="-1"/>')
    assert found == [("ref.unknown_lane", "RelativeLanePosition@dLane")]
