"""What the detections of one log show."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

from pytest_dvp.gap.perception.behind_others import Behind
from pytest_dvp.logs.log_contents import FloatArray


@dataclasses.dataclass(frozen=True, slots=True)
class Perceived:
    """Values of all perception effects in a log: (effect, key) -> (value, low, high), 95 % intervals; an effect that
    these data could not show is left out. worth: log-likelihood that each effect brings. rivals: by effect.
    levels (bands, 2): noise [m] of positions nearby by bands of distance, and its standard deviation; None where a band
    holds no object. behind: what was partly behind others."""

    values: dict[tuple[str, str], tuple[float, float, float]]
    worth: dict[str, float]
    rivals: Mapping[str, tuple[str, ...]]
    levels: FloatArray | None = None
    behind: Behind | None = None
