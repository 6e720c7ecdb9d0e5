"""A campaign's store: nothing is driven twice, nothing is lost by a kill, and another process cannot write it."""

from __future__ import annotations

import dataclasses
import json
import sqlite3
import subprocess
import sys
from pathlib import Path

import pytest
from lxml import etree

from pytest_dvp.campaigns.campaign import Campaign
from pytest_dvp.campaigns.crew import LocalCrew
from pytest_dvp.campaigns.export import export
from pytest_dvp.campaigns.one_drive import Drive
from pytest_dvp.campaigns.regression_set import FOLDER as REGRESSION
from pytest_dvp.campaigns.reproducer import FOLDER, smallest
from pytest_dvp.campaigns.sampling import sample
from pytest_dvp.campaigns.store import FILE, Row, Store, StoreError
from pytest_dvp.workers.scenario_files import CAMPAIGN

sys.path.insert(0, str(Path(__file__).parent))
import planted


def test_the_same_campaign_again_drives_nothing_and_a_longer_one_the_rest(tmp_path: Path) -> None:
    driven: list[str] = []

    def work(order: Drive) -> Row:
        driven.append(order.key)
        return planted.corner(order)

    for runs, expected in ((10, 10), (10, 10), (16, 16)):
        with Store(tmp_path / "out", writes=True) as store:
            one = planted.campaign(tmp_path, store, work)
            assert len(one.rows(sample("sobol", one.space.axes, runs, 7), "sample")) == runs
        assert len(driven) == len(set(driven)) == expected


def test_a_campaign_that_is_killed_loses_nothing_and_doubles_nothing(tmp_path: Path) -> None:
    codes = []
    for last in (4, 3, 6, 1000):
        words = [sys.executable, planted.__file__, str(tmp_path), "20", str(last)]
        codes.append(subprocess.run(words, check=False).returncode)
    assert codes == [-9, -9, -9, 0]
    driven = (tmp_path / "driven.txt").read_text().split()
    assert len(driven) == len(set(driven)) == 20  # 3, 2 and 5 before the kills, then the other 10
    with Store(tmp_path / "out") as store:
        assert sorted(row.key for row in store.rows()) == sorted(driven)


def test_the_table_has_the_columns_that_others_read(tmp_path: Path) -> None:
    with Store(tmp_path / "out", writes=True) as store:
        planted.campaign(tmp_path, store).rows([(0.95, 0.9)], "sample")
    with sqlite3.connect(tmp_path / "out" / "campaign.sqlite") as file:
        names = [column[1] for column in file.execute("PRAGMA table_info(runs)")]
        assert [column[1] for column in file.execute("PRAGMA table_info(runs)") if column[5]] == ["key"]
        parameters, verdict = file.execute("SELECT parameters, verdict FROM runs").fetchone()
        assert file.execute("PRAGMA journal_mode").fetchone() == ("wal",)
    assert names == ["key", "scenario", "parameters", "seed", "verdict", "margins", "metrics", "vacuous", "cpu",
                     "commit_id", "log"]  # fmt: skip
    assert json.loads(parameters) == {"a": 0.95, "b": 0.9}
    assert verdict == "FAIL"


def test_one_process_writes(tmp_path: Path) -> None:
    with Store(tmp_path / "out", writes=True):
        with pytest.raises(StoreError, match="another process is writing"):
            Store(tmp_path / "out", writes=True)
        with Store(tmp_path / "out") as reading:
            assert reading.rows() == []


@pytest.mark.parametrize("content", [b"", b"no database at all", b"SQLite format 3\0" + b"x" * 200])
def test_a_file_that_is_no_store_is_told_in_one_line(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "campaign.sqlite").write_bytes(content)
    with pytest.raises(StoreError, match=r"cannot be read as a campaign: \w+") as error:
        Store(tmp_path)
    assert "\n" not in str(error.value)


def test_another_gate_file_is_another_campaign(tmp_path: Path) -> None:
    with Store(tmp_path / "out", writes=True) as store:
        before = planted.campaign(tmp_path, store).base
        assert planted.campaign(tmp_path, store).base == before
        (tmp_path / "planted.gates.toml").write_text('[[gate]]\nmetric = "max_jerk"\nmax = 3\n')
        assert planted.campaign(tmp_path, store).base != before


@pytest.mark.parametrize("name", ["sobol", "random"])
def test_more_runs_begin_with_the_same_points(tmp_path: Path, name: str) -> None:
    with Store(tmp_path / "out", writes=True) as store:
        axes = planted.campaign(tmp_path, store).space.axes
    assert sample(name, axes, 40, 3)[:12] == sample(name, axes, 12, 3)
    assert sample(name, axes, 12, 3) != sample(name, axes, 12, 4)


def test_a_grid_has_the_ends_of_each_range(tmp_path: Path) -> None:
    with Store(tmp_path / "out", writes=True) as store:
        points = sample("grid", planted.campaign(tmp_path, store).space.axes, 7, 3)
    assert points == [(a, b) for a in (0.0, 0.5, 1.0) for b in (0.0, 1.0)]


def test_a_drive_that_ends_its_worker_costs_no_other_and_workers_change_nothing(tmp_path: Path) -> None:
    points = [(0.2, 0.3), (0.97, 0.1), (0.4, 0.5), (0.6, 0.1), (0.85, 0.98)]
    found = []
    for count, work in ((2, planted.deadly), (1, planted.corner)):
        with Store(tmp_path / str(count), writes=True) as store, LocalCrew(count, work) as crew:
            one = planted.campaign(tmp_path, store)
            found.append(Campaign(one.space, one.settings, store, crew).rows(points, "sample"))
    assert [row.verdict for row in found[0]] == ["PASS", "ERROR", "PASS", "PASS", "FAIL"]
    assert "died twice" in found[0][1].message
    assert [row for row in found[0] if row.verdict != "ERROR"] == [found[1][k] for k in (0, 2, 3, 4)]


@pytest.mark.parametrize(("column", "value"), [("log", "../x.mcap"), ("key", "../x"), ("margins", "{")])
def test_a_row_that_was_tampered_with_is_told(tmp_path: Path, column: str, value: str) -> None:
    with Store(tmp_path / "out", writes=True) as store:
        planted.campaign(tmp_path, store).rows([(0.5, 0.5)], "sample")
    with sqlite3.connect(tmp_path / "out" / "campaign.sqlite") as file:
        file.execute(f"UPDATE runs SET {column} = ?", (value,))
        if column == "key":
            file.execute("UPDATE judged SET key = ?", (value,))
    with Store(tmp_path / "out") as store, pytest.raises(StoreError, match=r"^campaign.sqlite: row "):
        store.rows()


@pytest.mark.parametrize("first", ["sample", "reproducer"])
def test_a_drive_of_a_sample_is_one_whichever_came_first(tmp_path: Path, first: str) -> None:
    second = {"sample": "reproducer", "reproducer": "sample"}[first]
    with Store(tmp_path / "out", writes=True) as store:
        one = planted.campaign(tmp_path, store, planted.corner)
        for purpose in (first, second):
            one.rows(sample("sobol", one.space.axes, 2, 7), purpose)
        assert [row.purpose for row in store.rows()] == ["sample", "sample"]
    parts = []
    for purpose in (first, second):
        with Store(tmp_path / purpose, writes=True) as store:
            one = planted.campaign(tmp_path, store, planted.corner)
            parts.append(one.rows(sample("sobol", one.space.axes, 2, 7), purpose))
    with Store(tmp_path / "both", writes=True) as store:
        for row in [row for rows in parts for row in rows]:
            store.add(row)
        assert [row.purpose for row in store.rows()] == ["sample", "sample"]


def test_a_drive_that_its_wall_limit_ended_is_driven_again_with_another_one(tmp_path: Path) -> None:
    driven: list[str] = []
    said = "run ERROR: ADS reference: tick did not return before the wall limit of 0.1 s ended the run at t=0.05 s"

    def work(order: Drive) -> Row:
        driven.append(order.key)
        slow = len(driven) == 1
        row = planted.corner(order)
        return dataclasses.replace(row, verdict="ERROR", message=said) if slow else row

    with Store(tmp_path / "out", writes=True) as store:
        one = planted.campaign(tmp_path, store, work)
        points = sample("sobol", one.space.axes, 1, 7)
        one.settings = dataclasses.replace(one.settings, wall_limit=0.1)
        assert [one.rows(points, "sample")[0].verdict for _ in range(2)] == ["ERROR", "ERROR"]
        assert len(driven) == 1  # with the same limit it would end so again
        one.settings = dataclasses.replace(one.settings, wall_limit=600.0)
        assert one.rows(points, "sample")[0].verdict == "PASS"
        assert [row.verdict for row in store.rows()] == ["PASS"]


@pytest.mark.parametrize("out", ["out", "deep/out", "."])
def test_what_a_campaign_writes_beside_its_scenario_does_not_change_its_drives(tmp_path: Path, out: str) -> None:
    """A catalogue beside the scenario decides a drive; a reproducer that the campaign wrote does not."""
    with Store(tmp_path / out, writes=True) as store:
        before = planted.campaign(tmp_path, store).base
        for name in (FOLDER, REGRESSION):
            (tmp_path / out / name).mkdir()
            (tmp_path / out / name / "written.xosc").write_text("<OpenSCENARIO/>")
        assert planted.campaign(tmp_path, store).base == before
        (tmp_path / "catalogs").mkdir()
        (tmp_path / "catalogs" / "cars.xosc").write_text("<OpenSCENARIO/>")
        assert planted.campaign(tmp_path, store).base != before
    assert CAMPAIGN == FILE


def test_junit_counts_the_failures_that_the_summary_counts(tmp_path: Path) -> None:
    """Drives that shrink a failure are in the table, with their purpose, and no tests."""
    with Store(tmp_path / "out", writes=True) as store:
        one = planted.campaign(tmp_path, store)
        smallest(one, one.rows([(0.5, 0.5), (0.99, 0.99)], "sample")[1])
        rows = store.rows()
    assert sum(row.failed for row in rows) > 1  # what shrank it failed as well
    suite = etree.parse(export(rows, "junit", tmp_path)[0]).getroot()
    assert (suite.get("tests"), suite.get("failures"), len(suite)) == ("2", "1", 2)
    (table,) = export(rows, "csv", tmp_path)
    assert len(table.read_text().splitlines()) == 1 + len(rows)
