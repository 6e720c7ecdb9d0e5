"""The space of a campaign: shares of the probability become values of ranges, distributions and lists."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path[:0] = [str(Path(__file__).parent)]
import planted  # noqa: E402

from pytest_dvp.campaigns.cases import excluded_by  # noqa: E402
from pytest_dvp.campaigns.constraint_range import FuzzError  # noqa: E402
from pytest_dvp.campaigns.parameter_space import Space, space_of  # noqa: E402
from pytest_dvp.campaigns.sampling import sample  # noqa: E402
from pytest_dvp.drive.assignments import Assignments  # noqa: E402
from pytest_dvp.drive.run_spec import RunSpec  # noqa: E402
from scenarios import path as shipped  # noqa: E402

FILE = (
    '<OpenSCENARIO><FileHeader revMajor="1" revMinor="2" date="2026-01-01T00:00:00" description="" author=""/>'
    '<ParameterValueDistribution><ScenarioFile filepath="planted.xosc"/>{}</ParameterValueDistribution></OpenSCENARIO>'
)
NORMAL = (
    '<Stochastic numberOfTestRuns="10"><StochasticDistribution parameterName="a">'
    '<NormalDistribution expectedValue="0.4" variance="0.01"/></StochasticDistribution></Stochastic>'
)
LISTED = (
    '<Deterministic><DeterministicSingleParameterDistribution parameterName="a"><DistributionSet>'
    '<Element value="0.1"/><Element value="0.5"/><Element value="0.9"/></DistributionSet>'
    "</DeterministicSingleParameterDistribution></Deterministic>"
)


def space(folder: Path, distribution: str) -> Space:
    planted.scenario(folder)
    file = folder / "varied.xosc"
    file.write_text(FILE.format(distribution))
    return space_of(file, RunSpec())


def test_a_range_is_even_and_its_nominal_value_is_found() -> None:
    found = space_of(shipped("overtaking.xosc"), RunSpec())
    middle = found.values((0.5,) * 5)
    assert float(middle["ego_speed"]) == 4.5  # 3 to 6 m/s
    assert found.values(found.nominal_shares) == {
        "ego_speed": "5.5", "target_position": "60", "target_lateral_offset": "0", "trigger_distance": "45",
        "oncoming_speed": "5",
    }  # fmt: skip
    assert found.nominal == found.values(found.nominal_shares)  # spelled alike: one drive, not two


def test_a_normal_distribution_has_its_quantiles(tmp_path: Path) -> None:
    found = space(tmp_path, NORMAL)
    values = [float(found.values((share,))["a"]) for share in (0.5, 0.8413447, 0.0227501)]
    assert values == pytest.approx([0.4, 0.5, 0.2], abs=1e-5)  # the mean, one above, two below


def test_a_grid_of_a_distribution_without_ends_has_the_middles_of_equal_parts(tmp_path: Path) -> None:
    """Its ends would lie eight standard deviations away, where nothing ever lies. Quartiles of N(0.4, 0.1)."""
    found = space(tmp_path, NORMAL)
    values = [float(found.values(shares)["a"]) for shares in sample("grid", found.axes, 2, 0)]
    assert values == pytest.approx([0.4 - 0.0674490, 0.4 + 0.0674490], abs=1e-5)
    bounded = NORMAL.replace(
        'variance="0.01"/>', 'variance="0.01"><Range lowerLimit="0.1" upperLimit="0.6"/></NormalDistribution>'
    )
    found = space(tmp_path, bounded)
    assert [found.values(shares)["a"] for shares in sample("grid", found.axes, 2, 0)] == ["0.1", "0.6"]


def test_a_list_has_each_value_equally_often(tmp_path: Path) -> None:
    found = space(tmp_path, LISTED)
    assert [found.values((share,))["a"] for share in (0.0, 0.3, 0.4, 0.7, 1.0)] == ["0.1", "0.1", "0.5", "0.9", "0.9"]
    assert found.nominal_shares == (0.5,)


def test_a_scenario_without_ranges_cannot_be_varied(tmp_path: Path) -> None:
    with pytest.raises(FuzzError, match="there is nothing to vary"):
        space_of(planted.scenario(tmp_path, ""), RunSpec())


WEIGHTED = (
    '<Stochastic numberOfTestRuns="10"><StochasticDistribution parameterName="a"><ProbabilityDistributionSet>'
    '<Element value="0.1" weight="18"/><Element value="0.3" weight="0"/><Element value="0.5" weight="1"/>'
    '<Element value="0.9" weight="1"/></ProbabilityDistributionSet></StochasticDistribution></Stochastic>'
)


def test_rare_values_of_a_list_have_places_of_their_own(tmp_path: Path) -> None:
    """18, 1 and 1 of 20; a value that is never drawn has no place."""
    (axis,) = (found := space(tmp_path, WEIGHTED)).axes
    assert axis.count == 3
    places = [axis.share_of({"a": value}) for value in ("0.1", "0.5", "0.9")]
    assert places == pytest.approx([0.45, 0.925, 0.975])
    assert [axis.even_share_of({"a": value}) for value in ("0.1", "0.5", "0.9")] == pytest.approx([1 / 6, 0.5, 5 / 6])
    assert [found.values((share,))["a"] for share in places] == ["0.1", "0.5", "0.9"]
    assert [found.values(point)["a"] for point in sample("grid", found.axes, 3, 7)] == ["0.1", "0.5", "0.9"]


def bounded(folder: Path, kind: str, nominal: str, *groups: tuple[str, str]) -> Path:
    """A scenario with one parameter `a` of a type, in groups from a least to a greatest value."""
    inside = "".join(
        f'<ConstraintGroup><ValueConstraint rule="greaterOrEqual" value="{low}"/>'
        f'<ValueConstraint rule="lessOrEqual" value="{high}"/></ConstraintGroup>'
        for low, high in groups
    )
    path = folder / "bounded.xosc"
    path.write_text(
        planted.XOSC.format(f'<ParameterDeclaration name="a" parameterType="{kind}" value="{nominal}">{inside}'
                            "</ParameterDeclaration>")
    )  # fmt: skip
    return path


def test_the_ends_of_a_range_are_inside_its_constraints(tmp_path: Path) -> None:
    """30 and 50 km/h in m/s: 13.8889 and 8.33333 would lie outside."""
    path = bounded(tmp_path, "double", "10", ("8.333333334", "13.888888889"))
    found = space_of(path, RunSpec())
    values = [found.values(shares) for shares in sample("grid", found.axes, 5, 1)]
    assert [float(each["a"]) for each in values][:: len(values) - 1] == [8.333333334, 13.888888889]
    assert not any(excluded_by(path, each) for each in values)
    (tmp_path / "one").mkdir()
    path = bounded(tmp_path / "one", "double", "13.88888888", ("13.88888888", "13.88888888"))
    assert not excluded_by(path, space_of(path, RunSpec()).values((0.5,)))


@pytest.mark.parametrize(("low", "high"), [("123456", "123457"), ("48.262501", "48.262523"), ("-5000.2", "-5000.1")])
def test_a_narrow_range_far_from_zero_has_many_values(tmp_path: Path, low: str, high: str) -> None:
    """Shares of 0 to 1 in steps of 1/1000 are 1001 places that lie evenly."""
    uniform = (
        '<Stochastic numberOfTestRuns="10"><StochasticDistribution parameterName="a"><UniformDistribution>'
        f'<Range lowerLimit="{low}" upperLimit="{high}"/></UniformDistribution></StochasticDistribution></Stochastic>'
    )
    for found in (space_of(bounded(tmp_path, "double", low, (low, high)), RunSpec()), space(tmp_path, uniform)):
        values = [float(found.values((k / 1000,))["a"]) for k in range(1001)]
        width = float(high) - float(low)
        assert values == pytest.approx([float(low) + k / 1000 * width for k in range(1001)], abs=1e-4 * width)
        assert float(low) <= min(values) <= max(values) <= float(high)


@pytest.mark.parametrize("kind", ["integer", "double"])
def test_values_that_two_groups_allow_are_drawn_no_more_often(tmp_path: Path, kind: str) -> None:
    """1 to 3 and 2 to 4 are 1 to 4."""
    found = space_of(bounded(tmp_path, kind, "2", ("2", "4"), ("1", "3")), RunSpec())
    (axis,) = found.axes
    assert axis.count == (4 if kind == "integer" else None)
    drawn = [float(axis.at((k + 0.5) / 1200)["a"]) for k in range(1200)]
    if kind == "integer":
        assert [drawn.count(value) for value in (1, 2, 3, 4)] == [300] * 4
    else:
        assert [sum(low <= value < low + 1 for value in drawn) for low in (1, 2, 3)] == [400] * 3


def test_a_set_of_values_leaves_what_it_does_not_name_as_declared(tmp_path: Path) -> None:
    planted.scenario(tmp_path)
    rows = (("a", 0.1), ("b", 0.2)), (("a", 0.3),), (("b", 0.4),)
    sets = "".join(
        "<ParameterValueSet>"
        + "".join(f'<ParameterAssignment parameterRef="{name}" value="{value}"/>' for name, value in row)
        + "</ParameterValueSet>"
        for row in rows
    )
    found = space(
        tmp_path,
        "<Deterministic><DeterministicMultiParameterDistribution><ValueSetDistribution>"
        f"{sets}</ValueSetDistribution></DeterministicMultiParameterDistribution></Deterministic>",
    )
    values = [found.values(shares) for shares in sample("grid", found.axes, 3, 1)]
    assert values == [{"a": "0.1", "b": "0.2"}, {"a": "0.3", "b": "0.5"}, {"a": "0.5", "b": "0.4"}]
    assert [found.axes[0].number_of(each) for each in values] == [0, 1, 2]


def compared(folder: Path) -> Path:
    """a of 10 to 20, nominally 15; b of 0 to a; c of b - 1 to b."""
    rules = (
        ("a", "15", (("greaterOrEqual", "10"), ("lessOrEqual", "20"))),
        ("b", "5", (("greaterOrEqual", "0"), ("lessOrEqual", "$a"))),
        ("c", "4.5", (("greaterOrEqual", "${$b - 1}"), ("lessOrEqual", "$b"))),
    )
    path = folder / "compared.xosc"
    path.write_text(
        planted.XOSC.format(
            "".join(
                f'<ParameterDeclaration name="{name}" parameterType="double" value="{value}"><ConstraintGroup>'
                + "".join(f'<ValueConstraint rule="{rule}" value="{bound}"/>' for rule, bound in group)
                + "</ConstraintGroup></ParameterDeclaration>"
                for name, value, group in rules
            )
        )
    )
    return path


def test_a_range_that_another_parameter_bounds_reaches_as_far_as_that_one_allows(tmp_path: Path) -> None:
    """Not as far as its nominal value: with a = 20, b may be 19. What does not go together is excluded, as a draw."""
    path = compared(tmp_path)
    found = space_of(path, RunSpec())
    assert [found.values((share,) * 3) for share in (0.0, 1.0)] == [
        {"a": "10", "b": "0", "c": "-1"}, {"a": "20", "b": "20", "c": "20"},
    ]  # fmt: skip
    draws = [found.values(shares) for shares in sample("random", found.axes, 4000, 1)]
    kept = [{name: float(value) for name, value in each.items()} for each in draws if not excluded_by(path, each)]
    assert len(kept) / len(draws) == pytest.approx(0.75 / 21, abs=0.01)  # b <= a in 3 of 4, c in 1 of its 21
    assert max(each["b"] for each in kept) > 17
    fixed = space_of(path, RunSpec(set=Assignments(scenario={"a": "12"})))
    assert fixed.values((1.0, 1.0)) == {"b": "12", "c": "12"}


def test_a_whole_number_stays_within_its_groups(tmp_path: Path) -> None:
    """The last share, and the one at the end of a group, are no value above it."""
    planted.scenario(tmp_path)
    file = tmp_path / "planted.xosc"
    constraint = '<ValueConstraint rule="{}" value="{}"/>'
    groups = "".join(
        "<ConstraintGroup>"
        + constraint.format("greaterOrEqual", low)
        + constraint.format("lessOrEqual", high)
        + "</ConstraintGroup>"
        for low, high in ((0, 3), (6, 9))
    )
    text = file.read_text()
    declared = f'<ParameterDeclaration name="n" parameterType="integer" value="1">{groups}</ParameterDeclaration>'
    at = text.index("<ParameterDeclarations>") + len("<ParameterDeclarations>")
    file.write_text(text[:at] + declared + text[at:])
    (axis,) = [one for one in space_of(file, RunSpec()).axes if one.name == "n"]
    assert {axis.at(k / 16)["n"] for k in range(17)} == {"0", "1", "2", "3", "6", "7", "8", "9"}
