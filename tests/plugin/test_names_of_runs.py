"""JUnit and terminal tell the runs of one test apart."""

from __future__ import annotations

import pytest

from pytest_dvp.plugin.fixtures import _names


@pytest.mark.parametrize(
    ("runs", "names"),
    [
        ([("a/stop.xosc", "dt"), ("a/follow.xosc", "dt")], ["stop", "follow"]),
        ([("a/stop.xosc", "dt"), ("a/stop.xosc", "pe")], ["stop dt", "stop pe"]),
        ([("a/stop.xosc", "dt"), ("b/stop.xosc", "dt")], ["a/stop.xosc dt", "b/stop.xosc dt"]),
    ],
)
def test_each_run_has_a_name_of_its_own(runs: list[tuple[str, str]], names: list[str]) -> None:
    assert _names([{"scenario": scenario, "stage": stage} for scenario, stage in runs]) == names
