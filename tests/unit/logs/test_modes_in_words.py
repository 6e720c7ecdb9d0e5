"""A mode that a log writes in words, as Apollo's COMPLETE_AUTO_DRIVE, says who drives."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from asammdf import MDF, Signal
from mcaps import write_json

from pytest_dvp.logs.engagement import driven_by_others
from pytest_dvp.logs.formats.ros_bag import read_bag
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_error import LogError
from pytest_dvp.logs.read_log import read_log
from pytest_dvp.logs.texts import LONGEST, MOST, texts_of

AUTO, MANUAL = "COMPLETE_AUTO_DRIVE", "COMPLETE_MANUAL"
T = np.arange(200) * 0.02  # s
BY_HAND = (T >= 1.0) & (T < 2.5)
WORDS = [MANUAL if hand else AUTO for hand in BY_HAND]


def mapping(folder: Path, when: str, field: str = "mode", more: str = "") -> Path:
    text = f'[[signal]]\nname = "v"\nfield = "v"\nunit = "m/s"\n[[signal]]\nname = "engaged"\nfield = "{field}"\n'
    (folder / "map.toml").write_text(f"{text}when = {when}\n{more}", encoding="utf-8")
    return folder / "map.toml"


def csv(folder: Path, words: list[str]) -> Path:
    rows = (f"{t:.2f},{t},{word}\n" for t, word in zip(T, words, strict=True))
    (folder / "log.csv").write_text("t,v,mode\n" + "".join(rows), encoding="utf-8")
    return folder / "log.csv"


def json_mcap(folder: Path, words: list[str]) -> Path:
    rows = [(float(t), {"v": float(t), "mode": word}) for t, word in zip(T, words, strict=True)]
    return write_json(folder / "log.mcap", {"/chassis": rows})


def mdf(folder: Path, words: list[str]) -> Path:
    table = {"val_0": 1, "text_0": AUTO.encode(), "val_1": 4, "text_1": MANUAL.encode()}
    codes = np.array([1 if word == AUTO else 4 for word in words], dtype=np.uint8)
    with MDF(version="4.10") as file:
        file.append([Signal(T, T, name="v"), Signal(codes, T, name="mode", conversion=table)])
        file.save(folder / "log.mf4", overwrite=True)
    return folder / "log.mf4"


FORMATS = {"csv": csv, "mcap": json_mcap, "mdf": mdf}


@pytest.mark.parametrize("kind", FORMATS)
def test_words_say_who_drives(tmp_path: Path, kind: str) -> None:
    log = read_log(FORMATS[kind](tmp_path, WORDS), mapping=mapping(tmp_path, f'["{AUTO}"]'))
    assert np.array_equal(driven_by_others(log), BY_HAND)
    assert log.meta["import"]["findings"] == []


@pytest.mark.parametrize("kind", FORMATS)
def test_numbers_for_a_field_of_words_are_answered_with_its_words(tmp_path: Path, kind: str) -> None:
    with pytest.raises(LogError, match=f'when: found .1., but .mode. holds words: "{AUTO}", "{MANUAL}"'):
        read_log(FORMATS[kind](tmp_path, WORDS), mapping=mapping(tmp_path, "[1]"))


def test_words_for_a_field_of_numbers_are_answered_with_its_numbers(tmp_path: Path) -> None:
    with pytest.raises(LogError, match="but 'mode' holds numbers: 1, 4"):
        read_log(csv(tmp_path, ["4" if hand else "1" for hand in BY_HAND]), mapping=mapping(tmp_path, '["AUTO"]'))


def test_a_field_of_words_is_there_and_no_number(tmp_path: Path) -> None:
    more = '[[signal]]\nname = "mine"\nfield = "mode"\nunit = "m"\n'
    with pytest.raises(LogError, match="it holds words, which only `when` takes: COMPLETE_AUTO_DRIVE"):
        read_log(csv(tmp_path, WORDS), mapping=mapping(tmp_path, f'["{AUTO}"]', more=more))


@pytest.mark.parametrize(("words", "when"), [(WORDS, '["AUTO_DRIVE"]'), ([str(int(h)) for h in BY_HAND], "[7]")])
def test_a_mode_that_never_comes_is_told(tmp_path: Path, words: list[str], when: str) -> None:
    log = read_log(csv(tmp_path, words), mapping=mapping(tmp_path, when))
    (told,) = log.meta["import"]["findings"]
    assert (told["code"], told["severity"]) == ("log.mode_absent", "warning")
    assert f"never holds {when[1:-1]}, which `when` names" in told["text"]
    assert driven_by_others(log).all()


@pytest.mark.parametrize("more", ['unit = "m"', "scale = 2.0", "sign = -1.0", "offset = 1.0", "ratio = 3.0"])
def test_a_mode_has_no_unit_and_no_scale(tmp_path: Path, more: str) -> None:
    with pytest.raises(LogError, match=r"engaged\.when: found .*, allowed: no unit, scale, sign"):
        read_log(csv(tmp_path, WORDS), mapping=mapping(tmp_path, f'["{AUTO}"]', more=more))


def test_a_mode_of_words_that_is_not_mapped_is_listed(tmp_path: Path) -> None:
    only = tmp_path / "map.toml"
    only.write_text('[[signal]]\nname = "v"\nfield = "v"\nunit = "m/s"\n', encoding="utf-8")
    for kind in FORMATS.values():
        found = read_log(kind(tmp_path, WORDS), mapping=only)
        assert any(field.split()[-1] == "mode" for field in found.meta["import"]["unmapped"])


def test_sentences_and_names_without_end_are_no_modes() -> None:
    assert texts_of(["a" * LONGEST, None, "b"]) is not None
    assert texts_of(["a" * (LONGEST + 1)]) is None
    assert texts_of([f"{k}" for k in range(MOST)]) is not None
    assert texts_of([f"{k}" for k in range(MOST + 1)]) is None
    assert texts_of([None, ""]) is None


def test_a_message_without_the_word_holds_none(tmp_path: Path) -> None:
    rows = [(float(t), {"v": float(t), **({"mode": AUTO} if t >= 1.0 else {})}) for t in T]
    file = write_json(tmp_path / "log.mcap", {"/chassis": rows})
    log = read_log(file, mapping=mapping(tmp_path, f'["{AUTO}"]'))
    assert isinstance(log, Log)
    assert np.array_equal(np.isnan(log.columns["engaged"]), T < 1.0)


def test_a_string_message_of_a_bag(tmp_path: Path) -> None:
    from rosbags.rosbag1 import Writer
    from rosbags.typesys import Stores, get_typestore

    from openscenario.findings import Findings

    store = get_typestore(Stores.ROS1_NOETIC)
    kind = "std_msgs/msg/String"
    with Writer(tmp_path / "a.bag") as bag:
        connection = bag.add_connection("/mode", kind, typestore=store)
        for t, word in zip(T, WORDS, strict=True):
            bag.write(connection, round(1e9 * (t + 1.0)), store.serialize_ros1(store.types[kind](word), kind))
    (found,) = read_bag(tmp_path / "a.bag", Findings())
    assert found.texts["data"].words == (AUTO, MANUAL)
    assert np.array_equal(found.texts["data"].codes == 1.0, BY_HAND)
