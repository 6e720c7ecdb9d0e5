"""From an effect's Python function to machine code that the kernel can call.

Each effect becomes a C function of three pointers (bus, parameters, memory), cached on disk beside its source. The
kernel calls them by address: it is compiled once, whatever effects there are, and an effect of a third party costs its
own compile (about 0.1 s, once) and no more than a built-in one afterwards.
"""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numba
import numpy as np
from numba import cfunc, types
from numba.extending import register_jitable

from vehicle.model import maths
from vehicle.model.bus import BUS_FIELDS
from vehicle.model.effect import Effect

BUS_DTYPE = np.dtype([(name, np.float64) for name in BUS_FIELDS])
_BUS_TYPE = numba.from_dtype(BUS_DTYPE)

for _helper in (maths.clip, maths.lag_end, maths.lag_mean, maths.delayed):
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
    """The effect as a numba C function; `.address` is what the kernel calls. Compiled (or loaded) on first use."""
    signature = types.void(_BUS_TYPE, numba.from_dtype(parameter_dtype(effect)), numba.from_dtype(memory_dtype(effect)))
    return cfunc(signature, cache=True, error_model="numpy")(effect.function)


def doubles(dtype: np.dtype[Any]) -> int:
    """Number of doubles in a record."""
    return math.ceil(dtype.itemsize / 8)
