"""Whether the messages of a car are sound: faults of a wire, named from its messages alone; bad ones are kept back.

What is judged of each topic: numbers, stamps, their order and rhythm, and, of a moving car's position, that it moves
and does not jump. The rhythm is learnt from its first messages. Stamps may jitter: see `vehicle/wire/missing.py`.

    not_finite     NaN or infinity                                                       kept back
    ahead          stamped later than now                                                kept back
    stepped_back   stamped much earlier than the one before                              kept back
    out_of_order   stamped earlier than the one before                                   kept back
    repeated       stamped as the one before                                             kept back
    jump           a position that no car reaches from the last                          kept back
    lost           fewer messages than periods, told once enough have followed
    late           much older than its first ones were when they came
    silent         nothing for three intervals, and 0.2 s; for 3 s from a topic whose rhythm is not learnt yet
    frozen         a position that stands still while the wheels turn

Whoever sees more than one topic may name further ones: "not_obeyed", a car that echoes none of the last commands;
"elsewhere", a fix far from the car's own pose, kept back; "malformed: ...", a message of a form that is not understood;
"unfit: ...", a topic of another type, or of a quality of service (QoS) that does not match; of CAN frames "checksum"
and "length". What begins with "assumed:", "unmeasured:" or "unpaired:" is no fault but a note on what was made of
sound messages.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple, TypeVar

import numpy as np

from vehicle.messages import GnssFix, VehicleState
from vehicle.wire.missing import Missing, period_of

AHEAD = 0.02  # s; as the guard takes it
LEARNING = 8  # intervals from which the rhythm is learnt
AGAIN = 64  # intervals after which the rhythm is learnt anew; chosen: a few missing messages leave their median alone
SHORTER = 0.75  # of the rhythm learnt before: then messages were missing; chosen: two of the first nine make it 0.67
BACK = 0.2  # s; further back than any mix-up of the order
LATE = 0.15  # s more than at first; chosen: three ticks of a stack (vehicle.messages.TICK) have passed without it
SILENT = 0.2  # s, and three intervals
UNLEARNT = 3.0  # s of silence while the rhythm is not known: three intervals of 1 Hz, the slowest GNSS receivers
FASTEST = 60.0  # m/s
SLACK = 3.0  # m: noise of a position
STILL = 5  # positions, all alike
MOVING = 1.0  # m/s
REANCHOR = 5  # positions in a row that do not fit: the one before them was wrong

M = TypeVar("M")


class Trouble(NamedTuple):
    """A fault at time `t` [s] of arrival: topic, name as above, and how much of it: messages, seconds or metres."""

    t: float
    topic: str
    what: str
    amount: float

    def __str__(self) -> str:
        unit = {"lost": "messages", "frozen": "messages", "jump": "m", "elsewhere": "m"}.get(self.what, "s")
        plain = self.what in _PLAIN or ":" in self.what
        return self.what if plain else f"{self.what} {self.amount:.3g} {unit}"

    @property
    def is_note(self) -> bool:
        """Whether nothing is wrong: it only tells how messages were understood."""
        return self.what.startswith(NOTES)


NOTES = ("assumed:", "unmeasured:", "unpaired:")
_PLAIN = ("not_finite", "repeated", "not_obeyed", "checksum", "length")


class Health:
    """Of one car. `record` gets every trouble; times [s] are the harness's; the caller keeps `speed` [m/s] current."""

    def __init__(self, record: Callable[[Trouble], None]) -> None:
        self._record = record
        self.speed = 0.0
        self.reset()

    def reset(self, expected: Iterable[str] = ()) -> None:
        """A new run: nothing is known but which topics are `expected` to speak; any other may stay away."""
        self._topics: dict[str, _Rhythm] = {topic: _Rhythm() for topic in expected}

    def sift(self, topic: str, messages: Sequence[M], now: float, *, by_source: bool = True) -> list[M]:
        """Those of the `messages` that came on a topic until `now` [s] that may be used, in their order.

        `by_source`: their stamps are of when they were true; else of when they came, and a gap is none in the messages.
        """
        if not messages:  # a topic that has never spoken is not waited for
            return []
        rhythm = self._topics.setdefault(topic, _Rhythm())
        return [message for message in messages if self._judged(rhythm, topic, message, now, by_source)]

    def look(self, now: float) -> None:
        """Name each topic that has fallen silent by `now` [s]; once, until it speaks again."""
        for topic, rhythm in self._topics.items():
            if rhythm.silent:
                continue
            rhythm.since = min(rhythm.since, now)
            quiet = now - (rhythm.since if rhythm.last == -math.inf else rhythm.last) - rhythm.delay
            allowed = UNLEARNT if rhythm.interval is None else max(SILENT, 3.0 * rhythm.interval)
            if quiet > allowed + 1e-9:
                rhythm.silent = True
                self._record(Trouble(now, topic, "silent", quiet))

    def _judged(self, rhythm: _Rhythm, topic: str, message: Any, now: float, by_source: bool) -> bool:
        sound = self._sound(rhythm, topic, message, now)
        missing = rhythm.missing_with(float(message.t), now) if by_source else 0  # what is kept back has come, too
        if missing:
            self._record(Trouble(now, topic, "lost", missing))
        return sound

    def _sound(self, rhythm: _Rhythm, topic: str, message: Any, now: float) -> bool:
        def say(what: str, amount: float = 1.0) -> None:
            self._record(Trouble(now, topic, what, amount))

        if not finite(message):
            say("not_finite")
            return False
        stamp, last = float(message.t), rhythm.last
        if stamp > now + AHEAD + 1e-9:
            say("ahead", stamp - now)
            return False
        if stamp <= last:
            say(
                "repeated" if stamp == last else "stepped_back" if last - stamp > BACK else "out_of_order", last - stamp
            )
            return False
        jump = rhythm.jump(message)
        if jump > 0.0:
            say("jump", jump)
            rhythm.refused += 1
            if rhythm.refused < REANCHOR:
                return False
        rhythm.refused = 0
        if now - stamp > rhythm.delay + LATE + 1e-9 and rhythm.interval is not None:
            say("late", now - stamp)
        rhythm.take(message, stamp, now, moving=abs(self.speed) > MOVING)
        if rhythm.still == STILL:
            say("frozen", STILL)
        return True


class _Rhythm:
    """What is known of one topic: `interval` and `delay` [s] once learnt, the newest stamp, the newest position.

    since   when [s] it was looked at first
    still   positions in a row that are those before them although the car moves
    """

    def __init__(self) -> None:
        self.last, self.since, self.delay = -math.inf, math.inf, 0.0
        self.interval: float | None = None
        self.silent = False
        self.still = self.refused = 0
        self._newest: list[float] = []  # since the interval was learnt last
        self._missing = Missing()
        self._place: tuple[float, float, float] | None = None

    def jump(self, message: Any) -> float:
        """How far [m] a position is from any that the car could have reached; 0 if none is meant."""
        if self._place is None or not isinstance(message, GnssFix | VehicleState):
            return 0.0
        t, x, y = self._place
        away = math.hypot(message.x - x, message.y - y)
        return away if away > FASTEST * (message.t - t) + SLACK else 0.0

    def missing_with(self, stamp: float, now: float) -> int:
        """How many messages are known to be missing now that one of this stamp has come by `now` [s], sound or not."""
        if not (math.isfinite(stamp) and self.last - BACK <= stamp <= now + AHEAD):  # a clock that steps: of no grid
            return 0
        return self._missing.take(stamp, self.interval)

    def take(self, message: Any, stamp: float, now: float, *, moving: bool) -> None:
        """Remember a message that counts."""
        self._newest.append(stamp)
        if self.interval is None:
            self.delay = max(self.delay, now - stamp)
        if len(self._newest) > (LEARNING if self.interval is None else AGAIN):
            found = period_of(np.array(self._newest))
            if self.interval is None or found < SHORTER * self.interval:
                self.interval = found
            self._newest.clear()
        self.last, self.silent = stamp, False
        if isinstance(message, GnssFix | VehicleState):
            same = self._place is not None and self._place[1:] == (message.x, message.y)
            self.still = self.still + 1 if same and moving else 0
            self._place = (stamp, message.x, message.y)


def finite(value: Any) -> bool:
    """Whether each number in a message is one."""
    if isinstance(value, float):
        return math.isfinite(value)
    if isinstance(value, np.ndarray):
        return bool(np.isfinite(value).all())
    if isinstance(value, tuple):
        return all(map(finite, value))
    if hasattr(value, "__struct_fields__"):
        return all(finite(getattr(value, name)) for name in value.__struct_fields__)
    return True
