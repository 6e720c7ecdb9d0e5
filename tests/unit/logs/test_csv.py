"""CSV: what a header may say, what is converted, and that every complaint has its line and column."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from drives import drive, write_csv

from pytest_dvp.logs.column_names import parse_header
from pytest_dvp.logs.log_error import LogError
from pytest_dvp.logs.read_log import read_log


def csv(folder: Path, text: str) -> Path:
    path = folder / "a.csv"
    path.write_text(text, encoding="utf-8")
    return path


def refused(path: Path) -> LogError:
    with pytest.raises(LogError) as error:
        read_log(path)
    return error.value


@pytest.mark.parametrize(
    ("header", "name", "unit"),
    [
        ("v [m/s]", "v", "m/s"), ("v (km/h)", "v", "km/h"), ("v_mps", "v", "mps"), ("speed_kmh", "speed", "kmh"),
        ("yaw_rate_degps", "yaw_rate", "degps"), ("ax_m_s2", "ax", "m/s^2"),
        ("t_s", "t", "s"), ("gear [-]", "gear", "-"),
        ("v", "v", None), ("yaw_rate", "yaw_rate", None), ("wheel_s", "wheel_s", None),
    ],
)  # fmt: skip
def test_a_header_names_signal_and_unit(header: str, name: str, unit: str | None) -> None:
    parsed = parse_header(header)
    assert (parsed.name, parsed.unit) == (name, unit)


@pytest.mark.parametrize(
    ("header", "written", "name", "si"),
    [
        ("speed [km/h]", 36.0, "v", 10.0), ("v [mph]", 10.0, "v", 4.4704), ("heading [deg]", 180.0, "yaw", math.pi),
        ("yawrate [deg/s]", 90.0, "yaw_rate", math.pi / 2), ("acc_x [g]", 1.0, "ax", 9.80665),
        ("throttle_cmd [%]", 40.0, "throttle_cmd", 0.4), ("steering_angle [°]", 18.0, "steer", math.pi / 10),
        ("brake_pressure [kPa]", 2.0, "brake_pressure", 2000.0), ("temperature [°C]", 20.0, "temperature", 293.15),
    ],
)  # fmt: skip
def test_other_units_become_si_and_other_names_signals(
    tmp_path: Path, header: str, written: float, name: str, si: float
) -> None:
    log = read_log(csv(tmp_path, f"t [ms],{header}\n" + "".join(f"{20 * i},{written}\n" for i in range(5))))
    assert log[name][2] == pytest.approx(si, rel=1e-12)
    assert log.t[2] == pytest.approx(0.04)
    assert name in log.meta["import"]["converted"]


def test_what_was_done_is_said(tmp_path: Path) -> None:
    log = read_log(csv(tmp_path, "time [s],speed [km/h],foo [bar],gear [-]\n0,36,1,1\n1,36,1,1\n2,36,1,1\n"))
    told = log.meta["import"]
    assert told["aliased"] == ["t", "v"]
    assert told["converted"] == ["v", "foo"]
    assert told["unknown"] == ["foo"]
    assert told["columns"]["v"] == {"from": "speed", "unit": "km/h", "si": "m/s", "scale": pytest.approx(1 / 3.6)}


def test_a_row_of_units_stands_for_brackets(tmp_path: Path) -> None:
    log = read_log(csv(tmp_path, "t,v,yaw\ns,km/h,deg\n0,36,90\n1,36,90\n2,36,90\n"))
    assert log["v"][0] == pytest.approx(10.0)
    assert log["yaw"][0] == pytest.approx(math.pi / 2)


def test_separators_decimal_commas_quotes_byte_order_marks_and_comments_are_understood(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes('\ufeff# exported\r\n"t [s]";"v [m/s]"\r\n0,0;"1,5"\r\n0,5;1,5\r\n1,0;2,5\r\n'.encode())
    log = read_log(path)
    assert log.t.tolist() == [0.0, 0.5, 1.0]
    assert log["v"].tolist() == [1.5, 1.5, 2.5]


def test_an_empty_field_was_not_measured(tmp_path: Path) -> None:
    log = read_log(csv(tmp_path, "t [s],v [m/s],x [m]\n0,1,\n1,,2\n2,NaN,3\n3,4,\n"))
    assert np.isnan(log["v"]).tolist() == [False, True, True, False]
    assert np.isnan(log["x"]).tolist() == [True, False, False, True]


def test_a_bare_name_is_an_error_that_says_how_to_fix_it(tmp_path: Path) -> None:
    error = refused(csv(tmp_path, "t [s],v\n0,1\n1,1\n2,1\n"))
    (finding,) = error.findings
    assert (finding.code, finding.line, finding.element) == ("log.unit_missing", 1, "column v")
    assert "`v [m/s]`" in finding.message


def test_each_bare_name_is_told_at_once(tmp_path: Path) -> None:
    error = refused(csv(tmp_path, "t,x,speed\n0,1,1\n1,1,1\n2,1,1\n"))
    assert [f.element for f in error.findings] == ["column x", "column speed", "column t"]


@pytest.mark.parametrize(
    ("text", "code", "line", "element"),
    [
        ("t [s],v [m/s]\n0,1\n1,x\n2,1\n", "value.not_a_number", 3, "column v"),
        ("t [s],v [m/s]\n0,1\n1\n2,1\n", "log.ragged_row", 3, ""),
        ("t [s],v [m/s]\n0,1\n1,1\n\n2,1,5\n", "log.ragged_row", 5, ""),
        ("t [s],v [rad]\n0,1\n1,1\n2,1\n", "log.unit_mismatch", 1, "column v"),
        ("t [s],v [fathom/week]\n0,1\n1,1\n2,1\n", "log.unit_unknown", 1, "column v"),
        ("t [s],v [m/s],v [km/h]\n0,1,1\n1,1,1\n2,1,1\n", "log.duplicate_column", 1, "column v"),
        ("v [m/s],x [m]\n0,1\n1,1\n2,1\n", "log.time_missing", 1, "column t"),
        ("t [s],v [m/s]\n0,1\n1,1\n0.5,1\n", "log.time_not_monotonic", 4, "column t"),
        ("t [s],v [m/s]\n0,1\n", "log.too_short", None, ""),
        ("t [s],v [m/s]\n", "log.too_short", None, ""),
        ("", "log.empty", None, ""),
        ("0,1\n1,1\n", "log.header_missing", 1, ""),
        ("t [s],,v [m/s]\n0,1,2\n", "log.name_missing", 1, "column 2"),
    ],
)  # fmt: skip
def test_a_defect_is_told_with_line_and_column(
    tmp_path: Path, text: str, code: str, line: int | None, element: str
) -> None:
    finding = next(f for f in refused(csv(tmp_path, text)).findings if f.severity == "error")
    assert (finding.code, finding.line, finding.element) == (code, line, element)


def test_a_column_of_words_is_left_out_and_told(tmp_path: Path) -> None:
    log = read_log(csv(tmp_path, "t [s],mode [-],on [-]\n0,auto,true\n1,manual,false\n2,auto,true\n"))
    assert list(log.columns) == ["t", "on"]
    assert log["on"].tolist() == [1.0, 0.0, 1.0]
    assert [f["code"] for f in log.meta["import"]["findings"]] == ["log.text_column"]


def test_repeated_stamps_are_kept_once_and_told(tmp_path: Path) -> None:
    log = read_log(csv(tmp_path, "t [s],v [m/s]\n0,1\n1,2\n1,3\n2,4\n"))
    assert log["v"].tolist() == [1.0, 2.0, 4.0]
    (finding,) = log.meta["import"]["findings"]
    assert (finding["code"], finding["severity"], finding["line"]) == ("log.duplicate_stamps", "warning", 4)


def test_dates_become_seconds_since_the_first(tmp_path: Path) -> None:
    log = read_log(csv(tmp_path, "t [s],v [m/s]\n1700000000.0,1\n1700000000.5,1\n1700000001.0,1\n"))
    assert log.t.tolist() == [0.0, 0.5, 1.0]
    assert log.meta["import"]["time_origin"] == 1.7e9


def test_numbers_are_read_exactly(tmp_path: Path) -> None:
    values = np.random.default_rng(0).normal(size=50)
    log = read_log(csv(tmp_path, "t [s],x [m]\n" + "".join(f"{i},{v!r}\n" for i, v in enumerate(values.tolist()))))
    assert np.array_equal(log["x"], values)


@pytest.mark.parametrize(
    ("cut", "first", "last"), [("@0:20", 0.0, 19.98), ("@20:", 20.0, 29.98), ("@:5", 0.0, 4.98), ("@5:6.5", 5.0, 6.48)]
)
def test_a_log_argument_may_be_cut(tmp_path: Path, cut: str, first: float, last: float) -> None:
    path = write_csv(tmp_path / "a.csv", drive(30.0))
    log = read_log(f"{path}{cut}")
    assert (log.t[0], log.t[-1]) == (pytest.approx(first), pytest.approx(last))


@pytest.mark.parametrize("cut", ["@5:5", "@9:1", "@a:b", "@100:200"])
def test_a_wrong_cut_is_told(tmp_path: Path, cut: str) -> None:
    path = write_csv(tmp_path / "a.csv", drive(30.0))
    with pytest.raises(LogError):
        read_log(f"{path}{cut}")


def test_reading_csv_imports_neither_pandas_nor_numba(tmp_path: Path) -> None:
    import subprocess
    import sys

    path = write_csv(tmp_path / "a.csv", drive(10.0))
    code = (
        "import sys; from pytest_dvp.cli.command_line import main; main(['check', sys.argv[1]]); "
        "print([m for m in ('pandas', 'numba', 'scipy', 'asammdf', 'rosbags') if m in sys.modules])"
    )
    run = subprocess.run([sys.executable, "-c", code, str(path)], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "[]"


def test_a_column_of_words_may_have_empty_fields(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text("t [s],v [m/s],mode\n0,1,AUTO\n0.1,2,\n0.2,3,MANUAL\n")
    log = read_log(tmp_path / "log.csv")
    assert log.columns["v"].tolist() == [1.0, 2.0, 3.0]
    assert [f["code"] for f in log.meta["import"]["findings"]] == ["log.text_column"]
