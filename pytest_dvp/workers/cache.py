"""Results kept by the hash of what they depend on: a file each, written by rename, never changed."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from pytest_dvp.workers.errors import TuneError
from reports.whole_file import write_whole


class Cache:
    """A folder `ab/abcdef....json`. A kill at any time leaves whole files only."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise TuneError(f"{folder}: cannot be made: {error.strerror or error}") from error

    def get(self, key: str) -> dict[str, Any] | None:
        """What was put under a key; None if nothing was, or if the file is spoilt."""
        try:
            found = json.loads(self._path(key).read_bytes())
        except (OSError, ValueError, RecursionError):
            return None
        return found if isinstance(found, dict) and isinstance(found.get("metrics"), dict) else None

    def put(self, key: str, result: dict[str, Any]) -> None:
        """Keep a result; two processes that put the same key put the same bytes."""
        path = self._path(key)
        path.parent.mkdir(exist_ok=True)
        write_whole(path, json.dumps(result, sort_keys=True, indent=1).encode() + b"\n")

    def _path(self, key: str) -> Path:
        return self.folder / key[:2] / f"{key}.json"
