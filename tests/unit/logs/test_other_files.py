"""Files of another kind under a log's name, and tables that only look like one: one line that says what it is."""

from __future__ import annotations

import gzip
import math
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from drives import drive, write_csv

from pytest_dvp.cli.command_line import main
from pytest_dvp.logs.log_error import LogError
from pytest_dvp.logs.read_log import read_log, read_streams

TABLE = "t [s],v [m/s]\n" + "".join(f"{k / 10},{k}\n" for k in range(50))


def refused(path: Path) -> LogError:
    with pytest.raises(LogError) as error:
        read_log(path)
    return error.value


@pytest.mark.parametrize("end", ["csv", "mcap", "mat", "mf4", "bag"])
@pytest.mark.parametrize(
    ("data", "says"),
    [
        (gzip.compress(TABLE.encode()), "this is a gzip archive, not what {} says; unpack it first"),
        (b"<?xml version='1.0'?>\n<OpenSCENARIO/>", "this is an XML file, not what {} says"),
        (b"<!DOCTYPE html><html>404</html>", "this is a web page, not what {} says"),
        (b'{"t": [0, 1, 2]}', "this is a JSON file, not what {} says"),
        (b"\x89HDF\r\n\x1a\n" + bytes(99), "this is an HDF5 file, not what {} says"),
    ],
)
def test_another_kind_of_file_is_called_by_its_name(tmp_path: Path, end: str, data: bytes, says: str) -> None:
    path = tmp_path / f"drive.{end}"
    path.write_bytes(data)
    assert str(refused(path)) == f"{path}: {says.format('.' + end)}"


def test_a_log_under_the_name_of_another_kind_is_to_be_renamed(tmp_path: Path) -> None:
    path = tmp_path / "drive.csv"
    path.write_bytes(b"\x89MCAP0\r\n" + bytes(99))
    assert str(refused(path)) == f"{path}: this is an MCAP file, not what .csv says; rename it"


def test_a_sheet_of_excel_is_told_also_by_recover(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "drive.csv"
    with zipfile.ZipFile(path, "w") as sheet:
        sheet.writestr("[Content_Types].xml", "")
    assert main(["recover", str(path), "--out", str(tmp_path / "b.csv")]) == 1
    assert "this is a ZIP archive or an Excel sheet" in capsys.readouterr().err


@pytest.mark.parametrize("mark", [" ", "   ", "|", " | "])
def test_blanks_and_bars_separate_fields(tmp_path: Path, mark: str) -> None:
    path = tmp_path / "a.csv"
    path.write_text(TABLE.replace(",", mark))
    log = read_log(path)
    assert (list(log.columns), log.t[7], log.columns["v"][7]) == (["t", "v"], 0.7, 7.0)


@pytest.mark.parametrize("mark", ["~", "/"])
def test_fields_that_nothing_separates_are_told(tmp_path: Path, mark: str) -> None:
    path = tmp_path / "a.csv"
    path.write_text(TABLE.replace(",", mark))
    error = refused(path)
    assert (error.code, error.findings[0].line) == ("log.one_field", 1)
    assert "allowed: fields separated by `,`, `;` or a tab" in str(error)


def test_a_table_of_words_has_no_streams(tmp_path: Path) -> None:
    from openscenario.findings import Findings

    path = tmp_path / "a.csv"
    path.write_text("name\none\ntwo\nthree\n")
    with pytest.raises(LogError, match=r"a\.csv:1: error log\.no_numbers: no column of numbers in it"):
        read_streams(path, Findings())


@pytest.mark.parametrize("cell", ["1_0", "\u0661\u0662", "0x10", "\u22125"])
def test_what_only_python_takes_for_a_number_is_none(tmp_path: Path, cell: str) -> None:
    path = tmp_path / "a.csv"
    path.write_text(TABLE.replace("0.3,3\n", f"0.3,{cell}\n"), encoding="utf-8")
    (finding,) = refused(path).findings
    assert (finding.code, finding.line, finding.element) == ("value.not_a_number", 5, "column v")
    assert main(["recover", str(path), "--out", str(tmp_path / "b.csv")]) == 0
    assert len(read_log(tmp_path / "b.csv").t) == 49


def test_rows_of_one_stamp_are_no_log(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("t [s],v [m/s]\n" + "1,2\n" * 20)
    assert [finding.code for finding in refused(path).findings] == ["log.too_short", "log.duplicate_stamps"]
    assert "1 row is no log; found '1 row'; allowed: 3 or more" in str(refused(path))


def test_a_quote_that_is_not_closed_is_told_with_its_line_and_recovered(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    rows = TABLE + "".join(f"{k / 10},{k}\n" for k in range(50, 20_000))
    path.write_text(rows.replace("0.3,3\n", '0.3,"3\n', 1))
    (finding,) = refused(path).findings
    assert (finding.code, finding.line) == ("log.open_quote", 5)
    assert main(["recover", str(path), "--out", str(tmp_path / "b.csv")]) == 0
    assert len(read_log(tmp_path / "b.csv").t) == 19_999


def test_a_name_without_end_is_no_name(tmp_path: Path) -> None:
    for length in (5_000, 200_000):
        path = tmp_path / "a.csv"
        path.write_text(f"t [s],{'a' * length} [m]\n0,1\n1,2\n3,4\n")
        error = refused(path)
        assert (error.code, error.findings[0].line) == ("log.header_missing", 1)
        assert len(str(error)) < 300


def test_recover_keeps_rows_whose_time_is_written_in_words(tmp_path: Path) -> None:
    path, out = tmp_path / "a.csv", tmp_path / "b.csv"
    rows = [f"2026-05-01T12:00:{k / 10:04.1f},{k}" for k in range(50)]
    rows[7] = "2026-05-01T12:0"
    path.write_text("t,v [m/s]\n" + "\n".join(rows) + "\n")
    assert main(["recover", str(path), "--out", str(out)]) == 0
    log = read_log(out)
    assert (len(log.t), log.t[-1]) == (49, pytest.approx(4.9))
    assert not math.isnan(log["v"][7])


@pytest.mark.parametrize("column", ["v", "x"])
def test_a_column_without_a_value_is_told_without_a_word_of_numpy(tmp_path: Path, column: str) -> None:
    values = drive(10.0)
    write_csv(tmp_path / "a.csv", {**values, column: values[column] * math.nan})
    command = [sys.executable, "-W", "error", "-m", "pytest_dvp.cli", "doctor", "a.csv"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=60, check=False)
    assert f"log.empty_column column {column}: the column holds no value" in done.stdout
    assert done.stderr == "a.csv: 0 errors, 1 warnings\n"


def test_the_folder_of_a_run_needs_no_mapping(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from pytest_dvp.logs.log import Log

    (tmp_path / "run").mkdir()
    Log(columns=dict(drive(2.0))).save(tmp_path / "run" / "log.mcap")
    assert main(["map", str(tmp_path / "run")]) == 2
    assert capsys.readouterr().err == f"{tmp_path / 'run'}: a log of dvp, it needs no mapping\n"


@pytest.mark.parametrize(
    ("files", "says"),
    [
        (["drive_0.mcap"], r"; .*drive_0\.mcap can be read by itself$"),
        (["drive_0.mcap", "drive_1.mcap"], r"; `ros2 bag reindex .*` writes the metadata\.yaml of the bag$"),
        (["drive_0.db3"], r"; `ros2 bag reindex .*` writes the metadata\.yaml of the bag$"),
        (["a.csv", "b.csv"], r"; several files of one drive become one log by `dvp join .*`$"),
        (["a.csv"], r"\(metadata\.yaml\)$"),
    ],
)
def test_folder_that_is_no_log_says_what_makes_one_of_its_files(tmp_path: Path, files: list[str], says: str) -> None:
    for name in files:
        (tmp_path / name).touch()
    with pytest.raises(LogError, match=says):
        read_log(tmp_path)
