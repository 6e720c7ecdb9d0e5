"""Factors, forms and terms of a law, what each does on the car, and the effect file that is written of it."""

from __future__ import annotations

import itertools
import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.discover.factors import FACTORS, NUMBER, THRESHOLD, unit_text, value
from pytest_dvp.gap.discover.forms import forms, points, terms_at
from pytest_dvp.gap.discover.generic_effect import effect_of, generic_effects, values_of
from pytest_dvp.gap.discover.law import FoundTerm, Law
from pytest_dvp.gap.discover.law_file import effect_text, equation, law_names
from pytest_dvp.gap.discover.term import POINTS, Form, Term
from pytest_dvp.gap.words.discovery import discovery_lines
from vehicle.model.effect import Effect, Key
from vehicle.model.effect_catalogue import catalogue
from vehicle.model.model_file import parse_model
from vehicle.model.open_loop import Replay

AT = {point.name: point for point in POINTS}


def a_bus(**given: float) -> SimpleNamespace:
    fields = {"vx": 12.0, "steer": -0.2, "accel": 1.5, "ax": 0.7, "ay": -2.5, "yaw_rate": 0.15, "dt": 0.01,
              "settle": 0.0, "mass": 1500.0, "mass_ref": 1400.0, "yaw_inertia": 2000.0, "drag": 10.0, "brake": 500.0,
              "yaw_moment": 3.0,
              "fy_front": 4.0, "fy_rear": 5.0, "meas_v": 6.0, "meas_yaw_rate": 7.0, "meas_ax": 8.0, "meas_ay": 9.0,
              "meas_yaw": 1.0}  # fmt: skip
    return SimpleNamespace(**(fields | given))


def known(accel: float) -> dict[str, float]:
    """Each factor on `a_bus`, for a threshold of 4 m/s."""
    return {"1": 1.0, "v": 12.0, "d": -0.2, "|d|": 0.2, "a+": max(accel, 0.0), "a-": max(-accel, 0.0), "ax": 0.7,
            "ay": -2.5, "|ay|": 2.5, "r": 0.15, "(v - v0)+": 8.0, "tanh(r)": math.tanh(1.5),
            "[drive]": float(accel > 0.05), "[brake]": float(accel < -0.05), "[coast]": float(abs(accel) <= 0.05),
            "sqrt(v)": math.sqrt(1.2)}  # fmt: skip


@pytest.mark.parametrize("accel", [1.5, -2.5, 0.051, 0.049, -0.051, -0.049])
def test_a_factor_is_what_its_name_says_in_the_search_and_in_a_file(accel: float) -> None:
    bus, expected = a_bus(accel=accel), known(accel)
    plain = {"abs": abs, "max": max, "float": float}
    names = {"x": bus, "p": SimpleNamespace(v0=4.0), "tanh": math.tanh, "sqrt": math.sqrt, "__builtins__": plain}
    assert set(expected) == {factor.name for factor in FACTORS}
    for k, factor in enumerate(FACTORS):
        assert value(bus, k, 4.0) == pytest.approx(expected[factor.name]), factor.name
        assert eval(factor.code, names) == pytest.approx(expected[factor.name]), factor.name  # noqa: S307
    assert value(a_bus(vx=3.0), THRESHOLD, 4.0) == 0.0
    assert value(a_bus(vx=-0.5), NUMBER["sqrt(v)"], 4.0) == 0.0  # a car that rolls back has no root of its speed


def test_usual_sizes_make_coefficients_comparable() -> None:
    usual = {factor.name: factor.usual for factor in FACTORS}
    assert usual == {"1": 1.0, "v": 10.0, "d": 0.1, "|d|": 0.1, "a+": 2.0, "a-": 2.0, "ax": 2.0, "ay": 3.0, "|ay|": 3.0,
                     "r": 0.3, "(v - v0)+": 5.0, "tanh(r)": 1.0, "[drive]": 1.0,
                     "[brake]": 1.0, "[coast]": 1.0, "sqrt(v)": 1.0}  # fmt: skip
    units = {factor.name: unit_text(factor.unit) for factor in FACTORS}
    assert units == {"1": "-", "v": "m/s", "d": "rad", "|d|": "rad", "a+": "m/s^2", "a-": "m/s^2", "ax": "m/s^2",
                     "ay": "m/s^2", "|ay|": "m/s^2", "r": "rad/s", "(v - v0)+": "m/s", "tanh(r)": "-", "[drive]": "-",
                     "[brake]": "-", "[coast]": "-", "sqrt(v)": "-"}  # fmt: skip
    assert {p.name: (p.size, unit_text(p.unit)) for p in POINTS} == {
        "steer": (0.01, "rad"), "accel": (0.1, "m/s^2"), "drag": (0.1, "m/s^2"), "brake": (0.1, "m/s^2"),
        "yaw_moment": (0.05, "rad/s^2"), "fy_front": (0.1, "m/s^2"), "fy_rear": (0.1, "m/s^2"), "v": (0.1, "m/s"),
        "yaw_rate": (0.01, "rad/s"), "ax": (0.1, "m/s^2"), "ay": (0.1, "m/s^2"), "yaw": (0.01, "rad"),
    }  # fmt: skip
    assert {p.name for p in POINTS if p.odd} == {"steer", "yaw_moment", "fy_front", "fy_rear", "yaw_rate", "ay", "yaw"}


@pytest.mark.parametrize(
    ("unit", "text"), [((0, -2, 0), "1/s^2"), ((2, -1, -1), "m^2/(s rad)"), ((1, 1, 1), "m s rad"), ((-1, 0, 0), "1/m")]
)
def test_what_is_below_the_line_is_in_brackets_if_it_is_more_than_one(unit: tuple[int, int, int], text: str) -> None:
    assert unit_text(unit) == text


def test_a_form_tells_its_symmetry_size_and_simplicity() -> None:
    form = Form(("a-",), ("v", "d"), "lag")
    assert (form.odd, form.size, form.complexity, form.text) == (True, 2.0, 5, "a- lag(v d)")
    assert (Form(("d", "ay")).odd, Form(("d", "ay")).size) == (False, pytest.approx(0.3))
    assert (Form(("(v - v0)+",)).complexity, Form(("v",)).complexity, Form().complexity) == (2, 1, 0)
    assert (Form((), ("v",), "highpass").text, Form().text, Form(("v", "v")).text) == ("change(v)", "1", "v v")
    assert Form((), ("v",), "highpass").complexity == 3


def test_the_grammar_has_products_of_two_some_of_three_and_what_is_remembered() -> None:
    free = ["v", "d", "|d|", "a+", "a-", "ay", "|ay|", "r", "ax", "(v - v0)+", "tanh(r)"]
    found = {(form.gate, form.inside, form.filter) for form in forms()}
    plain = {gate for gate, _, kind in found if not kind}
    pairs = set(itertools.combinations_with_replacement(free, 2)) - {("a+", "a-"), ("|d|", "|d|"), ("|ay|", "|ay|")}
    three = {("v", "v", name) for name in free} | {("v", name, "|ay|") for name in free}
    three |= {t for name in ("d", "ay", "r") for t in ((name,) * 3, (name, "a-", "v"), (name, "a+", "v"))}
    held_back = {("[coast]",), ("[coast]", "v"), ("sqrt(v)",)}
    assert plain == {(), *((name,) for name in free)} | pairs | three | held_back
    lagged = {(gate, inside) for gate, inside, kind in found if kind == "lag"}
    inside = {i for _, i in lagged}
    gates = {(), ("v",), ("d",), ("a+",), ("a-",), ("[drive]",), ("[brake]",), ("ay",), ("r",)}
    assert {("v", "a-"), ("v", "a+"), ("a-",), ("[brake]",), ("ax", "ay"), ("v", "|ay|")} < inside
    assert (len(inside), lagged) == (16, set(itertools.product(gates, inside)))
    assert {(gate, i) for gate, i, kind in found if kind == "highpass"} == {((), i) for i in inside}
    simple = [form.complexity for form in forms()]
    assert simple == sorted(simple)


def test_each_form_is_tried_from_several_time_constants_or_thresholds() -> None:
    tried = list(terms_at(AT["brake"]))
    assert not any(term.form.odd for term in tried)
    assert [t.tau for t in tried if t.form == Form((), ("v", "a-"), "lag")] == [0.1, 0.5, 2.0, 10.0, 60.0]
    assert [t.tau for t in tried if t.form == Form((), ("a-",), "highpass")] == [0.1, 0.5, 2.0]
    assert [t.v0 for t in tried if t.form == Form(("(v - v0)+",))] == [4.0, 9.0, 16.0]
    assert [(t.c, t.tau, t.v0) for t in tried if t.form == Form(("v", "v"))] == [(1.0, 1.0, 5.0)]
    steered = {term.form.text for term in terms_at(AT["steer"])}
    assert {"1", "a+", "v a-", "v d"} <= steered  # a plain pull may act to one side
    assert not {"v v v", "lag(a-)", "v v |ay|"} & steered
    shown = [term.form for term in terms_at(AT["yaw_rate"]) if term.form.filter]
    assert Form((), ("r",), "lag") in shown
    assert not any(form.gate for form in shown)


def test_a_law_acts_only_where_the_model_has_something_to_act_on() -> None:
    plain = parse_model('[model]\nbase = "kinematic_bicycle"\n[parameters]\nwheelbase = 2.7\n')
    tyres = parse_model('[model]\nbase = "dynamic_bicycle"\n[parameters]\nwheelbase = 2.7\n')
    driven = parse_model(
        '[model]\nbase = "kinematic_bicycle"\n[inputs]\nsteer = "steer_cmd"\nlongitudinal = "v"\n'
        "[parameters]\nwheelbase = 2.7\n"
    )
    assert [p.name for p in points(plain, ("v", "ay"))] == ["steer", "accel", "drag", "brake", "v", "ay"]
    assert [p.name for p in points(tyres, ())][-3:] == ["yaw_moment", "fy_front", "fy_rear"]
    assert [p.name for p in points(driven, ("yaw",))] == ["steer", "yaw"]


def test_a_coefficient_is_of_the_size_of_its_point_over_that_of_its_form() -> None:
    term = Term(AT["steer"], Form(("v", "d")), c=3.0)
    assert term.coefficient == pytest.approx(3.0 * 0.01 / (10.0 * 0.1))
    assert (term.has_threshold, Term(AT["drag"], Form((), ("(v - v0)+",), "lag")).has_threshold) == (False, True)


def test_a_term_is_given_to_a_generic_effect_by_numbers() -> None:
    law = (Term(AT["fy_rear"], Form(("d", "a-"), ("ay",), "highpass"), c=2.0, tau=0.7, v0=6.0),
           Term(AT["ay"], Form(("r",))))  # fmt: skip
    assert [effect_of(term, number) for number, term in enumerate(law)] == ["term_body_0", "term_sensor_1"]
    values = values_of(law)
    first = {key: found for (effect, key), found in values.items() if effect == "term_body_0"}
    assert first == {"point": 2.0, "g1": 2.0, "g2": 5.0, "g3": 0.0, "h1": 7.0, "h2": 0.0, "filter": 2.0,
                     "c": pytest.approx(2.0 * 0.1 / (0.1 * 2.0 * 3.0)), "tau": 0.7, "v0": 6.0}  # fmt: skip
    assert values["term_sensor_1", "point"] == 3.0
    assert len(values) == 20


GENERIC = {effect.name: effect for effect in generic_effects()}
ACTS = {"steer": ("steer", 1.0), "accel": ("accel", 1.0), "drag": ("drag", 1400.0), "brake": ("brake", 1400.0),
        "yaw_moment": ("yaw_moment", 2000.0), "fy_front": ("fy_front", 1500.0), "fy_rear": ("fy_rear", 1500.0),
        "v": ("meas_v", 1.0), "yaw_rate": ("meas_yaw_rate", 1.0), "ax": ("meas_ax", 1.0), "ay": ("meas_ay", 1.0),
        "yaw": ("meas_yaw", 1.0)}  # fmt: skip


def played(term: Term, memory: SimpleNamespace, bus: SimpleNamespace) -> SimpleNamespace:
    """The bus after the generic effect of a term."""
    effect = effect_of(term, 0)
    values = {key: found for (_, key), found in values_of((term,)).items()}
    GENERIC[effect].function(bus, SimpleNamespace(**values), memory)
    return bus


def written(term: Term) -> Effect:
    """The effect of the file that is written of a law with this one term."""
    law = Law("LAW", (FoundTerm(term, 0.5 * term.coefficient, 2.0 * term.coefficient),), (), (3.0, 2.0), (1.0, 1.0), ())
    space: dict[str, Any] = {}
    exec(effect_text(law, fitted=["a.csv"], held_out=["b.csv"]), space)  # noqa: S102
    (name,) = law_names(law)
    found = space[name]
    return found if isinstance(found, Effect) else next(v for v in space.values() if isinstance(v, Effect))


@pytest.mark.parametrize("point", POINTS, ids=lambda p: p.name)
@pytest.mark.parametrize("kind", ["", "lag", "highpass"])
def test_a_term_adds_to_its_point_what_its_equation_says(point: Any, kind: Any) -> None:
    form = Form(("v", "|ay|"), ("ax", "a+"), kind) if kind else Form(("v", "|ay|", "ax"))
    term = Term(point, form, c=-0.6, tau=0.4)
    memory = SimpleNamespace(h=0.2)
    bus = played(term, memory, a_bus())
    inside = 0.7 * 1.5
    slow = inside + (0.2 - inside) * math.exp(-0.01 / 0.4)
    factor = {"": 0.7, "lag": slow, "highpass": inside - slow}[kind]
    acts, scale = ACTS[point.name]
    expected = getattr(a_bus(), acts) + scale * term.coefficient * 12.0 * 2.5 * factor
    assert getattr(bus, acts) == pytest.approx(expected if point.name != "brake" else max(expected, 0.0))
    changed = {name for name, found in vars(bus).items() if found != getattr(a_bus(), name)}
    assert changed == {acts}
    assert memory.h == pytest.approx(slow if kind else 0.2)


def test_a_term_of_size_nought_does_nothing_and_memory_waits_for_the_log_to_begin() -> None:
    term = Term(AT["accel"], Form((), ("v",), "lag"), c=0.0)
    memory = SimpleNamespace(h=0.2)
    assert vars(played(term, memory, a_bus())) == vars(a_bus())
    assert memory.h == 0.2
    one = Term(AT["accel"], Form((), ("v",), "lag"), c=1.0, tau=0.4)
    settling = played(one, memory, a_bus(settle=1.0))
    assert (memory.h, settling.accel) == (0.2, pytest.approx(1.5 + one.coefficient * 0.2))
    much = Term(AT["brake"], Form(("v",)), c=-100.0)
    assert played(much, memory, a_bus()).brake == 0.0


def test_generic_effects_are_three_of_each_slot_and_come_last() -> None:
    assert list(GENERIC) == [f"term_{slot}_{k}" for slot in ("command", "force", "body", "sensor") for k in range(3)]
    shows, late = {"body_roll"}, {effect.slot: effect.order for effect in GENERIC.values()}
    assert all(effect.order < late[effect.slot] for effect in catalogue().values() if effect.slot in late
               and effect.name not in shows)  # fmt: skip
    assert late["body"] < catalogue()["body_roll"].order  # which shows the sway under all forces
    assert {effect.slot for effect in GENERIC.values() if effect.tyres} == {"body"}
    keys = {key.name: key for key in GENERIC["term_body_2"].parameters}
    assert {name for name, key in keys.items() if (key.low, key.high) == (0.0, 20.0)} == {
        "point", "g1", "g2", "g3", "h1", "h2", "filter",
    }  # fmt: skip
    assert (keys["tau"].low, keys["tau"].high, keys["v0"].low, keys["v0"].high) == (0.02, 100.0, 0.0, 30.0)


@pytest.mark.parametrize("point", POINTS, ids=lambda p: p.name)
@pytest.mark.parametrize("kind", ["", "lag", "highpass"])
def test_the_file_of_a_law_does_the_same_as_the_search_did(point: Any, kind: Any) -> None:
    form = Form(("v", "tanh(r)"), ("(v - v0)+", "ax"), kind) if kind else Form(("v", "tanh(r)", "(v - v0)+"))
    term = Term(point, form, c=0.8, tau=0.4, v0=4.0)
    effect = written(term)
    neutral = {key.name: key.neutral for key in effect.parameters}
    p = SimpleNamespace(**(neutral | {"c1": term.coefficient}))
    one, other = SimpleNamespace(h=0.2), SimpleNamespace(h1=0.2)
    expected, found = played(term, one, a_bus()), a_bus()
    effect.function(found, p, other)
    assert vars(found) == pytest.approx(vars(expected))
    assert other.h1 == pytest.approx(one.h)
    assert (effect.slot, effect.tyres) == (point.slot, point.slot == "body")


def shown(terms: tuple[Term, ...], own: tuple[Effect, ...] = (), values: Any = None) -> tuple[Any, Any]:
    """What a log shows of a car with offset steering and a body that rolls: by the terms of a search, and by the file
    that is written of them; own: effects of the user's own, with these `values`."""
    model = parse_model(
        '[model]\nbase = "dynamic_bicycle"\n[parameters]\nwheelbase = 2.6\n'
        '[[effect]]\nname = "steer_offset"\nparameters = { offset = 0.03 }\n'
        '[[effect]]\nname = "body_roll"\nparameters = { gain = 0.2 }\n'
    )
    law = Law("LAW", tuple(FoundTerm(term, -1.0, 1.0) for term in terms), (), (3.0, 2.0), (1.0, 1.0), ())
    space: dict[str, Any] = {}
    exec(effect_text(law, fitted=["a.csv"], held_out=["b.csv"], beside=own), space)  # noqa: S102
    file = [e for e in space.values() if isinstance(e, Effect)]
    assert {e.name for e in file} == set(law_names(law, own))
    t = np.arange(0.0, 10.0, 0.02)
    commands = {"steer_cmd": 0.1 * np.sin(t), "accel_cmd": np.where(t < 5.0, 2.0, 0.3 * np.sin(t))}
    replay = Replay(model, t, commands, extra=[*GENERIC.values(), *file, *own])
    as_file = {(e.name, f"c{k + 1}"): term.coefficient for e in file for k, term in enumerate(terms)}
    return replay.run({**values_of(terms), **(values or {})}), replay.run({**as_file, **(values or {})})


@pytest.mark.parametrize("point", ["steer", "fy_front"])
def test_the_file_sees_the_same_steering_and_its_forces_sway_the_same_body(point: str) -> None:
    searched, by_file = shown((Term(AT[point], Form(("d", "d", "d")), c=-20.0),))
    assert by_file == pytest.approx(searched, abs=1e-9)


def test_a_second_law_at_a_point_has_another_name_and_comes_after_the_first() -> None:
    """The first one halves the angle, and the second reads what it left."""

    def half(x: Any, p: Any, m: Any) -> None:
        x.steer *= 1.0 - p.c

    first = Effect(
        name="law_steer", slot="command", physics="", equation="", source="", reveals="", order=92, function=half,
        parameters=(Key("c", "-", 0.0, 1.0, neutral=0.0, least=0.01),),
    )  # fmt: skip
    second = (Term(AT["steer"], Form(("d", "v")), c=1.0),)
    searched, by_file = shown(second, (first,), {("law_steer", "c"): 0.5})
    assert by_file == pytest.approx(searched, abs=1e-9)
    law = a_law(terms=(FoundTerm(second[0], 0.0, 1.0),))
    assert law_names(law) == ("law_steer",)
    assert law_names(law, (first,)) == ("law_steer_2",)


def a_law(**given: Any) -> Law:
    term = Term(AT["steer"], Form(("a-",), ("v", "a-"), "lag"), c=2.0, tau=2.0)
    step = Term(AT["drag"], Form(("(v - v0)+",)), c=1.0, v0=9.0)
    fields: dict[str, Any] = {
        "verdict": "STAND_IN", "terms": (FoundTerm(term, -0.001, 0.003), FoundTerm(step, 0.01, 0.04, ("v v",))),
        "points": ("drag", "brake"), "before": (3.0, 5.0), "after": (1.5, 2.0), "reasons": ("because",),
        "decides": "a drive",
    }  # fmt: skip
    return Law(**(fields | given))


def test_the_file_of_a_law_has_ranges_about_what_was_found() -> None:
    text = effect_text(a_law(), fitted=["a.csv", "c.csv"], held_out=["b.csv"])
    assert '"""d += ' in text
    assert "Found by dvp discover in a.csv, c.csv: a stand-in, whose form is not proven." in text
    assert "takes away 75% of the error beyond the noise\nthere, and 75% on b.csv." in text
    space: dict[str, Any] = {}
    exec(text, space)  # noqa: S102
    effects = {e.name: e for e in space.values() if isinstance(e, Effect)}
    assert set(effects) == set(law_names(a_law())) == {"law_steer", "law_drag"}
    keys = {key.name: key for key in effects["law_steer"].parameters}
    assert (keys["c1"].low, keys["c1"].high, keys["c1"].neutral) == (pytest.approx(-0.009), pytest.approx(0.009), 0.0)
    assert keys["c1"].least == pytest.approx(0.00018)
    assert (keys["tau1"].low, keys["tau1"].high, keys["tau1"].neutral, keys["tau1"].least) == (0.4, 10.0, 2.0, 0.1)
    keys = {key.name: key for key in effects["law_drag"].parameters}
    assert (keys["v0_1"].low, keys["v0_1"].high, keys["v0_1"].neutral) == (0.0, 28.0, 9.0)
    assert (keys["c1"].high, keys["c1"].unit) == (pytest.approx(3.0 * 0.04), "1/s")
    proven = effect_text(a_law(verdict="LAW"), fitted=["a.csv"], held_out=["b.csv"])
    assert "a.csv: a law. It" in proven
    assert "tanh" not in proven
    assert "tyres" not in proven


def test_a_command_remembers_only_from_where_the_log_begins() -> None:
    term = Term(AT["steer"], Form((), ("v",), "lag"), c=1.0, tau=0.4)
    effect, memory = written(term), SimpleNamespace(h1=0.2)
    p = SimpleNamespace(c1=1.0, tau1=0.4)
    effect.function(a_bus(settle=1.0), p, memory)
    assert memory.h1 == 0.2


def test_terms_of_one_slot_are_one_effect() -> None:
    terms = (Term(AT["ay"], Form(("r",))), Term(AT["yaw"], Form(("d",))), Term(AT["steer"], Form(("d",)), c=0.26))
    pair = a_law(terms=tuple(FoundTerm(term, 0.0, 1.0) for term in terms))
    assert law_names(pair) == ("law_steer", "law_ay_yaw")
    assert equation(pair.terms[2:]) == "d += 0.026 d"
    assert equation(pair.terms[:1]) == f"ay shown += {0.1 / 0.3:.4g} r"
    lagged = a_law().terms
    assert equation(lagged) == "d += 0.0005 a- lag(v a-), tau = 2 s; F_x/m += 0.02 (v - v0)+, v0 = 9 m/s"


def test_what_a_law_removes_is_a_share_of_the_error_beyond_the_noise() -> None:
    assert a_law().removed == pytest.approx((0.75, 0.75))
    assert a_law(before=(1.0, 0.9), after=(0.5, 0.8)).removed == (0.0, 0.0)
    assert a_law(before=(2.0, 2.0), after=(0.5, 1.0)).removed == (1.0, 1.0)
    document = a_law().as_dict("law.py")
    assert document["error"] == {"fit": {"before": 3.0, "after": 1.5, "removed": 0.75},
                                 "held_out": {"before": 5.0, "after": 2.0, "removed": 0.75}}  # fmt: skip
    assert [set(term) >= {"tau"} for term in document["terms"]] == [True, False]
    assert document["terms"][1]["v0"] == {"value": 9.0, "unit": "m/s"}
    assert document["terms"][0]["tau"] == {"value": 2.0, "unit": "s"}
    assert (document["verdict"], document["file"], document["decides"]) == ("STAND_IN", "law.py", "a drive")


def test_what_is_said_of_a_law() -> None:
    lines = discovery_lines(a_law(), "law.py", "car.toml", ["a b.csv"], ["b.csv"])
    assert lines[0].startswith("STAND_IN: d += 0.0005")
    assert lines[0].endswith("(this removes the error, but its form is not proven)")
    assert lines[2] == "  a- lag(v a-) on the steering path (steer): c = 0.000500 s^5 rad/m^3 (-0.00100 to 0.00300)"
    assert lines[4] == "    in this car the same as v v"
    assert lines[5:7] == ["  chi²/N fitted    3.00 -> 1.50 (75% of the error beyond the noise)",
                          "  chi²/N held out  5.00 -> 2.00 (75%)"]  # fmt: skip
    assert lines[8:11] == ["these data cannot tell at which of these it acts: drag, brake", "because",
                           "a drive that would tell more: a drive"]  # fmt: skip
    assert "--effects law.py --add law_steer law_drag" in lines[11]
    assert lines[11].endswith("--fit 'a b.csv' --held-out b.csv --out car.extended.toml")
    short = discovery_lines(
        a_law(verdict="LAW", points=("drag",), reasons=(), decides=""), None, "car.toml", ["a.csv"], ["b.csv"]
    )
    assert short[0].endswith("(this form explains the error)")
    assert short[-1] == ""
    assert discovery_lines(a_law(verdict="NO_LAW"), "law.py", "car.toml", ["a b.csv"], ["b.csv"]) == ["NO_LAW: because"]


@pytest.mark.parametrize("name", ['a """quoted""".csv', "run\\user\\N.csv"])
def test_an_effect_file_is_python_whatever_the_logs_are_called(name: str) -> None:
    space: dict[str, Any] = {}
    exec(effect_text(a_law(), fitted=[name], held_out=[name]), space)  # noqa: S102
    assert f"discover in {name}: " in space["__doc__"]
