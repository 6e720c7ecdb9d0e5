"""A TOML file of a user, whoever reads it: its tables, or what is wrong with it and in which line."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from pytest_dvp.drive.remote_stack import RemoteStack
from pytest_dvp.logs.log_error import LogError
from pytest_dvp.logs.mapping import read_mapping
from pytest_dvp.tuning.iteration_plan_file import read_plan
from pytest_dvp.tuning.study_file import read_study
from pytest_dvp.verdicts.judging import GateError, read_gates
from vehicle.adapters.carla import _read as read_carla
from vehicle.guard.arming import read as read_arming
from vehicle.guard.envelope import read_envelope
from vehicle.guard.guard import ArmingRefused
from vehicle.surrogate.hidden import read_hidden
from vehicle.toml_file import MOST, TomlError, parse_toml, read_toml
from vehicle.wire.can_map import find_map
from vehicle.wire.ros1 import read_settings

WRONG: dict[str, tuple[bytes, str, int | None, str]] = {
    "no value": (b"a = 1\nb =\n", "not_toml", 2, "not TOML: Invalid value"),
    "cut": (b'a = 1\nb = "x', "not_toml", 2, "not TOML: Unterminated string"),
    "twice": (b"a = 1\na = 2\n", "not_toml", 2, "not TOML: Cannot overwrite a value"),
    "YAML": (b"a:\n  - b: 1\n", "not_toml", 1, "not TOML: Expected '=' after a key in a key/value pair"),
    "UTF-16": ("a = 1\n".encode("utf-16"), "not_utf8", None, "not UTF-8 text but UTF-16: save it as UTF-8"),
    "Latin-1": ("a = 1\n# für\n".encode("latin-1"), "not_utf8", 2, "not UTF-8 text"),
    "deep": (b"a = " + b"[" * 50_000, "too_deep", None, "not TOML: nested too deeply"),
    "digits": (b"a = " + b"9" * 5_000, "not_toml", None, "not TOML: a number with too many digits"),
    "large": (b"a = [{b = " + b"9" * 400 + b"}]", "not_toml", None, "not TOML: a whole number of more than 64 bits"),
    "long": (b"#" * (MOST + 1), "too_large", None, "larger than 4 MB"),
}
READERS: dict[str, Callable[[Path], object]] = {
    "gates": read_gates,
    "mapping": read_mapping,
    "study": read_study,
    "plan": read_plan,
    "stack": RemoteStack,
    "hidden": read_hidden,
    "envelope": read_envelope,
    "arming": lambda path: read_arming(path, "tabby", "x.xosc"),
    "CAN": find_map,
    "ROS 1": read_settings,
    "CARLA": read_carla,
}


def test_a_byte_order_mark_is_passed_over(tmp_path: Path) -> None:
    path = tmp_path / "a.toml"
    path.write_bytes(b"\xef\xbb\xbfa = 1\n[b]\nc = [2, -9223372036854775808]\n")
    data, text = read_toml(path)
    assert data == {"a": 1, "b": {"c": [2, -(2**63)]}}
    assert text.startswith("a = 1")


@pytest.mark.parametrize("name", WRONG)
def test_what_is_wrong_is_said_with_its_line(tmp_path: Path, name: str) -> None:
    data, kind, line, says = WRONG[name]
    path = tmp_path / "a.toml"
    path.write_bytes(data)
    with pytest.raises(TomlError) as caught:
        read_toml(path)
    assert (str(caught.value), caught.value.kind, caught.value.line) == (says, kind, line)


def test_no_file_and_a_folder_are_told(tmp_path: Path) -> None:
    for path, says in ((tmp_path / "none.toml", "No such file or directory"), (tmp_path, "Is a directory")):
        with pytest.raises(TomlError, match=f"^{says}$") as caught:
            read_toml(path)
        assert caught.value.kind == "unreadable"


def test_a_text_is_read_alike() -> None:
    assert parse_toml("a = 1") == {"a": 1}
    with pytest.raises(TomlError, match=r"^not TOML: Invalid value$"):
        parse_toml("a = ")


@pytest.mark.parametrize("name", WRONG)
@pytest.mark.parametrize("reader", READERS)
def test_every_reader_says_it_in_one_line_of_its_own(tmp_path: Path, reader: str, name: str) -> None:
    data, _, line, says = WRONG[name]
    path = tmp_path / "a.toml"
    path.write_bytes(data)
    with pytest.raises((ValueError, RuntimeError, GateError, LogError, ArmingRefused)) as caught:
        READERS[reader](path)
    assert type(caught.value).__module__.split(".")[0] in ("pytest_dvp", "vehicle")
    told = str(caught.value)
    assert says in told
    assert f"a.toml:{line}:" in told if line is not None else "a.toml: " in told
    assert "\n" not in told
