"""Scenario and road files: reading, sampling, and the storyboard alone at 10 ms.

With the public corpus at `../shared` (or `DVP_SHARED`) the figures are medians over it, else over the shipped files.
"""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from benchmarks.measure import Row, cpu_seconds
from openscenario.findings import ScenarioError
from openscenario.read import read_scenario
from openscenario.road.network import RoadNetwork, load_network
from openscenario.road.opendrive import examine_opendrive
from openscenario.storyboard.play import play

ROOT = Path(__file__).resolve().parents[1]
SHIPPED = ROOT / "scenarios"
CORPUS = Path(os.environ.get("DVP_SHARED", ROOT.parent / "shared")) / "openscenario" / "corpus"
DT, DURATION = 0.01, 60.0  # s
SHORTEST = 1.0  # s, of a play that says something about speed
ESMINI = 415.0  # s/s, median over such a corpus, esmini 3.6


def run() -> list[Row]:
    folder = CORPUS if CORPUS.is_dir() else SHIPPED
    return [*_read(folder), *_play(folder), *_roads(folder), *large()]


def _scenarios(folder: Path) -> list[Path]:
    """Files that a scenario can be read of."""
    found = []
    for path in sorted(folder.rglob("*.xosc")):
        try:
            read_scenario(path, library=[folder])
        except ScenarioError:
            continue
        found.append(path)
    return found


def _read(folder: Path) -> list[Row]:
    spent = []
    for path in _scenarios(folder):
        begin = time.process_time()
        for _ in range(3):
            read_scenario(path, library=[folder])
        spent.append((time.process_time() - begin) / 3)
    note = f"{len(spent)} files with their catalogues, all checks; slowest {max(spent) * 1e3:.3g} ms"
    row = Row("read .xosc", statistics.median(spent) * 1e3, "ms", "<= 5", "scenariogeneration", 182.0, note)
    return [row]


def _play(folder: Path) -> list[Row]:
    rates = []
    for path in _scenarios(folder):
        scenario = read_scenario(path, library=[folder])
        logic = scenario.road_network.logic_file
        try:
            network = None if logic is None else load_network(logic)
            play(scenario, network, DT, 0.1)  # compiled before the clock runs
            begin = time.process_time()
            simulated = play(scenario, network, DT, DURATION).time
            spent = time.process_time() - begin
        except ScenarioError:
            continue  # refused with findings
        if simulated >= SHORTEST:
            rates.append(simulated / spent)
    tenth = statistics.quantiles(rates, n=10)[0]
    note = f"{len(rates)} scenarios, median; a tenth of them below {tenth:.3g}"
    return [Row("storyboard alone, 10 ms", statistics.median(rates), "s/s", ">= 100", "esmini 3.6", ESMINI, note)]


def _roads(folder: Path) -> list[Row]:
    path = max(folder.rglob("*.xodr"), key=_drivable_size)
    size = path.stat().st_size / 1e3
    network = load_network(path)
    points = sum(len(border.points) for border in network.boundaries(0.1))
    whole = cpu_seconds(lambda: load_network(path).boundaries(0.1))
    name = f".xodr of {size:.0f} kB"
    return [
        Row(f"{name}, read and checked", cpu_seconds(lambda: examine_opendrive(path)) * 1e3, "ms"),
        Row(f"{name}, all borders each 0.1 m", whole * 1e3, "ms", "<= 40", "pyxodr", 131.0, f"{points} points"),
        *_lookups(network),
    ]


CHILD = """
import sys, time
from pathlib import Path
from openscenario.road.opendrive import examine_opendrive
from openscenario.xml import read_xml
def of(name):
    return next(int(row.split()[1]) * 1024 for row in open("/proc/self/status") if row.startswith(name))
examine_opendrive(sys.argv[2])
Path("/proc/self/clear_refs").write_text("5")  # the peak begins anew (Linux)
before, begin = of("VmRSS"), time.process_time()
kept = read_xml(sys.argv[1]) if sys.argv[3] == "xml" else examine_opendrive(sys.argv[1])
print(time.process_time() - begin, of("VmHWM") - before)
"""


def large(megabytes: float = 16.0) -> list[Row]:
    """Time and memory that a file takes for each of its MB, in a process of its own: its XML alone, and as a road.

    The file is a row of roads of 1 km with the elements that an editor writes, of 16 MB.
    """
    lane = '<lane id="{0}" type="driving" level="false"><link/><width sOffset="0" a="3.5" b="0" c="0" d="0"/></lane>'
    geometry = '<geometry s="{0}.0" x="{0}.0" y="{1}.0" hdg="0.0" length="10.0"><line/></geometry>'
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        big, small = Path(folder, "big.xodr"), Path(folder, "small.xodr")
        for path, most in ((small, 0.01), (big, megabytes)):
            size, roads = 0, []
            while size < most * 1e6:
                n = len(roads)
                plan = "\n".join(geometry.format(10 * k, 20 * n) for k in range(100))
                sides = f"<left>{lane.format(1)}</left><center><lane id='0' type='none'/></center>"
                roads.append(
                    f'<road name="" length="1000.0" id="{n}" junction="-1"><link/><planView>\n{plan}</planView>\n'
                    f'<lanes><laneSection s="0">{sides}<right>{lane.format(-1)}</right></laneSection></lanes></road>\n'
                )
                size += len(roads[-1])
            path.write_text(f'<OpenDRIVE><header revMajor="1" revMinor="6"/>{"".join(roads)}</OpenDRIVE>')
        size = big.stat().st_size / 1e6
        for what, name in (("xml", "XML alone"), ("road", "as a road, checked")):
            words = [sys.executable, "-c", CHILD, str(big), str(small), what]
            told = subprocess.run(words, capture_output=True, text=True, check=True, cwd=ROOT).stdout.split()
            seconds, memory = float(told[0]), float(told[1]) / 1e6
            rows.append(Row(f"a file of {size:.0f} MB, {name}: time for a MB", seconds / size * 1e3, "ms"))
            rows.append(Row(f"a file of {size:.0f} MB, {name}: memory for a MB", memory / size, "MB"))
    return rows


def _drivable_size(path: Path) -> int:
    """Bytes of a road file without errors, 0 of others and of what is one straight road with a thousand signs."""
    network, findings = examine_opendrive(path)
    wrong = network is None or any(finding.severity == "error" for finding in findings)
    return 0 if wrong or network is None or len(network.roads) < 10 else path.stat().st_size


def _lookups(network: RoadNetwork) -> list[Row]:
    road = max(network.roads.values(), key=lambda each: each.length)
    lane = -1 if network.lane(road.id, -1, 0.0) is not None else 1
    pose = network.lane_pose(road.id, lane, 0.5 * road.length)
    there = cpu_seconds(lambda: network.lane_pose(road.id, lane, 0.5 * road.length))
    back = cpu_seconds(lambda: network.locate(pose.x, pose.y))
    return [Row("lane, s to pose", there * 1e6, "us"), Row("x, y to lane, s", back * 1e6, "us")]
