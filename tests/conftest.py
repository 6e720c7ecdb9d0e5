"""Fixtures that all tests share."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

pytest_plugins = ["pytester"]

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="session")
def shared_dir() -> Path:
    """Folder of reference material beside the checkout; the product never depends on it."""
    folder = Path(os.environ.get("DVP_SHARED", ROOT.parent / "shared"))
    if not folder.is_dir():
        pytest.skip(f"no reference material at {folder} (set DVP_SHARED)")
    return folder


@pytest.fixture(scope="session")
def scenarios_dir() -> Path:
    """The scenarios that ship with the product."""
    return ROOT / "scenarios"
