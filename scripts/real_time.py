"""Real time on this machine: deadlines, round trips, mirror, and how soon a car that dies or hangs is noticed.

python -m scripts.real_time           writes its table into docs/your-vehicle.md; five minutes of wall time
"""

from __future__ import annotations

import argparse
import dataclasses
import os
import signal
import threading
import time
from pathlib import Path

import numpy as np

from pytest_dvp.drive.result import RunResult
from pytest_dvp.drive.run import run
from scenarios import path as shipped
from vehicle.adapter import VehicleLost
from vehicle.adapters.live import live_surrogate
from vehicle.messages import Command, VehicleState, no_surroundings

DRIVES = (
    ("overtaking", "pe", "surrogate"),
    ("pedestrian_crossing", "rw", "surrogate"),
    ("urban", "pe", "surrogate"),
    ("overtaking", "rw", "can"),
)
PAGE = Path("docs/your-vehicle.md")
BEGIN, END = "<!-- real time -->", "<!-- /real time -->"
STRIKES = 5  # of each kind


@dataclasses.dataclass(frozen=True)
class Struck:
    """How long [s] it took until a car that was struck was known to be lost, and whether its process is gone."""

    how: str
    seconds: float
    gone: bool


def strike(how: signal.Signals) -> Struck:
    """Drive for half a second, then kill or stop the car from another thread."""
    car = live_surrogate(7)
    struck: list[float] = []

    def hit() -> None:
        struck.append(time.monotonic())
        os.kill(car.process.pid, how)

    car.reset(VehicleState(t=0.0, x=0.0, y=0.0, yaw=0.0, v=5.0))
    timer = threading.Timer(0.5, hit)
    try:
        t = 0.0
        car.observe(no_surroundings())
        timer.start()
        while True:
            car.apply(Command(t, 0.0, 0.0, 0.0, 0.0))
            car.step(0.02)
            t += 0.02
    except VehicleLost:
        seconds = time.monotonic() - struck[0]
    finally:
        timer.cancel()
        car.close()
    return Struck(how.name, seconds, car.process.poll() is not None)


def drive(scenario: str, stage: str, vehicle: str) -> RunResult:
    """A shipped scenario by the wall clock."""
    return run(shipped(f"{scenario}.xosc"), stage=stage, vehicle=vehicle, clock="real")


def rows(results: list[tuple[str, RunResult]], strikes: list[Struck]) -> str:
    """The table of the page."""
    load, nice = os.getloadavg()[1], os.nice(0)
    how = f", at priority nice {nice}" if nice else ""
    how += f", {results[0][1].log.meta['timing']['scheduling']} scheduling"
    lines = [
        f"Measured on {os.cpu_count()} cores with a load average of {load:.1f}{how}, by `python -m scripts.real_time`:",
        "",
        "| drive | verdict | commands | over 10 ms late | 99 % within | worst | round trip | mirror error, worst |",
        "|---|---|---:|---:|---:|---:|---:|---:|",
    ]
    for name, result in results:
        told = result.log.meta["timing"]
        error = result.log.columns["mirror_error"]
        worst = f"{1000.0 * np.nanmax(error):.1f} mm" if np.isfinite(error).any() else "-"
        lines.append(
            f"| {name} | {result.status} | {told['commands']} | {100.0 * told['missed']:.2f} % "
            f"| {1000.0 * told['lateness_99']:.1f} ms | {1000.0 * told['lateness_worst']:.0f} ms "
            f"| {1000.0 * told['round_trip_median']:.1f} ms | {worst} |"
        )
    lines += ["", "| the car's process | noticed within | process left |", "|---|---:|---|"]
    for how in dict.fromkeys(one.how for one in strikes):
        mine = [one for one in strikes if one.how == how]
        left = "none" if all(one.gone for one in mine) else "some"
        lines.append(f"| {how}, {len(mine)} times | {1000.0 * max(one.seconds for one in mine):.0f} ms | {left} |")
    return "\n".join(lines)


def main() -> int:
    """Returns the exit code: 0 if every promise held."""
    parser = argparse.ArgumentParser(prog="python -m scripts.real_time", description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--dry", action="store_true", help="write no page")
    dry = parser.parse_args().dry
    results = [
        (f"{scenario}, {stage}{', can' * (vehicle == 'can')}", drive(scenario, stage, vehicle))
        for scenario, stage, vehicle in DRIVES
    ]
    strikes = [strike(how) for how in (signal.SIGKILL, signal.SIGSTOP) for _ in range(STRIKES)]
    text = rows(results, strikes)
    print(text)
    if not dry:
        page = PAGE.read_text(encoding="utf-8")
        before, rest = page.split(BEGIN)
        PAGE.write_text(f"{before}{BEGIN}\n{text}\n{END}{rest.split(END)[1]}", encoding="utf-8")
    missed = max(result.log.meta["timing"]["missed"] for _, result in results)
    return 0 if missed < 0.01 and max(one.seconds for one in strikes) <= 0.2 else 1


if __name__ == "__main__":
    raise SystemExit(main())
