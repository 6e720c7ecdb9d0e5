"""What the page of a diagnosis is made of: a drive of a car that brakes less than its model believes."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from gap_logs import NOISE, baseline, drive

from pytest_dvp.cli.command_line import main
from pytest_dvp.gap.diagnose.diagnose import diagnose
from pytest_dvp.gap.words.diagnosis_page import Typed, _whole, diagnosis_page
from tests.truth.generate import make_log, write_csv
from vehicle.model.model_file import parse_model

GAIN = 0.85


@pytest.fixture(scope="module")
def page() -> dict[str, Any]:
    logs, held_out = {"a.csv": drive(brake_gain=GAIN)}, {"b.csv": drive(brake_gain=GAIN, seed=2)}
    found = dataclasses.replace(diagnose(logs, baseline(), held_out=held_out), null_line=0.5)
    typed = Typed("models/car.toml", ["logs/a.csv"], ["logs/b.csv"])
    return diagnosis_page(found, logs, baseline(), held_out=held_out, typed=typed)


def test_the_effect_comes_with_its_physics_and_value(page: dict[str, Any]) -> None:
    (effect,) = page["effects"]
    assert effect["name"] == "brake_gain"
    assert effect["equation"] == "a = a_c + (g - 1)(a_c + a_motor) for a_c < -a_motor, else a_c"
    gain, motor = sorted(effect["parameters"], key=lambda one: str(one["key"]))
    assert float(gain["value"]) == pytest.approx(GAIN, abs=0.01)
    assert float(motor["value"]) == 0.0  # no motor takes anything over


def test_shares_are_told_for_fitted_and_held_out_data(page: dict[str, Any]) -> None:
    (effect,) = page["effects"]
    for data in ("fit", "held_out"):
        share = effect[data]
        assert 0.9 < share["low"] <= share["value"] <= share["high"] <= 1.0


def test_the_null_line_stands_where_luck_would_lead(page: dict[str, Any]) -> None:
    assert page["null_line"] == pytest.approx(page["ladder"][0]["fit"] - 0.5)


def test_the_clearest_seconds_are_a_braking(page: dict[str, Any]) -> None:
    """At -2 m/s^2 for 5 s a brake of 85 % leaves 0.3 m/s^2 x 5 s = 1.5 m/s at the end; then only noise."""
    close = page["close"]
    assert close["channel"] == "v"
    assert np.nanmax(np.abs(close["before"] - close["measured"])) > 10.0 * NOISE["v"]
    assert np.nanstd(close["after"] - close["measured"]) == pytest.approx(NOISE["v"], rel=0.2)


def test_the_difference_is_drawn_where_there_is_one(page: dict[str, Any]) -> None:
    fitted, judged = page["over_time"]
    assert (fitted["log"], fitted["held_out"], judged["held_out"]) == ("a.csv", False, True)
    assert "yaw_rate" in fitted["quiet"]
    assert {"v", "along"} <= set(fitted["rows"])
    for row in fitted["rows"].values():
        assert np.nanstd(row["after"]) <= np.nanstd(row["before"])


def test_what_one_level_of_braking_cannot_tell_apart_is_not_in_the_command(page: dict[str, Any]) -> None:
    """Always -2 m/s^2: a weaker brake and a limit of the brake do the same."""
    (effect,) = page["effects"]
    assert (effect["standing"], [r["name"] for r in effect["rivals"]]) == ("provisional", ["brake_limit"])
    assert page["command"] == ""
    assert any("added by name only: brake_gain" in line for line in page["remarks"])
    assert {"--model", "--fit", "--out"} < set(page["trial"].split())
    assert "--add brake_gain" in page["trial"]


@pytest.mark.nightly
def test_the_ladder_begins_with_the_model_as_given_where_an_effect_is_to_go() -> None:
    """A bias that the car does not have: 0.03 rad of heading at a noise of 0.005 rad is chi^2/N 37 of that channel."""
    model = parse_model(
        "[model]\n[parameters]\nwheelbase = 2.5\ncg_to_front_axle = 1.2\nmass = 1200.0\n"
        "[[effect]]\nname = 'heading_bias'\n[effect.parameters.b]\nvalue = 0.03\nunit = 'rad'\n"
    )
    logs = {"a.csv": drive()}
    found = diagnose(logs, model, held_out={"b.csv": drive(seed=2)})
    assert [(e.name, e.action) for e in found.effects] == [("heading_bias", "remove")]
    assert [step.added for step in found.ladder] == ["", "heading_bias"]
    assert found.ladder[0].channels["yaw"] > 5.0
    assert found.ladder[1].channels["yaw"] == pytest.approx(1.0, abs=0.15)
    page = diagnosis_page(dataclasses.replace(found, null_line=0.1), logs, model)
    assert [step["label"] for step in page["ladder"]] == ["model as given", "- heading_bias"]
    assert page["effects"][0]["fit"]["value"] == pytest.approx(1.0, abs=0.1)
    assert "--remove heading_bias" in page["command"]


def test_a_model_that_lacks_nothing_shows_its_worst_seconds_and_no_command() -> None:
    logs = {"a.csv": drive()}
    page = diagnosis_page(diagnose(logs, baseline(), held_out={"b.csv": drive(seed=2)}), logs, baseline())
    assert page["verdict"] == "NOTHING_MISSING"
    assert page["command"] == ""
    assert page["close"]["channel"] in ("v", "yaw_rate", "ax", "ay")


def test_the_command_line_writes_the_page_and_stays_json(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    model, log, report = tmp_path / "car.toml", tmp_path / "urban.csv", tmp_path / "page.html"
    model.write_text("[model]\n[parameters]\nwheelbase = 2.45\ncg_to_front_axle = 1.15\nmass = 1150.0\n")
    write_csv(log, make_log({"brake_gain": {"g": 0.8}}, "urban", seed=1, noise="mid"))
    assert main(["diagnose", str(log), "--model", str(model), "--report", str(report), "--json"]) == 0
    out = capsys.readouterr()
    assert [e["name"] for e in json.loads(out.out)["effects"]] == ["brake_gain"]
    assert f"report in {report}" in out.err
    assert "brake_gain" in report.read_text(encoding="utf-8")


def test_a_reason_that_the_terminal_breaks_is_one_paragraph_of_the_page() -> None:
    lines = ["provisional, roll: a rival votes;", "    much is left over in ay", "provisional, mass: alike"]
    assert _whole(lines) == ["provisional, roll: a rival votes; much is left over in ay", "provisional, mass: alike"]
