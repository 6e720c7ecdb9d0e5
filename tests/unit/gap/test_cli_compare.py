"""dvp compare as a user types it."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest
from gap_logs import WHEELBASE, drive

from pytest_dvp.cli.command_line import main
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.signals import SIGNALS


def written(folder: Path, log: Log, name: str = "drive.csv") -> str:
    head = ",".join(f"{column} [{SIGNALS[column].unit}]" for column in log.columns)
    rows = [",".join(f"{value:.9g}" for value in row) for row in zip(*log.columns.values(), strict=True)]
    (folder / name).write_text("\n".join([head, *rows]) + "\n")
    return str(folder / name)


@pytest.fixture
def model(tmp_path: Path) -> str:
    (tmp_path / "car.toml").write_text(
        f"[parameters]\nwheelbase = {WHEELBASE}\ncg_to_front_axle = 1.2\nmass = 1200.0\n"
    )
    return str(tmp_path / "car.toml")


def test_table_says_how_far_and_where(tmp_path: Path, model: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["compare", written(tmp_path, drive(brake_gain=0.8)), "--model", model]) == 0
    out = capsys.readouterr().out
    assert "car.toml misses" in out.splitlines()[1]
    assert "braking" in out
    assert "chi²/N" in out


def test_json_is_one_document_on_stdout(tmp_path: Path, model: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["compare", written(tmp_path, drive(20.0)), "--model", model, "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert set(document) == {"alignment", "signals", "where"}


def test_log_may_be_cut(tmp_path: Path, model: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["compare", written(tmp_path, drive(40.0)) + "@10:30", "--model", model]) == 0
    assert "20.0 s" in capsys.readouterr().out.splitlines()[0]


def test_second_log_is_a_model(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    one, other = written(tmp_path, drive(20.0)), written(tmp_path, drive(20.0, noise=0.0), "model.csv")
    assert main(["compare", one, "--model", other]) == 0
    assert "model.csv explains every signal to its noise" in capsys.readouterr().out


@pytest.mark.parametrize("missing", ["log", "model"])
def test_missing_file_is_exit_code_2(
    tmp_path: Path, model: str, missing: str, capsys: pytest.CaptureFixture[str]
) -> None:
    log = written(tmp_path, drive(20.0))
    words = ["nope.csv", "--model", model] if missing == "log" else [log, "--model", "nope.toml"]
    assert main(["compare", *words]) == 2
    assert "no such" in capsys.readouterr().err


def test_wrong_model_file_is_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "car.toml").write_text("[parameters]\nwheelbas = 2.5\n")
    assert main(["compare", written(tmp_path, drive(20.0)), "--model", str(tmp_path / "car.toml")]) == 1
    assert capsys.readouterr().err.count("\n") == 1


def test_report_is_one_page_without_network(tmp_path: Path, model: str) -> None:
    page = tmp_path / "compare.html"
    assert main(["compare", written(tmp_path, drive(20.0)), "--model", model, "--report", str(page)]) == 0
    text = page.read_text(encoding="utf-8")
    assert "drive.csv" in text
    assert "default-src 'none'" in text
    assert "<script src" not in text


def test_same_comparison_gives_the_same_page(tmp_path: Path, model: str) -> None:
    log = written(tmp_path, drive(20.0))
    pages = [tmp_path / "one.html", tmp_path / "two.html"]
    for page in pages:
        main(["compare", log, "--model", model, "--report", str(page)])
    assert pages[0].read_bytes() == pages[1].read_bytes()


def test_report_into_a_missing_folder_is_exit_code_2(tmp_path: Path, model: str) -> None:
    log = written(tmp_path, drive(20.0))
    assert main(["compare", log, "--model", model, "--report", str(tmp_path / "nope" / "a.html")]) == 2


def test_model_may_use_an_effect_of_the_users_own(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "weak.py").write_text(
        "from vehicle.model.effect import Key, effect\n\n\n"
        '@effect(name="weak_brakes", slot="command", physics="brakes give less", equation="a = g a_c",\n'
        '        source="test", parameters=(Key("g", "-", low=0.5, high=1.0, neutral=1.0, least=0.02),),\n'
        '        reveals="brake")\n'
        "def weak_brakes(x, p, m):\n"
        "    if x.accel < 0.0:\n"
        "        x.accel = p.g * x.accel\n"
    )
    (tmp_path / "car.toml").write_text(
        f"[parameters]\nwheelbase = {WHEELBASE}\ncg_to_front_axle = 1.2\nmass = 1200.0\n"
        '[[effect]]\nname = "weak_brakes"\n[effect.parameters.g]\nvalue = 0.8\n'
    )
    words = ["compare", written(tmp_path, drive(brake_gain=0.8)), "--model", str(tmp_path / "car.toml")]
    assert main([*words, "--effects", str(tmp_path / "weak.py"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["signals"]["v"]["chi2_per_n"] == pytest.approx(1.0, abs=0.2)


def in_degrees(log: Log) -> Log:
    """Yaw and its rate as a logger writes them that names degrees radians."""
    wrong = {name: np.degrees(log[name]) for name in ("yaw", "yaw_rate")}
    return dataclasses.replace(log, columns={**log.columns, **wrong})


def with_gap(log: Log) -> Log:
    """A second of rows was lost."""
    kept = (log.t < 10.0) | (log.t > 11.0)
    return dataclasses.replace(log, columns={name: values[kept] for name, values in log.columns.items()})


def test_degrees_as_radians_are_refused_before_any_physics(
    tmp_path: Path, model: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def never(*_: object, **__: object) -> None:
        raise AssertionError("compared")

    monkeypatch.setattr("pytest_dvp.gap.compare.compare.compare", never)
    good, bad = written(tmp_path, drive()), written(tmp_path, in_degrees(drive()), "degrees.csv")
    assert main(["compare", good, bad, "--model", model]) == 1
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err.count("\n") == 1
    assert "degrees.csv" in told.err
    assert "degrees stored as radians" in told.err


def test_second_log_in_degrees_is_no_model(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bad = written(tmp_path, in_degrees(drive()), "degrees.csv")
    assert main(["compare", written(tmp_path, drive()), "--model", bad]) == 1
    assert "degrees stored as radians" in capsys.readouterr().err


def test_warnings_are_told_and_the_log_is_compared(
    tmp_path: Path, model: str, capsys: pytest.CaptureFixture[str]
) -> None:
    page = tmp_path / "compare.html"
    log = written(tmp_path, with_gap(drive()))
    assert main(["compare", log, "--model", model, "--report", str(page)]) == 0
    told = capsys.readouterr()
    assert "warning log.gap column t" in told.err
    assert "chi²/N" in told.out
    assert "Warning: log.gap column t" in page.read_text(encoding="utf-8")


def test_json_on_stdout_stays_one_document_beside_warnings(
    tmp_path: Path, model: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["compare", written(tmp_path, with_gap(drive())), "--model", model, "--json"]) == 0
    told = capsys.readouterr()
    assert "log.gap" in told.err
    assert set(json.loads(told.out)) == {"alignment", "signals", "where"}


def test_mapping_is_passed_on(tmp_path: Path, model: str, capsys: pytest.CaptureFixture[str]) -> None:
    log = written(tmp_path, drive(20.0))
    (tmp_path / "map.toml").write_text('[[signal]]\nname = "v"\nfield = "no_such_field"\n')
    assert main(["compare", log, "--model", model, "--map", str(tmp_path / "map.toml")]) == 1
    assert "no_such_field" in capsys.readouterr().err
