"""What each parameter of P and S moves: drives of every scenario that ships with one parameter at an end of its range.

`python -m scripts.ads_figures_parameters` prints it; four minutes of CPU. What moves nothing here is tested where it
acts (tests/unit/ads/test_ads_each_parameter.py, tests/unit/vehicle/test_vehicle_each_parameter.py).
"""

from __future__ import annotations

import sys
from typing import Any

from ads.parameters import DECLARATIONS
from openscenario.findings import ScenarioError
from pytest_dvp.drive.run import run
from scenarios import path
from scripts.ads_figures_faults import SCENARIOS, SEED
from vehicle.model.simulator_parameters import S_PARAMETERS

Figure = dict[str, Any]
LONGEST = 130.0  # s simulated; the longest scenario takes 116 s


def figures() -> list[Figure]:
    """A row a parameter: in how many scenarios any metric is another than with the defaults, at each end."""
    nominal = {scenario: metrics(scenario) for scenario in SCENARIOS}
    ends = [("P", d.name, d.unit, d.low, d.high) for d in DECLARATIONS]
    ends += [("S", p.name, p.declaration.unit, p.declaration.low, p.declaration.high) for p in S_PARAMETERS]
    found = []
    for group, name, unit, low, high in ends:
        print(f"{group}.{name}", file=sys.stderr, flush=True)
        said = []
        for value in (low, high):
            drives = {scenario: metrics(scenario, **{group: {name: value}}) for scenario in SCENARIOS}
            moved = sum(one is not None and one != nominal[scenario] for scenario, one in drives.items())
            refused = sum(one is None for one in drives.values())
            more = f", {refused} allow no such value" if refused else ""
            said.append(f"{moved} at {value:g} {'' if unit == '-' else unit}".rstrip() + more)
        found.append({"name": f"{group}.{name}", "found": "; ".join(said), "goal": "shown", "met": None})
    return found


def metrics(scenario: str, **values: Any) -> dict[str, float | None] | None:
    """All metrics of a drive; None if the scenario does not allow the value."""
    file = path(f"{scenario}.xosc")
    try:
        return dict(run(file, seed=SEED, rootdir=file.parent, duration=LONGEST, **values).metrics)
    except ScenarioError:
        return None


def text() -> str:
    """What stands below the figures."""
    return f"""
Scenarios, of {len(SCENARIOS)}, in which any metric changes when this parameter alone is put to an end of its range
(seed {SEED}). All scenarios that ship set a speed, which stands before `LQR_v_max`. What each parameter does is tested
where it acts.
"""


if __name__ == "__main__":
    for figure in figures():
        print(f"{figure['name']}: {figure['found']}")
