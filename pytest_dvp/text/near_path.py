"""What to say of a path that leads nowhere: where it was looked for, and the nearest name that is there."""

from __future__ import annotations

import re
from pathlib import Path

from pytest_dvp.text.paths import shown
from pytest_dvp.text.spelling import nearest


def looked_for(path: Path, table: str = "") -> str:
    """`; looked in /home/me/scenarios; did you mean 'scenarios/overtaking.xosc'?` for a path that is not there.

    table: of a TOML file a table that a file must have to be meant, such as "gate": gate files and models end alike.
    """
    there, rest = _as_far_as_it_leads(path.absolute())
    where = f"looked in {there}" if len(rest) == 1 else f"no folder {there / rest[0]}"
    meant = _meant(there, rest, table)
    return f"; {where}" + ("" if meant is None else f"; did you mean {str(shown(meant))!r}?")


def _as_far_as_it_leads(path: Path) -> tuple[Path, tuple[str, ...]]:
    """The last folder on the way to a path, and the names after it, one at least."""
    there = path.parent
    while not there.is_dir() and there != there.parent:
        there = there.parent
    return there, path.relative_to(there).parts


def _meant(there: Path, rest: tuple[str, ...], table: str) -> Path | None:
    """The nearest of what is in a folder; for a file one of its kind, or one of its name in a folder below."""
    name, ending = rest[0], Path(rest[0]).suffix.lower()
    try:
        entries = sorted(there.iterdir())
    except OSError:  # a folder that may not be read
        return None
    folders = [entry for entry in entries if entry.is_dir()]
    if len(rest) > 1:
        near = nearest(name, (folder.name for folder in folders))
        if near is None:
            return None
        whole = there.joinpath(near, *rest[1:])
        return whole if whole.exists() else _meant(there / near, rest[1:], table)
    of_its_kind = [entry.name for entry in entries if entry.suffix.lower() == ending and _has(entry, table)]
    near = nearest(name, [known for known in of_its_kind if known != name])
    if near is not None:
        return there / near
    return next((folder / name for folder in folders if (folder / name).is_file()), None)


def _has(file: Path, table: str) -> bool:
    """Whether a file has a table of this name, or none is asked for."""
    if not table:
        return True
    try:
        text = file.read_text(encoding="utf-8", errors="replace")
    except OSError:  # a folder of such a name, or a file that may not be read
        return False
    return re.search(rf"^\s*\[\[?\s*{re.escape(table)}\s*\]", text, re.MULTILINE) is not None
