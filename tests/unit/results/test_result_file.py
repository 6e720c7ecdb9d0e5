"""result.json of a run folder: what is none is refused with the field that is wrong."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from pytest_dvp.drive.result_file import ResultFileError, read_result

VERDICT = {"gate": "collision <= 0", "metric": "collision", "status": "PASS", "message": "m", "short": "s"}
RUN: dict[str, Any] = {"scenario": "x.xosc", "status": "PASS", "verdicts": [VERDICT], "more": [1]}


def test_it_is_read_as_it_was_written_also_with_a_byte_order_mark(tmp_path: Path) -> None:
    path = tmp_path / "result.json"
    for mark in (b"", b"\xef\xbb\xbf"):
        path.write_bytes(mark + json.dumps(RUN).encode())
        assert read_result(path) == RUN


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        (RUN | {"status": "PASSED"}, "Invalid enum value 'PASSED' - at `$.status`"),
        (RUN | {"verdicts": [VERDICT, 1]}, "Expected `object`, got `int` - at `$.verdicts[1]`"),
        (RUN | {"verdicts": [VERDICT | {"line": "1"}]}, "Expected `int | null`, got `str` - at `$.verdicts[0].line`"),
        (RUN | {"notes": "one"}, "Expected `array`, got `str` - at `$.notes`"),
        (RUN | {"logs": {"dt": 1}}, "Expected `str`, got `int` - at `$.logs[...]`"),
        ([RUN], "Expected `object`, got `array`"),
        ({"x": RUN["verdicts"], "y": json.loads("[" * 900 + "]" * 900)}, "missing required field `scenario`"),
    ],
)  # fmt: skip
def test_a_wrong_field_is_named(tmp_path: Path, wrong: object, says: str) -> None:
    path = tmp_path / "result.json"
    path.write_text(json.dumps(wrong))
    with pytest.raises(ResultFileError) as caught:
        read_result(path)
    assert str(caught.value).startswith(f"{path}: not the result of a run: ")
    assert says in str(caught.value)


@pytest.mark.parametrize("data", [b"", b"\xff\xfe{", b'{"a": ', b'{"a": NaN}', b'{"a":' * 100_000, bytes(range(256))])
def test_what_is_no_json_is_refused(tmp_path: Path, data: bytes) -> None:
    path = tmp_path / "result.json"
    path.write_bytes(data)
    with pytest.raises(ResultFileError, match="not the result of a run: "):
        read_result(path)


def test_a_result_of_more_than_64_mb_is_none(tmp_path: Path) -> None:
    path = tmp_path / "result.json"
    with path.open("wb") as file:
        file.truncate(64_000_001)  # sparse
    with pytest.raises(ResultFileError, match=r"result\.json: not the result of a run: larger than 64 MB$"):
        read_result(path)
