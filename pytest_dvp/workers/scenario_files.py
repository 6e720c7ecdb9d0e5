"""Files below a folder that a run of a scenario in it can open: a scenario reaches nothing else."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from pathlib import Path

KINDS = (".xosc", ".xodr", ".xml", ".toml", ".csv")
LEFT: tuple[str, ...] = ("__pycache__", "site-packages", "node_modules", "runs")
CAMPAIGN = "campaign.sqlite"
"""What tells the folder of a campaign, as `campaigns/store.py` names it: what lies below was written by drives."""
WRITTEN = ("reproducers", "regression", "logs")
"""Folders that a campaign writes, where its folder is that of the scenario as well."""


def reachable(folder: str | Path, kinds: Sequence[str] = KINDS) -> Iterator[tuple[str, Path]]:
    """Name below `folder`, with slashes, and path of each of these kinds, sorted folder by folder; hidden folders,
    those of LEFT, those of campaigns and links that lead out of `folder` are left out."""
    inside = os.path.join(os.path.realpath(folder), "")
    for place, folders, names in os.walk(folder):
        left = LEFT
        if CAMPAIGN in names:
            if place != str(folder):
                folders.clear()
                continue
            left = (*LEFT, *WRITTEN)
        folders[:] = sorted(name for name in folders if name not in left and not name.startswith("."))
        for name in sorted(names):
            file = Path(place, name)
            if file.suffix not in kinds or not file.is_file():
                continue
            if not file.is_symlink() or os.path.realpath(file).startswith(inside):
                yield file.relative_to(folder).as_posix(), file
