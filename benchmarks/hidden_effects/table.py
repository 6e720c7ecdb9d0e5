"""The table of figures beside the goals, and the list of what was taken for what, as a page."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from benchmarks.hidden_effects import score
from benchmarks.hidden_effects.case import HARMLESS, WRONG
from benchmarks.hidden_effects.score import Line, Share

HEAD = """# Hidden effects

`python -m benchmarks.hidden_effects` writes this page. Truth cars that share no code with the kernel hide effects in
their logs, and the diagnosis must name them. Every value is drawn from the effect's typical range, and drawn again
until the logs with and without it differ by 5 % of the noise floor in chi^2/N. Two effects of one family (which data
cannot distinguish, or of which one contains the other) are never hidden together. Effects of slipping tyres are
hidden in a car whose baseline has tyres. A run of another seed of the same car is held out. A log in which `dvp
doctor` finds errors counts as refused.
""".splitlines()


@dataclass(frozen=True)
class Figure:
    """One row: what, found, its one-sided 95 % bound, of how many, goal, and whether the goal is met by that bound
    (None: cannot be told)."""

    name: str
    found: str
    count: int
    goal: str
    met: bool | None
    bound: str = ""


def _rate(name: str, found: Share, goal: str, enough: Callable[[float], bool]) -> Figure:
    """A goal to exceed is met by the lower bound, one to stay below by the upper one, an exact one as found."""
    if found.value is None:
        return Figure(name, "not measured", 0, goal, None)
    low, high = goal.startswith(">="), goal.startswith("<=")
    bound = found.low if low else found.high if high else found.value
    shown = f"> {found.low:.3f}" if low else f"< {found.high:.3f}" if high else ""
    return Figure(
        name, f"{found.value:.3f} ({found.hits}/{found.count})", found.count, goal, enough(bound), bound=shown
    )


def _number(
    name: str, found: float | None, count: int, unit: str, goal: str, enough: Callable[[float], bool]
) -> Figure:
    if found is None:
        return Figure(name, "not measured", 0, goal, None)
    return Figure(name, f"{found:.3g}{unit}", count, goal, enough(found))


def figures(lines: Sequence[Line], advised: Sequence[Line] = ()) -> list[Figure]:
    """All rows, in the order of the goals. advised: lines of `benchmarks.hidden_effects.deciding`."""
    of = score.asked
    singles, urban, nulls = of(lines, "single"), of(lines, "urban"), of(lines, "null")
    known = of(lines, "single", "urban", "pair", "triple")
    dirt = of(lines, "dirty")
    on_top = [line for line in of(lines, "surrogate", "multibody") if line["names"]]
    plain = [line for line in of(lines, "surrogate", "multibody") if not line["names"]]
    rows = [
        _rate(
            "one hidden effect, named first", score.share(singles, score.first_is_true), ">= 0.97", lambda v: v >= 0.97
        )
    ]
    for noise in ("low", "mid", "high"):
        some = [line for line in singles if line["noise"] == noise]
        rows.append(
            _rate(f"of it, noise {noise}", score.share(some, score.first_is_true), ">= 0.97", lambda v: v >= 0.97)
        )
    rows += [
        _rate("urban data only, truth in the set", score.share(urban, score.set_holds_truth), ">= 0.97",
              lambda v: v >= 0.97),
        _number("urban data only, mean size of the set", score.set_size(urban), len(urban), "", "<= 1.7",
                lambda v: v <= 1.7),
        _rate("a single confident name that is wrong", score.share(known, score.confident_and_wrong), "<= 0.01",
              lambda v: v <= 0.01),
        _rate("confirmed names that are not true, over all verdicts",
              score.wrongly_confirmed(of(lines, "single", "urban", "pair", "triple", "null", "outside")), "<= 0.01",
              lambda v: v <= 0.01),
        _rate("one hidden effect, confirmed", score.share(singles, score.confirmed_and_true), ">= 0.85",
              lambda v: v >= 0.85),
        _rate("names something when nothing is missing", score.share(nulls, lambda x: bool(x["effects"])), "<= 1/300",
              lambda v: v <= 1 / 300),
        _rate("two hidden effects, exact set", score.share(of(lines, "pair"), score.exact), ">= 0.90",
              lambda v: v >= 0.9),
        _rate("of it with rivals: both in the returned sets", score.share(of(lines, "pair"), score.set_holds_truth),
              ">= 0.90", lambda v: v >= 0.9),
        _rate("three, all found", score.share(of(lines, "triple"), score.all_found), ">= 0.80", lambda v: v >= 0.8),
        _rate("outside the library, PARTIAL or UNKNOWN", score.share(of(lines, "outside"), score.flagged), ">= 0.90",
              lambda v: v >= 0.9),
        _rate("on an independent truth, among the first two", score.share(on_top, score.first_two_hold_it), ">= 0.95",
              lambda v: v >= 0.95),
        _rate("of it, among the first two that the bare car lacks", score.first_two_new_hold_it(on_top + plain),
              ">= 0.95", lambda v: v >= 0.95),
    ]  # fmt: skip
    left = [score.chi2(line, "fit", "after") for line in plain]
    rows.append(
        _number(
            "chi^2/N left on those truths, worst", score.quantile(left, 1.0), len(left), "", "<= 2", lambda v: v <= 2.0
        )
    )
    return rows + _parameters(singles) + _rest(lines, dirt, advised)


def _parameters(singles: Sequence[Line]) -> list[Figure]:
    errors = [error for line in singles if score.first_is_true(line) for error in score.parameter_errors(line)]
    told = [error.covered for error in errors if error.covered is not None]
    of_effect, n = [error.of_effect for error in errors], len(errors)
    of_value = [error.of_value for error in errors]
    removed = [value for line in singles if (value := score.excess_removed(line)) is not None]
    return [
        _number("parameter error of the effect's size, median", score.quantile(of_effect, 0.5), n, "", "<= 0.02",
                lambda v: v <= 0.02),
        _number("of the effect's size, 90th percentile", score.quantile(of_effect, 0.9), n, "", "<= 0.10",
                lambda v: v <= 0.1),
        _number("of the value, median", score.quantile(of_value, 0.5), n, "", "<= 0.02", lambda v: v <= 0.02),
        _number("of the value, 90th percentile", score.quantile(of_value, 0.9), n, "", "<= 0.10", lambda v: v <= 0.1),
        _rate("95 % intervals that hold the truth", Share(sum(told), len(told)), "0.90 to 0.98",
              lambda v: 0.9 <= v <= 0.98),
        _number("excess error removed on the held-out run, median", score.quantile(removed, 0.5), len(removed), "",
                ">= 0.90", lambda v: v >= 0.9),
        _number("excess error removed, 10th percentile", score.quantile(removed, 0.1), len(removed), "", ">= 0.70",
                lambda v: v >= 0.7),
    ]  # fmt: skip


def _rest(lines: Sequence[Line], dirt: Sequence[Line], advised: Sequence[Line]) -> list[Figure]:
    of = score.asked
    harmless = [line for line in dirt if line["dirt"] in HARMLESS]
    wrong = [line for line in dirt if line["dirt"] in WRONG]
    spent = [line["cpu"] for line in of(lines, "single", "null", "pair", "triple") if "cpu" in line]
    independent = of(lines, "surrogate", "multibody")
    return [
        _rate("named on an independent truth, not named without", score.not_named_without(independent), "1.00",
              lambda v: v >= 1.0),
        _rate("ablation: switched off, the name disappears", score.share(of(lines, "ablation"), score.disappears),
              "1.00", lambda v: v >= 1.0),
        _rate("dirty logs, named first", score.share(harmless, score.dirt_is_survived), ">= 0.97", lambda v: v >= 0.97),
        _rate("one wrong column, refused or nothing wrong named", score.share(wrong, score.no_wrong_name), "1.00",
              lambda v: v >= 1.0),
        _rate("perception effects, named first", score.share(of(lines, "perception"), score.first_is_true), ">= 0.97",
              lambda v: v >= 0.97),
        _rate("after the advised manoeuvre, the truth alone", score.share(advised, lambda x: bool(x["alone"])),
              ">= 0.90", lambda v: v >= 0.90),
        _number("CPU of a diagnosis of 165 s at 50 Hz, median", score.quantile(spent, 0.5), len(spent), " s", "<= 3 s",
                lambda v: v <= 3.0),
        _number("CPU, 90th percentile", score.quantile(spent, 0.9), len(spent), " s", "<= 3 s", lambda v: v <= 3.0),
        _rate("diagnoses that raised", score.share(lines, lambda x: x["verdict"] == "ERROR"), "0", lambda v: v == 0.0),
    ]  # fmt: skip


def answer(line: Line) -> str:
    """The answer in a few words: verdict, names in order, rivals in brackets."""
    words = [
        effect["name"] + (f" ({', '.join(effect['rivals'])})" if effect.get("rivals") else "")
        for effect in line["effects"]
    ]
    return f"{line['verdict']} {' + '.join(words)}".strip()


def missed(line: Line) -> bool:
    """Whether a line counts against the goal of its category."""
    by_category: dict[str, Callable[[Line], bool]] = {
        "single": score.first_is_true,
        "urban": score.set_holds_truth,
        "null": lambda x: not x["effects"] and x["verdict"] != "ERROR",
        "pair": score.exact,
        "triple": score.all_found,
        "outside": score.flagged,
        "ablation": score.disappears,
        "perception": score.first_is_true,
        "dirty": lambda x: score.first_is_true(x) if x["dirt"] in HARMLESS else score.no_wrong_name(x),
    }
    if line["verdict"] == "UNDETECTABLE":
        return False
    if line["category"] in ("surrogate", "multibody"):
        return bool(line["names"]) and not score.first_two_hold_it(line)
    return not by_category[line["category"]](line)


def page(lines: Sequence[Line], base_seed: int, total: int, advised: Sequence[Line] = ()) -> str:
    """The page: table, what could not be seen, and the misses, the most frequent first."""
    out = [
        *HEAD,
        f"{len(lines)} of {total} cases, seeds from {base_seed}.",
        "",
        "| figure | found | 95 % bound | goal | met by the bound |",
        "|---|---|---|---|---|",
    ]
    for row in figures(lines, advised):
        met = "" if row.met is None else "yes" if row.met else "no"
        out.append(f"| {row.name} | {row.found} | {row.bound} | {row.goal} | {met} |")
    unseen = Counter(name for line in lines if line["verdict"] == "UNDETECTABLE" for name in line["names"])
    if unseen:
        out += ["", "No value of the range could be seen (not counted): " + _counted(unseen) + "."]
    misses = [line for line in lines if missed(line)]
    if misses:
        out += ["", "## Taken for something else", "", "| case | hidden | answer | times |", "|---|---|---|---|"]
        told = Counter((line["category"], _hidden(line), _plain(line)) for line in misses)
        for (category, hidden, words), times in sorted(told.items(), key=lambda item: (-item[1], item[0])):
            out.append(f"| {category} | {hidden} | {words} | {times} |")
    return "\n".join(out) + "\n"


def _plain(line: Line) -> str:
    words = answer(line)
    if line.get("refused"):
        words += f": {line['refused'][:80]}"
    return words.replace("|", "/")


def _hidden(line: Line) -> str:
    words = " + ".join(line["truth"]) or "nothing"
    if line["off"]:
        words += f" (without {line['off']})"
    return f"{words}, {line['dirt']}" if line["dirt"] else words


def _counted(found: Counter[str]) -> str:
    return ", ".join(f"{name} {times}x" for name, times in sorted(found.items()))
