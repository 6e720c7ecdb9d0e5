"""The stack that a command drives, as its first line names it."""

from __future__ import annotations

from pathlib import Path

from pytest_dvp.drive.run_spec import RunSpec
from pytest_dvp.text.paths import shown


def named_stack(settings: RunSpec) -> str:
    """`ADS stacks/mine.py:Stack (pytest.ini: dvp_ads)`: the stack, and who names it if the command line does not."""
    file, colon, name = settings.ads.rpartition(":")
    ads = f"{shown(Path(file))}:{name}" if colon and file.endswith(".py") else settings.ads
    origin = settings.origins.get("ads", "--ads")
    return f"ADS {ads}" if origin.startswith("--") else f"ADS {ads} ({origin})"
