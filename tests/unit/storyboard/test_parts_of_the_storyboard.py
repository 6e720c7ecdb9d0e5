"""Parts of a storyboard by themselves: names, reports, order of Init, phases, values, and what traffic is made of."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from openscenario import model
from openscenario.storyboard.actions.traffic import Area, Sink, vehicle
from openscenario.storyboard.conditions.time_of_day import _seconds
from openscenario.storyboard.entity import Entity
from openscenario.storyboard.init_order import Wish, _waits
from openscenario.storyboard.nodes import RUNNING, Node, find
from openscenario.storyboard.places import RoadPoint
from openscenario.storyboard.play import turned
from openscenario.storyboard.positions import on_ground
from openscenario.storyboard.report import report
from openscenario.storyboard.signals import Program, programs
from openscenario.storyboard.trailers import couple, couples, draw, line_up, train, uncouple
from openscenario.storyboard.values import COMPARISONS, Values, compare, typed
from openscenario.storyboard.world import World

# --- names


def tree() -> dict[str, Node]:
    """Two stories of one act each, with an event "e" in both and one "f" in the second."""
    root = Node("storyboard", "root", None)
    nodes = {"root": root}
    for story in ("s1", "s2"):
        nodes[story] = Node("story", story, root)
        nodes[f"{story}.a"] = Node("act", "a", nodes[story])
        nodes[f"{story}.e"] = Node("event", "e", nodes[f"{story}.a"])
    nodes["f"] = Node("event", "f", nodes["s2.a"])
    return nodes


def test_a_path_begins_with_the_story() -> None:
    nodes = tree()
    assert nodes["root"].path == ("root",)
    assert nodes["s1"].path == ("s1",)
    assert nodes["s1.e"].path == ("s1", "a", "e")


def test_a_name_means_the_element_that_is_nearest() -> None:
    nodes = tree()
    root = nodes["root"]
    assert find(root, "event", "e", nodes["s1.a"]) is nodes["s1.e"]
    assert find(root, "event", "e", nodes["f"]) is nodes["s2.e"]
    assert find(root, "event", "s1::a::e", nodes["f"]) is nodes["s1.e"]
    assert find(root, "event", "a::f", nodes["s1.e"]) is nodes["f"]
    assert find(root, "act", "e", nodes["s1.e"]) is None
    assert find(root, "event", "a", nodes["s1.e"]) is None
    assert find(root, "event", "s1::f", nodes["s1.e"]) is None


def test_an_element_ends_with_its_children() -> None:
    nodes = tree()
    act = nodes["s2.a"]
    assert not act.finished()
    assert not nodes["f"].finished()
    nodes["s2.e"].state = "completeState"
    assert not act.finished()
    nodes["f"].state = "completeState"
    assert act.finished()
    nodes["f"].state = RUNNING
    assert act.event_running()


# --- reports


def state(name: str = "c", *, ever: bool = False, at_start: bool = False, line: int = 7) -> Any:
    at = SimpleNamespace(file="x.xosc", line=line, element="Condition")
    shown = SimpleNamespace(name=name, condition=SimpleNamespace(), at=at, condition_edge="rising")
    return SimpleNamespace(model=shown, ever=ever, true_at_start=at_start)


def trigger(*states: Any) -> Any:
    return SimpleNamespace(groups=(states,), entities=())


def told(nodes: dict[str, Node]) -> dict[str, list[tuple[str, str | None]]]:
    found: dict[str, list[tuple[str, str | None]]] = {}
    for finding in report(nodes["root"]):
        found.setdefault(finding.code, []).append((finding.text, finding.hint))
    return found


def test_what_never_happened_is_reported_with_its_reason() -> None:
    nodes = tree()
    nodes["s1.a"].executions = nodes["s1.e"].executions = 1
    nodes["s2.a"].executions = nodes["s2"].executions = 1
    nodes["s2.e"].start = trigger(state("far", ever=True), state("near"), state(""))
    nodes["f"].start = trigger(state("one", ever=True), state("other", ever=True))
    found = told(nodes)
    assert found["event-never-fired"] == [
        ("event 'e' never fired", "never true: 'near', 'SimpleNamespace'"),
        ("event 'f' never fired", "its conditions were never true at the same time"),
    ]
    assert "act-never-started" not in found


def test_what_lies_in_what_never_started_says_so() -> None:
    nodes = tree()
    nodes["s1"].executions = nodes["s2"].executions = 1
    nodes["s2.a"].executions = nodes["s2.e"].executions = nodes["f"].executions = 1
    found = told(nodes)
    assert found["event-never-fired"] == [("event 'e' never fired", "its act 'a' never started")]
    assert found["act-never-started"] == [("act 'a' never started", "")]


def test_of_an_act_of_the_storyboard_itself_nothing_had_to_start_before() -> None:
    root = Node("storyboard", "root", None)
    act = Node("act", "a", root)
    assert told({"root": root})["act-never-started"] == [("act 'a' never started", "")]
    act.start = trigger(state("late"))
    assert told({"root": root})["act-never-started"] == [("act 'a' never started", "never true: 'late'")]


def test_an_act_that_still_runs_is_reported_if_anything_could_have_ended() -> None:
    nodes = tree()
    for node in nodes.values():
        node.executions = 1
    nodes["s1.a"].state = RUNNING
    assert told(nodes) == {"act-never-ended": [("act 'a' was still running at the end", "")]}
    empty = Node("storyboard", "root", None)
    act = Node("act", "a", empty)
    act.executions, act.state = 1, RUNNING
    assert told({"root": empty}) == {}


@pytest.mark.parametrize(("line", "shown"), [(7, 7), (0, None)])
def test_an_edge_that_was_true_from_the_start_is_reported_with_its_place(line: int, shown: int | None) -> None:
    nodes = tree()
    for node in nodes.values():
        node.executions = 1
    nodes["f"].executions = 0
    nodes["f"].start = trigger(state("c", at_start=True, ever=True, line=line), state("d", ever=True))
    edges = [finding for finding in report(nodes["root"]) if finding.code == "edge-true-from-start"]
    assert [(each.file, each.line, each.element, each.found) for each in edges] == [
        ("x.xosc", shown, "Condition", "conditionEdge rising")
    ]
    nodes["f"].executions = 1
    assert "edge-true-from-start" not in told(nodes)


# --- order of Init


def wish(entity: Any, gives: str, wants: str = "", of: str = "") -> Any:
    return ((None, entity), Wish(gives, wants, frozenset(of.split())))


def test_who_needs_another_s_place_waits_for_it() -> None:
    a, b, c = (SimpleNamespace(name=name) for name in "ABC")
    needs = wish(a, "place", "place", "B")
    assert _waits(0, [needs, wish(b, "place")])
    assert not _waits(0, [needs, wish(b, "speed")])  # not for its speed
    assert not _waits(0, [needs, wish(c, "place")])  # nor for somebody else
    assert not _waits(0, [needs, wish(None, "place")])
    assert not _waits(0, [wish(a, "place", "place", "A"), wish(a, "place")])  # nor for itself
    assert not _waits(0, [wish(a, "place"), wish(b, "place", "place", "A")])
    assert _waits(1, [wish(a, "speed"), wish(a, "place")])  # its own keep their order


# --- phases


def program(*phases: tuple[str, float], start: float = 0.0) -> Program:
    states = {name: (model.TrafficSignalState(traffic_signal_id="1", state=name),) for name, _ in phases}
    shown = tuple(model.Phase(name=n, duration=d, traffic_signal_states=states[n]) for n, d in phases)
    return Program(model.TrafficSignalController(name="c", phases=shown), start)


def test_a_light_that_an_action_sets_keeps_until_the_next_phase() -> None:
    lights, world = program(("red", 3.0), ("green", 2.0)), World()
    lights.show(0.0, world)
    assert world.signals == {"1": "red"}
    world.signals["1"] = "off"
    lights.show(2.9, world)
    assert world.signals == {"1": "off"}
    lights.show(3.0, world)
    assert world.signals == {"1": "green"}
    lights.begin("green", 4.0)  # anew
    world.signals["1"] = "off"
    lights.show(4.0, world)
    assert world.signals == {"1": "green"}
    assert [name and name.name for name in (lights.phase(5.9), lights.phase(6.0))] == ["green", "red"]


def test_a_controller_without_phases_shows_nothing() -> None:
    world = SimpleNamespace(signals={"1": "off"})
    program().show(3.0, world)  # type: ignore[arg-type]
    assert world.signals == {"1": "off"}
    assert program(("red", 0.0), ("green", 0.0)).phase(9.0).name == "red"  # type: ignore[union-attr]


def test_delays_add_up_along_references() -> None:
    def controller(name: str, delay: float, reference: str = "") -> model.TrafficSignalController:
        return model.TrafficSignalController(name=name, delay=delay, reference=reference, phases=())

    known = programs(
        [controller("a", 1.0), controller("b", 2.0, "a"), controller("c", 4.0, "b"), controller("d", 8.0, "e")]
    )
    assert {name: each.start for name, each in known.items()} == {"a": 1.0, "b": 3.0, "c": 7.0, "d": 8.0}
    assert {n: p.start for n, p in programs([controller("a", 1.0, "b"), controller("b", 2.0, "a")]).items()} == {
        "a": 3.0,
        "b": 3.0,
    }


# --- values


@pytest.mark.parametrize(
    ("rule", "below", "equal", "above"),
    [("equalTo", False, True, False), ("notEqualTo", True, False, True), ("greaterThan", False, False, True),
     ("lessThan", True, False, False), ("greaterOrEqual", False, True, True), ("lessOrEqual", True, True, False)],
)  # fmt: skip
def test_rules_compare_to_a_millionth(rule: str, below: bool, equal: bool, above: bool) -> None:
    holds = COMPARISONS[rule]
    assert (holds(0.99, 1.0), holds(1.0, 1.0), holds(1.01, 1.0)) == (below, equal, above)
    assert holds(1.0 + 5e-7, 1.0) == holds(1.0 - 5e-7, 1.0) == equal
    assert (holds(1.0 - 2e-6, 1.0), holds(1.0 + 2e-6, 1.0)) == (below, above)


@pytest.mark.parametrize(
    ("rule", "holds"), [("equalTo", True), ("notEqualTo", False), ("greaterThan", False), ("lessThan", False)]
)
def test_infinite_is_infinite(rule: str, holds: bool) -> None:
    assert COMPARISONS[rule](math.inf, math.inf) is holds


@pytest.mark.parametrize(
    ("kind", "text", "value"),
    [("boolean", " True ", True), ("boolean", "1", True), ("boolean", "0", False), ("integer", "3.0", 3),
     ("unsignedShort", "3", 3), ("double", "2.5", 2.5), ("string", "2.5", "2.5"), ("double", "fast", "fast"),
     ("integer", "x", "x"), ("dateTime", "1", "1")],
)  # fmt: skip
def test_a_text_spells_a_value_of_its_type(kind: str, text: str, value: Any) -> None:
    found = typed(kind, text)
    assert (found, type(found)) == (value, type(value))


def test_values_are_calculated_in_their_type() -> None:
    values = Values([("n", "integer", "7"), ("x", "double", "1.5"), ("s", "string", "abc")])
    for name in ("n", "x", "s"):
        values.add(name, 0.6)
        values.multiply(name, 2.0)
    assert [values.get(name) for name in ("n", "x", "s")] == [14, pytest.approx(4.2), "abc"]
    assert values.names() == ("n", "x", "s")
    values.set("n", "100")
    values.multiply("n", 1.15)  # 114.99999999999999 in binary
    assert values.get("n") == 115
    values.multiply("n", -1.15)
    assert values.get("n") == -132
    assert "n" in values
    assert "m" not in values
    values.set("n", "4")
    assert values.get("n") == 4


@pytest.mark.parametrize(
    ("left", "right", "rule"),
    [
        ("a", "b", "lessThan"),
        ("b", "a", "greaterThan"),
        ("a", "a", "equalTo"),
        (True, 1, "equalTo"),
        (2, 1.5, "greaterThan"),
    ],
)
def test_texts_compare_as_texts_and_numbers_as_numbers(left: Any, right: Any, rule: str) -> None:
    assert compare(rule, left, right)
    assert not compare({"lessThan": "greaterThan", "greaterThan": "lessThan"}.get(rule, "notEqualTo"), left, right)


def test_times_of_day_count_in_seconds_and_without_a_zone_in_utc() -> None:
    assert _seconds("2026-01-31T12:00:10") - _seconds(" 2026-01-31T12:00:00+00:00 ") == 10.0
    assert _seconds("2026-01-31T12:00:00+02:00") - _seconds("2026-01-31T12:00:00Z") == -7200.0
    assert _seconds("2026-02-01T00:00:00") - _seconds("2026-01-31T00:00:00") == 86400.0


@pytest.mark.parametrize(
    ("angle", "shown"), [(0.0, 0.0), (-0.5, math.tau - 0.5), (math.tau, 0.0), (7.0, 7.0 - math.tau), (-1e-20, 0.0)]
)
def test_rows_have_headings_from_nought_to_a_turn(angle: float, shown: float) -> None:
    assert turned(angle) == pytest.approx(shown)
    assert 0.0 <= turned(angle) < math.tau


# --- places and bodies without a road


@pytest.mark.parametrize("given", [(None,) * 4, (1.0, 2.0, 3.0, 4.0)])
def test_without_a_road_what_is_not_given_is_nought(given: tuple[Any, ...]) -> None:
    z, h, p, r = given
    place = on_ground(SimpleNamespace(network=None), 5.0, 6.0, z, h, p, r)  # type: ignore[arg-type]
    assert place[:6] == (5.0, 6.0, z or 0.0, h or 0.0, p or 0.0, r or 0.0)
    assert place.has_heading is (h is not None)


def body(name: str, x: float = 0.0, y: float = 0.0, h: float = 0.0) -> Entity:
    entity = Entity(model.ScenarioObject(name=name, entity=vehicle("car")), external=False)
    entity.hitch, entity.coupler = -1.0, 3.0
    entity.put(x, y, 0.5, h)
    return entity


def test_trailers_stand_straight_behind() -> None:
    """Hitch 1 m behind, coupler 3 m ahead of the axle: 4 m each; facing (0.6, 0.8)."""
    a, b, c = body("a", 10.0, 20.0, math.atan2(0.8, 0.6)), body("b"), body("c")
    couple(a, b)
    couple(b, c)
    line_up(a)
    assert (b.x, b.y, b.h) == pytest.approx((10.0 - 2.4, 20.0 - 3.2, a.h))
    assert (c.x, c.y, c.h) == pytest.approx((10.0 - 4.8, 20.0 - 6.4, a.h))
    assert list(train(a)) == [a, b, c]
    assert couples(b) == couples(c) == (a, b, c)
    assert couples(body("d"))[0].name == "d"
    couple(a, c)  # what hung there lets go, and c leaves b
    assert (a.trailer, c.drawn_by, b.drawn_by, b.trailer) == (c, a, None, None)
    uncouple(a)
    assert (a.trailer, c.drawn_by, c.speed) == (None, None, 0.0)


def test_an_axle_is_drawn_towards_the_hitch() -> None:
    """From (0, 0) towards a hitch at (3, 4): 5 m away with 3 m of drawbar it comes 2 m nearer."""
    a, b = body("a", 3.0, 5.0, 0.5 * math.pi), body("b")
    couple(a, b)
    a.speed, a.speed_before, a.ax, a.pitch = 4.0, 3.0, 2.0, 0.1
    draw(a, 0.5)
    assert (b.x, b.y, b.h) == pytest.approx((1.2, 1.6, math.atan2(4.0, 3.0)))
    assert (b.vx, b.vy, b.travelled) == pytest.approx((2.4, 3.2, 2.0))
    assert (b.speed, b.speed_before, b.ax, b.pitch) == (4.0, 3.0, 2.0, 0.1)
    draw(a, 0.0)
    assert (b.vx, b.travelled) == pytest.approx((2.4, 2.0))


# --- traffic


class Crowd:
    """As much of a crowd as an area or a sink asks for: spots each 10 m along two lanes of a road."""

    def __init__(self, *members: Entity) -> None:
        points = [RoadPoint("1", lane, 10.0 * k, 0.0) for lane in (-1, -2) for k in range(11)]
        x, y = np.array([point.s for point in points]), np.array([2.0 * point.lane + 0.0 for point in points])
        self.spots = SimpleNamespace(points=points, x=x, y=y)
        self.members = {each.name: (each, 0.0, None) for each in members}
        self.random = SimpleNamespace(random=lambda: 0.5)
        self.gone: list[str] = []
        self.admitted: list[Any] = []

    def of(self, flow: Any) -> list[Entity]:
        return [each for each, _, _ in self.members.values()]

    def dismiss(self, entity: Entity) -> None:
        self.gone.append(entity.name)
        del self.members[entity.name]

    def admit(self, flow: Any, name: str, what: Any, where: Any, speed: Any) -> bool:
        self.admitted.append(where)
        return True


def area(*ranges: Any, number: int = 2, continuous: bool = False) -> Area:
    where = SimpleNamespace(polygon=None, road_ranges=ranges)
    element: Any = SimpleNamespace(traffic_distribution=None, traffic_area=where)
    element.continuous, element.number_of_entities = continuous, number
    return Area(element, "area", None)  # type: ignore[arg-type]


def stretch(*cursors: tuple[float | None, tuple[int, ...]], length: float | None = None) -> Any:
    made = tuple(
        SimpleNamespace(road_id="1", s=s, lanes=tuple(SimpleNamespace(id=lane) for lane in lanes))
        for s, lanes in cursors
    )
    return SimpleNamespace(road_cursors=made, length=length)


@pytest.mark.parametrize(
    ("of_road", "lanes", "low", "high"),
    [
        (stretch((20.0, (-1,)), length=30.0), {-1}, 20.0, 50.0),
        (stretch((20.0, ()), length=30.0), {-1, -2}, 20.0, 50.0),
        (stretch((20.0, (-2,))), {-2}, 20.0, 100.0),
        (stretch((20.0, ()), (60.0, ())), {-1, -2}, 20.0, 60.0),
        (stretch((60.0, ()), (20.0, ()), length=5.0), {-1, -2}, 20.0, 60.0),
        (stretch((None, (-1,)), length=30.0), {-1}, 0.0, 30.0),
        (stretch((20.0, ()), (None, ()), length=30.0), {-1, -2}, 20.0, 50.0),
    ],
)
def test_an_area_is_a_stretch_of_some_lanes(of_road: Any, lanes: set[int], low: float, high: float) -> None:
    crowd: Any = Crowd()
    mask = area(of_road)._mask(crowd)
    found = {(point.lane, point.s) for point, here in zip(crowd.spots.points, mask, strict=True) if here}
    assert found == {(lane, 10.0 * k) for lane in lanes for k in range(11) if low <= 10.0 * k <= high}


def test_an_area_is_filled_once_and_kept_full_if_it_is_continuous() -> None:
    inside, outside = body("in", 30.0, -2.0), body("out", 70.0, -2.0)
    for continuous, gone, more in ((False, [], 0), (True, ["out"], 2)):
        crowd: Any = Crowd()
        flow = area(stretch((20.0, (-1,)), length=30.0), number=3, continuous=continuous)
        flow.come_and_go(crowd, 0.0)
        assert len(crowd.admitted) == 3
        crowd.members = {each.name: (each, 0.0, None) for each in (inside, outside)}
        flow.come_and_go(crowd, 0.1)
        assert (crowd.gone, len(crowd.admitted)) == (gone, 3 + more)


@pytest.mark.parametrize(("rate", "gone"), [(None, ["a", "b"]), (2.0, ["a"]), (0.0, [])])
def test_a_sink_takes_so_many_a_second_of_those_within_its_radius(rate: float | None, gone: list[str]) -> None:
    sink: Any = object.__new__(Sink)
    sink._element, sink._due = SimpleNamespace(rate=rate, radius=5.0), -math.inf
    sink._where = lambda: SimpleNamespace(x=50.0, y=0.0)
    crowd = Crowd(body("far", 50.0, 5.1), body("a", 53.0, 4.0), body("b", 50.0, 0.0))
    sink.come_and_go(crowd, 10.0)
    assert crowd.gone == gone
    sink.come_and_go(crowd, 10.4)
    assert crowd.gone == gone
    sink.come_and_go(crowd, 10.5)
    assert crowd.gone == (["a", "b"] if gone else [])
