"""The page of figures about foreign cars."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from benchmarks.hidden_effects import score
from benchmarks.hidden_effects.score import Share

HEAD = """# Cars of another make

`python -m benchmarks.foreign_cars` writes this page. Three cars are built in MuJoCo of bodies, springs and joints, with
tyres, actuators and a driver of their own; they share nothing with the kernel. From its data sheet alone each car is
diagnosed on one drive, another one being held out (*bare*), and its twin is extended by all that is named and learns
from both drives together (`dvp extend --grow`, since caa68c83). Then the car
drives again, with nothing new (*null*) or with one hidden effect (*single*), and the diagnosis starts from that twin,
whose file tells its known remainder. An effect counts as detectable if a signal differs by 3 sigma in 25 rows. A van,
made after the rule stood, is asked bare only.

The cars and the diagnosis were written by the same people, so this is no test by strangers: each new draw has new
values and drives, but the same cars.
"""


def page(lines: Sequence[dict[str, Any]], commit: str) -> str:
    """The page; lines: answers of one seed."""
    return f"{HEAD}\nOf these cases, drawn from the seed {commit}, {figures(lines)}"


def figures(lines: Sequence[dict[str, Any]]) -> str:
    """How many cases there are, the table of rates, the bare cars and the answers that miss; lines: answers."""
    asked = [line for line in lines if line["verdict"] != "UNDETECTABLE"]
    singles, nulls = ([x for x in asked if x["category"] == c] for c in ("single", "null"))
    rows: list[tuple[str, Share, str, Callable[[Share], bool]]] = [
        ("one hidden effect, named first", score.share(singles, score.first_is_true), ">= 0.95",
         lambda s: s.low >= 0.95),
        ("one hidden effect, confirmed and true", score.share(singles, score.confirmed_and_true), ">= 0.85",
         lambda s: s.low >= 0.85),
        ("confirmed names that are not true, over all verdicts", score.wrongly_confirmed([*singles, *nulls]), "<= 0.01",
         lambda s: s.high <= 0.01),
        ("nothing new: NOTHING_MISSING", score.share(nulls, lambda x: x["verdict"] == "NOTHING_MISSING"), ">= 0.95",
         lambda s: s.low >= 0.95),
        ("95 % intervals that hold the truth", _covered(singles), "0.90 to 0.98",
         lambda s: s.value is not None and 0.90 <= s.value <= 0.98),
        ("diagnoses that raised", score.share(asked, lambda x: x["verdict"] == "ERROR"), "0", lambda s: s.hits == 0),
    ]  # fmt: skip
    out = [f"{len(lines)} were asked; {len(lines) - len(asked)} could not be seen.", "",
           "| figure | found | one-sided 95 % bounds | goal | met by the bound |", "|---|---|---|---|---|"]  # fmt: skip
    for name, share, goal, met in rows:
        found = "not measured" if share.value is None else f"{share.value:.3f} ({share.hits}/{share.count})"
        bounds = "" if share.value is None else f"{share.low:.3f}, {share.high:.3f}"
        out.append(
            f"| {name} | {found} | {bounds} | {goal} | {'yes' if share.value is not None and met(share) else 'no'} |"
        )
    spent = sorted(float(line["cpu"]) for line in asked if line["category"] != "bare" and "cpu" in line)
    if spent:
        out += [
            "",
            f"CPU of a diagnosis of 110 s from a matched twin, median of {len(spent)}: {spent[len(spent) // 2]:.0f} s.",
        ]
    bare = [line for line in lines if line["category"] == "bare"]
    if bare:
        head = ("car", "chi^2/N before", "after", "held out before", "after", "CPU", "named")
        out += ["", "## From the data sheet", "", f"| {' | '.join(head)} |", "|---" * len(head) + "|"]
    for line in bare:
        fit, held = line["chi2_per_n"]["fit"], line["chi2_per_n"]["held_out"]
        named = ", ".join(
            e["name"] + ("" if e["standing"] == "confirmed" else " (provisional)") for e in line["effects"]
        )
        figures = " | ".join(f"{x:.3g}" for x in (fit["before"], fit["after"], held["before"], held["after"]))
        out.append(f"| {line['car']} | {figures} | {line['cpu']:.0f} s | {named} |")
    wrong = [line for line in asked if line["category"] != "bare" and _missed(line)]
    if wrong:
        out += ["", "## Answers that miss", "", "| case | hidden | answer |", "|---|---|---|"]
    for line in wrong:
        hidden = (
            ", ".join(f"{n} {', '.join(f'{v:g}' for v in p.values())}" for n, p in line["truth"].items()) or "nothing"
        )
        named = ", ".join(f"{e['name']} ({e['standing']})" for e in line["effects"])
        out.append(f"| {line['key']} | {hidden} | {line['verdict']} {named} |")
    return "\n".join(out) + "\n"


def _covered(singles: Sequence[dict[str, Any]]) -> Share:
    named = [{**line, "truth": line["total"]} for line in singles if score.first_is_true(line)]
    told = [error.covered for line in named for error in score.parameter_errors(line)]
    known = [one for one in told if one is not None]
    return Share(sum(known), len(known))


def _missed(line: dict[str, Any]) -> bool:
    if line["category"] == "null":
        return bool(line["verdict"] != "NOTHING_MISSING")
    wrong = set(score.confirmed(line)) - set(line["truth"])
    return bool(wrong) or not score.first_is_true(line) or not score.confirmed_and_true(line)
