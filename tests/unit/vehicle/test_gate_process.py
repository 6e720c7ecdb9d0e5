"""The guard in a process of its own: it goes on when nobody asks, and brakes a car whose stack hangs."""

from __future__ import annotations

import json
import os
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.waiting import wait_until
from vehicle.adapter import VehicleLost
from vehicle.guard.guard import ArmingRefused
from vehicle.guard.host import Host
from vehicle.guard.messages import Arming, Decision, Outcome, State
from vehicle.guard.process import GuardProcess
from vehicle.guard.process_messages import Answer, Keys, Opening, pack, unpack
from vehicle.messages import Command, FloatArray, Observation, VehicleState, no_surroundings
from vehicle.wire.geodetic import Origin
from vehicle.wire.health import Trouble

CAR = '''
import json
import numpy as np
from vehicle.adapter import Hands, VehicleLost
from vehicle.messages import Imu, Observation, VehicleDescription
from vehicle.wire.health import Trouble


class Car:
    """Does what it is told at once, and writes that down; a point on a line."""

    is_real = real_time = True
    hands = Hands(False, False)
    description = VehicleDescription(3.0, 1.5, 1.4, 2.0, 1.0, 0.35, 20.0, 3.0, 7.0, 700.0)

    def __init__(self, argument):
        self.file = argument
        self.tell(lambda _: None)

    def tell(self, record):
        self.record = record

    def punctuality(self):
        return {"clock": "real", "commands": 3}

    def reset(self, state):
        self.t, self.x, self.v, self.accel, self.steer = state.t, state.x, state.v, 0.0, 0.0

    def observe(self, surroundings):
        self.record(Trouble(self.t, "/imu/data", "late", 0.2))
        return Observation(self.t, imu=(Imu(self.t, self.accel, 0.0, 0.0),))

    def apply(self, command):
        self.accel, self.steer = command.accel, command.steer
        if self.file:
            with open(self.file, "a") as file:
                file.write(json.dumps([command.t, command.accel, command.brake]) + "\\n")

    def step(self, dt):
        rows = []
        for _ in range(round(dt / 0.01)):
            self.t = round(self.t + 0.01, 9)
            self.v = max(0.0, self.v + 0.01 * self.accel)
            self.x += 0.01 * self.v
            rows.append([self.t, self.x, 0.0, 0.0, 0.0, self.v, self.v, 0.0, 0.0, self.accel, 0.0, self.steer])
        return np.array(rows).reshape(-1, 12)

    def stop(self):
        self.accel = -7.0

    def close(self):
        pass


class Lost(Car):
    """Gone after 0.2 s, which it writes down."""

    def step(self, dt):
        if self.t >= 0.2:
            with open(self.file, "a") as file:
                file.write("lost\\n")
            raise VehicleLost("the car has been silent for 0.16 s")
        return super().step(dt)


class Located(Car):
    """Writes down where its map lies."""

    def locate_map(self, origin, why_not):
        with open(self.file, "w") as file:
            json.dump([origin, why_not], file)


def none(argument):
    return "a car"


def broken(argument):
    raise RuntimeError("no battery")
'''
AREA = ((-50.0, -50.0), (500.0, -50.0), (500.0, 50.0), (-50.0, 50.0))
START = VehicleState(t=0.0, x=0.0, y=0.0, yaw=0.0, v=5.0)
KEYS = Keys("toy", Arming("toy", "x.xosc", 1))


@pytest.fixture(autouse=True)
def module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "toy_car_behind_gate.py").write_text(CAR)
    monkeypatch.syspath_prepend(tmp_path)


def opening(name: str = "Car", argument: str = "", **options: Any) -> Opening:
    given = {"parallel": False, "seed": 1, "name": "toy", "scenario": "x.xosc", "max_speed": 8.0, "area": AREA}
    return Opening(f"toy_car_behind_gate:{name}", argument, **{**given, **options})


class Asked:
    """A host that is asked without a wire between."""

    def __init__(self) -> None:
        self.host = Host(opening())
        self.decisions: list[Decision] = []

    def ask(self, what: str, given: object = None, kind: Any = None) -> Any:
        answer: Answer = self.host.answer(what, pack(given))
        self.decisions += answer.untold.decisions
        return unpack(answer.value, kind)

    def step(self, dt: float = 0.05) -> FloatArray:
        rows: FloatArray = self.ask("step", dt, FloatArray)
        return rows

    def drive(self, t: float) -> FloatArray:
        self.ask("observe", no_surroundings(), Observation)
        self.ask("apply", (Command(t, 0.0, 0.5, 0.2, 0.0), None))
        return self.step()


@pytest.fixture
def asked() -> Asked:
    asked = Asked()
    asked.ask("reset", (START, KEYS))
    return asked


def test_a_stack_that_hangs_has_the_car_braked_after_100_ms(asked: Asked) -> None:
    """A command of 0.1 s is in force; cycles of the gate's own follow each other at 20 ms."""
    for tick in range(3):
        asked.drive(0.05 * tick)
    for _ in range(10):
        asked.host.go_on()
    asked.ask("observe", no_surroundings(), Observation)
    own = [decision for decision in asked.decisions if decision.t > 0.1]
    assert {d.outcome is Outcome.STOP for d in own if d.t < 0.2 - 1e-9} == {False}
    stopping = [d for d in own if d.t >= 0.2 - 1e-9]
    assert stopping[0].t == pytest.approx(0.21)  # cycles are at 0.15, 0.17, 0.19, 0.21 s
    assert {d.outcome for d in stopping} == {Outcome.STOP}
    assert all(d.output.accel == -7.0 and d.output.throttle == 0.0 for d in stopping)
    assert stopping[0].reasons == ("command_not_fresh",)


def test_what_the_car_did_meanwhile_comes_with_the_next_steps(asked: Asked) -> None:
    """Each row of motion once, in its order, and the harness's time catches up with the gate's before it goes on."""
    rows = [asked.drive(0.0)]
    for _ in range(4):
        asked.host.go_on()  # 80 ms
    seen = asked.ask("observe", no_surroundings(), Observation)
    assert seen.t == 0.05  # the harness's
    rows += [asked.step(), asked.step()]  # 50 ms of the 80; the other 30, and 20 more
    assert [len(part) for part in rows] == [5, 8, 2]
    assert np.concatenate(rows)[:, 0] == pytest.approx(0.01 * np.arange(1, 16))


def test_it_goes_on_by_itself_only_while_the_car_is_driven(asked: Asked) -> None:
    assert asked.host.wait() is None
    asked.drive(0.0)
    wait = asked.host.wait()
    assert wait is not None
    assert 0.0 <= wait <= 0.02
    asked.ask("stop")
    assert asked.host.wait() is None


def test_without_keys_nothing_reaches_the_car_in_its_own_cycles_either() -> None:
    asked = Asked()
    asked.ask("reset", (START, Keys()))
    asked.drive(0.0)
    for _ in range(10):
        asked.host.go_on()
    rows = asked.step(0.25)
    assert rows[:, 5] == pytest.approx(5.0)  # it rolls on
    assert {decision.state for decision in asked.decisions} == {State.DRY}


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "told.txt"


@pytest.fixture
def car(file: Path) -> Iterator[GuardProcess]:
    decisions: list[Decision] = []
    troubles: list[Trouble] = []
    car = GuardProcess(opening(argument=str(file)), record=decisions.append, trouble=troubles.append)
    car.decisions, car.troubles = decisions, troubles  # type: ignore[attr-defined]
    yield car
    car.close()


def test_over_the_wire_it_is_used_as_a_gated_vehicle_is(car: GuardProcess) -> None:
    assert (car.is_real, car.needs_keys, car.armed) == (True, True, False)
    assert car.description.wheelbase == 2.0
    assert car.pid != os.getpid()
    car.reset(START, named="toy", arming=KEYS.arming)
    assert car.armed
    seen = car.observe(no_surroundings())
    assert seen.imu[0].ax == 0.0
    car.apply(Command(0.0, 0.0, 0.5, 0.2, 0.0))
    rows = car.step(0.05)
    assert rows[:5, 0] == pytest.approx([0.01, 0.02, 0.03, 0.04, 0.05])
    assert car.decisions[0].live  # type: ignore[attr-defined]
    assert (car.troubles[0].topic, car.troubles[0].what) == ("/imu/data", "late")  # type: ignore[attr-defined]
    assert car.punctuality() == {"clock": "real", "commands": 3}
    pid = car.pid
    car.close()
    assert car.punctuality() == {"clock": "real", "commands": 3}
    assert not Path(f"/proc/{pid}").exists()
    with pytest.raises(VehicleLost, match=r"^the vehicle is closed$"):
        car.step(0.05)


def test_keys_that_do_not_fit_are_refused_there_and_told_here(car: GuardProcess) -> None:
    with pytest.raises(ArmingRefused, match=r"^wrong vehicle: it is 'toy', but 'bus' was named$"):
        car.reset(START, named="bus", arming=KEYS.arming)
    assert not car.armed


def test_a_harness_that_says_nothing_has_its_car_braked(car: GuardProcess, file: Path) -> None:
    """Nothing is asked of it after one tick; its last word to the car is full braking."""
    car.reset(START, named="toy", arming=KEYS.arming)
    car.apply(Command(0.0, 0.0, 0.5, 0.2, 0.0))
    car.step(0.05)

    def said() -> list[list[float]]:
        return [json.loads(line) for line in file.read_text().splitlines() if line.endswith("]")]

    wait_until(lambda: said()[-1][1:] == [-7.0, 1.0], "the car is not braked")
    told = said()
    assert any(accel > 0.0 for _, accel, _ in told)  # what was asked for went out first
    first = next(t for t, accel, _ in told if accel == -7.0)
    assert first == pytest.approx(0.11)  # the first of its cycles that finds the command of t = 0 s 100 ms old


def test_what_the_gate_did_before_its_car_was_lost_is_told(file: Path) -> None:
    """The harness is away from 0.05 s on: braked from 0.11 s on, and lost at 0.2 s."""
    decisions: list[Decision] = []
    car = GuardProcess(opening("Lost", str(file)), record=decisions.append, trouble=lambda _: None)
    car.reset(START, named="toy", arming=KEYS.arming)
    car.apply(Command(0.0, 0.0, 0.5, 0.2, 0.0))
    car.step(0.05)
    wait_until(lambda: "lost" in file.read_text(), "the car is not lost")
    for ask in (lambda: car.observe(no_surroundings()), car.stop):
        with pytest.raises(VehicleLost, match=r"^the car has been silent for 0\.16 s$"):
            ask()
    assert car.punctuality() == {}
    car.close()
    stopping = [decision.t for decision in decisions if decision.outcome is Outcome.STOP]
    assert stopping == pytest.approx([0.11, 0.13, 0.15, 0.17, 0.19, 0.21])


@pytest.mark.parametrize(
    ("how", "says"),
    [
        (signal.SIGKILL, r"^the guard's process ended \(killed by SIGKILL\)$"),
        (signal.SIGSTOP, r"^the guard's process is stopped \(SIGSTOP\)$"),
    ],
)
def test_a_gate_that_dies_or_is_stopped_ends_the_run(car: GuardProcess, how: signal.Signals, says: str) -> None:
    car.reset(START)
    os.kill(car.pid, how)
    with pytest.raises(VehicleLost, match=says):
        car.step(0.05)


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("none", r"^vehicle 'toy': str is no Vehicle \(vehicle\.adapter\.Vehicle\)$"),
        ("broken", r"^the guard's process: RuntimeError: no battery$"),
        ("nothing", r"^the guard's process: AttributeError: .*has no attribute 'nothing'$"),
    ],
)
def test_a_car_that_cannot_be_opened_is_one_line(name: str, says: str) -> None:
    with pytest.raises(ValueError, match=says):
        GuardProcess(opening(name), record=lambda _: None, trouble=lambda _: None)


def test_a_car_behind_its_guard_learns_where_the_map_lies(tmp_path: Path) -> None:
    told = tmp_path / "told.json"
    origin = Origin(48.137, 11.575, None, 500.0, -200.0, 0.03, 0.9996)
    Host(unpack(pack(opening("Located", str(told), origin=origin, why_not="so")), Opening)).close()
    assert json.loads(told.read_text()) == [list(origin), "so"]
