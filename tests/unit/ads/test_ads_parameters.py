"""P: presets of the paper, ranges, errors."""

from __future__ import annotations

import dataclasses

import pytest

from ads.parameters import DECLARATIONS, ParameterError, Parameters, declaration, preset


def test_the_tenth_iteration_is_the_default():
    assert Parameters() == preset(10, "dt") == preset()


@pytest.mark.parametrize(
    ("iteration", "stage", "name", "value"),
    [
        (1, "dt", "LQR_v_max", 7.0),
        (1, "rw", "LQR_v_max", 5.5),
        (1, "pe", "LQR_r11", 5000.0),
        (5, "dt", "DECISION_PC_d_min", 10.0),
        (5, "rw", "DECISION_PC_d_min", 15.0),
        (5, "rw", "FUSION_min_dist", 4.0),
        (5, "pe", "FUSION_min_dist", 2.5),
        (5, "rw", "LIDAR_x_max", 30.0),
        (10, "pe", "LQR_q22", 0.0001),
        (10, "rw", "LIDAR_abs_y_max", 5.0),
    ],
)
def test_presets_are_those_of_the_paper(iteration, stage, name, value):
    assert getattr(preset(iteration, stage), name) == value


def test_every_parameter_is_declared_with_its_default_inside_its_range():
    assert [d.name for d in DECLARATIONS] == [f.name for f in dataclasses.fields(Parameters)]
    for d in DECLARATIONS:
        assert d.low <= getattr(Parameters(), d.name) <= d.high
        assert d.unit
        assert d.meaning


def test_with_values_leaves_the_original_alone():
    base = Parameters()
    assert base.with_values({"LQR_q11": 20}).LQR_q11 == 20.0
    assert base.LQR_q11 == 30.0


def test_unknown_name_says_the_nearest_one():
    with pytest.raises(ParameterError, match=r"LQR_q111.*did you mean 'LQR_q11'"):
        Parameters().with_values({"LQR_q111": 1.0})


@pytest.mark.parametrize("value", [-1.0, 1e9, float("nan"), "wide"])
def test_value_outside_its_range_says_the_range(value):
    with pytest.raises(ParameterError, match=r"MPC_w.*\[0, 6\] m"):
        Parameters().with_values({"MPC_w": value})


def test_bounds_belong_to_the_range():
    d = declaration("DECISION_PC_d_min")
    assert Parameters().with_values({d.name: d.low}).DECISION_PC_d_min == 0.0
    assert Parameters().with_values({d.name: d.high}).DECISION_PC_d_min == d.high


def test_unknown_preset_is_an_error():
    with pytest.raises(ParameterError, match="1, 5, 10"):
        preset(2)
    with pytest.raises(ParameterError, match="dt, pe, rw"):
        preset(10, "hil")
