"""Nets: the firing rule, the hierarchy, and the properties of the behaviour's nets."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ads.planning.nets import CROSSING, FOLLOWING, JUNCTION, LIGHT, MAIN, NETS, OVERTAKING
from ads.planning.petri_net import Net, NetSystem, Transition

FACTS = sorted({fact for net in NETS for fact in net.facts})
HOME = {
    "main": "drive", "light": "go", "crossing": "clear", "junction": "clear", "following": "free", "overtaking": "keep",
}  # fmt: skip


def successors(net: Net, marking: frozenset[str]) -> set[frozenset[str]]:
    return {net.fire(marking, t) for t in net.enabled(marking)}


@pytest.mark.parametrize("net", NETS, ids=lambda net: net.name)
def test_every_reachable_marking_holds_one_token(net):
    assert {len(marking) for marking in net.reachable()} == {1}


@pytest.mark.parametrize("net", NETS, ids=lambda net: net.name)
def test_no_transition_is_dead(net):
    fired = {t.name for marking in net.reachable() for t in net.enabled(marking)}
    assert fired == {t.name for t in net.transitions}


@pytest.mark.parametrize("net", NETS, ids=lambda net: net.name)
def test_no_place_is_out_of_reach(net):
    assert {p for marking in net.reachable() for p in marking} == set(net.places)


@pytest.mark.parametrize("net", NETS, ids=lambda net: net.name)
def test_every_marking_can_come_back_to_driving(net):
    home = frozenset({HOME[net.name]})
    for start in net.reachable():
        seen, todo = {start}, [start]
        while todo:
            for after in successors(net, todo.pop()):
                if after not in seen:
                    seen.add(after)
                    todo.append(after)
        assert home in seen


@pytest.mark.parametrize("net", NETS, ids=lambda net: net.name)
def test_every_guard_can_hold(net):
    assert [t.name for t in net.transitions if set(t.when) & set(t.unless)] == []


@given(st.lists(st.frozensets(st.sampled_from(FACTS)), max_size=30))
def test_nets_at_work_hold_one_token_each_whatever_happens(history):
    system = NetSystem(NETS)
    for true in history:
        system.step({fact: fact in true for fact in FACTS})
        for net in NETS:
            assert sum(system.trace[f"net.{net.name}.{place}"] for place in net.places) == 1


@given(st.lists(st.frozensets(st.sampled_from(FACTS)), max_size=30))
def test_an_undisturbed_drive_comes_back_to_driving(history):
    system = NetSystem(NETS)
    for true in history:
        system.step({fact: fact in true for fact in FACTS})
    calm = {"located", "averted", "standing", "in_lane", "beside", "passed"}  # nothing ahead, in the lane again
    for _ in range(8):
        system.step({fact: fact in calm for fact in FACTS})
    assert {net.name for net in NETS if not system.marked(net.name, HOME[net.name])} == set()


def test_children_run_while_the_car_drives_and_only_then():
    assert MAIN.parent == ""
    assert {net.parent for net in (LIGHT, CROSSING, JUNCTION, FOLLOWING, OVERTAKING)} == {"main.drive"}


def toggle(parent: str = "") -> Net:
    up = Transition("up", ("off",), ("on",), when=("go",), unless=("no",))
    down = Transition("down", ("on",), ("off",), when=("back",))
    return Net("toggle", ("off",), {"off": "", "on": ""}, (up, down), parent)


@pytest.mark.parametrize(
    ("facts", "on"),
    [
        ({"go": True, "no": False, "back": False}, True),
        ({"go": True, "no": True, "back": False}, False),
        ({"go": False, "no": False, "back": False}, False),
    ],
)
def test_a_transition_fires_when_its_guard_holds(facts, on):
    system = NetSystem((toggle(),))
    system.step(facts)
    assert system.marked("toggle", "on") is on
    assert system.trace == {"net.toggle.off": 0.0 if on else 1.0, "net.toggle.on": 1.0 if on else 0.0}


def test_a_transition_fires_at_most_once_a_step():
    system = NetSystem((toggle(),))
    assert system.step({"go": True, "no": False, "back": True}) == ("toggle.up", "toggle.down")


def test_a_full_output_place_blocks():
    net = Net("n", ("a", "b"), {"a": "", "b": ""}, (Transition("t", ("a",), ("b",)),))
    assert net.enabled(frozenset(net.initial)) == ()
    with pytest.raises(ValueError, match="not enabled"):
        net.fire(frozenset(net.initial), net.transitions[0])


def test_a_child_sleeps_and_keeps_its_marking_while_its_parent_place_is_empty():
    halt = Transition("halt", ("run",), ("rest",), when=("halt",))
    wake = Transition("wake", ("rest",), ("run",), unless=("halt",))
    parent = Net("p", ("run",), {"run": "", "rest": ""}, (halt, wake))
    system = NetSystem((parent, toggle("p.run")))
    facts = {"halt": False, "go": True, "no": False, "back": False}
    system.step(facts)
    system.step({**facts, "halt": True, "back": True})
    assert system.marked("toggle", "on")
    system.step({**facts, "go": False, "back": True})
    assert system.marked("toggle", "off")


def test_an_unknown_place_is_refused():
    with pytest.raises(ValueError, match="unknown place 'c'"):
        Net("n", ("a",), {"a": ""}, (Transition("t", ("a",), ("c",)),))
