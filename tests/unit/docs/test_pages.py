"""The pages under docs say what the code does: examples run, lists are whole, links lead somewhere."""

from __future__ import annotations

import importlib.util
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest

from pytest_dvp.logs.log import Log
from pytest_dvp.metrics import Metric, known_metrics
from pytest_dvp.metrics.metric import REQUIRED
from pytest_dvp.verdicts.judging import read_gates
from scenarios import __file__ as scenarios_file

DOCS = Path(__file__).parents[3] / "docs"
PAGES = sorted(DOCS.glob("*.md"))


def blocks(page: str, language: str) -> list[str]:
    text = (DOCS / page).read_text(encoding="utf-8")
    return re.findall(rf"^```{language}\n(.*?)^```", text, re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_to_files(page: Path) -> None:
    links = re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", page.read_text(encoding="utf-8"))
    assert [link for link in links if not (page.parent / link).exists()] == []


def test_the_index_names_every_page() -> None:
    index = (DOCS / "README.md").read_text(encoding="utf-8")
    missing = [page.name for page in PAGES if page.name != "README.md" and f"({page.name})" not in index]
    assert missing == [], "add a line to docs/README.md"


@pytest.mark.parametrize("name", list(known_metrics()))
def test_every_metric_is_in_the_table_with_unit_and_options(name: str) -> None:
    page = (DOCS / "metrics.md").read_text(encoding="utf-8")
    row = next((line for line in page.splitlines() if line.startswith(f"| `{name}` |")), "")
    assert row, f"add {name} to docs/metrics.md"
    assert row.split("|")[2].strip() == known_metrics()[name].unit
    options = [f"`{key}` = {value}" for key, value in known_metrics()[name].options.items() if value is not REQUIRED]
    assert "as above" in row or [option for option in options if option not in row] == []


def test_the_metric_of_ones_own_works_as_printed(tmp_path: Path) -> None:
    path = tmp_path / "my_metrics.py"
    path.write_text(blocks("metrics.md", "python")[0])
    spec = importlib.util.spec_from_file_location("my_metrics", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    mine = module.max_speed
    assert isinstance(mine, Metric)
    log = Log({"t": np.arange(5.0), "v": np.array([9.0, 1.0, 3.0, 7.0, 2.0])})
    measured = mine(log, after=1.0)
    assert (measured.value, measured.t) == (7.0, 3.0)


def test_the_gate_file_is_read_as_printed(tmp_path: Path) -> None:
    path = tmp_path / "x.gates.toml"
    whole, meant, further = blocks("your-project.md", "toml")
    path.write_text(whole)
    gates = read_gates(path)
    assert gates.task is not None
    assert [gate.metric for gate in gates.gates] == ["collision", "max_ttc_inverse", "max_jerk", "goal_reached"]
    path.write_text(meant)
    assert [gate.metric for gate in read_gates(path).gates] == ["events_fired", "event_started"]
    assert [table.get("metric") for table in tomllib.loads(further)["gate"]] == ["mncc", None]


def test_what_drives_the_default_car_is_what_the_pages_say() -> None:
    model = tomllib.loads((Path(scenarios_file).parent / "models" / "tabby_evo.toml").read_text(encoding="utf-8"))
    assert model["inputs"]["longitudinal"] == "throttle_cmd + brake_cmd"
    said = " ".join((DOCS / "your-project.md").read_text(encoding="utf-8").split())
    assert "is driven by `throttle` and `brake`**" in said
    assert f"full throttle asks for {model['inputs']['full_throttle']} m/s^2" in said
    assert f"full brake for {model['inputs']['full_brake']} m/s^2" in said
