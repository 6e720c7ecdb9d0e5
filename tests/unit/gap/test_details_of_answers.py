"""Details of an answer: what a run has of its own, which of several logs tells an effect, how a remainder lasts."""

from __future__ import annotations

import dataclasses
import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.compare.segments import CHANNELS
from pytest_dvp.gap.diagnose.diagnosis import Diagnosis, Estimate, NamedEffect, Step
from pytest_dvp.gap.diagnose.lasting_remainder import LastingRemainder
from pytest_dvp.gap.perception import diagnose_perception
from pytest_dvp.gap.words.diagnosis import setup_lines
from pytest_dvp.logs.log import Log
from vehicle.model.remainder_shape import RemainderShape


def effect(name: str, gain: float, width: float, value: float = 1.0) -> NamedEffect:
    return NamedEffect(name, {"p": Estimate(value, 1.0, 1.0 + width, "m")}, gain=gain)


def test_of_several_logs_the_narrowest_interval_tells_an_effect_and_what_gains_most_comes_first(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    answers = {
        "one": (effect("offset", 0.2, 0.5), effect("noise", 0.5, 0.3)),
        "two": (effect("offset", 0.3, 0.4), effect("noise", 0.9, 0.3), effect("latency", 0.5, 0.1)),
        "three": (effect("offset", 0.8, 0.6), effect("latency", 0.6, 0.0, math.nan)),
    }
    twins: list[Any] = []

    def one(measured: Any, model: Any, twin: Any = None) -> tuple[NamedEffect, ...]:
        twins.append(twin)
        return answers[measured.meta.get("scenario", "three")]

    monkeypatch.setattr(diagnose_perception, "diagnose_perception", one)
    logs: Any = [SimpleNamespace(meta={"scenario": name}) for name in ("one", "two")] + [SimpleNamespace(meta={})]
    told = diagnose_perception.diagnose_perceptions(logs, None, {"two": "twin"})  # type: ignore[arg-type, dict-item]
    assert [(e.name, e.gain) for e in told] == [("latency", 0.5), ("noise", 0.5), ("offset", 0.3)]
    assert twins == [None, "twin", None]


STEP = Step("", 1.0, {}, {}, 1.0, {}, (1.0,), (1.0,))
DIAGNOSIS = Diagnosis("NOTHING_MISSING", (), (), (STEP,), {}, {})


def test_what_is_of_the_run_is_told_with_the_values_of_each_held_out_run() -> None:
    assert setup_lines(DIAGNOSIS) == []
    runs = ({("gyro_bias", "b"): 0.01234, ("steer_offset", "d"): -0.5}, {})
    last = dataclasses.replace(STEP, held_out_setups=runs)
    named = effect("gyro_bias", 0.5, 0.1), effect("mass", 0.3, 0.1), effect("steer_offset", 0.2, 0.1)
    lines = setup_lines(dataclasses.replace(DIAGNOSIS, effects=named, ladder=(STEP, last)))
    assert lines[0].startswith("gyro_bias and steer_offset: of the run, not of the car")
    assert lines[1:] == ["held out: gyro_bias.b = 0.0123, steer_offset.d = -0.500", "held out: none of them"]


@pytest.mark.parametrize(
    ("there", "of_the_run"),
    [(0.0020, True), (0.0022, False), (0.0042, False), (0.0062, False), (0.0064, True), (-0.0042, True)],
)
def test_a_zero_that_another_run_has_as_well_is_the_cars(there: float, of_the_run: bool) -> None:
    zero = NamedEffect("steer_offset", {"offset": Estimate(0.0042, 0.004, 0.0044, "rad")})
    last = dataclasses.replace(STEP, held_out_setups=({("steer_offset", "offset"): there}, {}))
    found = dataclasses.replace(DIAGNOSIS, effects=(zero, effect("mass", 0.3, 0.1)), ladder=(STEP, last))
    assert found.set_up == (("steer_offset",) if of_the_run else ())


class White:
    """Noise that does not repeat."""

    def __init__(self, independent: float = 1.0) -> None:
        self.independent = np.full(8, independent)

    def scaled(self, noise: Any) -> White:
        return self

    def of(self, rest: Any, begins: Any) -> Any:
        return rest.copy()


def lasting(
    remainder: Any, memory: dict[str, float], independent: float = 1.0, wanders: Any = None
) -> LastingRemainder:
    """A car that stands for 2 s and then drives 6 s at a constant speed."""
    t = 0.02 * np.arange(400)
    v = np.where(t < 2.0, 0.0, 8.0)
    measured = np.full((400, 8), np.nan)
    measured[:, 3], measured[:, 4] = v, 0.0
    if wanders:
        measured[:, 2] = 0.3
    coloured: Any = White(independent)
    shape = RemainderShape(memory, wanders=wanders or {})
    return LastingRemainder(Log({"t": t, "v": v}), measured, remainder, shape, np.ones(8), coloured,
                            np.arange(400) == 0)  # fmt: skip


def test_position_heading_and_speed_remember_for_a_second_and_the_rest_for_0_3_if_nothing_else_is_stated() -> None:
    kept = lasting({}, {"ax": 0.5, "v": 2.0})._kept
    memory = {"x": 1.0, "y": 1.0, "yaw": 1.0, "v": 2.0, "yaw_rate": 0.3, "ax": 0.5, "ay": 0.3, "steer": 0.3}
    assert kept == pytest.approx([math.exp(-0.02 / memory[channel]) for channel in CHANNELS])
    assert lasting({}, {})._kept[CHANNELS.index("v")] == pytest.approx(math.exp(-0.02))


def test_the_level_is_that_of_the_regimes_a_sample_is_in_and_what_whitens_the_noise_passes_less_of_it() -> None:
    found = lasting({"v": {"standstill": 0.5, "cruise": 0.2, "launch": 0.3}}, {})._levels
    k = CHANNELS.index("v")
    assert found[20:80, k] == pytest.approx(0.5)
    assert found[380:, k] == pytest.approx(0.2)
    assert found[150, k] == pytest.approx(0.3)
    assert not np.delete(found, k, axis=1).any()
    less = lasting({"v": {"standstill": 0.5}}, {}, independent=0.25)._levels
    assert less[50, k] == pytest.approx(0.25)
    assert less[300, k] == 0.0


def test_where_the_file_does_not_say_what_wanders_dead_reckoning_changes_nothing() -> None:
    """Whether a heading is measured or not: positions and heading stay as they are."""
    t = 0.02 * np.arange(400)
    measured = np.full((400, 8), np.nan)
    measured[:, 2], measured[:, 3], measured[:, 4] = 0.3, 8.0, 0.0
    found = LastingRemainder(Log({"t": t, "v": measured[:, 3]}), measured, {}, RemainderShape(), np.ones(8),
                             White(1.0), t == 0.0)  # type: ignore[arg-type] # fmt: skip
    rest = np.cumsum(np.ones((400, 8)), axis=0)
    assert found.freed(rest, reckoned=True).tolist() == found.freed(rest).tolist() == rest.ravel().tolist()


def test_positions_and_heading_are_compared_with_dead_reckoning_only_if_that_is_asked_for() -> None:
    """A place that is off by as much all the time, with speed and heading right, is no step beside dead reckoning."""
    found = lasting({}, {}, wanders={name: {"standstill": 0.1, "cruise": 0.1} for name in ("along", "across", "yaw")})
    rest = np.zeros((400, 8))
    rest[:, :2] = 1.0
    assert found.freed(rest).tolist() == rest.ravel().tolist()
    reckoned = found.freed(rest, reckoned=True).reshape(400, 8)
    assert np.abs(reckoned).max() < 0.05
