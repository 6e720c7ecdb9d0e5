"""The page of the real cars says what its own values give on the measured logs."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from pytest_dvp.gap.diagnose.experiment import experiment_set
from pytest_dvp.gap.diagnose.run_setup import end_of_beginning
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_part import cut_log
from vehicle.model.effect_catalogue import run_setups
from vehicle.model.model_file import read_model

real_cars = pytest.importorskip("scripts.real_cars", reason="scripts/ is not on the path")

MODEL = """
[model]
base = "kinematic_bicycle"
[inputs]
steer = "steer"
longitudinal = "v"
[parameters]
wheelbase = 3.0
"""


def part(name: str) -> str:
    """The page's text on a study."""
    text: str = real_cars.PAGE.read_text(encoding="utf-8")
    found = re.search(rf"<!-- {name} -->\n(.*?)<!-- end of {name} -->", text, re.DOTALL)
    assert found, f"docs/real-cars.md says nothing of {name}"
    return found[1]


def cells(text: str) -> list[list[str]]:
    return [[c.strip() for c in line.strip("|").split("|")] for line in text.splitlines() if line.startswith("|")]


def printed(text: str) -> dict[tuple[str, str], float]:
    """The values of the page's table of effects."""
    values = {}
    for row in cells(text):
        effect = re.fullmatch(r"(?:add|change|remove) `(\w+)`|(input map)", row[0])
        if effect:
            values[effect[1] or "inputs", row[1].strip("`")] = float(row[2])
    return values


def own_setup(text: str) -> dict[tuple[str, str], float]:
    """What the page says of the held-out run's own set-up."""
    (line,) = (line for line in text.splitlines() if "Own set-up" in line)
    return {(name, key): float(value) for name, key, value in re.findall(r"`(\w+)` `(\w+)` (-?[\d.e-]*\d)", line)}


@pytest.mark.parametrize("study", real_cars.STUDIES, ids=lambda study: study.name)
def test_the_values_on_the_page_leave_the_error_on_the_page(shared_dir: Path, study: real_cars.Study) -> None:
    if not (shared_dir / "measurements").is_dir():
        pytest.skip("no measured logs in the reference material")
    text = part(study.name)
    logs, values = study.logs(shared_dir / "measurements", held_out=True), printed(text)
    if "Own set-up" in text:
        logs = {name: cut_log(log, end_of_beginning(log), np.inf) for name, log in logs.items()}
        values = {key: value for key, value in values.items() if key[0] not in run_setups()} | own_setup(text)
    left = experiment_set(logs, study.model(shared_dir / "measurements")).rmse(values)
    rows = {row[0].split(" ")[0]: float(row[2]) for row in cells(text) if re.match(r"[a-z_]+ \[", row[0])}
    for name in ("yaw_rate", "v"):
        if name in left:
            assert left[name] == pytest.approx(rows[name], rel=0.05), name  # values are printed with few digits


@pytest.mark.parametrize("study", real_cars.STUDIES, ids=lambda study: study.name)
def test_no_effect_on_the_page_loses_on_the_held_out_run(study: real_cars.Study) -> None:
    gains = [float(row[6]) for row in cells(part(study.name)) if len(row) == 8 and re.match(r"[-\d]*\d", row[6])]
    assert min(gains, default=0.0) >= 0.0


def test_position_error_of_a_car_that_goes_faster_than_its_wheels_say(tmp_path: Path) -> None:
    """1 m/s that the model does not know of is 2 m after 2 s."""
    t = np.arange(0.0, 20.0, 0.02)
    zero = np.zeros_like(t)
    log = Log({"t": t, "x": 11.0 * t, "y": zero, "yaw": zero, "yaw_rate": zero, "v": 10.0 + zero, "steer": zero})
    file = tmp_path / "car.toml"
    file.write_text(MODEL)
    assert real_cars.position_error({"log": log}, read_model(file), {}) == pytest.approx(2.0, rel=1e-3)


def test_a_study_takes_the_place_between_its_marks() -> None:
    page = "head\n<!-- a -->\nold\n<!-- end of a -->\ntail\n"
    assert real_cars.placed(page, "a", "new") == "head\n<!-- a -->\nnew\n<!-- end of a -->\ntail\n"
