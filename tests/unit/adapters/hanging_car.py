"""The surrogate, hanging in its third step: python -m tests.unit.adapters.hanging_car --dds N asleep|works"""

from __future__ import annotations

import sys
import threading

from vehicle.surrogate.hidden import Hidden
from vehicle.surrogate.node import Node, end_with_parent
from vehicle.wire.dds import on_domain


class Hanging(Node):
    """A lock that nobody frees, or work that never ends."""

    how = ""
    steps = 0

    def _advance(self, until: int) -> None:
        self.steps += 1
        while self.steps > 2 and self.how == "works":
            pass
        if self.steps > 2:
            threading.Lock().acquire() and threading.Event().wait()
        super()._advance(until)


if __name__ == "__main__":
    end_with_parent()
    Hanging.how = sys.argv[3]
    Hanging(on_domain(int(sys.argv[2])), Hidden(), 7).serve()
