"""dvp recover: every whole row, chunk and message of a damaged file comes out, and the loss is said."""

from __future__ import annotations

import json
import struct
from pathlib import Path

import numpy as np
import pytest
from drives import drive, write_csv
from mcap.reader import make_reader
from mcap.writer import CompressionType
from mcaps import states, write_json

from pytest_dvp.cli.command_line import main
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.read_log import read_log


def recovered(path: Path, out: Path, capsys: pytest.CaptureFixture[str]) -> dict[str, object]:
    assert main(["recover", str(path), "--out", str(out), "--json"]) == 0
    told: dict[str, object] = json.loads(capsys.readouterr().out)
    return told


def messages(path: Path) -> list[tuple[int, bytes]]:
    with path.open("rb") as file:
        return [(message.log_time, message.data) for _, _, message in make_reader(file).iter_messages()]


def test_rows_around_a_block_of_zeros_do_not_become_one(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A block that was never written begins in one row and ends in another; together they would look like a whole."""
    rows = [f"{0.1 * k:.1f},{k}.5" for k in range(60)]
    text = "t [s],v [m/s]\n" + "\n".join(rows) + "\n"
    begin, end = text.index("2.0,20.5") + 3, text.index("3.0,30.5") + 3
    path, out = tmp_path / "a.csv", tmp_path / "b.csv"
    path.write_text(text[:begin] + "\x00" * (end - begin) + text[end:], encoding="utf-8")
    told = recovered(path, out, capsys)
    assert out.read_text(encoding="utf-8").split("\n")[1:-1] == rows[:20] + rows[31:]
    assert told["lost"] == ["1 row not whole, first in line 22", f"{end - begin} zero bytes"]


def test_the_whole_rows_of_a_damaged_table_come_out_word_for_word(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, out = write_csv(tmp_path / "a.csv", drive(10.0)), tmp_path / "b.csv"
    lines = path.read_text(encoding="utf-8").split("\n")
    spoilt = [*lines]
    spoilt[100] = spoilt[100][:10]  # cut
    spoilt[200] = spoilt[200].replace(",", ",x", 1)  # no number
    spoilt[300] = "\x00" * 40  # a block that was never written
    path.write_text("\n".join(spoilt)[:-30], encoding="utf-8")
    assert main(["check", str(path)]) == 1
    capsys.readouterr()
    told = recovered(path, out, capsys)
    assert told["kept"] == 500 - 4
    assert out.read_text(encoding="utf-8").split("\n")[:-1] == [
        line for i, line in enumerate(lines) if i not in (100, 200, 300, 500) and line
    ]
    assert told["lost"] == ["3 rows not whole, first in line 101", "40 zero bytes"]
    assert len(read_log(out).t) == 496


def test_units_rows_decimal_commas_words_and_empty_fields_stay(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, out = tmp_path / "a.csv", tmp_path / "b.csv"
    rows = [f"{i};1,5;auto;" for i in range(9)]
    path.write_text("# exported\nt;v;mode;x\ns;km/h;-;m\n" + "\n".join(rows) + "\n9;1,", encoding="utf-8")
    assert recovered(path, out, capsys)["kept"] == 9
    assert out.read_text(encoding="utf-8") == "# exported\nt;v;mode;x\ns;km/h;-;m\n" + "\n".join(rows) + "\n"


@pytest.mark.parametrize("share", [0.4, 0.95])
def test_the_whole_chunks_of_a_cut_recording_come_out(
    tmp_path: Path, share: float, capsys: pytest.CaptureFixture[str]
) -> None:
    path, out = write_json(tmp_path / "a.mcap", {"/car": states()}), tmp_path / "b.mcap"
    whole = messages(path)
    data = path.read_bytes()
    path.write_bytes(data[: int(share * len(data))])
    assert main(["check", str(path)]) in (0, 1)
    assert "dvp recover" in capsys.readouterr().out
    told = recovered(path, out, capsys)
    kept = messages(out)
    assert kept == whole[: len(kept)]
    assert len(kept) == told["kept"] > 0.5 * share * len(whole)


@pytest.mark.parametrize("compression", [CompressionType.ZSTD, CompressionType.LZ4])
def test_what_follows_a_damaged_place_comes_out_too(
    tmp_path: Path, compression: CompressionType, capsys: pytest.CaptureFixture[str]
) -> None:
    path = write_json(tmp_path / "a.mcap", {"/car": states()}, compression=compression)
    whole = messages(path)
    data = bytearray(path.read_bytes())
    second = data.index(b"zstd" if compression is CompressionType.ZSTD else b"lz4", len(data) // 3) - 41
    assert data[second] == 6
    struct.pack_into("<Q", data, second + 1, 2**62)  # its length: all that follows is out of step
    path.write_bytes(bytes(data))
    told = recovered(path, tmp_path / "b.mcap", capsys)
    kept = messages(tmp_path / "b.mcap")
    assert 0.5 * len(whole) < len(kept) < len(whole)
    assert kept[-1] == whole[-1]
    assert set(kept) < set(whole)
    assert any(f"{len(whole) - len(kept)} of {len(whole)} messages" in text for text in told["lost"])  # type: ignore[attr-defined]


def test_a_damaged_log_of_ours_becomes_a_whole_one(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = 60_000
    t = np.arange(rows) * 0.01
    path, out = tmp_path / "log.mcap", tmp_path / "b.mcap"
    Log({"t": t, "v": np.random.default_rng(0).normal(size=rows)}, meta={"seed": 7}).save(path)
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    path.write_bytes(bytes(data))
    told = recovered(path, out, capsys)
    log = Log.load(out)
    assert told["kept"] == len(log.t)
    assert 0.5 * rows < len(log.t) < rows
    assert log.t[-1] == t[-1]
    assert log.meta["seed"] == 7
    assert any("damaged chunk" in text for text in told["lost"])  # type: ignore[attr-defined]


def test_a_whole_file_loses_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = write_csv(tmp_path / "a.csv", drive(10.0))
    assert recovered(path, tmp_path / "b.csv", capsys)["lost"] == []
    assert (tmp_path / "b.csv").read_bytes() == path.read_bytes()
    path = write_json(tmp_path / "a.mcap", {"/car": states()})
    assert recovered(path, tmp_path / "b.mcap", capsys)["lost"] == []
    assert messages(tmp_path / "b.mcap") == messages(path)


@pytest.mark.parametrize(
    ("name", "data"), [("a.csv", b"t [s],v [m/s]\n\x00\x00"), ("a.mcap", b"nothing at all"), ("b.csv", b"")]
)
def test_a_file_with_nothing_whole_is_answered_with_1(
    tmp_path: Path, name: str, data: bytes, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / name).write_bytes(data)
    out = tmp_path / f"out{Path(name).suffix}"
    assert main(["recover", str(tmp_path / name), "--out", str(out)]) == 1
    assert len(capsys.readouterr().err.splitlines()) == 1
    assert not out.exists()


@pytest.mark.parametrize(
    "words", [["absent.csv", "--out", "b.csv"], ["a.csv"], ["a.csv", "--out", "a.csv"], ["a.csv", "--out", "b.mcap"]]
)
def test_wrong_arguments_are_answered_with_2(
    tmp_path: Path, words: list[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    write_csv(tmp_path / "a.csv", drive(10.0))
    assert main(["recover", *words]) == 2
    assert capsys.readouterr().out == ""


def test_a_last_row_that_was_cut_is_a_warning_and_left_out(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = write_csv(tmp_path / "a.csv", drive(30.0))
    path.write_bytes(path.read_bytes()[:-40])
    assert main(["check", "--json", str(path)]) == 0
    (finding,) = json.loads(capsys.readouterr().out)["findings"]
    assert (finding["code"], finding["severity"], finding["line"]) == ("log.truncated", "warning", 1501)
    assert len(read_log(path).t) == 1499
