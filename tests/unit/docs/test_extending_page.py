"""docs/extending.md: each of its examples is put into its folder, found there, and does what it says."""

from __future__ import annotations

import dataclasses
import importlib
import json
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from vehicle.messages import TRACE_COLUMNS

PAGE = Path(__file__).parents[3] / "docs" / "extending.md"
TESTS = Path(__file__).parents[1]
EXAMPLES = dict(
    re.findall(r"^```python\n# (\S+)\.py\n(.*?)^```", PAGE.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
)


def _forget() -> None:
    """The catalogues read their folders anew."""
    from openscenario.storyboard.registry import action_factories, condition_factories
    from pytest_dvp.cli.dispatch import commands
    from pytest_dvp.logs.formats.log_format import log_formats
    from pytest_dvp.metrics.registry import known_metrics
    from reports.panels.panel import panels
    from vehicle.model.effect_catalogue import catalogue, run_setups
    from vehicle.sensors.further import further_sensors

    registries = (action_factories, condition_factories, commands, known_metrics, panels, catalogue, run_setups)
    for known in (*registries, further_sensors, log_formats):
        known.cache_clear()


@pytest.fixture(autouse=True)
def folders_with_the_examples(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Each package has a second folder, with the example in it and nothing else."""
    loaded = set(sys.modules)
    for name, text in EXAMPLES.items():
        file = tmp_path / "more" / f"{name}.py"
        file.parent.mkdir(parents=True)
        file.write_text(text, encoding="utf-8")
        package = importlib.import_module(name.rpartition("/")[0].replace("/", "."))
        monkeypatch.setattr(package, "__path__", [*package.__path__, str(file.parent)])
    _forget()
    yield
    for name in EXAMPLES:
        module, _, stem = name.replace("/", ".").rpartition(".")
        if f"{module}.{stem}" not in loaded and sys.modules.pop(f"{module}.{stem}", None):
            delattr(sys.modules[module], stem)
    _forget()


def test_there_is_an_example_of_each_kind_of_file() -> None:
    rows = re.findall(r"^\| [^|]+ \| 1(?: \+ 2)? \| `([^`]+)/` \|", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    assert len(rows) == 9
    assert sorted(rows) == sorted(name.rpartition("/")[0] for name in EXAMPLES)


def test_the_effect_lengthens_a_stop_as_its_equation_says() -> None:
    """v' = -a/(1 + c (v0^2 - v^2)/2) takes v0/a + c v0^3/(3 a) to standstill."""
    from vehicle.messages import VehicleState
    from vehicle.model.car import make_car
    from vehicle.model.effect_catalogue import find_effect
    from vehicle.model.plant import Plant
    from vehicle.model.vehicle_model import Inputs, VehicleModel

    plain = VehicleModel("kinematic_bicycle", Inputs(), make_car({"wheelbase": 2.5}))
    commands = np.zeros((120, 6))
    commands[:, 1] = -3.0
    for c in (0.0, 0.01):
        car = Plant(plain.with_effect(find_effect("brake_glazing"), {"c": c}))
        car.reset(VehicleState(t=0.0, x=0.0, y=0.0, yaw=0.0, v=10.0))
        trace = car.drive(commands, 50)
        moving = trace[trace[:, TRACE_COLUMNS.index("v")] > 1e-3]
        assert moving[-1, TRACE_COLUMNS.index("t")] == pytest.approx(10.0 / 3.0 + c * 1000.0 / 9.0, abs=0.02)


def test_the_effect_is_judged_by_what_shows_it_and_tried_as_a_detail() -> None:
    from pytest_dvp.doctor.excitation import excitation
    from pytest_dvp.gap.diagnose.candidates import candidates
    from pytest_dvp.logs.log import Log
    from vehicle.model.car import make_car
    from vehicle.model.effect_catalogue import catalogue
    from vehicle.model.vehicle_model import Inputs, VehicleModel

    t = np.arange(0.0, 20.0, 0.02)
    for fast, within in ((20.0, True), (8.0, False)):
        v = fast * (0.6 + 0.4 * np.cos(0.8 * t))
        shown = excitation(Log({"t": t, "v": v, "accel_cmd": np.gradient(v, t)}))
        assert ("brake_glazing" in shown.within_reach) is within
        assert ("10 m/s" in shown.out_of_reach.get("brake_glazing", "")) is not within
    model = VehicleModel("kinematic_bicycle", Inputs(), make_car({"wheelbase": 2.5}))
    (tried,) = candidates(model, [catalogue()["brake_glazing"]])
    assert tried.detail


def test_the_searcher_searches_a_study_that_names_its_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from pytest_dvp.tuning.searchers import search_names

    monkeypatch.syspath_prepend(str(TESTS / "tuning"))
    bowl: Any = importlib.import_module("bowl")
    assert "random_points" in search_names()
    one, other = (bowl.tuned(tmp_path / name, "random_points", budget=66) for name in ("one", "other"))
    assert [trial.point for trial in one.trials] == [trial.point for trial in other.trials]
    assert len(one.trials) == 33  # two seeds a point
    assert one.best.score.value < one.start.score.value


def test_the_metric_measures() -> None:
    from pytest_dvp.logs.log import Log
    from pytest_dvp.metrics import compute

    v = np.array([0.0, 0.0, 5.0, 0.05, 0.0, 0.09, 0.0, 3.0, 0.0])
    found = compute("longest_stop", Log({"t": np.arange(9.0), "v": v}))
    assert (found.value, found.t, found.unit) == (3.0, 3.0, "s")


def test_the_format_is_read_and_known_by_its_first_bytes(tmp_path: Path) -> None:
    from pytest_dvp.logs.log_error import LogError
    from pytest_dvp.logs.read_log import read_log

    rows = np.zeros(50, dtype=[("t_s", "f8"), ("speed_kmh", "f4")])
    rows["t_s"], rows["speed_kmh"] = np.arange(50) / 10.0, 36.0
    np.save(tmp_path / "a.npy", rows)
    assert read_log(tmp_path / "a.npy")["v"] == pytest.approx(10.0)  # 36 km/h
    (tmp_path / "a.csv").write_bytes((tmp_path / "a.npy").read_bytes())
    with pytest.raises(LogError, match=r"this is a NumPy file, not what \.csv says; rename it"):
        read_log(tmp_path / "a.csv")
    np.save(tmp_path / "b.npy", np.zeros(50))
    with pytest.raises(LogError, match="expected a row of records"):
        read_log(tmp_path / "b.npy")


def test_the_action_is_run_by_the_factory_of_its_class() -> None:
    from openscenario.storyboard.registry import action_factories

    (kind,) = [kind for kind in action_factories() if kind.__name__ == "HornAction"]
    board = SimpleNamespace(time=4.5, world=SimpleNamespace(commands=[]))
    run = action_factories()[kind](kind("high"), SimpleNamespace(name="Ego"), board)
    assert board.world.commands == []
    assert run.start()
    assert board.world.commands == [(4.5, "horn", "Ego: high")]


def test_the_condition_is_tested_by_the_factory_of_its_class() -> None:
    from openscenario.storyboard.registry import Scope, condition_factories

    (kind,) = [kind for kind in condition_factories() if kind.__name__ == "FacingCondition"]
    entity, other = SimpleNamespace(x=1.0, y=1.0, h=3.1), SimpleNamespace(x=-9.0, y=1.0, h=0.0)
    scope: Any = Scope(SimpleNamespace(entities={"Other": other}), None)  # type: ignore[arg-type]
    holds = condition_factories()[kind](kind("Other", 0.1), entity, scope)
    assert holds()
    other.y = 11.0  # to its right, by an eighth of a turn
    assert not holds()


def test_the_command_answers_as_text_and_as_json(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from pytest_dvp.cli.dispatch import main

    log = tmp_path / "log.csv"
    log.write_text("t [s],x [m],y [m]\n" + "".join(f"{k / 10},{0.3 * k},{0.4 * k}\n" for k in range(21)))
    assert main(["length", str(log)]) == 0
    assert capsys.readouterr().out == "2 s, 10 m\n"
    assert main(["length", str(log), "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == pytest.approx({"seconds": 2.0, "metres": 10.0})
    assert main(["--help"]) == 0
    assert "How long a log is, in seconds and in metres." in " ".join(capsys.readouterr().out.split())


def test_the_panel_stands_at_its_place_and_only_where_it_has_something_to_show(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    from reports.html import render_run_report

    monkeypatch.setattr("reports.frame.plotly_js", lambda: "/* plotly */")
    monkeypatch.setattr("reports.frame.packed_plotly", lambda: "")
    monkeypatch.syspath_prepend(str(TESTS / "reports"))
    run = importlib.import_module("synthetic_run").synthetic_run()
    run["meta"]["nets"] = [{"name": "light", "initial": ["go"], "places": {"go": ""}, "transitions": []}]
    v = run["columns"]["v"]
    run["columns"]["v"] = np.where(np.arange(len(v)) < len(v) // 4, 0.0, 5.0)
    page = render_run_report(**run)
    headings = re.findall(r"<h2>([A-Z]\w+)", page)
    assert headings[headings.index("Standing") + 1] == "Decision"
    assert "stood for 25.0 % of the run" in page
    del run["columns"]["v"]
    assert "Standing" not in render_run_report(**run)


def test_the_sensor_reaches_the_stack_and_leaves_the_others_as_they_were() -> None:
    import msgspec

    from vehicle.messages import Observation, Reading, Surroundings
    from vehicle.sensors import default_sensors

    suite = default_sensors()
    row = [0.0] * len(TRACE_COLUMNS)
    row[TRACE_COLUMNS.index("z")] = 7.0
    one, other = suite.start(row, 5), dataclasses.replace(suite, further={}).start(row, 5)
    nobody = Surroundings(np.zeros((0, 9)), np.zeros(0, np.int64), ())
    heights = []
    for tick in range(1, 401):
        rows = [[tick / 20.0, *row[1:]]]
        one.feed(rows)
        other.feed(rows)
        seen, plain = (each.observe(tick / 20.0, nobody) for each in (one, other))
        readings = seen.readings.get("barometer", ())
        heights += [value for reading in readings for value in reading.values]
        assert (seen.gnss, seen.odometry, seen.imu) == (plain.gnss, plain.odometry, plain.imu)
        assert plain.readings == {}
    assert len(heights) == pytest.approx(200, abs=1)  # 10 Hz for 20 s
    assert np.mean(heights) == pytest.approx(7.0, abs=4 * 0.1 / np.sqrt(200))  # four standard errors
    assert np.std(heights) == pytest.approx(0.1, rel=0.25)
    sent = Observation(1.0, readings={"barometer": (Reading(0.9, (7.0,)),)})
    assert msgspec.msgpack.decode(msgspec.msgpack.encode(sent), type=Observation) == sent
