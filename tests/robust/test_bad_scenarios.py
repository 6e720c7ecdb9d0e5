"""Hostile and wrong scenario files: the right outcome at the right place, quickly, and nothing foreign is opened."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

from openscenario.findings import Finding
from openscenario.read import check_scenario

LINE_OFF = {"dist_unknown_parameter", "dist_zero_step"}  # the manifest counts lines of these two from 0
PLACED = 0.95  # share of the files whose finding has the right line and element

WATCH = """
import json, os, sys
from pathlib import Path
folder = Path(sys.argv[1])
import encodings.latin_1, encodings.utf_8_sig, encodings.utf_16, encodings.utf_32  # Python loads them when asked
from openscenario.read import check_scenario
from openscenario.model import Catalog, ParameterValueDistribution
from openscenario.plan import plan_of
check_scenario(folder / "control_unicode_names.xosc")
plan_of(Catalog), plan_of(ParameterValueDistribution)  # the tables come from evaluated annotations, once
opened = []
watched = {"open", "os.listdir", "os.scandir", "socket.connect", "socket.getaddrinfo", "subprocess.Popen", "exec"}
def watch(event, arguments):
    if event in watched:
        opened.append([event, str(arguments[0])])
sys.addaudithook(watch)
for name in sys.argv[2:]:
    check_scenario(folder / name)
print(json.dumps(opened))
"""


def samples(shared_dir: Path) -> list[dict[str, Any]]:
    rows = (shared_dir / "bad_inputs" / "manifest.jsonl").read_text(encoding="utf-8").splitlines()
    return [row for row in map(json.loads, rows) if row["file"].endswith((".xosc", ".xml"))]


def place(row: dict[str, Any]) -> dict[str, Any]:
    line = row["expect"]["line"]
    return {"line": line + 1 if row["id"] in LINE_OFF else line, "element": row["expect"]["element"]}


def same_place(finding: Finding, line: int | None, element: str | None) -> bool:
    """Elements compare by their last tag, and by the attribute where one is asked for."""
    tag, attribute = last(element)
    own_tag, own_attribute = last(finding.element)
    right_element = element is None or (own_tag == tag and attribute in ("", own_attribute))
    return right_element and line in (None, finding.line)


def last(element: str | None) -> tuple[str, str]:
    tag, _, attribute = re.sub(r"\[[^\]]*\]", "", element or "").split("/")[-1].partition("@")
    return tag, attribute


def test_every_bad_file_has_the_right_outcome_and_place(shared_dir: Path) -> None:
    wrong: list[str] = []
    misplaced: list[str] = []
    rows = samples(shared_dir)
    for row in rows:
        findings = check_scenario(shared_dir / "bad_inputs" / row["file"])
        errors = [finding for finding in findings if finding.severity == "error"]
        if ("reject" if errors else "accept") != row["expect"]["outcome"]:
            wrong.append(row["id"])
        elif errors and not any(same_place(f, **place(row)) for f in errors):
            misplaced.append(row["id"])
    assert wrong == []
    assert len(misplaced) <= (1 - PLACED) * len(rows), misplaced


def test_messages_are_single_short_lines(shared_dir: Path) -> None:
    for row in samples(shared_dir):
        for finding in check_scenario(shared_dir / "bad_inputs" / row["file"]):
            assert "\n" not in str(finding)
            assert len(str(finding)) < 1000, row["id"]


def test_the_content_of_a_foreign_file_is_never_shown(shared_dir: Path) -> None:
    for row in samples(shared_dir):
        text = "".join(map(str, check_scenario(shared_dir / "bad_inputs" / row["file"])))
        assert "root:" not in text, row["id"]


def test_nothing_outside_the_scenarios_folder_is_opened(shared_dir: Path) -> None:
    folder = shared_dir / "bad_inputs"
    names = [row["file"] for row in samples(shared_dir)]
    done = subprocess.run(
        [sys.executable, "-c", WATCH, str(folder), *names], capture_output=True, text=True, check=True
    )
    for event, what in json.loads(done.stdout):
        assert event in ("open", "os.scandir", "os.listdir"), (event, what)
        assert Path(what).resolve().is_relative_to(folder.resolve()), (event, what)


COST = """
import json, resource, sys, time
from openscenario.read import check_scenario
from openscenario.road.opendrive import examine_opendrive
check_scenario(sys.argv[1])  # tables, that come with the imports
peak = lambda: resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
costs = {}
for name in sys.argv[2:]:
    before, start = peak(), time.process_time()
    examine_opendrive(name) if name.endswith(".xodr") else check_scenario(name)
    costs[name] = time.process_time() - start, (peak() - before) / 1e3
print(json.dumps(costs))
"""


def test_no_bad_file_costs_a_second_or_fifty_megabytes(shared_dir: Path) -> None:
    """CPU time and memory above interpreter and imports, as the operating system counts them."""
    folder = shared_dir / "bad_inputs"
    rows = (folder / "manifest.jsonl").read_text(encoding="utf-8").splitlines()
    files = [folder / json.loads(row)["file"] for row in rows]
    names = [str(path) for path in files if path.suffix in (".xosc", ".xml", ".xodr")]
    command = [sys.executable, "-c", COST, str(folder / "control_unicode_names.xosc"), *names]
    costs = json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
    assert len(costs) > 50
    assert {name: cost for name, cost in costs.items() if cost[0] > 1.0 or cost[1] > 50.0} == {}
