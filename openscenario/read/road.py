"""The road file that a scenario names: where it lies, and whether positions and signals of the scenario exist on it."""

from __future__ import annotations

import dataclasses

from openscenario.model.scenario import RoadNetwork
from openscenario.paths import PathError, Roots
from openscenario.read.context import Context


def with_road(network: RoadNetwork | None, roots: Roots, context: Context) -> RoadNetwork | None:
    """The road network with the resolved path of its logic file, which must lie in the allowed folders."""
    if network is None or network.logic is None:
        return network
    logic = network.logic
    try:
        path = roots.find(logic.filepath, roots.base)
    except PathError as error:
        context.error(
            error.code,
            logic.at,
            "@filepath",
            error.text,
            found=logic.filepath,
            allowed=error.allowed,
            hint=error.hint,
        )
        return None
    return dataclasses.replace(network, logic=dataclasses.replace(logic, path=path))
