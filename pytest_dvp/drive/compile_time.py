"""How long numba has been compiling or loading compiled code in this process: no part of what a stack computes.

It happens once, when a function meets a kind of argument for the first time, which may be in any tick; on a car it is
done before the drive.
"""

from __future__ import annotations

import contextlib
import sys
import threading
import time
from collections.abc import Callable, Iterator


class Compiling:
    """Counts the seconds. `tell(True)` is called where compiling begins in the main thread, `tell(False)` at its end.

    It follows the events of numba's compiler lock (`numba.core.event`), which is held while a function is compiled or
    read from the cache. Nothing is counted before `attach` finds numba loaded.
    """

    def __init__(self) -> None:
        self.tell: Callable[[bool], None] | None = None
        self._seconds, self._since, self._depth, self._attached = 0.0, 0.0, 0, False

    def attach(self) -> None:
        """Listen, as soon as numba is there. May be called at any time."""
        if self._attached or "numba.core.event" not in sys.modules:
            return
        from numba.core import event

        outer = self

        class Listener(event.Listener):
            def on_start(self, event: object) -> None:
                outer._begin()

            def on_end(self, event: object) -> None:
                outer._end()

        event.register("numba:compiler_lock", Listener())
        self._attached = True

    @contextlib.contextmanager
    def apart(self) -> Iterator[None]:
        """What is done within is no part of what a stack computes either."""
        self._begin()
        try:
            yield
        finally:
            self._end()

    @property
    def seconds(self) -> float:
        """Wall time so far [s], in all threads together but counted once."""
        return self._seconds + (time.perf_counter() - self._since if self._depth else 0.0)

    def _begin(self) -> None:
        self._depth += 1
        if self._depth == 1:
            self._since = time.perf_counter()
            self._say(True)

    def _end(self) -> None:
        self._depth -= 1
        if self._depth == 0:
            self._seconds += time.perf_counter() - self._since
            self._say(False)

    def _say(self, begins: bool) -> None:
        if self.tell is not None and threading.current_thread() is threading.main_thread():
            self.tell(begins)


COMPILING = Compiling()
"""Of this process."""
