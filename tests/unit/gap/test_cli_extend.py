"""dvp extend as a user types it."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import re
import shlex
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pytest_dvp.cli.command_line import main
from pytest_dvp.gap.extend import extend as extend_module
from pytest_dvp.gap.extend import growth
from pytest_dvp.gap.extend.twin_remainder import with_shape
from tests.truth.generate import make_log, write_csv
from vehicle.model.model_file import read_model

INPUTS = '[inputs]\nsteer = "steer_cmd"\nlongitudinal = "accel_cmd"\n'
CAR = INPUTS + "[parameters]\nwheelbase = 2.45\ncg_to_front_axle = 1.15\nmass = 1150.0\nyaw_inertia = 1400.0\n"
GATES = '[[gate]]\nmodel = "car.toml"\nrmse = { yaw_rate = 0.01, v = 0.05 }\nstages = ["rw"]\n'


@pytest.fixture(scope="module")
def drives(tmp_path_factory: pytest.TempPathFactory) -> Mapping[str, bytes]:
    """Town drives of a car that steers 0.2 s late, and of one that does not."""
    path = tmp_path_factory.mktemp("drives") / "log.csv"
    found = {}
    for name, delay, seed in (("one.csv", 0.2, 1), ("two.csv", 0.2, 2), ("prompt.csv", 0.0, 3)):
        write_csv(path, make_log({"steer_delay": {"T": delay}} if delay else {}, "urban", seed))
        found[name] = path.read_bytes()
    return found


@pytest.fixture(scope="module", autouse=True)
def _without_shape() -> Iterator[None]:
    """What a remainder looks like takes nine tenths of an extension; the first test has it."""
    with pytest.MonkeyPatch.context() as patch:
        for module in (extend_module, growth):
            patch.setattr(module, "with_shape", lambda twin, *more: twin)
        yield


@pytest.fixture
def here(tmp_path: Path, drives: Mapping[str, bytes], monkeypatch: pytest.MonkeyPatch) -> Path:
    for name, text in drives.items():
        (tmp_path / name).write_bytes(text)
    (tmp_path / "car.toml").write_text(CAR)
    (tmp_path / "car.gates.toml").write_text(GATES)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def extend(*words: str, add: str = "steer_delay") -> int:
    named = ["--add", add] if add else []
    return main(["extend", "--model", "car.toml", *named, "--out", "new.toml", *words])


def document(capsys: pytest.CaptureFixture[str]) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(capsys.readouterr().out)
    return found


def test_new_model_is_written_with_interval_and_provenance_and_the_ladder_shows_both_kinds_of_data(
    here: Path, drives: Mapping[str, bytes], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(extend_module, "with_shape", with_shape)
    assert extend("--fit", "one.csv", "--held-out", "two.csv") == 0
    (applied,) = read_model(here / "new.toml").effects
    interval = applied.intervals["T"]
    assert applied.values["T"] == pytest.approx(0.2, rel=0.02)
    assert interval.low < 0.2 < interval.high
    assert applied.fitted_on == (f"one.csv sha256:{hashlib.sha256(drives['one.csv']).hexdigest()}",)
    out = capsys.readouterr().out
    rows = [re.split(r"\s{2,}", line)[:2] for line in out.splitlines()]
    assert [row for row in rows if row[0] in ("fit", "held out")] == [
        ["fit", "model as given"], ["fit", "+ steer_delay"], ["held out", "model as given"],
        ["held out", "+ steer_delay"],
    ]  # fmt: skip
    assert "yaw_rate [rad/s]" in out
    assert "stop here" in out


@pytest.mark.parametrize("left", [{}, {"v": {"cruise": 0.1}}])
def test_a_twin_that_leaves_something_can_learn_from_the_logs_that_judged_it_as_the_last_line_says(
    here: Path, left: Any, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(extend_module, "with_shape", lambda twin, *more: dataclasses.replace(twin, remainder=left))
    assert extend("--fit", "one.csv", "--held-out", "two.csv") == 0
    said = "dvp extend: to learn from the held-out logs as well, now that they have judged it: "
    lines = [line for line in capsys.readouterr().err.splitlines() if line.startswith(said)]
    assert lines == (
        [f"{said}dvp extend --model new.toml --grow --fit one.csv two.csv --out new.all.toml"] if left else []
    )
    assert extend("--fit", "one.csv") == 0
    assert said not in capsys.readouterr().err
    if left:
        assert main(shlex.split(lines[0].removeprefix(said))[1:]) == 0
        assert read_model(here / "new.all.toml").effects[0].values["T"] == pytest.approx(0.2, rel=0.02)


def test_what_the_user_wrote_stays(here: Path) -> None:
    mine = CAR.replace("mass = 1150.0", "mass = 1150.0  # weighed") + "\n# to be found: what is slow\n"
    (here / "car.toml").write_text(mine)
    assert extend("--fit", "one.csv") == 0
    assert (here / "new.toml").read_text().startswith(mine.rstrip() + '\n\n[[effect]]\nname = "steer_delay"\n')


def test_file_and_document_hold_the_same_values(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert extend("--fit", "one.csv@0:30", "--held-out", "one.csv@30:", "--json") == 0
    estimate = document(capsys)["effects"][0]["parameters"]["T"]
    (applied,) = read_model(here / "new.toml").effects
    assert estimate == {"value": applied.values["T"], "low": applied.intervals["T"].low,
                        "high": applied.intervals["T"].high, "unit": "s"}  # fmt: skip
    assert applied.fitted_on[0].startswith("one.csv@0:30 sha256:")


@pytest.mark.nightly
def test_compare_shows_the_fall(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    extend("--fit", "one.csv")
    left = {}
    for model in ("car.toml", "new.toml"):
        capsys.readouterr()
        assert main(["compare", "two.csv", "--model", model, "--json"]) == 0
        left[model] = document(capsys)["signals"]["yaw_rate"]["chi2_per_n"]
    assert left["car.toml"] > 5.0
    assert left["new.toml"] == pytest.approx(1.0, abs=0.15)


@pytest.mark.nightly
def test_without_add_what_the_diagnosis_names_is_added(here: Path) -> None:
    assert extend("--fit", "one.csv", "two.csv", add="") == 0
    assert [a.name for a in read_model(here / "new.toml").effects] == ["steer_delay"]


@pytest.mark.nightly
def test_diagnosis_of_a_file_is_added(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    main(["diagnose", "one.csv", "--model", "car.toml", "--json"])
    (here / "found.json").write_text(capsys.readouterr().out)
    assert extend("--from", "found.json", "--fit", "one.csv", add="") == 0
    assert [a.name for a in read_model(here / "new.toml").effects] == ["steer_delay"]


def found_by_hand(here: Path, *effects: tuple[str, str], set_up: Sequence[str] = ()) -> None:
    """A document of `dvp diagnose --json` that names these (effect, action)."""
    entries = [{"name": name, "action": action} for name, action in effects]
    (here / "found.json").write_text(json.dumps({"effects": entries, "set_up": {"names": list(set_up)}}))


def test_of_a_diagnosis_only_what_is_confirmed_is_added(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    entries = [
        {"name": "steer_delay", "action": "add", "standing": "confirmed", "doubts": []},
        {"name": "brake_gain", "action": "add", "standing": "provisional", "doubts": ["it has a rival"]},
    ]
    (here / "found.json").write_text(json.dumps({"verdict": "PARTIAL", "effects": entries}))
    assert extend("--from", "found.json", "--fit", "one.csv", add="") == 0
    assert [a.name for a in read_model(here / "new.toml").effects] == ["steer_delay"]
    said = capsys.readouterr()
    assert "brake_gain: left, as provisional (it has a rival); --add brake_gain adds it" in said.err + said.out


def test_where_nothing_is_confirmed_the_file_is_a_copy(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    entry = {"name": "brake_gain", "action": "add", "standing": "provisional", "doubts": ["it has a rival"]}
    (here / "found.json").write_text(json.dumps({"verdict": "PARTIAL", "effects": [entry]}))
    assert extend("--from", "found.json", "--fit", "one.csv", add="") == 0
    assert (here / "new.toml").read_bytes() == (here / "car.toml").read_bytes()
    assert "PARTIAL; brake_gain: left, as provisional" in capsys.readouterr().err


def test_of_a_diagnosis_what_the_logs_give_no_value_for_is_told_and_left(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Detections that were judged beside a run of the twin, and a zero that is of the run."""
    named = ("steer_delay", "detection_noise", "gyro_bias")
    found_by_hand(here, *((name, "add") for name in named), set_up=["gyro_bias"])
    assert extend("--from", "found.json", "--fit", "one.csv", add="") == 0
    assert [a.name for a in read_model(here / "new.toml").effects] == ["steer_delay"]
    shown = capsys.readouterr()
    assert "gyro_bias: left, as of the run" in shown.err
    assert "note: detection_noise: left, as the detections of the logs fitted on give no value" in shown.out


def test_a_diagnosis_of_nothing_but_detections_writes_nothing(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found_by_hand(here, ("detection_noise", "add"))
    assert extend("--from", "found.json", "--fit", "one.csv", add="") == 1
    assert "new.toml is not written: detection_noise: left" in capsys.readouterr().err


LATE = CAR + '[[effect]]\nname = "steer_delay"\n[effect.parameters.T]\nvalue = {}\nunit = "s"\n'


def test_an_effect_that_the_model_has_is_fitted_again(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (here / "car.toml").write_text(LATE.format(0.1))
    assert extend("--fit", "one.csv") == 0
    assert "car.toml has steer_delay already: its value is fitted again" in capsys.readouterr().err
    assert read_model(here / "new.toml").value("steer_delay", "T") == pytest.approx(0.2, rel=0.02)


def test_an_effect_whose_value_is_right_already_stays_as_it_is(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (here / "car.toml").write_text(LATE.format(0.2))
    assert extend("--fit", "one.csv") == 1
    said = capsys.readouterr().err
    assert "steer_delay is in the model already, and another value gains too little: chi²/N " in said
    assert "without" not in said


def test_an_effect_to_remove_that_the_model_lacks_is_told_beside_those_it_has(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (here / "car.toml").write_text(LATE.format(0.1))
    assert extend("--fit", "one.csv", "--remove", "brake_lag", add="") == 2
    assert capsys.readouterr().err == "--remove: car.toml does not have brake_lag; it has steer_delay\n"
    assert extend("--fit", "one.csv", "--remove", "brake_lg", add="") == 2
    assert "unknown effect 'brake_lg', did you mean 'brake_lag'?" in capsys.readouterr().err


def test_columns_that_are_assumed_to_drive_the_model_are_said(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (here / "car.toml").write_text(CAR.removeprefix(INPUTS))
    assert main(["compare", "one.csv", "--model", "car.toml"]) == 0
    said = 'car.toml does not say which columns drive it; [inputs] steer = "steer_cmd", longitudinal = "accel_cmd" is '
    assert capsys.readouterr().err == f"dvp compare: {said}assumed\n"
    (here / "one.csv").write_text((here / "one.csv").read_text().replace("accel_cmd [", "soc [", 1))
    assert main(["compare", "one.csv", "--model", "car.toml"]) == 1
    told = capsys.readouterr().err
    assert told.startswith(
        "car.toml: is driven by 'accel_cmd', which one.csv does not have; nearest of its 9 columns: "
    )
    assert said in told
    assert told.count("\n") == 1


@pytest.mark.nightly
def test_nothing_missing_is_an_answer_and_an_unchanged_copy(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (here / "car.toml").write_bytes(CAR.replace("\n", "\r\n").encode() + b"# mine\r\n")
    given = (here / "car.toml").read_bytes()
    assert extend("--fit", "prompt.csv", "--json", add="") == 0
    told = capsys.readouterr()
    found = json.loads(told.out)
    assert (found["written"], found["effects"], found["verdict"]) == (True, [], "NOTHING_MISSING")
    assert "new.toml written, an unchanged copy of car.toml: NOTHING_MISSING: " in told.err
    assert (here / "new.toml").read_bytes() == given
    words = ["extend", "--model", "car.toml", "--fit", "prompt.csv", "--out", "car.toml", "--force"]
    assert main(words) == 0
    assert (here / "car.toml").read_bytes() == given


@pytest.mark.parametrize("verdict", ["NOTHING_MISSING", "UNKNOWN", "NOT_EXCITED"])
def test_a_diagnosis_that_names_nothing_is_an_answer(
    here: Path, verdict: str, capsys: pytest.CaptureFixture[str]
) -> None:
    (here / "found.json").write_text(json.dumps({"verdict": verdict, "effects": []}))
    assert extend("--from", "found.json", "--fit", "one.csv", "--json", add="") == 0
    assert document(capsys) | {"model": ""} == {
        "written": True, "model": "", "verdict": verdict, "effects": [], "refusal": "",
    }  # fmt: skip
    assert (here / "new.toml").read_bytes() == (here / "car.toml").read_bytes()


def test_a_diagnosis_of_nothing_but_the_runs_own_zeros_leaves_the_model_as_it_is(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    found_by_hand(here, ("gyro_bias", "add"), set_up=["gyro_bias"])
    assert extend("--from", "found.json", "--fit", "one.csv", add="") == 0
    assert "an unchanged copy of car.toml: gyro_bias: left, as of the run" in capsys.readouterr().err
    assert (here / "new.toml").read_text() == CAR


@pytest.mark.nightly
def test_an_error_that_no_effect_explains_is_an_answer(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A yaw rate that swings at 0.8 Hz, whatever is commanded."""
    log = make_log({}, "urban", 3)
    log["yaw_rate"] = log["yaw_rate"] + 0.05 * np.sin(2.0 * np.pi * 0.8 * log["t"])
    write_csv(here / "odd.csv", log)
    assert extend("--fit", "odd.csv", "--json", add="") == 0
    found = document(capsys)
    assert (found["verdict"], found["written"], found["effects"]) == ("UNKNOWN", True, [])
    assert (here / "new.toml").read_text() == CAR


def test_held_out_loss_writes_nothing_and_keeps_what_was_there(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """What is fitted to the late car makes the prompt one late, too."""
    (here / "new.toml").write_text("# mine\n")
    assert extend("--fit", "one.csv", "--held-out", "prompt.csv") == 1
    *progress, said = capsys.readouterr().err.splitlines()  # on a busy machine, progress comes before
    assert "new.toml is not written: steer_delay loses on held-out data, chi²/N 1" in said
    assert all(line.endswith("s)") for line in progress)
    assert (here / "new.toml").read_text() == "# mine\n"


@pytest.mark.nightly
def test_refusal_stands_in_the_document_as_well(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert extend("--fit", "one.csv", "--held-out", "prompt.csv", "--json") == 1
    found = document(capsys)
    assert not found["written"]
    assert "loses on held-out data" in found["refusal"]


def test_gates_that_change_are_told(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert extend("--fit", "one.csv", "--gates", "car.gates.toml", "--json") == 0
    verdicts = {g["gate"]: (g["before"]["verdict"], g["after"]["verdict"]) for g in document(capsys)["gates"]}
    assert verdicts == {"rmse of yaw_rate": ("FAIL", "PASS"), "rmse of v": ("PASS", "PASS")}


def test_gates_on_another_model_are_no_answer(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (here / "other.toml").write_text(CAR)
    (here / "car.gates.toml").write_text(GATES.replace("car.toml", "other.toml"))
    assert extend("--fit", "one.csv", "--gates", "car.gates.toml") == 2
    assert "none of its gates is on car.toml" in capsys.readouterr().err


def test_own_input_is_overwritten_only_by_force(here: Path) -> None:
    words = ["extend", "--model", "car.toml", "--add", "steer_delay", "--fit", "one.csv", "--out", "car.toml"]
    assert main(words) == 2
    assert (here / "car.toml").read_text() == CAR
    assert main([*words, "--force"]) == 0
    assert [a.name for a in read_model(here / "car.toml").effects] == ["steer_delay"]
    assert [path.name for path in here.iterdir() if path.name.endswith(".part")] == []


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--fit", "none.csv"], "none.csv: no such log"),
        (["--fit", "one.csv", "--held-out", "none.csv"], "none.csv: no such log"),
        (["--fit", "one.csv", "--held-out", "one.csv@20:30"], "would judge itself"),
        (["--fit", "one.csv", "--out", "one.csv", "--force"], "one.csv is a file that is read"),
        (["--fit", "one.csv", "--out", "no/new.toml"], "no folder no"),
        (["--fit", "one.csv", "--add", "steer_dely"], "did you mean 'steer_delay'"),
        (
            ["--fit", "one.csv", "--remove", "brake_lag"],
            "--remove: car.toml does not have brake_lag; it has no effects",
        ),
        (["--fit", "one.csv", "--remove", "steer_delay"], "both to be added and to be removed"),
        (["--fit", "one.csv", "--gates", "none.toml"], "none.toml: no such gate file"),
        (["--fit", "one.csv", "--from", "none.json"], "none.json: no such diagnosis"),
        (["--fit", "one.csv", "--refti"], "did you mean --refit"),
        (["--fit", "one.csv", "--grow"], "--grow fits all effects and finds what to add itself: leave out --add"),
        (["--fit", "one.csv", "--held-out", "two.csv", "--grow"], "name those of --held-out after --fit"),
    ],
)
def test_wrong_argument_is_one_line_and_exit_code_2(
    here: Path, words: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert extend(*words) == 2
    told = capsys.readouterr()
    assert said in told.err
    assert told.err.count("\n") == 1
    assert not (here / "new.toml").exists()


def test_growing_from_a_bare_data_sheet_is_refused_with_what_comes_first(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert extend("--grow", "--fit", "one.csv", "two.csv", add="") == 2
    assert capsys.readouterr().err == (
        "dvp extend: --grow goes on from effects that a diagnosis found, and car.toml has none: first run dvp diagnose "
        "one.csv --held-out two.csv --model car.toml\n"
    )
    assert not (here / "new.toml").exists()


def test_growing_on_one_log_is_refused_in_one_line(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert extend("--grow", "--fit", "one.csv", add="") == 2
    assert capsys.readouterr().err == (
        "dvp extend: --grow asks what several logs show together: name two at least after --fit\n"
    )
    assert not (here / "new.toml").exists()


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"effects": 3}', '{"effects": [{}]}', "\x00", '{"effects": []}'])
def test_file_that_is_no_diagnosis_is_one_line(here: Path, text: str, capsys: pytest.CaptureFixture[str]) -> None:
    (here / "found.json").write_text(text)
    assert extend("--from", "found.json", "--fit", "one.csv", add="") == 1
    told = capsys.readouterr()
    assert told.err.startswith("found.json: ")
    assert told.err.count("\n") == 1
