"""A set of drives that stands for a campaign: what it holds, what it notices, and that it drives."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path[:0] = [str(Path(__file__).parent)]
import planted  # noqa: E402

from pytest_dvp.campaigns.export import export  # noqa: E402
from pytest_dvp.campaigns.one_drive import Drive  # noqa: E402
from pytest_dvp.campaigns.regression_set import regression_set, write_regression_set  # noqa: E402
from pytest_dvp.campaigns.sampling import sample  # noqa: E402
from pytest_dvp.campaigns.store import Row, Store  # noqa: E402


def rows_of(folder: Path, limit: float = 1.8, count: int = 256) -> list[Row]:
    """A campaign that fails where a + b > limit, and by another gate where c < 0.03."""

    def work(order: Drive) -> Row:
        value = {name: float(text) for name, text in order.parameters.items()}
        if value["c"] < 0.03:
            return planted.row(order, value["c"] - 0.03, "other >= 0")
        return planted.row(order, limit - value["a"] - value["b"])

    with Store(folder / "out", writes=True) as store:
        one = planted.campaign(folder, store, work, "abc")
        return one.rows(sample("sobol", one.space.axes, count, 7), "sample")


def test_it_holds_a_failure_of_each_kind_and_passes_near_the_boundary(tmp_path: Path) -> None:
    rows = rows_of(tmp_path)
    chosen = regression_set(rows, 20)
    assert len({row.key for row in chosen}) == 20
    assert {row.gate for row in chosen if row.failed} == {"gap >= 0", "other >= 0"}
    assert sum(row.failed for row in chosen) == 2
    near = [row.objective for row in chosen[2:15]]
    others = [row.objective for row in rows if row.verdict == "PASS"]
    assert np.median(near) < np.quantile(others, 0.15)  # type: ignore[type-var]
    assert chosen == regression_set(list(reversed(rows)), 20)
    assert regression_set(rows[:7], 20) == sorted(rows[:7], key=lambda row: row.key)


def test_it_notices_a_stack_that_became_a_little_worse_where_as_many_draws_do_not(tmp_path: Path) -> None:
    """The boundary moves from 1.8 to 1.77: 0.6 % of all variants fail more. One set of 20 draws in eight has one."""
    before, after = rows_of(tmp_path / "before"), rows_of(tmp_path / "after", 1.77)
    now = {tuple(row.parameters.items()): row.failed for row in after}

    def noticed(rows: list[Row]) -> bool:
        return any(not row.failed and now[tuple(row.parameters.items())] for row in rows)

    assert noticed(regression_set(before, 20))
    rng = np.random.default_rng(5)
    by_chance = [noticed([before[k] for k in rng.choice(len(before), 20, replace=False)]) for _ in range(50)]
    assert np.mean(by_chance) < 0.4


def test_it_is_a_distribution_with_these_cases(tmp_path: Path) -> None:
    from openscenario.read import read_cases

    chosen = regression_set(rows_of(tmp_path), 12)
    file = write_regression_set(chosen, tmp_path / "set", "planted")
    cases = read_cases(file, rootdir=tmp_path)
    assert cases.count == 12
    assert [dict(cases[k]) for k in range(12)] == [row.parameters for row in chosen]
    assert cases.scenario is not None
    assert cases.scenario.samefile(chosen[0].scenario)
    first = file.read_bytes()
    assert write_regression_set(chosen, tmp_path / "set", "planted").read_bytes() == first


@pytest.mark.parametrize("count", [1, 2, 5])
def test_a_small_set_is_as_small_as_was_asked(tmp_path: Path, count: int) -> None:
    assert len(regression_set(rows_of(tmp_path, count=64), count)) == count


def test_scenarios_of_one_name_have_a_set_each(tmp_path: Path) -> None:
    rows = [row for folder in ("north", "south") for row in rows_of(tmp_path / folder, count=2)]
    files = export(rows, "regression", tmp_path)
    assert [file.name for file in files] == ["north--planted-regression.xosc", "south--planted-regression.xosc"]
    for folder, file in zip(("north", "south"), files, strict=True):
        assert f"{folder}/planted.xosc" in file.read_text()
