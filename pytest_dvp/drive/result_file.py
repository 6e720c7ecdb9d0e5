"""result.json of a run folder, read as somebody may have left it: cut, edited by hand, of another tool."""

from __future__ import annotations

import codecs
from pathlib import Path
from typing import Any

import msgspec

from pytest_dvp.verdicts.judging import Status

MOST = 64_000_000  # bytes of a result that is read, about what a scenario may have (openscenario.file_budget.BYTES)


class ResultFileError(ValueError):
    """A file that is not the result of a run: one line with the field that is wrong."""


class _Verdict(msgspec.Struct):
    gate: str
    metric: str
    status: Status
    message: str
    short: str
    value: float | None = None
    unit: str = ""
    bound: float | None = None
    margin: float | None = None
    t: float | None = None
    object: str = ""
    file: str = ""
    line: int | None = None
    name: str = ""
    used: float | None = None
    reason: str = ""
    requirement: str = ""


class _Result(msgspec.Struct):
    """What others rely on; a result may hold more."""

    scenario: str
    status: Status
    verdicts: list[_Verdict]
    stage: str = ""
    seed: int | None = None
    replay: str = ""
    ended: str = ""
    error: str | None = None
    notes: list[str] = []
    set: dict[str, str] = {}
    logs: dict[str, str] = {}
    metrics: dict[str, Any] = {}
    tick_time: dict[str, float | None] = {}
    findings: list[dict[str, Any]] = []
    compute_delay: str | None = None


def read_result(path: Path) -> dict[str, Any]:
    """The result of a run or of stages held against each other, as it was written.

    Raises ResultFileError, and OSError if there is no such file.
    """
    with path.open("rb") as file:
        data = file.read(MOST + 1)
    if len(data) > MOST:
        raise ResultFileError(f"{path}: not the result of a run: larger than {MOST // 1_000_000} MB")
    data = data.removeprefix(codecs.BOM_UTF8)
    try:
        found: dict[str, Any] = msgspec.json.decode(data, type=dict[str, Any])
        msgspec.convert(found, _Result)
    except (msgspec.MsgspecError, UnicodeDecodeError) as error:
        raise ResultFileError(f"{path}: not the result of a run: {error}") from None
    except RecursionError:
        raise ResultFileError(f"{path}: not the result of a run: too deep") from None
    return found
