"""CSV files as other tools write them: words above the header, stamps as dates, decimal commas in quotes."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from pytest_dvp.doctor import examine
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_error import LogError
from pytest_dvp.logs.read_log import read_log

ROWS = 50


def read(folder: Path, head: str, row: Callable[[int], str], above: str = "") -> Log:
    path = folder / "a.csv"
    path.write_text(above + head + "\n" + "".join(f"{row(i)}\n" for i in range(ROWS)), encoding="utf-8")
    return read_log(path)


@pytest.mark.parametrize("above", ["Test drive 12\nDriver: XY\n\n", "Car;A 7\nMass;800\n", "Hall, dry\n", "sep=;\n"])
def test_lines_above_the_header_are_left_out_and_told(tmp_path: Path, above: str) -> None:
    log = read(tmp_path, "t [s];v [m/s];x [m]", lambda i: f"{0.02 * i:.2f};1;{i}", above)
    assert log.t == pytest.approx(0.02 * np.arange(ROWS))
    (finding,) = [f for f in examine(log) if f.code == "log.lines_above_header"]
    assert (finding.line, finding.severity) == (1, "warning")
    assert f": {above.count(chr(10))} line" in str(finding)


def test_the_lines_of_rows_count_from_the_top_of_the_file(tmp_path: Path) -> None:
    with pytest.raises(LogError, match=r"a\.csv:13: error value\.not_a_number column v") as error:
        read(tmp_path, "t [s],v [m/s]", lambda i: f"{i},{'x' if i == 10 else 1}", "one\n")
    assert "2 fields" not in str(error.value)


def test_a_row_that_is_short_is_no_header(tmp_path: Path) -> None:
    with pytest.raises(LogError, match=r"a\.csv:3: error log\.ragged_row"):
        read(tmp_path, "t [s],v [m/s],x [m]", lambda i: f"{i},1,1" if i != 1 else f"{i},1")


STAMPS = {
    "time of day": lambda i: f"12:03:{4 + i // 50:02d}.{i % 50 * 20:03d}",
    "ISO 8601": lambda i: f"2026-05-01T12:03:04.{i % 50 * 20:03d}",
    "with a zone": lambda i: f"2026-05-01 12:03:04.{i % 50 * 20:03d}+02:00",
    "days first": lambda i: f"01.05.2026 12:03:04.{i % 50 * 20:03d}",
}


@pytest.mark.parametrize("kind", STAMPS)
def test_stamps_of_words_are_seconds(tmp_path: Path, kind: str) -> None:
    log = read(tmp_path, "time,v [m/s]", lambda i: f"{STAMPS[kind](i)},1")
    assert np.diff(log.t) == pytest.approx(0.02, abs=1e-6)
    begin = 12 * 3600 + 3 * 60 + 4 if kind == "time of day" else 0  # s; a date begins at 0, its origin is told
    assert log.t[0] == pytest.approx(begin)


def test_a_time_of_day_goes_on_after_midnight(tmp_path: Path) -> None:
    log = read(tmp_path, "time,v [m/s]", lambda i: f"{23 + i // 25 if i < 25 else 0:02d}:{59 if i < 25 else 0:02d}:"
               f"{i + 35 if i < 25 else i - 25:02d},1")  # fmt: skip
    assert np.diff(log.t) == pytest.approx(1.0)


def test_a_day_alone_is_no_time(tmp_path: Path) -> None:
    with pytest.raises(LogError, match=r"a\.csv:1: error log\.time_missing column t"):
        read(tmp_path, "time,v [m/s]", lambda i: f"2026-05-{1 + i % 28:02d},1")


def test_a_quoted_decimal_comma_is_one_unless_it_may_separate_thousands(tmp_path: Path) -> None:
    log = read(tmp_path, "t [s],v [m/s]", lambda i: f'"{i // 50},{i % 50 * 2:02d}","12,5"')
    assert log.t == pytest.approx(0.02 * np.arange(ROWS))
    assert set(log.columns["v"]) == {12.5}
    with pytest.raises(LogError, match=r"value\.not_a_number column v"):
        read(tmp_path, "t [s],v [m/s]", lambda i: f'{i},"1,250"')


def test_a_time_in_words_that_is_none_is_told_with_what_is_allowed(tmp_path: Path) -> None:
    with pytest.raises(LogError) as error:
        read(tmp_path, "time,v [m/s]", lambda i: f"05/01/2026 12:00:{i:02d},1")
    told = [f for f in error.value.findings if f.element == "column time"]
    assert [f.line for f in told] == [2]
    assert "found '05/01/2026 12:00:00'; allowed: a number, or a time such as 12:03:04.5" in told[0].message


def test_a_first_row_with_nothing_but_its_time_is_no_row_of_units(tmp_path: Path) -> None:
    log = read(tmp_path, "time,v [m/s]", lambda i: f"12:00:{i:02d},{i if i else ''}")
    assert log.t.tolist() == [43200.0 + i for i in range(ROWS)]
    assert np.isnan(log["v"]).tolist() == [True] + (ROWS - 1) * [False]


@pytest.mark.parametrize("separator", [",", ";", "\t", " "])
def test_a_comment_among_the_rows_is_passed_over(tmp_path: Path, separator: str) -> None:
    """Also one that was a row; lines keep their numbers."""
    path = tmp_path / "a.csv"
    rows = [f"{i}{separator}{10 * i}" for i in range(10)]
    rows[4:4] = ["# a lap, the second", f"#4{separator}40"]
    path.write_text("\n".join([separator.join(("t_s", "v_mps")), *rows, ""]), encoding="utf-8")
    log = read_log(path)
    assert log["v"].tolist() == [10.0 * i for i in range(10)]
    path.write_text(path.read_text(encoding="utf-8").replace("50", "x"), encoding="utf-8")
    with pytest.raises(LogError, match=r"a\.csv:9: error"):
        read_log(path)
