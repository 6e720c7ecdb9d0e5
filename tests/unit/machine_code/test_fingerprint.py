"""The digest of what goes into machine code: the same in every process, another after any change."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from machine_code import compiled
from machine_code.fingerprint import fingerprint

ALL = """
import sys
import ads.stack, openscenario.road.index, pytest_dvp.drive.contact, pytest_dvp.metrics._box_collision_time
import vehicle.model.kernel
from machine_code.fingerprint import fingerprint
from vehicle.model.effect_catalogue import catalogue

for effect in catalogue().values():
    print(effect.name, fingerprint(effect.function, {}))
for name, module in sorted(sys.modules.items()):
    if name.partition(".")[0] in ("ads", "openscenario", "pytest_dvp", "vehicle"):
        for key, value in vars(module).items():
            if hasattr(value, "py_func"):
                print(name, key, fingerprint(value.py_func, value.targetoptions))
"""


@pytest.mark.nightly
def test_every_compiled_function_has_the_same_digest_in_every_process() -> None:
    """Else nothing that was stored would ever be loaded: an address or the order of a set would do."""
    made = [
        subprocess.run(
            [sys.executable, "-c", ALL], env=os.environ | {"PYTHONHASHSEED": seed}, capture_output=True, text=True
        )
        for seed in ("1", "2")
    ]
    assert made[0].stdout == made[1].stdout, made[0].stderr
    assert made[0].stdout.count("\n") > 150


def scaled(factor: object) -> Callable[[float], Any]:
    def function(x: float) -> Any:
        return x * factor  # type: ignore[operator]

    return function


def test_values_that_a_function_closes_over_count() -> None:
    values = (1.0, 1, True, 2.0, -0.0, 0.0, (1.0,), (1.0, 2.0), "1.0", np.float32(1.0), np.ones(2), np.ones((2, 1)))
    assert len({fingerprint(scaled(value), {}) for value in values}) == len(values)
    assert fingerprint(scaled(np.ones(2)), {}) == fingerprint(scaled(np.ones(2)), {})
    assert fingerprint(scaled(1.0), {"inline": "never"}) != fingerprint(scaled(1.0), {"inline": "always"})


def test_functions_that_call_each_other_count_to_the_end() -> None:
    def made(step: int) -> Any:
        @compiled
        def even(n: int) -> bool:
            return True if n == 0 else bool(odd(n - 1))

        @compiled
        def odd(n: int) -> bool:
            return False if n == 0 else bool(even(n - step))

        return even.py_func  # type: ignore[attr-defined]

    assert fingerprint(made(1), {}) == fingerprint(made(1), {})
    assert fingerprint(made(1), {}) != fingerprint(made(3), {})
