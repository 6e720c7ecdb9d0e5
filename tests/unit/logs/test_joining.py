"""Raw CSV files as owners publish them: comment headers, index columns, time in two columns, one file a topic."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from openscenario.findings import Findings
from pytest_dvp.cli.command_line import main
from pytest_dvp.logs.formats.csv_file import read_csv
from pytest_dvp.logs.joining import join
from pytest_dvp.logs.log_error import LogError
from pytest_dvp.logs.mapping_proposal import propose
from pytest_dvp.logs.mapping_text import mapping_text
from pytest_dvp.logs.read_log import read_log, read_streams


def written(path: Path, header: str, *rows: str) -> Path:
    path.write_text("\n".join([header, *rows]) + "\n")
    return path


def test_a_comment_with_a_name_for_each_number_is_the_header(tmp_path: Path) -> None:
    file = written(tmp_path / "a.csv", "# time(s),v(km/h)", "0.0,36", "0.1,36", "0.2,36")
    log = read_log(file)
    assert log.columns["v"].tolist() == pytest.approx([10.0] * 3)


@pytest.mark.parametrize("comment", ["# drive of Monday, dry", "# 1.0,2.0"])
def test_another_comment_is_passed_over(tmp_path: Path, comment: str) -> None:
    file = written(tmp_path / "a.csv", comment, "t [s],v [m/s]", "0.0,1", "0.1,2", "0.2,3")
    assert read_log(file).columns["v"].tolist() == [1.0, 2.0, 3.0]


def test_a_first_column_without_a_name_is_an_index(tmp_path: Path) -> None:
    file = written(tmp_path / "a.csv", ",t [s],v [m/s]", "0,0.0,1", "1,0.1,2", "2,0.2,3")
    assert [c.header.name for c in read_csv(file).columns] == ["index", "t", "v"]
    assert read_log(file)["index"].tolist() == [0.0, 1.0, 2.0]  # and needs no unit
    with pytest.raises(LogError, match="column 2 has no name"):
        read_csv(written(tmp_path / "b.csv", "t [s],,v [m/s]", "0.0,1,2"))


def test_seconds_and_nanoseconds_are_one_time(tmp_path: Path) -> None:
    rows = [f"{17 + (k + 8) // 10},{(k + 8) % 10 * 100_000_000},{k}" for k in range(5)]
    (stream,) = read_streams(written(tmp_path / "a.csv", "s,ns,V", *rows), Findings())
    assert stream.receive.tolist() == pytest.approx([17.8, 17.9, 18.0, 18.1, 18.2], abs=1e-9)
    assert list(stream.fields) == ["t", "V"]


def test_two_columns_that_are_no_such_time_stay(tmp_path: Path) -> None:
    file = written(tmp_path / "a.csv", "t,s,ns", "0,0.5,3", "1,0.7,4", "2,0.9,5")
    assert [c.header.name for c in read_csv(file).columns] == ["t", "s", "ns"]


def turned(file: Path, names: str) -> Path:
    yaw = np.linspace(3.0, 3.4, 5)  # over the border at pi
    rows = [f"{0.1 * k},0,0,{np.sin(a / 2):.12f},{np.cos(a / 2):.12f},0.1" for k, a in enumerate(yaw)]
    return written(file, f"t,{names},roll", *rows)


@pytest.mark.parametrize("names", ["q.x,q.y,q.z,q.w", "qx,qy,qz,qw", "q_x,q_y,q_z,q_w"])
def test_a_quaternion_is_a_yaw_and_its_parts_are_no_position(tmp_path: Path, names: str) -> None:
    streams = read_streams(turned(tmp_path / "a.csv", names), Findings())
    assert isinstance(streams, list)
    chosen, unsure = propose(streams)
    assert [(s.name, s.field, s.unit) for s in chosen.signals] == [("yaw", "q", "quaternion")]
    assert unsure == ()
    (tmp_path / "map.toml").write_text(mapping_text(streams))
    log = read_log(tmp_path / "a.csv", mapping=tmp_path / "map.toml")
    assert log.columns["yaw"] == pytest.approx(np.linspace(3.0, 3.4, 5), abs=1e-9)


def test_a_roll_angle_is_no_steering(tmp_path: Path) -> None:
    rows = [f"{0.1 * k},{0.01 * k},{0.02 * k}" for k in range(5)]
    streams = read_streams(written(tmp_path / "a.csv", "t [s],roll [rad],wanted [rad]", *rows), Findings())
    assert isinstance(streams, list)
    text = mapping_text(streams)
    assert 'field = "wanted"' in text
    assert 'field = "roll"' not in text


@pytest.fixture
def parts(tmp_path: Path) -> list[Path]:
    """Commands at 10 Hz and poses at 5 Hz, whose clock begins later."""
    commands = [f"{100 + k // 10},{k % 10 * 100_000_000},{0.1 * k:.1f}" for k in range(20)]
    poses = [f"{100.5 + 0.2 * k:.1f},{k},7" for k in range(5)]
    return [
        written(tmp_path / "commands.csv", "s,ns,delta", *commands),
        written(tmp_path / "poses.csv", "t [s],x [m],delta", *poses),
    ]


def test_files_of_one_drive_become_one_by_their_clocks(parts: list[Path], tmp_path: Path) -> None:
    found = join(parts)
    assert found.t.tolist() == pytest.approx([0.1 * k for k in range(20)])
    assert list(found.columns) == ["delta", "x [m]", "poses.delta"]
    assert found.renamed == {"poses.csv: delta": "poses.delta"}
    known = np.isfinite(found.columns["x [m]"])
    assert found.t[known].tolist() == pytest.approx([0.5, 0.7, 0.9, 1.1, 1.3])
    assert found.columns["x [m]"][known].tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]
    assert found.columns["delta"].tolist() == pytest.approx([0.1 * k for k in range(20)])


def test_a_time_without_a_unit_is_in_that_of_its_steps_and_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Both begin at 20 s; the second has ten rows a second, 100 ms apart."""
    first = written(tmp_path / "a.csv", "t [s],x [m]", *(f"{20 + 0.2 * k:.1f},{k}" for k in range(20)))
    second = written(tmp_path / "b.csv", "time,v [m/s]", *(f"{20_000 + 100 * k},{k}" for k in range(40)))
    found = join([first, second])
    assert found.guessed == {str(second): "ms"}
    assert found.t == pytest.approx(0.1 * np.arange(40))
    assert main(["join", str(first), str(second), "--out", str(tmp_path / "c.csv")]) == 0
    assert f"{second}: its time does not say its unit; taken for ms" in capsys.readouterr().out


def test_the_joined_file_is_read_back_as_it_was(
    parts: list[Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "drive.csv"
    assert main(["join", *map(str, parts), "--out", str(out), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["rows"] == 20
    assert told["renamed"] == {"poses.csv: delta": "poses.delta"}
    table = {c.header.name: c.values for c in read_csv(out).columns}
    for header, values in join(parts).columns.items():
        np.testing.assert_array_equal(table[header.partition(" [")[0]], values)


def test_columns_that_took_another_name_are_one_line(
    parts: list[Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["join", *map(str, parts), "--out", str(tmp_path / "drive.csv")]) == 0
    lines = [line for line in capsys.readouterr().out.splitlines() if "poses.delta" in line]
    assert lines == ["  called after their file, because an earlier file has a column of that name: poses.delta"]


def test_what_cannot_be_joined_is_said_in_one_line(
    parts: list[Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    late = written(tmp_path / "late.csv", "t [s],z [m]", "900.0,1", "900.1,2", "900.2,3")
    timeless = written(tmp_path / "timeless.csv", "a,b", "3,1", "1,2", "2,3")
    back = written(tmp_path / "back.csv", "t [s],z [m]", "100.0,1", "101.0,2", "100.5,3")
    for wrong, said in ((late, "does not overlap"), (timeless, "no time column"), (back, "jumps back")):
        assert main(["join", str(parts[0]), str(wrong), "--out", str(tmp_path / "out.csv")]) == 1
        (line,) = capsys.readouterr().err.splitlines()
        assert said in line
        assert str(wrong) in line
    assert not (tmp_path / "out.csv").exists()


def test_a_mode_in_words_is_kept(tmp_path: Path) -> None:
    car = written(tmp_path / "car.csv", "t [s],v [m/s]", "0.0,1", "0.1,2", "0.2,3")
    modes = written(tmp_path / "modes.csv", "t [s],mode,count", "0.0,AUTO,1", '0.2,"MANUAL, by hand",2')
    out = tmp_path / "drive.csv"
    assert main(["join", str(car), str(modes), "--out", str(out)]) == 0
    (stream,) = read_streams(out, Findings())
    texts = stream.texts["mode"]
    assert [None if np.isnan(code) else texts.words[int(code)] for code in texts.codes] == [
        "AUTO", None, "MANUAL  by hand",
    ]  # fmt: skip
    assert list(stream.fields) == ["t", "v", "count"]


@pytest.mark.parametrize("name", ["header.stamp", "%time"])
def test_the_stamp_of_a_ros_topic_is_its_time_and_said(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Epochs in ns, 20 and 10 a second, as rosbag tools write them: `dvp map` took them for the time."""
    epoch = 1_717_401_000_000_000_000
    first = written(tmp_path / "cmd.csv", f"{name},speed", *(f"{epoch + 50_000_000 * k},{k}" for k in range(40)))
    second = written(tmp_path / "odom.csv", f"seq,{name},v", *(f"{k},{epoch + 10**8 * k},{k}" for k in range(20)))
    assert main(["join", str(first), str(second), "--out", str(tmp_path / "c.csv")]) == 0
    told = capsys.readouterr().out
    assert f"{second}: no column is called a time; {name} is taken for it" in told
    assert f"{second}: its time does not say its unit; taken for ns" in told
    found = join([first, second])
    assert found.t == pytest.approx(0.05 * np.arange(40), abs=1e-5)
    assert list(found.columns) == ["speed", "seq", "v"]
    assert found.columns["v"][::2] == pytest.approx(np.arange(20))


@pytest.mark.parametrize("header", ["count,v [m/s]", "x [m],v [m/s]"])
def test_what_counts_rows_or_is_no_time_is_none(header: str, tmp_path: Path) -> None:
    first = written(tmp_path / "a.csv", "t [s],z [m]", *(f"{k},{k}" for k in range(20)))
    second = written(tmp_path / "b.csv", header, *(f"{k},{k * k % 7}" for k in range(20)))
    with pytest.raises(LogError, match="no time column"):
        join([first, second])
