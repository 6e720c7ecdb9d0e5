"""How sure it is that one set of effects has less error than another: segments drawn anew, with replacement."""

from __future__ import annotations

import numpy as np

from pytest_dvp.logs.log_contents import FloatArray

_DRAWS = 400  # a share of 0.95 is then known to 1 %
_SEED = 7  # any; fixed, so that the same logs give the same answer


def bootstrap_share(worse: FloatArray, better: FloatArray, *, slack: float = 0.0) -> float:
    """Share of draws of segments, 0 to 1, in which `better` has less error than `worse`.

    Both (m,) hold chi^2 by segment, in units of the squared noise. A draw also counts in which it is worse by less than
    `slack` of what it gains in all: draws without the one event in which an effect shows say nothing against it.
    """
    rng = np.random.default_rng(_SEED)
    m = len(worse)
    draws = rng.multinomial(m, np.full(m, 1.0 / m), size=_DRAWS)
    gain = worse - better
    return float(np.mean(draws @ gain > -slack * max(float(gain.sum()), 0.0)))
