"""What the report's tests share."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from synthetic_run import synthetic_run


@pytest.fixture
def make_run() -> Callable[..., dict[str, Any]]:
    """Makes keyword arguments of write_run_report: `make_run(status="PASS", name="pedestrian_crossing")`."""
    return synthetic_run
