"""How an FMU is driven through a log: each call, in its order, of an FMU that only writes down what it is asked."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.compare import fmu_model
from pytest_dvp.gap.compare.compared_model import CompareError
from pytest_dvp.gap.compare.fmu_model import FmuSubject, _between, _inputs, _line, _outputs, _simulated, _stepped
from pytest_dvp.gap.compare.segments import CHANNELS


def variable(name: str, causality: str, number: int, kind: str = "Real") -> SimpleNamespace:
    return SimpleNamespace(name=name, causality=causality, valueReference=number, type=kind)


VARIABLES = [
    variable("steer_cmd", "input", 3),
    variable("accel_cmd", "input", 4),
    variable("v", "output", 7),
    variable("yaw", "local", 8),
    variable("x", "parameter", 9),
    variable("inner", "output", 10),
]


def described(*, free: bool = True, version: str = "2.0", variables: list[SimpleNamespace] = VARIABLES) -> Any:
    steps = SimpleNamespace(canHandleVariableCommunicationStepSize=free)
    return SimpleNamespace(coSimulation=steps, fmiVersion=version, modelVariables=variables)


class Written:
    """An FMU that shows as v the time it has been stepped to, as yaw the steering command of that time."""

    def __init__(self) -> None:
        self.calls: list[tuple[str, object]] = []
        self.time, self.given = 0.0, [0.0, 0.0]

    def setupExperiment(self, startTime: float) -> None:
        self.calls.append(("setup", startTime))

    def enterInitializationMode(self, startTime: float | None = None) -> None:
        self.calls.append(("enter", startTime))

    def exitInitializationMode(self) -> None:
        self.calls.append(("exit", None))

    def setReal(self, into: list[int], values: list[float]) -> None:
        assert into == ([11] if self.time == 0.0 and len(self.calls) == 0 and len(values) == 1 else [3, 4])
        self.given = values
        self.calls.append(("put", tuple(values)))

    def setFloat64(self, into: list[int], values: list[float]) -> None:
        self.setReal(into, values)

    def getReal(self, out_of: list[int]) -> list[float]:
        assert out_of == [7, 8]
        self.calls.append(("get", None))
        return [self.time, self.given[0]]

    def getFloat64(self, out_of: list[int]) -> list[float]:
        return self.getReal(out_of)

    def doStep(self, currentCommunicationPoint: float, communicationStepSize: float) -> None:
        assert currentCommunicationPoint == pytest.approx(self.time)
        self.time += communicationStepSize
        self.calls.append(("step", pytest.approx(communicationStepSize)))

    def terminate(self) -> None:
        self.calls.append(("end", None))

    def freeInstance(self) -> None:
        self.calls.append(("free", None))


@pytest.fixture
def fmu(monkeypatch: pytest.MonkeyPatch) -> Written:
    one = Written()
    simulation = SimpleNamespace(instantiate_fmu=lambda folder, description, kind: one)
    monkeypatch.setattr(fmu_model.importlib, "import_module", lambda name: simulation)
    return one


T = np.array([10.0, 10.1, 10.3])
COLUMNS = {"steer_cmd": np.array([0.1, 0.2, 0.3]), "accel_cmd": np.array([1.0, 2.0, 3.0])}


def test_outputs_that_are_channels_are_read_also_local_ones() -> None:
    assert [v.name for v in _outputs(described())] == ["v", "yaw"]
    assert [v.name for v in _inputs(described())] == ["steer_cmd", "accel_cmd"]


def test_of_free_steps_a_thousandth_shows_the_command_of_the_stamp_and_the_rest_goes_on(fmu: Written) -> None:
    found = _stepped(None, "", described(), T, COLUMNS, {})
    assert fmu.calls == [
        ("setup", 0.0), ("enter", None), ("put", (0.1, 1.0)), ("exit", None),
        ("put", (0.1, 1.0)), ("step", 0.0001), ("get", None), ("step", 0.0999),
        ("put", (0.2, 2.0)), ("step", 0.0002), ("get", None), ("step", 0.1998),
        ("put", (0.3, 3.0)), ("step", 0.00015), ("get", None),  # a usual step: the median of 0.1 and 0.2
        ("end", None), ("free", None),
    ]  # fmt: skip
    assert found[:, CHANNELS.index("v")] == pytest.approx([0.0001, 0.1002, 0.30015])
    assert found[:, CHANNELS.index("yaw")].tolist() == [0.1, 0.2, 0.3]
    assert np.isnan(np.delete(found, [CHANNELS.index("v"), CHANNELS.index("yaw")], axis=1)).all()


def test_an_fmu_of_version_3_is_told_the_start_when_it_begins(fmu: Written) -> None:
    _stepped(None, "", described(version="3.0"), T, COLUMNS, {})
    assert fmu.calls[:3] == [("enter", 0.0), ("put", (0.1, 1.0)), ("exit", None)]


def test_an_fmu_is_put_where_the_log_begins_before_it_is_set_up(fmu: Written) -> None:
    """In the units that it declares, by parameters alone, and only where the log tells the start."""
    parameters = [variable("v0", "parameter", 11), variable("x0", "output", 12), variable("yaw0", "parameter", 13)]
    parameters[0].unit = "km/h"
    description = described(variables=[*VARIABLES, *parameters])
    subject = FmuSubject(Path("a.fmu"))
    start = subject._start(description, {"x": 5.0, "y": 6.0, "yaw": math.nan, "v": 10.0})
    assert start == {"v0": pytest.approx(36.0)}
    _stepped(None, "", description, T, COLUMNS, start)
    assert fmu.calls[:2] == [("put", (pytest.approx(36.0),)), ("setup", 0.0)]


def test_an_fmu_of_one_step_length_goes_in_usual_steps_and_is_read_between_them(fmu: Written) -> None:
    """Steps of 0.15 s: 0, 0.15 and 0.3 s; the command is that of the last stamp, so 0.1, 0.2 and 0.3."""
    found = _stepped(None, "", described(free=False), T, COLUMNS, {})
    assert fmu.calls[4:] == [
        ("put", (0.1, 1.0)), ("get", None), ("step", 0.15),
        ("put", (0.2, 2.0)), ("get", None), ("step", 0.15),
        ("put", (0.3, 3.0)), ("get", None), ("end", None), ("free", None),
    ]  # fmt: skip
    assert found[:, CHANNELS.index("v")] == pytest.approx([0.0, 0.1, 0.3])
    assert found[:, CHANNELS.index("yaw")] == pytest.approx([0.1, 0.1 + 0.1 * 0.1 / 0.15, 0.3])


def test_steps_of_one_length_reach_beyond_the_last_stamp(fmu: Written) -> None:
    t = np.array([0.0, 0.1, 0.2, 0.35])
    columns = {name: np.append(values, values[-1]) for name, values in COLUMNS.items()}
    found = _stepped(None, "", described(free=False), t, columns, {})
    assert [name for name, _ in fmu.calls].count("step") == 4  # to 0.4 s
    assert found[:, CHANNELS.index("v")] == pytest.approx([0.0, 0.1, 0.2, 0.35])


def test_an_fmu_without_inputs_is_given_nothing_and_one_that_fails_is_let_go(fmu: Written) -> None:
    _stepped(None, "", described(variables=VARIABLES[2:]), T, {}, {})
    assert "put" not in [name for name, _ in fmu.calls]
    fmu.time = 0.0
    fmu.terminate = lambda: 1 / 0  # type: ignore[assignment, method-assign]
    with pytest.raises(ZeroDivisionError):
        _stepped(None, "", described(variables=VARIABLES[2:]), T, {}, {})
    assert fmu.calls[-1] == ("free", None)


def test_model_exchange_is_given_commands_that_are_held_and_read_after_each_event() -> None:
    asked: dict[str, Any] = {}

    def simulate(folder: str, **options: Any) -> Any:
        asked.update(options, folder=folder)
        times = np.array([0.0, 0.1, 0.1, 0.3, 0.3])
        result = np.zeros(5, dtype=[("time", float), ("v", float)])
        result["time"], result["v"] = times, [1.0, 2.0, 3.0, 4.0, 5.0]
        return result

    found = _simulated(SimpleNamespace(simulate_fmu=simulate), "here", T, COLUMNS, ["v"], {"v0": 3.0})
    assert found[:, CHANNELS.index("v")] == pytest.approx([1.0, 3.0, 5.0])
    assert (asked["folder"], asked["output"], asked["record_events"]) == ("here", ["v"], True)
    assert (asked["start_time"], asked["stop_time"]) == (0.0, pytest.approx(0.3))
    assert asked["start_values"] == {"v0": 3.0}
    assert asked["output_interval"] == pytest.approx(0.15)
    assert asked["input"]["time"] == pytest.approx([0.0, 0.1, 0.1, 0.3, 0.3])
    assert asked["input"]["steer_cmd"].tolist() == [0.1, 0.1, 0.2, 0.2, 0.3]
    _simulated(SimpleNamespace(simulate_fmu=simulate), "here", T, {}, ["v"], {})
    assert asked["input"] is None


def test_rows_between_steps_lie_on_straight_lines() -> None:
    found = _between(np.array([0.0, 1.0]), np.array([[0.0, 4.0], [2.0, 0.0]]), np.array([0.25, 1.0]))
    assert found.tolist() == [[0.5, 3.0], [2.0, 0.0]]


def test_a_message_of_an_fmu_is_one_line_of_300_letters() -> None:
    assert _line(ValueError("a\n  b")) == "a b"
    assert len(_line(ValueError(400 * "x"))) == 300


class Reading:
    """FMPy as far as it reads and unpacks."""

    def __init__(self, description: Any, folder: Path) -> None:
        self.description, self.folder = description, folder

    def read_model_description(self, path: str) -> Any:
        return self.description

    def extract(self, path: str) -> str:
        self.folder.mkdir()
        return str(self.folder)

    def simulate_fmu(self, folder: str, **options: Any) -> Any:
        result = np.zeros(2, dtype=[("time", float), ("v", float), ("yaw", float)])
        result["time"], result["v"] = [0.0, 0.3], 6.0
        return result


@pytest.mark.parametrize(
    ("variables", "message"),
    [
        (VARIABLES[:2], "none of its outputs is named like a channel"),
        ([variable("gear", "input", 1, "Integer"), *VARIABLES], "input 'gear' is no real number"),
    ],
)
def test_an_fmu_that_cannot_be_driven_by_a_log_is_refused(
    variables: list[SimpleNamespace], message: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    reading = Reading(described(variables=variables), tmp_path / "x")
    monkeypatch.setattr(fmu_model.importlib, "import_module", lambda name: reading)
    with pytest.raises(CompareError, match=message):
        FmuSubject(Path("a.fmu"))._read()


@pytest.mark.parametrize(("steps", "version"), [(False, "2.0"), (True, "1.0")])
def test_an_fmu_without_steps_of_its_own_is_integrated_and_what_was_unpacked_is_removed(
    steps: bool, version: str, tmp_path: Path
) -> None:
    description = described(version=version)
    if not steps:
        description.coSimulation = None
    reading = Reading(description, tmp_path / "x")
    found = FmuSubject(Path("a.fmu"))._run(reading, description, T, COLUMNS, {})
    assert found[:, CHANNELS.index("v")].tolist() == [6.0, 6.0, 6.0]
    assert not reading.folder.exists()


def test_real_numbers_of_both_versions_are_taken(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    both = [variable("accel_cmd", "input", 1), variable("steer_cmd", "input", 2, "Float64"), *VARIABLES[2:]]
    reading = Reading(described(variables=both), tmp_path / "x")
    monkeypatch.setattr(fmu_model.importlib, "import_module", lambda name: reading)
    assert FmuSubject(Path("a.fmu"))._read() == (reading, reading.description)
