"""The table of stages: rows of the paper, a column a stage, each compared with the one to its left."""

from __future__ import annotations

import json

import numpy as np
import pytest
from results_logs import log_of, times

from pytest_dvp.logs.log import Log
from pytest_dvp.verdicts.stage_table import _single, stage_table

T = times(40.0)


def drive(delay: float, gain: float = 1.0) -> Log:
    wave = -(T - 20.0 - delay) * np.exp(-(((T - 20.0 - delay) / 2.0) ** 2))
    return log_of(40.0, columns={"v": 5.0 + gain * wave, "x": 5.0 * T, "y": 0.0})


def test_each_stage_is_compared_with_the_one_to_its_left() -> None:
    table = stage_table({"dt": drive(0.0), "pe-surrogate": drive(0.2), "rw-surrogate": drive(0.5, 0.9)})
    assert table.against == ("", "dt", "pe-surrogate")
    cells = [table.cell("velocity", stage) for stage in table.stages]
    assert cells[0].value is None
    assert [cell.lag for cell in cells[1:]] == pytest.approx([0.2, 0.3])
    assert [cell.gain for cell in cells[1:]] == pytest.approx([1.0, 0.9], rel=1e-4)


def test_the_first_stage_is_compared_with_the_drive_before_it_if_there_is_one() -> None:
    table = stage_table({"dt": drive(0.3)}, before=("rw", drive(0.0)))
    assert table.against == ("rw",)
    assert table.cell("velocity", "dt").lag == pytest.approx(0.3)


def test_what_is_not_defined_says_why_and_is_no_number() -> None:
    table = stage_table({"dt": drive(0.0), "rw": drive(0.0)})
    cell = table.cell("ego y", "rw")
    assert (cell.value, cell.text) == (None, "-")
    assert cell.reason == "the signal is constant"


def test_a_row_that_is_defined_for_no_stage_has_the_unit_of_its_metric_and_without_stages_none() -> None:
    """A car at 5 m/s never creeps, which is a way in metres."""
    found = _single("rolled", "creep", {"dt": drive(0.0)})
    assert (found.unit, found.cells[0].value) == ("m", None)
    assert _single("rolled", "creep", {}).unit == "-"


def test_it_is_plain_data_and_fits_a_terminal() -> None:
    table = stage_table({"dt": drive(0.0), "pe-surrogate": drive(0.2), "rw-surrogate": drive(0.5)})
    assert json.loads(json.dumps(table.as_dict()))["stages"] == ["dt", "pe-surrogate", "rw-surrogate"]
    lines = table.lines()
    assert max(map(len, lines)) <= 100
    velocity = next(line for line in lines if line.startswith("MNCC velocity"))
    assert "1.0000 +0.20 s x1.000" in velocity
