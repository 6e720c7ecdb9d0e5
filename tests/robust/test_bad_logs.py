"""Damaged logs: one line that says what is wrong, or what was saved; never a traceback, never a silent loss."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from pytest_dvp.doctor import examine
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_error import LogError
from pytest_dvp.logs.read_log import read_log
from pytest_dvp.logs.recovery import recover

MUTATIONS = int(os.environ.get("DVP_FUZZ", "800"))
HEADER = b"t [s],x [m],y [m],yaw [rad],v [m/s],steer_cmd [rad]\n"


def sound_csv() -> bytes:
    rows = (b"%.3f,%.3f,0.0,0.0,%.2f,0.01\n" % (0.02 * i, 0.4 * i, 20.0) for i in range(60))
    return HEADER + b"".join(rows)


def mutated(data: bytes, rng: np.random.Generator) -> bytes:
    out = bytearray(data)
    for _ in range(int(rng.integers(1, 6))):
        at = int(rng.integers(0, max(len(out), 1)))
        match int(rng.integers(0, 6)):
            case 0:
                out[at : at + 1] = bytes([int(rng.integers(0, 256))])
            case 1:
                del out[at : at + int(rng.integers(1, 40))]
            case 2:
                out[at:at] = out[: int(rng.integers(1, 60))]
            case 3:
                out[at:at] = rng.choice(
                    [b",", b"\n", b'"', b";", b"nan", b"1e400", b"-", b"=1+1", b"\x00", b"\xff\xfe"]
                )
            case 4:
                out = out[:at] or out
            case 5:
                out[at : at + 8] = rng.bytes(8)
    return bytes(out)


def answer(path: Path, mapping: Path | None = None) -> LogError | None:
    """Read and examine: the error that refused the file, if one did."""
    try:
        examine(read_log(path, mapping=mapping, strict=False))
    except LogError as error:
        return error
    return None


def is_one_line(error: LogError | None) -> bool:
    return error is None or ("\n" not in str(error) and error.code.split(".")[0] in ("log", "value"))


@pytest.mark.filterwarnings("error")
def test_mutated_csv_files_are_read_or_refused(tmp_path: Path) -> None:
    rng = np.random.default_rng(11)
    path, data = tmp_path / "a.csv", sound_csv()
    for _ in range(MUTATIONS):
        path.write_bytes(mutated(data, rng))
        assert is_one_line(answer(path))


@pytest.mark.filterwarnings("error")
def test_mutated_mcap_files_are_read_or_refused(tmp_path: Path) -> None:
    rng = np.random.default_rng(12)
    t = np.arange(400) * 0.01
    path = tmp_path / "log.mcap"
    Log({"t": t, "v": 5 + np.sin(t), "yaw_rate": 0.1 * np.cos(t), "steer_cmd": np.round(t, 1)}).save(path)
    data = path.read_bytes()
    for _ in range(MUTATIONS // 4):
        path.write_bytes(mutated(data, rng))
        assert is_one_line(answer(path))


@pytest.mark.filterwarnings("error")
def test_mutated_mappings_are_read_or_refused(tmp_path: Path) -> None:
    rng = np.random.default_rng(13)
    log, mapping = tmp_path / "a.csv", tmp_path / "map.toml"
    log.write_bytes(sound_csv())
    good = b'[log]\ntime = "t"\nantenna = [1.0, 0.0]\n' + b"".join(
        b'[[signal]]\nname = "%s"\nfield = "%s"\nunit = "%s"\nscale = 1.0\nsign = -1\n' % (n, n, u)
        for n, u in ((b"x", b"m"), (b"y", b"m"), (b"yaw", b"rad"), (b"v", b"m/s"))
    )
    for _ in range(MUTATIONS // 2):
        mapping.write_bytes(mutated(good, rng))
        assert is_one_line(answer(log, mapping))


@pytest.mark.parametrize("name", ["a.csv", "a.mcap"])
@pytest.mark.filterwarnings("error")
def test_mutated_files_are_recovered_or_refused(tmp_path: Path, name: str) -> None:
    rng = np.random.default_rng(14)
    path, out = tmp_path / name, tmp_path / f"out_{name}"
    t = np.arange(400) * 0.01
    if name == "a.csv":
        path.write_bytes(sound_csv())
    else:
        Log({"t": t, "v": 5 + np.sin(t), "steer_cmd": np.round(t, 1)}).save(path)
    data = path.read_bytes()
    kept = 0
    for _ in range(MUTATIONS // 4):
        path.write_bytes(mutated(data, rng))
        refusal: LogError | None = None
        try:
            kept += recover(path, out).kept > 0
            read_log(out, strict=False)
        except LogError as error:
            refusal = error
        assert is_one_line(refusal)
    assert kept > MUTATIONS // 40
