"""Which parts of the logs on a command line a diagnosis looks at, named as log arguments of the next command."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from pytest_dvp.logs.log import Log
    from vehicle.model.vehicle_model import VehicleModel


class SelectedParts(NamedTuple):
    """logs by name; texts that name the same parts on a command line; said: a line about what was left out, or ""."""

    logs: dict[str, Log]
    texts: list[str]
    said: str


def select_parts(texts: Sequence[str], logs: Mapping[str, Log], model: VehicleModel) -> SelectedParts:
    """The most eventful parts of logs that are too long to be diagnosed as a whole; texts as the user typed them."""
    from pytest_dvp.gap.diagnose.part_selection import exciting_parts
    from pytest_dvp.logs.log_part import parse_argument

    parts = exciting_parts(logs, model.inputs.columns)
    if all(part.whole for part in parts) and len(parts) == len(logs):
        return SelectedParts(dict(logs), list(texts), "")
    typed = dict(zip(logs, dict.fromkeys(texts), strict=False))
    kept: dict[str, Log] = {}
    words: list[str] = []
    for part in parts:
        path = parse_argument(typed[part.name]).path
        words.append(typed[part.name] if part.whole else part.called(str(path)))
        kept[part.name if part.whole else Path(words[-1]).name] = part.log
    seconds, whole = sum(part.log.duration for part in parts), sum(log.duration for log in logs.values())
    return SelectedParts(kept, words, (
        f"looked at {seconds:.0f} of {whole:.0f} s: {', '.join(words)} (the parts that drive the car most "
        "variedly; to choose others name them as LOG@START:STOP)"
    ))  # fmt: skip
