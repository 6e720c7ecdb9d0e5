"""Parameter value distributions: cases counted as by hand and never built for it; slips with their place."""

from __future__ import annotations

import math
import random
import statistics
from collections.abc import Callable
from pathlib import Path

import pytest
from xosc_samples import ROAD, SCENARIO

from openscenario import model
from openscenario.distributions import MOST
from openscenario.draws import NothingToDraw, inverse
from openscenario.findings import Finding, ScenarioError
from openscenario.read import check_scenario, read_cases, read_distribution
from openscenario.write import write_distribution

PARAMETERS = """
    <ParameterDeclaration name="EgoSpeed" parameterType="double" value="10.0"/>
    <ParameterDeclaration name="Gap" parameterType="double" value="20.0">
      <ConstraintGroup><ValueConstraint rule="greaterThan" value="0"/></ConstraintGroup>
    </ParameterDeclaration>
    <ParameterDeclaration name="Lanes" parameterType="integer" value="1"/>
    <ParameterDeclaration name="Model" parameterType="string" value="car"/>
    <ParameterDeclaration name="Wet" parameterType="boolean" value="true"/>
"""
HEAD = '<FileHeader revMajor="1" revMinor="1" date="2026-01-01T00:00:00" description="d" author="a"/>'

Write = Callable[..., Path]


@pytest.fixture
def write(tmp_path: Path) -> Write:
    """Writes a distribution (its inside as text) beside the scenario that it varies, and gives its path."""

    def written(inside: str, scenario: str = "scenario.xosc") -> Path:
        declared = SCENARIO.index("<ParameterDeclaration "), SCENARIO.index("</ParameterDeclarations>")
        (tmp_path / "road.xodr").write_text(ROAD)
        (tmp_path / "scenario.xosc").write_text(SCENARIO[: declared[0]] + PARAMETERS + SCENARIO[declared[1] :])
        path = tmp_path / "distribution.xosc"
        path.write_text(
            f"<OpenSCENARIO>\n{HEAD}\n<ParameterValueDistribution>\n"
            f'<ScenarioFile filepath="{scenario}"/>\n{inside}\n</ParameterValueDistribution></OpenSCENARIO>'
        )
        return path

    return written


def single(name: str, inside: str) -> str:
    return (
        f'<DeterministicSingleParameterDistribution parameterName="{name}">\n{inside}\n'
        "</DeterministicSingleParameterDistribution>\n"
    )


def listed(*values: str) -> str:
    return "<DistributionSet>" + "".join(f'<Element value="{value}"/>' for value in values) + "</DistributionSet>"


def steps(low: str, high: str, step: str) -> str:
    return f'<DistributionRange stepWidth="{step}"><Range lowerLimit="{low}" upperLimit="{high}"/></DistributionRange>'


def table(*rows: dict[str, str]) -> str:
    sets = "".join(
        "<ParameterValueSet>"
        + "".join(f'<ParameterAssignment parameterRef="{name}" value="{value}"/>' for name, value in row.items())
        + "</ParameterValueSet>"
        for row in rows
    )
    inside = f"<ValueSetDistribution>{sets}</ValueSetDistribution>"
    return f"<DeterministicMultiParameterDistribution>{inside}</DeterministicMultiParameterDistribution>"


def deterministic(*parts: str) -> str:
    return f"<Deterministic>\n{''.join(parts)}</Deterministic>"


def stochastic(name: str, inside: str, runs: int = 2000, seed: str = 'randomSeed="4"') -> str:
    return (
        f'<Stochastic numberOfTestRuns="{runs}" {seed}>\n'
        f'<StochasticDistribution parameterName="{name}">\n{inside}\n</StochasticDistribution></Stochastic>'
    )


def errors(path: Path) -> list[tuple[str, int | None, str]]:
    found: tuple[Finding, ...] = check_scenario(path)
    return [(f.code, f.line, f.element.split("/")[-1]) for f in found if f.severity == "error"]


def test_all_combinations_in_order_the_last_changes_fastest(write: Write) -> None:
    cases = read_cases(
        write(deterministic(single("Model", listed("car", "van")), single("EgoSpeed", steps("1", "2", "1"))))
    )
    assert list(cases) == [
        {"Model": "car", "EgoSpeed": "1"},
        {"Model": "car", "EgoSpeed": "2"},
        {"Model": "van", "EgoSpeed": "1"},
        {"Model": "van", "EgoSpeed": "2"},
    ]


def test_a_table_gives_several_parameters_at_once_and_may_leave_one_at_its_default(write: Write) -> None:
    rows = ({"EgoSpeed": "5", "Gap": "9"}, {"Gap": "12"})
    assert list(read_cases(write(deterministic(table(*rows))))) == list(rows)


@pytest.mark.parametrize(
    ("low", "high", "step", "values"),
    [
        ("1.1", "1.5", "0.2", ["1.1", "1.3", "1.5"]),  # in binary (1.5 - 1.1) / 0.2 is below 2
        ("0", "0.9999999999999999", "0.1", [str(n / 10) if n else "0" for n in range(10)] + ["0.9999999999999999"]),
        ("10", "30", "7", ["10", "17", "24"]),
        ("-1", "1", "1", ["-1", "0", "1"]),
        ("3", "3", "5", ["3"]),
    ],
)
def test_a_range_has_the_steps_that_a_person_counts(
    write: Write, low: str, high: str, step: str, values: list[str]
) -> None:
    cases = read_cases(write(deterministic(single("EgoSpeed", steps(low, high, step)))))
    assert [case["EgoSpeed"] for case in cases] == values
    assert cases.count == len(values)


def test_a_count_of_1e18_is_known_at_once_and_its_last_case_too(write: Write) -> None:
    ranges = [single(name, steps("1", "1000000000", "1")) for name in ("EgoSpeed", "Gap")]
    cases = read_cases(write(deterministic(*ranges)))
    assert cases.count == 10**18
    assert cases[10**18 - 1] == {"EgoSpeed": "1000000000", "Gap": "1000000000"}
    with pytest.raises(IndexError):
        cases[10**18]


def test_a_sample_is_the_same_for_the_same_seed_and_has_no_case_twice(write: Write) -> None:
    cases = read_cases(write(deterministic(single("EgoSpeed", steps("1", "1000000000", "1")))))
    assert cases.sample(50, 7) == cases.sample(50, 7)
    assert cases.sample(50, 7) != cases.sample(50, 8)
    assert len(set(cases.sample(50, 7))) == 50
    assert read_cases(write(deterministic(single("Model", listed("a", "b"))))).sample(50, 7) == [0, 1]


def test_combinations_that_cannot_be_numbered_are_refused(write: Write) -> None:
    ranges = [single(name, steps("0.001", "1000000000", "0.001")) for name in ("EgoSpeed", "Gap")]
    assert MOST < 10**24
    assert errors(write(deterministic(*ranges))) == [("dist.too_many_cases", 5, "Deterministic")]


def test_a_written_distribution_reads_back_equal(write: Write, tmp_path: Path) -> None:
    parts = (
        table({"Gap": "9"}, {"Gap": "8"}),
        single("EgoSpeed", steps("1.1", "1.5", "0.2")),
        single("Model", listed("ä&lt;")),
    )
    for inside in (
        deterministic(*parts),
        stochastic("EgoSpeed", '<NormalDistribution expectedValue="3" variance="1"/>'),
    ):
        file = read_distribution(write(inside))
        (tmp_path / "below").mkdir(exist_ok=True)
        write_distribution(file, tmp_path / "below" / "copy.xosc")
        assert read_distribution(tmp_path / "below" / "copy.xosc", library=[tmp_path]) == file


TAIL = '<Range lowerLimit="8.5" upperLimit="10"/>'
ABOVE = '<Range lowerLimit="1" upperLimit="99"/>'

# Moments by theory: uniform (a+b)/2 and (b-a)^2/12; Poisson both the rate; a histogram the mixture of its bins;
# a normal distribution cut at its mean from below: mean + sigma sqrt(2/pi), variance sigma^2 (1 - 2/pi).
DRAWN = [
    ('<UniformDistribution><Range lowerLimit="2" upperLimit="8"/></UniformDistribution>', 5.0, 3.0),
    ('<NormalDistribution expectedValue="-3" variance="4"/>', -3.0, 4.0),
    (
        f'<NormalDistribution expectedValue="1" variance="4">{ABOVE}</NormalDistribution>',
        1 + 2 * math.sqrt(2 / math.pi),
        4 * (1 - 2 / math.pi),
    ),
    ('<LogNormalDistribution expectedValue="2" variance="0.5"/>', 2.0, 0.5),
    ('<PoissonDistribution expectedValue="3.5"/>', 3.5, 3.5),
    ('<PoissonDistribution expectedValue="40000"/>', 40000.0, 40000.0),
    (
        '<Histogram><Bin weight="1"><Range lowerLimit="0" upperLimit="1"/></Bin>'
        '<Bin weight="3"><Range lowerLimit="1" upperLimit="3"/></Bin></Histogram>',
        0.25 * 0.5 + 0.75 * 2.0,
        0.25 * (1 / 3) + 0.75 * (13 / 3) - 1.625**2,
    ),
]


@pytest.mark.parametrize(("inside", "mean", "variance"), DRAWN)
def test_drawn_values_have_the_moments_of_their_distribution(
    write: Write, inside: str, mean: float, variance: float
) -> None:
    """Within five standard errors of 2,000 draws (of the variance: for tails of up to those of the log-normal)."""
    cases = read_cases(write(stochastic("EgoSpeed", inside)))
    values = [float(case["EgoSpeed"]) for case in cases]
    assert len(values) == cases.count == 2000
    assert abs(statistics.fmean(values) - mean) < 5 * math.sqrt(variance / 2000)
    assert abs(statistics.variance(values) / variance - 1) < 5 * math.sqrt(5 / 2000)


def test_words_are_drawn_by_their_weights(write: Write) -> None:
    elements = '<Element value="car" weight="3"/><Element value="van" weight="1"/><Element value="bus" weight="0"/>'
    inside = f"<ProbabilityDistributionSet>{elements}</ProbabilityDistributionSet>"
    words = [case["Model"] for case in read_cases(write(stochastic("Model", inside)))]
    assert set(words) == {"car", "van"}
    assert abs(words.count("car") / 2000 - 0.75) < 5 * math.sqrt(0.75 * 0.25 / 2000)


@pytest.mark.parametrize(
    "inside",
    [
        f'<NormalDistribution expectedValue="0" variance="1">{TAIL}</NormalDistribution>',
        f'<LogNormalDistribution expectedValue="1" variance="1">{TAIL}</LogNormalDistribution>',
        f'<PoissonDistribution expectedValue="2">{TAIL}</PoissonDistribution>',
        f"<UniformDistribution>{TAIL}</UniformDistribution>",
    ],
)
def test_nothing_is_drawn_outside_the_range_even_far_in_the_tail(write: Write, inside: str) -> None:
    values = [float(case["EgoSpeed"]) for case in read_cases(write(stochastic("EgoSpeed", inside, runs=200)))]
    assert all(8.5 <= value <= 10 for value in values)


def test_draws_repeat_for_a_seed_and_differ_for_another(write: Write) -> None:
    inside = '<NormalDistribution expectedValue="3" variance="1"/>'
    own = [list(read_cases(write(stochastic("EgoSpeed", inside, 20)), seed=seed)) for seed in (1, 2)]
    assert own[0] == own[1]  # randomSeed of the file holds
    lent = [list(read_cases(write(stochastic("EgoSpeed", inside, 20, "")), seed=seed)) for seed in (1, 2, 1)]
    assert lent[0] == lent[2] != lent[1]


def test_a_case_is_drawn_without_those_before_it(write: Write) -> None:
    cases = read_cases(write(stochastic("Gap", '<PoissonDistribution expectedValue="9"/>', runs=4_000_000_000)))
    assert cases.count == 4_000_000_000
    assert cases[3_999_999_999] == cases[3_999_999_999]


def test_a_whole_parameter_gets_whole_numbers(write: Write) -> None:
    inside = '<UniformDistribution><Range lowerLimit="0" upperLimit="9"/></UniformDistribution>'
    assert all(case["Lanes"].isdigit() for case in read_cases(write(stochastic("Lanes", inside, 100))))


SLIPS = [
    (
        stochastic("Wet", '<PoissonDistribution expectedValue="2"/>'),
        ("dist.wrong_type", 6, "StochasticDistribution@parameterName"),
    ),
    (deterministic(single("EgoSpede", listed("1"))), ("param.undefined", 6, "@parameterName")),
    (deterministic(table({"EgoSpede": "1"})), ("param.undefined", 6, "ParameterAssignment@parameterRef")),
    (
        deterministic(single("EgoSpeed", steps("1", "2", "0"))),
        ("dist.step_not_positive", 7, "DistributionRange@stepWidth"),
    ),
    (
        deterministic(single("EgoSpeed", steps("1", "2", "-1"))),
        ("dist.step_not_positive", 7, "DistributionRange@stepWidth"),
    ),
    (deterministic(single("EgoSpeed", steps("3", "2", "1"))), ("value.out_of_range", 7, "Range@upperLimit")),
    (deterministic(single("EgoSpeed", "<DistributionSet/>")), ("xml.missing_element", 7, "DistributionSet")),
    (deterministic(single("EgoSpeed", "")), ("xml.missing_element", 6, "DeterministicSingleParameterDistribution")),
    (deterministic(single("EgoSpeed", listed("fast"))), ("value.not_a_number", 7, "Element@value")),
    (deterministic(single("Gap", listed("-3"))), ("param.outside_constraint", 7, "Element@value")),
    (deterministic(single("Gap", steps("0", "3", "1"))), ("param.outside_constraint", 7, "Range@lowerLimit")),
    (
        deterministic(single("Lanes", steps("1", "3", "0.5"))),
        ("value.not_an_integer", 7, "DistributionRange@stepWidth"),
    ),
    (
        deterministic(single("Gap", listed("3")), single("Gap", listed("4"))),
        ("dist.varied_twice", 9, "DeterministicSingleParameterDistribution@parameterName"),
    ),
    (
        deterministic(single("Gap", '<UserDefinedDistribution type="sobol">x</UserDefinedDistribution>')),
        ("dist.user_defined", 7, "UserDefinedDistribution@type"),
    ),
    (
        stochastic("Gap", '<UserDefinedDistribution type="sobol">x</UserDefinedDistribution>'),
        ("dist.user_defined", 7, "UserDefinedDistribution@type"),
    ),
    (
        stochastic("Gap", '<Histogram><Bin weight="-1"><Range lowerLimit="1" upperLimit="2"/></Bin></Histogram>'),
        ("value.out_of_range", 7, "Bin@weight"),
    ),
    (
        stochastic("Gap", '<ProbabilityDistributionSet><Element value="1" weight="0"/></ProbabilityDistributionSet>'),
        ("dist.nothing_to_draw", 7, "ProbabilityDistributionSet"),
    ),
    (
        stochastic("Gap", '<NormalDistribution expectedValue="1" variance="-1"/>'),
        ("value.out_of_range", 7, "NormalDistribution@variance"),
    ),
    (
        stochastic(
            "Gap",
            '<PoissonDistribution expectedValue="1" ><Range lowerLimit="0.2" upperLimit="0.8"/></PoissonDistribution>',
        ),
        ("dist.nothing_to_draw", 7, "PoissonDistribution"),
    ),
    (
        stochastic("Gap", '<PoissonDistribution expectedValue="2"/>', runs=0),
        ("value.out_of_range", 5, "Stochastic@numberOfTestRuns"),
    ),
    (deterministic() + "<Stochastic/>", ("xml.too_many", 6, "Stochastic")),
]


@pytest.mark.parametrize(("inside", "slip"), SLIPS)
def test_a_slip_is_found_at_its_place(write: Write, inside: str, slip: tuple[str, int, str]) -> None:
    code, line, element = slip
    found = errors(write(inside))
    assert any((code, line) == place[:2] and place[2].endswith(element) for place in found), found


def test_a_missing_scenario_is_one_slip_and_what_follows_is_said_once(write: Write) -> None:
    path = write(deterministic(single("EgoSpeed", listed("1")), single("Gap", listed("2"))), scenario="scenari.xosc")
    assert [place[:2] for place in errors(path)] == [("path.not_found", 4), ("param.undefined", 6)]
    assert "did you mean 'scenario.xosc'?" in str(check_scenario(path)[0])


@pytest.mark.parametrize(
    ("scenario", "code"), [("../../x.xosc", "path.outside_root"), ("distribution.xosc", "file.not_a_scenario")]
)
def test_what_is_varied_is_a_scenario_in_the_allowed_folders(write: Write, scenario: str, code: str) -> None:
    assert errors(write(deterministic(single("EgoSpeed", listed("1"))), scenario))[0][0] == code


def test_a_scenario_is_no_distribution_and_the_reader_says_so(write: Write) -> None:
    write(deterministic())
    with pytest.raises(ScenarioError, match=r"file\.not_a_distribution"):
        read_cases(write(deterministic()).with_name("scenario.xosc"))


def test_nothing_varied_is_a_warning_and_one_case(write: Write) -> None:
    path = write(deterministic())
    assert [(f.code, f.severity) for f in check_scenario(path)] == [("dist.empty", "warning")]
    assert list(read_cases(path)) == [{}]


def test_extreme_figures_give_finite_values_within_the_range_or_nothing() -> None:
    rng = random.Random(1)
    figures = (0.0, 5e-324, 1e-300, 1e-12, 1.0, 3.7, 1e12)
    drawn = 0
    for _ in range(3000):
        low, high = sorted(rng.choice((-1, 1)) * rng.choice(figures) for _ in range(2))
        limits = rng.choice((None, model.Range(low, high)))
        mean, variance = rng.choice(figures), rng.choice(figures)
        distribution = rng.choice(
            (
                model.NormalDistribution(rng.choice((-1, 1)) * mean, variance, limits),
                model.LogNormalDistribution(max(mean, 5e-324), variance, limits),
                model.PoissonDistribution(min(mean, 40.0), limits),
            )
        )
        try:
            draw = inverse(distribution)
        except NothingToDraw:
            continue
        values = [float(draw(u)) for u in (2**-54, 0.5, 1 - 2**-54)]
        assert all(math.isfinite(value) for value in values), distribution
        assert limits is None or all(low <= value <= high for value in values), distribution
        assert values == sorted(values), distribution
        drawn += 1
    assert drawn > 1000
