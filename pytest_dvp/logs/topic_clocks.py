"""The clocks of topics: stamps of the senders in their headers, held against when the recorder got each message."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from openscenario.findings import Findings
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.stream import Stream

APART = 2.0  # [s] between two clocks; less is for the doctor, as a slow pipeline stamps before it sends; chosen


def on_one_clock(
    streams: Sequence[Stream], used: Sequence[tuple[Stream, float]], file: str, findings: Findings
) -> Sequence[Stream]:
    """The streams, with the recorder's clock of those without a header moved to that of the headers, by the median of
    what lies between the two in the others: headers may count from 1970, the recorder from its first message.

    used: each stream that a signal takes its header's stamps from, and the delay [s] that the mapping takes off them.
    """
    apart = {
        (one.topic, delay): float(np.nanmedian(one.header - one.receive)) - delay
        for one, delay in used
        if one.header is not None and np.isfinite(one.header - one.receive).any()
    }
    _check_apart(apart, file, findings)
    bare = {id(one): one.topic for one, _ in used if one.header is None and not (one.si and "t" in one.fields)}
    if not apart or not bare:
        return streams
    shift = float(np.median(list(apart.values())))
    for topic in dict.fromkeys(bare.values()):
        findings.add(
            "log.no_header", file, None, topic, "its messages have no header: the recorder's clock is taken, moved by "
            f"the {shift:.6g} s between the two clocks of the other topics", severity="warning",
        )  # fmt: skip
    return [dataclasses.replace(s, receive=s.receive + shift) if id(s) in bare else s for s in streams]


def _check_apart(apart: dict[tuple[str, float], float], file: str, findings: Findings) -> None:
    """An error for each topic whose sender's clock is another one than that of the first topic."""
    (first, _), reference = next(iter(apart.items()), (("", 0.0), 0.0))
    for (topic, delay), ahead in apart.items():
        off = ahead - reference
        if abs(off) > APART:
            findings.add(
                "log.clock_offset", file, None, topic,
                f"its headers are {_seconds(abs(off))} s {'ahead of' if off > 0.0 else 'behind'} those of {first}, "
                "by when the recorder got them",
                allowed=f"{APART:g} s", hint=f"senders whose clocks differ (GPS time is 18 s ahead of UTC): with "
                f"`delay = {_seconds(off + delay)}` in the entries of {topic} the stamps are corrected; or take the "
                'recorder\'s, `time = "receive"`',
            )  # fmt: skip


def check_stamps(t: FloatArray, stream: Stream, file: str, findings: Findings) -> None:
    """Add a finding for stamps (n,) [s] of a topic that go back, and one for stamps that repeat."""
    steps = np.diff(t)
    back = np.flatnonzero(steps < 0)
    if len(back):
        i = int(back[0])
        findings.add(
            "log.time_not_monotonic", file, None, stream.topic,
            f"time jumps back {len(back)} times, first by {-steps[i]:.6g} s after t = {t[i]:.6g} s",
            found=f"{t[i + 1]:.6g} s after {t[i]:.6g} s", allowed="rising time",
            hint="a clock that was set, or two recordings in one: cut the file there",
        )  # fmt: skip
    same = int(np.count_nonzero(steps == 0))
    if same:
        findings.add(
            "log.duplicate_messages", file, None, stream.topic,
            f"{same} messages repeat the time of the one before; the first of each is kept", severity="warning",
        )  # fmt: skip


def _seconds(value: float) -> str:
    """To the millisecond, however many seconds there are: 18, -1699999900.25."""
    return f"{value:.3f}".rstrip("0").rstrip(".")
