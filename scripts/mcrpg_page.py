"""The figures of docs/mcrpg.md, measured:  python -m scripts.mcrpg_page paper [CAR ...]   |   searches   |   kills

paper     `dvp iterate` on scenarios/mcrpg/paper.toml for each car of scenarios/mcrpg/cars, from the presets of the
          paper's 1st iteration; writes the table beside the bounds
searches  the same budget of simulations by coordinate search, CMA-ES and TPE, and diagnosis first against tuning alone
kills     a tuning run killed 20 times at random (SIGKILL to its process group) and one left alone: the same result

Everything that is simulated is kept in runs/mcrpg/cache: killed, the same command goes on where it was.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from pytest_dvp.tuning.paper_result import TENTH
from pytest_dvp.tuning.result_bounds import DRIVE, EQUIVALENT, GAIN, LIKENESS
from scripts.mcrpg_kills import kills
from scripts.mcrpg_searches import searches
from scripts.real_cars import placed

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "mcrpg.md"
RUNS = ROOT / "runs" / "mcrpg"
CARS = ("nominal", "heavy_slow", "sharp_slippery", "drawn")


def main(argv: Sequence[str] | None = None) -> int:
    """Returns the exit code: 0."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("part", choices=("paper", "searches", "kills"))
    parser.add_argument("cars", nargs="*", metavar="CAR", help=f"of {', '.join(CARS)}; default: all")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--runs", type=Path, default=RUNS)
    parser.add_argument("--no-write", action="store_true", help="print, and leave the page as it is")
    arguments = parser.parse_args(argv)
    if unknown := sorted({*arguments.cars} - {*CARS}):
        parser.error(f"CAR: found {', '.join(unknown)}; allowed: {', '.join(CARS)}")
    if arguments.part == "paper":
        for car in arguments.cars or CARS:
            iterated(car, arguments.runs, arguments.jobs)
        text = paper(arguments.runs)
    elif arguments.part == "searches":
        text = searches(arguments.runs, arguments.jobs, ROOT / "docs")
    else:
        text = kills(arguments.runs, arguments.jobs)
    print(text)
    if not arguments.no_write:
        PAGE.write_text(placed(PAGE.read_text(encoding="utf-8"), arguments.part, text), encoding="utf-8")
    return 0


def iterated(car: str, runs: Path, jobs: int) -> None:
    """One car: ledger, result.json and report.html below `runs`."""
    from pytest_dvp.cli.command_line import main as dvp

    folder = ROOT / "scenarios" / "mcrpg"
    dvp([
        "iterate", str(folder / "paper.toml"), "--vehicle", f"surrogate:{folder / 'cars' / car}.toml",
        "--out", str(runs / car), "--cache", str(runs / "cache"), "--jobs", str(jobs),
    ])  # fmt: skip


def paper(runs: Path) -> str:
    """The table of all cars that have a result."""
    found = {
        car: json.loads((runs / car / "result.json").read_text(encoding="utf-8"))
        for car in CARS
        if (runs / car / "result.json").is_file()
    }
    tables = {car: {(b["what"], b["where"]): b for b in result["bounds"]} for car, result in found.items()}
    lines = [*_glance(found), "", "| row | bound | paper, 10th | " + " | ".join(map(_called, found)) + " |"]
    lines.append("|---|---|---|" + "---|" * len(found))
    for pair, name in ((pair, name) for pair in ("dt-rw", "pe-rw") for name in LIKENESS):
        first = next(iter(tables.values()))[f"MNCC {name}", pair]
        cells = [_alike(table, name, pair) for table in tables.values()]
        lines.append(
            f"| MNCC {name}, {_pair(pair)} | {_sign(first['bound'])} | {first['paper']} | {' | '.join(cells)} |"
        )
        if pair == "dt-rw":
            cells = [_shown(result["repeatability"], name) for result in found.values()]
            lines.append(f"| … RW to RW, other seeds | shown | | {' | '.join(cells)} |")
        cells = [_shown(result["held_out"]["last"]["likeness"][pair], name) for result in found.values()]
        lines.append(f"| … drive by drive | shown | | {' | '.join(cells)} |")
    for name in DRIVE:
        first = next(iter(tables.values()))[name, "dt"]
        theirs = " / ".join(next(iter(tables.values()))[name, stage]["paper"] for stage in ("dt", "pe", "rw"))
        cells = [" / ".join(_value(table[name, stage]) for stage in ("dt", "pe", "rw")) for table in tables.values()]
        lines.append(f"| {name}, DT / PE / RW | {_sign(first['bound'])} | {theirs.strip(' /')} | {' | '.join(cells)} |")
    for name, unit in (("lateral RMSE, lane", "m"), ("max yaw rate", "rad/s"), ("completion time", "s")):
        theirs = " / ".join(f"{value:g}" for value in TENTH[name])
        cells = [_stages(result, name) for result in found.values()]
        lines.append(f"| {name} [{unit}] | shown | {theirs} | {' | '.join(cells)} |")
    key = ("open-loop position after 2 s", "twin")
    cells = [f"{_value(table[key])} (<= {_limit(table[key])})" for table in tables.values()]
    lines.append(f"| open-loop position after 2 s [m] | ≤ 2 × noise | | {' | '.join(cells)} |")
    for name in EQUIVALENT:
        rows = [[table[f"{name}, between stages", pair] for pair in ("dt-rw", "pe-rw")] for table in tables.values()]
        share = f"{GAIN:.0%} of the {'bound' if name in DRIVE else 'value'}".replace("%", " %")
        cells = [" / ".join(map(_apart, both)) for both in rows]
        lines.append(f"| {name} between stages, DT to RW / PE to RW | ± {share} | | {' | '.join(cells)} |")
    for pair in ("dt-rw", "pe-rw"):
        cells = [_meeting(result["held_out"]["last"]["metrics"], pair) for result in found.values()]
        lines.append(f"| … 95 % intervals of both stages meet, {_pair(pair)} | shown | | {' | '.join(cells)} |")
    lines += ["", *(line for car, result in found.items() for line in _story(car, result))]
    return "\n".join(lines)


def _glance(found: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """What came of each car in a line."""
    lines = ["| car | bounds that hold | what misses |", "|---|---|---|"]
    for car, result in found.items():
        rows = result["bounds"]
        missed = [
            f"{row['what']} ({_pair(row['where'])}{', too few repeats to tell' if row['undecided'] else ''})"
            for row in rows
            if not row["holds"]
        ]
        held = f"**{len(rows) - len(missed)} of {len(rows)}**"
        lines.append(f"| {_called(car)} | {held} | {'; '.join(missed) or 'nothing'} |")
    return lines


def _called(car: str) -> str:
    return car.replace("_", ", ")


def _alike(table: Mapping[tuple[str, str], Mapping[str, Any]], name: str, pair: str) -> str:
    """`0.99994 ± 0.00002, 0.00 ± 0.01 s, 0.3 ± 0.1 %`; what misses its bound is struck by a cross."""
    rows = [table[what, pair] for what in (f"MNCC {name}", f"lag of {name}", f"gain of {name}, from 1")]
    parts = _parts([(row["value"], row["half_width"]) for row in rows])
    return ", ".join(f"{'' if row['holds'] else '✗ '}{part}" for row, part in zip(rows, parts, strict=True))


def _shown(rows: Mapping[str, Mapping[str, Any]], name: str) -> str:
    """The same of figures that no bound judges."""
    figures = [rows.get(key, {}) for key in (name, f"{name}.lag", f"{name}.gain")]
    return ", ".join(_parts([(each.get("mean"), each.get("half_width")) for each in figures]))


def _parts(values: Sequence[tuple[float | None, float | None]]) -> list[str]:
    """MNCC, lag [s] and distance of the gain from 1 with their half widths, as text."""
    found = []
    for (value, half), scale, digits, unit in zip(values, (1, 1, 100), (5, 3, 1), ("", " s", " %"), strict=True):
        if value is None:
            found.append("undefined")
            continue
        wide = "" if half is None else f" ± {scale * half:.{digits}f}"
        found.append(f"{scale * value:.{digits}f}{wide}{unit}")
    return found


def _value(row: Mapping[str, Any]) -> str:
    text = "–" if row["value"] is None else f"{row['value']:.3g}"
    return text if row["holds"] else f"✗ {text}"


def _limit(row: Mapping[str, Any]) -> str:
    return str(row["bound"]).removeprefix("<= ").partition(" ")[0]


def _stages(result: Mapping[str, Any], name: str) -> str:
    metrics = result["held_out"]["last"]["metrics"]
    values = [metrics[stage].get(name, {}).get("mean") for stage in ("dt", "pe", "rw")]
    return " / ".join("–" if v is None else f"{v:.3g}" for v in values)


def _apart(row: Mapping[str, Any]) -> str:
    """Difference of a metric between two stages with its interval, in % of what its margin is 2 % of."""
    if row["value"] is None:
        return "✗ undefined"
    scale = 100.0 * GAIN / row["margin"] if row["margin"] else 0.0  # TET has a margin of 0
    text = f"{scale * row['value']:+.1f}"
    if row["half_width"] is not None:
        text += f" ± {scale * row['half_width']:.1f}"
    return f"{'' if row['holds'] else '? ' if row['undecided'] else '✗ '}{text} %"


def _meeting(metrics: Mapping[str, Mapping[str, Any]], pair: str) -> str:
    """Of how many metrics the 95 % intervals of both stages meet, and of which not."""
    one, other = (metrics[stage] for stage in pair.split("-"))
    apart = [
        name
        for name in EQUIVALENT
        if abs(one[name]["mean"] - other[name]["mean"]) > one[name]["half_width"] + other[name]["half_width"] + 1e-12
    ]
    return f"{len(EQUIVALENT) - len(apart)} of {len(EQUIVALENT)}" + (f", not {', '.join(apart)}" if apart else "")


def _pair(pair: str) -> str:
    return pair.upper().replace("-", " to ")


def _sign(bound: str) -> str:
    return bound.replace(">=", "≥").replace("<=", "≤")


def _story(car: str, result: Mapping[str, Any]) -> list[str]:
    """What happened to a car, iteration by iteration."""
    held = sum(row["holds"] for row in result["bounds"])
    lines = [
        f"**{_called(car)}**: {held} of {len(result['bounds'])} bounds hold; ended: {result['ended']}.",
        "",
    ]
    for entry in result["ledger"][1:]:
        lines.append(f"- Iteration {entry['number']}, taken: {entry['accepted'] or 'nothing'}.")
        lines += [f"  - {change}" for change in entry["changes"]]
    return [*lines, ""]


if __name__ == "__main__":
    sys.exit(main())
