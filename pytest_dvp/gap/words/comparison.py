"""A comparison in words and tables, for terminals, failing tests and gates."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from pytest_dvp.gap.compare.compare import Comparison, SignalScore
from pytest_dvp.gap.compare.error_location import Where
from pytest_dvp.gap.compare.match_bounds import BoundCheck
from pytest_dvp.gap.compare.segments import longest_step
from pytest_dvp.gap.compare.time_alignment import grid, on_grid
from pytest_dvp.logs.likeness import unlike_at

NOTHING_LEFT = 1.3  # chi^2/N up to which a signal counts as explained by its noise
CAUSES = ("v", "yaw_rate", "ax", "ay", "steer")
WORTH_SAYING = 0.1  # excess share of the error from which a regime is worth a sentence
LATE = 0.02  # s, least lag worth a word
NAMED_STRETCHES = 5  # that a line names, the longest
STEADY = 0.5  # of the squared error, from which an offset says more than a place
ALIKE = 0.5  # MNCC from which a signal tells a lag or a gain
TAKEN_BACK = 0.7  # of what a signal leaves, that a shift by its lag may leave; chosen: late drives leave up to 0.65 of
# it, brakes of 0.8 in place of 1, which are not late, 0.83
PART_NOT_JUDGED = 0.1  # of the time, from which the first line says that a part was not judged; chosen


def headline(comparison: Comparison) -> str:
    """One sentence: how far off the worst signal is, by how much it comes late, and where."""
    scores = {k: s for k, s in comparison.signals.items() if math.isfinite(s.chi2_per_n)}
    if not scores:
        return f"{comparison.model}: no sample could be compared"
    furthest = worst = max(scores, key=lambda name: scores[name].chi2_per_n)
    # Position and heading follow from speed and turn rate: where those are off already, they are what to look at
    causes = [name for name in CAUSES if name in scores and scores[name].chi2_per_n > NOTHING_LEFT]
    if causes:
        worst = max(causes, key=lambda name: scores[name].chi2_per_n)
    score = scores[worst]
    if score.chi2_per_n <= NOTHING_LEFT:
        share = slid_share(comparison)
        where = (
            "this log" if share < PART_NOT_JUDGED else f"the {100.0 * (1.0 - share):.0f} % of this log that is judged"
        )
        return (
            f"{comparison.model} explains every signal to its noise (worst: {worst}, chi²/N {score.chi2_per_n:.2f}); "
            f"nothing is left to find in {where}"
        )
    text = f"{comparison.model} misses {worst} by {amount(score)}, {math.sqrt(score.chi2_per_n):.1f} times its noise"
    if furthest not in (worst, *causes):
        more = math.sqrt(scores[furthest].chi2_per_n)
        text += f" ({furthest} misses by {more:.1f} times its noise, but follows from speed and turn rate)"
    steady = offset(comparison, worst)
    place = None if steady else worst_place(comparison.where, worst)
    return "; ".join([text, *late(comparison, worst), *steady, *([sentence(place)] if place else [])])


def offset(comparison: Comparison, channel: str) -> list[str]:
    """The mean of a channel's error, if it makes most of the squared error; else nothing."""
    left = comparison.residuals[channel]
    left = left[np.isfinite(left)]
    middle = float(left.mean()) if len(left) else 0.0
    share = middle**2 / float(np.mean(left**2)) if middle else 0.0
    if share < STEADY:
        return []
    unit = comparison.signals[channel].unit
    return [f"{share:.0%} of it is one offset: measured minus modelled is {middle:+.3g} {unit}".replace("%", " %")]


def late(comparison: Comparison, channel: str) -> list[str]:
    """By how much a channel's measurement comes later than the model, or earlier; nothing if that is not worth a word,
    or if a shift takes back little of the error: brakes that are too weak end later, too."""
    score = comparison.signals[channel]
    if score.lag is None or abs(score.lag) < LATE or (score.mncc or 0.0) < ALIKE:
        return []
    t, known = comparison.t, np.isfinite(comparison.residuals[channel])
    even = grid(t)
    measured, modelled = (
        on_grid(even, t, np.where(known, each[channel], np.nan)) for each in (comparison.measured, comparison.modelled)
    )
    samples = round(score.lag / float(even[1] - even[0]))
    if unlike_at(modelled, measured, samples) > TAKEN_BACK * unlike_at(modelled, measured, 0):
        return []
    return [f"it comes {abs(score.lag):.2f} s {'later' if score.lag > 0.0 else 'earlier'} than in the model"]


def covered(comparison: Comparison) -> str:
    """ "coverage 92 %, 2 gaps of 5.0 s together": the share of the time that was compared, and what is missing."""
    spans = np.diff(comparison.t)
    gaps = spans[spans > longest_step(comparison.t)]
    share = comparison.alignment.coverage
    # A log that is not whole must not read 100 %
    text = f"coverage {100.0 if share == 1.0 else min(100.0 * share, 99.9):.{0 if share in (0.0, 1.0) else 1}f} %"
    if not len(gaps):
        return text
    return f"{text}, {len(gaps)} gap{'s' * (len(gaps) > 1)} of {gaps.sum():.1f} s{' together' * (len(gaps) > 1)}"


def slid(comparison: Comparison) -> list[tuple[float, float]]:
    """Stretches (from, to) [s] that are not judged because the car slides or spins, or its heading is contradicted."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], comparison.slid.astype(np.int8), [0]]))).reshape(-1, 2)
    t = comparison.t
    return [(float(t[first]), float(t[min(end, len(t) - 1)])) for first, end in edges]


def slid_share(comparison: Comparison) -> float:
    """Share of the time, 0 to 1, in which the car slides or spins, or its heading is contradicted."""
    return sum(b - a for a, b in slid(comparison)) / max(float(comparison.t[-1] - comparison.t[0]), 1e-9)


def not_judged(comparison: Comparison) -> str:
    """ "not judged: 38 % of the time, 24.3-28.9 s, ...: ..."; empty if all that was compared is judged."""
    stretches = slid(comparison)
    if not stretches:
        return ""
    share = slid_share(comparison)
    longest = sorted(sorted(stretches, key=lambda one: one[0] - one[1])[:NAMED_STRETCHES])
    named = ", ".join(f"{a:.1f}-{b:.1f} s" for a, b in longest)
    more = f" and {len(stretches) - len(longest)} more" if len(stretches) > len(longest) else ""
    return (
        f"not judged: {100.0 * share:.0f} % of the time ({named}{more}): the car slides, spins or goes where it does "
        "not point, or its heading contradicts its yaw rate; from there to the end of a segment nothing is predicted"
    )


def worst_place(where: Sequence[Where], channel: str) -> Where | None:
    """The regime that holds most of a channel's error for its time, else the segment; None if it is everywhere."""
    for kind in ("regime", "speed", "segment"):
        for entry in where:
            if entry.channel == channel and entry.kind == kind and entry.excess >= WORTH_SAYING:
                return entry
    return None


def sentence(where: Where) -> str:
    """ "73 % of it in braking, which is 18 % of the time"."""
    name = where.regime.replace("turn_in", "turn-in").replace("_", " ")
    link = "at" if where.kind in ("speed", "place") else "in"
    return f"{where.share_of_error:.0%} of it {link} {name}, {where.share_of_time:.0%} of the time".replace("%", " %")


def amount(score: SignalScore) -> str:
    """RMSE with its unit."""
    return f"{score.rmse:.3g} {score.unit}"


def table(comparison: Comparison) -> list[str]:
    """Lines of the table of signals."""
    head = ("signal", "rmse", "unit", "noise", "chi²/N", "nrmse", "mncc", "lag [s]", "gain", "ISO 18571")
    rows = [head]
    for name, score in comparison.signals.items():
        rows.append((
            name, f"{score.rmse:.4g}", score.unit, f"{comparison.noise[name]:.2g}", f"{score.chi2_per_n:.2f}",
            "-" if score.nrmse is None else f"{100.0 * score.nrmse:.2f} %", _text(score.mncc, ".4f"),
            _text(score.lag, "+.3f"),
            _text(score.gain if (score.mncc or 0.0) >= ALIKE else None, ".3f"), _text(score.iso18571, ".3f"),
        ))  # fmt: skip
    return columns(rows)


def columns(rows: Sequence[Sequence[str]]) -> list[str]:
    """Rows of words as aligned lines, the first column to the left."""
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    lines = []
    for row in rows:
        cells = [
            cell.ljust(width) if k in (0, 2) else cell.rjust(width)
            for k, (cell, width) in enumerate(zip(row, widths, strict=True))
        ]
        lines.append("  ".join(cells).rstrip())
    return lines


def places(where: Sequence[Where], limit: int = 8) -> list[str]:
    """Lines of where the error sits: the regimes first, then the worst speed, segment and place."""
    chosen: list[Where] = [w for w in where if w.kind == "regime" and w.excess >= 0.05][:limit]
    for kind in ("speed", "segment", "place"):
        chosen += [w for w in where if w.kind == kind and w.excess >= 0.05][:2]
    if not chosen:
        return ["the error is spread evenly"]
    rows = [("channel", "where", "", "share of error", "share of time")]
    rows += [
        (w.channel, w.regime, "", f"{100.0 * w.share_of_error:.0f} %", f"{100.0 * w.share_of_time:.0f} %")
        for w in chosen
    ]
    return columns([(a, f"{b:<34}", c, d, e) for a, b, c, d, e in rows])


def skipped(not_compared: Mapping[str, str]) -> str:
    """Which channels were not compared and why, in one line; empty if none."""
    return "; ".join(f"{name}: {reason}" for name, reason in not_compared.items())


def _text(value: float | None, form: str) -> str:
    return "-" if value is None else format(value, form).replace("-0.000", "+0.000")


def failure(comparison: Comparison, judged: Sequence[BoundCheck]) -> str:
    """Why a model does not match: the broken bounds, the headline, and where the error of each broken signal sits."""
    broken = [one for one in judged if not one.holds]
    verb = "is" if len(broken) == 1 else "are"
    lines = [f"{comparison.model} does not match the log: {len(broken)} of {len(judged)} bounds {verb} broken"]
    for one in broken:
        place = worst_place(comparison.where, one.signal) if one.kind == "rmse" else None
        lines.append(f"  {one}" + (f"; {sentence(place)}" if place else ""))
    return "\n".join([*lines, headline(comparison), *table(comparison)])
