"""A bridge: modules of another interpreter, used over a socket; found out at once when it dies or hangs."""

from __future__ import annotations

import ast
import math
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.waiting import is_gone, wait_until
from vehicle import child_process
from vehicle import interpreter_bridge as bridge_module
from vehicle.adapter import VehicleLost
from vehicle.interpreter_bridge import SERVER, SILENT, Bridge

OLD = [*(f"python3.{minor}" for minor in range(6, 11)), "/usr/bin/python3"]


@pytest.fixture
def bridge() -> Iterator[Bridge]:
    opened = Bridge(who="the bridge", error=VehicleLost)
    yield opened
    opened.close()


def old_interpreters() -> list[str]:
    """Interpreters of other versions that are here: those on the path, and pyenv's."""
    found = [found for name in OLD if (found := shutil.which(name)) and "shims" not in found]
    found += [str(each) for each in sorted(Path.home().glob(".pyenv/versions/3.[6-9].*/bin/python"))]
    return found


def test_the_far_end_is_python_3_6_and_needs_nothing_but_its_library() -> None:
    tree = ast.parse(SERVER.read_text(encoding="utf-8"), feature_version=(3, 6))
    needed = {
        name.split(".")[0]
        for node in ast.walk(tree)
        for name in (
            [each.name for each in node.names]
            if isinstance(node, ast.Import)
            else [node.module or ""]
            if isinstance(node, ast.ImportFrom)
            else []
        )
    }
    assert needed - sys.stdlib_module_names == {"rospy", "rosgraph"}


def test_old_interpreters_serve_it() -> None:
    """Those that this machine has, from 3.6 on."""
    found = old_interpreters()
    if not found:
        pytest.skip("no other interpreter is here: python3.6 to python3.10 on the path")
    for python in found:
        opened = Bridge(python, who="the bridge", error=VehicleLost)
        try:
            assert opened.module("math").hypot(3.0, 4.0) == 5.0
            there = opened.module("os").getpid()
            assert there == opened.pid != os.getpid()
        finally:
            opened.close()


def test_objects_stay_there_and_are_used_from_here(bridge: Bridge) -> None:
    fractions = bridge.module("fractions")
    third = fractions.Fraction(1, 3)
    assert (third.numerator, third.limit_denominator(2).denominator) == (1, 2)
    place = bridge.module("types").SimpleNamespace(x=1.5, near=[third, "s"])
    place.y = third
    assert (place.x, place.y.denominator, place.near[1]) == (1.5, 3, "s")
    assert [each.denominator for each in bridge.module("itertools").repeat(third, 2)] == [3, 3]


def test_what_is_raised_there_is_raised_here(bridge: Bridge) -> None:
    maths = bridge.module("math")
    with pytest.raises(ValueError, match="math domain error"):
        maths.sqrt(-1.0)
    with pytest.raises(AttributeError, match="no attribute 'sqroot'"):
        _ = maths.sqroot
    with pytest.raises(VehicleLost, match=r"^the bridge: .*python\S* lacks a module: No module named 'no_such'$"):
        bridge.module("no_such")
    assert maths.pi == math.pi  # and goes on


def test_an_interpreter_that_is_not_there_is_one_line() -> None:
    with pytest.raises(VehicleLost, match=r"^the bridge's process cannot be started: /no/python3: No such file"):
        Bridge("/no/python3", who="the bridge", error=VehicleLost)


@pytest.mark.parametrize(
    ("how", "says"),
    [
        (signal.SIGKILL, r"^the bridge's process ended \(killed by SIGKILL\)$"),
        (signal.SIGSTOP, r"^the bridge's process is stopped \(SIGSTOP\)$"),
    ],
)
def test_one_that_dies_or_is_stopped_is_known_at_once(bridge: Bridge, how: signal.Signals, says: str) -> None:
    os.kill(bridge.pid, how)
    with pytest.raises(VehicleLost, match=says):
        bridge.receive(60.0)


def test_one_that_hangs_is_known_by_its_beats(bridge: Bridge, monkeypatch: pytest.MonkeyPatch) -> None:
    """Stopped, and not seen to be: for as long as beats may stay away nothing is said, then that it hangs."""
    monkeypatch.setattr(child_process, "is_stopped", lambda pid: False)
    clock = [0.0]
    os.kill(bridge.pid, signal.SIGSTOP)
    while child_process.Path(f"/proc/{bridge.pid}/stat").read_text().rpartition(")")[2].split()[0] != "T":
        os.sched_yield()
    bridge.receive(0.0)  # beats of before
    real = bridge_module.select.select

    def waits(*arguments: object) -> object:
        came = real(*arguments[:3], 0.0)  # type: ignore[call-overload]
        clock[0] += float(arguments[3])  # type: ignore[arg-type]
        return came

    monkeypatch.setattr(bridge_module.select, "select", waits)
    monkeypatch.setattr(time, "monotonic", lambda: clock[0])
    assert bridge.receive(0.9 * SILENT) == []
    with pytest.raises(VehicleLost, match=r"^the bridge hangs: no beat for 2\.0\d s$"):
        bridge.receive(60.0)
    monkeypatch.undo()


def test_beats_that_nobody_listened_for_are_not_missed(bridge: Bridge, monkeypatch: pytest.MonkeyPatch) -> None:
    """Only time spent listening counts: a harness that computes for a minute does not lose its bridge."""
    assert bridge.module("math").pi == math.pi
    real = time.monotonic
    monkeypatch.setattr(time, "monotonic", lambda: real() + 60.0)
    assert bridge.module("math").pi == math.pi


def test_it_ends_with_the_process_that_started_it() -> None:
    started = (
        "from vehicle.interpreter_bridge import Bridge; import os, sys\n"
        "b = Bridge(who='the bridge', error=ValueError); print(b.pid); sys.stdout.flush(); os.kill(os.getpid(), 9)"
    )
    parent = subprocess.run([sys.executable, "-c", started], stdout=subprocess.PIPE, text=True, timeout=60, check=False)
    pid = int(parent.stdout)
    try:
        wait_until(lambda: is_gone(pid), f"process {pid} is still there")
    finally:
        if not is_gone(pid):
            os.kill(pid, signal.SIGKILL)
