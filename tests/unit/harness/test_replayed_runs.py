"""`--vehicle replay:LOG`: the same stack agrees with its own log, another one makes closed-loop metrics invalid."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from pytest_dvp.drive.result import RunResult
from pytest_dvp.drive.run import run
from pytest_dvp.drive.run_folder import measure
from pytest_dvp.drive.stages import StageError
from pytest_dvp.logs.read_log import read_log
from tests.unit.harness.conftest import OneTrick, coast
from tests.unit.harness.test_loop import WITH_TARGET
from vehicle.adapter import VehicleLost
from vehicle.messages import Command, Observation

Write = Callable[..., Path]
GATES = "[[gate]]\nmetric = 'max_jerk'\nmax = 4\n"


def steer_left(observation: Observation) -> Command:
    return Command(observation.t, 0.1 if observation.t >= 0.6 else 0.0, 0.0, 0.0, 0.0)


@pytest.fixture
def recorded(scenario: Write, tmp_path: Path) -> tuple[Path, Path]:
    """A scenario, and the run folder of a coasting ego in it."""
    path = scenario(*WITH_TARGET)
    path.with_name("x.gates.toml").write_text(GATES)
    result = run(path, duration=2.0, ads=OneTrick(coast), log_dir=tmp_path / "runs")
    assert result.folder is not None
    return path, result.folder


def replayed(recorded: tuple[Path, Path], stack: OneTrick, stage: str = "rw", cut: str = "") -> RunResult:
    path, log = recorded
    return run(path, stage=stage, vehicle=f"replay:{log}{cut}", ads=stack)


def test_the_motion_of_the_log_is_that_of_the_recording(recorded: tuple[Path, Path]) -> None:
    first = replayed(recorded, OneTrick(coast))
    assert first.stage == "rw-replay"
    assert first.ended == "the end of the recording"
    before, again = read_log(recorded[1]), first.log
    assert before.duration > 1.9
    for name in ("x", "y", "yaw", "v", "ax"):
        assert again[name] == pytest.approx(np.interp(again.t, before.t, before[name]), abs=1e-9)
    assert measure(again)["replay_steer_error"].value == 0.0
    assert first.status == "PASS"


def test_a_stack_that_asks_for_something_else_is_told_and_not_judged(recorded: tuple[Path, Path]) -> None:
    result = replayed(recorded, OneTrick(steer_left))
    (event,) = [event for event in result.log.events if event.kind == "replay"]
    assert (event.t, event.element) == (pytest.approx(0.6), "apart")
    values = measure(result.log)
    assert not values["max_jerk"].valid
    assert values["max_jerk"].reason.startswith(
        "the ego's motion is a recording's, and from t=0.60 s on the stack asked"
    )
    assert values["replay_steer_error"].valid
    assert values["replay_steer_error"].extra["greatest"] == pytest.approx(0.1)
    assert result.status == "INCONCLUSIVE"


def test_the_distance_to_the_recorded_commands_is_said_without_a_gate_on_it(recorded: tuple[Path, Path]) -> None:
    """0.1 rad off from 0.6 s to the end of the 2 s: root mean square 0.1 sqrt(29/41)."""
    (line,) = replayed(recorded, OneTrick(steer_left)).notes
    assert line == (
        "recording: off its commands by 0.084 rad (at most 0.1 at t=0.60 s), 0 m/s^2 (at most 0 at t=0.00 s), "
        "root mean square; apart from t=0.60 s on: metrics of the ego's motion are INVALID"
    )


@pytest.mark.parametrize("stage", ["pe", "rw"])
def test_what_was_not_recorded_is_rendered(recorded: tuple[Path, Path], stage: str) -> None:
    """The log has no LiDAR: the standing car of the scenario is seen from the recorded poses."""
    stack = OneTrick(coast)
    result = replayed(recorded, stack, stage)
    seen = [(one.t, one.lidar) for one in stack.seen if one.lidar is not None and len(one.lidar.points)]
    assert seen
    t, scan = seen[-1]
    target = result.log.objects["Target"]
    log = result.log
    rear = target.x[0] - 0.5 * target.length - float(np.interp(t, log.t, log["x"]))
    lidar_x = 1.2  # of the car that ships, within a decimetre or two
    assert scan.points[:, 0].min() == pytest.approx(rear - lidar_x, abs=0.6)


def test_a_log_that_begins_elsewhere_is_refused(recorded: tuple[Path, Path]) -> None:
    with pytest.raises(VehicleLost, match=r"@1:2: begins at x=.* a log can be cut: LOG@FROM:TO$"):
        replayed(recorded, OneTrick(coast), cut="@1:2")


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"vehicle": "replay:"}, r"no log \(replay:LOG or replay:LOG@FROM:TO\)$"),
        ({"vehicle": "replay:nowhere.mcap"}, r"^vehicle replay:nowhere\.mcap: no log nowhere\.mcap$"),
        ({"vehicle": "replay:{log}@5"}, r"@5: no such log; a part of one is .*@5: from there on, .*@:5 up to there$"),
        ({"vehicle": "replay:{log}", "require_real": True}, r"a recording cannot be driven$"),
        ({"vehicle": "replay:{log}", "fault": "drop"}, r"^--fault is not for a recording"),
        ({"vehicle": "replay:{log}", "clock": "real"}, r"^--clock real is not for a recording"),
    ],
)
def test_what_cannot_be_is_one_line(recorded: tuple[Path, Path], options: dict[str, object], says: str) -> None:
    path, log = recorded
    options["vehicle"] = str(options["vehicle"]).format(log=log)
    with pytest.raises(StageError, match=says):
        run(path, stage="rw", ads=OneTrick(coast), **options)  # type: ignore[arg-type]


def test_a_bag_that_another_program_wrote_is_played_with_its_own_sensors(scenario: Write, tmp_path: Path) -> None:
    """rosbags writes it: 10 m/s along x, a LiDAR return 20 m ahead, the bag 1.5 s ahead; once without a fix."""
    pytest.importorskip("cyclonedds")
    writer = pytest.importorskip("rosbags.rosbag2").Writer
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    from vehicle.messages import GnssFix, Odometry, VehicleState
    from vehicle.wire import convert, topics
    from vehicle.wire.definitions import DEFINITIONS

    store = get_typestore(Stores.ROS2_HUMBLE)
    for name, text in DEFINITIONS.items():
        store.register(get_types_from_msg(text, name))
    path = scenario()
    path.with_name("x.gates.toml").write_text(GATES)
    first = run(path, duration=0.1, ads=OneTrick(coast)).log
    x0, y0, begin = float(first["x"][0]), float(first["y"][0]), 70.0

    def types(topic: topics.Topic) -> str:
        package, _, _, kind = str(topic.type.__idl_typename__).split("::")
        return f"{package}/msg/{kind.removesuffix('_')}"

    with writer(tmp_path / "bag", version=9) as bag:
        channels = {
            t: bag.add_connection(t.name, types(t), typestore=store)
            for t in (topics.ODOMETRY, topics.FEEDBACK, topics.FIX, topics.POINTS, topics.COMMAND)
        }

        def put(topic: topics.Topic, t: float, late: float, message: object) -> None:
            bag.write(channels[topic], round((t + late + 1.5) * 1e9), message.serialize())  # type: ignore[attr-defined]

        for k in range(101):
            t = begin + 0.01 * k
            ns, x = round(t * 1e9), x0 + 0.1 * k
            put(topics.ODOMETRY, t, 0.0, convert.state_to_ros(VehicleState(t, x, y0, 0.0, 10.0, vx=10.0), ns))
            if k % 10 == 0:
                put(topics.FEEDBACK, t, 0.0, convert.feedback_to_ros(Odometry(t, 10.0, 0.0), ns))
                place, _ = convert.fix_to_ros(GnssFix(t, x, y0, 0.5), ns)
                place.status.status = -1 if k == 50 else 0  # sensor_msgs/NavSatStatus: no fix, a fix
                put(topics.FIX, t, 0.01, place)
                put(topics.POINTS, t, 0.05, convert.points_to_ros(np.array([[20.0, 0.0, 0.0]]), ns))
                put(topics.COMMAND, t, 0.0, convert.command_to_ros(coast(Observation(t)), ns))

    stack = OneTrick(coast)
    result = run(path, stage="rw", vehicle=f"replay:{tmp_path / 'bag'}", ads=stack)
    assert result.error is None
    assert result.log.duration == pytest.approx(1.0)
    fixes = [fix for one in stack.seen for fix in one.gnss]
    assert [fix.sigma for fix in fixes] == [pytest.approx(0.5)] * 9  # the last comes 10 ms after the end
    assert [round(10.0 * fix.t) for fix in fixes] == [0, 1, 2, 3, 4, 6, 7, 8, 9]  # at 0.5 s there was no fix
    scans = [(one.t, one.lidar) for one in stack.seen if one.lidar is not None]
    assert [(pytest.approx(t), s.t) for t, s in scans[:2]] == [(0.05, pytest.approx(0.0)), (0.15, pytest.approx(0.1))]
    assert scans[0][1].points.tolist() == [[20.0, 0.0, 0.0]]
    assert measure(result.log)["replay_accel_error"].value == 0.0
