"""Measures the guard and faults of the wire, writes docs/reliability.md:  python -m scripts.make_reliability_page

Each part of the page stands between a pair of markers, <!-- gate --> and <!-- /gate -->, and only the part measured is
written anew. What was measured is kept in runs/reliability until a file of the gate or its tests changes, so that a run
which was cut short goes on where it was. Ends with 1 if a line or branch is not covered, a mutant survives for which
no reason is listed, or a fault is not named, passes, or outlives its run.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import random
import re
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from scripts import fault_matrix
from scripts.gate_mutants import Report, examine

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "reliability.md"
KEPT = ROOT / "runs" / "reliability"
FILES = (
    "vehicle/guard/guard.py",
    "vehicle/guard/messages.py",
    "vehicle/guard/arming.py",
    "vehicle/guard/guarded_vehicle.py",
)
TESTS = ("tests/unit/vehicle/test_command_gate*.py", "tests/unit/vehicle/test_gated_vehicle.py")
STEPS = 40  # rules in each example of the state machine


def coverage() -> dict[str, tuple[int, int, int, int]]:
    """File -> lines, lines run, branches, branches run, by the unit tests alone."""
    with tempfile.TemporaryDirectory() as folder:
        data, out = f"--data-file={folder}/data", f"{folder}/coverage.json"
        tests = [str(path) for pattern in TESTS for path in sorted(ROOT.glob(pattern))]
        run = ["run", data, "--branch", f"--include={','.join(FILES)}", "-m", "pytest", "-q", "-p", "no:cacheprovider"]
        _python("-m", "coverage", *run, *tests)
        _python("-m", "coverage", "json", data, "-o", out)
        files = json.loads(Path(out).read_text(encoding="utf-8"))["files"]
    keys = ("num_statements", "covered_lines", "num_branches", "covered_branches")
    return {name: tuple(files[name]["summary"][key] for key in keys) for name in FILES}  # type: ignore[misc]


def commands(count: int) -> Counter[str]:
    """Ask `count` times as tests/property does; how often each outcome and reason came. Raises AssertionError."""
    sys.path.insert(0, str(ROOT / "tests" / "property"))
    from test_command_gate_commands import DRIVE, drive

    seen: Counter[str] = Counter()
    for seed in range(count // DRIVE):
        drive(random.Random(seed), DRIVE, seen)
    return seen


def states(examples: int) -> int:
    """Run the state machine; rules tried."""
    test = "tests/property/test_command_gate_states.py"
    _python("-m", "pytest", "-q", "-p", "no:cacheprovider", test, DVP_STATE_EXAMPLES=str(examples))
    return examples * STEPS


def gate_files() -> list[Path]:
    """What the figures of the gate depend on."""
    files = [*FILES, "scripts/gate_equivalents.toml", "scripts/mutate.py"]
    tests = [*ROOT.glob("tests/unit/vehicle/*gate*.py"), *ROOT.glob("tests/property/*command_gate*.py")]
    return [*(ROOT / file for file in files), *sorted(tests)]


def wire_files() -> list[Path]:
    """What the fault matrix depends on, more or less: stack and loop could change a status, but not what it shows."""
    folders = ("vehicle/wire", "vehicle/adapters", "vehicle/surrogate")
    code = [file for folder in folders for file in sorted((ROOT / folder).glob("*.py"))]
    return [*code, ROOT / "pytest_dvp" / "wire_log.py", ROOT / "scripts" / "fault_matrix.py"]


def kept(name: str, measure: Callable[[], Any], files: Sequence[Path]) -> Any:
    """The result of `measure` (of JSON values), from before if the files are what they were."""
    digest = hashlib.sha256(name.encode())
    for file in files:
        digest.update(file.read_bytes())
    place = KEPT / f"{name}-{digest.hexdigest()[:16]}.json"
    if not place.exists():
        result = json.dumps(measure())
        KEPT.mkdir(parents=True, exist_ok=True)
        place.with_suffix(".part").write_text(result, encoding="utf-8")
        place.with_suffix(".part").replace(place)
    return json.loads(place.read_text(encoding="utf-8"))


def gate_part(
    covered: Mapping[str, tuple[int, int, int, int]], mutants: Report, count: int, seen: Counter[str], rules: int
) -> str:
    """The part of the page about the gate."""
    out = [
        "| file | lines | covered | branches | covered | mutants | killed | equivalent |",
        "|---|--|--|--|--|--|--|--|",
    ]
    for name, (lines, run, branches, taken) in covered.items():
        module = name.removesuffix(".py").replace("/", ".")
        made, killed = mutants.made.get(module), mutants.killed.get(module, 0)
        same = sum(1 for where, _, reason in mutants.survivors if where == module and reason)
        cells = (made, killed, same) if made is not None else ("-", "-", "-")
        out.append(f"| `{name}` | {lines} | {run} | {branches} | {taken} | " + " | ".join(map(str, cells)) + " |")
    out += ["", "Equivalent mutants, which behave exactly like the guard:", ""]
    out += [f"- `{m.before}` -> `{m.after}`: {reason}" for _, m, reason in mutants.survivors if reason]
    if mutants.unexplained:
        out += ["", "Mutants that survive without a reason:", ""]
        out += [f"- `{module}`, line {m.line}: `{m.before}` -> `{m.after}`" for module, m, _ in mutants.unexplained]
    outcomes = ("passed", "clamped", "stop", "handed_over")
    out += [
        "",
        f"{count:,} random and boundary commands, 0 outputs outside their bounds; "
        f"up to {rules:,} rules tried on the states (dry, armed, overridden, stopped), 0 broken.",
        "",
        "| outcome of a command | times |",
        "|---|--|",
        *(f"| {name.replace('_', ' ')} | {seen[name]:,} |" for name in outcomes),
        "",
        "| for this reason (a command may have several) | times |",
        "|---|--|",
        *(f"| `{name}` | {times:,} |" for name, times in sorted(seen.items()) if name not in outcomes),
    ]
    return "\n".join(out)


def replaced(page: str, part: str, text: str) -> str:
    """The page with another text between the markers of a part."""
    between = re.compile(rf"(<!-- {part} -->\n).*?(<!-- /{part} -->)", re.DOTALL)
    if not between.search(page):
        raise SystemExit(f"{PAGE.name} has no markers <!-- {part} --> and <!-- /{part} -->")
    return between.sub(lambda found: f"{found[1]}{text}\n{found[2]}", page)


def _python(*arguments: str, **environment: str) -> None:
    done = subprocess.run(
        [sys.executable, *arguments], cwd=ROOT, env={**os.environ, **environment}, capture_output=True, text=True
    )
    if done.returncode:
        raise SystemExit(done.stdout + done.stderr)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--commands", type=int, default=1_000_000)
    parser.add_argument("--examples", type=int, default=1_000, help="of the state machine")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--part", choices=tuple(PARTS), help="only this one")
    options = parser.parse_args()
    good = [measure(options) for name, measure in PARTS.items() if options.part in (name, None)]
    return 0 if all(good) else 1


def gate(options: argparse.Namespace) -> bool:
    """Measure and write the part of the gate; whether it is as it must be."""
    files = gate_files()
    covered = kept("coverage", coverage, files)
    seen = Counter(kept(f"commands-{options.commands}", lambda: commands(options.commands), files))
    rules = kept(f"states-{options.examples}", lambda: states(options.examples), files)
    mutants = Report.of(kept("mutants", lambda: examine(options.jobs).plain(), files))
    write("gate", gate_part(covered, mutants, options.commands, seen, rules))
    whole = all(lines == run and branches == taken for lines, run, branches, taken in covered.values())
    return whole and not mutants.unexplained


def faults(_: argparse.Namespace) -> bool:
    """Measure and write the part of the wire; whether it is as it must be."""
    files = wire_files()
    cells = fault_matrix.matrix(lambda name, measure: kept(name, measure, files))
    write("faults", fault_matrix.part(cells))
    missed = fault_matrix.missed(cells)
    print(*missed, sep="\n")
    return not missed


def write(part: str, text: str) -> None:
    """Put a part into the page."""
    PAGE.write_text(replaced(PAGE.read_text(encoding="utf-8"), part, text), encoding="utf-8")
    print(text)


PARTS: Mapping[str, Callable[[argparse.Namespace], bool]] = {"gate": gate, "faults": faults}


if __name__ == "__main__":
    sys.exit(main())
