"""The boundary of failure on planted shapes: where it is known, what finds it sooner, and what is not told."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

sys.path[:0] = [str(Path(__file__).parent)]
import planted  # noqa: E402

from pytest_dvp.campaigns.failure_boundary import Boundary, boundary_of, refine_boundary  # noqa: E402
from pytest_dvp.campaigns.one_drive import Drive  # noqa: E402
from pytest_dvp.campaigns.sampling import sample  # noqa: E402
from pytest_dvp.campaigns.store import Row, Store  # noqa: E402

Shape = Callable[[np.ndarray, np.ndarray], np.ndarray]


def disc(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Fails within 0.25 of (0.6, 0.4): 20 % of the square."""
    return np.hypot(a - 0.6, b - 0.4) - 0.25


def two_corners(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Fails near two corners, with a slope that bends."""
    return np.minimum(np.hypot(a - 1.0, b - 1.0) - 0.4, np.hypot(a, b - 1.0) - 0.3)


def cliff(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """A margin that jumps from 0.5 to -0.5 on a slanting line: nothing on the way tells that it comes."""
    return np.where(a + 0.5 * b > 0.9, -0.5, 0.5)


def wrong_share(folder: Path, shape: Shape, refined: bool, count: int = 60) -> float:
    """Share of the square that is put on the wrong side after so many drives."""

    def work(order: Drive) -> Row:
        a, b = (np.float64(order.parameters[name]) for name in "ab")
        return planted.row(order, float(shape(a, b)))

    with Store(folder / "out", writes=True) as store:
        one = planted.campaign(folder, store, work)
        rows = refine_boundary(one, count, 7) if refined else one.rows(sample("sobol", one.space.axes, count, 7), "s")
        assert len({row.key for row in rows}) == count
        found = boundary_of(one.space, rows)
    assert found is not None
    assert found.tells
    a, b = (each.ravel() for each in np.meshgrid(np.linspace(0.005, 0.995, 100), np.linspace(0.005, 0.995, 100)))
    return float(((found.fails(np.array([a, b]).T) > 0.5) != (shape(a, b) < 0.0)).mean())


@pytest.mark.parametrize("shape", [disc, two_corners, cliff])
@pytest.mark.nightly
def test_refined_drives_tell_the_boundary_better_than_as_many_even_ones(tmp_path: Path, shape: Shape) -> None:
    refined = wrong_share(tmp_path / "refined", shape, True)
    even = wrong_share(tmp_path / "even", shape, False)
    assert refined < 0.02
    assert refined < 0.75 * even


def test_how_often_the_guess_is_right_is_told_from_drives_that_were_left_out(tmp_path: Path) -> None:
    """Verdicts that follow nothing cannot be guessed, and that is said."""

    def noise(order: Drive) -> Row:
        return planted.row(order, 0.5 if hash_of(order.parameters) % 2 else -0.5)

    with Store(tmp_path / "out", writes=True) as store:
        one = planted.campaign(tmp_path, store, noise)
        found = boundary_of(one.space, one.rows(sample("random", one.space.axes, 120, 3), "sample"))
    assert found is not None
    assert 0.3 < found.right < 0.7
    assert not found.tells


@pytest.mark.parametrize(("right", "tells"), [(0.86, True), (0.84, False)])
def test_a_guess_that_is_wrong_half_as_often_as_none_is_shown(right: float, tells: bool) -> None:
    assert Boundary(np.zeros((1, 1)), np.zeros(1), 0.1, right, 0.3).tells == tells


def hash_of(parameters: dict[str, str]) -> int:
    return sum(ord(letter) * 31**k for k, letter in enumerate("".join(parameters.values())))


def test_without_failures_or_with_few_drives_there_is_no_boundary(tmp_path: Path) -> None:
    with Store(tmp_path / "out", writes=True) as store:
        one = planted.campaign(tmp_path, store, lambda order: planted.row(order, 0.5))
        rows = one.rows(sample("sobol", one.space.axes, 60, 7), "sample")
        assert boundary_of(one.space, rows) is None
    with Store(tmp_path / "few", writes=True) as store:
        one = planted.campaign(tmp_path / "few", store)
        assert boundary_of(one.space, one.rows(sample("sobol", one.space.axes, 19, 7), "sample")) is None


def test_the_same_again_drives_nothing_new(tmp_path: Path) -> None:
    with Store(tmp_path / "out", writes=True) as store:
        one = planted.campaign(tmp_path, store)
        keys = [row.key for row in refine_boundary(one, 30, 7)]
        driven = one.progress.driven
        assert [row.key for row in refine_boundary(one, 30, 7)] == keys
        assert one.progress.driven == driven
