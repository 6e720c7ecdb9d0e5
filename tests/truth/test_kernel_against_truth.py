"""The kernel with an effect on, against the truth with the same effect hidden: two integrators, two sets of equations.

Noise-free logs, on segments of 5 s that begin at the true motion. Misfit is the mean square error over the variance of
the sensors, so with noise chi^2/N = 1 + misfit: 0.1 is the bound of 1.1.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from tests.truth.car import SUBSTEPS
from tests.truth.effects import CATALOGUE, REFINED, SPEED_MODE, Effects, TruthCar, typical
from tests.truth.generate import FACTOR, SIGMA, fine_truth, make_log
from vehicle.model.model_file import read_model
from vehicle.model.open_loop import MEASURED_COLUMNS, Replay
from vehicle.model.vehicle_model import VehicleModel
from vehicle.surrogate.driver import Drive

CAR = TruthCar()
SOFT_TYRES = ("tyre_relaxation", "load_transfer", "yaw_inertia")  # only show on axles that slip
SEGMENT = 250  # rows, 5 s
# urban driving stays below these limits, and its tyres hardly work
TOO_GENTLE = ("brake_limit", "steer_rate_limit", "steer_angle_limit", *SOFT_TYRES)
# what no ordinary search meets: effects that change while driving, one that needs another, a wind that stands still
OTHERS: dict[str, Effects] = {name: {name: values} for name, values in REFINED.items()} | {
    "speed_limit": {name: typical(name) for name in ("speed_limit", "speed_controller")},
    "headwind": {"headwind": {"speed": 6.0, "k": 0.003, "heading": 0.7}},
}


@cache
def model(folder: Path, name: str) -> VehicleModel:
    """The baseline of the truth car, with the inputs and tyres that this effect needs."""
    base = "dynamic_bicycle" if name in SOFT_TYRES else "kinematic_bicycle"
    column = "speed_cmd" if name in SPEED_MODE else "accel_cmd"
    text = f'[model]\nbase = "{base}"\n[inputs]\nsteer = "steer_cmd"\nlongitudinal = "{column}"\n[parameters]\n'
    text += f"wheelbase = {CAR.wheelbase}\ncg_to_front_axle = {CAR.cg_to_front_axle}\nmass = {CAR.mass}\n"
    text += f"yaw_inertia = {CAR.yaw_inertia}\n"
    if name in SOFT_TYRES:
        text += f"cornering_stiffness_front = {CAR.stiffness_front}\ncornering_stiffness_rear = {CAR.stiffness_rear}\n"
    path = folder / f"{name}.toml"
    path.write_text(text)
    return read_model(path)


@dataclass(frozen=True)
class Misfit:
    """In units of the noise: `without` the effect (worst channel, low noise); with it (mean of all channels) at a step
    of 1 ms, which tests the equations, and at the default step, both at low noise."""

    without: float
    fine_step: float
    default_step: float


def misfits(
    folder: Path, name: str, drive: Drive, effects: Effects | None = None, *, ours: Effects | None = None
) -> Misfit:
    """ours: the same effects as the catalogue writes them, where the truth has another form."""
    effects = effects or {name: typical(name)}
    log = make_log(effects, drive, 1, "none")
    _, fine = fine_truth(effects, drive, 1)
    commands = {c: log[c] for c in ("accel_cmd", "speed_cmd", "steer_cmd") if c in log}
    starts = np.arange(0, len(log["t"]), SEGMENT)
    true = fine[starts * SUBSTEPS]
    states = np.column_stack([true[:, :4], np.full(len(starts), np.nan), true[:, 4]])
    with_effect = {(one, key): value for one, values in (ours or effects).items() for key, value in values.items()}
    others = {(one, key): value for (one, key), value in with_effect.items() if one != name}

    def misfit(values: dict[tuple[str, str], float] | None, step: float | None, noise: str) -> list[float]:
        replay = Replay(model(folder, name), log["t"], commands, step=step)
        rows = replay.run(values, starts=starts, states=states)
        error = {c: rows[:, MEASURED_COLUMNS.index(c)] - log[c] for c in SIGMA}
        return [float(np.mean((error[c] / (FACTOR[noise] * SIGMA[c])) ** 2)) for c in SIGMA]

    return Misfit(
        without=max(misfit(others or None, None, "low")),
        fine_step=float(np.mean(misfit(with_effect, 0.001, "low"))),
        default_step=float(np.mean(misfit(with_effect, None, "low"))),
    )


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("models")


@pytest.mark.parametrize("name", CATALOGUE)
@pytest.mark.nightly(by_day=4)
def test_kernel_reproduces_the_rich_truth(name: str, folder: Path) -> None:
    misfit = misfits(folder, name, "rich")
    assert misfit.fine_step < 0.1
    assert misfit.default_step < 0.1
    # what the sensors could see at all, the effect explains
    assert misfit.without > 0.2
    assert misfit.without > 10.0 * misfit.fine_step


@pytest.mark.parametrize("name", sorted(set(CATALOGUE) - set(TOO_GENTLE)))
@pytest.mark.nightly(by_day=4)
def test_kernel_reproduces_the_urban_truth(name: str, folder: Path) -> None:
    misfit = misfits(folder, name, "urban")
    assert misfit.fine_step < 0.1
    assert misfit.default_step < 0.1
    assert misfit.without > 5.0 * misfit.fine_step


@pytest.mark.parametrize("name", sorted(OTHERS))
def test_kernel_reproduces_the_truth_of_what_no_ordinary_search_meets(name: str, folder: Path) -> None:
    """All show in both drives, none hides in the noise."""
    for drive in ("rich", "urban"):
        misfit = misfits(folder, name, drive, OTHERS[name])  # type: ignore[arg-type]
        assert misfit.fine_step < 0.1
        assert misfit.default_step < 0.1
        assert misfit.without > 10.0 * max(misfit.fine_step, 0.02)


def test_a_steering_that_rings_is_a_servo_of_second_order(folder: Path) -> None:
    """The truth integrates it with steps of its own, by its frequency."""
    rings = typical("steer_resonance")
    servo = {"tau": 1.0 / (2.0 * np.pi * rings["frequency"]), "damping": rings["damping"]}
    for drive in ("rich", "urban"):
        misfit = misfits(folder, "steer_servo", drive, {"steer_resonance": rings}, ours={"steer_servo": servo})  # type: ignore[arg-type]
        assert misfit.fine_step < 0.1
        assert misfit.default_step < 0.1
        assert misfit.without > 10.0 * max(misfit.fine_step, 0.02)
