"""What a campaign shows: minimal reproducers, the influence of parameters, the page, and what became worse."""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

sys.path[:0] = [str(Path(__file__).parent)]
import planted  # noqa: E402

from pytest_dvp.campaigns.baseline import compared  # noqa: E402
from pytest_dvp.campaigns.campaign import Campaign  # noqa: E402
from pytest_dvp.campaigns.crew import LocalCrew  # noqa: E402
from pytest_dvp.campaigns.criticality import box_gap  # noqa: E402
from pytest_dvp.campaigns.map_page import map_page  # noqa: E402
from pytest_dvp.campaigns.one_drive import Drive  # noqa: E402
from pytest_dvp.campaigns.parameter_influence import influence  # noqa: E402
from pytest_dvp.campaigns.parameter_space import Axis, space_of  # noqa: E402
from pytest_dvp.campaigns.reproducer import changed_values, reproducers, smallest  # noqa: E402
from pytest_dvp.campaigns.sampling import sample  # noqa: E402
from pytest_dvp.campaigns.store import EXCLUDED, Row, Store  # noqa: E402
from pytest_dvp.drive.run_spec import RunSpec  # noqa: E402
from reports.campaign import render_campaign_page  # noqa: E402
from scenarios import path as shipped  # noqa: E402


def two_needed(order: Drive) -> Row:
    """Fails where a > 0.7 and b > 0.8, whatever c is; another gate fails where c < 0.05."""
    value = {name: float(text) for name, text in order.parameters.items()}
    if value["c"] < 0.05:
        return planted.row(order, value["c"] - 0.05, "other >= 0")
    return planted.row(order, max(0.7 - value["a"], 0.8 - value["b"]))


def test_a_reproducer_holds_what_is_needed_and_nothing_else(tmp_path: Path) -> None:
    with Store(tmp_path / "out", writes=True) as store:
        one = planted.campaign(tmp_path, store, two_needed, "abc")
        row = smallest(one, one.rows([(0.97, 0.99, 0.3)], "sample")[0])
        changed = changed_values(one, row)
        assert changed.keys() == {"a", "b"}
        assert 0.7 < float(changed["a"]) < 0.72  # moved back as far as it still fails, to 3 % of the way
        assert 0.8 < float(changed["b"]) < 0.82
        for name in changed:
            assert not one.rows_of([{**row.parameters, name: "0.5"}], "reproducer")[0].failed


def test_each_kind_of_failure_has_a_reproducer_of_its_own_kind(tmp_path: Path) -> None:
    with Store(tmp_path / "out", writes=True) as store:
        one = planted.campaign(tmp_path, store, two_needed, "abc")
        rows = one.rows([(0.9, 0.9, 0.5), (0.95, 0.9, 0.5), (0.4, 0.4, 0.01)], "sample")
        found = reproducers_without_files(one, rows)
    assert {cluster: sorted(changed) for cluster, changed in found.items()} == {
        "gap >= 0": ["a", "b"],
        "other >= 0": ["c"],
    }


def test_the_replay_of_a_stack_that_ended_its_worker_keeps_it_in_a_process_of_its_own(tmp_path: Path) -> None:
    """In a worker the stack runs inside it; a replay that did so would end without a word."""
    settings = RunSpec(stack_process="off")
    with Store(tmp_path / "out", writes=True) as store:
        crew = LocalCrew(1, lambda order: planted.row(order, -1.0))
        one = Campaign(space_of(shipped("follow.xosc"), settings), settings, store, crew)
        (found,) = reproducers(one, one.rows([(0.5,) * 5], "sample"), "follow")
    assert found.command.startswith("dvp run ")
    assert "--stack-process" not in found.command


def reproducers_without_files(one: object, rows: list[Row]) -> dict[str, Mapping[str, str]]:
    """The planted scenario drives nothing, so that it cannot be written as one that does."""
    from pytest_dvp.campaigns import reproducer

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(reproducer, "_write", lambda campaign, values, target: "dvp run it")
        return {each.cluster: each.changed for each in reproducers(one, rows, "planted")}  # type: ignore[arg-type]


def test_the_influence_of_a_linear_objective_is_known(tmp_path: Path) -> None:
    # 3a + 4b with a, b even: shares of the variance 9/25 and 16/25, c nothing.
    def work(order: Drive) -> Row:
        value = {name: float(text) for name, text in order.parameters.items()}
        return planted.row(order, 10.0 + 3.0 * value["a"] + 4.0 * value["b"])

    with Store(tmp_path / "out", writes=True) as store:
        one = planted.campaign(tmp_path, store, work, "abc")
        rows = one.rows(sample("sobol", one.space.axes, 256, 7), "sample")
        told = influence(one.space, rows)
        assert told is not None
        assert told.dependent == ""
        assert list(told.shares) == ["the tightest gate", "gap >= 0"]
        for shares in told.shares.values():
            assert [shares[name][0] for name in "abc"] == pytest.approx([0.36, 0.64, 0.0], abs=0.06)
            assert all(0.002 < shares[name][1] < 0.06 for name in "abc")  # c, too: that it does nothing is not sure
        assert influence(one.space, rows[:20]) is None
        searched = [dataclasses.replace(row, purpose="search") for row in rows]
        assert influence(one.space, searched) is None  # a search lies where it looked


@pytest.mark.nightly
def test_where_draws_are_excluded_the_influence_is_shared_by_what_depends_on_each_other(tmp_path: Path) -> None:
    """The result is a, and b must be below a: b says where a is, so that a part falls to it, and none to c."""

    def work(order: Drive) -> Row:
        value = {name: float(text) for name, text in order.parameters.items()}
        row = planted.row(order, value["a"] if value["b"] < value["a"] else None)
        return row if value["b"] < value["a"] else dataclasses.replace(row, verdict=EXCLUDED, message="b is < a")

    with Store(tmp_path / "out", writes=True) as store:
        one = planted.campaign(tmp_path, store, work, "abc")
        rows = one.rows(sample("sobol", one.space.axes, 512, 7), "sample")
        told = influence(one.space, rows)
        page = render_campaign_page([map_page(one, rows, [], None)])
        assert influence(one.space, rows[:120]) is None  # 60 or so are left: too few to compare
    assert told is not None
    excluded = sum(row.verdict == EXCLUDED for row in rows)
    assert told.dependent == f"{excluded} of 512 draws are outside the scenario's constraints: b is < a"
    # b explains Var(E[a|b]) of Var(a): a | b even over b to 1, its mean (1 + b)/2; half of that share falls to b.
    alone = (1.0 / 18.0 / 4.0) / (1.0 / 18.0)
    shares = {name: share for name, (share, _) in told.shares["the tightest gate"].items()}
    assert [shares[name] for name in "abc"] == pytest.approx([1.0 - alone / 2.0, alone / 2.0, 0.0], abs=0.06)
    assert f"{excluded} of 512 draws are outside" in page
    assert "Shapley effects" in page


def test_the_page_shades_where_a_failure_is_likely_and_says_how_sure_that_is(tmp_path: Path) -> None:
    """Fails where a > 0.7 for any b: three tenths of the only plot, none of it on the left."""

    def work(order: Drive) -> Row:
        return planted.row(order, 0.7 - float(order.parameters["a"]))

    with Store(tmp_path / "out", writes=True) as store:
        one = planted.campaign(tmp_path, store, work)
        rows = one.rows(sample("sobol", one.space.axes, 64, 7), "sample")
        plain = map_page(one, rows, [], None)
        page = render_campaign_page([plain])
        assert map_page(one, rows[:10], [], None)["boundary"] is None
    assert [axis["name"] for axis in plain["axes"]] == ["a", "b"]
    (cells,) = plain["boundary"]["slices"]
    assert np.mean(cells, axis=0) == pytest.approx([0.0] * 13 + [0.05] + [1.0] * 6, abs=0.5)
    assert np.mean(cells) == pytest.approx(0.3, abs=0.03)
    assert plain["boundary"]["right"] > 0.95
    assert page.count('fill-opacity="0.35"') > 100
    assert f"{100 * plain['boundary']['right']:.0f} % were put on the right side" in page


def test_a_list_is_shaded_at_its_values_and_not_at_their_numbers(tmp_path: Path) -> None:
    """Values 1, 2 and 10, of which 10 fails: the plot goes from 1 to 10, and beyond 6 it is nearer to 10 than to 2."""
    listed = Axis("a", lambda share: {"a": ("1", "2", "10")[min(int(share * 3), 2)]}, {"a": "1"}, 3)

    def work(order: Drive) -> Row:
        return planted.row(order, 5.0 - float(order.parameters["a"]))

    with Store(tmp_path / "out", writes=True) as store:
        one = planted.campaign(tmp_path, store, work)
        one.space = dataclasses.replace(one.space, axes=(listed, one.space.axes[1]))
        rows = one.rows(sample("sobol", one.space.axes, 64, 7), "sample")
        page = map_page(one, rows, [], None)
    (cells,) = page["boundary"]["slices"]
    assert [axis["name"] for axis in page["axes"]] == ["a", "b"]
    assert [share > 0.5 for share in np.mean(cells, axis=0)] == [False] * 11 + [True] * 9  # 6 lies in the eleventh step


def test_the_page_escapes_what_a_file_says_and_loads_nothing(tmp_path: Path) -> None:
    def work(order: Drive) -> Row:
        return dataclasses.replace(planted.corner(order), message="<script>alert(1)</script>")

    with Store(tmp_path / "out", writes=True) as store:
        one = planted.campaign(tmp_path, store, work)
        rows = one.rows([(0.99, 0.99), (0.2, 0.2)], "sample")
        page = render_campaign_page([map_page(one, rows, [], None)])
    assert "<script" not in page
    assert "&lt;script&gt;alert(1)" in page
    assert "http" not in page.replace("http-equiv", "")
    assert page.count("<circle") == 2


def test_the_page_says_what_its_points_are_and_what_it_does_not_draw(tmp_path: Path) -> None:
    """Seven parameters are 21 pairs, of which 15 are drawn; a drive that decided nothing is a circle."""

    def work(order: Drive) -> Row:
        return planted.row(order, None if float(order.parameters["a"]) > 0.9 else 1.0)

    with Store(tmp_path / "out", writes=True) as store:
        one = planted.campaign(tmp_path, store, work, "abcdefg")
        page = render_campaign_page([map_page(one, one.rows([(0.99,) * 7, (0.2,) * 7], "sample"), [], None)])
        few = planted.campaign(tmp_path / "few", store, work, "ab")
        other = render_campaign_page([map_page(few, few.rows([(0.2, 0.2), (0.3, 0.3)], "sample"), [], None)])
    assert "15 of 21 pairs of parameters are drawn" in page
    assert "decided nothing</p>" in page
    assert "are drawn" not in other
    assert "decided nothing" not in other


def test_what_passed_before_and_fails_now_is_told(tmp_path: Path) -> None:
    def worse(order: Drive) -> Row:
        return planted.row(order, 1.6 - float(order.parameters["a"]) - float(order.parameters["b"]))

    points = [(0.9, 0.8), (0.95, 0.95), *[(0.3, k / 40) for k in range(20)]]
    with Store(tmp_path / "old", writes=True) as old, Store(tmp_path / "new", writes=True) as new:
        before = planted.campaign(tmp_path, old).rows(points, "sample")
        now = planted.campaign(tmp_path, new, worse).rows(points, "sample")
    found = compared(before, now)
    assert (found.pairs, len(found.worse), found.better) == (22, 1, ())
    assert found.worse[0].parameters == {"a": "0.9", "b": "0.8"}
    assert [(each.gate, round(each.change, 9), each.pairs) for each in found.shrunk] == [("gap >= 0", -0.2, 22)]
    assert compared(before, before).shrunk == ()


def test_the_gap_between_boxes_is_that_of_geometry() -> None:
    # x, y, yaw, length, width, vx, vy: 4 x 2 m at the origin; others 3 m ahead, beside, turned by 45 degrees, over it
    ego = np.tile([0.0, 0.0, 0.0, 4.0, 2.0, 0.0, 0.0], (4, 1))
    other = np.array([
        [7.0, 0.0, 0.0, 4.0, 2.0, 0.0, 0.0],
        [0.0, 2.5, 0.0, 4.0, 2.0, 0.0, 0.0],
        [5.0, 0.0, np.pi / 4, 2.0, 2.0, 0.0, 0.0],
        [1.0, 0.5, 0.0, 4.0, 2.0, 0.0, 0.0],
    ])  # fmt: skip
    assert box_gap(ego, other) == pytest.approx([3.0, 0.5, 3.0 - np.sqrt(2.0), 0.0])
