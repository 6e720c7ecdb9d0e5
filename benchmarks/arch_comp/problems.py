"""The problems: what drives which model, and what is required of it.

Formulas and ranges are those of the competition as its tools wrote them down: FReaK for 2024 (Abdu-Hekal/FReaK,
examples/ARCHcomp24/instance2), STGEM for 2021 (mshaheryarmalik/stgem, problems/arch-comp-2021), and FalStar and
zlscheck for 2019 and 2020. All four agree but for CC3 and CC4, see there. Inputs are those of instance 2: constant over
5 s.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np

from benchmarks.arch_comp import cars, transmission
from benchmarks.arch_comp.robustness import always, eventually, implies
from pytest_dvp.logs.log_contents import FloatArray

STEP = 0.01  # [s], of both models
PIECE = 5.0  # [s], length of a piece of an input in instance 2


@dataclasses.dataclass(frozen=True)
class Model:
    """A model: upper ends of throttle and brake, which begin at 0, and how many pieces each of them has."""

    drive: Callable[[FloatArray, FloatArray], FloatArray]
    highest: tuple[float, float]
    pieces: int


@dataclasses.dataclass(frozen=True)
class Problem:
    """A requirement: `margin` of a trace is its robustness, each atom's distance divided by its bound."""

    name: str
    model: Model
    seconds: float
    formula: str
    margin: Callable[[FloatArray], FloatArray]

    def robustness(self, values: FloatArray) -> float:
        """Robustness of the drive with these values: the pieces of the throttle, then those of the brake."""
        return float(self.margin(self.trace(values))[0])

    def trace(self, values: FloatArray) -> FloatArray:
        """What the model does with these values; the last piece lasts until the end."""
        count = round(self.seconds / STEP) + 1
        pieces = np.minimum(np.arange(count) // round(PIECE / STEP), self.model.pieces - 1)
        throttle, brake = np.reshape(values, (2, self.model.pieces))
        return self.model.drive(throttle[pieces], brake[pieces])


TRANSMISSION = Model(transmission.drive, (100.0, 325.0), 6)  # 30 s
CARS = Model(cars.drive, (1.0, 1.0), 20)  # 100 s


def _below(values: FloatArray, bound: float) -> FloatArray:
    return (bound - values) / bound


def _from(values: FloatArray, bound: float) -> FloatArray:
    return (values - bound) / bound


def _always(margin: FloatArray, begin: float, end: float) -> FloatArray:
    return always(margin, begin, end, STEP)


def _eventually(margin: FloatArray, begin: float, end: float) -> FloatArray:
    return eventually(margin, begin, end, STEP)


def _shift(gear: int) -> Problem:
    """AT5: what has shifted into a gear stays there for 2.5 s. The margin of a gear is whole: half, or less than it."""

    def margin(trace: FloatArray) -> FloatArray:
        inside = 0.5 - np.abs(trace[2] - gear)
        entered = np.minimum(-inside, _eventually(inside, 0.001, 0.1))
        stays = _eventually(_always(inside, 0.0, 2.5), 0.001, 0.1)
        return _always(implies(entered, stays), 0.0, 30.0)

    text = f"always[0,30] ((gear != {gear} and eventually[0.001,0.1] gear = {gear}) implies eventually[0.001,0.1] "
    return Problem(f"AT5{gear}", TRANSMISSION, 32.6, f"{text}always[0,2.5] gear = {gear})", margin)


SLOW = (("AT6a", 4.0, 35.0), ("AT6b", 8.0, 50.0), ("AT6c", 20.0, 65.0))  # until when [s], how fast [mph]


def _slow(trace: FloatArray, end: float, speed: float) -> FloatArray:
    quiet = _always(_below(trace[1], 3000.0), 0.0, 30.0)
    return implies(quiet, _always(_below(trace[0], speed), 0.0, end))


def _slow_text(end: float, speed: float) -> str:
    return f"(always[0,30] rpm < 3000) implies (always[0,{end:g}] speed < {speed:g})"


def _slows(trace: FloatArray) -> FloatArray:
    return np.minimum.reduce([_slow(trace, end, speed) for _, end, speed in SLOW])


def _gap(trace: FloatArray, car: int) -> FloatArray:
    """How far this car is behind the one before it, the first being car 1."""
    return trace[car - 1] - trace[car - 2]


def _apart(trace: FloatArray) -> FloatArray:
    return np.minimum.reduce([_always(_from(_gap(trace, car), 7.5), 0.0, 50.0) for car in (2, 3, 4, 5)])


def _settles(stays: float) -> Callable[[FloatArray], FloatArray]:
    return lambda x: _always(_eventually(_always(_from(_gap(x, 5), 8.0), 0.0, stays), 0.0, 30.0), 0.0, 65.0)


def _follows(trace: FloatArray) -> FloatArray:
    near, far = _always(_from(_gap(trace, 2), 9.0), 0.0, 5.0), _always(_from(_gap(trace, 5), 9.0), 5.0, 20.0)
    return _always(_eventually(implies(near, far), 0.0, 8.0), 0.0, 72.0)


def _either(trace: FloatArray) -> FloatArray:
    near, far = _always(_below(_gap(trace, 2), 20.0), 0.0, 20.0), _eventually(_from(_gap(trace, 5), 40.0), 0.0, 20.0)
    return _always(np.maximum(near, far), 0.0, 80.0)


def _cars(name: str, seconds: float, formula: str, margin: Callable[[FloatArray], FloatArray]) -> Problem:
    return Problem(name, CARS, seconds, formula, margin)


PROBLEMS: tuple[Problem, ...] = (
    Problem("AT1", TRANSMISSION, 20.0, "always[0,20] speed < 120", lambda x: _always(_below(x[0], 120.0), 0.0, 20.0)),
    Problem("AT2", TRANSMISSION, 10.0, "always[0,10] rpm < 4750", lambda x: _always(_below(x[1], 4750.0), 0.0, 10.0)),
    *(_shift(gear) for gear in (1, 2, 3, 4)),
    *(
        Problem(name, TRANSMISSION, 30.0, _slow_text(end, mph), lambda x, end=end, mph=mph: _slow(x, end, mph))
        for name, end, mph in SLOW
    ),
    Problem("AT6abc", TRANSMISSION, 30.0, "AT6a and AT6b and AT6c", _slows),
    _cars("CC1", 100.0, "always[0,100] y5 - y4 <= 40", lambda x: _always(_below(_gap(x, 5), 40.0), 0.0, 100.0)),
    _cars(
        "CC2",
        100.0,
        "always[0,70] eventually[0,30] y5 - y4 >= 15",
        lambda x: _always(_eventually(_from(_gap(x, 5), 15.0), 0.0, 30.0), 0.0, 70.0),
    ),
    # FalStar's files of 2019 have y5 - y4 <= 40 here; those of the other three, and of FReaK for 2024, have >= 40
    _cars("CC3", 100.0, "always[0,80] ((always[0,20] y2 - y1 <= 20) or (eventually[0,20] y5 - y4 >= 40))", _either),
    # always[0,5] in the files of FalStar, zlscheck and FReaK, always[0,20] in that of STGEM: both are driven
    _cars("CC4", 100.0, "always[0,65] eventually[0,30] always[0,5] y5 - y4 >= 8", _settles(5.0)),
    _cars("CC4-20", 100.0, "always[0,65] eventually[0,30] always[0,20] y5 - y4 >= 8", _settles(20.0)),
    _cars(
        "CC5",
        100.0,
        "always[0,72] eventually[0,8] ((always[0,5] y2 - y1 >= 9) implies (always[5,20] y5 - y4 >= 9))",
        _follows,
    ),
    _cars("CCx", 50.0, "always[0,50] y(i+1) - y(i) > 7.5, for i = 1 to 4", _apart),
)
