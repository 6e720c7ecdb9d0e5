"""The findings of a run in words: each of them is said by the room that finds it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from openscenario.road.repairs import CODE as REPAIRED
from openscenario.road.repairs import as_results
from openscenario.road.repairs import note as said_of_road
from openscenario.storyboard.plausibility import CODE as IMPLAUSIBLE
from openscenario.storyboard.plausibility import said_of as said_of_motion
from pytest_dvp.drive.command_range import finding_text as said_of_command
from pytest_dvp.text.paths import shown

if TYPE_CHECKING:
    from openscenario.road.network import RoadNetwork


def of_road(network: RoadNetwork) -> tuple[dict[str, Any], ...]:
    """What was assumed of the road on which a run drives: rows for `RunResult.findings`."""
    return tuple({**row, "file": shown(Path(row["file"]))} for row in as_results(network.file.repairs))


def said(finding: Mapping[str, Any]) -> str:
    """A finding of `RunResult.findings` in one line."""
    if finding["code"] == REPAIRED:
        return said_of_road(finding)
    if finding["code"] == IMPLAUSIBLE:
        return said_of_motion(finding)
    return said_of_command(finding)
