"""P: the parameters of the reference stack, with unit, range, meaning and the paper's presets.

Source: Arango et al., Sensors 2026, 26, 1338 (parameter sets of the 1st, 5th and 10th iteration).
"""

from __future__ import annotations

import dataclasses
import difflib
import math
from collections.abc import Mapping
from typing import Literal, NamedTuple, TypeAlias

Iteration: TypeAlias = Literal[1, 5, 10]
Stage: TypeAlias = Literal["dt", "pe", "rw"]
ITERATIONS: tuple[Iteration, ...] = (1, 5, 10)
STAGES: tuple[Stage, ...] = ("dt", "pe", "rw")


class ParameterError(ValueError):
    """A name, value or preset that P does not have; the message is one line and says what is allowed."""


_Row: TypeAlias = tuple[float, float, float]
_Presets: TypeAlias = tuple[_Row, _Row, _Row]


class Declaration(NamedTuple):
    """One parameter: closed range [low, high] in `unit`; `presets` are rows of ITERATIONS, columns of STAGES."""

    name: str
    unit: str
    low: float
    high: float
    meaning: str
    presets: _Presets


def _same(first: float, fifth: float, tenth: float) -> _Presets:
    return ((first,) * 3, (fifth,) * 3, (tenth,) * 3)


DECLARATIONS: tuple[Declaration, ...] = (
    Declaration("LQR_v_max", "m/s", 0.5, 60.0, "speed on straight road when the task sets none",
                ((7.0, 5.5, 5.5), (5.5,) * 3, (5.5,) * 3)),
    Declaration("LQR_rc_max", "m", 1.0, 500.0, "radius below which the speed falls with its square root",
                _same(25.0, 30.0, 40.0)),
    Declaration("LQR_q11", "1/m^2", 0.0, 10_000.0, "weight of the lateral error", _same(20.0, 30.0, 30.0)),
    Declaration("LQR_q22", "1/rad^2", 0.0, 10_000.0, "weight of the heading error",
                ((100.0, 10.0, 10.0), (1.0,) * 3, (0.0001,) * 3)),
    Declaration("LQR_r11", "1/rad^2", 1.0, 1_000_000.0, "weight of the steering effort",
                ((9000.0, 5000.0, 5000.0), (5000.0,) * 3, (5000.0,) * 3)),
    Declaration("MPC_w", "m", 0.0, 6.0, "lateral offset of the path around an obstacle, to the left",
                ((3.5, 2.75, 2.75), (2.75,) * 3, (2.75,) * 3)),
    Declaration("DECISION_PC_d_max", "m", 0.0, 200.0, "distance to a crossing at which the ego slows to crossing speed",
                _same(30.0, 30.0, 40.0)),
    Declaration("DECISION_PC_d_min", "m", 0.0, 100.0, "distance to the middle of an occupied crossing where it stops",
                ((10.0,) * 3, (10.0, 15.0, 15.0), (15.0,) * 3)),
    Declaration("DECISION_OT_d_max", "m", 0.0, 200.0, "distance to the obstacle at which overtaking may start",
                ((40.0,) * 3, (40.0, 30.0, 30.0), (30.0,) * 3)),
    Declaration("DECISION_OT_speed", "m/s", 0.5, 30.0, "speed while overtaking",
                ((7.0,) * 3, (7.0, 5.0, 5.0), (5.0,) * 3)),
    Declaration("FUSION_min_dist", "m", 0.0, 20.0, "largest distance at which a camera and a LiDAR object are one",
                ((2.5,) * 3, (2.5, 2.5, 4.0), (4.5,) * 3)),
    Declaration("LIDAR_x_max", "m", 1.0, 200.0, "LiDAR points farther ahead or behind are dropped",
                ((50.0,) * 3, (50.0, 50.0, 30.0), (30.0,) * 3)),
    Declaration("LIDAR_abs_y_max", "m", 0.5, 100.0, "LiDAR points farther to a side are dropped",
                _same(10.0, 10.0, 5.0)),
)  # fmt: skip

_BY_NAME: Mapping[str, Declaration] = {d.name: d for d in DECLARATIONS}


@dataclasses.dataclass(frozen=True)
class Parameters:
    """All of P. The defaults are the paper's 10th iteration; units, ranges and meanings stand in DECLARATIONS."""

    LQR_v_max: float = 5.5
    LQR_rc_max: float = 40.0
    LQR_q11: float = 30.0
    LQR_q22: float = 0.0001
    LQR_r11: float = 5000.0
    MPC_w: float = 2.75
    DECISION_PC_d_max: float = 40.0
    DECISION_PC_d_min: float = 15.0
    DECISION_OT_d_max: float = 30.0
    DECISION_OT_speed: float = 5.0
    FUSION_min_dist: float = 4.5
    LIDAR_x_max: float = 30.0
    LIDAR_abs_y_max: float = 5.0

    def __post_init__(self) -> None:
        for field in dataclasses.fields(self):
            _checked(field.name, getattr(self, field.name))

    def with_values(self, values: Mapping[str, float]) -> Parameters:
        """A copy with other values, such as ``{"LQR_q11": 30}``.

        Raises: ParameterError for an unknown name (says the nearest one) or a value outside its range.
        """
        return dataclasses.replace(self, **{name: _checked(name, value) for name, value in values.items()})

    def as_dict(self) -> dict[str, float]:
        """Name to value, in the order of DECLARATIONS."""
        return {d.name: float(getattr(self, d.name)) for d in DECLARATIONS}


def preset(iteration: int = 10, stage: str = "dt") -> Parameters:
    """The paper's values of an iteration (1, 5, 10) and a stage ("dt", "pe", "rw").

    Raises: ParameterError for another iteration or stage.
    """
    if iteration not in ITERATIONS:
        raise ParameterError(f"no preset for iteration {iteration!r}; allowed: 1, 5, 10")
    if stage not in STAGES:
        raise ParameterError(f"no preset for stage {stage!r}; allowed: dt, pe, rw")
    row, column = ITERATIONS.index(iteration), STAGES.index(stage)
    return Parameters(**{d.name: d.presets[row][column] for d in DECLARATIONS})


def declaration(name: str) -> Declaration:
    """The declaration of a parameter.

    Raises: ParameterError for an unknown name.
    """
    found = _BY_NAME.get(name)
    if found is None:
        near = difflib.get_close_matches(name, _BY_NAME, n=1, cutoff=0.0)
        raise ParameterError(f"unknown ADS parameter {name!r}; did you mean {near[0]!r}?")
    return found


def _checked(name: str, value: float) -> float:
    allowed = declaration(name)
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = math.nan
    if not allowed.low <= number <= allowed.high:
        wrong = "is no number; its range is" if math.isnan(number) else "is outside its range"
        raise ParameterError(
            f"ADS parameter {name} = {value!r} {wrong} [{allowed.low:g}, {allowed.high:g}] {allowed.unit}"
        )
    return number
