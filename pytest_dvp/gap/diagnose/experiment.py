"""A log set up so that a model with any effects can be tried on it: whitened residuals in about a millisecond."""

from __future__ import annotations

import dataclasses
import threading
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Protocol, TypeAlias

import numpy as np

from pytest_dvp.gap.compare.coloured_noise import first_rows, whitening
from pytest_dvp.gap.compare.compare import judged_channels, noise_floor
from pytest_dvp.gap.compare.compared_model import (
    CompareError,
    ModelSubject,
    at_place_of,
    command_at_stamps,
    rows_with_commands,
    unheeded_rows,
)
from pytest_dvp.gap.compare.road_slope import SLOWEST, slope_spread
from pytest_dvp.gap.compare.segments import (
    CHANNELS,
    Residuals,
    cut,
    filled,
    has_speed,
    measured_array,
    residuals,
    restarted,
)
from pytest_dvp.gap.compare.start_correction import IntArray
from pytest_dvp.gap.diagnose.dead_reckoning import Reckoned, beside_dead_reckoning
from pytest_dvp.gap.diagnose.known_remainder import MARGIN, Left, expected, regimes_of
from pytest_dvp.gap.diagnose.lasting_remainder import LastingRemainder
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray

if TYPE_CHECKING:
    from vehicle.model.effect import Effect
    from vehicle.model.vehicle_model import VehicleModel

FINE_STEP = 0.002  # s
JUMP = 5.0  # standard deviations of the accelerometer's noise
LITTLE_ELSE = 20.0  # chi^2/N
"""That a model may leave beside hills that are no error of it; chosen: of three cars from their data sheets, which left
25 and more, the speed says more of the car than hills of 0.6 % take from it."""
LONG_ENOUGH = 2.0  # s of a segment, for a slope to show in the speed; chosen
KEPT = 32e6  # bytes of motions that are kept for who asks again, 90 of a log of 110 s at 50 Hz: a tenth of all is
# asked for again, five times in six within the next 64
_V, _YAW_RATE, _AX, _AY = (CHANNELS.index(name) for name in ("v", "yaw_rate", "ax", "ay"))
_SETTLES = 0.2  # s after a start in which what is shown of a turn may still be of the start; chosen: on a lorry the
# square of what ay was off by was 7 and 20 times that of later in the second half of this, and that of later after it
_QUIET = 0.1  # rad/s^2 of the yaw rate at a start, up to which there is nothing to settle; chosen: a gyro with a noise
# of 0.005 rad/s at 50 Hz shows 0.01 (standard deviation) where nothing turns

Values: TypeAlias = Mapping[tuple[str, str], float]
"""(effect, key) -> value, over those of the model."""


class Machine(Protocol):
    """What answers commands with motion, with any values of any effects: a `vehicle.model.open_loop.Replay`."""

    def run(self, values: Values | None = None, *, starts: IntArray | None = None,
            states: FloatArray | None = None) -> FloatArray:  # fmt: skip
        """The channels (n, 8) in their units at the stamps; see Replay.run."""
        ...


class Experiment:
    """One log and one model.

    name   of the log; channels: those that are judged; noise (8,) standard deviation of each, inf where not judged
    sigma  (8,) the noise together with what the model is known not to explain, in units of which residuals are judged
    slopes  standard deviation [m/s^2] of the slope of the road, which is no error of the model; 0: a flat road
    independent  of the samples judged (`count`), as many as would tell the same if their noise were white
    edges  (m + 1,) where the segments begin and end in the whitened residual
    """

    def __init__(self, name: str, log: Log, model: VehicleModel, *, extra: Iterable[Effect] = ()) -> None:
        from vehicle.model.open_loop import Replay

        model = at_place_of(log, model)
        subject = ModelSubject(model)
        commands = {column: command_at_stamps(log, column, subject.name) for column in subject.inputs}
        self.name, self.log, self.model = name, log, model
        self.machine: Machine = Replay(model, log.t, commands, extra=extra)
        fine = max(FINE_STEP, 2e-4 * float(np.diff(log.t).max(initial=0.0)))  # a long pause is not worth more steps
        self._exact: Machine = Replay(model, log.t, commands, step=fine, extra=extra)
        self.measured = measured_array(log.columns)
        if not has_speed(self.measured):
            raise CompareError(f"{name}: no speed for a model to start with: neither v nor x and y are measured")
        self.segments = cut(log.t, self.measured, wheelbase=model.car.wheelbase, known=rows_with_commands(log, subject),
                            unheeded=unheeded_rows(log, subject))  # fmt: skip
        self._free_speed = "v" not in subject.imposed_channels
        if model.inputs.longitudinal == ("speed_cmd",):  # a controlled speed forgets where it started, a restarted one
            states = self.segments.states.copy()  # upsets the controller's memory: it runs on
            states[1:, 3] = np.nan
            self.segments = dataclasses.replace(self.segments, states=states)
            self._free_speed = False
        self._first = self.segments
        self._one_at_a_time = threading.Lock()
        self._motions: dict[tuple[tuple[tuple[str, str], float], ...], FloatArray] = {}
        self._moved_on = self.segments
        output = self.machine.run({}, starts=self.segments.starts, states=self.segments.states)
        self.slopes = 0.0
        self.channels, _ = judged_channels(subject, self.measured, output, None)
        self.sigma = noise_floor(log.t, self.measured, self.channels)
        self.measured = _without_jumps(self.measured, commands.get("accel_cmd"), float(self.sigma[_AX]))
        self.measured = _without_settling(self.measured, log.t, self.segments.starts)
        rough = self._residuals(output)
        white = noise_floor(log.t, self.measured, self.channels, rough.values)
        coloured = whitening(log.t, self.measured, white)
        self.noise = coloured.sigma
        self.sigma = np.hypot(self.noise, MARGIN * expected(model.remainder, log, self.measured))
        self._whitening = coloured
        self.slopes = self._slopes_of_road(output) if self._free_speed else 0.0
        self._begins = first_rows(log.t, self.segments.starts)
        self._lasting = LastingRemainder(
            log, self.measured, model.remainder, model.remainder_shape, self.noise, coloured, self._begins
        )
        self._count(output)
        self.edges = np.append(self.segments.starts, len(log.t)).astype(np.int64) * len(CHANNELS)

    def motion(self, values: Values) -> FloatArray:
        """Channels (n, 8) in their units that the model shows with `values`, each segment from its start; not to be
        written to, for the latest are kept."""
        key = tuple(sorted(values.items()))
        with self._one_at_a_time:
            if self._moved_on is not self.segments:
                self._motions, self._moved_on = {}, self.segments
            found = self._motions.pop(key, None)
        if found is None:
            found = self.machine.run(values, starts=self.segments.starts, states=self.segments.states)
        with self._one_at_a_time:
            while self._motions and (len(self._motions) + 1) * found.nbytes > KEPT:
                del self._motions[next(iter(self._motions))]
            self._motions[key] = found
        return found

    def residuals(self, values: Values) -> Residuals:
        """Measured - model with these values, the best start of each segment taken out."""
        return self._residuals(self.motion(values))

    def left(self, values: Values) -> Left:
        """What the model with these values does not explain."""
        return Left(self.log, self.measured, self.residuals(values).values, self.noise, self.channels)

    def hills(self, values: Values) -> tuple[FloatArray, FloatArray, FloatArray]:
        """What the model with these values leaves in each segment (m,) in which the car and it roll for a while: for
        how long [s], how much more the car speeds up [m/s^2], and how much more its accelerometer shows [m/s^2]."""
        motion = self.motion(values)
        rest = self._residuals(motion, slopes=0.0).values
        rolls = np.minimum(np.abs(motion[:, _V]), np.abs(filled(self.log.t, self.measured)[:, _V])) > SLOWEST
        found = []
        for first, end in zip(self.segments.starts, self.segments.ends, strict=True):
            t, there = self.log.t[first:end], rolls[first:end] & np.isfinite(rest[first:end][:, (_V, _AX)]).all(axis=1)
            if not there.any() or np.ptp(t[there]) < LONG_ENOUGH:
                continue
            pushed = np.nan_to_num(rest[first:end, _AX])
            pushed = np.concatenate([[0.0], np.cumsum(0.5 * (pushed[1:] + pushed[:-1]) * np.diff(t))])
            both = np.column_stack([rest[first:end, _V], pushed])[there]
            found.append((np.ptp(t[there]), *np.polyfit(t[there] - t[0], both, 1)[0]))
        lasts, faster, shown = np.array(found, dtype=np.float64).reshape(-1, 3).T
        return lasts, faster, shown

    def on_hills(self, slopes: float) -> None:
        """From now on the slope of the road, of this spread [m/s^2], is no error of the model; 0: a flat road."""
        self.slopes = slopes
        self._count(self.motion({}))

    def _count(self, output: FloatArray) -> None:
        """On hills, fewer samples count."""
        counts = self._residuals(output).count
        self.count = int(counts.sum())
        self.independent = float(counts @ self._whitening.independent)

    def _slopes_of_road(self, output: FloatArray) -> float:
        """Spread [m/s^2] of the slope of the road that is no error of the model: as the model's file tells of the
        drives that it was learnt from, or as the log tells of a model that leaves little else (`output` (n, 8))."""
        told = self.model.remainder_shape.slopes
        if told is not None or self.model.remainder:
            return told or 0.0
        found = slope_spread(self.log.t, measured_array(self.log.columns))
        return found if found and self._residuals(output, found).total <= LITTLE_ELSE else 0.0

    def reckoned(self, values: Values) -> Reckoned:
        """What the model with these values leaves beside dead reckoning."""
        motion, t = filled(self.log.t, self.measured), self.log.t
        rest = beside_dead_reckoning(self.residuals(values).values, motion, t, self._begins)
        heading = motion[:, 2] if np.isfinite(self.measured[:, 2]).any() else np.full(len(t), np.nan)
        return Reckoned(t, heading, rest, self.noise, self._begins, regimes_of(self.log, self.measured))

    def whitened(self, values: Values) -> FloatArray:
        """Residuals in units of the noise, (n * 8,), row by row; 0 where nothing was compared."""
        return self.white(self.residuals(values).values)

    def white(self, rest: FloatArray) -> FloatArray:
        """Residuals (n, 8) in the channels' units, in units of sigma and freed of what neighbouring noise repeats."""
        return self._whitening.scaled(self.sigma).of(rest, self._begins)

    def freed(self, rest: FloatArray, *, reckoned: bool = False) -> FloatArray:
        """Residuals (n, 8) in the channels' units, in units of the noise and of what the known remainder does anew;
        reckoned: positions and heading beside dead reckoning."""
        return self._lasting.freed(rest, reckoned=reckoned)

    def exact(self, values: Values) -> FloatArray:
        """Residuals (n, 8) in the channels' units of a model that is integrated in far smaller steps.

        Where they differ from the others, the error is one of the integration and not of the physics.
        """
        output = self._exact.run(values, starts=self.segments.starts, states=self.segments.states)
        return self._residuals(output).values

    def settle(self, values: Values) -> None:
        """From now on the segments begin where the model with these values would have had them begin."""
        self.segments = self._first
        self.segments = restarted(self._first, self.residuals(values))

    def _residuals(self, output: FloatArray, slopes: float | None = None) -> Residuals:
        return residuals(output, self.measured, self.log.t, self.sigma, self.segments, free_speed=self._free_speed,
                         slopes=self.slopes if slopes is None else slopes)  # fmt: skip


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class ExperimentSet:
    """Several experiments with one model, judged together.

    lasts: the model's known remainder counts as an error that lasts (`lasting_remainder`), not as more noise.
    reckons: and positions and heading count beside dead reckoning (`dead_reckoning`).
    """

    experiments: tuple[Experiment, ...]
    lasts: bool = False
    reckons: bool = False

    @property
    def count(self) -> int:
        """Samples judged in all."""
        return sum(e.count for e in self.experiments)

    @property
    def independent(self) -> float:
        """Samples that would tell as much if the noise of neighbours were not alike; `count` where it is white."""
        return sum(e.independent for e in self.experiments)

    def slides(self) -> tuple[float, float]:
        """Shares of the drives (0..1) in which the car slides or its wheels lock, and that do not count for it."""
        cuts = [e.segments for e in self.experiments]
        rows = sum(len(one.slides) for one in cuts)
        slides, abandoned = sum(one.slides.sum() for one in cuts), sum(one.abandoned.sum() for one in cuts)
        return float(slides) / rows, float(abandoned) / rows

    @property
    def slopes(self) -> float:
        """Spread [m/s^2] of the slope of the road that is no error of the model, the largest of the logs."""
        return max((e.slopes for e in self.experiments), default=0.0)

    @property
    def excused(self) -> bool:
        """True if the model is known not to explain everything: part of sigma is then not noise."""
        return any(e.model.remainder for e in self.experiments)

    @property
    def sample(self) -> float:
        """Time between stamps [s], the longest of the usual ones of the logs."""
        return max(float(np.median(np.diff(e.log.t))) for e in self.experiments)

    @property
    def channels(self) -> tuple[str, ...]:
        """Channels that are judged in one log at least, in the order of CHANNELS."""
        return tuple(c for c in CHANNELS if any(c in e.channels for e in self.experiments))

    def whitened(self, values: Values) -> FloatArray:
        """Residuals (N,) of all experiments in units of their noise, one after the other."""
        found = [self._white(e, e.residuals(values).values) for e in self.experiments]
        return found[0] if len(found) == 1 else np.concatenate(found)

    def exact(self, values: Values) -> FloatArray:
        """Residuals (N,) of all experiments in units of their noise, by small steps; see Experiment.exact."""
        return np.concatenate([self._white(e, e.exact(values)) for e in self.experiments])

    def lasting(self) -> ExperimentSet:
        """The same experiments; the known remainder is an error that lasts."""
        return dataclasses.replace(self, lasts=True)

    def reckoned(self) -> ExperimentSet:
        """The same experiments; the known remainder is an error that lasts, positions and heading count beside dead
        reckoning."""
        return dataclasses.replace(self, lasts=True, reckons=True)

    def _white(self, e: Experiment, rest: FloatArray) -> FloatArray:
        if self.reckons:
            return e.freed(rest, reckoned=True)
        return e.freed(rest) if self.lasts else e.white(rest)

    def settle(self, values: Values) -> None:
        """See Experiment.settle."""
        for e in self.experiments:
            e.settle(values)

    def by_segment(self, whitened: FloatArray) -> FloatArray:
        """Sum of squares (m,) of each segment of all experiments; `whitened` (N,) in units of the noise."""
        return np.add.reduceat(whitened * whitened, self.starts())

    def starts(self) -> IntArray:
        """Where each segment of all experiments begins: index (m,) into the whitened residual."""
        found, offset = [], 0
        for e in self.experiments:
            found.append(e.edges[:-1] + offset)
            offset += int(e.edges[-1])
        return np.concatenate(found)

    def by_channel(self, values: Values) -> dict[str, float]:
        """chi^2/N of each channel over all experiments."""
        sums: dict[str, list[float]] = {}
        for e in self.experiments:
            rest = e.residuals(values)
            squares = (self._white(e, rest.values).reshape(-1, len(CHANNELS)) ** 2).sum(axis=0)
            for name in e.channels:
                k = CHANNELS.index(name)
                if rest.count[k]:
                    pair = sums.setdefault(name, [0.0, 0.0])
                    pair[0] += float(squares[k])
                    pair[1] += float(rest.count[k])
        return {name: sums[name][0] / sums[name][1] for name in CHANNELS if name in sums}

    def anew(self) -> dict[str, float]:
        """chi^2/N of each channel that the model's known remainder is known to make anew, at least 1."""
        shapes = [e.model.remainder_shape.anew for e in self.experiments]
        return {name: max([1.0, *(shape.get(name, 1.0) for shape in shapes)]) for name in CHANNELS}

    def rmse(self, values: Values) -> dict[str, float]:
        """RMSE of each channel in its unit, over all experiments, on segments of about 5 s; without one that has no
        sample that is judged."""
        sums: dict[str, list[float]] = {}
        for e in self.experiments:
            found = e.residuals(values)
            for name in e.channels:
                rest = found.values[:, CHANNELS.index(name)]
                pair = sums.setdefault(name, [0.0, 0.0])
                pair[0] += float(np.nansum(rest * rest))
                pair[1] += float(np.isfinite(rest).sum())
        return {n: float(np.sqrt(sums[n][0] / sums[n][1])) for n in CHANNELS if n in sums and sums[n][1] > 0.0}

    def noise(self) -> dict[str, float]:
        """Noise sigma of each channel in its unit: root mean square over the experiments."""
        found: dict[str, list[float]] = {}
        for e in self.experiments:
            for name in e.channels:
                found.setdefault(name, []).append(float(e.noise[CHANNELS.index(name)]))
        return {name: float(np.sqrt(np.mean(np.square(found[name])))) for name in CHANNELS if name in found}


def experiment_set(logs: Mapping[str, Log], model: VehicleModel, *, extra: Sequence[Effect] = ()) -> ExperimentSet:
    """Experiments of a model on logs by name. Raises CompareError or ModelError: an input missing, nothing to judge."""
    found = ExperimentSet(tuple(Experiment(name, log, model, extra=extra) for name, log in logs.items()))
    for one in found.experiments if found.slopes else ():
        one.on_hills(found.slopes)
    return found


def on_same_roads(model: VehicleModel, target: ExperimentSet) -> VehicleModel:
    """The model for drives that judge it beside those of `target`: its file tells the slopes of their roads, if they
    have any."""
    if not target.slopes:
        return model
    shape = dataclasses.replace(model.remainder_shape, slopes=target.slopes)
    return dataclasses.replace(model, remainder_shape=shape)


def _without_settling(measured: FloatArray, t: FloatArray, starts: IntArray) -> FloatArray:
    """Without yaw rate and ay for as long as they settle after a start amid a change of the turn: of steering and tyres
    no start knows what they were doing, and ay ahead of the axle shows each jump of the yaw rate."""
    rate = measured[:, _YAW_RATE]
    found = measured.copy()
    for row in starts[1:]:
        near = (np.abs(t - t[row]) <= _SETTLES) & np.isfinite(rate)
        if near.sum() > 2 and np.ptp(t[near]) > 0.0 and abs(np.polyfit(t[near] - t[row], rate[near], 1)[0]) > _QUIET:
            settling = (t >= t[row]) & (t < t[row] + _SETTLES)
            found[np.ix_(settling, (_YAW_RATE, _AY))] = np.nan
    return found


def _without_jumps(measured: FloatArray, command: FloatArray | None, sigma: float) -> FloatArray:
    """Without ax at the stamps at which the commanded acceleration jumps: it has no value there. One logger shows it
    before, the next after the jump, and half a sample of that looks like a dead time."""
    if command is None or not np.isfinite(sigma):
        return measured
    found = measured.copy()
    found[np.abs(np.diff(command, prepend=command[:1])) > JUMP * sigma, _AX] = np.nan
    return found
