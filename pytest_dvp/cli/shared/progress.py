"""What a command that takes a while is at, on stderr: a line that changes or, into a file, one every few seconds."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

_EVERY = 5.0  # s between lines where there is no terminal


@contextmanager
def progress(command: str, doing: str, expected: str = "") -> Iterator[Callable[[str], None]]:
    """A function to be told what is done now; `command` begins each line where stderr is no terminal. Each line ends
    with the time since the start and, where `expected` says what CPU it usually takes, that of this process so far."""
    began, cpu = time.monotonic(), time.process_time()

    def timed(text: str) -> str:
        used = f"; {time.process_time() - cpu:.0f} s of CPU, {expected}" if expected else ""
        return f"{text} ({time.monotonic() - began:.0f} s{used})"

    if sys.stderr.isatty():
        from rich.console import Console

        with Console(stderr=True).status(doing) as status:
            yield lambda text: status.update(timed(text))
        return
    last = began

    def tell(text: str) -> None:
        nonlocal last
        now = time.monotonic()
        if now - last >= _EVERY:
            last = now
            print(f"{command}: {timed(text)}", file=sys.stderr, flush=True)

    yield tell
