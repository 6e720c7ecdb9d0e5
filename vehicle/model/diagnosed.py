"""What a diagnosis must know about an effect before it tries it on a log."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True, slots=True)
class Diagnosed:
    """How an effect is tried.

    details      the plainer effect that this one is a finer form of: few logs can tell it from plainer effects, so it
                 is tried only where none of those pays any more
    refines      the constant effects of which this one is the form that changes while driving: it is tried only at the
                 end of a search, in the place of those that were found or beside them
    seen_as      (effect, quantity): where this effect is missing, the constant value of that one seems to change with
                 time, brake_energy, motor_energy, speed, acceleration or place
    contains     the simpler effect that this one can do exactly; where both explain a log, the simpler one is named
    held         parameters that a search leaves as the model has them, off where it does not name them
    needs        group of parts whose data sheet must be known: tried only on a model that has an effect of this group
    input        the command that must drive the model's longitudinal motion, "" for any
    run_setup    "zero": a zero of a sensor or of the steering, which may differ from run to run of the same car;
                 "place": where a sensor is mounted, asked of a held-out run only if another run has it
    grid_points  points of the grid for an effect whose error has many valleys; 0: as many as its parameters ask for
    grid         (parameter, values): the points of the grid on this axis, where its range would give too few or others
    delay_error  share of a sample by which the dead time `delay` is never known
    input_scales scales of the model's input map that do the same as this effect
    scaled_by    (scale of the input map, parameter): the parameter is held where this scale is fitted, for scale and
                 parameters together could all be larger or smaller by the same factor
    surroundings True for the road and the air: the model's value is that of the drives it was learnt from, and another
                 drive has one of its own
    by_gear      True for a force of which each gear has another: where the model changes gears, its value is that of
                 the gears in which its drives met it
    hides_in     (parameter of S, place): parameters whose tuned value may stand in for this effect, and its place among
                 the effects tried for each; only the first few are tried
    """

    details: str = ""
    refines: tuple[str, ...] = ()
    seen_as: tuple[tuple[str, str], ...] = ()
    contains: str = ""
    held: tuple[str, ...] = ()
    needs: str = ""
    input: str = ""
    run_setup: Literal["", "zero", "place"] = ""
    grid_points: int = 0
    grid: tuple[tuple[str, tuple[float, ...]], ...] = ()
    delay_error: float = 0.1
    input_scales: tuple[str, ...] = ()
    scaled_by: tuple[tuple[str, str], ...] = ()
    surroundings: bool = False
    by_gear: bool = False
    hides_in: tuple[tuple[str, int], ...] = ()
