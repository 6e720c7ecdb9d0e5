"""Names of signals in gates: a misspelt one is told when the file is read, not after the drive."""

from __future__ import annotations

from typing import NamedTuple

from openscenario.findings import listed, nearest
from pytest_dvp.logs.signals import SIGNALS
from pytest_dvp.verdicts.model_gate import CHANNELS, METRICS

OF_MODEL = tuple(METRICS.values())  # metrics that compare a model's answer
TRACK = ("x", "y", "yaw", "vx", "vy")  # of object.NAME.
SEEN = ("objects.x", "objects.y")
_COLUMNS = ("response_lag", "response_gain", "repeated_commands", "steer_roughness", "accel_roughness")
_TWO_LOGS = ("mncc", "bias", "lag", "gain")


class Wrong(NamedTuple):
    """What is wrong with a name: for Finding."""

    text: str
    allowed: str
    hint: str


def wrong_signal(metric: str, name: object) -> Wrong | None:
    """Why `name` is no signal for one of our metrics; None if it may be one, or the metric is another package's.

    What a driving stack logs of itself (`ads.`) only the log knows.
    """
    if metric in (*OF_MODEL, "twin_error", "twin_chi2", "twin_gain"):
        known = (*CHANNELS, *(("position",) if metric == "twin_error" else ()))
    elif metric in (*_COLUMNS, *_TWO_LOGS):
        known = (*SIGNALS, *(SEEN if metric in _TWO_LOGS else ()))
    else:
        return None
    if not isinstance(name, str):
        return Wrong(f"the signal is {str(name)[:40]!r}", "a name in quotes", "")
    if name in known or (metric not in OF_MODEL and name.startswith("ads.")):
        return None
    if metric in _TWO_LOGS and name.startswith("object."):
        who, _, what = name.removeprefix("object.").rpartition(".")
        good = who and what in TRACK
        return None if good else Wrong(f"unknown signal {name[:80]!r}", "object.NAME." + ", ".join(TRACK), "")
    hint = nearest(name, known)
    return Wrong(f"unknown signal {name[:80]!r}", "" if hint else listed(known), hint)
