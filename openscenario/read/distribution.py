"""Reading a parameter value distribution, and whether the scenario that it varies can take its values."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Final

from openscenario.findings import Findings, ScenarioError, nearest
from openscenario.model.declarations import ParameterDeclaration
from openscenario.model.distributions import (
    DistributionFile,
    ParameterValueDistribution,
    ScenarioFile,
)
from openscenario.model.kinds import At
from openscenario.parameters import Scope
from openscenario.paths import PathError
from openscenario.plan import plan_of
from openscenario.read.header import read_header
from openscenario.read.scenario import Reading, declarations_of, open_reading
from openscenario.read.varied import check_varied

TAG: Final = "ParameterValueDistribution"
_SECTIONS: Final = ("FileHeader", TAG)


def is_distribution(reading: Reading) -> bool:
    """Whether the file is a parameter value distribution."""
    return reading.root.find(TAG) is not None


def read_distribution_file(reading: Reading) -> tuple[DistributionFile | None, tuple[ParameterDeclaration, ...]]:
    """The distribution and the parameters of its scenario; what is wrong is in the context, and None comes back."""
    context = reading.context
    header = read_header(reading.root.find("FileHeader"), reading.reader, reading.at())
    if header is None:
        return None, ()
    _check_sections(reading)
    node = reading.root.find(TAG)
    distribution: ParameterValueDistribution | None = (
        None if node is None else reading.reader.read(plan_of(ParameterValueDistribution), node, Scope(), _path())
    )
    if distribution is None:
        # the distribution has a slip; whether the scenario is there at all is still worth knowing
        _scenario_alone(reading)
        return None, ()
    scenario, declared = _scenario(distribution.scenario_file, reading)
    check_varied(distribution.definition, declared, context)
    if context.findings.errors or scenario is None:
        return None, ()
    file = DistributionFile(
        header,
        dataclasses.replace(distribution, scenario_file=scenario),
        Path(reading.document.file),
        reading.document.sha256,
        at=reading.at(),
    )
    return file, declared or ()


def _path() -> str:
    return f"OpenSCENARIO/{TAG}"


def _check_sections(reading: Reading) -> None:
    seen: set[str] = set()
    for child in reading.root.children:
        at = reading.at(child, child.tag)
        if child.tag not in _SECTIONS:
            reading.context.error(
                "xml.unknown_element",
                at,
                "",
                "a distribution has no such section",
                found=child.tag,
                allowed=", ".join(_SECTIONS),
                hint=nearest(child.tag, _SECTIONS),
            )
        elif child.tag in seen:
            reading.context.error(
                "xml.too_many", at, "", "only one element of its kind may stand here", found=child.tag
            )
        seen.add(child.tag)


def _scenario(
    written: ScenarioFile, reading: Reading
) -> tuple[ScenarioFile | None, tuple[ParameterDeclaration, ...] | None]:
    """The scenario file with its path, and the parameters it declares; None: it is missing or wrong."""
    context = reading.context
    try:
        path = reading.roots.find(written.filepath, reading.roots.base)
    except PathError as error:
        context.error(
            error.code,
            written.at,
            "@filepath",
            error.text,
            found=written.filepath,
            allowed=error.allowed,
            hint=error.hint,
        )
        return None, None
    found = Findings()
    inner = open_reading(path, (), None, found)
    declared: tuple[ParameterDeclaration, ...] = ()
    if inner is not None and inner.root.find("Storyboard") is None:
        context.error(
            "file.not_a_scenario",
            written.at,
            "@filepath",
            "what is varied is no scenario",
            found=written.filepath,
            allowed="a file with a <Storyboard>",
        )
        return None, None
    if inner is not None:
        declared = _without_comparing(declarations_of(inner, {}), inner)
    if found.errors:
        context.findings.found.extend(found.found)
        return None, None
    return dataclasses.replace(written, path=path), declared


def _without_comparing(
    declared: tuple[ParameterDeclaration, ...], reading: Reading
) -> tuple[ParameterDeclaration, ...]:
    """The declarations without constraints that compare parameters: those judge a case, not a single value."""
    below = reading.root.find("ParameterDeclarations")
    compared = {
        node.get("name")
        for node in (below.children if below is not None else ())
        if any("$" in inner.get("value") for inner in node.walk() if inner.tag == "ValueConstraint")
    }
    return tuple(dataclasses.replace(d, constraint_groups=()) if d.name in compared else d for d in declared)


def _scenario_alone(reading: Reading) -> None:
    below = reading.root.find(TAG)
    node = None if below is None else below.find("ScenarioFile")
    if node is not None and node.get("filepath"):
        at = At(reading.document.file, node.line, f"{_path()}/ScenarioFile")
        _scenario(ScenarioFile(node.get("filepath"), at=at), reading)


def refuse(findings: Findings) -> ScenarioError:
    """All findings as one error, errors first."""
    return ScenarioError(sorted(findings.in_order(), key=lambda finding: finding.severity))
