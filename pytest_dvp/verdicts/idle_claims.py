"""What a twin claims and a drive cannot show: taken out of the twin, its answer to the car's commands stays the same.

A limit of the jerk of 2 m/s^3 is neither right nor wrong on a drive that never asks for 1. Bounds on what the twin
leaves of the car's motion say nothing of such an effect, whatever excited it.
"""

from __future__ import annotations

import functools

import numpy as np

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.obeyed_commands import with_obeyed_commands
from pytest_dvp.logs.undefined import Undefined

IDLE = 0.5
"""Mean square, in units of the sensor's noise and in the regime where it is greatest, below which nothing changed. Half
of what noise alone gives a `twin_chi2`, whose bounds that ship are 1.9 to 4.7; chosen, not measured."""
LEAST = 2.0  # s in a regime, as of twin_chi2


@functools.lru_cache(maxsize=4)
def idle_claims(twin: Log, measured: Log) -> tuple[str, ...]:
    """Effects of the twin of a log, without those that were fitted on logs or are of perception, that do nothing here.

    `measured`: the drive whose commands the twin answers. () where the two cannot be compared.
    """
    from pytest_dvp.gap.compare.compare import Comparison, compare
    from pytest_dvp.gap.compare.compared_model import CompareError
    from pytest_dvp.metrics.twin_error import compared
    from vehicle.model.errors import ModelError
    from vehicle.model.model_file import parse_model

    def change(one: Comparison, other: Comparison) -> float:
        """The greatest mean square of the change of a signal in a regime."""
        step = float(np.median(np.diff(one.t)))
        greatest = 0.0
        for name in one.signals.keys() & other.signals.keys():
            square = np.square((one.residuals[name] - other.residuals[name]) / one.noise[name])
            for rows in one.regimes.values():
                known = rows & np.isfinite(square)
                if known.sum() * step >= LEAST:
                    greatest = max(greatest, float(square[known].mean()))
        return greatest

    try:
        whole, car = compared(twin, measured), with_obeyed_commands(measured)
        model = parse_model(str(twin.meta["model"]["toml"]))
        claims = [a.name for a in model.effects if not a.fitted_on and a.effect.slot != "perception"]
        apart = {name: compare(car, model.without_effect(name)) for name in claims}
    except (Undefined, CompareError, ModelError):
        return ()
    return tuple(name for name, without in apart.items() if change(whole, without) < IDLE)
