"""The gate kind `model`."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from gap_logs import drive

from pytest_dvp.gap.compare import match_bounds, segments
from pytest_dvp.logs.log import Log
from pytest_dvp.plugin.fixtures import properties
from pytest_dvp.verdicts import model_gate
from pytest_dvp.verdicts.judging import check_gates, judge, read_gates
from reports.verdicts import headline, rows

CAR = "[model]\nname = 'car'\n[parameters]\nwheelbase = 2.5\ncg_to_front_axle = 1.2\nmass = 1200.0\n"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "models").mkdir()
    (tmp_path / "models" / "car.toml").write_text(CAR)
    return tmp_path


def written(folder: Path, text: str) -> Path:
    path = folder / "drive.gates.toml"
    path.write_text(text)
    return path


def staged(log: Log, stage: str = "rw") -> Log:
    return dataclasses.replace(log, meta={"stage": stage})


def test_each_bound_is_a_verdict_of_its_own(folder: Path) -> None:
    path = written(folder, '[[gate]]\nmodel = "models/car.toml"\nrmse = { v = 0.05, yaw_rate = 0.01 }\nlag = 0.05\n')
    verdicts = judge(read_gates(path), staged(drive()))
    assert [(v.gate, v.status) for v in verdicts] == [
        ("rmse(v, car.toml) <= 0.05 m/s", "PASS"),
        ("rmse(yaw_rate, car.toml) <= 0.01 rad/s", "PASS"),
        ("lag(v, car.toml) <= 0.05 s", "PASS"),
        ("lag(yaw_rate, car.toml) <= 0.05 s", "PASS"),
    ]


def test_failure_says_how_far_where_and_which_line(folder: Path) -> None:
    path = written(folder, '[[gate]]\nmodel = "models/car.toml"\nrmse = { v = 0.05 }\n')
    verdict = judge(read_gates(path), staged(drive(brake_gain=0.8)))[0]
    assert verdict.status == "FAIL"
    assert "of it in braking" in verdict.message
    assert verdict.message.endswith("drive.gates.toml:3")


def test_text_json_and_page_name_what_the_gate_file_names(folder: Path) -> None:
    path = written(folder, '[[gate]]\nmodel = "models/car.toml"\nrmse = { v = 0.05 }\n')
    verdict = judge(read_gates(path), staged(drive(brake_gain=0.8)))[0]
    plain = verdict.as_dict()
    assert verdict.short.startswith("rmse(v, car.toml) 0.")
    assert (plain["name"], plain["gate"]) == ("rmse(v, car.toml)", "rmse(v, car.toml) <= 0.05 m/s")
    table = rows([plain])
    assert table[0].name == "rmse(v, car.toml)"
    assert "Worst: rmse(v, car.toml) 0." in headline("FAIL", table)
    result = {"status": "FAIL", "metrics": {}, "verdicts": [plain]}
    assert ("rmse(v, car.toml).status", "FAIL") in properties(result)


def test_small_bound_does_not_read_like_none(folder: Path) -> None:
    path = written(folder, '[[gate]]\nmodel = "models/car.toml"\nrmse = { yaw_rate = 0.002 }\n')
    verdict = judge(read_gates(path), staged(drive()))[0]
    assert verdict.gate == "rmse(yaw_rate, car.toml) <= 0.002 rad/s"
    assert verdict.short.startswith("rmse(yaw_rate, car.toml) 0.005 rad/s > 0.002")


def test_gate_applies_to_its_stages_only(folder: Path) -> None:
    path = written(folder, '[[gate]]\nmodel = "models/car.toml"\nlag = 0.05\nstages = ["rw"]\n')
    assert judge(read_gates(path), staged(drive(), "dt"))[0].status == "INCONCLUSIVE"


def test_log_without_commands_is_inconclusive(folder: Path) -> None:
    path = written(folder, '[[gate]]\nmodel = "models/car.toml"\nrmse = { v = 0.05 }\n')
    log = drive(20.0)
    bare = Log(
        {name: values for name, values in log.columns.items() if not name.endswith("_cmd")}, meta={"stage": "rw"}
    )
    assert judge(read_gates(path), bare)[0].status == "INCONCLUSIVE"


def test_log_in_degrees_is_inconclusive(folder: Path) -> None:
    path = written(folder, '[[gate]]\nmodel = "models/car.toml"\nrmse = { v = 100.0 }\n')
    log = drive()
    wrong = {name: np.degrees(log[name]) for name in ("yaw", "yaw_rate")}
    verdict = judge(read_gates(path), staged(dataclasses.replace(log, columns={**log.columns, **wrong})))[0]
    assert verdict.status == "INCONCLUSIVE"
    assert "degrees stored as radians" in verdict.message


@pytest.mark.parametrize(
    ("text", "code", "line"),
    [
        ('model = "models/cra.toml"\nlag = 0.1', "dvp.gates.model", 2),
        ('model = "../car.toml"\nlag = 0.1', "dvp.gates.model", 2),
        ('model = "/etc/passwd"\nlag = 0.1', "dvp.gates.model", 2),
        ('model = "models/car.toml"\nrmse = { vv = 0.1 }', "dvp.gates.signal", 3),
        ('model = "models/car.toml"\nrmse = 0.1', "dvp.gates.bound", 3),
        ('model = "models/car.toml"\nrmse = { v = nan }', "dvp.gates.bound", 3),
        ('model = "models/car.toml"\nlga = 0.1', "dvp.gates.unknown_key", 3),
        ('model = "models/car.toml"', "dvp.gates.no_bound", 1),
    ],
)
def test_wrong_gate_is_a_finding_with_its_line(folder: Path, text: str, code: str, line: int) -> None:
    found = check_gates(written(folder, f"[[gate]]\n{text}\n"))
    assert (found[0].code, found[0].line) == (code, line)


def test_link_out_of_the_folder_is_refused(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> None:
    outside = tmp_path_factory.mktemp("outside") / "car.toml"
    outside.write_text(CAR)
    (folder / "models" / "link.toml").symlink_to(outside)
    found = check_gates(written(folder, '[[gate]]\nmodel = "models/link.toml"\nlag = 0.1\n'))
    assert found[0].code == "dvp.gates.model"


def test_light_copies_of_names_are_those_of_the_comparison() -> None:
    assert model_gate.CHANNELS == segments.CHANNELS
    assert model_gate.KINDS == match_bounds.KINDS


def test_metric_may_be_named_outright(folder: Path) -> None:
    text = '[[gate]]\nmetric = "open_loop_error"\nmodel = "models/car.toml"\nsignal = "v"\nmax = 0.05\n'
    assert judge(read_gates(written(folder, text)), staged(drive()))[0].status == "PASS"


def test_metric_named_outright_may_not_leave_the_folder_either(folder: Path) -> None:
    text = '[[gate]]\nmetric = "open_loop_error"\nmodel = "../car.toml"\nsignal = "v"\nmax = 0.05\n'
    assert [(f.code, f.line) for f in check_gates(written(folder, text))] == [("dvp.gates.model", 3)]
