"""Reading scenario files: file -> model, or findings."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TypeAlias

from openscenario.findings import Finding, Findings, ScenarioError
from openscenario.model.declarations import ParameterDeclaration
from openscenario.model.scenario import Scenario
from openscenario.read.scenario import check_catalog, declarations_of, open_reading, read_sections, texts

AnyPath: TypeAlias = str | os.PathLike[str]

__all__ = ["check_scenario", "read_declarations", "read_scenario"]


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
        raise ScenarioError(sorted(findings.in_order(), key=lambda finding: finding.severity))  # errors first
    return scenario


def check_scenario(
    path: AnyPath, *, library: Sequence[AnyPath] = (), rootdir: AnyPath | None = None
) -> tuple[Finding, ...]:
    """All findings of a scenario or catalogue file at once, warnings included; empty: nothing is wrong.

    A user's file never raises.
    """
    findings = Findings()
    reading = open_reading(Path(path), _folders(library), _folder(rootdir), findings)
    if reading is not None:
        if reading.root.find("Catalog") is not None:
            check_catalog(reading)
        else:
            read_sections(reading, {})
    return findings.in_order()


def read_declarations(path: AnyPath) -> tuple[ParameterDeclaration, ...]:
    """The parameters that a scenario declares: name, type, value, constraint groups.

    Raises:
        ScenarioError: the file or a declaration is wrong.
    """
    findings = Findings()
    reading = open_reading(Path(path), (), None, findings)
    declared = () if reading is None else declarations_of(reading)
    if findings.errors:
        raise ScenarioError(findings.in_order())
    return declared


def _folders(paths: Sequence[AnyPath]) -> list[Path]:
    return [Path(path) for path in paths]


def _folder(path: AnyPath | None) -> Path | None:
    return None if path is None else Path(path)
