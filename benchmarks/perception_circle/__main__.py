"""python -m benchmarks.perception_circle [--effect NAME] [--seed 7] [--out docs/perception.md]

Hides perception effects in the surrogate, one after the other, and adds to the twin what the diagnosis makes of its
drives. Prints the table of what was hidden, found, and how alike the detections of car and twin then are.
"""

from __future__ import annotations

import argparse
import dataclasses
import os
import tempfile
import time
from pathlib import Path

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):  # before numpy loads: CPU of one core
    os.environ.setdefault(_name, "1")

from benchmarks.perception_circle.circle import HIDDEN, circle  # noqa: E402
from benchmarks.perception_circle.motion import learn_motion  # noqa: E402
from benchmarks.perception_circle.scene import write_street  # noqa: E402
from benchmarks.perception_circle.table import table, written_into  # noqa: E402


def main() -> int:
    """Ask all, print the table."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.perception_circle", description=__doc__)
    parser.add_argument("--effect", action="append", choices=["nothing", *HIDDEN], help="only this one")
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--seconds", type=float, default=40.0, help="length of a drive")
    parser.add_argument("--judges", type=int, default=3, help="seeds over which the last drives are averaged")
    parser.add_argument("--model", type=Path, help="twin to begin with; default: the data sheet, and the motion learnt")
    parser.add_argument("--out", type=Path, help="page in which the table is replaced")
    given = parser.parse_args()
    from scenarios import path
    from vehicle.model.errors import ModelError
    from vehicle.model.model_file import read_model

    done = []
    with tempfile.TemporaryDirectory() as folder:
        sheet = path("models/surrogate.toml")
        try:
            model = read_model(given.model) if given.model else learn_motion(sheet, Path(folder) / "motion")
        except ModelError as error:
            parser.error(f"--model: {error}")
        scenario = write_street(Path(folder) / "street", given.seconds)
        for name in given.effect or ["nothing", *HIDDEN]:
            begin = time.monotonic()
            hidden = {name: HIDDEN[name]} if name in HIDDEN else {}
            one = circle(scenario, Path(folder) / name, model, hidden, given.seed, judges=given.judges)
            done.append(one)
            print(f"{name}: {time.monotonic() - begin:.0f} s; named {', '.join(one.named) or 'nothing'}", flush=True)
            for label, shown in (("car", one.car), ("twin before", one.before), ("twin after", one.after)):
                told = (f"{k} {'-' if v is None else format(v, '.3g')}" for k, v in dataclasses.asdict(shown).items())
                print(f"    {label}: {', '.join(told)}", flush=True)
            print(f"    found: {one.found}", flush=True)
    print(table(done))
    if given.out:
        given.out.write_text(written_into(given.out.read_text(encoding="utf-8"), table(done)), encoding="utf-8")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
