"""The terms that may explain an error, each against the sentence by which it reads."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.compare.smoothed_motion import Motion
from pytest_dvp.gap.diagnose.residual_terms import CREEPING, CROSSED, RINGING, Term, _passed, _rings, _shifted, terms
from pytest_dvp.logs.log_contents import FloatArray

RNG = np.random.default_rng(3)
N = 240
STEP = 0.05
T = STEP * np.arange(N)


def a_motion(**given: Any) -> Motion:
    """12 s in which everything varies; the first 20 rows stand."""
    fields: dict[str, Any] = {
        "t": T, "step": STEP, "x": 0.0 * T, "y": 0.0 * T, "yaw": 0.3 * T, "v": 6.0 + 5.0 * np.sin(0.7 * T) + 0.1 * T,
        "yaw_rate": 0.4 * np.cos(1.1 * T), "accel": 2.0 * np.sin(0.9 * T + 0.4), "steer": 0.2 * np.sin(1.3 * T - 0.2),
        "moving": np.arange(N) >= 20, "way": 6.0 * T + T**2, "braked": 1.5 * T, "driven": 2.5 * T, "wheelbase": 2.5,
    }  # fmt: skip
    return Motion(**(fields | given))


def named(found: list[Term]) -> dict[tuple[str, str], FloatArray]:
    columns = {(term.key, term.name): term.columns for term in found if "levelling off" not in term.name}
    assert len(columns) == len(found) - sum("levelling off" in term.name for term in found)
    return columns


def at(m: Motion, y: FloatArray, late: float) -> FloatArray:
    """y as it was `late` [s] ago, between its samples on straight lines."""
    rows = np.clip((m.t - late) / m.step, 0.0, None)
    low = np.floor(rows + 1e-9).astype(int)
    share = rows - low
    return np.asarray((1.0 - share) * y[low] + share * y[np.minimum(low + 1, len(y) - 1)])


def held(found: dict[tuple[str, str], FloatArray], key: str, name: str, *columns: FloatArray) -> None:
    assert found.pop((key, name)) == pytest.approx(np.column_stack(columns), abs=1e-9), name


def test_a_term_of_the_steering_is_called_after_the_signal_that_steers() -> None:
    """A model on the measured road-wheel angle follows no command."""
    names = {term.name for term in terms("lateral", [a_motion()], [], "steer")[0]}
    assert {"steer", "steer^3", "v steer"} <= names
    assert not any("steer_cmd" in name for name in names)


def test_terms_of_a_longitudinal_error_are_what_their_names_say() -> None:
    m = a_motion()
    assert m.accel is not None
    every = terms("longitudinal", [m], [])[0]
    found = named(every)
    one = m.moving.astype(float)
    v, ay, a = m.v, m.v * m.yaw_rate, m.accel * one
    drive, brake = np.where(a > 0.0, a, 0.0), np.where(a < 0.0, a, 0.0)
    held(found, "speed", "v", one, v * one)
    held(found, "speed_squared", "v^2", one, v * abs(v))
    held(found, "cornering", "|ay|", abs(ay))
    held(found, "cornering_squared", "ay^2", ay**2)
    held(found, "drive_command", "a_cmd > 0", drive)
    held(found, "brake_command", "a_cmd < 0", brake)
    held(found, "command_rate", "d a_cmd/dt", (m.accel - at(m, m.accel, 0.1)) * one,
         (m.accel - at(m, m.accel, 0.4)) * one)  # fmt: skip
    held(found, "coasting", "pedals released", one * (abs(m.accel) < 0.05))
    for side, size in (("drive", drive), ("brake", brake)):
        sign = ">" if side == "drive" else "<"
        held(found, f"{side}_by_speed", f"v a_cmd {sign} 0", size, v * size)
        held(found, f"{side}_by_size", f"a_cmd^2 {sign} 0", size, size**2)
        held(found, f"{side}_by_time", f"t a_cmd {sign} 0", size, T * size)
    for key, energy, words, size in (("brake_heat", m.braked, "energy braked away", brake),
                                     ("drive_energy", m.driven, "energy spent", drive)):  # fmt: skip
        held(found, key, words, size, energy * size)
        rest = [term.columns for term in every if term.name == f"{words}, levelling off" and term.key == key]
        for columns, share in zip(rest, (0.15, 0.5), strict=True):
            level = 1.0 - np.exp(-energy / (share * energy[-1]))
            assert columns == pytest.approx(np.column_stack([size, level * size]))
    assert CREEPING == (1.5, 2.5, 4.0)
    for slow in CREEPING:
        near = np.where(v < slow, 1.0 - v / slow, 0.0)
        held(found, "creeping", f"below {slow:g} m/s without brake", near * (m.accel > -0.3))
        held(found, "creeping_any", f"below {slow:g} m/s", near * one)
    held(found, "constant", "constant", one)
    held(found, "time", "t", one, T * one)
    held(found, "heading", "heading", np.cos(m.yaw) * one, np.sin(m.yaw) * one)
    assert RINGING == (0.8, 1.2, 1.8, 2.5, 3.5, 5.0)
    for f in RINGING:
        held(found, "drive_rings", f"a_cmd rings at {f:g} Hz", _rings(m, m.accel, f) * one)
    passed = {name for key, name in found if key == "speed_passed"}
    speeds = [speed for speed in range(2, 36) if speed < v.max()]
    assert passed == {f"the {span:g} s after passing {speed:g} m/s" for speed in speeds for span in (0.25, 0.5, 1.0)}
    held(found, "speed_passed", "the 0.5 s after passing 9 m/s", _passed(m, 9.0, 0.5) * drive)
    assert {key for key, _ in found} == {"speed_passed"}
    assert (CROSSED[0], CROSSED[-1], len(CROSSED)) == (2.0, 35.0, 34)


def test_terms_of_a_lateral_error_are_what_their_names_say() -> None:
    m = a_motion()
    assert m.accel is not None
    assert m.steer is not None
    found = named(terms("lateral", [m], [])[0])
    one, ay, a, d = m.moving.astype(float), m.v * m.yaw_rate, m.accel, m.steer
    held(found, "offset", "offset", one)
    held(found, "lateral_acceleration", "ay", ay)
    held(found, "lateral_acceleration_cubed", "ay^3", ay, ay**3)
    held(found, "accel_steer", "a_cmd", a * one)
    held(found, "brake_pull", "a_cmd < 0", np.where(a < 0.0, a, 0.0) * one)
    held(found, "torque_steer", "a_cmd > 0", np.where(a > 0.0, a, 0.0) * one)
    held(found, "steer_command", "steer_cmd", d)
    held(found, "steer_size", "|steer_cmd|", d, abs(d))
    held(found, "steer_cubed", "steer_cmd^3", d, d**3)
    held(found, "steer_rate", "d steer_cmd/dt", d - at(m, d, 0.1), d - at(m, d, 0.3))
    held(found, "steer_side", "sign of d steer_cmd/dt", np.tanh((d - at(m, d, 0.1)) / 0.1 / 0.02))
    held(found, "steer_by_speed", "v steer_cmd", d, m.v * d)
    held(found, "steer_by_speed_squared", "v^2 steer_cmd", d, m.v**2 * d)
    held(found, "steer_by_time", "t steer_cmd", d, T * d)
    for f in RINGING:
        held(found, "steer_rings", f"steer_cmd rings at {f:g} Hz", d - at(m, d, 0.1), _rings(m, d, f))
    assert {key for key, _ in found} == {"constant", "time", "heading"}


def test_without_a_command_what_follows_it_is_not_tried() -> None:
    bare = a_motion(accel=None, steer=None)
    along = {term.key for term in terms("longitudinal", [bare], [])[0]}
    assert along == {"speed", "speed_squared", "cornering", "cornering_squared", "constant", "time", "heading"}
    across = {term.key for term in terms("lateral", [bare], [])[0]}
    assert across == {"offset", "lateral_acceleration", "lateral_acceleration_cubed", "constant", "time", "heading"}
    steered = {term.key for term in terms("lateral", [a_motion(accel=None)], [])[0]}
    assert "steer_command" in steered
    assert "brake_pull" not in steered


def test_every_log_has_the_same_terms_on_the_scale_of_the_longest() -> None:
    """Heat levels off over a share of the most that any log has, speeds are passed up to the fastest of any log."""
    short, long = a_motion(braked=1.0 * T, v=3.5 + 0.0 * T), a_motion(braked=4.0 * T)
    assert short.accel is not None
    both = terms("longitudinal", [short, long], [])
    assert [t.name for t in both[0]] == [t.name for t in both[1]]
    heat = [t.columns[:, -1] for t in both[0] if t.name == "energy braked away, levelling off"]
    brake = np.minimum(short.accel, 0.0) * short.moving
    for column, share in zip(heat, (0.15, 0.5), strict=True):
        assert column == pytest.approx((1.0 - np.exp(-T / (share * 4.0 * T[-1]))) * brake)


def test_a_wave_has_a_phase_of_its_own_in_each_log() -> None:
    logs = [a_motion(), a_motion(way=3.0 * T)]
    found = terms("lateral", logs, [("time", 1.25), ("distance", 0.1234)])
    for place, m in enumerate(logs):
        by_name = named(found[place])
        for key, name, phase in (("wave_time", "wave at 1.25 Hz", 2.0 * np.pi * 1.25 * T),
                                 ("wave_distance", "wave at 0.123 1/m", 2.0 * np.pi * 0.1234 * m.way)):  # fmt: skip
            columns = by_name[key, name]
            assert columns.shape == (N, 4)
            expected = np.zeros((N, 4))
            expected[:, 2 * place : 2 * place + 2] = np.column_stack([np.cos(phase), np.sin(phase)])
            expected[:20] = 0.0
            assert columns == pytest.approx(expected)


def test_what_was_earlier_is_on_straight_lines_and_before_the_start_the_first_value() -> None:
    m = a_motion(t=np.arange(4.0), step=1.0)
    y = np.array([2.0, 4.0, 8.0, 0.0])
    assert _shifted(m, y, 0.5) == pytest.approx([2.0, 3.0, 6.0, 4.0])


@pytest.mark.parametrize(("lowest", "again"), [(3.76, False), (3.74, True)])
def test_a_speed_is_passed_upward_and_again_only_after_it_was_a_quarter_lower(lowest: float, again: bool) -> None:
    v = np.array([4.0, 6.0, 6.0, 6.0, 4.9, lowest, 4.9, 6.0, 6.0, 6.0])
    m = a_motion(t=np.arange(10.0), step=1.0, v=v)
    shown = [0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, *([1.0, 1.0] if again else [0.0, 0.0]), 0.0]
    assert _passed(m, 5.0, 2.0).tolist() == shown


def test_a_speed_that_is_exceeded_from_the_start_was_not_passed() -> None:
    m = a_motion(t=np.arange(6.0), step=1.0, v=np.array([6.0, 6.0, 6.0, 1.0, 5.0, 6.0]))
    assert _passed(m, 5.0, 1.0).tolist() == [0.0, 0.0, 0.0, 0.0, 1.0, 0.0]
    down = a_motion(t=np.arange(4.0), step=1.0, v=np.array([6.0, 6.0, 4.0, 3.0]))
    assert _passed(down, 5.0, 1.0).tolist() == [0.0] * 4


def test_what_rings_answers_a_step_as_a_damped_oscillator() -> None:
    """x(t) of x'' + 2 D w x' + w^2 x = w^2 u for a step of u, less the step itself, with a step of integration that is
    short beside the period; before the step there is nothing."""
    step, hertz, damping = 0.001, 1.2, 0.25
    t = step * np.arange(3000)
    u = np.where(t < 0.5, 3.0, 5.0)
    m = a_motion(t=t, step=step)
    w = 2.0 * np.pi * hertz
    wd, tau = w * np.sqrt(1.0 - damping**2), t - 0.5
    swing = np.exp(-damping * w * tau) * (np.cos(wd * tau) + damping * w / wd * np.sin(wd * tau))
    expected = np.where(tau < 0.0, 0.0, -2.0 * swing)
    found = _rings(m, u, hertz)
    assert found[:499] == pytest.approx(0.0, abs=1e-12)
    assert found[502:] == pytest.approx(expected[502:], abs=0.02)
    coarse = a_motion(t=0.05 * np.arange(100), step=0.05)
    v = np.where(coarse.t < 0.01, 0.0, 1.0)
    p, k = 2.0 * np.pi * 2.5, 40.0  # the bilinear rule s = k (z - 1)/(z + 1), written as its recursion
    x = np.zeros(100)
    for i in range(1, 100):
        x1, x2, u2 = x[i - 1], x[i - 2] if i > 1 else 0.0, v[i - 2] if i > 1 else 0.0
        side = p * p * (v[i] + 2.0 * v[i - 1] + u2) - 2.0 * (p * p - k * k) * x1 - (k * k - 0.5 * p * k + p * p) * x2
        x[i] = side / (k * k + 0.5 * p * k + p * p)
    assert _rings(coarse, v, 2.5) == pytest.approx(x - v, abs=1e-9)
