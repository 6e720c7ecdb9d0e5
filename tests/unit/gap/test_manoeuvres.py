"""Manoeuvres that decide: within the limits, by the physics that tells effects apart, as files that run."""

from __future__ import annotations

import csv
import dataclasses
import json
import math
import shlex
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.cli.command_line import main
from pytest_dvp.gap.diagnose.experiment import Values
from pytest_dvp.gap.manoeuvres import simulated_drive
from pytest_dvp.gap.manoeuvres.catalogue import MANOEUVRES, Manoeuvre, chosen
from pytest_dvp.gap.manoeuvres.choice import Choice, PlanError
from pytest_dvp.gap.manoeuvres.discrimination import Evidence, decide
from pytest_dvp.gap.manoeuvres.driving_limits import Area, Envelope
from pytest_dvp.gap.manoeuvres.exciting_manoeuvres import excite
from pytest_dvp.gap.manoeuvres.limit_violations import violations
from pytest_dvp.gap.manoeuvres.simulated_drive import Drive, columns, drive, perform, responder
from vehicle.model.car import make_car
from vehicle.model.effect import Effect, Key
from vehicle.model.vehicle_model import Inputs, VehicleModel

MODEL = VehicleModel(
    "kinematic_bicycle", Inputs(), make_car({"wheelbase": 2.45, "cg_to_front_axle": 1.15, "mass": 1150.0})
)
TIGHT = Envelope(
    max_speed=6.0, max_acceleration=1.0, max_deceleration=1.5, max_lateral=1.5, length=70.0, width=40.0, max_steer=0.35
)
MODEL_FILE = """
[model]
base = "kinematic_bicycle"
[inputs]
steer = "steer_cmd"
longitudinal = "accel_cmd"
[parameters]
wheelbase = 2.45
"""


def within(drive: Drive, envelope: Envelope) -> None:
    """Said anew, apart from the code under test: rear axle and wishes keep every limit."""
    x, y, _, v, rate = drive.motion.T
    assert np.ptp(x) <= envelope.length
    assert np.ptp(y) <= envelope.width
    assert x.min() >= drive.area.x_min
    assert x.max() <= drive.area.x_max
    assert y.min() >= drive.area.y_min
    assert y.max() <= drive.area.y_max
    assert v.max() <= envelope.max_speed
    assert v.min() >= 0.0
    assert np.max(np.abs(v * rate)) <= envelope.max_lateral
    accel, steer, _ = drive.wishes.T
    assert accel.max() <= envelope.max_acceleration
    assert accel.min() >= -envelope.max_deceleration
    assert np.max(np.abs(steer)) <= envelope.max_steer
    assert np.max(np.abs(np.diff(steer))) <= 0.02 * envelope.steer_rate + 2e-5  # the wish is rounded


@pytest.mark.parametrize("manoeuvre", MANOEUVRES, ids=lambda m: m.name)
@pytest.mark.nightly(by_day=4)
def test_a_manoeuvre_keeps_within_the_limits(manoeuvre: Manoeuvre) -> None:
    for envelope in (Envelope(), TIGHT):
        drive = perform(manoeuvre, MODEL, {}, envelope)
        if drive is None:
            assert manoeuvre.round_about, "circles need room"
            assert envelope is TIGHT
            continue
        within(drive, envelope)
        assert drive.motion[-1, 3] == 0.0, "it ends in a standstill"
        assert drive.motion[:, 3].max() >= 1.5, "it goes somewhere"


def test_a_car_that_answers_too_strongly_is_asked_for_less() -> None:
    strong = {("steer_ratio", "g"): 1.6, ("drive_gain", "g"): 1.2}
    for manoeuvre in MANOEUVRES[:2]:
        drive = perform(manoeuvre, MODEL, strong, Envelope())
        assert drive is not None
        assert drive.size < 1.0
        within(drive, Envelope())


def test_a_fast_car_is_braked_until_it_stands() -> None:
    """Gently from 26 m/s takes longer than 20 s."""
    fast = Envelope(max_speed=40.0, length=1000.0, width=200.0)
    found = drive(chosen(["slow_ramp"])[0], MODEL.car, responder(MODEL), fast, 0.55)
    assert found.finished
    assert found.motion[-1, 3] < 0.1


def test_a_drive_that_does_not_come_to_its_end_is_none_to_be_planned(monkeypatch: pytest.MonkeyPatch) -> None:
    (ramp,) = chosen(["slow_ramp"])
    whole = perform(ramp, MODEL, {}, Envelope())
    assert whole is not None
    monkeypatch.setattr(simulated_drive, "LONGEST", 0.5 * whole.seconds)
    assert not drive(ramp, MODEL.car, responder(MODEL), Envelope()).finished
    assert perform(ramp, MODEL, {}, Envelope(), (whole.size,)) is None


def test_leaving_the_limits_is_told() -> None:
    t = np.arange(0.0, 4.0, 0.02)
    v = 5.0 * t  # 5 m/s^2 up to 20 m/s
    motion = np.column_stack([2.5 * t**2, 0.0 * t, 0.0 * t, v, 0.3 + 0.0 * t])
    told = " ".join(violations(t, motion, 0.6 + 0.0 * t, Envelope(), Area(-10.0, 30.0, -5.0, 5.0), MODEL.car))
    for word in ("speed", "acceleration", "lateral", "steering", "area"):
        assert word in told
    still = np.zeros((len(t), 5))
    assert violations(t, still, 0.0 * t, Envelope(), Area(-10.0, 30.0, -5.0, 5.0), MODEL.car) == ()


def test_commands_take_the_form_of_the_models_inputs() -> None:
    pedals = dataclasses.replace(MODEL, inputs=Inputs(longitudinal=("throttle_cmd", "brake_cmd"), steer_scale=2.0))
    plain, by_pedals = (perform(MANOEUVRES[0], m, {}, Envelope()) for m in (MODEL, pedals))
    assert plain is not None
    assert by_pedals is not None
    np.testing.assert_allclose(by_pedals.motion, plain.motion, atol=1e-6)  # the same car, asked in another way
    named = columns(by_pedals, pedals.inputs)
    accel = 3.0 * named["throttle_cmd"] - 6.0 * named["brake_cmd"]  # full throttle and full brake [m/s^2]
    np.testing.assert_allclose(accel, by_pedals.wishes[:, 0], atol=1e-9)
    np.testing.assert_allclose(2.0 * named["steer_cmd"], by_pedals.wishes[:, 1], atol=1e-9)


@pytest.fixture(scope="module")
def lag_or_delay() -> Choice:
    known = {"steer_lag": {("steer_lag", "tau"): 0.15}, "steer_delay": {("steer_delay", "T"): 0.15}}
    return decide(MODEL, known, manoeuvres=chosen(["sine_sweep", "circles_left", "full_throttle"]))


def test_lag_and_delay_are_told_apart_by_fast_steering(lag_or_delay: Choice) -> None:
    """Both shift slow steering alike; at 2 Hz a lag of 0.15 s halves it, a delay does not."""
    assert lag_or_delay.manoeuvre.name == "sine_sweep"
    assert lag_or_delay.gap > 1.0
    assert lag_or_delay.repeats == 1
    assert not lag_or_delay.weak
    slow = lag_or_delay.ranking["circles_left"]
    assert lag_or_delay.ranking["sine_sweep"] > 10.0 * slow


def test_a_brake_that_saturates_is_told_from_a_weak_one_by_braking() -> None:
    known: dict[str, Values] = {"brake_limit": {}, "brake_gain": {}}
    drives = chosen(["brake_ramps", "circles_left", "full_throttle"])
    assert decide(MODEL, known, manoeuvres=drives).manoeuvre.name == "brake_ramps"


def test_what_the_logs_say_counts_beside_the_drive() -> None:
    evidence = Evidence(1000, {"a": 1000.0, "b": 1100.0})
    assert evidence.joint("a", "b", 0.0, 1000) == pytest.approx(0.05)  # 100 of 2000 samples
    assert evidence.joint("b", "a", 0.2, 1000) == pytest.approx(0.1)  # the logs say nothing for b
    assert evidence.joint("b", "a", 0.2, 1000, repeats=3) == pytest.approx(0.15)


def test_what_nobody_could_see_is_called_weak() -> None:
    known: dict[str, Values] = {"steer_delay": {}, "steer_lag": {}}
    assert decide(MODEL, known, {"x": 5.0, "y": 5.0}, manoeuvres=chosen(["step_steer"])).weak


def test_a_limit_is_shown_by_what_reaches_it() -> None:
    (found,) = excite(MODEL, ["power_limit"], manoeuvres=chosen(["full_throttle", "brake_ramps"]))
    assert found.manoeuvre.name == "full_throttle"


@pytest.mark.parametrize(("effect", "manoeuvre"), [("drive_gain", "full_throttle"), ("brake_gain", "brake_steps")])
def test_a_drive_that_shows_an_effect_keeps_within_the_limits_with_it(effect: str, manoeuvre: str) -> None:
    """A car that accelerates or brakes by 14 % more than the pedals say, at limits that the pedals reach."""
    (found,) = excite(MODEL, [effect], manoeuvres=chosen([manoeuvre]))
    stronger = MODEL.with_effect(effect, {"g": 1.14})
    driven = drive(found.manoeuvre, MODEL.car, responder(stronger), Envelope(), found.drive.size)
    assert violations(driven.t, driven.motion, driven.wishes[:, 1], Envelope(), driven.area, MODEL.car) == ()


def test_an_effect_of_the_users_own_can_be_asked_about() -> None:
    def soft(x: Any, p: Any, m: Any) -> None:
        x.steer *= 1.0 - p.c

    own = Effect(
        name="soft_steer", slot="command", physics="", equation="", source="", reveals="", function=soft,
        parameters=(Key("c", "-", 0.0, 0.5, neutral=0.0, least=0.01),),
    )  # fmt: skip
    drives = chosen(["step_steer", "slow_ramp"])
    known: dict[str, Values] = {"soft_steer": {}, "steer_lag": {}}
    assert decide(MODEL, known, effects=(own,), manoeuvres=drives).gap > 0.15
    (found,) = excite(MODEL, ["soft_steer"], effects=(own,), manoeuvres=drives)
    assert found.effects == ("soft_steer",)


def test_one_drive_for_what_one_drive_shows() -> None:
    (found,) = excite(MODEL, ["brake_limit", "brake_gain"], manoeuvres=chosen(["brake_ramps", "full_throttle"]))
    assert set(found.effects) == {"brake_limit", "brake_gain"}
    assert found.manoeuvre.name == "brake_ramps"


@pytest.mark.parametrize(
    ("names", "said"),
    [
        (["steer_lg", "steer_delay"], "steer_lag"),
        (["steer_lag"], "nothing to decide"),
        (["steer_lag", "detection_noise"], "does not act on this model"),
    ],
)
def test_what_cannot_be_planned_is_one_line(names: list[str], said: str) -> None:
    with pytest.raises(PlanError, match=said) as caught:
        decide(MODEL, {name: {} for name in names})
    assert "\n" not in str(caught.value)


@pytest.fixture(scope="module")
def planned(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("plan")
    (folder / "car.toml").write_text(MODEL_FILE)
    arguments = ["plan", "--model", str(folder / "car.toml"), "--between", "brake_limit,brake_gain"]
    arguments += ["--only", "brake_ramps"]
    assert main([*arguments, "--out", str(folder / "plan")]) == 0
    return folder


def test_the_scenario_is_sound_and_plays_the_drive(planned: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (scenario,) = (planned / "plan").glob("*.xosc")
    assert main(["check", str(planned / "plan"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["findings"] == []
    rows = planned / "played.csv"
    assert main(["play", str(scenario), "--csv", str(rows), "--duration", "200"]) == 0
    with rows.open() as stream:
        played = {row["time"]: row for row in csv.DictReader(stream)}
    with next((planned / "plan").glob("*_commands.csv")).open() as stream:
        for row in list(csv.DictReader(stream))[::250]:
            at = played[f"{float(row['t [s]']):.6f}"]
            assert (
                math.hypot(float(at["x"]) - float(row["planned_x [m]"]), float(at["y"]) - float(row["planned_y [m]"]))
                < 0.1
            )


@pytest.mark.nightly
def test_the_robot_drives_the_plan_in_the_closed_loop(planned: Path, capsys: pytest.CaptureFixture[str],
                                                      monkeypatch: pytest.MonkeyPatch) -> None:  # fmt: skip
    (scenario,) = (planned / "plan").glob("*.xosc")
    monkeypatch.chdir(planned)
    robot = f"plan/{scenario.stem}_robot.py:Robot"
    options = ["--ads", robot, "--model", "car.toml", "--no-report", "--duration", "200", "--json"]
    assert main(["run", str(scenario), *options]) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["status"] == "PASS"
    assert result["ended"] == "the stop trigger"


def test_the_card_says_what_to_drive_record_and_repeat(planned: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["plan", "--model", str(planned / "car.toml"), "--excite", "power_limit", "--out", str(planned / "two")]
    arguments += ["--only", "full_throttle"]
    assert main(arguments) == 0
    card = capsys.readouterr().out
    for word in ("why", "where", "speed", "steering", "record", "means", "100 x 60 m", "accel_cmd", "50 Hz", ".xosc"):
        assert word in card
    assert f"dvp diagnose LOG... full_throttle.csv --model {planned / 'car.toml'}" in card
    assert "MODEL.toml" not in card
    page = next((planned / "two").glob("*_card.html")).read_text()
    assert page.count("<svg") == 4
    assert "http" not in page.replace("http-equiv", "")


@pytest.mark.parametrize(
    ("driven", "unit", "rehearsed"),
    [("v", "m/s", False), ("throttle_cmd + brake_pressure", "Pa", True), ("motor_current", "A", False)],
)
def test_a_rehearsal_is_offered_where_a_stack_can_drive_the_model_and_commands_have_their_unit(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], driven: str, unit: str, rehearsed: bool
) -> None:
    (tmp_path / "car.toml").write_text(MODEL_FILE.replace('"accel_cmd"', f'"{driven}"'))
    arguments = ["plan", "--model", str(tmp_path / "car.toml"), "--drive", "circles_left", "--out", str(tmp_path / "p")]
    assert main(arguments) == 0
    card = capsys.readouterr().out
    assert ("  rehearse dvp run " in card) == rehearsed
    assert ("  rehearse not by dvp run: a driving stack has no " in card) != rehearsed
    head = (tmp_path / "p" / "circles_left_commands.csv").read_text().splitlines()[0].split(",")
    assert f"{driven.split(' + ')[-1]} [{unit}]" in head


def test_limits_are_obeyed_and_wrong_ones_refused(planned: Path, capsys: pytest.CaptureFixture[str]) -> None:
    model = ["plan", "--model", str(planned / "car.toml"), "--excite", "steer_ratio"]
    model += ["--only", "full_lock"]
    assert main([*model, "--max-speed", "-3"]) == 2
    assert "--max-speed is -3" in capsys.readouterr().err
    assert main(["plan", "--model", str(planned / "car.toml")]) == 2
    assert "nothing to plan for" in capsys.readouterr().err
    assert main(["plan", "--model", str(planned / "car.toml"), "--excite", "steer_ratoi"]) == 2
    assert "--excite: no effect called 'steer_ratoi', did you mean 'steer_ratio'" in capsys.readouterr().err
    assert main([*model[:-1], "ful_lock"]) == 2
    assert "did you mean 'full_lock'" in capsys.readouterr().err
    assert main([*model, "--max-speed", "7", "--out", str(planned / "slow"), "--json"]) == 0
    (manoeuvre,) = json.loads(capsys.readouterr().out)["manoeuvres"]
    assert manoeuvre["max_speed"] <= 7.0


def test_the_same_question_has_the_same_bytes(planned: Path) -> None:
    arguments = ["plan", "--model", str(planned / "car.toml"), "--between", "brake_limit,brake_gain"]
    arguments += ["--only", "brake_ramps"]
    assert main([*arguments, "--out", str(planned / "again")]) == 0
    for first in filter(Path.is_file, (planned / "plan").iterdir()):
        assert (planned / "again" / first.name).read_bytes() == first.read_bytes()


def test_manoeuvres_are_written_by_name(planned: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A steady circle of ISO 4138: on most of its way the steering stands still while the car turns."""
    out = planned / "named"
    model = ["plan", "--model", str(planned / "car.toml"), "--out", str(out)]
    assert main([*model, "--drive", "circles_left", "--json"]) == 0
    (entry,) = json.loads(capsys.readouterr().out)["manoeuvres"]
    assert (entry["manoeuvre"], entry["purpose"], entry["effects"]) == ("circles_left", "named", [])
    commands = np.genfromtxt(entry["files"]["commands"], delimiter=",", names=True, deletechars="")
    steer = commands[next(name for name in commands.dtype.names if name.startswith("wanted_steer"))]
    _, counts = np.unique(steer[steer > 0.02], return_counts=True)
    assert counts.max() > 0.8 * counts.sum()
    assert main([*model, "--drive", "circle_left"]) == 2
    assert "did you mean 'circles_left'" in capsys.readouterr().err


@pytest.mark.parametrize("asked", [("--drive", "full_throttle"), ("--excite", "mass")])
def test_a_car_that_no_command_moves_has_no_manoeuvre(
    planned: Path, asked: tuple[str, str], capsys: pytest.CaptureFixture[str]
) -> None:
    """It stood for 33 s, and its card said so many seconds of full throttle."""
    text = (planned / "car.toml").read_text()
    assert 'longitudinal = "accel_cmd"' in text
    (planned / "idle.toml").write_text(text.replace('"accel_cmd"', '"speed_cmd"'))
    out = planned / "idle"
    assert main(["plan", "--model", str(planned / "idle.toml"), *asked, "--out", str(out)]) == 2
    assert 'idle.toml: longitudinal = "speed_cmd" drives nothing' in capsys.readouterr().err
    assert not out.exists()


def test_printed_commands_run_as_they_stand(
    planned: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """In a folder with a space in its name, with the logs that judge, and the effects of the user's own."""
    from pytest_dvp.cli import plan
    from pytest_dvp.gap.manoeuvres.advice import Advice
    from pytest_dvp.gap.manoeuvres.choice import as_named

    choices = as_named(chosen(["step_steer"]), MODEL, Envelope())
    found = SimpleNamespace(noise_floor=None, verdict="NOT_EXCITED", effects=())
    for name in ("read_all", "refuse_same_drive", "check_command_columns", "existing_log"):
        monkeypatch.setattr(plan, name, lambda *_: {})
    monkeypatch.setattr(plan, "select_parts", lambda *_: SimpleNamespace(logs={}, said=""))
    monkeypatch.setattr("pytest_dvp.gap.diagnose.diagnose.diagnose", lambda *_, **__: found)
    monkeypatch.setattr("pytest_dvp.gap.manoeuvres.advice.advise", lambda *_, **__: Advice({}, choices, ()))
    own = planned / "own.py"
    own.write_text(
        "from vehicle.model.effect import Key, effect\n"
        '@effect(name="mine", slot="command", physics="", equation="", source="", reveals="",\n'
        '        parameters=(Key("c", "-", 0.0, 1.0, neutral=0.0, least=0.1),))\n'
        "def mine(x, p, m):\n    x.steer += p.c\n"
    )
    model, out = str(planned / "car.toml"), planned / "my plan"
    asked = ["plan", "a.csv", "--held-out", "b c.csv", "--model", model, "--effects", str(own), "--out", str(out)]
    assert main(asked) == 0
    lines = {line[2:10].strip(): line[11:] for line in capsys.readouterr().out.splitlines()}
    scenario, robot = out / "step_steer.xosc", out / "step_steer_robot.py"
    run = ["dvp", "run", str(scenario), "--ads", f"{robot}:Robot", "--model", model, "--effects", str(own)]
    assert shlex.split(lines["rehearse"])[:-1] == [*run, "--duration"]
    then = ["dvp", "diagnose", "a.csv", "step_steer.csv", "--model", model, "--held-out", "b c.csv"]
    assert shlex.split(lines["then"]) == [*then, "--effects", str(own)]


@pytest.mark.parametrize("option", ["--between", "--excite", "--drive"])
def test_logs_that_judge_a_diagnosis_are_refused_where_there_is_none(
    planned: Path, option: str, capsys: pytest.CaptureFixture[str]
) -> None:
    judge = planned / "judge.csv"
    judge.write_text("t [s],v [m/s]\n0,1\n")
    asked = ["--model", str(planned / "car.toml"), "--held-out", str(judge), "--out", str(planned / "none")]
    assert main(["plan", option, "steer_lag,steer_delay", *asked]) == 2
    assert f"--held-out: judges a diagnosis, and with {option} there is none" in capsys.readouterr().err
