"""What of a space was tried, on drives whose places are known."""

from __future__ import annotations

import dataclasses
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path[:0] = [str(Path(__file__).parent)]
import planted  # noqa: E402

from pytest_dvp.campaigns.campaign import Campaign  # noqa: E402
from pytest_dvp.campaigns.crew import LocalCrew  # noqa: E402
from pytest_dvp.campaigns.parameter_space import Axis, space_of  # noqa: E402
from pytest_dvp.campaigns.sampling import sample  # noqa: E402
from pytest_dvp.campaigns.space_coverage import Coverage, _listed, coverage  # noqa: E402
from pytest_dvp.campaigns.store import EXCLUDED, Store  # noqa: E402
from pytest_dvp.drive.run_spec import RunSpec  # noqa: E402


def of(folder: Path, points: list[tuple[float, ...]], outside: int = 0) -> Coverage | None:
    """The coverage of drives at these shares of a, b, c, of which the last `outside` are excluded."""
    with Store(folder / "out", writes=True) as store:
        one = planted.campaign(folder, store, planted.corner, "abc"[: len(points[0])])
        rows = one.rows(points, "sample")
        cut = len(rows) - outside
        return coverage(one.space, [*rows[:cut], *(dataclasses.replace(r, verdict=EXCLUDED) for r in rows[cut:])])


def test_a_diagonal_has_all_values_and_a_tenth_of_the_pairs(tmp_path: Path) -> None:
    told = of(tmp_path, [((k + 0.5) / 10.0,) * 3 for k in range(10)])
    assert told is not None
    assert told.drives == 10
    assert told.tried == pytest.approx((1.0, 0.1, 0.01))


def test_the_largest_gap_lies_in_the_empty_half(tmp_path: Path) -> None:
    """Nothing beyond a = 0.4: the emptiest place is the far end, 0.6 or a little more from the next drive."""
    rng = np.random.default_rng(3)
    told = of(tmp_path, [(0.4 * float(a), float(b)) for a, b in rng.random((200, 2))])
    assert told is not None
    assert 0.59 < told.gaps[0].radius < 0.65
    assert float(told.gaps[0].values["a"]) > 0.95
    assert [gap.radius for gap in told.gaps] == sorted((gap.radius for gap in told.gaps), reverse=True)
    assert told.unevenness is not None
    assert told.unevenness > 5.0


@pytest.mark.nightly
def test_even_points_are_more_even_than_independent_ones(tmp_path: Path) -> None:
    space = [None] * 2
    even = of(tmp_path / "a", sample("sobol", space, 256, 7))  # type: ignore[arg-type]
    draws = [of(tmp_path / f"{k}", sample("random", space, 256, k)) for k in range(12)]  # type: ignore[arg-type]
    assert even is not None
    assert even.unevenness is not None
    assert even.unevenness < 0.2
    assert np.mean([each.unevenness for each in draws if each and each.unevenness]) == pytest.approx(1.0, abs=0.35)


def test_what_only_excluded_draws_met_is_not_missing(tmp_path: Path) -> None:
    """Of 100 cells those on and below the diagonal are driven, the 45 above it are excluded."""
    middles = [(k + 0.5) / 10.0 for k in range(10)]
    inside = [(a, b) for a in middles for b in middles if b <= a]
    outside = [(a, b) for a in middles for b in middles if b > a]
    told = of(tmp_path, [*inside, *outside], outside=len(outside))
    assert told is not None
    assert told.drives == 55
    assert told.tried == (1.0, 1.0)
    assert told.unevenness is None


def test_of_a_few_drives_nothing_is_said(tmp_path: Path) -> None:
    assert of(tmp_path, [(0.1, 0.1)] * 3) is None


def test_a_grid_with_eleven_values_of_each_range_has_all_parts(tmp_path: Path) -> None:
    """0, 0.1, ... 1.0 lie on the edges of the ten parts, one in each of them, and the last two in the last."""
    told = of(tmp_path, [(a / 10.0, b / 10.0) for a in range(11) for b in range(11)])
    assert told is not None
    assert told.tried == (1.0, 1.0)


def drawn_whole(folder: Path, points: list[tuple[float, ...]]) -> Coverage | None:
    """The coverage of drives at these shares of k, a whole number evenly of 1 to 4, and of a."""
    folder.mkdir(exist_ok=True)
    whole = '<ParameterDeclaration name="k" parameterType="integer" value="2"/>'
    (folder / "planted.xosc").write_text(planted.XOSC.format(whole + planted.PARAMETER.format("a")))
    (folder / "drawn.xosc").write_text(
        '<OpenSCENARIO><FileHeader revMajor="1" revMinor="2" date="2026-01-01T00:00:00" description="" author=""/>'
        '<ParameterValueDistribution><ScenarioFile filepath="planted.xosc"/><Stochastic numberOfTestRuns="10">'
        + "".join(
            f'<StochasticDistribution parameterName="{name}"><UniformDistribution><Range lowerLimit="{low}" '
            f'upperLimit="{high}"/></UniformDistribution></StochasticDistribution>'
            for name, low, high in (("k", 0.5, 4.49), ("a", 0, 1))
        )
        + "</Stochastic></ParameterValueDistribution></OpenSCENARIO>"
    )
    one = space_of(folder / "drawn.xosc", RunSpec())
    with Store(folder / "out", writes=True) as store:
        many = Campaign(one, RunSpec(), store, LocalCrew(1, lambda order: planted.row(order, 1.0)))
        return coverage(one, many.rows(points, "sample"))


def test_whole_numbers_of_a_distribution_are_all_tried_if_each_was_driven(tmp_path: Path) -> None:
    """Four values, each with ten of `a`: nothing is missing, and a drive that has a value is at no distance from it."""
    told = drawn_whole(tmp_path, [((k + 0.5) / 4, (a + 0.5) / 10) for k in range(4) for a in range(10)])
    assert told is not None
    assert told.tried == (1.0, 1.0)
    assert told.unevenness is None
    assert told.gaps[0].radius == pytest.approx(0.05, abs=0.005)  # half the way between two of `a`
    less = drawn_whole(tmp_path / "less", [((k + 0.5) / 4, (a + 0.5) / 10) for k in range(2) for a in range(10)])
    assert less is not None
    assert less.tried == pytest.approx(((2 + 10) / (4 + 10), 0.5))
    assert less.gaps[0].values["k"] == "4"


def test_a_long_list_is_tried_where_its_drives_lie() -> None:
    """Of 10,000 whole numbers only the first 20 were driven: one part of ten."""
    axis = Axis("a", lambda share: {"a": str(min(int(share * 10_000), 9_999))}, {"a": "0"}, 10_000)
    places = _listed(axis)
    assert places is not None
    assert {int(10 * place) for place in places} == set(range(10))
