"""The log of a model: read with the mapping of the measured one as far as it fits, and not examined like a sensor."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from gap_logs import baseline, drive

from pytest_dvp.cli.command_line import main
from pytest_dvp.gap.assert_matches import assert_matches
from pytest_dvp.gap.compare.compare import compare
from pytest_dvp.gap.diagnosis_switch import diagnosis_wanted
from pytest_dvp.gap.words.comparison_page import page_of
from pytest_dvp.logs.log import Log
from pytest_dvp.verdicts.gate_explanation import gate_explanation
from reports.compare import write_compare_report

MEASURED = {
    "t": "t [s]", "accel_cmd": "wish [m/s^2]", "steer_cmd": "steering angle command [deg]", "x": "x [m]", "y": "y [m]",
    "yaw": "yaw [rad]", "v": "wheel speed [km/h]", "yaw_rate": "yaw_rate [rad/s]", "ax": "ax [m/s^2]",
}  # fmt: skip
FACTOR = {"steer_cmd": 180.0 / np.pi, "v": 3.6}
MAP = """
[[signal]]
name = "steer_cmd"
field = "steering angle command"
unit = "deg"
[[signal]]
name = "accel_cmd"
field = "wish"
unit = "m/s^2"
[[signal]]
name = "v"
field = "wheel speed"
unit = "km/h"
"""


def written(path: Path, log: Log, heads: dict[str, str]) -> str:
    columns = [log[name] * FACTOR.get(name, 1.0) if heads[name] == MEASURED[name] else log[name] for name in heads]
    rows = [",".join(f"{value:.9g}" for value in row) for row in zip(*columns, strict=True)]
    path.write_text("\n".join([",".join(heads.values()), *rows]) + "\n")
    return str(path)


@pytest.fixture
def mapping(tmp_path: Path) -> str:
    (tmp_path / "map.toml").write_text(MAP)
    return str(tmp_path / "map.toml")


@pytest.mark.parametrize("speed", ["wheel speed [km/h]", "v [m/s]"])
def test_mapping_of_the_log_need_not_fit_the_model(
    tmp_path: Path, mapping: str, speed: str, capsys: pytest.CaptureFixture[str]
) -> None:
    log = written(tmp_path / "drive.csv", drive(20.0), MEASURED)
    heads = {k: head for k, head in MEASURED.items() if not k.endswith("_cmd")} | {"v": speed}
    model = written(tmp_path / "model.csv", drive(20.0, noise=0.0), heads)
    assert main(["compare", log, "--model", model, "--map", mapping]) == 0
    assert "model.csv explains every signal to its noise" in capsys.readouterr().out
    found = assert_matches(log, model, map=mapping, rmse={"v": 0.05, "yaw_rate": 0.01})
    assert found.signals["v"].rmse < 0.05


def test_model_named_as_the_log_is_read_with_its_mapping(tmp_path: Path, mapping: str) -> None:
    log = written(tmp_path / "drive.csv", drive(20.0), MEASURED)
    model = written(tmp_path / "model.csv", drive(20.0, noise=0.0), MEASURED)
    assert_matches(log, model, map=mapping, rmse={"v": 0.05, "yaw_rate": 0.01})


def test_field_that_is_not_there_names_the_file(
    tmp_path: Path, mapping: str, capsys: pytest.CaptureFixture[str]
) -> None:
    heads = {k: head for k, head in MEASURED.items() if k != "steer_cmd"}
    log = written(tmp_path / "drive.csv", drive(20.0), heads)
    assert main(["doctor", log, "--map", mapping]) == 1
    said = capsys.readouterr().out
    assert f"no field 'steering angle command' in {log}" in said


def test_models_output_is_no_sensor(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log = drive(20.0)
    heads = {k: f"{k} [{head.split('[')[1]}" for k, head in MEASURED.items()}
    heads |= {"steer_cmd": "steer_cmd [rad]", "v": "v [m/s]"}
    clean = drive(20.0, noise=0.0)
    model = Log({**clean.columns, "ax": clean["accel_cmd"], "yaw_rate": np.clip(clean["yaw_rate"], -0.1, 0.1)})
    one, other = written(tmp_path / "drive.csv", log, heads), written(tmp_path / "model.csv", model, heads)
    assert main(["doctor", other]) == 0
    assert "log.ax_is_command" in capsys.readouterr().out  # of a measurement it would be worth saying
    assert main(["compare", one, "--model", other]) == 0
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("bound", [{"steer": 0.01}, {"yaw_raet": 0.01}])
def test_bound_without_a_number_is_not_called_tighter_than_the_noise(bound: dict[str, float]) -> None:
    assert diagnosis_wanted()
    with pytest.raises(AssertionError) as failed:
        assert_matches(drive(30.0), baseline(), rmse=bound)
    assert "not compared" in str(failed.value)
    assert "tighter than the noise" not in str(failed.value)


@pytest.mark.parametrize(("value", "lines"), [(None, 0), (0.3, 1)])
def test_gate_without_a_number_is_not_diagnosed(tmp_path: Path, value: float | None, lines: int) -> None:
    verdict = {
        "file": str(tmp_path / "none.gates.toml"), "line": 1, "metric": "open_loop_error", "status": "FAIL",
        "value": value,
    }  # fmt: skip
    assert len(gate_explanation(drive(1.0), [verdict], "drive.mcap")) == lines


def test_bound_below_the_noise_is_called_so() -> None:
    with pytest.raises(AssertionError, match="tighter than the noise"):
        assert_matches(drive(30.0), baseline(), rmse={"v": 1e-4, "steer": 0.1})


def test_what_is_not_known_is_not_said_to_be_recognised(
    tmp_path: Path, mapping: str, capsys: pytest.CaptureFixture[str]
) -> None:
    log = drive(20.0)
    path = Path(written(tmp_path / "drive.csv", log, MEASURED))
    lines = path.read_text().splitlines()
    path.write_text("\n".join([lines[0] + ",oil [degC]", *(line + ",90" for line in lines[1:])]) + "\n")
    assert main(["doctor", str(path), "--map", mapping]) == 0
    told = {line.split(":")[0].strip(): line for line in capsys.readouterr().out.splitlines() if ":" in line}
    assert "oil" in told["kept, not known"]
    assert "oil" not in told["recognised by name and unit"]


def test_check_takes_a_mapping(tmp_path: Path, mapping: str, capsys: pytest.CaptureFixture[str]) -> None:
    log = written(tmp_path / "drive.csv", drive(20.0), MEASURED)
    assert main(["check", log, "--map", mapping]) == 0
    assert main(["check", log, "--map", str(tmp_path / "none.toml")]) == 2
    bad = tmp_path / "bad.toml"
    bad.write_text(MAP.replace("wheel speed", "wheel sped"))
    capsys.readouterr()
    assert main(["check", log, "--map", str(bad)]) == 1
    assert "wheel sped" in capsys.readouterr().out


def test_page_shows_no_lag_below_nought(tmp_path: Path) -> None:
    found = compare(drive(20.0), baseline())
    little = {name: dataclasses.replace(score, lag=-0.0001) for name, score in found.signals.items()}
    found = dataclasses.replace(found, signals=little, alignment=dataclasses.replace(found.alignment, lag=-0.0002))
    write_compare_report(str(tmp_path / "page.html"), [page_of("drive.csv", found, ())])
    text = (tmp_path / "page.html").read_text()
    assert "lag +0.000 s" in text
    assert "-0.000 " not in text
