"""Any driving stack in a process of its own, over ROS 2 messages.

    python -m pytest_dvp.drive.stack_server --dds 42 --ads NAME

A new run is a message, not a new process: the stack is made anew. What it does wrong ends the process, with one line.
"""

from __future__ import annotations

import argparse
import functools
import json
import math
import os
import sys
import threading
from pathlib import Path
from typing import Any

import msgspec

from pytest_dvp.drive.stack_faults import AdsFault, StackRaised, one_line
from pytest_dvp.drive.stack_host import find_ads, make_driver
from pytest_dvp.drive.stack_parameters import received
from pytest_dvp.text.errors import SettingError
from pytest_dvp.text.names import REFERENCE
from vehicle.messages import VehicleDescription, brake_first

IDLE = 3600.0  # s without a word after which it gives up


def main(argv: list[str] | None = None) -> int:
    """Returns the exit code: 0 served, 1 the stack broke, 2 there is no such stack."""
    parser = argparse.ArgumentParser(
        prog="python -m pytest_dvp.drive.stack_server", description=(__doc__ or "").split("\n")[0]
    )
    parser.add_argument("--dds", type=int, required=True, metavar="DOMAIN")
    parser.add_argument("--ads", default=REFERENCE, metavar="NAME", help="as of dvp run; default: the reference stack")
    arguments = parser.parse_args(argv)
    _end_with_parent()
    try:
        ads = find_ads(arguments.ads, [Path.cwd()], process="off", tick_limit=math.inf)
        _serve(arguments.dds, ads)
    except SettingError as error:
        print(error, file=sys.stderr)
        return 2
    except AdsFault as error:
        print(error, file=sys.stderr)
        return 1
    return 0


def _serve(domain: int, ads: Any) -> None:
    from vehicle.wire import convert, topics
    from vehicle.wire import stack_topics as wire
    from vehicle.wire.dds import on_domain
    from vehicle.wire.end import End, Silence
    from vehicle.wire.geodetic import DEFAULT_ORIGIN, Origin
    from vehicle.wire.ros2_types import String

    end = End(on_domain(domain), wire.FROM_STACK, wire.TO_STACK, (wire.DONE, wire.STEP), lambda: None)
    driver: Any = None
    origin = DEFAULT_ORIGIN
    path: Any = None
    deceleration = 0.0
    while True:
        try:
            number, now = end.next_step(IDLE)
        except Silence:
            return
        if number == 0:  # a call to see whether somebody is there: answered once every topic is
            if end.matched():
                end.step(0, now)
            continue
        resets = end.take(wire.RESET)
        observation = wire.take_observation(end, now, origin)
        if resets:
            run = json.loads(resets[-1].data)
            origin = msgspec.convert(run["origin"], Origin)
            car = msgspec.convert(run["vehicle"], VehicleDescription)
            driver, path, deceleration = _made(ads, run, car), None, car.max_deceleration
        elif driver is not None:
            try:
                command = driver.tick(observation)
            except AdsFault:
                raise
            except StackRaised as error:
                raise AdsFault(f"ADS {ads.name}: {one_line(error.__cause__ or error)}") from error
            new = driver.path if driver.path is not path else None
            path = driver.path
            state = wire.State(dict(driver.trace), list(driver.detections), None if new is None else new.tolist())
            command = brake_first(command, deceleration)  # the message has no pedals
            end.send(topics.COMMAND, convert.command_to_ros(command, now))
            end.send(wire.STATE, String(msgspec.json.encode(state).decode()))
        end.step(number, now)


def _made(ads: Any, run: dict[str, Any], car: VehicleDescription) -> Any:
    parameters = received(ads, run["parameters"])
    return make_driver(ads, parameters, _map(run["map"], Path(run["map"]).stat().st_mtime_ns), car)


@functools.lru_cache(maxsize=4)
def _map(path: str, changed: int) -> Any:
    """A map, read anew when the file has changed: runs in a row are on the same one."""
    from openscenario.road.network import load_network

    return load_network(path)


def _end_with_parent() -> None:
    """Leave at once when standard input closes."""

    def watch() -> None:
        while os.read(sys.stdin.fileno(), 1):  # not through a buffer, whose lock would abort an ordinary end
            pass
        os._exit(0)

    threading.Thread(target=watch, daemon=True).start()


if __name__ == "__main__":
    raise SystemExit(main())
