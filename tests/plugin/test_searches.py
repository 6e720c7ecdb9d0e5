"""Events that never fired, whatever metrics a test asks for; searches that go past them and end with the smallest."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import pytest

from tests.plugin.conftest import XOSC, write_scenario

# A run that drives nothing. Its event fires, and it hits somebody, as the functions of the test's `world.py` say.
FAKE_RUN = """
import pytest
from world import fires, hits
from pytest_dvp import Variant
from pytest_dvp.plugin.item_notes import current_item, note, note_variant

NOMINAL = {"ego_speed": 5.0, "gap": 20.0}


class Result:
    folder = None

    def __init__(self, values, set):
        silent = [] if fires(**values) else ["Brake"]
        status = "FAIL" if hits(**values) else "PASS"
        text = f"collision {1 if hits(**values) else 0} at {values['ego_speed']:g} m/s"
        self.plain = {
            "scenario": "x.xosc", "line": 40, "stage": "dt", "seed": 7, "status": status, "ending": "stop",
            "simulated": 3.0, "set": set, "folder": None, "error": None, "replay": "dvp run x.xosc --seed 7",
            "metrics": {}, "events": ["Brake", "CutIn"], "never_fired": silent,
            "verdicts": [{
                "gate": "collision <= 0", "metric": "collision", "status": status, "value": 0.0, "unit": "-",
                "bound": 0.0, "margin": 0.0, "t": None, "object": "", "short": text, "message": text, "file": "",
                "line": None,
            }],
        }

    def as_dict(self):
        return self.plain


@pytest.fixture(scope="session")
def run(request):
    def drive(scenario):
        item = current_item(request.config)
        variant = scenario if isinstance(scenario, Variant) else None
        changed = dict(variant.values) if variant else {}
        note_variant(item, variant, {"seed": 7, "rootdir": request.config.rootpath})
        result = Result({**NOMINAL, **changed}, {name: str(value) for name, value in changed.items()})
        note(item, result.as_dict())
        return result

    return drive
"""

SEARCH = """
from hypothesis import given, settings
from pytest_dvp import scenario_variants

@settings(max_examples={examples}, derandomize=True, database=None)
@given(variant=scenario_variants("x.xosc"))
def test_it(run, gate, variant):
    gate(run(variant), metrics=["collision"]{more})
"""

ALWAYS = "def fires(ego_speed, gap): return True\n"
SLOW_NEVER = "def fires(ego_speed, gap): return ego_speed >= 3.0\n"
NEVER_HITS = "def hits(ego_speed, gap): return False\n"


@pytest.fixture
def world(pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> pytest.Pytester:
    monkeypatch.setenv("COLUMNS", "160")
    gap = """<ParameterDeclaration name="gap" parameterType="double" value="20"><ConstraintGroup>
      <ValueConstraint rule="greaterOrEqual" value="2"/><ValueConstraint rule="lessOrEqual" value="40"/>
    </ConstraintGroup></ParameterDeclaration></ParameterDeclarations>"""
    write_scenario(pytester.path, "x.xosc", XOSC.replace("</ParameterDeclarations>", gap))
    pytester.makeini("[pytest]\naddopts = --strict-markers --strict-config -W error -p no:cacheprovider")
    pytester.makeconftest(FAKE_RUN)
    pytester.syspathinsert()
    return pytester


def search(world: pytest.Pytester, rules: str, more: str = "", examples: int = 60) -> pytest.RunResult:
    world.makepyfile(world=rules, test_it=SEARCH.format(more=more, examples=examples))
    return world.runpytest_inprocess("test_it.py", "--junitxml=out.xml")


def properties(world: pytest.Pytester) -> dict[str | None, str | None]:
    return {p.get("name"): p.get("value") for p in ET.parse(world.path / "out.xml").iter("property")}


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ('metrics=["collision"]', "storyboard INCONCLUSIVE: event 'Brake' never fired"),
        ("", "storyboard INCONCLUSIVE: event 'Brake' never fired"),
        ('metrics=["collision"], optional_events=["CutIn"]', "storyboard INCONCLUSIVE: event 'Brake' never fired"),
        ('metrics=["collision"], optional_events=["Brake"]', ""),
        ('optional_events=["Brake", "CutIn"]', ""),
        ('optional_events=["Brke"]', "the scenario has no storyboard event 'Brke'; did you mean 'Brake'?"),
        ('optional_events="Brake"', "found 'Brake', expected a list of names: optional_events=['Brake']"),
        ('metrics="collision"', "metrics: found 'collision', expected a list of names: metrics=['collision']"),
    ],
)  # fmt: skip
def test_an_event_that_never_fired_is_inconclusive_unless_the_test_says_so(
    world: pytest.Pytester, asked: str, said: str
) -> None:
    never = "def fires(ego_speed, gap): return False\n"
    world.makepyfile(world=never + NEVER_HITS, test_it=f"def test_it(run, gate): gate(run('x.xosc'), {asked})")
    result = world.runpytest_inprocess("test_it.py")
    result.assert_outcomes(passed=not said, failed=bool(said))
    assert said in result.stdout.str()
    if "Brke" not in asked and "=[" in asked and "storyboard" in said:
        result.stdout.fnmatch_lines(["dvp run x.xosc --seed 7 --gate collision*"])


def test_variants_in_which_nothing_happened_are_counted_and_are_no_pass(world: pytest.Pytester) -> None:
    result = search(world, SLOW_NEVER + NEVER_HITS)
    result.assert_outcomes(failed=1)
    silent, variants = (int(properties(world)[name] or 0) for name in ("never_fired.Brake", "variants"))
    assert 0 < silent < variants == 60
    result.stdout.fnmatch_lines(
        [
            f"*Undecided: storyboard INCONCLUSIVE: event 'Brake' never fired ({silent} of 60 examples INCONCLUSIVE, *",
            "E   *mallest inconclusive example: test_it(",
            "E *variant=Variant(x.xosc, ego_speed=2.*),",
            "dvp run runs/variants/test_it-x.xosc --seed 7 --gate collision",
            "INCONCLUSIVE test_it.py::test_it x storyboard INCONCLUSIVE: event 'Brake' never fired",
            f"test_it.py::test_it x: {silent} of 60 variants: event 'Brake' never fired",
        ]
    )


def test_with_optional_events_they_are_still_counted(world: pytest.Pytester) -> None:
    result = search(world, SLOW_NEVER + NEVER_HITS, ', optional_events=["Brake"]')
    result.assert_outcomes(passed=1)
    result.stdout.re_match_lines([r"test_it\.py::test_it x: [1-9]\d? of 60 variants: event 'Brake' never fired"])


def test_a_variant_in_which_nothing_happened_hides_no_failure(world: pytest.Pytester) -> None:
    """More than half of the variants decide nothing, and the failure is the rarer one."""
    rules = (
        "def fires(ego_speed, gap): return gap >= 22\ndef hits(ego_speed, gap): return ego_speed < 2.5 and gap > 30\n"
    )
    result = search(world, rules, examples=200)
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["*GateFailed: collision 1 at 2.4* m/s"])
    assert "Undecided" not in result.stdout.str()


@pytest.mark.parametrize("method", [False, True])
def test_the_variant_that_is_told_has_no_parameter_too_many(world: pytest.Pytester, method: bool) -> None:
    """With a gap of 30 less speed is enough, so that Hypothesis alone ends with both parameters changed."""
    rules = "def hits(ego_speed, gap): return 5.6 < ego_speed < 5.85 or (ego_speed > 5.1 and gap > 30)\n"
    head, test = SEARCH.format(more="", examples=100).split("@settings")
    if method:
        lines = f"@settings{test}".replace("test_it(run", "test_it(self, run").splitlines()
        world.makepyfile(test_it="\n".join([head, "class TestIt:", *(f"    {line}" for line in lines)]))
    else:
        world.makepyfile(test_it=f"{head}@settings{test}")
    world.makepyfile(world=ALWAYS + rules)
    result = world.runpytest_inprocess("test_it.py")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(
        [
            "*GateFailed: collision 1 at 5.65 m/s",
            "E *variant=Variant(x.xosc, ego_speed=5.65),",
            "FAIL*collision 1 at 5.65 m/s*",
            "replay the worst: dvp run x.xosc --seed 7 --gate collision",
        ]
    )


def test_a_search_without_shrinking_is_left_as_it_ended(world: pytest.Pytester) -> None:
    rules = ALWAYS + "def hits(ego_speed, gap): return ego_speed > 5.6\n"
    world.makepyfile(
        world=rules,
        test_it=SEARCH.format(more="", examples=100)
        .replace("database=None", "database=None, phases=[Phase.generate]")
        .replace("import given", "import Phase, given"),
    )
    world.runpytest_inprocess("test_it.py").assert_outcomes(failed=1)


def test_what_a_test_assumes_holds_while_a_variant_is_made_smaller(world: pytest.Pytester) -> None:
    world.makepyfile(
        world=ALWAYS + "def hits(ego_speed, gap): return ego_speed > 5.6\n",
        test_it=SEARCH.format(more="", examples=100)
        .replace("import given", "import assume, given")
        .replace("    gate(", '    assume(variant.values.get("gap", 20) < 19)\n    gate('),
    )
    result = world.runpytest_inprocess("test_it.py")
    result.stdout.fnmatch_lines(["E *variant=Variant(x.xosc, ego_speed=5.65, gap=18.5),"])


def test_two_failing_tests_leave_two_files(world: pytest.Pytester) -> None:
    """`[1]` and `[-1]` are one name once their signs are gone, and both scenarios are x.xosc."""
    head, test = SEARCH.format(more="", examples=100).split("@settings")
    test = test.replace("variant):", "variant, side):")
    rules = "def hits(ego_speed, gap): return ego_speed > 5.6\n"
    sides = "@pytest.mark.parametrize('side', [1, -1])\n"
    world.makepyfile(world=ALWAYS + rules, test_it=f"import pytest\n{head}{sides}@settings{test}")
    result = world.runpytest_inprocess("test_it.py")
    result.assert_outcomes(failed=2)
    kept = [path.name for path in (world.path / "runs/variants").glob("test_it-1-*-x.xosc")]
    assert len(kept) == 2
    for name in kept:
        result.stdout.fnmatch_lines([f"dvp run runs/variants/{name} *"])
