"""python -m benchmarks.discover --seed HEX [--laws N] [--nulls N] [--json F] [--out docs/discover_table.md]

Hides laws in the twin's own kernel and asks `discover`. Each answer is a line of the JSON file as soon as it is there;
what the file has is not asked again. --minutes ends early, the next call goes on.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from pathlib import Path
from typing import Any

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):  # before numpy loads: CPU of one core
    os.environ.setdefault(_name, "1")

import numpy as np  # noqa: E402

from benchmarks.discover.foreign_base import KINDS, foreign  # noqa: E402
from benchmarks.discover.hidden_laws import NAMES, TAU, bounds, hidden, true_form  # noqa: E402
from pytest_dvp.gap.discover.discover import SHOWN, discover  # noqa: E402
from pytest_dvp.logs.log import Log  # noqa: E402
from tests.truth.effects import TruthCar  # noqa: E402
from tests.truth.generate import SIGMA, make_log  # noqa: E402
from vehicle.model.car import make_car  # noqa: E402
from vehicle.model.open_loop import Replay  # noqa: E402
from vehicle.model.vehicle_model import Inputs, VehicleModel  # noqa: E402

WRONG = (("steer_ratio", "g", 0.97, 1.03), ("drive_gain", "g", 0.95, 1.05), ("brake_gain", "g", 0.95, 1.05),
         ("rolling_resistance", "c", 0.02, 0.1), ("steer_offset", "offset", -0.004, 0.004))  # fmt: skip


VISIBLE = 1.3  # chi^2/N without the law, from which it counts as visible


def sheet() -> VehicleModel:
    """The data sheet of the car."""
    truth = TruthCar()
    known = {"wheelbase": truth.wheelbase, "cg_to_front_axle": truth.cg_to_front_axle, "mass": truth.mass}
    return VehicleModel("kinematic_bicycle", car=make_car(known), inputs=Inputs())


def driven(model: VehicleModel, name: str, values: dict[str, float], drive: str, seed: int) -> Log:
    """What a car with a hidden law, "" for none, shows of a drive's commands, with noise."""
    columns = make_log({}, drive, seed, "none")  # type: ignore[arg-type]
    commands = {key: columns[key] for key in ("steer_cmd", "accel_cmd")}
    extra = [hidden(name)] if name else []
    asked = {(f"hidden_{name}", key): value for key, value in values.items()}
    states = np.array([[0.0, 0.0, 0.0, 0.0, np.nan, np.nan]])
    rows = Replay(model, columns["t"], commands, extra=extra).run(asked, starts=np.zeros(1, np.int64), states=states)
    rng = np.random.default_rng(seed)
    measured = {
        key: rows[:, k] + SIGMA[key] * rng.standard_normal(len(rows))
        for k, key in enumerate(("x", "y", "yaw", "v", "yaw_rate", "ax", "ay"))
    }
    return Log({"t": columns["t"], **commands, **measured})


Case = tuple[VehicleModel, dict[str, Log], dict[str, Log], dict[str, Any]]


def made(seed: int, number: int, *, null: bool) -> Case:
    """A hidden law in our own kernel, or nothing hidden: model, logs, logs held out, and what is to be told of it."""
    rng = np.random.default_rng([seed, number, int(null)])
    name = "" if null else NAMES[number % len(NAMES)]
    model = sheet()
    car = model
    values = {"c": float(rng.uniform(*bounds(name))), "tau": float(rng.uniform(*TAU))} if name else {}
    wrong = null and number % 2 == 1
    if wrong:  # the car differs from its model by values that a diagnosis would name
        for effect, key, low, high in WRONG[: int(rng.integers(1, len(WRONG) + 1))]:
            car = car.with_effect(effect, {key: float(rng.uniform(low, high))})
    first = int(rng.integers(1, 1_000_000))
    logs = {"rich.csv": driven(car, name, values, "rich", first)}
    judge = {"urban.csv": driven(car, name, values, "urban", first + 7)}
    told = {"base": "wrong" if wrong else "true", "true": {**values, "form": true_form(name)} if name else {}}
    return model, logs, judge, told


def ask(key: str, seed: int, folder: Path) -> dict[str, Any]:
    """One case as a line."""
    kind, _, number = key.partition("/")
    if kind in KINDS:
        model, logs, judge, told = foreign(kind, int(number), seed, folder)
    else:
        model, logs, judge, told = made(seed, int(number), null=kind == "null")
    begin = time.process_time()
    law = discover(logs, model, judge)
    return {"case": key, **told, "cpu": round(time.process_time() - begin, 1)} | law.as_dict(None)


def keys(laws: int, nulls: int) -> list[str]:
    """The cases, a fifth of the nulls on a foreign base."""
    strange = nulls // 5
    own = [f"null/{k}" for k in range(nulls - strange)]
    other = [f"{KINDS[k % len(KINDS)]}/{k}" for k in range(strange)]
    return [*(f"{NAMES[k % len(NAMES)]}/{k}" for k in range(laws)), *own, *other]


def _hex(text: str) -> str:
    """The text, if it is a number in hexadecimal digits. Raises argparse.ArgumentTypeError."""
    if not text or set(text.lower()) - set("0123456789abcdef"):
        raise argparse.ArgumentTypeError(f"must be hexadecimal digits, such as fa07879d (found {text!r})")
    return text


def table(lines: list[dict[str, Any]], seed: str) -> str:
    """The page's table and figures."""
    laws = [line for line in lines if line["true"] and line["error"]["fit"]["before"] >= VISIBLE]
    hidden_too_well = sum(bool(line["true"]) for line in lines) - len(laws)
    nulls = [line for line in lines if not line["true"]]
    true = [line for line in laws if _is_true(line)]
    wrong = [line for line in laws if line["verdict"] == "LAW" and not _is_true(line)]
    judged = [line for line in laws if line["error"]["held_out"]["before"] >= 1.0 + SHOWN]
    most = [line for line in judged if line["error"]["held_out"]["removed"] >= 0.7]
    rows = [
        f"Seed {seed}; {len(laws)} hidden laws, {len(nulls)} cases without one; {hidden_too_well} more laws were "
        f"drawn so weak that chi^2/N without them is below {VISIBLE}.", "",
        "| figure | found | goal |", "|---|---|---|",
        f"| removes 70 % of the error or more where the held-out data show it | {len(most)}/{len(judged)} | 7 of 10 |",
        f"| the true form is the answer | {len(true)}/{len(laws)} | 6 of 10 |",
        f"| LAW said of a wrong form | {len(wrong)} | 0 |",
        *(f"| without a hidden law: {said} | {sum(x['verdict'] == said for x in nulls)}/{len(nulls)} | {goal} |"
          for said, goal in (("LAW", "0"), ("STAND_IN", "2 of 100"))),
        *(f"| of these, {kind}: LAW, STAND_IN, NO_LAW | {_split(nulls, kind)} | |" for kind in ("null", *KINDS)),
        f"| CPU of a case, most | {max(line['cpu'] for line in lines):.0f} s | 60 s |", "",
        "| hidden | answer | terms | removed, fitted and held out | CPU |", "|---|---|---|---|---|",
    ]  # fmt: skip
    for line in laws:
        named = "; ".join(f"{t['point']}: {t['c']['value']:.3g} {t['form']}" for t in line["terms"])
        terms = (named or line["reasons"][0]).replace("|", "&#124;")
        share = [f"{line['error'][side]['removed']:.0%}" for side in ("fit", "held_out")]
        rows.append(f"| {line['case']} | {line['verdict']} | {terms} | {' / '.join(share)} | {line['cpu']:.0f} s |")
    return "\n".join(rows) + "\n"


def _split(nulls: list[dict[str, Any]], kind: str) -> str:
    said = [line["verdict"] for line in nulls if line["case"].startswith(f"{kind}/")]
    return ", ".join(str(said.count(verdict)) for verdict in ("LAW", "STAND_IN", "NO_LAW"))


def _is_true(line: dict[str, Any]) -> bool:
    """Whether each term of the answer has the form that was hidden, and no term is missing."""
    forms = [form for form in line["true"]["form"].split("; ") if form]
    if len(forms) != len(line["terms"]):
        return False
    return bool(forms) and all(any(form in (term["form"], *term["same"]) for term in line["terms"]) for form in forms)


def main() -> int:
    """Returns 0: the figures are the result."""
    parser = argparse.ArgumentParser(description="Laws that no catalogue has: are they found?")
    parser.add_argument(
        "--seed", required=True, type=_hex, metavar="HEX", help="first 8 digits of the commit that froze the rule"
    )
    parser.add_argument("--laws", type=int, default=24)
    parser.add_argument("--nulls", type=int, default=100)
    parser.add_argument("--minutes", type=float, default=1e6, help="of CPU, after which no further case is begun")
    parser.add_argument("--json", type=Path, default=Path("runs/discover/answers.jsonl"), metavar="F")
    parser.add_argument("--out", type=Path, metavar="F", help="write the table")
    args = parser.parse_args()
    args.json.parent.mkdir(parents=True, exist_ok=True)
    known = args.json.read_text("utf-8").splitlines() if args.json.exists() else []
    lines = [json.loads(text) for text in known]
    for key in keys(args.laws, args.nulls):
        if key in {line["case"] for line in lines} or time.process_time() > 60.0 * args.minutes:
            continue
        line = ask(key, int(args.seed, 16), args.json.parent / f"twins-{args.seed}")
        lines.append(line)
        told = "; ".join(f"{t['point']} {t['form']}" for t in line["terms"]) or "; ".join(line["reasons"])
        print(f"{line['case']}: {line['verdict']} {told} ({line['cpu']} s)", file=sys.stderr, flush=True)
        with args.json.open("a", encoding="utf-8") as file:
            file.write(json.dumps(line) + "\n")
    if args.out:
        args.out.write_text(table(lines, args.seed), encoding="utf-8")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
