"""A diagnosis as text for a terminal."""

from __future__ import annotations

import math
import shlex
from collections.abc import Iterator, Sequence
from pathlib import Path

from pytest_dvp.gap.compare.segments import UNITS
from pytest_dvp.gap.diagnose.diagnosis import Diagnosis, Estimate, NamedEffect, Step
from pytest_dvp.gap.diagnose.error_shares import Share, percents, shares
from pytest_dvp.gap.diagnose.standing import MUCH_LEFT
from pytest_dvp.gap.words.comparison import CAUSES, NOTHING_LEFT
from pytest_dvp.gap.words.residual_signature import signature_lines
from vehicle.model.bus import GRAVITY
from vehicle.model.effect_catalogue import perception_effect_names
from vehicle.model.remainder import Remainder

SHOWN = 3  # signals whose own error the ladder shows
_SIGNS = {"add": "+", "change": "~", "remove": "-"}
SLIGHT = 0.01  # of the error: what explains less is told apart
LEADING = 4  # effects that the first sentence names
WIDTH = 112  # of a line, about


def page(found: Diagnosis, *, model: str = "the model", command: str = "", plan: str = "", trial: str = "") -> str:
    """The whole answer: verdict, effects, ladder, what the data could not show, and what to do next.

    `model` as the user named it; `command` adds what was found, see `extend_command`; `plan` finds the drive that
    decides, see `plan_command`; `trial` adds what is provisional besides, see `trial_command`.
    """
    lines = [f"{found.verdict}: {headline(found, model)}"]
    if found.effects:
        lines += ["", *_effects(found)]
    lines += ["", *_ladder(found)]
    lines += _notes(found)
    drives = [f"to tell {e.name} from its rivals, drive {e.deciding_manoeuvre}" for e in found.effects
              if e.rivals and e.deciding_manoeuvre]  # fmt: skip
    after = [f"next: {command}"] if command else []
    after += [f"to try what is provisional: {trial}"] if trial else []
    before = drives or ([f"what to drive to know more: {plan}"] if plan else [])
    return "\n".join([*lines, "", *before, *after]).rstrip()


def headline(found: Diagnosis, model: str = "the model") -> str:
    """One sentence that a reader understands who knows nothing of the method."""
    first, last = found.ladder[0].chi2_per_n, found.ladder[-1].chi2_per_n
    little = "no more than the twin's known remainder" if found.remainder else "sensor noise"
    if found.verdict == "NOTHING_MISSING":
        judged = "these data"
        if found.samples.slides > PART_NOT_JUDGED:
            judged = f"the {_rate(1.0 - found.samples.slides)} of these data that can be judged"
        return f"{model} lacks nothing that {judged} show: what is left is {little} (chi²/N {figure(last)})"
    if found.verdict == "NOT_EXCITED":
        many = len(found.not_excited)
        return f"nothing was found missing in {model}, but this drive could not have shown {many} of the effects"
    left = f"chi²/N {figure(last)}{_worst(found)}"
    before, after = first, last
    if found.remainder and last <= 1.0 and (apart := found.ladder[-1].held_out_chi2_per_n) is not None and apart > 1.0:
        left = f"chi²/N {figure(last)}, on data held out {figure(apart)}"  # only these show what is left
        before, after = found.ladder[0].held_out_chi2_per_n or apart, apart
    if found.verdict == "UNKNOWN":
        everywhere = " on all drives" if found.vetoed else ""
        return f"{model} misses something that no effect of the catalogue explains{everywhere} ({left})"
    lacks = _lacks(found, model)
    if found.verdict == "PARTIAL" and len(found.ladder) == 1:
        return f"{lacks}; what is left no effect of the catalogue explains ({left})"
    if found.verdict == "PARTIAL":
        (share,) = percents([max(1.0 - (after - 1.0) / max(before - 1.0, 1e-9), 0.0)])
        share = "more than 99 %" if share == "100 %" else share  # a rest is told in the same sentence
        return f"{lacks}; that explains {share} of the error, and no effect of the catalogue explains the rest ({left})"
    only = little if found.remainder else f"only {little}"
    if len(found.ladder) == 1:  # nothing but effects on detections
        return f"{lacks}; apart from that {only} is left (chi²/N {figure(last)})"
    return f"{lacks}; after that {only} is left (chi²/N {figure(first)} -> {figure(last)})"


def extend_command(
    found: Diagnosis, model: str, logs: Sequence[str], held_out: Sequence[str] = (), options: Sequence[str] = ()
) -> str:
    """The command that adds what is confirmed of the car; empty if there is nothing to add. options: its further words,
    such as `--map F`, without which the logs cannot be read."""
    return _extending([e for e in found.effects if e.standing == "confirmed"], found, model, logs, held_out, options)


def trial_command(
    found: Diagnosis, model: str, logs: Sequence[str], held_out: Sequence[str] = (), options: Sequence[str] = ()
) -> str:
    """As `extend_command`, with what is provisional by name as well; empty if nothing is."""
    if not _provisional(found):
        return ""
    return _extending(found.effects, found, model, logs, held_out, options)


def _provisional(found: Diagnosis) -> list[str]:
    return [e.name for e in found.effects if e.standing == "provisional" and e.name not in found.set_up]


def _extending(
    effects: Sequence[NamedEffect], found: Diagnosis, model: str, logs: Sequence[str], held_out: Sequence[str],
    options: Sequence[str],
) -> str:  # fmt: skip
    wanted = [e for e in effects if e.name not in found.set_up]
    add = [e.name for e in wanted if e.action != "remove"]
    remove = [e.name for e in wanted if e.action == "remove"]
    if not add and not remove:
        return ""
    words = ["dvp", "extend", "--model", model]
    for option, values in (("--add", add), ("--remove", remove), ("--fit", logs), ("--held-out", held_out)):
        words += [option, *values] if values else []
    return shlex.join([*words, "--out", f"{Path(model).stem}.extended.toml", *options])


def plan_command(
    found: Diagnosis, model: str, logs: Sequence[str], held_out: Sequence[str] = (), options: Sequence[str] = ()
) -> str:
    """The command that finds the drive which decides between rivals, or shows what these data could not.

    Empty if nothing is open, or the drive is known already.
    """
    undecided = any(e.rivals and not e.deciding_manoeuvre for e in found.effects)
    if not undecided and found.verdict != "NOT_EXCITED":
        return ""
    judges = [word for log in held_out for word in ("--held-out", log)]
    return shlex.join(["dvp", "plan", *logs, *judges, "--model", model, *options])


def step_label(found: Diagnosis, step: Step) -> str:
    """ "+ steer_delay", "~ mass", "- aero_drag", or the model as given."""
    action = next((e.action for e in found.effects if e.name == step.added), "add")
    return f"{_SIGNS[action]} {step.added}" if step.added else "model as given"


def value(estimate: Estimate) -> str:
    """ "0.252" with as many digits as its interval gives meaning."""
    return f"{estimate.value:.{_digits(estimate)}f}"


def interval(estimate: Estimate) -> str:
    """ "0.250 to 0.255"."""
    digits = _digits(estimate)
    return f"{estimate.low:.{digits}f} to {estimate.high:.{digits}f}"


def causes(step: Step, limit: int = SHOWN) -> list[str]:
    """Signals with the most error at a step, those first that others follow from."""

    off = any(level > NOTHING_LEFT for level in step.channels.values())

    def order(name: str) -> tuple[bool, float]:
        return not (name in CAUSES and (step.channels[name] > NOTHING_LEFT or not off)), -step.channels[name]

    return sorted(step.channels, key=order)[:limit]


def _lacks(found: Diagnosis, model: str) -> str:
    """ "car.toml lacks a and may lack one of b, c": what is provisional is said as such, what explains most first."""
    parts = []
    wanted = [e for e in found.effects if e.action == "add"]
    # a reader with a deadline adds what matters; the rest is in the table, as are the rivals of many
    chief = sorted((e for e in wanted if e.gain >= SLIGHT), key=lambda e: -e.gain) or wanted
    more, chief = chief[LEADING:], chief[:LEADING]
    words = _choice if len(wanted) <= LEADING else _or_another
    few = [words(e) if len(wanted) - len(chief) < 3 else e.name for e in wanted if e not in (*chief, *more)]
    for does, mine in _by_standing(chief, "lacks", "may lack"):
        parts.append(f"{does} {_and([words(e) for e in mine])}")
    if more:
        parts[-1] += f", and {len(more) + len(few)} more of less weight (in the table)"
    elif few:
        parts[-1] += f", and by far less {_and(few)}"
    for does, mine in _by_standing([e for e in found.effects if e.action == "change"], "has", "may have"):
        parts.append(f"{does} another {_and([e.name for e in mine])} than the car")
    for does, mine in _by_standing([e for e in found.effects if e.action == "remove"], "has", "may have"):
        parts.append(f"{does} {_and([e.name for e in mine])}, which the car does not")
    return f"{model} {_and(parts)}"


def _by_standing(effects: Sequence[NamedEffect], sure: str, unsure: str) -> Iterator[tuple[str, Sequence[NamedEffect]]]:
    """The confirmed ones with the verb `sure`, then the provisional ones with `unsure`, where there are any."""
    for standing, does in (("confirmed", sure), ("provisional", unsure)):
        mine = [each for each in effects if each.standing == standing]
        if mine:
            yield does, mine


def _choice(effect: NamedEffect) -> str:
    if not effect.rivals:
        return effect.name
    return f"{effect.name} (or {' or '.join(effect.rivals)}: these data cannot tell)"


def _or_another(effect: NamedEffect) -> str:
    return f"{effect.name} (or another)" if effect.rivals else effect.name


def _and(words: Sequence[str]) -> str:
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"


def _worst(found: Diagnosis) -> str:
    channels = found.ladder[-1].channels
    if not channels:
        return ""
    name = max(channels, key=lambda c: channels[c])
    return f", worst {name} {figure(channels[name])}"


def _effects(found: Diagnosis) -> list[str]:
    fit, held = shares(found.ladder), shares(found.ladder, held_out=True)
    rows: list[tuple[str, ...]] = [
        ("effect", "", "value", "95 % interval", "unit", "explains", "held out", "standing", "cannot be told from")
    ]
    for effect in found.effects:
        name = f"{_SIGNS[effect.action]} {effect.name}"
        rivals = ", ".join(effect.rivals) or ("the car does not have it" if effect.action == "remove" else "-")
        last: tuple[str, ...] = (
            _share(fit.get(effect.name)), _share(held.get(effect.name)), effect.standing, rivals
        )  # fmt: skip
        if effect.action == "remove":
            rows.append((name, "", "-", "-", "", *last))
            continue
        for key, one in effect.parameters.items():
            row = (name, key, value(one), interval(one), one.unit)
            rows.append((*row, *last))
            name, last = "", ("", "", "", "")
    return _table(rows, "llrllrrll")


def _ladder(found: Diagnosis) -> list[str]:
    steps = found.ladder
    names = causes(steps[0])
    held = steps[0].held_out_chi2_per_n is not None
    head = ("error after each step", "chi²/N", *(("held out",) if held else ()), *(f"{n} [{UNITS[n]}]" for n in names))
    rows = [head]
    for step in steps:
        rest = (figure(step.held_out_chi2_per_n),) if held else ()
        label = step_label(found, step)
        rows.append((label, figure(step.chi2_per_n), *rest, *(three(step.rmse[n]) for n in names)))
    rows.append(("sensor noise", "1", *(("1",) if held else ()), *(three(found.noise_floor[n]) for n in names)))
    return _table(rows, "l" + "r" * (len(head) - 1))


def _notes(found: Diagnosis) -> list[str]:
    lines = []
    if found.input_map:
        fitted = ", ".join(f"{k} = {value(e)} {e.unit}".rstrip(" -") for k, e in found.input_map.items())
        lines.append(f"fitted along: {fitted}")
        lines += found.scale_notes
    lines += [*standing_lines(found), *setup_lines(found)]
    if found.vetoed:
        lines.append(f"not {', '.join(found.vetoed)}: fits, but data it was not fitted on do not confirm it")
    lines += [f"what is left, {aspect}: {text}" for aspect, text in signature_lines(found.signature)]
    lines += _second_opinion(found)
    if found.not_excited:
        lines += _wrapped("these data cannot show: ", found.not_excited)
    return ["", *lines] if lines else []


WORSE = -0.005  # share of the error held out, from which a table shows it as less than 0 %
MOST_HIDDEN = 8  # effects of which a line says how much may hide; chosen: two lines, and the JSON has the others
PART_NOT_JUDGED = 0.1  # of the drives, from which the first line says that a part was not judged; chosen
COLOURED = 0.9  # of the samples: where fewer are independent, the answer says so


def standing_lines(found: Diagnosis) -> list[str]:
    """Why effects are provisional, how values change while driving, and what the twin is known not to explain."""
    lines = []
    open_ones = [e for e in found.effects if e.standing == "provisional" and e.doubts]
    alike = [e for e in open_ones if all(each.startswith(MUCH_LEFT) for each in e.doubts)]
    alike = alike if len(alike) > 1 else []
    for e in open_ones:
        if e not in alike:
            lines += _wrapped(f"provisional, {e.name}: ", e.doubts, "; ")
    if alike:
        names = [*(e.name for e in alike[:-1]), f"{alike[-1].name}: {MUCH_LEFT} signals on which they act"]
        lines += _wrapped("provisional, for the same reason: ", names)
    lines += [_changing(e) for e in found.effects if e.depends_on]
    if found.remainder:
        lines += _wrapped("the twin's known remainder counts as noise: ", remainder_words(found.remainder))
        lines += _hidden(found)
    if found.samples.independent < COLOURED * found.samples.count:
        lines.append(
            f"neighbouring samples repeat each other's noise: {found.samples.count} samples tell as much as "
            f"{found.samples.independent:.0f} independent ones"
        )
    if found.samples.slides:
        words = [
            f"wheels lock or spin, or the car slides, in {_rate(found.samples.slides)} of the drives fitted",
            "no effect of the catalogue does that",
            f"{_rate(found.samples.left_out)} of them is left out of the fit, up to the ends of those segments",
            "the answer holds for the rest alone",
            "where no wheel slipped, its speed contradicts the positions",
        ]
        lines += _wrapped("", words, "; ")
    if found.samples.slopes:
        slope = 100.0 * found.samples.slopes / GRAVITY
        words = [
            f"the road has slopes of {slope:.1f} % (root mean square) that differ along a drive",
            "the accelerometer tells them from forces, and they are no error of the model",
        ]
        lines += _wrapped("", words, "; ")
    lost = [name for name, share in shares(found.ladder, held_out=True).items() if share.value < WORSE]
    if lost:
        lines.append(
            f"held out below 0 %: with {_and(lost)} the error on the data held out grew at that step, by so much of "
            "the error of the model as given; later steps, or values of that run of its own, may take it back"
        )
    if len(found.ladder) > 1 and found.ladder[0].held_out_chi2_per_n is None:
        lines.append(
            "nothing was held out: no part of the logs could be set aside on which these effects show; name another "
            "log with --held-out"
        )
    if found.chosen_by_held_out:
        lines.append(
            "the data held out took part in choosing the effects, so their figures are too good: a third drive tells "
            "the true ones (dvp compare)"
        )
    if by_name := _provisional(found):
        lines.append(f"provisional, and so added by name only: {', '.join(by_name)}")
    return lines


def _rate(share: float) -> str:
    return f"{float(f'{100.0 * share:.2g}'):g} %"  # two figures, and 100 without an exponent


def _changing(e: NamedEffect) -> str:
    """ "brake_gain falls from 1.00 to 0.86 with brake energy: brake_fade has that" """
    change = e.depends_on
    assert change is not None
    moves = "falls" if change.end < change.start else "rises"
    what = e.name if len(e.parameters) == 1 else f"{e.name}.{change.key}"
    text = f"{what} {moves} from {three(change.start)} to {three(change.end)} with {change.quantity.replace('_', ' ')}"
    return f"{text}: {change.effect} has that" if change.effect else text


def _hidden(found: Diagnosis) -> list[str]:
    """Of which effects a known remainder hides most: "drive_lag.tau 0.2 s, brake_gain.g 0.1"."""
    most: dict[str, str] = {}
    for one in found.may_hide:
        if one.effect not in found.not_excited:
            most.setdefault(one.effect, f"{one.effect}.{one.key} {three(one.size)} {one.unit}".removesuffix(" -"))
    words = list(most.values())[:MOST_HIDDEN]
    return _wrapped("it may hide differences between car and twin of this size, or larger: ", words) if words else []


def remainder_words(remainder: Remainder) -> list[str]:
    """The worst driving regime of each signal: "ax up to 0.221 m/s^2 (standstill)"."""
    found = []
    for channel, regimes in remainder.items():
        worst = max(regimes, key=lambda name: regimes[name])
        found.append(f"{channel} up to {three(regimes[worst])} {UNITS[channel]} ({worst.replace('_', ' ')})")
    return found


def setup_lines(found: Diagnosis) -> list[str]:
    """What differs from run to run, and what the beginning of each held-out run says of it."""
    if not found.set_up:
        return []
    lines = [
        f"{_and(found.set_up)}: of the run, not of the car (other values held out); calibrate before each run. A "
        "held-out run's own are taken from its first 30 %, the rest of it judges"
    ]
    for run in found.ladder[-1].held_out_setups:
        values = ", ".join(f"{name}.{key} = {three(one)}" for (name, key), one in run.items())
        lines.append(f"held out: {values or 'none of them'}")
    return lines


def _second_opinion(found: Diagnosis) -> list[str]:
    """What regression of measured derivatives says, if it says something else."""
    first = found.votes.get("first")
    if first is None or any(first == e.name or first in e.rivals for e in found.effects):
        return []
    score = dict(found.votes["ranking"])[first]
    named = next((e.name for e in found.effects if e.name not in perception_effect_names()), "")  # of the motion
    instead = f" before {named}" if named else ""
    return [
        "second opinion: on the whole error, with no effect added yet, regression without simulation votes for "
        f"{first}{instead} ({100.0 * min(score, 1.0):.0f} %)"
    ]


def _wrapped(start: str, words: Sequence[str], between: str = ", ") -> list[str]:
    lines = [start]
    for k, word in enumerate(words):
        piece = word + (between if k < len(words) - 1 else "")
        if len(lines[-1]) + len(piece) > WIDTH:
            lines.append(" " * 4)
        lines[-1] += piece
    return [line.rstrip() for line in lines]


def _table(rows: Sequence[Sequence[str]], sides: str) -> list[str]:
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    lines = []
    for row in rows:
        cells = [c.ljust(w) if s == "l" else c.rjust(w) for c, w, s in zip(row, widths, sides, strict=True)]
        lines.append("  " + "  ".join(cells).rstrip())
    return lines


def _digits(estimate: Estimate) -> int:
    """Decimals that show the interval's half width, of four figures at most."""
    width = 0.5 * (estimate.high - estimate.low)
    first = math.floor(math.log10(abs(estimate.value))) if estimate.value else 0
    most = min(max(3 - first, 0), 6)
    return next((digits for digits in range(most) if width * 10.0**digits >= 0.95), most)


def three(number: float) -> str:
    """Three figures, zeros too."""
    return f"{number:#.3g}".rstrip(".")


def _share(share: Share | None) -> str:
    return "-" if share is None else share.shown


def figure(number: float | None) -> str:
    """A number with two decimals below 10, one below 100, none above; "-" for None."""
    if number is None:
        return "-"
    return f"{number:.2f}" if number < 9.995 else f"{number:.1f}" if number < 99.95 else f"{number:.0f}"
