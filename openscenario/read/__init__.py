"""Reading scenario files: file -> model, or findings."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final, TypeAlias

from openscenario.distributions import Cases, cases_of
from openscenario.findings import Finding, Findings, ScenarioError
from openscenario.model.catalog_file import CatalogFile
from openscenario.model.declarations import ParameterDeclaration
from openscenario.model.distributions import DistributionFile
from openscenario.model.scenario import Scenario
from openscenario.read.distribution import is_distribution, read_distribution_file, refuse
from openscenario.read.scenario import declarations_of, open_reading, read_catalog_file, read_sections, texts

AnyPath: TypeAlias = str | os.PathLike[str]

# What breaks a rule of the standard and still has one meaning: a warning when the file is run, an error when checked.
_STRICT: Final = (
    *("name.duplicate", "reference_control.unique_element_names_on_same_level", "value.not_a_moment"),
    *("path.outside_root", "path.scheme_forbidden", "path.too_long"),  # of a catalogue of which nothing is used
)

__all__ = ["check_scenario", "read_cases", "read_catalog", "read_declarations", "read_distribution", "read_scenario"]


def read_scenario(
    path: AnyPath,
    *,
    library: Sequence[AnyPath] = (),
    rootdir: AnyPath | None = None,
    parameters: Mapping[str, str | float | bool] | None = None,
) -> Scenario:
    """Reads a scenario with its catalogues; parameters, expressions and references are resolved.

    Args:
        path: the `.xosc` file.
        library: folders, besides the scenario's own, that it may reach into.
        rootdir: one more such folder: pytest's rootdir.
        parameters: values in place of the declared ones, by name.

    Raises:
        ScenarioError: with all findings, if one of them is an error.
    """
    findings = Findings()
    scenario = None
    reading = open_reading(Path(path), _folders(library), _folder(rootdir), findings)
    if reading is not None:
        scenario = read_sections(reading, texts(parameters or {}))
    if scenario is None:
        raise refuse(findings)
    return scenario


def read_catalog(path: AnyPath, *, library: Sequence[AnyPath] = (), rootdir: AnyPath | None = None) -> CatalogFile:
    """Reads a catalogue file, each entry with the default values of its parameters.

    Raises:
        ScenarioError: with all findings, if one of them is an error.
    """
    findings = Findings()
    reading = open_reading(Path(path), _folders(library), _folder(rootdir), findings)
    if reading is not None and reading.root.find("Catalog") is None:
        reading.context.error("file.not_a_catalog", reading.at(), "", "it is no catalogue", allowed="<Catalog>")
    file = None if reading is None else read_catalog_file(reading)
    if file is None and reading is not None and not findings.errors:
        text = "an entry refers to another catalogue, and only a scenario says where that lies"
        reading.context.error("catalog.not_alone", reading.at(), "", text)
    if file is None:
        raise refuse(findings)
    return file


def read_distribution(
    path: AnyPath, *, library: Sequence[AnyPath] = (), rootdir: AnyPath | None = None
) -> DistributionFile:
    """Reads a parameter value distribution and checks it against the scenario that it varies.

    Raises:
        ScenarioError: with all findings, if one of them is an error.
    """
    return _distribution(path, library, rootdir)[0]


def read_cases(
    path: AnyPath, *, library: Sequence[AnyPath] = (), rootdir: AnyPath | None = None, seed: int = 7
) -> Cases:
    """The cases of a parameter value distribution: their number at once, each one when it is asked for.

    Args:
        seed: of a stochastic distribution that names none.

    Raises:
        ScenarioError: as `read_distribution`.
    """
    file, declared = _distribution(path, library, rootdir)
    return cases_of(file, declared, seed=seed)


def _distribution(
    path: AnyPath, library: Sequence[AnyPath], rootdir: AnyPath | None
) -> tuple[DistributionFile, tuple[ParameterDeclaration, ...]]:
    findings = Findings()
    reading = open_reading(Path(path), _folders(library), _folder(rootdir), findings)
    file: DistributionFile | None = None
    declared: tuple[ParameterDeclaration, ...] = ()
    if reading is not None and is_distribution(reading):
        file, declared = read_distribution_file(reading)
    elif reading is not None:
        wanted = "<ParameterValueDistribution>"
        reading.context.error(
            "file.not_a_distribution", reading.at(), "", "the file varies no scenario", allowed=wanted
        )
    if file is None:
        raise refuse(findings)
    return file, declared


def check_scenario(
    path: AnyPath, *, library: Sequence[AnyPath] = (), rootdir: AnyPath | None = None, strict: bool = True
) -> tuple[Finding, ...]:
    """All findings of a scenario, catalogue or distribution file at once, warnings included; empty: nothing is wrong.

    A user's file never raises. Names that are taken, and a date that is none, are warnings in `read_scenario`: files in
    the wild have them, and run. strict: they are errors here; in a catalogue they always are.
    """
    findings = Findings()
    reading = open_reading(Path(path), _folders(library), _folder(rootdir), findings)
    if reading is not None:
        if reading.root.find("Catalog") is not None:
            read_catalog_file(reading)
        elif is_distribution(reading):
            read_distribution_file(reading)
        else:
            read_sections(reading, {})
    strict = strict or (reading is not None and reading.root.find("Catalog") is not None)
    found = findings.in_order()
    if strict:
        found = tuple(dataclasses.replace(each, severity="error") if each.code in _STRICT else each for each in found)
    return tuple(dict.fromkeys(found))


def read_declarations(
    path: AnyPath, parameters: Mapping[str, str | float | bool] | None = None
) -> tuple[ParameterDeclaration, ...]:
    """The parameters that a scenario declares: name, type, value, constraint groups.

    Args:
        path: the `.xosc` file.
        parameters: values in place of the declared ones, by name.

    Raises:
        ScenarioError: the file or a declaration is wrong, or a value is outside its constraints.
    """
    findings = Findings()
    reading = open_reading(Path(path), (), None, findings)
    declared = () if reading is None else declarations_of(reading, texts(parameters or {}))
    if findings.errors:
        raise ScenarioError(findings.in_order())
    return declared


def declarations_with(path: AnyPath, parameters: Mapping[str, str | float | bool]) -> tuple[ParameterDeclaration, ...]:
    """The parameters as `read_declarations` has them, with the constraints that hold at these values, also where the
    values are outside of them. Empty for a file that cannot be read."""
    reading = open_reading(Path(path), (), None, Findings())
    return () if reading is None else declarations_of(reading, texts(parameters))


def _folders(paths: Sequence[AnyPath]) -> list[Path]:
    return [Path(path) for path in paths]


def _folder(path: AnyPath | None) -> Path | None:
    return None if path is None else Path(path)
