"""What is left of a run that was ended before its log was written, and which command reads it; how a disk fails."""

from __future__ import annotations

import errno
from pathlib import Path

FULL = (errno.ENOSPC, errno.EDQUOT, errno.EIO)
"""What a disk says that nobody could have known before: full, quota used up, broken."""

LOG = "log.mcap"
PART = "log.mcap.part"  # of the run's folder, while it drives: `pytest_dvp.logs.partial_log`


def told_of(place: Path) -> str:
    """Of a run folder without a log, the log that is missing there, or the part itself: one line that says what to do.

    "" if no run was ended there.
    """
    part = place if place.name == PART else (place if place.is_dir() else place.parent) / PART
    missing = place.is_dir() or place.name in (LOG, PART)
    if not missing or not part.is_file() or (place.is_dir() and (place / LOG).is_file()):
        return ""
    folder = place if place.is_dir() else place.parent
    return (
        f"{place}: the run is under way, or was ended before its log was written; "
        f"what there is of it: dvp recover {folder} --out FILE.mcap"
    )
