"""A car of `make paper` that nobody chose: what is hidden in it, and by how much, a seed draws.

python -m scripts.mcrpg_new_car SEED      hexadecimal; writes scenarios/mcrpg/cars/drawn.toml

One effect of the steering, one of the drive or the brake, and one of the chassis or the road, none of which the chosen
cars have; sizes are uniform between what matters to a driving stack and what is gross.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence

import numpy as np

from scenarios import path as shipped

GROUPS: tuple[tuple[tuple[str, str, float, float], ...], ...] = (
    (
        ("steer_offset", "offset", 0.005, 0.02),
        ("steer_backlash", "half_width", 0.005, 0.02),
        ("steer_rate_limit", "limit", 0.2, 0.4),
        ("steer_compliance", "c", 0.003, 0.01),
    ),
    (
        ("drive_delay", "T", 0.1, 0.3),
        ("drive_gain", "g", 0.75, 0.92),
        ("brake_gain", "g", 0.75, 0.92),
        ("jerk_limit", "limit", 0.8, 2.0),
    ),
    (
        ("rolling_resistance", "c", 0.15, 0.3),
        ("aero_drag", "k", 0.004, 0.015),
        ("road_grade", "slope", 0.01, 0.03),
        ("tyre_relaxation", "length", 0.4, 1.2),
        ("yaw_inertia", "ratio", 1.3, 2.0),
    ),
)
"""Effect, key, least and greatest value, in the unit of the surrogate's own table (vehicle/surrogate/hidden.py)."""


def drawn(seed: int) -> str:
    """The text of the file of hidden effects; same seed, same car."""
    rng = np.random.default_rng([seed, 22])
    lines = [f"# Drawn by `python -m scripts.mcrpg_new_car {seed:x}`."]
    for group in GROUPS:
        effect, key, low, high = group[int(rng.integers(len(group)))]
        lines += [f"[hidden.{effect}]", f"{key} = {float(rng.uniform(low, high)):.4g}"]
    return "\n".join(lines) + "\n"


def main(argv: Sequence[str]) -> int:
    """Returns the exit code: 0, 2 without a seed."""
    if len(argv) != 1:
        print((__doc__ or "").strip(), file=sys.stderr)
        return 2
    (shipped("mcrpg/paper.toml").parent / "cars" / "drawn.toml").write_text(drawn(int(argv[0], 16)), encoding="utf-8")
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
