"""A twin that has learnt what its car lacks, and then the car gets one more effect: is that named?

    python -m benchmarks.hidden_effects.matched [--cases 40] [--seed 1000] [--jobs 2] [--json F] [--resume]

Cars of other simulators (the double-track surrogate, CommonRoad's multi-body cars), in turn. The bare car is diagnosed
and its twin extended by all that is named (`dvp extend`), as a user does who closes a gap. Then the same car drives
with one effect hidden on top, as in `benchmarks.hidden_effects`, and the diagnosis starts from the extended twin.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):  # before numpy loads: CPU of one core
    os.environ.setdefault(_name, "1")

from benchmarks.hidden_effects.case import Case, strata  # noqa: E402
from benchmarks.hidden_effects.score import first_two_hold_it, names  # noqa: E402
from benchmarks.hidden_effects.truth import question  # noqa: E402
from pytest_dvp.gap.diagnose.diagnose import diagnose  # noqa: E402
from pytest_dvp.gap.extend.extend import extend  # noqa: E402
from vehicle.model.vehicle_model import VehicleModel  # noqa: E402

OTHER_DRIVES = 900  # seed of the bare car's logs: not those of the cases


def cases(base_seed: int = 1000) -> list[Case]:
    """The cases of the matrix that hide an effect in a car of another simulator, the simulators in turn."""
    both = [[case for case in strata()[kind] if case.names] for kind in ("surrogate", "multibody")]
    return [replace(case, base_seed=base_seed) for pair in zip(*both, strict=True) for case in pair]


@cache
def matched(bare: Case) -> tuple[VehicleModel, tuple[str, ...]]:
    """The twin extended by what the bare car lacks, and the names of that."""
    asked = question(bare)
    assert asked is not None
    found = diagnose(asked.logs, asked.model, held_out=asked.held_out or None)
    start = {
        (effect.name, key): estimate.value
        for effect in found.effects
        if effect.action == "add"
        for key, estimate in effect.parameters.items()
    }
    add = [effect.name for effect in found.effects if effect.action == "add"]
    extended = extend(asked.logs, asked.model, add=add, held_out=asked.held_out or None, start=start)
    return extended.model, tuple(add)


def ask(case: Case) -> dict[str, Any]:
    """The record of one case."""
    begin = time.process_time()
    twin, learnt = matched(replace(case, names=(), seed=OTHER_DRIVES))
    asked = question(case)
    assert asked is not None
    at = time.process_time()
    found = diagnose(asked.logs, twin, held_out=asked.held_out or None).as_dict()
    kept = {key: found[key] for key in ("verdict", "effects", "chi2_per_n")}
    who = {"key": case.key, "base_seed": case.base_seed, "names": list(case.names), "truth": asked.truth}
    cpu = {"cpu": round(time.process_time() - at, 1), "learning": round(at - begin, 1)}
    return {**who, "learnt": learnt, **kept, **cpu}


def main() -> int:
    """Returns 0: the figures are the result."""
    import multiprocessing
    from concurrent.futures import ProcessPoolExecutor, as_completed

    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--cases", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1000)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--json", type=Path, metavar="F", help="answers, one JSON line a case")
    parser.add_argument("--resume", action="store_true", help="go on with the answers that F has")
    args = parser.parse_args()
    lines: list[dict[str, Any]] = []
    if args.resume and args.json and args.json.exists():
        lines = [json.loads(text) for text in args.json.read_text("utf-8").splitlines()]
    left = [case for case in cases(args.seed)[: args.cases] if case.key not in {line["key"] for line in lines}]
    with ProcessPoolExecutor(args.jobs, multiprocessing.get_context("spawn")) as pool:
        for future in as_completed([pool.submit(ask, case) for case in left]):
            line = future.result()
            lines.append(line)
            mark, said = "yes" if first_two_hold_it(line) else "NO ", ", ".join(names(line)) or "-"
            print(f"{mark} {line['key']}: {line['verdict']} {said} ({line['cpu']} s)", flush=True)
            if args.json:
                with args.json.open("a", encoding="utf-8") as file:
                    file.write(json.dumps(line) + "\n")
    hit = sum(map(first_two_hold_it, lines))
    first = sum(line["truth"].keys() & set(names(line)[:1]) != set() for line in lines)
    print(f"one more effect in a car that its twin matched: first {first}, among the first two {hit} of {len(lines)}",
          file=sys.stderr)  # fmt: skip
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
