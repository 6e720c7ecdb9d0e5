"""What the figures of faults under the gates that ship count, on drives made up here."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from scripts import ads_figures_shipped as shipped
from scripts.ads_figures_shipped import Drive

FAULTS = [SimpleNamespace(name=name, scenario="urban") for name in ("seen", "elsewhere", "nowhere", "unsure")]
FINE, CHANGED = Drive({}, False), Drive({}, True)


def test_each_fault_counts_once_and_a_scenario_of_its_own_apart(monkeypatch: pytest.MonkeyPatch) -> None:
    drives = {
        "seen": {"urban": Drive({"collision": "FAIL", "tet": "FAIL"}, True), "follow": Drive({"tet": "FAIL"}, True)},
        "elsewhere": {"urban": CHANGED, "follow": Drive({"tet": "FAIL"}, True)},
        "nowhere": {"urban": CHANGED, "follow": FINE},
        "unsure": {"urban": Drive({"goal_reached": "INCONCLUSIVE"}, True), "follow": FINE},
    }
    monkeypatch.setattr(shipped, "faults", lambda: FAULTS)
    monkeypatch.setattr(shipped, "drives", lambda: drives)
    monkeypatch.setattr(shipped, "SCENARIOS", ("urban", "follow"))
    monkeypatch.setattr(shipped, "drive", lambda *_: None)
    monkeypatch.setattr(shipped, "not_passed", lambda _: [])
    assert [(figure["found"], figure["met"]) for figure in shipped.figures()] == [
        ("2 (1 FAIL, 1 INCONCLUSIVE)", None),
        ("3 (2 FAIL, 1 INCONCLUSIVE)", None),
        ("4", None),  # of 6
        ("2 of 2", True),
    ]
    assert "of the 6 in which" in shipped.figures()[2]["name"]
    assert shipped.text().rstrip().endswith("No scenario that ships sees: nowhere.")
