"""MDF files as other tools write them: groups of one name, samples that do not count, the older version."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pytest_dvp.logs.read_log import read_log

asammdf = pytest.importorskip("asammdf")
pytestmark = pytest.mark.filterwarnings("ignore")

T = np.arange(0.0, 4.0, 0.05)
V = 10.0 + np.sin(T)


def test_two_groups_of_one_name_are_both_read(tmp_path: Path) -> None:
    """Two messages of one bus: their group is called after the bus."""
    with asammdf.MDF(version="4.10") as file:
        file.append([asammdf.Signal(V, T, unit="m/s", name="v")], acq_name="CAN1")
        file.append([asammdf.Signal(0.1 * T[::2], T[::2], unit="rad/s", name="yaw_rate")], acq_name="CAN1")
        file.save(tmp_path / "a.mf4")
    log = read_log(tmp_path / "a.mf4")
    assert log["v"] == pytest.approx(V)
    assert log["yaw_rate"][::2] == pytest.approx(0.1 * T[::2])


def test_a_sample_that_its_bit_calls_invalid_is_not_measured(tmp_path: Path) -> None:
    invalid = np.arange(len(T)) % 4 == 1
    with asammdf.MDF(version="4.10") as file:
        bad = asammdf.Signal(np.where(invalid, 999.0, V), T, unit="m/s", name="v", invalidation_bits=invalid)
        file.append([bad, asammdf.Signal(0.1 * T, T, unit="rad/s", name="yaw_rate")])
        file.save(tmp_path / "a.mf4")
    log = read_log(tmp_path / "a.mf4")
    assert np.isnan(log["v"]).tolist() == invalid.tolist()
    assert log["v"][~invalid] == pytest.approx(V[~invalid])
    assert log["yaw_rate"] == pytest.approx(0.1 * T)


def test_mdf_of_version_3_is_read(tmp_path: Path) -> None:
    with asammdf.MDF(version="3.30") as file:
        file.append([asammdf.Signal(V, T, unit="m/s", name="v")])
        file.save(tmp_path / "a.mdf")
    assert read_log(tmp_path / "a.mdf")["v"] == pytest.approx(V)


@pytest.mark.parametrize(("kind", "sync"), [(0, 0), (2, 2)])
def test_a_group_without_a_time_is_left_out(tmp_path: Path, kind: int, sync: int) -> None:
    """Without a master channel, or with one of the crank's angle: neither numbers of samples nor angles are seconds."""
    with asammdf.MDF(version="4.10") as file:
        file.append([asammdf.Signal(V, T, unit="m/s", name="v")])
        file.append([asammdf.Signal(V, T, unit="rad/s", name="yaw_rate")])
        master = file.groups[1].channels[0]
        master.channel_type, master.sync_type = kind, sync
        file.save(tmp_path / "a.mf4")
    log = read_log(tmp_path / "a.mf4")
    assert log.t == pytest.approx(T)
    assert "yaw_rate" not in log.columns
    (told,) = log.meta["import"]["findings"]
    assert (told["code"], told["severity"]) == ("log.time_missing", "warning")
    assert "yaw_rate" in str(told)
