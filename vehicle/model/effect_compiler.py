"""From an effect's Python function to machine code that the kernel can call.

Each effect becomes a C function of three pointers (bus, parameters, memory), kept on disk by `machine_code`. The
kernel calls them by address: it is compiled once, whatever effects there are, and an effect of a third party costs its
own compile (about 0.1 s, once) and no more than a built-in one afterwards.
"""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numba
import numpy as np
from numba import types
from numba.core.errors import NumbaError
from numba.extending import register_jitable

from machine_code import compiled_callback
from vehicle.model import step_maths
from vehicle.model.bus import BUS_FIELDS
from vehicle.model.effect import Effect
from vehicle.model.errors import ModelError, nearest_name

BUS_DTYPE = np.dtype([(name, np.float64) for name in BUS_FIELDS])
_BUS_TYPE = numba.from_dtype(BUS_DTYPE)

for _helper in (
    step_maths.clip,
    step_maths.lag_end,
    step_maths.lag,
    step_maths.limit_rate,
    step_maths.delayed,
    step_maths.arrived,
    step_maths.remember,
    step_maths.recall,
    step_maths.spin_up,
    step_maths.held_across,
):
    register_jitable(_helper)


def parameter_dtype(effect: Effect) -> np.dtype[Any]:
    """Record of the effect's parameters."""
    return np.dtype([(k.name, np.float64) for k in effect.parameters])


def memory_dtype(effect: Effect) -> np.dtype[Any]:
    """Record of the effect's memory (one unused double if it needs none)."""
    fields = [(m.name, np.float64, (m.size,)) if m.size > 1 else (m.name, np.float64) for m in effect.memory]
    return np.dtype(fields or [("unused", np.float64)])


@cache
def compiled(effect: Effect) -> Any:
    """The effect as a numba C function; `.address` is what the kernel calls. Compiled (or loaded) on first use.

    Raises ModelError, naming file and effect, if the function cannot be compiled.
    """
    signature = types.void(_BUS_TYPE, numba.from_dtype(parameter_dtype(effect)), numba.from_dtype(memory_dtype(effect)))
    try:
        return compiled_callback(signature, effect.function)
    except (NumbaError, KeyError) as error:  # KeyError: numba's answer to a field that a record lacks
        unknown = str(error.args[0]) if isinstance(error, KeyError) and error.args else ""
        fields = (*BUS_FIELDS, *(k.name for k in effect.parameters), *(m.name for m in effect.memory))
        reason = f"no such field: {unknown}" if unknown else " ".join(str(error).split())[:300]
        raise ModelError(
            f"effect cannot be compiled: {reason}",
            file=effect.function.__code__.co_filename,
            key=effect.name,
            nearest=nearest_name(unknown, fields),
        ) from error


def doubles(dtype: np.dtype[Any]) -> int:
    """Number of doubles in a record."""
    return math.ceil(dtype.itemsize / 8)
