"""A drive-by-wire on a virtual CAN bus: handshake, watchdog, refused frames; the surrogate's side in this process."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("cantools")

import can

from vehicle.adapter import Hands, VehicleLost
from vehicle.adapters.can_bus import CanActuators
from vehicle.messages import Command, Odometry
from vehicle.surrogate.ecu import DriveByWire
from vehicle.wire.can_codec import Frame
from vehicle.wire.can_link import DONE, STEP, BusError, Link, open_bus
from vehicle.wire.can_map import find_map

MS = 1_000_000  # ns
CYCLE = 20 * MS
SECOND = 1000 * MS


class Pair:
    """Both ends, moved on by hand: a cycle of 20 ms as harness and surrogate do it."""

    def __init__(self, name: str) -> None:
        car = find_map()
        self.unit = DriveByWire(f"virtual:{name}", car)
        self.harness = CanActuators(f"virtual:{name}", car, lambda: None, timeout=0.2)
        self.number, self.now = 0, 0

    def cycle(self, *, silent: bool = False, wheels: Odometry | None = None) -> Command | None:
        """What the actuators get in this cycle."""
        self.number += 1
        if not silent:
            self.harness.cycle(self.now)
        self.harness.step(self.number)
        self.unit.hear(self.number, self.now)
        command = self.unit.command(self.now / 1e9)
        self.now += CYCLE
        self.unit.watch(self.now)
        self.unit.report(self.now, wheels or Odometry(0.0, 5.0, 0.1))
        self.unit.done(self.number)
        self.harness.stepped(self.number, self.now)
        return command


@pytest.fixture
def pair(request: pytest.FixtureRequest) -> Iterator[Pair]:
    pair = Pair(request.node.name)
    yield pair
    pair.harness.close()
    pair.unit.close()


def asked(t: float = 0.0, steer: float = 0.1, throttle: float = 0.3, brake: float = 0.0) -> Command:
    return Command(t, steer, 1.0, throttle, brake)


def test_nothing_is_sent_before_the_first_command(pair: Pair) -> None:
    """A dry run leaves the bus of a car alone."""
    watching = open_bus("virtual:test_nothing_is_sent_before_the_first_command")
    assert pair.cycle() is None
    seen = [message.arbitration_id for message in iter(lambda: watching.recv(0.0), None)]
    watching.shutdown()
    assert set(seen) & {m.frame_id for m in find_map().database.messages if m.senders == ["HARNESS"]} == set()
    assert seen.count(STEP) == 1
    assert pair.unit.mode == "manual"


def test_automatic_is_granted_with_the_first_beat_and_command(pair: Pair) -> None:
    pair.harness.apply(asked())
    command = pair.cycle()
    assert command is not None
    assert (command.steer, command.throttle, command.brake) == pytest.approx((0.1, 0.3, 0.0), abs=5e-5)
    assert pair.unit.mode == "automatic"


def test_a_heartbeat_of_four_bits_does_not_stand_still(tmp_path: Path) -> None:
    """It begins again after 15: at its signal's end a heart that counts on has stopped."""
    ours = find_map()
    (tmp_path / "car.dbc").write_text(ours.dbc.read_text().replace("BEAT : 16|16@1+", "BEAT : 16|4@1+"))
    (tmp_path / "car.toml").write_text(ours.file.read_text())
    spy = open_bus("virtual:heart")
    harness = CanActuators("virtual:heart", find_map(tmp_path / "car.dbc"), lambda: None, timeout=0.2)
    harness.apply(asked())
    for k in range(40):
        harness.cycle(k * CYCLE)
    harness.close()
    beats = [message.data[2] & 15 for message in iter(lambda: spy.recv(0.0), None) if message.arbitration_id == 260]
    spy.shutdown()
    assert beats == [k % 16 for k in range(1, 41)]


def test_reports_carry_the_time_they_were_measured_at(pair: Pair) -> None:
    pair.cycle(wheels=Odometry(0.0, 7.0, -0.2))
    (report,) = pair.harness.reports()
    assert report.t == pytest.approx(0.02)
    assert (report.v, report.steer) == pytest.approx((7.0, -0.2), abs=1e-3)
    assert pair.harness.reports() == []


def test_a_heart_that_stops_makes_the_car_brake_by_itself_within_100_ms(pair: Pair) -> None:
    pair.harness.apply(asked())
    pair.cycle()
    for _ in range(3):
        driving = pair.cycle(silent=True)
        assert driving is not None
        assert driving.brake == 0.0
    with pytest.raises(VehicleLost, match="drive-by-wire is in mode fault, asked for was automatic"):
        pair.cycle(silent=True)  # the fourth cycle without a beat ends 100 ms after the last
    assert pair.unit.mode == "fault"
    halt = pair.unit.command(1.0)
    assert halt is not None
    assert (halt.brake, halt.throttle) == (1.0, 0.0)
    assert halt.steer == pytest.approx(0.1, abs=5e-5)


def test_after_a_fault_automatic_needs_manual_first(pair: Pair) -> None:
    pair.harness.apply(asked())
    pair.cycle()
    pair.unit.watch(pair.now + 100 * MS)
    command = pair.cycle()
    assert command is not None
    assert (pair.unit.mode, command.brake) == ("fault", 1.0)
    pair.unit.reset()
    pair.harness.reset()
    pair.harness.apply(asked())
    pair.cycle()
    assert pair.unit.mode == "automatic"


def test_a_stranger_on_a_simulated_bus_is_found_out(pair: Pair) -> None:
    pair.harness.apply(asked())
    pair.cycle()
    stranger = Link(
        open_bus("virtual:test_a_stranger_on_a_simulated_bus_is_found_out"), frozenset(), lambda: None, steps=False
    )
    stranger.send(Frame(256, False, bytes(8)))
    stranger.close()
    with pytest.raises(BusError, match="lost"):
        pair.cycle()


def test_a_frame_of_the_car_that_is_spoilt_does_not_count_and_is_named(
    pair: Pair, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A bit of the reported angle flips on the bus: the angle before it stands."""
    pair.cycle(wheels=Odometry(0.0, 5.0, 0.1))
    frames = pair.unit._codec.frames

    def spoilt(*values: object, **options: object) -> list[Frame]:
        steering, *others = frames(*values, **options)  # type: ignore[arg-type]
        return [steering._replace(data=steering.data[:2] + b"\xff" + steering.data[3:]), *others]

    monkeypatch.setattr(pair.unit._codec, "frames", spoilt)
    pair.cycle(wheels=Odometry(0.0, 5.0, 0.3))
    assert [report.steer for report in pair.harness.reports()] == pytest.approx([0.1, 0.1])
    (trouble,) = pair.harness.troubles()
    assert (trouble.topic, trouble.what, trouble.t) == ("CAN DBW_STEER_STATE", "checksum", pytest.approx(0.04))
    assert pair.harness.troubles() == []


def test_a_bus_that_loses_a_frame_is_found_out() -> None:
    one, other = (open_bus("virtual:lossy") for _ in range(2))
    sender, receiver = (Link(bus, frozenset(), lambda: None, steps=k == 0) for k, bus in enumerate((one, other)))
    sender.send(Frame(1, False, b"\x01"))
    sender.send(Frame(2, False, b"\x02"))
    assert other.recv(0.0) is not None  # lost
    sender.say(STEP, 1)
    with pytest.raises(BusError, match="the CAN bus lost 1 frames before step 1"):
        receiver.until(STEP, 1, 0.2)
    sender.close()
    receiver.close()


def test_frames_of_its_own_that_come_back_are_no_reason_to_doubt_the_car() -> None:
    """A bus between processes hands them to their sender, before the frames of the car."""

    def doubted() -> None:
        raise VehicleLost("it was asked for")

    one, other = (open_bus("virtual:echo") for _ in range(2))
    sender = Link(one, frozenset(), lambda: None, steps=False)
    receiver = Link(other, frozenset({(1, False)}), doubted, steps=True)
    for _ in range(20):
        one.send(can.Message(arbitration_id=1, is_extended_id=False, data=b"\x01"))
    sender.say(DONE, 1)
    assert receiver.until(DONE, 1, 60.0) == []
    with pytest.raises(VehicleLost, match="it was asked for"):  # silence is one
        receiver.until(DONE, 2, 60.0)
    sender.close()
    receiver.close()


def test_a_silent_car_is_one_line(pair: Pair) -> None:
    pair.harness.step(1)
    with pytest.raises(VehicleLost, match=r"^the car's CAN said nothing within 0\.2 s$"):
        pair.harness.stepped(1, 0)


@pytest.mark.parametrize(
    ("address", "says"),
    [
        ("can0", "expected INTERFACE:CHANNEL"),
        ("udp_multicast:239.1.1.1", "expected udp_multicast:GROUP:PORT"),
        ("socketcan:nosuchcan0", "'socketcan:nosuchcan0' cannot be opened"),
        ("nosuchinterface:1", "'nosuchinterface:1' cannot be opened"),
    ],
)
def test_a_bus_that_cannot_be_opened_is_one_line(address: str, says: str) -> None:
    with pytest.raises(BusError, match=says) as refused:
        open_bus(address)
    assert "\n" not in str(refused.value)


class LivePair(Pair):
    """By the wall clock, whose time is given by hand: nobody says when a cycle ends."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.spy = open_bus(f"virtual:{name}")

    def live(self, *, mute: bool = False, deaf: bool = False) -> Command | None:
        """A cycle; `mute`: the harness sends nothing; `deaf`: the car reports nothing."""
        if not mute:
            self.harness.cycle(self.now)
        self.unit.listen(self.now)
        self.unit.watch(self.now)
        command = self.unit.command(self.now / 1e9)
        self.now += CYCLE
        if not deaf:
            self.unit.report(self.now, Odometry(0.0, 5.0, 0.1), stamped=False)
        self.harness.listen(0, self.now)
        return command

    def close(self) -> None:
        self.spy.shutdown()
        self.harness.close()
        self.unit.close()


@pytest.fixture
def live(request: pytest.FixtureRequest) -> Iterator[LivePair]:
    with contextlib.closing(LivePair(request.node.name)) as pair:
        yield pair


def test_by_the_wall_clock_frames_of_the_car_alone_are_on_the_bus(live: LivePair) -> None:
    live.harness.apply(asked())
    assert live.live() == Command(0.0, pytest.approx(0.1, abs=1e-4), 0.0, pytest.approx(0.3, abs=1e-4), 0.0)
    seen = []
    while (message := live.spy.recv(0.0)) is not None:
        seen.append((message.arbitration_id, message.is_extended_id))
    assert seen
    assert not any(extended for _, extended in seen)  # STEP, DONE and TIME are


def test_by_the_wall_clock_a_report_is_of_when_it_came(live: LivePair, monkeypatch: pytest.MonkeyPatch) -> None:
    """The bus stamps by a wall clock that stands 1000 s off the monotonic one."""
    monkeypatch.setattr("vehicle.wire.can_link.time.monotonic_ns", lambda: time.time_ns() - 1_000 * SECOND)
    live.harness.apply(asked())
    before = time.time() - 1_000.0
    live.live()
    (report,) = live.harness.reports()
    assert before - 1e-3 <= report.t <= time.time() - 1_000.0 + 1e-3
    assert (report.v, report.steer) == pytest.approx((5.0, 0.1), abs=1e-3)


def test_by_the_wall_clock_a_command_that_stays_away_for_100_ms_makes_the_car_brake(live: LivePair) -> None:
    """And the harness is told that the car no longer obeys: 300 ms after it asked first, as it must not hurry a car."""
    live.harness.apply(asked())
    for _ in range(15):
        live.live()
    got = [live.live(mute=True) for _ in range(4)]
    assert [command and command.throttle for command in got] == pytest.approx([0.3] * 4, abs=1e-4)
    assert live.now - 15 * CYCLE == 80 * MS
    with pytest.raises(VehicleLost, match=r"^the car's drive-by-wire is in mode fault, asked for was automatic$"):
        live.live(mute=True)
    command = live.unit.command(live.now / 1e9)
    assert command is not None
    assert (command.accel, command.brake, command.steer) == (-7.0, 1.0, pytest.approx(0.1, abs=1e-4))


def test_by_the_wall_clock_a_can_that_falls_silent_is_a_lost_car(live: LivePair) -> None:
    """150 ms without a frame; before the first command a car may say nothing."""
    for _ in range(20):
        live.live(deaf=True)
    live.harness.apply(asked())
    live.live()
    for _ in range(7):
        live.live(deaf=True)  # 140 ms
    with pytest.raises(VehicleLost, match=r"^the car's CAN has been silent for 0\.16 s$"):
        live.live(deaf=True)


@pytest.mark.parametrize(
    "frame",
    [
        pytest.param((0x7DF, bytes(8)), id="of another unit"),
        pytest.param((275, bytes(8)), id="of the car, with a wrong checksum"),
    ],
)
def test_by_the_wall_clock_other_frames_on_the_bus_are_no_life_of_the_car(
    live: LivePair, frame: tuple[int, bytes]
) -> None:
    live.harness.apply(asked())
    live.live()
    message = can.Message(arbitration_id=frame[0], is_extended_id=False, data=frame[1])
    for _ in range(7):  # 140 ms
        live.spy.send(message)
        live.live(deaf=True)
    live.spy.send(message)
    with pytest.raises(VehicleLost, match=r"^the car's CAN has been silent for 0\.16 s$"):
        live.live(deaf=True)


def without(pair: Pair, frame_id: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """From now on the car leaves out one of its messages."""
    frames = pair.unit._codec.frames
    monkeypatch.setattr(
        pair.unit._codec, "frames", lambda *values, **more: [f for f in frames(*values, **more) if f.id != frame_id]
    )


def test_a_driver_who_takes_over_keeps_the_car_when_he_lets_go(pair: Pair, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nobody asks for automatic mode again, and that the car is in manual mode is no reason to call it lost."""
    frames, override = pair.unit._codec.frames, {"override": 1.0}
    monkeypatch.setattr(pair.unit._codec, "frames", lambda values, **more: frames(values | override, **more))
    pair.harness.apply(asked())
    spy = open_bus("virtual:test_a_driver_who_takes_over_keeps_the_car_when_he_lets_go")
    for _ in range(3):
        pair.cycle()
    override["override"] = 0.0
    for _ in range(10):
        pair.cycle()
    assert (pair.unit.mode, pair.harness.hands) == ("manual", Hands(False, False))
    modes = [message.data[2] & 3 for message in iter(lambda: spy.recv(0.0), None) if message.arbitration_id == 259]
    spy.shutdown()
    assert modes == [1] + [0] * 12
    pair.unit.reset()
    pair.harness.reset()
    pair.harness.apply(asked())
    pair.cycle()
    assert pair.unit.mode == "automatic"


def test_hands_that_are_reported_no_longer_are_the_drivers_after_200_ms(
    pair: Pair, monkeypatch: pytest.MonkeyPatch
) -> None:
    pair.harness.apply(asked())
    pair.cycle()
    without(pair, 275, monkeypatch)
    seen = []
    for _ in range(10):
        pair.cycle()
        seen.append(pair.harness.hands)
    assert seen == [Hands(False, False)] * 9 + [Hands(True, False)]


def test_hands_that_a_car_never_reports_are_the_drivers_after_200_ms(
    pair: Pair, monkeypatch: pytest.MonkeyPatch
) -> None:
    without(pair, 275, monkeypatch)
    seen = []
    for _ in range(11):
        pair.cycle()
        seen.append(pair.harness.hands)
    assert seen == [Hands(False, False)] * 10 + [Hands(True, False)]  # the first cycle's end is when it first listens


def test_a_steering_angle_that_is_reported_no_longer_is_not_used(pair: Pair, monkeypatch: pytest.MonkeyPatch) -> None:
    """For 200 ms the last one stands; then the speed alone is no report."""
    pair.cycle()
    without(pair, 272, monkeypatch)
    pair.harness.reports()
    for _ in range(20):
        pair.cycle()
    assert len(pair.harness.reports()) == 9
