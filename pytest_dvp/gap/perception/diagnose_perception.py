"""Which perception effect a model lacks, judged on detected boxes against the objects that were there.

Every effect here has a likelihood of its own, so nothing is simulated: positions give latency, offset and noise, frames
without a box give misses and range, boxes without an object give false objects, each counted once when it appears.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping, Sequence
from math import hypot, inf, isfinite, isinf, log
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import chi2 as chi2_distribution
from scipy.stats import t as student

from pytest_dvp.gap.compare.start_correction import BoolArray
from pytest_dvp.gap.diagnose.diagnosis import Action, Estimate, NamedEffect
from pytest_dvp.gap.perception import behind_others
from pytest_dvp.gap.perception.behind_others import Behind, needed_behind
from pytest_dvp.gap.perception.box_fit import Boxes
from pytest_dvp.gap.perception.detection_pairs import CLEAR, Frames, Pairs, frames, paired
from pytest_dvp.gap.perception.fresh_detections import measured_only
from pytest_dvp.gap.perception.noise_levels import LIKELY, UNSETTLED, noise_differs
from pytest_dvp.gap.perception.on_top import DAMPENED, on_top
from pytest_dvp.gap.perception.perceived_values import Perceived
from pytest_dvp.gap.perception.position_fit import BLOCK, Positions
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray

if TYPE_CHECKING:
    from vehicle.model.effect import Effect
    from vehicle.model.vehicle_model import VehicleModel

LEAST_PAIRS = 50  # 5 s of one object at 10 Hz; with fewer, nothing is said of perception
FIRST_GATE = (4.0, 0.05)  # m and its growth with distance, wide enough for half a second of latency at town speed
_GATE = 5.0  # standard deviations of the noise, later on
_LEAST_GATE = 0.5  # m
_LATEST = 5.0  # s, the maximum of detection_latency
_STARTS = (0.8, 1.6, 2.4, 3.2, 4.0, 4.8)  # s: latencies from which a fit begins as well, so that FIRST_GATE holds each
_MATCHED = 0.9  # share of boxes that belong to objects, from which on no other start is tried; chosen
_MORE = 1.05  # times the boxes that another start must match to be taken; chosen: false objects match by chance
_ROUNDS = 5  # of fitting and pairing anew, at most; chosen
_STRAY = 0.005  # chance that a box beyond the range is taken for the object
_BEYOND = 0.05  # share of frames beyond a border in which an object is seen all the same, at most
_RIVAL = 2.0  # difference of log-likelihood per block below which two effects are not told apart
_ONE = 2.0  # m, how well one object shows a range: a car that comes at 10 m/s is believed some 0.2 s sooner or later
_BORDER = 3.0  # log-likelihood: 95 % for a border, whose likelihood falls off exponentially
_LEAVES_NO = {
    "noise": ("misses", "false"),
    "false": ("noise", "misses", "range", "occlusion"),
}  # with a twin beside, all other effects leave these
# two behind, so they wait for them
_WAITS_FOR = {"misses": ("noise",), "occlusion": ("size", "yaw")}  # noise makes a tracker lose what it follows; wrong
# boxes hide others more, and are paired worse where they are hidden themselves
_SIGMAS = 1.96  # standard deviations in half a 95 % interval
_UNSURE = 0.1  # how well a border of occlusion is known at best: boxes do not fill what they stand for
_LEAST_HIDDEN = 20  # rows of objects that are partly behind others, from which on these show where it ends
_ORDER = ("latency", "offset", "range", "misses", "false", "noise", "size", "yaw", "occlusion")


def diagnose_perception(measured: Log, model: VehicleModel, *, twin: Log | None = None) -> tuple[NamedEffect, ...]:
    """The perception effects in which a model differs from the detections of a log, what explains most first.

    Compared with the values of the model's own perception effects or, given a `twin`, the log of a run of that model,
    with what its detections show; the values are then those that the model needs on top of its sensors
    (`pytest_dvp.gap.perception.on_top`). An effect is named if its value differs by at least Key.least and outside the
    95 % interval (that of the difference with a `twin`): clustered by object and block of 5 s; range by profile
    likelihood and by objects left out; false objects by the exact Poisson interval; size and yaw by object; noise, with
    a `twin`, by its level nearby (`pytest_dvp.gap.perception.noise_levels`). With a `twin`, a value that the model has
    and trackers dampen is named until it is settled; and what others that are named leave behind is provisional: noise
    and false objects, and misses beside noise. gain: share of the log-likelihood of all effects named.

    () for a run of a stage without a `twin`, for its detections come from simulated sensors, with all that those do to
    them; also for a log without detections or objects, or with fewer than 50 pairs of them.
    Objects in directions in which the detector hardly ever sees one do not count as missed; hidden ones do, for a log
    does not say what hides what.
    """
    if twin is None and simulated_sensors(measured):
        return ()
    found = perceived_in(measured)
    if found is None:
        return ()
    from vehicle.model.effect_catalogue import catalogue

    other = perceived_in(twin) if twin is not None else None
    named = []
    for part in _ORDER:
        name = f"detection_{part}"
        effect = catalogue()[name]
        lacks = part == "occlusion" and other is not None and _puts_behind(found, other, model)
        keys = [k for k in effect.parameters if (name, k.name) in found.values]
        if not keys:
            continue
        if part == "occlusion" and other is not None:
            differs = lacks
        elif part == "noise" and found.levels is not None and other is not None and other.levels is not None:
            differs = noise_differs(found.levels, other.levels, any(a.name == name for a in model.effects))
        else:
            differs = any(_differs(found, other, model, effect, k.name) for k in keys)
        if differs:
            named.append(name)
    seen = found if other is None else on_top(found, other, model)
    if other is not None:
        named = [name for name in named if _moves(seen, model, catalogue()[name])]
        late = {name: causes for name in named if (causes := _left_by(name, named))}
        seen = dataclasses.replace(seen, rivals={**seen.rivals, **late})
    total = max(sum(found.worth[name] for name in named), 1e-9)
    named.sort(key=lambda name: (-found.worth[name], name))
    return tuple(_named(name, seen, model, catalogue()[name], found.worth[name] / total) for name in named)


def simulated_sensors(measured: Log) -> bool:
    """Whether the detections of a log are of simulated sensors: of a run of any stage whose objects are known."""
    return bool(measured.meta.get("stage"))


def diagnose_perceptions(
    logs: Iterable[Log], model: VehicleModel, twins: Mapping[str, Log] | None = None
) -> tuple[NamedEffect, ...]:
    """The same of several logs; an effect that several show is told as the log with the narrowest interval has it.
    twins: by scenario, as meta["scenario"] has it."""
    best: dict[str, NamedEffect] = {}
    for measured in logs:
        twin = (twins or {}).get(measured.meta.get("scenario", ""))
        for effect in diagnose_perception(measured, model, twin=twin):
            if effect.name not in best or _width(effect) < _width(best[effect.name]):
                best[effect.name] = effect
    return tuple(sorted(best.values(), key=lambda e: (-e.gain, e.name)))


def _width(effect: NamedEffect) -> float:
    return max(e.high - e.low if isfinite(e.value) else inf for e in effect.parameters.values())


def _left_by(name: str, named: Sequence[str]) -> tuple[str, ...]:
    """Of the effects named those that leave behind what looks like this one."""
    part, parts = name.removeprefix("detection_"), [other.removeprefix("detection_") for other in named]
    if part in _LEAVES_NO:
        kept = [other for other in parts if other not in (part, *_LEAVES_NO[part])]
    else:
        kept = [other for other in parts if other in _WAITS_FOR.get(part, ())]
    return tuple(f"detection_{other}" for other in kept)


def _differs(found: Perceived, twin: Perceived | None, model: VehicleModel, effect: Effect, key: str) -> bool:
    value, low, high = found.values[effect.name, key]
    declared = effect.key(key)
    if twin is not None and (effect.name, key) in twin.values:
        base, base_low, base_high = twin.values[effect.name, key]
    else:
        given = model.value(effect.name, key)
        base = base_low = base_high = declared.neutral if given is None else given
    if isinf(value) or isinf(base):  # no border was found: it is beyond what was seen, which `low` tells
        return isinf(value) != isinf(base) and (low > base_high + declared.least or high + declared.least < base_low)
    unsure = hypot(value - low, base_high - base) if value > base else hypot(high - value, base - base_low)
    apart = abs(value - base)
    present = twin is not None and model.value(effect.name, key) is not None
    if present and (effect.name, key) in DAMPENED:  # an interval says nothing of how much a tracker dampens
        moves = max(UNSETTLED * abs(value - declared.neutral), LIKELY / _SIGMAS * unsure)
        return apart >= min(moves, max(declared.least, unsure))
    return apart >= max(declared.least, unsure)


def _puts_behind(found: Perceived, twin: Perceived, model: VehicleModel) -> bool:
    """Puts what a model needs of `detection_occlusion` into what a car's log shows; True if it lacks that."""
    if found.behind is None or twin.behind is None:
        return False
    lost, lacks = needed_behind(found.behind, twin.behind, model.effects)
    found.values.pop(behind_others.SHARE, None)
    twin.values.pop(behind_others.SHARE, None)
    if lost is not None:
        found.values[behind_others.SHARE], found.values[behind_others.LIDAR] = lost.share, lost.lidar
        found.worth[behind_others.NAME] = lost.gain
    return lacks


def _moves(seen: Perceived, model: VehicleModel, effect: Effect) -> bool:
    """Whether a value that the model needs is another than it has: a car whose sensors are better than the model's
    own asks for less than none."""
    for k in effect.parameters:
        if (effect.name, k.name) in seen.values:
            given = model.value(effect.name, k.name)
            base, value = k.neutral if given is None else given, seen.values[effect.name, k.name][0]
            if value != base and (isinf(value) or isinf(base) or abs(value - base) >= k.least):
                return True
    return False


def _named(name: str, found: Perceived, model: VehicleModel, effect: Effect, gain: float) -> NamedEffect:
    estimates = {k.name: Estimate(*found.values[name, k.name], k.unit) for k in effect.parameters
                 if (name, k.name) in found.values}  # fmt: skip
    present = any(a.name == name for a in model.effects)
    off = all(_near_neutral(effect, key, e) for key, e in estimates.items())
    action: Action = "remove" if present and off else "change" if present else "add"
    rivals = found.rivals.get(name, ())
    return NamedEffect(
        name=name, parameters=estimates, rivals=rivals, gain=gain, action=action,
        standing="provisional" if rivals else "confirmed",
        doubts=(f"these data cannot tell it from {', '.join(rivals)}",) if rivals else (),
    )  # fmt: skip


def _near_neutral(effect: Effect, key: str, e: Estimate) -> bool:
    declared = effect.key(key)
    return e.value == declared.neutral or abs(e.value - declared.neutral) < declared.least


def perceived_in(measured: Log) -> Perceived | None:
    """What the detections of a log show; None without enough of them."""
    if not len(measured.detections.t) or not measured.objects or not {"x", "y", "yaw"} <= set(measured.columns):
        return None
    measured = dataclasses.replace(measured, detections=measured_only(measured.detections))
    f = frames(measured)
    if f is None:
        return None
    found = _placed(f, 0.0)
    if found is None or int(found[0].seen.sum()) < _MATCHED * len(f.x):  # they may be later than the gate allows
        start = _best_start(f)
        found = (_placed(f, start) if start else None) or found
    return _Seen(f, *found).perceived() if found is not None else None


def _placed(f: Frames, start: float) -> tuple[Pairs, Positions, FloatArray] | None:
    """Pairs, their fit, and latency [s] with offset x, y [m] (3,), found in rounds from a latency `start` [s] on; None
    with too few pairs."""
    place = np.array([start, 0.0, 0.0])
    noise = np.array([0.3, 0.0])
    gate = FIRST_GATE
    for _ in range(_ROUNDS):
        pairs = paired(f, float(place[0]), (float(place[1]), float(place[2])), gate)
        if int(pairs.seen.sum()) < LEAST_PAIRS:
            return None
        fitted = Positions(f, pairs, noise)
        place = place + fitted.step
        place[0] = min(max(float(place[0]), 0.0), _LATEST)
        noise = fitted.noise
        gate = (_LEAST_GATE + _GATE * float(noise[0]), _GATE * float(noise[1]))
    return pairs, fitted, place


def _best_start(f: Frames) -> float:
    """The latency [s] of _STARTS with which most boxes belong to an object, 0 if none does clearly better than that."""
    least = _MORE * int(paired(f, 0.0, (0.0, 0.0), FIRST_GATE).seen.sum())
    matched = {start: int(paired(f, start, (0.0, 0.0), FIRST_GATE).seen.sum()) for start in _STARTS}
    best = max(matched, key=lambda start: matched[start])
    return best if matched[best] > least else 0.0


class _Seen:
    """Range, misses and false boxes, and everything put together."""

    def __init__(self, f: Frames, p: Pairs, fitted: Positions, place: FloatArray) -> None:
        self.f, self.p, self.fitted, self.place = f, p, fitted, place
        looked_at = p.in_field_of_view()
        self.boxes = Boxes(f, p, float(place[0]))
        self.partly = looked_at & (p.hidden > CLEAR)
        rows = looked_at & (p.hidden <= CLEAR)
        frame, thing = np.nonzero(rows)
        order = np.argsort(p.distance[rows], kind="stable")
        self.far = p.distance[rows][order]
        self.seen = p.seen[rows][order]
        self.block = ((f.t[frame] // BLOCK).astype(np.int64) * 1000 + thing)[order]
        self.thing = thing[order]

    def perceived(self) -> Perceived:
        """All of it."""
        z, q = self.fitted, self.place
        values: dict[tuple[str, str], tuple[float, float, float]] = {}
        worth: dict[str, float] = {}

        blocks = len(np.unique(z.blocks))

        def put(
            name: str, key: str, value: float, spread: float, least: float = -inf, of: int = blocks, most: float = inf
        ) -> None:
            wide = _t(of) * spread
            values[name, key] = (value, max(value - wide, least), min(value + wide, most))

        if np.isfinite(z.spread[0]):
            put("detection_latency", "T", float(q[0]), float(z.spread[0]), 0.0)
        put("detection_offset", "x", float(q[1]), float(z.spread[1]))
        put("detection_offset", "y", float(q[2]), float(z.spread[2]))
        put("detection_noise", "sigma0", float(z.noise[0]), float(z.noise_spread[0]), 0.0)
        put("detection_noise", "slope", float(z.noise[1]), float(z.noise_spread[1]), 0.0)
        worth["detection_latency"], worth["detection_offset"] = z.loss(q, (0,)), z.loss(q, (1, 2))
        worth["detection_noise"] = z.noise_worth()
        rivals = self._position_rivals()
        reach, low, high, gained, alone = self._range()
        values["detection_range", "R"] = (reach, low, high)
        worth["detection_range"] = gained
        rate, spread, missed = self._misses(reach)
        put("detection_misses", "rate", rate, spread, 0.0, len(np.unique(self.block[self.far <= reach])), 1.0)
        worth["detection_misses"] = missed
        if 0.0 < gained < _RIVAL + alone and rate > 0.0:
            rivals["detection_range"] = ("detection_misses",)
        self._add_boxes(values, worth)
        share, low, high, worth["detection_occlusion"] = self._occlusion(reach)
        if isfinite(share):
            values["detection_occlusion", "share"] = (share, low, high)
        values["detection_false", "rate"] = _poisson(self.p.false, self.f.duration)
        expected = max(values["detection_false", "rate"][0], 1e-9)
        worth["detection_false"] = self.p.false * log(max(expected / 1e-3, 1.0))
        return Perceived(values, worth, rivals, z.levels(), self._behind())

    def _add_boxes(self, values: dict[tuple[str, str], tuple[float, float, float]], worth: dict[str, float]) -> None:
        """Size and yaw, if the boxes tell them."""
        b = self.boxes
        if not b.objects:
            return
        keys = (("detection_size", "length_ratio"), ("detection_size", "width_ratio"), ("detection_yaw", "b"))
        for key, mean, spread in zip(keys, b.mean.tolist(), b.spread.tolist(), strict=True):
            wide = _t(b.objects) * spread
            values[key] = (mean, mean - wide, mean + wide)
        worth["detection_size"], worth["detection_yaw"] = (float(w) for w in b.worth)

    def _occlusion(self, reach: float) -> tuple[float, float, float, float]:
        """Share of an object behind others up to which it is seen, its interval, and the log-likelihood it brings; NaN
        if too few were partly behind others, 1 if they are seen all the same."""
        rows = self.partly & (self.p.distance <= reach)
        share, seen = self.p.hidden[rows], self.p.seen[rows]
        if len(share) < _LEAST_HIDDEN:
            return float("nan"), 0.0, 1.0, 0.0
        order = np.argsort(share, kind="stable")
        share, seen = share[order], seen[order]
        likelihood = _likelihood(seen)
        best = int(np.argmax(likelihood))
        gained = float(likelihood[best] - likelihood[-1])
        if best == len(share) or gained < _BORDER:
            return 1.0, float(share[seen].max(initial=CLEAR)), 1.0, 0.0
        likely = np.flatnonzero(likelihood > likelihood[best] - _BORDER)
        low = float(share[max(int(likely[0]) - 1, 0)]) if likely[0] else 0.0
        value = 0.5 * float(share[best] + (share[best - 1] if best else 0.0))
        high = float(share[min(int(likely[-1]), len(share) - 1)])
        return value, max(min(low, value - _UNSURE), 0.0), max(high, value + _UNSURE), gained

    def _behind(self) -> Behind:
        """Rows of what is partly behind others, near."""
        rows = self.partly & (self.p.distance < behind_others.NEAR)
        frame, thing = np.nonzero(rows)
        block = (self.f.t[frame] // behind_others.BLOCK).astype(np.int64) * 1000 + thing
        clear = self.p.in_field_of_view() & (self.p.hidden <= CLEAR) & (self.p.distance < behind_others.NEAR)
        seen = float(self.p.seen[clear].mean()) if clear.any() else 1.0
        return Behind(self.p.hidden[rows], self.p.seen[rows], block, seen)

    def _position_rivals(self) -> dict[str, tuple[str, ...]]:
        """Latency and offset are told apart only by objects that move in different ways."""
        z = self.fitted
        found: dict[str, tuple[str, ...]] = {}
        if not np.isfinite(z.spread[0]):
            return {"detection_offset": ("detection_latency",)}
        both = z.loss(self.place, (0, 1, 2))
        blocks = len(np.unique(z.blocks))
        for name, other, without in (("latency", "offset", (0,)), ("offset", "latency", (1, 2))):
            lost = z.loss(self.place, without)
            if both > 20.0 and lost < 0.02 * both and lost / blocks < _RIVAL:
                found[f"detection_{name}"] = (f"detection_{other}",)
        return found

    def _range(self) -> tuple[float, float, float, float, float]:
        """Range [m] with its interval, the log-likelihood that it brings, and that of misses without a range.

        Without a border the range is inf, from the farthest that was seen on. One object shows a border no better than
        to where it is first believed to be there, so the interval is as wide as the borders of the others let it be.
        """
        n = len(self.far)
        likelihood = _likelihood(self.seen)
        best = int(np.argmax(likelihood))
        never = 0.5 * float(likelihood[-1] - n * log(0.5)) if n else 0.0
        gained = float(likelihood[best] - likelihood[-1]) if n else 0.0
        # A range is a border with hardly anything seen beyond it, and enough not seen in several blocks
        unseen = len(np.unique(self.block[best:][~self.seen[best:]]))
        if best == 0 or best == n or gained < 10.0 or unseen < 2:
            return inf, float(self.far[self.seen].max(initial=0.0)), inf, 0.0, never
        likely = np.flatnonzero(likelihood > likelihood[best] - _BORDER)
        low, high = self.far[max(int(likely[0]) - 1, 0)], self.far[min(int(likely[-1]), n - 1)]
        reach = 0.5 * (self.far[best - 1] + self.far[best])
        unsure = self._between_objects(float(reach))
        return float(reach), float(min(low, reach - unsure)), float(max(high, reach + unsure)), gained, 0.0

    def _between_objects(self, reach: float) -> float:
        """Half of a 95 % interval [m] of the range from how it moves with each object left out (jackknife); of a border
        that one object alone has crossed _ONE."""
        things = np.unique(self.thing)
        crossed = [k for k in things.tolist() if self._crosses(k, reach)]
        if len(crossed) < 2:
            return _ONE
        moved = []
        for k in crossed:
            others = self.thing != k
            far, likelihood = self.far[others], _likelihood(self.seen[others])
            best = min(max(int(np.argmax(likelihood)), 1), len(far) - 1)
            moved.append(0.5 * (far[best - 1] + far[best]))
        m = len(moved)
        return 1.96 * float(np.sqrt((m - 1) / m * np.sum((np.array(moved) - np.mean(moved)) ** 2)))

    def _crosses(self, thing: int, reach: float) -> bool:
        """Whether an object was there on both sides of the border."""
        far = self.far[self.thing == thing]
        return bool(far.min() < reach < far.max())

    def _misses(self, reach: float) -> tuple[float, float, float]:
        """Share of frames missed within the range, its standard deviation by blocks, and its log-likelihood."""
        inside = self.far <= reach
        missed = ~self.seen[inside]
        if not len(missed):
            return 0.0, inf, 0.0
        rate = float(missed.mean())
        index = np.unique(self.block[inside], return_inverse=True)[1]
        scores = np.bincount(index, weights=missed - rate)
        blocks = len(scores)
        spread = float(np.sqrt((scores @ scores) * blocks / max(blocks - 1, 1))) / len(missed)
        spread = max(spread, float(np.sqrt(max(rate * (1.0 - rate), 1.0 / len(missed)) / len(missed))))
        count = float(missed.sum())
        gained = count * log(max(rate, 1e-9) / _STRAY) + (len(missed) - count) * log(max(1.0 - rate, 1e-9))
        return rate, spread, max(gained, 0.0) if count else 0.0


def _likelihood(seen: BoolArray) -> FloatArray:
    """Log-likelihood of a border before each row and after the last, rows in the order of their distance (n + 1,);
    -inf where too much is seen beyond it for a border."""
    n = len(seen)
    hit = np.concatenate([[0], np.cumsum(seen)]).astype(np.float64)
    rows = np.arange(n + 1, dtype=np.float64)
    miss = rows - hit
    share = np.clip(miss / np.maximum(rows, 1.0), 1e-4, 1.0 - 1e-4)
    beyond_hit, beyond_miss = hit[-1] - hit, miss[-1] - miss
    likely = (
        hit * np.log(1.0 - share) + miss * np.log(share) + beyond_hit * log(_STRAY) + beyond_miss * log(1.0 - _STRAY)
    )
    likely[beyond_hit > _BEYOND * (n - rows)] = -inf
    return np.asarray(likely)


def _t(blocks: int) -> float:
    """Standard deviations of a 95 % interval whose errors are known from so many independent blocks (Student)."""
    return float(student.ppf(0.975, max(blocks - 1, 1)))


def _poisson(count: int, duration: float) -> tuple[float, float, float]:
    """Rate [1/s] with its exact interval (Garwood 1936)."""
    low = float(chi2_distribution.ppf(0.025, 2 * count)) / 2.0 if count else 0.0
    high = float(chi2_distribution.ppf(0.975, 2 * count + 2)) / 2.0
    return count / duration, low / duration, high / duration
