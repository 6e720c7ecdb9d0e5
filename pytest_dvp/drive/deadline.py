"""A deadline on calls of a stack that runs in the harness's own process: its Python code is interrupted.

In the main thread a signal interrupts what waits, too (a sleep, a socket, a lock). In another thread only Python code
is interrupted, between two of its instructions. C code that never comes back is out of reach here: a stack that is
given by name runs in a process of its own, which is ended (`pytest_dvp.drive.stack_process`).
"""

from __future__ import annotations

import contextlib
import ctypes
import signal
import sys
import threading
import time
import traceback
from types import FrameType, TracebackType

from pytest_dvp.drive.compile_time import COMPILING
from pytest_dvp.drive.stack_faults import StackHung, hung

FIRST = 6.0  # times the limit: what a first tick, an import or a constructor has, as they may load or compile
TICK_LIMIT = 10.0  # s of wall time; 200 times the cycle, so that a machine under load ends no healthy stack
AGAIN = 0.2  # s until a stack that catches the interruption is interrupted again
_NEVER = float("inf")
_LONG = 3600.0  # s; the system does not wait for more than some centuries
_SIGNAL = getattr(signal, "SIGURG", None)  # does nothing unless somebody asks for it


class _Interrupted(BaseException):
    """Raised in the stack's code; no Exception, so that `except Exception` there does not swallow it."""


class Deadline:
    """Interrupts what runs `within` it, in the thread that calls it.

    name   of the stack, for messages
    limit  [s] of wall time for a call. Time in which numba compiles does not count. `math.inf` for none, neither that
           of the run: a stack in a process of its own watches both itself.
    wall   time (`time.monotonic`) at which the whole run must be over; `wall_limit` how long it had [s]
    """

    def __init__(self, name: str, limit: float = TICK_LIMIT) -> None:
        self.name, self.limit = name, limit
        self.wall, self.wall_limit = _NEVER, _NEVER
        self._thread: threading.Thread | None = None
        self._lock = threading.RLock()  # of the condition; taken without it where nobody waits, which is quicker
        self._changed = threading.Condition(self._lock)
        self._closed = False
        self._until = _NEVER  # of the call that runs now
        self._compiled, self._wakes = 0.0, 0.0
        self._target, self._by_signal = 0, False
        self._old_handler: object = None
        self._late = False
        self._found: list[traceback.FrameSummary] = []  # where it was when its time was over

    def within(self, call: str, *, first: bool = False) -> _Call:
        """A context. Raises StackHung if the code within does not return in time. `call`: what it is, as "tick"."""
        return _Call(self, call, limit_of(self.limit, first=first))

    def begin(self, until: float) -> None:
        """A call begins, which must be over at `until` (`time.monotonic`)."""
        self._late, self._compiled = False, COMPILING.seconds
        self._ensure_watched()
        self._arm(until)

    def end(self) -> bool:
        """It is over; whether its time was over before."""
        self._disarm()
        return self._late

    def fault(self, call: str, limit: float, until: float) -> StackHung:
        """What to raise of a call that had `limit` [s] and was interrupted."""
        wall = self.wall <= until
        return hung(overdue(self.name, call, limit, self.wall_limit if wall else None), self._found, wall=wall)

    def close(self) -> None:
        """End the watch; the signal is what it was before."""
        with self._changed:
            self._closed = True
            self._changed.notify()
        if self._thread is not None:
            self._thread.join()
            self._thread = None
        if self._by_signal and threading.current_thread() is threading.main_thread():
            signal.signal(_SIGNAL, self._old_handler)  # type: ignore[arg-type]
        self._by_signal = False

    def _ensure_watched(self) -> None:
        me = threading.get_ident()
        if self._thread is not None and self._target == me:
            return
        self.close()
        self._target, self._closed = me, False
        if threading.current_thread() is threading.main_thread() and _SIGNAL is not None:
            self._old_handler = signal.getsignal(_SIGNAL)
            if self._old_handler in (signal.SIG_DFL, signal.SIG_IGN):
                signal.signal(_SIGNAL, self._strike)
                self._by_signal = True
        self._thread = threading.Thread(target=self._watch, daemon=True, name="dvp-deadline")
        self._thread.start()

    def _arm(self, until: float) -> None:
        with self._lock:
            self._until = until
            if min(until, self.wall) < self._wakes:
                self._changed.notify()

    def _disarm(self) -> None:
        """The call is over. What was asked for before and has not come yet must not come in the harness."""
        while True:
            try:
                with self._lock:
                    self._until = _NEVER
                break
            except _Interrupted:
                continue
        if self._late and not self._by_signal:
            _raise_in(self._target, nothing=True)

    def _watch(self) -> None:
        """Wakes when a deadline may have passed, and not for each tick: a run in real time is not disturbed."""
        with self._changed:
            while not self._closed:
                now = time.monotonic()
                if self._until == _NEVER:
                    wait = min(self.limit, _LONG)
                else:
                    wait = min(self._until + COMPILING.seconds - self._compiled, self.wall, now + _LONG) - now
                if wait <= 0.0:
                    self._interrupt()
                    wait = AGAIN
                self._wakes = now + wait
                self._changed.wait(wait)

    def _interrupt(self) -> None:
        frame = sys._current_frames().get(self._target)
        if frame is None:
            return
        if not self._late:
            self._late = True
            self._found = list(reversed(traceback.StackSummary.extract(traceback.walk_stack(frame))))
        if self._by_signal and _SIGNAL is not None:
            with contextlib.suppress(ProcessLookupError):
                signal.pthread_kill(self._target, _SIGNAL)
        else:
            _raise_in(self._target)

    def _strike(self, number: int, frame: FrameType | None) -> None:
        """In the main thread: too late for a call that has returned meanwhile. Here, no code of the stack is
        interrupted: `end` says that it was late."""
        here = frame is not None and frame.f_globals is globals()
        if self._until != _NEVER and self._late and not here:
            raise _Interrupted


class _Call:
    """One call within a deadline. A class, because a generator costs half as much again as the rest of a tick's
    watch."""

    __slots__ = ("_call", "_deadline", "_limit", "_until")

    def __init__(self, deadline: Deadline, call: str, limit: float) -> None:
        self._deadline, self._call, self._limit = deadline, call, limit
        self._until: float | None = None  # nobody watches

    def __enter__(self) -> None:
        deadline, limit = self._deadline, self._limit
        if limit == deadline.wall == _NEVER:
            return
        self._until = time.monotonic() + limit
        try:
            deadline.begin(self._until)
        except BaseException as error:  # the interruption may come at once
            self.__exit__(type(error), error, None)
            raise

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None) -> None:
        if self._until is None:
            return
        # Whatever the stack made of the interruption, its time was over.
        if self._deadline.end() and not isinstance(error, KeyboardInterrupt):
            raise self._deadline.fault(self._call, self._limit, self._until) from None


def limit_of(limit: float, *, first: bool) -> float:
    """Wall time [s] that a call has; `first`: the first tick, a constructor, an import."""
    return FIRST * limit if first else limit


def overdue(name: str, call: str, limit: float, wall_limit: float | None) -> str:
    """The line that says so. `wall_limit` [s], if it is that of the run that is over."""
    if wall_limit is not None:
        return f"ADS {name}: {call} did not return before the wall limit of {wall_limit:g} s ended the run"
    return f"ADS {name}: {call} did not return within {limit:g} s (--tick-limit)"


def _raise_in(thread: int, *, nothing: bool = False) -> None:
    """Let a thread raise `_Interrupted` at its next instruction, or take that back."""
    what = None if nothing else ctypes.py_object(_Interrupted)
    ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(thread), what)
