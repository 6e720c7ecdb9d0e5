"""How a term of a law acts at each point of a car, and how much more than noise a residual holds: by hand."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.compare.segments import CHANNELS
from pytest_dvp.gap.discover import generic_effect
from pytest_dvp.gap.discover.generic_effect import effect_of, generic_effects, values_of
from pytest_dvp.gap.discover.law import Law
from pytest_dvp.gap.discover.noise_left import beyond_noise, settle
from pytest_dvp.gap.discover.term import POINTS, Form, Term

V = CHANNELS.index("v")


@pytest.fixture(autouse=True)
def numbers(monkeypatch: pytest.MonkeyPatch) -> None:
    """Factor 0 is 1, factor k is k + v0 / 10."""
    monkeypatch.setattr(generic_effect, "value", lambda x, k, v0: k + 0.1 * v0 if k else 1.0)


def parameters(**given: float) -> Any:
    base = {"point": 0.0, "g1": 0.0, "g2": 0.0, "g3": 0.0, "h1": 0.0, "h2": 0.0, "filter": 0.0, "c": 1.0, "tau": 1.0,
            "v0": 0.0}  # fmt: skip
    return SimpleNamespace(**{**base, **given})


def term(p: Any, *, settles: bool = False, before: float = 0.5, dt: float = 0.1) -> tuple[float, float]:
    """The term, and its memory after."""
    m = SimpleNamespace(h=before)
    found = generic_effect._term(SimpleNamespace(settle=1.0 if settles else 0.0, dt=dt), p, m)
    return found, m.h


def test_a_term_is_the_product_of_its_coefficient_and_all_of_its_factors() -> None:
    assert term(parameters(c=2.0, g1=3, g2=5, g3=7, h1=11, h2=13))[0] == 2.0 * 3 * 5 * 7 * 11 * 13
    assert term(parameters(c=2.0, g1=3, v0=5.0))[0] == 7.0
    assert term(parameters(c=2.0, h1=3, v0=5.0))[0] == 7.0
    assert term(parameters(c=0.0, g1=3, filter=1.0))[0:2] == (0.0, 0.5)


def test_what_is_inside_a_filter_comes_late_or_passes_only_while_it_changes() -> None:
    """From 0.5 towards 6 with a time constant of 0.2 s for 0.1 s."""
    late = 6.0 - 5.5 * math.exp(-0.5)
    p = {"c": 2.0, "g1": 3.0, "h1": 2.0, "h2": 3.0, "tau": 0.2}
    assert term(parameters(**p, filter=1.0)) == pytest.approx((6.0 * late, late))
    assert term(parameters(**p, filter=2.0)) == pytest.approx((6.0 * (6.0 - late), late))
    assert term(parameters(**p, filter=1.0), settles=True) == pytest.approx((3.0, 0.5))  # its memory waits
    assert term(parameters(**p, filter=0.0)) == (36.0, 0.5)


@pytest.mark.parametrize(
    ("slot", "point", "field", "size"),
    [
        ("command", 0.0, "steer", 1.0),
        ("command", 1.0, "accel", 1.0),
        ("force", 0.0, "drag", 1000.0),  # by the mass for which accelerations hold
        ("force", 1.0, "brake", 1000.0),
        ("body", 0.0, "yaw_moment", 1500.0),  # by the yaw inertia
        ("body", 1.0, "fy_front", 1200.0),  # by the mass
        ("body", 2.0, "fy_rear", 1200.0),
        ("sensor", 0.0, "meas_v", 1.0),
        ("sensor", 1.0, "meas_yaw_rate", 1.0),
        ("sensor", 2.0, "meas_ax", 1.0),
        ("sensor", 3.0, "meas_ay", 1.0),
        ("sensor", 4.0, "meas_yaw", 1.0),
    ],
)
def test_a_term_is_added_at_its_point_in_the_unit_of_it(slot: str, point: float, field: str, size: float) -> None:
    fields = ("steer", "accel", "drag", "brake", "yaw_moment", "fy_front", "fy_rear", "meas_v", "meas_yaw_rate",
              "meas_ax", "meas_ay", "meas_yaw")  # fmt: skip
    x = SimpleNamespace(
        settle=0.0, dt=0.1, mass_ref=1000.0, mass=1200.0, yaw_inertia=1500.0, **dict.fromkeys(fields, 0.25)
    )
    generic_effect._FUNCTIONS[slot](x, parameters(point=point, c=3.0), SimpleNamespace(h=0.0))
    assert {name: getattr(x, name) for name in fields} == {**dict.fromkeys(fields, 0.25), field: 0.25 + 3.0 * size}


def test_a_brake_never_drives() -> None:
    x = SimpleNamespace(settle=0.0, dt=0.1, mass_ref=1000.0, brake=500.0)
    generic_effect._force(x, parameters(point=1.0, c=-0.25), SimpleNamespace(h=0.0))
    assert x.brake == 250.0
    generic_effect._force(x, parameters(point=1.0, c=-3.0), SimpleNamespace(h=0.0))
    assert x.brake == 0.0


def test_there_are_three_terms_of_each_slot_after_all_that_is_known() -> None:
    effects = {e.name: e for e in generic_effects()}
    slots = {point.slot for point in POINTS}
    assert set(effects) == {f"term_{slot}_{k}" for slot in slots for k in range(3)}
    assert all(e.tyres == (e.slot == "body") for e in effects.values())
    keys = {k.name: k for k in effects["term_force_0"].parameters}
    assert (keys["c"].neutral, keys["tau"].low, keys["tau"].high, keys["tau"].minimum) == (0.0, 0.02, 100.0, 1e-3)
    assert all(keys[name].neutral == 0.0 for name in ("point", "g1", "g2", "g3", "h1", "h2", "filter"))
    steer = next(point for point in POINTS if point.slot == "command")
    law = (Term(steer, Form(("v",)), c=1.0), Term(steer, Form(("d",)), c=2.0))
    assert [effect_of(one, k) for k, one in enumerate(law)] == ["term_command_0", "term_command_1"]
    assert {name for name, _ in values_of(law)} == {"term_command_0", "term_command_1"}


# --- how much is left


def alternating(rows: int, size: float, *, offset: float = 0.0, channels: Any = ("v",)) -> Any:
    """A residual of `size` to either side of `offset`; its third differences are 8 times as large, and 64 / 20 of its
    variance is taken for that of the noise."""
    rest = np.full((rows, 8), np.nan)
    rest[:, V] = offset + size * (-1.0) ** np.arange(rows)
    return SimpleNamespace(residuals=lambda values: SimpleNamespace(values=rest), white=lambda found: found.ravel(),
                           channels=channels)  # fmt: skip


@pytest.mark.parametrize("size", [0.1, 1.0, 7.0])
def test_what_is_left_is_told_in_units_of_the_noise_that_it_shows(size: float) -> None:
    data: Any = SimpleNamespace(experiments=[alternating(100, size, offset=2.0 * size)])
    assert beyond_noise(data, {}) == pytest.approx(5.0 * 20.0 / 64.0)  # 4 of the offset and 1


@pytest.mark.parametrize(("rows", "left"), [(52, 4.0), (53, 20.0 / 64.0)])
def test_fifty_differences_tell_a_level(rows: int, left: float) -> None:
    """Of 52 rows there are 49 third differences: the noise is taken as it was said to be."""
    data: Any = SimpleNamespace(experiments=[alternating(rows, 2.0)])
    assert beyond_noise(data, {}) == pytest.approx(left)


def test_all_channels_of_all_logs_count_by_their_samples() -> None:
    short, long = alternating(20, 2.0), alternating(60, 1.0)
    both: Any = SimpleNamespace(experiments=[short, long])
    assert beyond_noise(both, {}) == pytest.approx((20 * 4.0 + 60 * 20.0 / 64.0) / 80.0)
    none: Any = SimpleNamespace(experiments=[alternating(20, 2.0, channels=())])
    assert beyond_noise(none, {}) == 0.0


@pytest.mark.parametrize(("after", "moved"), [(2.9, True), (3.0, True), (3.1, False)])
def test_segments_begin_elsewhere_where_that_leaves_no_more(after: float, moved: bool) -> None:
    class Settling:
        segments = "before"

        def whitened(self, values: Any) -> Any:
            return np.array([3.0 if self.segments == "before" else after])

        def settle(self, values: Any) -> None:
            self.segments = "after"

    one = Settling()
    settle(SimpleNamespace(experiments=[one]), {})  # type: ignore[arg-type]
    assert one.segments == ("after" if moved else "before")


@pytest.mark.parametrize(
    ("before", "after", "removed"),
    [
        ((3.0, 2.0), (2.0, 1.0), (0.5, 1.0)),
        ((3.0, 1.0), (0.5, 0.5), (1.0, 0.0)),
        ((3.0, 2.0), (5.0, 2.5), (-1.0, -0.5)),
    ],
)
def test_what_a_law_removes_is_a_share_of_what_was_beyond_the_noise(before: Any, after: Any, removed: Any) -> None:
    law = Law("LAW", (), (), before, after, ())
    assert law.removed == pytest.approx(removed)
    error = law.as_dict("law.py")["error"]
    assert error["held_out"] == {"before": before[1], "after": after[1], "removed": pytest.approx(removed[1])}
    assert error["fit"]["before"] == before[0]
