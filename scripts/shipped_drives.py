"""Drives of the reference stack in the scenarios that ship, each kept as one line of JSON, so that an interrupted
call goes on where it was.

    python -m scripts.shipped_drives clean 0 40      # seeds 0 to 39 of every scenario

The reference stack drives on dt. Every sixth seed takes parameters drawn from the ranges that the scenario declares:
those drives show that the requirements hold there too; bounds come from the scenario as it is written. Drives of one
seed share the noise of the sensors that do not see the scenario, GNSS and wheels, in all scenarios: `fresh` therefore
takes other seeds in each.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from pytest_dvp.drive.run import run
from pytest_dvp.metrics import compute
from scenarios import path

STORE = Path("runs/shipped_gates")
FOLDER = path("overtaking.xosc").parent
VARIANT = 6
APART = 60_000  # between the fresh seeds of two scenarios; a multiple of VARIANT

# Metrics that gates ask with other options than the default ones: those of short faults, and of what is far away.
WITH_OPTIONS: tuple[tuple[str, Mapping[str, Any]], ...] = (
    ("localization_error", {"statistic": "greatest"}),
    ("heading_error", {"statistic": "greatest"}),
    ("speed_error", {"statistic": "greatest"}),
    ("detection_recall", {"reach": 40.0}),
    ("false_tracks", {"reach": 40.0}),
    ("track_position_error", {"reach": 40.0}),
    ("track_speed_error", {"reach": 40.0}),
    ("track_size_error", {"reach": 40.0}),
    ("kind_error", {"reach": 40.0}),
    ("repeated_commands", {"signal": "accel_cmd"}),
    ("steer_roughness", {"signal": "steer"}),
    *(("input_age", {"sensor": s}) for s in ("gnss", "odometry", "imu", "lidar", "camera")),
    *(("input_age", {"sensor": s, "statistic": "least"}) for s in ("gnss", "odometry", "imu", "lidar", "camera")),
    *(("nis", {"sensor": s}) for s in ("gnss", "heading", "wheels")),
    *(("nis", {"sensor": s, "statistic": "greatest"}) for s in ("gnss", "heading", "wheels")),
)


def names() -> list[str]:
    """The scenarios that ship."""
    return sorted(file.stem for file in FOLDER.glob("*.xosc"))


def key(metric: str, options: Mapping[str, Any]) -> str:
    """How the store calls a metric: `detection_recall reach=40.0`."""
    return " ".join([metric, *(f"{name}={value}" for name, value in sorted(options.items()))])


def drawn(scenario: str, seed: int) -> dict[str, float]:
    """Parameters of a drive: none, but uniform over the declared ranges for every sixth seed."""
    if seed % VARIANT != VARIANT - 1:
        return {}
    from scripts.ads_figures_behaviour import ranges

    rng = np.random.default_rng([seed, *scenario.encode()])
    return {name: round(float(rng.uniform(low, high)), 3) for name, (low, high) in ranges(scenario).items()}


def driven(scenario: str, seed: int, parameters: Mapping[str, float] | None = None, **options: Any) -> dict[str, Any]:
    """One drive as the store keeps it: status, gates that did not pass, all metrics (None: undefined)."""
    file = FOLDER / f"{scenario}.xosc"
    result = run(file, seed=seed, parameters=dict(parameters or {}), rootdir=FOLDER, **options)
    metrics = dict(result.metrics)
    for metric, given in WITH_OPTIONS:
        metrics[key(metric, given)] = compute(metric, result.log, **given).value
    failed = sorted({verdict.gate for verdict in result.verdicts if verdict.status != "PASS"})
    return {
        "scenario": scenario, "seed": seed, "parameters": dict(parameters or {}), "status": result.status,
        "failed": failed, "metrics": {name: _finite(value) for name, value in metrics.items()},
    }  # fmt: skip


def stored(file: Path) -> Iterator[dict[str, Any]]:
    """The drives of a file; a line that an interruption cut short is left out."""
    for line in file.read_text("utf-8").splitlines() if file.is_file() else ():
        try:
            yield json.loads(line)
        except ValueError:
            continue


def go_on(file: Path, wanted: list[tuple[Any, ...]], key_of: Callable[[dict[str, Any]], tuple[Any, ...]],
          drive: Callable[..., dict[str, Any]]) -> None:  # fmt: skip
    """Drive what the file does not hold yet, a line each, with progress on stderr."""
    file.parent.mkdir(parents=True, exist_ok=True)
    there = {key_of(row) for row in stored(file)}
    left = [one for one in wanted if one not in there]
    cut = file.is_file() and not file.read_bytes().endswith(b"\n")
    with file.open("a", encoding="utf-8") as out:
        out.write("\n" if cut else "")
        for n, one in enumerate(left, 1):
            print(f"\r{n} of {len(left)}: {one}".ljust(100)[:100], end="", file=sys.stderr)
            out.write(json.dumps(drive(*one)) + "\n")
            out.flush()
    print(file=sys.stderr)


def clean(scenario: str, seed: int) -> dict[str, Any]:
    """One drive without a fault."""
    return driven(scenario, seed, drawn(scenario, seed))


def _finite(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "what", choices=["clean", "fresh"], help="fresh: seeds after the gates stood, in a file of their own"
    )
    parser.add_argument("first", type=int)
    parser.add_argument("last", type=int)
    parser.add_argument("--scenario", nargs="+", default=None)
    asked = parser.parse_args()
    apart = APART if asked.what == "fresh" else 0
    chosen = [(name, apart * k) for k, name in enumerate(names()) if name in (asked.scenario or names())]
    wanted = [(name, seed + own) for seed in range(asked.first, asked.last) for name, own in chosen]
    go_on(STORE / f"{asked.what}.jsonl", wanted, lambda row: (row["scenario"], row["seed"]), clean)


if __name__ == "__main__":
    main()
