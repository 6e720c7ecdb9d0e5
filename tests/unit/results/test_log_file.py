"""Log files: what goes in comes out, byte for byte the same, and damage is never silent."""

from __future__ import annotations

import hashlib
import io
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap.stream_reader import StreamReader
from results_logs import content, drive_straight, log_of, relaxed, rich_log, times, track

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_error import LogError
from pytest_dvp.logs.mcap_write import encode_log


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("log") / "log.mcap"
    rich_log().save(path)
    return path


def test_every_number_comes_back_exactly(saved: Path) -> None:
    assert content(Log.load(saved)) == content(rich_log())


def test_empty_log_comes_back() -> None:
    empty = Log({"t": np.zeros(0), "x": np.zeros(0)})
    assert content(_through_file(empty)) == content(empty)


def test_time_that_jumps_or_is_not_a_number_comes_back() -> None:
    broken = Log({"t": np.array([0.0, np.nan, -5.0, np.inf]), "x": np.arange(4.0)})
    assert content(_through_file(broken)) == content(broken)


@relaxed
@given(seed=st.integers(0, 2**32 - 1), rows=st.integers(0, 230))
def test_any_log_comes_back_exactly(seed: int, rows: int) -> None:
    log = rich_log(seed, rows)
    assert content(_through_file(log)) == content(log)


def test_same_log_gives_the_same_bytes() -> None:
    assert encode_log(rich_log(3)) == encode_log(rich_log(3))


@pytest.mark.parametrize("hash_seed", ["0", "1"])
@pytest.mark.nightly(by_day=2)
def test_bytes_depend_on_neither_process_nor_hash_seed(hash_seed: str) -> None:
    code = (
        "import hashlib; from results_logs import rich_log; from pytest_dvp.logs.mcap_write import encode_log;"
        "print(hashlib.sha256(encode_log(rich_log(3))).hexdigest())"
    )
    environment = {**os.environ, "PYTHONHASHSEED": hash_seed, "PYTHONPATH": str(Path(__file__).parent)}
    other = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    assert other.stdout.strip() == hashlib.sha256(encode_log(rich_log(3))).hexdigest()


def test_reference_reader_reads_every_message_with_checksums(saved: Path) -> None:
    with saved.open("rb") as file:
        counted = sum(type(record).__name__ == "Message" for record in StreamReader(file, validate_crcs=True).records)
    with saved.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        messages = list(reader.iter_messages())
    assert summary is not None
    assert summary.statistics is not None
    assert summary.statistics.message_count == counted == len(messages) > 0
    assert all(isinstance(json.loads(message.data), dict) for _, _, message in messages)


@pytest.mark.parametrize(
    ("topic", "schema"),
    [
        ("/ego/pose", "foxglove.PoseInFrame"),
        ("/ego/signals", "dvp.ego_signals"),
        ("/tf", "foxglove.FrameTransforms"),
        ("/scene", "foxglove.SceneUpdate"),
        ("/scene/road", "foxglove.SceneUpdate"),
    ],
)
def test_viewer_channels_have_foxglove_schemas(topic: str, schema: str, saved: Path) -> None:
    with saved.open("rb") as file:
        found = [(s.name, s.encoding, c.message_encoding) for s, c, _ in make_reader(file).iter_messages([topic]) if s]
    assert set(found) == {(schema, "jsonschema", "json")}


def test_messages_fit_the_schemas_they_declare() -> None:
    for schema, channel, message in make_reader(_stream(rich_log())).iter_messages():
        assert schema is not None
        _assert_fits(json.loads(message.data), json.loads(schema.data), channel.topic)


def test_viewer_shows_the_box_of_an_object_where_it_is() -> None:
    log = drive_straight(0.0, 1.0, objects={"car": track(times(1.0)[::5], 12.0, -3.0, yaw=np.pi / 2)})
    _, _, message = next(make_reader(_stream(log)).iter_messages(["/scene"]))
    ego, car = json.loads(message.data)["entities"]
    assert (ego["id"], car["id"]) == ("ego", "car")
    assert ego["cubes"][0]["pose"]["position"] == {"x": 1.2, "y": 0.0, "z": 0.7}
    assert car["cubes"][0]["pose"]["position"] == {"x": 12.0, "y": -3.0, "z": 0.75}
    assert car["cubes"][0]["pose"]["orientation"]["z"] == pytest.approx(np.sqrt(0.5), abs=1e-6)
    assert car["cubes"][0]["size"] == {"x": 4.0, "y": 2.0, "z": 1.5}


def test_object_that_left_the_run_leaves_the_picture() -> None:
    log = drive_straight(0.0, 2.0, objects={"car": track(times(1.0)[::5], 12.0, 0.0)})
    *_, (_, _, last) = make_reader(_stream(log)).iter_messages(["/scene"])
    assert [entity["id"] for entity in json.loads(last.data)["entities"]] == ["ego"]


def test_viewer_can_plot_the_speed_as_a_plain_number_ten_times_a_second() -> None:
    log = drive_straight(5.0, 1.0)
    messages = [
        (m.log_time, json.loads(m.data)) for _, _, m in make_reader(_stream(log)).iter_messages(["/ego/signals"])
    ]
    assert [time for time, _ in messages] == [100_000_000 * i for i in range(11)]
    assert all(values["v"] == 5.0 for _, values in messages)


def test_viewer_gets_no_number_for_what_was_not_measured() -> None:
    log = drive_straight(5.0, 1.0)
    log.columns["ax"] = np.full(len(log.t), np.nan)
    log.columns["ay"] = np.full(len(log.t), 0.5)
    _, _, first = next(make_reader(_stream(log)).iter_messages(["/ego/signals"]))
    values = json.loads(first.data)
    assert "ax" not in values
    assert values["ay"] == 0.5


def test_a_run_folder_loads_as_its_log(saved: Path) -> None:
    assert content(Log.load(saved.parent)) == content(rich_log())


def test_a_folder_without_a_log_says_which_file_is_missing(tmp_path: Path) -> None:
    with pytest.raises(LogError, match=r"log\.mcap: the log cannot be read"):
        Log.load(tmp_path)


def test_a_usual_other_name_of_a_column_leads_to_ours() -> None:
    with pytest.raises(LogError, match=r"no column 'speed', did you mean 'v'\?"):
        drive_straight(5.0, 1.0)["speed"]


def test_logs_tracks_and_tables_show_as_one_short_line() -> None:
    log = rich_log()
    shown = [repr(log), repr(log.detections), *(repr(track) for track in log.objects.values())]
    assert all("\n" not in text and len(text) < 100 for text in shown)
    assert repr(drive_straight(5.0, 1.0)).startswith("Log(101 rows, 0.00 to 1.00 s, ")


def test_columns_state_their_units_in_the_file(saved: Path) -> None:
    with saved.open("rb") as file:
        _, _, message = next(make_reader(file).iter_messages(["/meta"]))
    units = {column["name"]: column["unit"] for column in json.loads(message.data)["columns"]}
    assert (units["t"], units["x"], units["yaw"], units["v"]) == ("s", "m", "rad", "m/s")


@relaxed
@given(share=st.floats(0.0, 1.0, exclude_max=True))
def test_cut_file_is_an_error_of_one_line(share: float, saved: Path) -> None:
    data = saved.read_bytes()
    path = saved.with_name("cut.mcap")
    path.write_bytes(data[: int(share * len(data))])
    with pytest.raises(LogError) as caught:
        Log.load(path)
    assert "\n" not in str(caught.value)
    assert str(path) in str(caught.value)


@relaxed
@given(position=st.integers(0, 10**9), bit=st.integers(0, 7))
def test_flipped_bit_is_never_silent(position: int, bit: int, saved: Path) -> None:
    data = bytearray(saved.read_bytes())
    data[position % len(data)] ^= 1 << bit
    path = saved.with_name("flipped.mcap")
    path.write_bytes(data)
    with pytest.raises(LogError):
        Log.load(path)


@relaxed
@given(data=st.binary(max_size=400))
def test_arbitrary_bytes_between_the_magics_are_an_error(data: bytes, tmp_path_factory: pytest.TempPathFactory) -> None:
    magic = b"\x89MCAP0\r\n"
    path = tmp_path_factory.getbasetemp() / "noise.mcap"
    path.write_bytes(magic + data + magic)
    with pytest.raises(LogError):
        Log.load(path)


def test_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(LogError, match=r"absent\.mcap: the log cannot be read: No such file"):
        Log.load(tmp_path / "absent.mcap")


@pytest.mark.parametrize(
    ("name", "code"),
    [
        ("log_bad_magic", "log.not_mcap"),
        ("log_not_finished", "log.truncated"),
        ("log_huge_record_length", "log.record_too_long"),
        ("control_log", "log.foreign"),
    ],
)
def test_foreign_and_damaged_files_have_their_code(name: str, code: str, shared_dir: Path) -> None:
    with pytest.raises(LogError) as caught:
        Log.load(shared_dir / "bad_inputs" / f"{name}.mcap")
    assert caught.value.code == code


def test_log_that_cannot_be_written_leaves_nothing(tmp_path: Path) -> None:
    with pytest.raises(LogError, match="cannot be written"):
        log_of(1.0, meta={"thing": object()}).save(tmp_path / "log.mcap")
    assert list(tmp_path.iterdir()) == []


def test_columns_of_other_length_are_refused() -> None:
    with pytest.raises(LogError, match=r"column 'x' is float64\[3\], expected float64\[2\]"):
        Log({"t": np.zeros(2), "x": np.zeros(3)})


def test_unknown_column_names_the_nearest() -> None:
    with pytest.raises(LogError, match="no column 'yaw_rat', did you mean 'yaw_rate'"):
        log_of(1.0)["yaw_rat"]


def test_table_has_a_column_for_every_signal() -> None:
    frame = drive_straight(2.0, 1.0).to_frame()
    assert list(frame.columns[:3]) == ["t", "x", "y"]
    assert frame["x"].iloc[-1] == pytest.approx(2.0)


def _assert_fits(value: object, schema: dict[str, Any], where: str) -> None:
    """The part of JSON Schema that our schemas use; a name that a schema does not list is wrong too."""
    kinds = {"object": dict, "array": list, "string": str, "integer": int, "number": (int, float), "boolean": bool}
    allowed = schema["type"] if isinstance(schema["type"], list) else [schema["type"]]
    assert any(value is None if name == "null" else isinstance(value, kinds[name]) for name in allowed), where
    if isinstance(value, dict) and "properties" in schema:
        for key, item in value.items():
            _assert_fits(item, schema["properties"][key], f"{where}.{key}")
    if isinstance(value, list):
        for item in value:
            _assert_fits(item, schema["items"], f"{where}[]")


def _stream(log: Log) -> io.BytesIO:
    return io.BytesIO(encode_log(log))


def _through_file(log: Log) -> Log:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "log.mcap"
        log.save(path)
        return Log.load(path)
