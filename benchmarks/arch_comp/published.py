"""What one tool of the competition published of these problems, where its own record could be read.

zlscheck's records of ARCH-COMP 2020: ismailbennani/zlscheck_arch20_counterexamples, commit 1fc46751, the file `info` in
each folder of bench_results (at_inst2 and cc): 50 searches of at most 300 simulations. zlscheck knows the equations and
follows their gradient. Its brake goes up to 350, its inputs of AT1 and AT2 end with the requirement, and its models
are stepped by Euler's rule. The medians in these files are left out: that of CC5, 3 beside a mean of 2.02, is hardly
one of 50 whole numbers from 1 on.
"""

from __future__ import annotations

import dataclasses


@dataclasses.dataclass(frozen=True)
class Published:
    """Searches that falsified, of 50, and the mean of their simulations."""

    found: int
    mean: float


ZLSCHECK = {
    "AT1": Published(50, 2.26),
    "AT2": Published(50, 9.22),
    "AT51": Published(50, 8.72),
    "AT52": Published(50, 35.08),
    "AT53": Published(50, 22.7),
    "AT54": Published(47, 56.30),
    "AT6a": Published(50, 42.86),
    "AT6b": Published(8, 129.5),
    "AT6c": Published(3, 261.67),
    "CC1": Published(50, 8.82),
    "CC2": Published(50, 4.70),
    "CC3": Published(50, 23.38),
    "CC4": Published(32, 124.59),
    "CC5": Published(50, 2.02),
}
SEARCHES = 50
