"""Variants: what is drawn, what a failure shrinks to, and the file and command it leaves."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import Phase, find, given, settings
from hypothesis import strategies as st
from hypothesis.errors import NoSuchExample

from openscenario.read import read_declarations, read_scenario
from pytest_dvp import Variant, scenario_variants
from pytest_dvp.plugin.scenario_strategy import FuzzError, keep, kept_name

Write = Callable[..., Path]
QUIET = settings(database=None, derandomize=True, deadline=None, phases=[Phase.generate, Phase.shrink])

WHOLE = (
    "  </ParameterDeclarations>",
    """<ParameterDeclaration name="count" parameterType="integer" value="3"><ConstraintGroup>
      <ValueConstraint rule="greaterThan" value="0"/><ValueConstraint rule="lessThan" value="9"/>
    </ConstraintGroup></ParameterDeclaration>
    <ParameterDeclaration name="weather" parameterType="string" value="dry">
      <ConstraintGroup><ValueConstraint rule="equalTo" value="dry"/></ConstraintGroup>
      <ConstraintGroup><ValueConstraint rule="equalTo" value="wet"/></ConstraintGroup>
    </ParameterDeclaration>
    <ParameterDeclaration name="free" parameterType="double" value="1"/>
  </ParameterDeclarations>""",
)


def shrunk(path: Path, bad: Callable[[Variant], bool]) -> Variant:
    return find(scenario_variants(path), bad, settings=QUIET)


def test_the_simplest_variant_is_the_nominal_one(scenario: Write) -> None:
    assert shrunk(scenario(), lambda _: True).values == {}


def test_a_failure_shrinks_to_the_value_nearest_to_nominal(scenario: Write) -> None:
    # nominal 5, range 2 to 6, a grid of 0.05
    assert shrunk(scenario(), lambda v: v.values.get("ego_speed", 5.0) < 4.0).values == {
        "ego_speed": pytest.approx(3.95)
    }


def test_values_are_round_numbers(scenario: Write) -> None:
    value = shrunk(scenario(), lambda v: v.values.get("ego_speed", 5.0) > 5.3).values["ego_speed"]
    assert repr(value) == "5.35"


@pytest.mark.parametrize("end", [2.0, 6.0])
def test_both_ends_of_a_range_are_reached(scenario: Write, end: float) -> None:
    assert shrunk(scenario(), lambda v: v.values.get("ego_speed", 5.0) == end).values == {"ego_speed": end}


def test_nothing_outside_the_constraints_is_drawn(scenario: Write) -> None:
    with pytest.raises(NoSuchExample):
        shrunk(scenario(WHOLE), lambda v: not 2.0 <= v.values.get("ego_speed", 5.0) <= 6.0)
    with pytest.raises(NoSuchExample):
        shrunk(scenario(WHOLE), lambda v: not 1 <= v.values.get("count", 3) <= 8)


def test_the_value_that_a_range_leaves_out_is_not_drawn(scenario: Write) -> None:
    end = '<ValueConstraint rule="lessOrEqual" value="6.0"/>'
    path = scenario((end, f'{end}<ValueConstraint rule="notEqualTo" value="2.0"/>'))
    with pytest.raises(NoSuchExample):
        shrunk(path, lambda v: v.values.get("ego_speed") == 2.0)
    assert shrunk(path, lambda v: v.values.get("ego_speed") == 6.0).values == {"ego_speed": 6.0}


def test_parameters_that_constrain_each_other_are_drawn_together(scenario: Write) -> None:
    """Nobody else is faster than the ego, whatever its speed is in the variant."""
    other = """<ParameterDeclaration name="other" parameterType="double" value="3"><ConstraintGroup>
      <ValueConstraint rule="greaterOrEqual" value="1"/><ValueConstraint rule="lessOrEqual" value="$ego_speed"/>
    </ConstraintGroup></ParameterDeclaration></ParameterDeclarations>"""
    path = scenario(("</ParameterDeclarations>", other))
    with pytest.raises(NoSuchExample):
        shrunk(path, lambda v: v.values.get("other", 3.0) > v.values.get("ego_speed", 5.0))
    slow = shrunk(path, lambda v: v.values.get("ego_speed", 5.0) < 2.5).values
    assert slow["other"] <= slow["ego_speed"] < 2.5


def test_whole_numbers_stay_whole(scenario: Write) -> None:
    value = shrunk(scenario(WHOLE), lambda v: v.values.get("count", 3) > 5).values["count"]
    assert (value, type(value)) == (6, int)


def test_words_come_from_the_groups(scenario: Write) -> None:
    assert shrunk(scenario(WHOLE), lambda v: v.values.get("weather") is not None).values == {"weather": "wet"}


def test_a_parameter_without_constraints_is_not_varied(scenario: Write) -> None:
    with pytest.raises(NoSuchExample):
        shrunk(scenario(WHOLE), lambda v: "free" in v.values)


def test_only_the_named_parameters_vary(scenario: Write) -> None:
    with pytest.raises(NoSuchExample):
        find(scenario_variants(scenario(WHOLE), ["count"]), lambda v: "ego_speed" in v.values, settings=QUIET)


def test_an_unknown_name_comes_with_the_nearest(scenario: Write) -> None:
    with pytest.raises(FuzzError, match="did you mean 'ego_speed'"):
        find(scenario_variants(scenario(), ["ego_sped"]), lambda _: True, settings=QUIET)


def test_a_name_without_a_range_is_no_silent_gap(scenario: Write) -> None:
    with pytest.raises(FuzzError, match=r"x\.xosc: free has no ConstraintGroup, so there is no range to vary it in"):
        find(scenario_variants(scenario(WHOLE), ["free", "ego_speed"]), lambda _: True, settings=QUIET)


def test_a_scenario_with_nothing_to_vary_says_so(scenario: Write) -> None:
    path = scenario(("greaterOrEqual", "notEqualTo"), ("lessOrEqual", "notEqualTo"))
    with pytest.raises(FuzzError, match="ego_speed bound no range"):
        find(scenario_variants(path), lambda _: True, settings=QUIET)


def test_a_missing_scenario_says_where_it_looked() -> None:
    with pytest.raises(FuzzError, match=r"no scenario nowhere\.xosc"):
        find(scenario_variants("nowhere.xosc"), lambda _: True, settings=QUIET)


def test_a_shipped_scenario_is_found_by_name(scenarios_dir: Path) -> None:
    variant = find(scenario_variants("overtaking.xosc"), lambda _: True, settings=QUIET)
    assert variant.scenario.samefile(scenarios_dir / "overtaking.xosc")


def test_the_kept_file_holds_the_values_and_its_command_names_it(
    scenario: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    variant = Variant(scenario(), {"ego_speed": 3.5})
    command = keep(variant, {"seed": 11, "rootdir": tmp_path}, tmp_path / "runs", "test_it")
    target = tmp_path / "runs/variants/test_it-x.xosc"
    assert command == "dvp run runs/variants/test_it-x.xosc --seed 11"
    assert [d.value for d in read_declarations(target)] == ["3.5"]
    assert read_scenario(target, rootdir=tmp_path).road_network.logic_file == tmp_path / "straight.xodr"


def test_tests_that_could_share_a_name_keep_files_of_their_own() -> None:
    long = "test_" + 60 * "a"
    tests = ["a.py::test_it", "a.py::test_p[1]", "a.py::test_p[-1]", "a.py::test_same", "b.py::test_same"]
    tests += ["a.py::test_Case", "a.py::test_case", f"a.py::{long}_b", f"a.py::{long}_c"]
    names = [test.partition("::")[2] for test in tests]
    kept = [kept_name(name, test, names) for name, test in zip(names, tests, strict=True)]
    assert kept[0] == "test_it"
    assert len({name.lower() for name in kept}) == len(tests)
    assert all(re.fullmatch(r"[A-Za-z0-9_-]{1,69}", name) for name in kept)


def test_the_command_of_a_variant_says_all_that_it_was_driven_with(
    scenario: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    asked = {"rootdir": tmp_path, "stage": "pe", "vehicle": "can", "fault": "drop@1", "reading": "standard"}
    command = keep(Variant(scenario(), {}), asked, tmp_path / "runs", "test_it")
    told = "--seed 7 --stage pe --vehicle can --fault drop@1 --reading standard"
    assert command == f"dvp run runs/variants/test_it-x.xosc {told}"


def test_a_variant_reads_as_what_changed() -> None:
    assert repr(Variant(Path("a/x.xosc"), {"ego_speed": 3.5})) == "Variant(x.xosc, ego_speed=3.5)"


@given(st.data())
@settings(max_examples=50, database=None, derandomize=True, deadline=None)
def test_every_variant_is_accepted_by_the_reader(data: st.DataObject) -> None:
    variant = data.draw(scenario_variants("urban.xosc"))
    texts = {name: repr(value) if isinstance(value, float) else str(value) for name, value in variant.values.items()}
    read_scenario(variant.scenario, parameters=texts)
