"""Figures of the faults seeded into the stack under the gates that ship (`scenarios/*.gates.toml`), as they ship.

`python -m scripts.ads_figures_shipped` prints them: every fault in every scenario that ships, five minutes of CPU.
"""

from __future__ import annotations

import sys
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "faults"))
from mutation import drive, faults, not_passed, seeded

from scripts.ads_figures_faults import SCENARIOS, SEED

Figure = dict[str, Any]


class Drive(NamedTuple):
    """One drive with a fault: status by metric of each gate that did not pass; whether any metric changed."""

    bad: dict[str, str]
    changed: bool


@cache
def drives() -> dict[str, dict[str, Drive]]:
    """Every fault in every scenario: by the name of the fault, then by scenario."""
    clean = {scenario: drive(scenario, SEED) for scenario in SCENARIOS}
    found: dict[str, dict[str, Drive]] = {}
    for number, fault in enumerate(faults(), 1):
        print(f"{number}/{len(faults())} {fault.name}", file=sys.stderr, flush=True)
        with seeded(fault):
            of_it = {scenario: drive(scenario, SEED) for scenario in SCENARIOS}
        found[fault.name] = {
            scenario: Drive({v.metric: v.status for v in not_passed(run)}, run.metrics != clean[scenario].metrics)
            for scenario, run in of_it.items()
        }
    return found


def figures() -> list[Figure]:
    """How many faults a gate that ships sees: in the scenario that the fault is for, in any of them, drive by drive."""
    own = [drives()[fault.name][fault.scenario].bad for fault in faults()]
    everywhere = [{k: v for one in of.values() for k, v in one.bad.items()} for of in drives().values()]
    failing = [any("FAIL" in one.bad.values() for one in of.values()) for of in drives().values()]
    changed = [one for of in drives().values() for one in of.values() if one.changed]
    clean = sum(not not_passed(drive(scenario, SEED)) for scenario in SCENARIOS)
    total = len(own)
    return [
        _shown(f"seeded faults that a gate that ships does not pass, in the fault's own scenario, of {total}",
               _told(sum(map(bool, own)), sum("FAIL" in bad.values() for bad in own))),
        _shown(f"the same in at least one of the {len(SCENARIOS)} scenarios, of {total}",
               _told(sum(map(bool, everywhere)), sum(failing))),
        _shown(f"drives that a gate that ships does not pass, of the {len(changed)} in which a fault changed a metric",
               str(sum(bool(one.bad) for one in changed))),
        {"name": "scenarios that pass all their gates without a fault", "found": f"{clean} of {len(SCENARIOS)}",
         "goal": "all", "met": clean == len(SCENARIOS)},
    ]  # fmt: skip


def text() -> str:
    """What stands below the figures: the faults that no scenario that ships sees."""
    unseen = [name for name, of in drives().items() if not any(one.bad for one in of.values())]
    return f"""
These are the bounds that a scenario ships with: what a user gets who changes nothing. They are wide, for stacks of any
make; bounds that are tightened to a stack's own values see more of its faults (next section). Seed {SEED}, urban with
its background traffic. No scenario that ships sees: {"; ".join(unseen)}.
"""


def _told(bad: int, fail: int) -> str:
    return f"{bad} ({fail} FAIL, {bad - fail} INCONCLUSIVE)"


def _shown(name: str, found: str) -> Figure:
    return {"name": name, "found": found, "goal": "shown", "met": None}


if __name__ == "__main__":
    for figure in figures():
        print(f"{figure['name']}: {figure['found']}")
    print(text())
