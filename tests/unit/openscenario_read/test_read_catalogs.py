"""Catalogue references: found, filled with parameters, kept inside the allowed folders."""

from __future__ import annotations

from pathlib import Path

import pytest
from xosc_samples import SCENARIO, Spoil, line_of

from openscenario.findings import Finding, ScenarioError
from openscenario.model import Scenario, Vehicle
from openscenario.read import check_scenario, read_scenario

VEHICLE = SCENARIO[SCENARIO.index("      <Vehicle ") : SCENARIO.index("    </ScenarioObject>")]
LOCATIONS = "<CatalogLocations><VehicleCatalog><Directory path='{}'/></VehicleCatalog></CatalogLocations>"


def catalog(folder: Path, entries: str, name: str = "cars") -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{name}.xosc"
    path.write_text(
        '<OpenSCENARIO>\n<FileHeader revMajor="1" revMinor="2" date="2026-01-01" description="c" author="t"/>\n'
        f'<Catalog name="{name}">\n{entries}\n</Catalog></OpenSCENARIO>'
    )
    return path


def using(spoil: Spoil, reference: str = "", folder: str = "catalogs") -> Path:
    path = spoil(VEHICLE, reference or '<CatalogReference catalogName="cars" entryName="car"/>\n')
    path.write_text(path.read_text().replace("<CatalogLocations/>", LOCATIONS.format(folder)))
    return path


def vehicle(scenario: Scenario) -> Vehicle:
    assert isinstance(scenario.entities[0].entity, Vehicle)
    return scenario.entities[0].entity


def findings_of(path: Path, **options: object) -> tuple[Finding, ...]:
    with pytest.raises(ScenarioError) as caught:
        read_scenario(path, **options)  # type: ignore[arg-type]
    return caught.value.findings


def parametrized(extra: str = "") -> str:
    declarations = (
        '<ParameterDeclarations><ParameterDeclaration name="length" parameterType="double" value="4.5"/>'
        f"{extra}</ParameterDeclarations>"
    )
    entry = VEHICLE.replace('length="4.5"', 'length="$length"')
    return entry.replace("<BoundingBox>", declarations + "<BoundingBox>", 1)


def test_the_entry_stands_in_place_of_the_reference(spoil: Spoil) -> None:
    path = using(spoil)
    catalog(path.parent / "catalogs", VEHICLE)
    assert read_scenario(path).entities[0] == read_scenario(spoil()).entities[0]


def test_the_entry_knows_its_place_in_the_catalogue(spoil: Spoil) -> None:
    path = using(spoil)
    where = catalog(path.parent / "catalogs", VEHICLE)
    at = vehicle(read_scenario(path)).at
    assert (at.file, at.line, at.element) == (str(where), 4, "OpenSCENARIO/Catalog/Vehicle[car]")


def test_an_assignment_replaces_the_default_of_the_entry(spoil: Spoil) -> None:
    reference = (
        '<CatalogReference catalogName="cars" entryName="car"><ParameterAssignments>'
        '<ParameterAssignment parameterRef="length" value="${$EgoSpeed / 2}"/>'
        "</ParameterAssignments></CatalogReference>\n"
    )
    path = using(spoil, reference)
    catalog(path.parent / "catalogs", parametrized())
    assert vehicle(read_scenario(path)).bounding_box.dimensions.length == 5.0


def test_a_parameter_of_the_scenario_is_not_seen_by_the_entry_without_a_warning(spoil: Spoil) -> None:
    path = using(spoil)
    catalog(path.parent / "catalogs", VEHICLE.replace('length="4.5"', 'length="$EgoSpeed"'))
    assert vehicle(read_scenario(path)).bounding_box.dimensions.length == 10.0
    (warning,) = check_scenario(path)
    assert warning.code == "parameters.valid_parameter_declaration_in_catalogs"


@pytest.mark.parametrize(
    ("reference", "code", "hint"),
    [
        ('catalogName="crs" entryName="car"', "catalog.unknown", "'cars'"),
        ('catalogName="cars" entryName="cat"', "catalog.unknown_entry", "'car'"),
    ],
)
def test_an_unknown_name_is_found_at_the_reference_with_the_nearest_one(
    spoil: Spoil, reference: str, code: str, hint: str
) -> None:
    path = using(spoil, f"<CatalogReference {reference}/>\n")
    catalog(path.parent / "catalogs", VEHICLE)
    finding = findings_of(path)[0]
    assert (finding.code, finding.line) == (code, line_of(path, "<CatalogReference"))
    assert hint in finding.hint


def test_an_entry_of_another_kind_is_refused(spoil: Spoil) -> None:
    path = using(spoil)
    catalog(path.parent / "catalogs", '<Controller name="car"><Properties/></Controller>')
    assert findings_of(path)[0].code == "catalog.wrong_kind"


def test_a_defect_in_an_entry_is_found_in_the_catalogue(spoil: Spoil) -> None:
    path = using(spoil)
    where = catalog(path.parent / "catalogs", VEHICLE.replace('length="4.5"', 'length="-4.5"'))
    (finding,) = findings_of(path)
    assert (finding.file, finding.line) == (str(where), line_of(where, "-4.5"))


@pytest.mark.parametrize("folder", ["../outside", "/etc", "..%2foutside", "http://127.0.0.1:9/"])
def test_a_catalogue_outside_the_allowed_folders_is_refused_at_its_location(
    spoil: Spoil, tmp_path: Path, folder: str
) -> None:
    catalog(tmp_path.parent / "outside", VEHICLE)
    path = using(spoil, folder=folder)
    (finding,) = findings_of(path)
    assert finding.code in ("path.outside_root", "path.scheme_forbidden")
    assert finding.element.endswith("VehicleCatalog/Directory@path")


def test_a_declared_library_opens_its_folder(spoil: Spoil, tmp_path_factory: pytest.TempPathFactory) -> None:
    library = tmp_path_factory.mktemp("library")
    catalog(library, VEHICLE)
    path = using(spoil, folder=str(library))
    assert vehicle(read_scenario(path, library=[library])).name == "car"
    assert findings_of(path)[0].code == "path.outside_root"


def test_a_catalogue_is_known_by_its_file_name_as_well(spoil: Spoil) -> None:
    path = using(spoil)
    where = catalog(path.parent / "catalogs", VEHICLE)
    where.write_text(where.read_text().replace('<Catalog name="cars">', '<Catalog name="Other">'))
    assert vehicle(read_scenario(path)).name == "car"


def test_a_changed_catalogue_changes_the_hash(spoil: Spoil) -> None:
    path = using(spoil)
    catalog(path.parent / "catalogs", VEHICLE)
    first = read_scenario(path).sha256
    catalog(path.parent / "catalogs", VEHICLE.replace("4.5", "4.6"))
    assert read_scenario(path).sha256 != first


def test_a_catalogue_can_be_checked_by_itself(tmp_path: Path) -> None:
    path = catalog(tmp_path, VEHICLE + VEHICLE.replace('length="4.5"', 'length="$length"'))
    assert [finding.code for finding in check_scenario(path)] == [
        "reference_control.uniquely_resolvable_entity_references",
        "param.undefined",
    ]


def test_a_catalogue_is_no_scenario(tmp_path: Path) -> None:
    assert findings_of(catalog(tmp_path, VEHICLE))[0].code == "file.not_a_scenario"


def test_a_catalogue_that_cannot_be_read_is_said_to_be_that_and_not_missing(spoil: Spoil) -> None:
    path = using(spoil)
    broken = catalog(path.parent / "catalogs", VEHICLE, name="all")
    broken.write_text(broken.read_text().replace('name="all"', 'name="cars"').replace("</Catalog>", ""))
    (finding,) = findings_of(path)
    assert (finding.code, Path(finding.file).name) == ("xml.not_well_formed", "all.xosc")


def test_two_entries_of_one_name_are_found_at_the_second(spoil: Spoil) -> None:
    path = using(spoil)
    twice = catalog(path.parent / "catalogs", VEHICLE + "\n" + VEHICLE)
    (finding,) = findings_of(path)
    place = Path(finding.file).name, finding.line, finding.element
    second = twice.read_text().count("\n", 0, twice.read_text().rindex("<Vehicle ")) + 1
    assert place == ("cars.xosc", second, "OpenSCENARIO/Catalog/Vehicle[2]@name")


def test_a_parameter_of_an_entry_is_given_one_value(spoil: Spoil) -> None:
    given = "".join(f'<ParameterAssignment parameterRef="length" value="{value}"/>' for value in (4, 5))
    reference = (
        '<CatalogReference catalogName="cars" entryName="car">'
        f"<ParameterAssignments>{given}</ParameterAssignments></CatalogReference>"
    )
    path = using(spoil, reference)
    catalog(path.parent / "catalogs", parametrized())
    (finding,) = findings_of(path)
    assert (finding.code, finding.element.rpartition("/")[2]) == (
        "name.duplicate",
        "ParameterAssignment@parameterRef",
    )
