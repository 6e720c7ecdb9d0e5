"""The driver card of a chosen manoeuvre: what to drive, where, what to record, how often, what the answer means."""

from __future__ import annotations

import math
import shlex
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pytest_dvp.gap.compare.segments import UNITS
from pytest_dvp.gap.manoeuvres.choice import Choice, LargestDifference
from pytest_dvp.gap.manoeuvres.driving_limits import Envelope

if TYPE_CHECKING:
    from vehicle.model.vehicle_model import VehicleModel

RATE = 50  # Hz, of commands and motion
SLOW_RATE = 10  # Hz, enough for positions


def card(choice: Choice, model: VehicleModel, envelope: Envelope, noise: Mapping[str, float], files: Mapping[str, str],
         model_file: str = "MODEL.toml", logs: Sequence[str] = (), options: Sequence[str] = ()) -> str:  # fmt: skip
    """The card as text for a terminal or a printer. `files`: what was written, by kind.

    model_file, logs and options (each with its value): as the user gave them, for the commands that come next.
    """
    m, d = choice.manoeuvre, choice.drive
    source = f" ({m.source})" if m.source else ""
    x, y, _, v, rate = d.motion.T
    accel, steer = d.wishes[:, 0], d.wishes[:, 1]
    turns = float(np.max(np.abs(v * rate)))
    lines = [
        f"{m.title}{source}",
        f"  why      {_why(choice)}",
        f"  drive    {m.what}",
        f"           {d.seconds:.0f} s, {_times(choice.repeats)}; from standstill to standstill, a log for each",
        f"  where    flat, dry, free ground of {envelope.length:g} x {envelope.width:g} m; start {-d.area.x_min:.0f} m "
        f"from the end behind and {-d.area.y_min:.0f} m from the right side",
        f"           the path takes {np.ptp(x):.0f} x {np.ptp(y):.0f} m",
        f"  speed    up to {v.max():.1f} m/s ({3.6 * v.max():.0f} km/h)",
        f"  pedals   {accel.max():+.1f} to {accel.min():+.1f} m/s^2 asked for",
        f"  steering up to {math.degrees(np.abs(steer).max()):.1f} deg at the road wheels (times the steering ratio at "
        f"the wheel in hand), {turns:.1f} m/s^2 sideways",
        f"  record   {_record(model, noise)}",
    ]
    lines += [f"  {label:8s} {text}" for label, text in zip(["means", *[""] * 99], _meanings(choice), strict=False)]
    if choice.weak:
        lines.append("  but      this is the best within these limits, and may well not be enough: widen them")
    if choice.not_shown:
        lines.append(f"  not      {', '.join(choice.not_shown)}: nothing within these limits shows them")
    lines += [f"  {kind:8s} {path}" for kind, path in files.items()]
    if files and not model.inputs.by_a_stack:
        driven = " + ".join(model.inputs.longitudinal)
        lines.append(f"  rehearse not by dvp run: a driving stack has no {driven}, by which this model is driven")
    elif files:
        seconds = math.ceil(d.seconds / 10.0) * 10 + 10
        own = [
            word for pair in zip(options[::2], options[1::2], strict=True) if pair[0] == "--effects" for word in pair
        ]
        run = ["dvp", "run", files["scenario"], "--ads", f"{files['robot']}:Robot", "--model", model_file, *own]
        lines.append(f"  rehearse {shlex.join([*run, '--duration', str(seconds)])}")
    given = shlex.join(logs) if logs else "LOG..."
    lines.append(f"  then     dvp diagnose {given} {shlex.join([f'{m.name}.csv', '--model', model_file, *options])}")
    return "\n".join(lines)


def as_dict(choice: Choice, files: Mapping[str, str]) -> dict[str, Any]:
    """The entry of `plan --json`."""
    d = choice.drive
    return {
        "manoeuvre": choice.manoeuvre.name,
        "title": choice.manoeuvre.title,
        "source": choice.manoeuvre.source,
        "purpose": "named" if not choice.effects else "excite" if choice.exciting else "decide",
        "effects": list(choice.effects),
        "gap": choice.gap,
        "weak": choice.weak,
        "repeats": choice.repeats,
        "duration": d.seconds,
        "max_speed": float(d.motion[:, 3].max()),
        "max_lateral": float(np.max(np.abs(d.motion[:, 3] * d.motion[:, 4]))),
        "max_steer": float(np.max(np.abs(d.wishes[:, 1]))),
        "signs": [
            {"truth": s.truth or None, "other": s.other, "gap": s.gap, "channel": s.channel, "time": s.time,
             "difference": s.difference, "unit": UNITS[s.channel]} for s in choice.signs
        ],
        "ranking": dict(choice.ranking),
        "not_shown": list(choice.not_shown),
        "files": dict(files),
    }  # fmt: skip


def _why(choice: Choice) -> str:
    if not choice.effects:
        return "asked for by name; what it would show was not looked at"
    if choice.exciting:
        return f"shows {', '.join(choice.effects)}, if the car has {'it' if len(choice.effects) == 1 else 'them'}"
    return (
        f"tells {' from '.join(choice.effects)}: in its log chi^2/N grows by {choice.gap:.2g} or more with a wrong one"
    )


def _times(count: int) -> str:
    return "once" if count == 1 else f"{count} times"


def _record(model: VehicleModel, noise: Mapping[str, float]) -> str:
    fast = [
        *model.inputs.columns,
        *(name for name in noise if name not in ("x", "y") and name not in model.inputs.columns),
    ]
    slow = [name for name in ("x", "y") if name in noise]
    also = f"; {', '.join(slow)} at {SLOW_RATE} Hz or more" if slow else ""
    return f"{', '.join(fast)} at {RATE} Hz or more{also}, on one clock"


def _meanings(choice: Choice) -> list[str]:
    if choice.exciting:
        return [f"{s.other} of {s.size}: {_differs(s)}; if not, the car has none of that size" for s in choice.signs]
    best: dict[frozenset[str], LargestDifference] = {}
    for sign in choice.signs:
        best.setdefault(frozenset((sign.truth, sign.other)), sign)
    return [f"{s.truth}, if a model with {s.other} in its place {_differs(s)}" for s in best.values()]


def _differs(sign: LargestDifference) -> str:
    unit = UNITS[sign.channel]
    return f"differs in {sign.channel}, most at {sign.time:.1f} s by {abs(sign.difference):.2g} {unit}"
