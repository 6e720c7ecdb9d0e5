"""compare: the figures say what was hidden, and where."""

from __future__ import annotations

import dataclasses
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from gap_logs import NOISE, baseline, drive

from pytest_dvp.gap.compare.compare import compare
from pytest_dvp.gap.compare.compared_model import CompareError
from pytest_dvp.gap.words.comparison import headline
from pytest_dvp.gap.words.pooled_comparison import pooled
from pytest_dvp.logs.log import Log
from vehicle.messages import TRACE_COLUMNS, VehicleState
from vehicle.model.effect_catalogue import effects_of_file
from vehicle.model.errors import ModelError
from vehicle.model.model_file import parse_model
from vehicle.model.plant import Plant


def test_model_without_error_leaves_nothing_to_explain() -> None:
    found = compare(drive(), baseline())
    assert {name: score.chi2_per_n for name, score in found.signals.items()} == pytest.approx(
        dict.fromkeys(NOISE, 1.0), abs=0.2
    )


def test_residual_is_measured_minus_modelled() -> None:
    found = compare(drive(), baseline())
    known = np.isfinite(found.residuals["v"])
    assert (found.measured["v"] - found.modelled["v"])[known] == pytest.approx(found.residuals["v"][known])


def test_steering_delay_is_a_lag_of_yaw_rate_and_of_no_speed() -> None:
    found = compare(drive(steer_delay=0.2), baseline())
    assert found.signals["yaw_rate"].lag == pytest.approx(0.2, abs=0.01)
    assert found.signals["v"].lag == pytest.approx(0.0, abs=0.02)


def test_brake_gain_is_located_in_braking() -> None:
    found = compare(drive(brake_gain=0.85), baseline())
    first = next(w for w in found.where if w.channel == "v" and w.kind == "regime")
    assert first.regime == "braking"
    assert first.share_of_error > 0.6
    assert first.share_of_time < 0.35


def test_drive_gain_is_located_in_launch_or_acceleration() -> None:
    found = compare(drive(drive_gain=0.85), baseline())
    assert next(w for w in found.where if w.channel == "ax" and w.kind == "regime").regime == "launch"


def test_steering_delay_is_located_in_turn_in() -> None:
    found = compare(drive(steer_delay=0.2), baseline())
    assert next(w for w in found.where if w.channel == "yaw_rate" and w.kind == "regime").regime in (
        "turn_in",
        "steady_turn",
    )


def test_gain_is_the_slope_of_measured_against_model() -> None:
    assert compare(drive(drive_gain=0.8, brake_gain=0.8), baseline()).signals["ax"].gain == pytest.approx(0.8, abs=0.03)


def test_document_has_exactly_the_keys_of_the_contract() -> None:
    document = compare(drive(), baseline()).as_dict()
    assert list(document) == ["alignment", "signals", "where"]
    assert set(document["alignment"]) == {"lag", "coverage"}
    assert set(document["signals"]["v"]) == {
        "rmse", "nrmse", "chi2_per_n", "mncc", "lag", "gain", "iso18571", "unit",
    }  # fmt: skip
    assert all(set(entry) == {"channel", "regime", "share_of_error", "share_of_time"} for entry in document["where"])
    json.dumps(document)


def test_shares_of_a_partition_add_up_to_one() -> None:
    found = compare(drive(), baseline())
    speed = [w for w in found.where if w.channel == "v" and w.kind == "speed"]
    assert sum(w.share_of_error for w in speed) == pytest.approx(1.0, abs=1e-6)
    assert sum(w.share_of_time for w in speed) == pytest.approx(1.0, abs=1e-6)


def test_same_log_and_model_give_the_same_document() -> None:
    assert compare(drive(), baseline()).as_dict() == compare(drive(), baseline()).as_dict()


def test_only_channels_asked_for() -> None:
    assert list(compare(drive(), baseline(), channels=["v"]).signals) == ["v"]


def test_unknown_channel_names_the_nearest() -> None:
    with pytest.raises(CompareError, match="yaw_rate"):
        compare(drive(), baseline(), channels=["yawrate"])


def test_log_without_the_commands_says_which() -> None:
    log = drive()
    with pytest.raises(CompareError, match="'steer_cmd'"):
        compare(Log({name: values for name, values in log.columns.items() if name != "steer_cmd"}), baseline())


def test_time_that_stands_still_is_refused_with_its_row() -> None:
    log = drive()
    log.columns["t"][100] = log.columns["t"][99]
    with pytest.raises(CompareError, match="row 100"):
        compare(log, baseline())


def test_channel_not_measured_is_named_as_such() -> None:
    assert compare(drive(), baseline()).not_compared == {"steer": "not measured"}


def test_several_logs_become_one_document_weighted_by_samples() -> None:
    short, long = compare(drive(20.0), baseline()), compare(drive(60.0, brake_gain=0.85), baseline())
    document = pooled({"a": short, "b": long})
    parts = [one.residuals["v"][np.isfinite(one.residuals["v"])] for one in (short, long)]
    assert document["signals"]["v"]["rmse"] == pytest.approx(float(np.sqrt(np.mean(np.concatenate(parts) ** 2))))
    assert [entry["log"] for entry in document["logs"]] == ["a", "b"]


def test_one_log_is_its_own_document() -> None:
    found = compare(drive(20.0), baseline())
    assert pooled({"a": found}) == found.as_dict()


def test_gap_in_the_log_costs_nothing() -> None:
    log = drive()
    keep = (log.t < 24.0) | (log.t > 31.0)
    found = compare(Log({name: values[keep] for name, values in log.columns.items()}), baseline())
    assert {name: score.chi2_per_n for name, score in found.signals.items()} == pytest.approx(
        dict.fromkeys(NOISE, 1.0), abs=0.25
    )


def test_wrapped_heading_is_the_same_heading() -> None:
    log = drive(yaw_bias=3.1)
    wrapped = Log({**log.columns, "yaw": (log["yaw"] + np.pi) % (2.0 * np.pi) - np.pi})
    assert compare(wrapped, baseline()).signals["yaw"].chi2_per_n == pytest.approx(
        compare(log, baseline()).signals["yaw"].chi2_per_n
    )


def test_slow_position_among_fast_signals_is_compared_where_it_was_measured() -> None:
    log = drive()
    for name in ("x", "y"):
        log.columns[name][np.arange(len(log.t)) % 10 != 0] = np.nan
    found = compare(log, baseline())
    assert np.isfinite(found.residuals["x"]).sum() == pytest.approx(len(log.t) / 10, rel=0.2)
    assert found.signals["v"].chi2_per_n == pytest.approx(1.0, abs=0.2)


@pytest.mark.parametrize("seed", range(12))
def test_any_finite_columns_give_finite_figures_or_one_line(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n = int(rng.integers(3, 400))
    columns = {"t": np.cumsum(rng.choice([0.01, 0.02, 0.7, 30.0], n, p=[0.5, 0.45, 0.04, 0.01]))}
    for name in ("steer_cmd", "accel_cmd", "x", "y", "yaw", "v", "yaw_rate", "ax", "ay"):
        kind = rng.integers(5)
        values = [
            np.zeros(n),
            np.full(n, 7.5),
            rng.normal(size=n),
            1e3 * rng.normal(size=n),
            np.round(rng.normal(size=n)),
        ]
        column = values[kind] * (0.01 if name.endswith("_cmd") else 1.0)
        columns[name] = np.where(rng.random(n) < rng.choice([0.0, 0.5, 0.97]), np.nan, column)
    document: dict[str, Any] = {"where": []}
    complaint = ""
    try:
        document = compare(Log(columns), baseline()).as_dict()
    except (CompareError, ModelError) as error:
        complaint = str(error)
    assert "\n" not in complaint
    json.dumps(document)
    assert all(0.0 <= w["share_of_error"] <= 1.0 + 1e-9 for w in document["where"])


def test_model_that_breaks_is_refused_and_not_perfect(tmp_path: Path) -> None:
    file = tmp_path / "broken.py"
    file.write_text(
        "from vehicle.model.effect import Key, effect\n\n"
        '@effect(name="broken", slot="actuator", physics="a root of a negative number", equation="d = nan",\n'
        '        source="none", reveals="anything",\n'
        '        parameters=(Key("c", "-", 0.1, 1.0, neutral=0.0, least=0.1, meaning="none"),))\n'
        "def broken(x, p, m):\n    x.steer = x.steer + (x.vx - x.vx) / (x.vx - x.vx)\n",
        encoding="utf-8",
    )
    text = "[parameters]\nwheelbase = 2.45\n[[effect]]\nname = 'broken'\nparameters = { c = 0.5 }\n"
    with pytest.raises(CompareError, match=r"is not finite from t=0\.0"):
        compare(drive(), parse_model(text, extra=effects_of_file(file)))


def test_headline_says_by_how_much_the_measurement_is_late() -> None:
    assert "it comes 0.20 s later than in the model" in headline(compare(drive(steer_delay=0.2), baseline()))
    assert "later" not in headline(compare(drive(brake_gain=0.8), baseline()))


def test_an_offset_is_told_as_one_and_not_as_a_place() -> None:
    log = drive()
    log.columns["yaw_rate"] = log.columns["yaw_rate"] - 0.05
    text = headline(compare(log, baseline()))
    assert " misses yaw_rate by " in text
    told = re.search(r"; (\d+) % of it is one offset: measured minus modelled is (-0\.\d+) rad/s", text)
    assert told is not None
    assert int(told[1]) > 90
    assert float(told[2]) == pytest.approx(-0.05, abs=0.002)
    assert "one offset" not in headline(compare(drive(steer_delay=0.2), baseline()))


def test_headline_names_the_cause_and_says_what_follows_from_it() -> None:
    """A position that runs away with a wrong speed is further off than the speed, in units of its noise."""
    found = compare(drive(brake_gain=0.8), baseline())
    times = {name: score.chi2_per_n**0.5 for name, score in found.signals.items()}
    furthest = max(times, key=lambda name: times[name])
    assert furthest in ("x", "y")
    text = headline(found)
    assert " misses v by " in text
    assert f"({furthest} misses by {times[furthest]:.1f} times its noise, but follows from speed and turn rate)" in text
    one = dataclasses.replace(found, signals={"v": found.signals["v"]})
    assert "follows" not in headline(one)


def test_a_run_of_the_twin_is_judged_where_it_was_logged() -> None:
    """It logs what its reference point does, not what the accelerometer of the car feels 1.3 m ahead of it."""
    model = parse_model(
        '[model]\nbase = "dynamic_bicycle"\n[parameters]\nwheelbase = 2.6\nmass = 1200.0\nax_x = 1.3\nay_x = 1.3\n'
    )
    t = np.arange(0.0, 30.0, 0.01)
    commands = np.zeros((len(t), 6))
    commands[:, 0] = 0.05 * np.sin(2.0 * t)
    car = Plant(model)
    car.reset(VehicleState(t=0.0, x=0.0, y=0.0, yaw=0.0, v=8.0))
    rows = car.drive(commands, 10)[:-1]
    columns = {"t": t[1:]} | {
        name: rows[:, k].copy() for k, name in enumerate(TRACE_COLUMNS) if name in ("x", "y", "yaw", "v", "ax", "ay")
    }
    columns |= {"yaw_rate": rows[:, 8].copy(), "steer_cmd": commands[1:, 0].copy(), "accel_cmd": commands[1:, 1].copy()}
    run, recording = (compare(Log(dict(columns), meta=meta), model) for meta in ({"stage": "dt"}, {}))
    rmse = [float(np.sqrt(np.nanmean(found.residuals["ay"] ** 2))) for found in (run, recording)]
    assert rmse[0] < 0.05
    assert rmse[1] > 0.2  # about 1.3 m times r' of 0.3 rad/s^2
    ax = [float(np.sqrt(np.nanmean(found.residuals["ax"] ** 2))) for found in (run, recording)]
    assert ax[0] < 0.01 < ax[1]
