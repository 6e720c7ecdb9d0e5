"""Models made elsewhere: a second log, a Python function, an FMU; and what a wrong one says."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from gap_logs import WHEELBASE, baseline, drive

from pytest_dvp.gap.compare.compare import compare
from pytest_dvp.gap.compare.compared_model import CompareError
from pytest_dvp.gap.compare.fmu_model import FmuSubject
from pytest_dvp.gap.compare.model_loader import load_compared_model
from pytest_dvp.gap.compare.python_model import StepSubject, load_step
from pytest_dvp.gap.compare.segments import CHANNELS, cut, measured_array
from pytest_dvp.logs.log import Log

STEP = f"""
import math
def step(state, inputs, dt):
    v = state["v"]
    after = max(v + inputs["accel_cmd"] * dt, 0.0)
    k = math.tan(inputs["steer_cmd"]) / {WHEELBASE}
    mean = 0.5 * (v + after)
    heading = state["yaw"] + 0.5 * dt * mean * k
    return {{
        "x": state["x"] + dt * mean * math.cos(heading), "y": state["y"] + dt * mean * math.sin(heading),
        "yaw": state["yaw"] + dt * mean * k, "v": after, "yaw_rate": after * k, "count": state.get("count", 0) + 1,
    }}
"""


def test_second_log_of_the_same_motion_leaves_the_noise() -> None:
    found = compare(drive(seed=1), drive(noise=0.0))
    assert found.signals["v"].chi2_per_n == pytest.approx(1.0, abs=0.2)
    assert found.alignment.coverage == 1.0


def test_second_log_that_drifted_away_is_judged_segment_by_segment() -> None:
    found = compare(drive(), drive(noise=0.0, yaw_bias=0.3))
    assert found.signals["x"].rmse < 0.1


def test_second_log_that_is_shorter_covers_less() -> None:
    assert compare(drive(60.0), drive(30.0, noise=0.0)).alignment.coverage == pytest.approx(0.5, abs=0.01)


def test_second_log_at_another_time_is_refused() -> None:
    other = drive(30.0)
    late = Log({**other.columns, "t": other.t + 500.0})
    with pytest.raises(CompareError, match="no time in common"):
        compare(drive(30.0), late)


def test_python_function_is_as_good_as_the_model_it_copies(tmp_path: Path) -> None:
    (tmp_path / "car.py").write_text(STEP)
    log = drive()
    ours, theirs = compare(log, baseline()), compare(log, load_compared_model(str(tmp_path / "car.py")))
    for name in ("x", "y", "yaw", "v", "yaw_rate"):
        assert theirs.signals[name].rmse == pytest.approx(ours.signals[name].rmse, rel=0.25)
    assert theirs.not_compared["ay"] == "the model does not give it"


def test_sideways_speed_of_a_python_function_begins_at_0_and_runs_on(tmp_path: Path) -> None:
    slip = 'after * k, "vy": 0.1 * after * math.tan(inputs["steer_cmd"]), "ay": k * after**2 + 0.0 * state["vy"]}'
    (tmp_path / "car.py").write_text(STEP.replace('after * k, "count": state.get("count", 0) + 1,\n    }', slip))
    seen: list[float] = []
    function = load_step(tmp_path / "car.py")

    def step(state: dict[str, float], inputs: Mapping[str, float], dt: float) -> Mapping[str, float]:
        seen.append(state["vy"])
        return function(state, inputs, dt)

    found = compare(drive(), StepSubject(step))
    assert seen[0] == 0.0
    assert len(found.segments.starts) > 5
    assert np.isfinite(seen).all()
    assert max(np.abs(np.diff(seen))) < 0.1  # m/s: no jump at a start of a segment
    assert found.signals["ay"].chi2_per_n == pytest.approx(1.0, abs=0.2)


@pytest.mark.parametrize("seed", range(3))
def test_sample_of_the_docs_explains_a_log_of_its_own_equations(tmp_path: Path, seed: int) -> None:
    page = (Path(__file__).parents[3] / "docs" / "compare.md").read_text(encoding="utf-8")
    samples = [block.split("```")[0] for block in page.split("```python\n")[1:]]
    sample = next(block for block in samples if "def step(" in block)
    (tmp_path / "car.py").write_text(sample.replace("2.45", str(WHEELBASE)))
    found = compare(drive(seed=seed), load_compared_model(str(tmp_path / "car.py")))
    assert {name for name, score in found.signals.items() if score.chi2_per_n > 1.15} == set()
    assert set(found.signals) == {"x", "y", "yaw", "v", "yaw_rate"}


def shown(step: object, log: Log) -> dict[str, np.ndarray]:
    """What a step function shows of a log's commands, by channel."""
    segments = cut(log.t, measured_array(log.columns))
    return dict(zip(CHANNELS, StepSubject(step).output(log, segments).T, strict=True))


def steps_of_steering(t: np.ndarray) -> Log:
    """5 m/s, the wheels at 0.1 rad to the left and to the right in turns, a second each."""
    steer = np.where(t % 2.0 < 1.0, 0.1, -0.1)
    return Log({"t": t, "v": np.full(len(t), 5.0), "steer_cmd": steer, "accel_cmd": np.zeros(len(t))})


def test_row_shows_the_command_of_its_stamp_already_acting() -> None:
    def step(state: dict[str, float], inputs: Mapping[str, float], dt: float) -> Mapping[str, float]:
        return {"yaw_rate": state["v"] * math.tan(inputs["steer_cmd"]) / WHEELBASE, "ax": inputs["accel_cmd"]}

    log = steps_of_steering(np.arange(400) * 0.02)
    found = shown(step, log)
    assert found["yaw_rate"] == pytest.approx(5.0 * np.tan(log["steer_cmd"]) / WHEELBASE, rel=1e-9)
    assert found["ax"] == pytest.approx(np.zeros(400))


def test_row_shows_what_the_function_keeps_as_a_state_at_its_stamp() -> None:
    tau = 0.3

    def step(state: dict[str, float], inputs: Mapping[str, float], dt: float) -> Mapping[str, float]:
        steer = state.get("steer_now", 0.0)
        steer += (inputs["steer_cmd"] - steer) * (1.0 - math.exp(-dt / tau))
        return {"steer_now": steer, "steer": steer}

    t = np.arange(50) * 0.02
    found = shown(step, steps_of_steering(t))
    # tau d' = 0.1 - d from d(0) = 0; the glance is a thousandth of a sample ahead
    assert found["steer"] == pytest.approx(0.1 * (1.0 - np.exp(-t / tau)), abs=0.1 * 2e-5 / tau)


def test_queue_that_a_function_keeps_is_not_shared_with_the_glance() -> None:
    def step(state: dict[str, list[float]], inputs: Mapping[str, float], dt: float) -> Mapping[str, object]:
        queue = state.get("queue", [0.0] * 10)
        queue.append(inputs["steer_cmd"])
        return {"queue": queue, "steer": queue.pop(0)}

    log = steps_of_steering(np.arange(200) * 0.02)
    late = np.concatenate([np.zeros(10), log["steer_cmd"][:-10]])  # ten samples of dead time
    assert shown(step, log)["steer"] == pytest.approx(late)


def test_function_of_another_name_is_named_after_a_colon(tmp_path: Path) -> None:
    (tmp_path / "car.py").write_text(STEP.replace("def step", "def simulate"))
    assert compare(drive(20.0), load_compared_model(f"{tmp_path / 'car.py'}:simulate")).signals["v"].rmse < 0.1
    with pytest.raises(CompareError, match="no function step"):
        load_compared_model(str(tmp_path / "car.py"))


def test_function_that_asks_for_a_column_the_log_lacks_says_which() -> None:
    def step(state: dict[str, float], inputs: Mapping[str, float], dt: float) -> Mapping[str, float]:
        return {"v": inputs["throttle"]}

    with pytest.raises(CompareError, match=r"'throttle'.*accel_cmd"):
        compare(drive(20.0), StepSubject(step))


def test_function_that_fails_says_when() -> None:
    def step(state: dict[str, float], inputs: Mapping[str, float], dt: float) -> Mapping[str, float]:
        return {"v": math.sqrt(-1.0)}

    with pytest.raises(CompareError, match=r"failed at t=0\.00 s: ValueError"):
        compare(drive(20.0), StepSubject(step))


def test_function_that_fails_on_the_way_names_the_stamp_from_which_it_was_to_go_on() -> None:
    """Five steps of 0.02 s have been gone from 0 s on when it fails."""

    def step(state: dict[str, float], inputs: Mapping[str, float], dt: float) -> Mapping[str, float]:
        gone = state.get("gone", 0.0)
        if dt > 0.01 and gone == 5.0:  # a glance is shorter
            raise ValueError("no road")
        return {"gone": gone + 1.0}

    with pytest.raises(CompareError, match=r"failed at t=0\.10 s: ValueError: no road"):
        shown(step, steps_of_steering(np.arange(50) * 0.02))


@pytest.mark.parametrize(
    ("returned", "message"),
    [
        (None, "step: returned a NoneType, not a dict of the new state"),
        ({"v": "fast"}, "step: returned v as a str at t=0.00 s, not as a number"),
        ({"yaw_rate": 1j}, "step: returned yaw_rate as a complex at t=0.00 s, not as a number"),
        ({"v": math.nan}, "step: v is not finite from t=0.020 s on"),
    ],
)
def test_function_that_returns_no_motion_is_refused_in_one_line(returned: object, message: str) -> None:
    with pytest.raises(CompareError) as caught:
        compare(drive(20.0), StepSubject(lambda state, inputs, dt: returned))  # type: ignore[arg-type,return-value]
    assert str(caught.value) == message


def test_file_that_is_no_python_says_so(tmp_path: Path) -> None:
    (tmp_path / "car.py").write_text("def step(:")
    with pytest.raises(CompareError, match=r"cannot be loaded: SyntaxError"):
        load_compared_model(str(tmp_path / "car.py"))


def test_file_that_is_no_fmu_is_refused_in_one_line(tmp_path: Path) -> None:
    (tmp_path / "car.fmu").write_bytes(b"no zip")
    with pytest.raises(CompareError, match=r"extra fmi|not a readable FMU") as caught:
        compare(drive(20.0), FmuSubject(tmp_path / "car.fmu"))
    assert "\n" not in str(caught.value)


def test_command_not_logged_in_every_row_is_held() -> None:
    log = drive()
    sparse = log["accel_cmd"].copy()
    sparse[np.arange(len(sparse)) % 5 != 0] = np.nan
    held = np.repeat(log["accel_cmd"][::5], 5)
    found = compare(Log({**log.columns, "accel_cmd": sparse}), baseline())
    assert found.signals["v"] == compare(Log({**log.columns, "accel_cmd": held}), baseline()).signals["v"]
