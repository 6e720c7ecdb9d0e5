"""A law that no catalogue has: found, told, written as an effect file, and used."""

from __future__ import annotations

import json
import shlex
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pytest_dvp.cli.command_line import main
from pytest_dvp.gap.discover.discover import discover
from pytest_dvp.gap.discover.factors import FACTORS, unit_text
from pytest_dvp.gap.discover.forms import forms, terms_at
from pytest_dvp.gap.discover.law import FoundTerm, Law
from pytest_dvp.gap.discover.term import POINTS, Form, Term
from pytest_dvp.logs.log import Log
from vehicle.model.effect import Effect, Key
from vehicle.model.effect_catalogue import effects_of_files
from vehicle.model.model_file import parse_model
from vehicle.model.open_loop import Replay

SHEET = '[model]\nbase = "kinematic_bicycle"\n[parameters]\nwheelbase = 2.7\nmass = 1500.0\n'
NOISE = {"x": 0.02, "y": 0.02, "yaw": 0.005, "v": 0.03, "yaw_rate": 0.005, "ax": 0.1, "ay": 0.1}


def _torque_steer(x: Any, p: Any, m: Any) -> None:
    if x.accel > 0.0:
        x.steer += p.c * x.accel


TORQUE_STEER = Effect(
    name="torque_steer", slot="command", physics="", equation="d += c a+", source="", reveals="", order=80,
    parameters=(Key("c", "rad s^2/m", 0.0, 0.1, neutral=0.0, least=0.001),), function=_torque_steer,
)  # fmt: skip


def drive(c: float, seed: int, seconds: float = 24.0) -> Log:
    """Commands that change every two seconds, and what a car with torque steer shows of them."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, seconds, 0.02)
    part = (t // 2.0).astype(int)
    accel = rng.choice([-1.5, 0.0, 1.0, 2.0], part[-1] + 1)[part]
    steer = np.interp(t, np.arange(0.0, seconds + 1.0), rng.uniform(-0.15, 0.15, int(seconds) + 1))
    accel = np.where(t < 4.0, 2.0, accel)
    commands = {"accel_cmd": accel, "steer_cmd": steer}
    replay = Replay(parse_model(SHEET), t, commands, extra=[TORQUE_STEER])
    rows = replay.run({("torque_steer", "c"): c}, starts=np.array([0]), states=np.array([[0.0] * 4 + [np.nan] * 2]))
    noisy = {name: rows[:, k] + sigma * rng.standard_normal(len(t)) for k, (name, sigma) in enumerate(NOISE.items())}
    return Log({"t": t, **commands, **noisy})


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("discover")
    (folder / "car.toml").write_text(SHEET)
    for name, seed in (("fit.csv", 1), ("judge.csv", 2)):
        log = drive(0.01, seed)
        units = {"t": "s", "accel_cmd": "m/s^2", "steer_cmd": "rad", "x": "m", "y": "m", "yaw": "rad", "v": "m/s"}
        units |= {"yaw_rate": "rad/s", "ax": "m/s^2", "ay": "m/s^2"}
        names = ["t", *(n for n in log.columns if n != "t")]
        table = np.column_stack([log.columns[n] for n in names])
        header = ",".join(f"{n} [{units[n]}]" for n in names)
        np.savetxt(folder / name, table, delimiter=",", header=header, comments="", fmt="%.9g")
    return folder


@pytest.mark.nightly
def test_the_law_is_found_written_and_used(logs: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = logs / "law.py"
    asked = ["--model", str(logs / "car.toml"), "--held-out", str(logs / "judge.csv")]
    assert main(["discover", str(logs / "fit.csv"), *asked, "--out", str(out), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["verdict"] == "LAW"
    assert found["points"] == ["steer"]
    (term,) = found["terms"]
    assert (term["form"], term["c"]["unit"]) == ("a+", "s^2 rad/m")
    assert term["c"]["low"] <= 0.01 <= term["c"]["high"]
    assert found["error"]["held_out"]["removed"] > 0.9
    assert len(out.read_text().splitlines()) < 30
    extended = ["--effects", str(out), "--add", "law_steer", "--out", str(logs / "car2.toml")]
    assert main(["extend", *asked, "--fit", str(logs / "fit.csv"), *extended, "--json"]) == 0
    (effect,) = json.loads(capsys.readouterr().out)["effects"]
    assert effect["parameters"]["c1"]["value"] == pytest.approx(0.01, rel=0.03)


def test_where_nothing_is_left_there_is_no_law() -> None:
    law = discover({"a": drive(0.0, 3)}, parse_model(SHEET), {"b": drive(0.0, 4)})
    assert law.verdict == "NO_LAW"
    assert "nothing is left" in law.reasons[0]


@pytest.mark.parametrize("wrong", ["law.txt", "missing/law.py"])
def test_a_wrong_place_is_said_before_any_work(logs: Path, wrong: str, capsys: pytest.CaptureFixture[str]) -> None:
    asked = ["--model", str(logs / "car.toml"), "--held-out", str(logs / "judge.csv"), "--out", str(logs / wrong)]
    assert main(["discover", str(logs / "fit.csv"), *asked]) == 2
    assert "--out" in capsys.readouterr().err


OWN = """from vehicle.model.effect import Key, effect
@effect(name="law_steer", slot="command", physics="", equation="", source="", reveals="",
        parameters=(Key("c", "-", 0.0, 1.0, neutral=0.0, least=0.1),))
def law_steer(x, p, m):
    x.steer += p.c
"""


def test_a_file_that_is_read_is_not_written_over(logs: Path, capsys: pytest.CaptureFixture[str]) -> None:
    own = logs / "own.py"
    own.write_text(OWN)
    asked = ["--model", str(logs / "car.toml"), "--held-out", str(logs / "judge.csv"), "--effects", str(own)]
    assert main(["discover", str(logs / "fit.csv"), *asked, "--out", str(own)]) == 2
    assert f"--out {own} is a file that is read" in capsys.readouterr().err
    assert own.read_text() == OWN


def test_the_command_that_uses_a_law_has_what_was_needed_to_find_it(
    logs: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The effects and the map of the search; the file has another name for its law than the effects given."""
    own, columns, out = logs / "own.py", logs / "map.toml", logs / "law.py"
    own.write_text(OWN)
    columns.write_text('[signals]\nv = "v [m/s]"\n')
    term = Term(next(p for p in POINTS if p.name == "steer"), Form(("a+",)), c=1.0)
    law = Law("LAW", (FoundTerm(term, 0.0, 1.0),), ("steer",), (3.0, 3.0), (1.0, 1.0), ())
    monkeypatch.setattr("pytest_dvp.gap.discover.discover.discover", lambda *a, **k: law)
    monkeypatch.setattr("pytest_dvp.cli.discover.read_all", lambda texts, arguments: {t: drive(0.0, 1) for t in texts})
    monkeypatch.setattr("pytest_dvp.cli.discover.refuse_same_drive", lambda *a: None)
    read = ["--effects", str(own), "--map", str(columns)]
    asked = ["--model", str(logs / "car.toml"), "--held-out", str(logs / "judge.csv"), *read]
    assert main(["discover", str(logs / "fit.csv"), *asked, "--out", str(out)]) == 0
    words = shlex.split(capsys.readouterr().out.splitlines()[-1].split("use it: ")[1])
    assert words[:2] == ["dvp", "extend"]
    assert [words[k + 1] for k, word in enumerate(words) if word == "--effects"] == [str(out), str(own)]
    assert words[words.index("--map") + 1] == str(columns)
    assert words[words.index("--add") + 1] == "law_steer_2"
    assert set(effects_of_files([own, out])) == {"law_steer", "law_steer_2"}


@pytest.mark.parametrize(("unit", "text"), [((1, -2, 0), "m/s^2"), ((0, 0, 0), "-"), ((-1, 2, 1), "s^2 rad/m")])
def test_units_are_written_as_people_do(unit: tuple[int, int, int], text: str) -> None:
    assert unit_text(unit) == text


def test_a_coefficient_has_the_unit_that_makes_its_term_sound() -> None:
    steer = next(p for p in POINTS if p.name == "steer")
    brake = next(p for p in POINTS if p.name == "brake")
    assert Term(steer, Form(("v", "d"))).unit == "s/m"
    assert Term(brake, Form(("a-",), ("v", "a-"), "lag")).unit == "s^3/m^2"


def test_forms_are_unique_and_lead_where_symmetry_lets_them() -> None:
    assert len({form.text for form in forms()}) == len(forms())
    for point in POINTS:
        for term in terms_at(point):
            pulls = not term.form.filter and len(term.form.gate) <= 2
            assert term.form.odd == point.odd or (point.odd and pulls)
    assert {factor.name for factor in FACTORS if factor.odd} == {"d", "ay", "r", "tanh(r)"}
