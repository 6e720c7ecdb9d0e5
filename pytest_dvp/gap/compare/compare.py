"""How far a model is from a measured log, signal by signal, and where."""

from __future__ import annotations

import dataclasses
import difflib
import math
from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from pytest_dvp.gap.compare import iso18571
from pytest_dvp.gap.compare.coloured_noise import Whitening, first_rows, whitening
from pytest_dvp.gap.compare.compared_model import (
    ComparedModel,
    CompareError,
    LogSubject,
    ModelSubject,
    rows_with_commands,
    rows_with_motion,
    unheeded_rows,
)
from pytest_dvp.gap.compare.error_location import Where, locate
from pytest_dvp.gap.compare.noise_floor import sigma as channel_sigma
from pytest_dvp.gap.compare.regimes import regimes
from pytest_dvp.gap.compare.segments import (
    CHANNELS,
    UNITS,
    Residuals,
    Segments,
    cut,
    filled,
    has_speed,
    longest_step,
    measured_array,
    residuals,
    restarted,
    standing,
    stands_for,
)
from pytest_dvp.gap.compare.start_correction import BoolArray
from pytest_dvp.gap.compare.time_alignment import Alignment, alike, common_lag, coverage, grid, on_grid
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray

if TYPE_CHECKING:
    from vehicle.model.vehicle_model import VehicleModel

Comparable: TypeAlias = "ComparedModel | VehicleModel | Log"

RATING_STEP = 0.1  # s: both signals are averaged to this step before they are rated, as ISO 18571 wants filtered ones
POSE = ("x", "y", "yaw")
"""Position and heading come out of somebody's filter: what is white in an INS is its last digit, not its error."""
BEST_SENSOR_SIGMA = (0.01, 0.01, 0.0005, 0.01, 0.0005, 0.02, 0.02, 0.001)
"""Sigma of CHANNELS in their units, of the size that data sheets of the best sensors of road cars state (satellites
with corrections, a fibre-optic gyro, wheel encoders); our choice, not of one source. A simulator's own log is finer,
and no effect is worth adding for what nobody can measure."""
_LAG_SIGNALS = ("yaw_rate", "v", "ay", "ax")
_VISIBLE = 4.0  # a signal tells a lag if it varies by this many sigma


@dataclasses.dataclass(frozen=True, slots=True)
class SignalScore:
    """How far apart a signal is. rmse in its unit; nrmse: rmse / range of the measured; chi2_per_n: mean square in
    units of the noise, 1 = nothing left to explain; mncc, lag [s] (> 0: the measurement comes later), gain
    measured/model (None for a constant signal); iso18571: total rating 0..1."""

    rmse: float
    nrmse: float | None
    chi2_per_n: float
    mncc: float | None
    lag: float | None
    gain: float | None
    iso18571: float | None
    unit: str

    def as_dict(self) -> dict[str, Any]:
        """The entry of `compare --json`."""
        return dataclasses.asdict(self)


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class Comparison:
    """Result of `compare`. Arrays (n,) at the stamps t [s] of the log, by channel; NaN = not compared.

    modelled is the model's output on re-initialised segments with the best start, so residuals = measured - modelled.
    slid (n,): rows that are not judged because the car slides or spins there, or its heading contradicts its yaw rate;
    speed (n,) measured [m/s], bridged where it was not measured, of the path if it never was; position map x, y (n,)
    [m] if measured; chi2_per_n: over all channels; not_compared: the reason for each channel left out.
    """

    model: str
    alignment: Alignment
    signals: dict[str, SignalScore]
    where: tuple[Where, ...]
    noise: dict[str, float]
    residuals: dict[str, FloatArray]
    t: FloatArray
    measured: dict[str, FloatArray]
    modelled: dict[str, FloatArray]
    segments: Segments
    slid: BoolArray
    regimes: dict[str, BoolArray]
    speed: FloatArray
    position: tuple[FloatArray, FloatArray] | None
    chi2_per_n: float
    not_compared: dict[str, str]

    def as_dict(self) -> dict[str, Any]:
        """The document of `compare --json`."""
        return {
            "alignment": {"lag": self.alignment.lag, "coverage": self.alignment.coverage},
            "signals": {name: score.as_dict() for name, score in self.signals.items()},
            "where": [where.as_dict() for where in self.where],
        }


def compare(log: Log, model: Comparable, *, channels: Collection[str] | None = None) -> Comparison:
    """Compare a measured log with a vehicle model, a black box (`Subject`) or the model's own log.

    channels: those to compare, else all that both have, out of x, y, yaw, v, yaw_rate, ax, ay, steer. The model is
    driven by the log's commands, open loop, on segments of about 5 s that start from the measured motion; what a wrong
    start explains is taken out. Raises CompareError (one line) if nothing can be compared.
    """
    subject = as_subject(model)
    if len(log.t) < 16:
        raise CompareError(f"log: {len(log.t)} samples are too few to compare")
    if not (np.diff(log.t) > 0.0).all():
        row = int(np.argmin(np.diff(log.t) > 0.0)) + 1
        raise CompareError(f"log: time does not increase at row {row} (t={log.t[row]:.3f} s); see dvp doctor")
    measured = measured_array(log.columns)
    wheelbase = subject.model.car.wheelbase if isinstance(subject, ModelSubject) else 2.5
    if subject.restarts and not has_speed(measured):
        raise CompareError("log: no speed for a model to start with: neither v nor x and y are measured")
    known = rows_with_commands(log, subject)
    given, unheeded = rows_with_motion(log, subject), unheeded_rows(log, subject)
    segments = cut(log.t, measured, wheelbase=wheelbase, known=known, given=given, unheeded=unheeded)
    output = subject.output(log, segments)
    _check_finite(subject, log.t, output)
    judged, left_out = judged_channels(subject, measured, output, channels)
    free_speed = "v" not in subject.imposed_channels
    sigma = noise_floor(log.t, measured, judged)
    rough = residuals(output, measured, log.t, sigma, segments, free_speed=free_speed)
    if not rough.count.any():
        raise CompareError(f"{subject.name}: nothing to compare: {_why_nothing(measured, segments)}")
    sigma = noise_floor(log.t, measured, judged, rough.values)
    found = residuals(output, measured, log.t, sigma, segments, free_speed=free_speed)
    if subject.restarts:
        output = subject.output(log, restarted(segments, found))
        _check_finite(subject, log.t, output)
        again = residuals(output, measured, log.t, sigma, segments, free_speed=free_speed)
        found = again if again.total < found.total else found
    noise = whitening(log.t, measured, sigma)
    found = _whitened(found, noise, first_rows(log.t, segments.starts))
    sigma = noise.sigma
    column = {name: CHANNELS.index(name) for name in judged}
    rest = {name: np.ascontiguousarray(found.values[:, k]) for name, k in column.items()}
    real = {name: np.ascontiguousarray(measured[:, k]) for name, k in column.items()}
    twin = {name: real[name] - rest[name] for name in judged}
    chi2 = {name: float(found.chi2[k]) for name, k in column.items()}
    even = grid(log.t)
    signals = {
        name: _score(real[name], twin[name], rest[name], chi2[name], log.t, even, UNITS[name]) for name in judged
    }
    whole = filled(log.t, measured)
    v, rate = np.ascontiguousarray(whole[:, 3]), np.ascontiguousarray(whole[:, 4])
    masks = _regimes(log, v, rate)
    position = (measured[:, 0], measured[:, 1]) if np.isfinite(measured[:, :2]).any() else None
    both = np.isfinite(output[:, list(column.values())]) & np.isfinite(measured[:, list(column.values())])
    seen = np.logical_or.reduce([stands_for(log.t, rows) for rows in both.T])
    covered = coverage(log.t, seen & ~segments.lost, longest_step(log.t))
    still = standing(log.t, v) if has_speed(measured) else np.zeros(len(log.t), dtype=np.bool_)
    return Comparison(
        model=subject.name,
        alignment=Alignment(_lag(real, twin, sigma, log.t, even), covered),
        signals=signals,
        where=locate(rest, chi2, masks, log.t, v, position, segments),
        noise={name: float(sigma[k]) for name, k in column.items()},
        residuals=rest,
        t=log.t,
        measured=real,
        modelled=twin,
        segments=segments,
        slid=~(segments.counted | segments.lost | still),
        regimes=masks,
        speed=v,
        position=position,
        chi2_per_n=found.total,
        not_compared=left_out,
    )


def _whitened(found: Residuals, noise: Whitening, first: BoolArray) -> Residuals:
    """The residuals with the chi^2/N of whitened ones: neighbours that repeat each other's noise count once."""
    squares = (noise.of(found.values, first).reshape(-1, len(CHANNELS)) ** 2).sum(axis=0)
    mean = np.where(found.count > 0, squares / np.maximum(found.count, 1), np.nan)
    return dataclasses.replace(found, chi2=mean, total=float(squares.sum() / max(int(found.count.sum()), 1)))


def _why_nothing(measured: FloatArray, segments: Segments) -> str:
    if segments.lost.all():
        return "never are the commands, what a start needs (yaw, v, yaw_rate) and the model known at the same time"
    return "wherever both are known, the car stands or slides"


def _check_finite(subject: ComparedModel, t: FloatArray, output: FloatArray) -> None:
    """A model that we step must stay finite: what is missing would otherwise pass as explained. Raises CompareError."""
    if not subject.restarts:
        return  # a log of another model may have gaps of its own
    bad: BoolArray = ~np.isfinite(output)
    given = range(len(CHANNELS)) if isinstance(subject, ModelSubject) else np.flatnonzero(~bad.all(axis=0)).tolist()
    if not given:
        raise CompareError(f"{subject.name}: gives no finite value at all")
    row, name = min((int(np.argmax(bad[:, k])), CHANNELS[k]) if bad[:, k].any() else (len(t), "") for k in given)
    if name:
        raise CompareError(f"{subject.name}: {name} is not finite from t={t[row]:.3f} s on")


def as_subject(model: Comparable) -> ComparedModel:
    """What `compare` takes, as a Subject."""
    from vehicle.model.vehicle_model import VehicleModel

    if isinstance(model, VehicleModel):
        return ModelSubject(model)
    if isinstance(model, Log):
        return LogSubject(model)
    return model


def judged_channels(
    subject: ComparedModel, measured: FloatArray, output: FloatArray, wanted: Collection[str] | None
) -> tuple[list[str], dict[str, str]]:
    """Channels to judge in the order of CHANNELS, and for each other channel why it is not judged.

    measured, output (n, 8) in channel units, NaN where there is no value; wanted: channels to judge and no others, None
    for all that can be judged. Raises CompareError for an unknown channel, for a wanted one that cannot be judged, and
    if none is left.
    """
    for name in wanted or ():
        if name not in CHANNELS:
            near = difflib.get_close_matches(name, CHANNELS, n=1)
            raise CompareError(f"no channel {name!r}; " + (f"nearest is {near[0]!r}" if near else ", ".join(CHANNELS)))
    reasons: dict[str, str] = {}
    for k, name in enumerate(CHANNELS):
        if not np.isfinite(measured[:, k]).any():
            reasons[name] = "not measured"
        elif name in subject.inputs:
            reasons[name] = "drives the model"
        elif name in subject.imposed_channels:
            reasons[name] = "follows from what drives the model"
        elif not np.isfinite(output[:, k]).any():
            reasons[name] = "the model does not give it"
        elif not (np.isfinite(output[:, k]) & np.isfinite(measured[:, k])).any():
            reasons[name] = "never known at the same time"
        elif wanted is not None and name not in wanted:
            reasons[name] = "not asked for"
    judged = [name for name in CHANNELS if name not in reasons]
    missing = [f"{name}: {reasons[name]}" for name in (wanted or CHANNELS) if name in reasons]
    if not judged or (wanted is not None and missing):
        raise CompareError("nothing to compare (" + "; ".join(missing) + ")")
    return judged, reasons


def noise_floor(
    t: FloatArray, measured: FloatArray, judged: Collection[str], rest: FloatArray | None = None
) -> FloatArray:
    """Standard deviation (8,) of the noise in channel units, inf for channels that are not judged.

    t (n,) [s]; measured and rest (n, 8) in channel units. No sigma is below BEST_SENSOR_SIGMA.
    """
    found = np.full(len(CHANNELS), np.inf)
    for name in judged:
        k = CHANNELS.index(name)
        pose = name in POSE
        sigma = channel_sigma(t, measured[:, k], None if rest is None else rest[:, k], filtered=pose)
        found[k] = max(sigma, BEST_SENSOR_SIGMA[k]) if np.isfinite(sigma) else np.inf
    return found


def _regimes(log: Log, v: FloatArray, rate: FloatArray) -> dict[str, BoolArray]:
    return regimes(log.t, v, rate, log.columns.get("accel_cmd"))


def _score(
    measured: FloatArray, twin: FloatArray, rest: FloatArray, chi2: float, t: FloatArray, even: FloatArray, unit: str
) -> SignalScore:
    known = np.isfinite(rest)
    if not known.any():
        return SignalScore(math.nan, None, math.nan, None, None, None, None, unit)
    rmse = float(np.sqrt(np.mean(rest[known] ** 2)))
    span = float(np.ptp(measured[np.isfinite(measured)]))
    masked = np.where(known, measured, np.nan)
    a, b = on_grid(even, t, masked), on_grid(even, t, twin)
    step = float(even[1] - even[0])
    likeness = alike(a, b, step)
    block = max(1, round(RATING_STEP / step))
    c, d = _blocks(a, block), _blocks(b, block)
    rating = iso18571.score(c, d, block * step).total if len(c) >= 10 else None
    return SignalScore(rmse, rmse / span if span > 0.0 else None, chi2, likeness.mncc, likeness.lag, likeness.gain,
                       rating, unit)  # fmt: skip


def _blocks(y: FloatArray, block: int) -> FloatArray:
    count = len(y) // block
    return np.asarray(y[: count * block].reshape(count, block).mean(axis=1))


def _lag(
    real: Mapping[str, FloatArray], twin: Mapping[str, FloatArray], sigma: FloatArray, t: FloatArray, even: FloatArray
) -> float:
    """Common lag of the signals that vary well above their noise."""
    pairs = []
    for name in _LAG_SIGNALS:
        if name in real and np.isfinite(twin[name]).sum() > 16:
            a, b = on_grid(even, t, np.where(np.isfinite(twin[name]), real[name], np.nan)), on_grid(even, t, twin[name])
            if float(np.std(a)) > _VISIBLE * sigma[CHANNELS.index(name)]:
                pairs.append((a, b))
    return common_lag(pairs, float(even[1] - even[0]))
