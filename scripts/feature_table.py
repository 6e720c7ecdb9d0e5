"""The part of docs/conformance.md by feature: how many references show an action or condition, and what runs beside.

A feature is an action or condition of OpenSCENARIO that the storyboard can run. Wild files are those of
`openscenario/wild` in the shared folder: scenarios of public repositories, of which nobody has played a reference.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from pathlib import Path

from openscenario.findings import ScenarioError
from openscenario.model.kinds import elements_below
from openscenario.model.scenario import Scenario
from openscenario.read import read_scenario
from openscenario.road.network import load_network
from openscenario.storyboard.engine import Storyboard
from openscenario.storyboard.registry import action_factories, condition_factories
from openscenario.xml import read_xml


def features_of(scenario: Scenario) -> frozenset[str]:
    """Names of the actions and conditions that a scenario uses."""
    known = {kind.__name__ for kind in (*action_factories(), *condition_factories())}
    return frozenset(type(each).__name__ for each in elements_below(scenario.storyboard)) & known


def found_files(folder: Path) -> tuple[list[frozenset[str]], Counter[str]]:
    """Features of each wild scenario that the storyboard takes; how many others there are, by their first error's code.

    Files whose neighbours are not there count as `path.not_found`. Catalogues and distributions are left out.
    """
    taken: list[frozenset[str]] = []
    refused: Counter[str] = Counter()
    for path in sorted(folder.rglob("*.xosc")):
        try:
            root = read_xml(path).root
            if root.find("Catalog") is not None or root.find("ParameterValueDistribution") is not None:
                continue
            scenario = read_scenario(path, library=[folder])
            road = scenario.road_network.logic_file
            Storyboard(scenario, load_network(road) if road is not None else None).start()
        except ScenarioError as error:
            first = next(each for each in error.findings if each.severity == "error")
            refused[first.code.rpartition(":")[2]] += 1
        else:
            taken.append(features_of(scenario))
    return taken, refused


def table(references: Mapping[str, tuple[frozenset[str], bool]], folder: Path) -> list[str]:
    """Lines of the page. references: by name, the features of each and whether the drives agree."""
    taken, refused = found_files(folder) if folder.is_dir() else ([], Counter[str]())
    lines = [
        "\n## By feature\n",
        "A feature is an action or condition that a file uses. The second column counts the references above that",
        "use it, the third those of them that agree. The last column counts scenarios of public repositories that",
        "were not seen before and that run; nobody has played references of them.\n",
        "| feature | references | agree | wild files that run |",
        "|---|---|---|---|",
    ]
    kinds = sorted({kind.__name__ for kind in (*action_factories(), *condition_factories())})
    compared = 0
    for name in kinds:
        shown = [agrees for features, agrees in references.values() if name in features]
        wild = sum(name in features for features in taken)
        compared += bool(shown)
        lines.append(f"| `{name}` | {len(shown)} | {sum(shown)} | {wild} |")
    share = 100.0 * compared / max(len(kinds), 1)
    lines += ["", f"{compared} of {len(kinds)} features ({share:.0f} %) are compared with at least one reference."]
    if taken or refused:
        reasons = ", ".join(f"{count} `{code}`" for code, count in refused.most_common())
        lines += [f"Of {len(taken) + refused.total()} wild scenarios {len(taken)} run; refused: {reasons}."]
    return lines
