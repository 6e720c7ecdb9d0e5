"""The search for the critical: it finds several failures far apart, and takes a vacuous drive for nothing."""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest

sys.path[:0] = [str(Path(__file__).parent)]
import planted  # noqa: E402

from pytest_dvp.campaigns.critical_search import apart, search  # noqa: E402
from pytest_dvp.campaigns.hypothesis_search import search_by_hypothesis  # noqa: E402
from pytest_dvp.campaigns.one_drive import Drive  # noqa: E402
from pytest_dvp.campaigns.store import Row, Store  # noqa: E402

CENTRES = ((0.85, 0.2, 0.7), (0.15, 0.75, 0.2))
RADIUS = 0.06  # two balls of it fill 0.18 % of the unit cube


def at(row: Row) -> tuple[float, ...]:
    return tuple(float(row.parameters[name]) for name in "abc")


def two_balls(order: Drive) -> Row:
    point = [float(order.parameters[name]) for name in "abc"]
    return planted.row(order, min(math.dist(point, centre) for centre in CENTRES) - RADIUS)


def found(rows: Sequence[Row]) -> set[int]:
    """Which of the balls a failure was found in."""
    return {k for row in rows if row.failed for k, c in enumerate(CENTRES) if math.dist(at(row), c) < RADIUS}


@pytest.mark.parametrize("name", ["descent", "cross_entropy", "gaussian_process"])
@pytest.mark.nightly(by_day=3)
def test_both_of_two_rare_faults_are_found_in_a_third_of_what_chance_needs_for_one(tmp_path: Path, name: str) -> None:
    # Uniform random drives need ln 2 / 0.0018 = 383 for an even chance of a single failure.
    with Store(tmp_path / "out", writes=True) as store:
        rows = search(planted.campaign(tmp_path, store, two_balls, "abc"), name, 260, 3)
    assert len(rows) == 260
    assert found(rows) == {0, 1}
    assert min(k for k, row in enumerate(rows) if row.failed) < 128


def ball(order: Drive) -> Row:
    point = [float(order.parameters[name]) for name in "abc"]
    return planted.row(order, math.dist(point, CENTRES[0]) - 2.0 * RADIUS)  # 0.7 % of the cube


LEAST, BESIDE = (0.7, 0.3, 0.4), (0.78, 0.36, 0.33)  # where the margin is least, and the failure near it


def beside_the_least(order: Drive) -> Row:
    point = [float(order.parameters[name]) for name in "abc"]
    fails = math.dist(point, BESIDE) < 0.05  # 0.05 % of the cube, without a slope of its own
    return planted.row(order, -1.0 if fails else 0.3 + math.dist(point, LEAST))


@pytest.mark.nightly
def test_a_failure_beside_the_least_margin_is_found_after_the_round_that_ended_there(tmp_path: Path) -> None:
    found = 0
    for seed in (1, 4):
        with Store(tmp_path / str(seed), writes=True) as store:
            rows = search(planted.campaign(tmp_path, store, beside_the_least, "abc"), "gaussian_process", 250, seed)
        found += any(row.failed for row in rows)
    assert found >= 1  # none, where such a place was pushed away from


def test_a_bandit_finds_a_ball_sooner_than_chance(tmp_path: Path) -> None:
    first = []
    for seed in range(20, 29):
        with Store(tmp_path / str(seed), writes=True) as store:
            rows = search(planted.campaign(tmp_path, store, ball, "abc"), "bandit", 150, seed)
        first.append(next((k for k, row in enumerate(rows) if row.failed), 150))
    assert sorted(first)[4] < 96  # ln 2 / 0.0072, the median of chance


def test_hypothesis_asks_for_as_many_points_as_it_may_and_for_the_same_again(tmp_path: Path) -> None:
    ways = []
    for _ in range(2):
        with Store(tmp_path / "out", writes=True) as store:
            ways.append(
                [row.key for row in search_by_hypothesis(planted.campaign(tmp_path, store, ball, "abc"), 60, 3)]
            )
    assert ways[0] == ways[1]
    assert 50 <= len(set(ways[0])) <= 60  # it may ask twice for the same point


def test_a_vacuous_drive_is_no_goal(tmp_path: Path) -> None:
    def work(order: Drive) -> Row:
        a = float(order.parameters["a"])
        return planted.row(order, None, vacuous=True) if a > 0.5 else planted.row(order, 0.6 - a)

    with Store(tmp_path / "out", writes=True) as store:
        rows = search(planted.campaign(tmp_path, store, work), "descent", 80, 3)
    assert sum(row.vacuous for row in rows) < 40  # half of all drives, had it drawn evenly
    assert min(row.objective for row in rows if row.objective is not None) < 0.12  # it went to the edge


def test_the_search_goes_the_same_way_again_and_drives_nothing(tmp_path: Path) -> None:
    driven: list[str] = []

    def work(order: Drive) -> Row:
        driven.append(order.key)
        return two_balls(order)

    ways = []
    for _ in range(2):
        with Store(tmp_path / "out", writes=True) as store:
            rows = search(planted.campaign(tmp_path, store, work, "abc"), "cross_entropy", 60, 3)
            ways.append([row.key for row in rows])
    assert ways[0] == ways[1]
    assert len(driven) == 60


def test_the_distance_of_opposite_corners_is_one() -> None:
    assert apart((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)) == 1.0
    assert apart((0.0, 0.0), (0.6, 0.8)) == pytest.approx(math.sqrt(0.5))
