"""Equations of a regression are solved alike whatever the units of their columns."""

from __future__ import annotations

import numpy as np
import pytest

from pytest_dvp.gap.diagnose.residual_regression import _solved


@pytest.mark.parametrize("unit", [1e-9, 1.0, 1e6])
def test_a_column_in_another_unit_has_the_same_part(unit: float) -> None:
    """theta of y = X theta by numpy, with the second column in a unit so many times as large."""
    rng = np.random.default_rng(4)
    x, y = rng.normal(size=(50, 3)), rng.normal(size=50)
    x[:, 1] *= unit
    theta = np.linalg.lstsq(x / [1.0, unit, 1.0], y, rcond=None)[0]
    assert _solved(x.T @ x, x.T @ y) * [1.0, unit, 1.0] == pytest.approx(theta, rel=1e-4)
