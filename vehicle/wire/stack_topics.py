"""Topics of a driving stack in a process of its own: it gets what a car's sensors send, and answers with commands.

harness -> stack                                            stack -> harness
/clock                the time of the tick                  /vehicle/command   steer [rad], accel [m/s^2]
/vehicle/feedback /imu/data /gnss/fix /gnss/heading         /ads/state         for the log, JSON: State
/lidar/points /camera/detections /camera/signals            /ads/done          as /ads/step
/ads/task             what to do, JSON, when it is new
/ads/reset            a new run: parameters, map file, where the map lies, car, JSON
/ads/step             number, time [ns], messages sent so far on each topic
"""

from __future__ import annotations

import msgspec

from vehicle.messages import Detection, GnssFix, Imu, Observation, Task
from vehicle.wire import convert, topics
from vehicle.wire import ros2_types as ros
from vehicle.wire.end import End
from vehicle.wire.geodetic import DEFAULT_ORIGIN, Origin
from vehicle.wire.topics import Topic

RESET = Topic("/ads/reset", ros.String)
TASK = Topic("/ads/task", ros.String)
STEP = Topic("/ads/step", ros.UInt64MultiArray)
STATE = Topic("/ads/state", ros.String)
DONE = Topic("/ads/done", ros.UInt64MultiArray)

TO_STACK: tuple[Topic, ...] = (
    topics.CLOCK, topics.FEEDBACK, topics.IMU, topics.FIX, topics.HEADING, topics.POINTS, topics.CAMERA,
    topics.SEEN_SIGNALS, TASK, RESET,
)  # fmt: skip
FROM_STACK: tuple[Topic, ...] = (topics.COMMAND, STATE)


class State(msgspec.Struct, frozen=True):
    """What a stack may tell of itself: numbers by name, what it sees, and its path (x, y [m]) when that is new."""

    trace: dict[str, float] = {}
    detections: list[Detection] = []
    path: list[tuple[float, float]] | None = None


def send_observation(end: End, seen: Observation, origin: Origin = DEFAULT_ORIGIN) -> None:
    """Put an observation on its topics, each message with the stamp it had; `origin` of the map, for its fixes."""
    end.send(topics.CLOCK, ros.Clock(convert.stamp(_ns(seen.t))))
    for wheels in seen.odometry:
        end.send(topics.FEEDBACK, convert.feedback_to_ros(wheels, _ns(wheels.t)))
    for felt in seen.imu:
        end.send(topics.IMU, convert.imu_to_ros(felt, _ns(felt.t)))
    for fix in seen.gnss:
        place, heading = convert.fix_to_ros(fix, _ns(fix.t), origin)
        end.send(topics.FIX, place)
        if heading is not None:
            end.send(topics.HEADING, heading)
    if seen.lidar is not None:
        end.send(topics.POINTS, convert.points_to_ros(seen.lidar.points, _ns(seen.lidar.t)))
    if seen.camera is not None:
        end.send(topics.CAMERA, convert.camera_to_ros(seen.camera, _ns(seen.camera.t)))
    if seen.signals:
        end.send(topics.SEEN_SIGNALS, convert.signals_to_ros(seen.signals))
    if seen.task is not None:
        end.send(TASK, ros.String(msgspec.json.encode(seen.task).decode()))


def take_observation(end: End, ns: int, origin: Origin = DEFAULT_ORIGIN) -> Observation:
    """The observation of the tick at `ns` [ns], from what has come on the topics; `origin` of the map."""
    end.take(topics.CLOCK)
    headings = {convert.nanoseconds(message.header): message for message in end.take(topics.HEADING)}
    said = [
        convert.fix_from_ros(message, headings.get(convert.nanoseconds(message.header)), origin)
        for message in end.take(topics.FIX)
    ]
    clouds, frames = end.take(topics.POINTS), end.take(topics.CAMERA)
    lights, tasks = end.take(topics.SEEN_SIGNALS), end.take(TASK)
    return Observation(
        ns / convert.SECOND,
        gnss=tuple(fix for fix in said if isinstance(fix, GnssFix)),
        odometry=tuple(map(convert.feedback_from_ros, end.take(topics.FEEDBACK))),
        imu=tuple(felt for felt in map(convert.imu_from_ros, end.take(topics.IMU)) if isinstance(felt, Imu)),
        lidar=convert.points_from_ros(clouds[-1]) if clouds else None,
        camera=convert.camera_from_ros(frames[-1]) if frames else None,
        signals=convert.signals_from_ros(lights[-1]) if lights else (),
        task=msgspec.json.decode(tasks[-1].data, type=Task) if tasks else None,
    )


def _ns(t: float) -> int:
    return round(t * convert.SECOND)
