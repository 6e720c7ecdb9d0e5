"""A process of this machine that serves a run: heard of when it dies or is stopped, gone when it is not needed."""

from __future__ import annotations

import contextlib
import errno
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import IO

TIED = Path(__file__).with_name("end_with_parent.py")


def own_module(name: str) -> list[str]:
    """The command that runs a module of ours in a process of its own; together with `own_path`.

    Not `python -m` alone: that puts the current folder first, where a project may have a package of the same name.
    """
    here = __name__.removesuffix("vehicle.child_process")  # what stands before the names of all our packages
    return [sys.executable, "-P", "-m", name if name.startswith("pytest_dvp.") else here + name]


def own_path() -> dict[str, str]:
    """The environment in which a process finds the modules that this one found."""
    return {"PYTHONPATH": os.pathsep.join(sys.path)}


class Child:
    """`command`, started now. `who` it is ("the car") and the kind of error that says what became of it.

    It leads a process group of its own and is killed with it; its standard input is a pipe from here, so that it can
    end by itself when this process does, and if it is stopped and cannot, the kernel ends it (Linux; then it also ends
    with the thread that started it, so who starts it must stay). `keep_open` are file descriptors that it gets.
    `streams` are where its standard output and error go; its standard input then is empty, and it hears of the end of
    this process elsewhere. Raises that error if it cannot be started.
    """

    def __init__(
        self,
        command: Sequence[str],
        who: str,
        error: Callable[[str], Exception],
        environment: Mapping[str, str] | None = None,
        keep_open: Sequence[int] = (),
        streams: tuple[int, int] | None = None,
    ) -> None:
        self._who, self._error = who, error
        if shutil.which(command[0]) is None:
            raise error(f"{who}'s process cannot be started: {command[0]}: {os.strerror(errno.ENOENT)}")
        self._errors: IO[bytes] = tempfile.TemporaryFile()  # noqa: SIM115  (lives as long as the child)
        try:
            self.process = subprocess.Popen(
                [sys.executable, "-I", "-S", str(TIED), str(os.getpid()), *command],
                pass_fds=keep_open,
                stdin=subprocess.PIPE if streams is None else subprocess.DEVNULL,
                stdout=subprocess.DEVNULL if streams is None else streams[0],
                stderr=self._errors if streams is None else streams[1],
                start_new_session=True,
                env=None if environment is None else {**os.environ, **environment},
            )
        except OSError as failed:
            self._errors.close()
            raise error(f"{who}'s process cannot be started: {failed.strerror}") from None

    def check(self) -> None:
        """Raises the error if it has ended or is stopped."""
        how = self.how_it_ended()
        if not how:
            if is_stopped(self.process.pid):
                raise self._error(f"{self._who}'s process is stopped (SIGSTOP)")
            return
        self._errors.seek(0)
        said = self._errors.read().decode(errors="replace").strip().splitlines()
        raise self._error(f"{self._who}'s process ended ({how})" + (f": {said[-1][:200]}" if said else ""))

    def how_it_ended(self) -> str:
        """`exit code 1` or `killed by SIGSEGV`; "" while it runs."""
        code = self.process.poll()
        if code is None:
            return ""
        return f"killed by {signal.Signals(-code).name}" if code < 0 else f"exit code {code}"

    def end(self, *, after: float = 0.0) -> None:
        """Kill it and all it has started, `after` [s] that it has to end by itself. May be called again."""
        if self.process.stdin is not None and not self.process.stdin.closed:
            with contextlib.suppress(OSError):
                self.process.stdin.close()
        if after and not is_stopped(self.process.pid):
            with contextlib.suppress(subprocess.TimeoutExpired):
                self.process.wait(after)
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self.process.pid, signal.SIGKILL)
        self.process.wait()
        self._errors.close()


def is_stopped(pid: int) -> bool:
    """Whether a process is stopped by a signal; where the system does not tell (it does on Linux), no."""
    try:
        state = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8", errors="replace").rpartition(")")[2]
    except OSError:
        return False
    return state.split()[:1] == ["T"]
