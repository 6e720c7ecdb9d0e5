"""Whether a model that does not match is diagnosed: a session, or the environment, says."""

from __future__ import annotations

import contextlib
import contextvars
import os
from collections.abc import Iterator

from pytest_dvp.text.flags import is_on

NO_DIAGNOSIS = "DVP_NO_DIAGNOSIS"  # the environment's twin of `--dvp-no-diagnosis`
_DIAGNOSIS: contextvars.ContextVar[bool | None] = contextvars.ContextVar("dvp_diagnosis", default=None)


@contextlib.contextmanager
def diagnosis(wanted: bool) -> Iterator[None]:
    """Within it, a model that does not match is diagnosed or is not: `assert_matches` knows no session to ask."""
    token = _DIAGNOSIS.set(wanted)
    try:
        yield
    finally:
        _DIAGNOSIS.reset(token)


def diagnosis_wanted() -> bool:
    """Whether a model that does not match is to be diagnosed; outside a session the environment says. Raises
    SettingError if it says nonsense."""
    told = _DIAGNOSIS.get()
    if told is not None:
        return told
    raw = os.environ.get(NO_DIAGNOSIS, "").strip()
    return not raw or not is_on(raw, f"environment {NO_DIAGNOSIS}")
