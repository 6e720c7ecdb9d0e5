"""Which files a scenario may reach: those below its own folder and below folders that the user named, nothing else."""

from __future__ import annotations

import contextlib
import itertools
import os
import re
import stat
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Final
from urllib.parse import unquote

from openscenario.findings import listed, nearest

_SCHEME: Final = re.compile(r"[A-Za-z][A-Za-z0-9+.\-]+:")
_DRIVE: Final = re.compile(r"[A-Za-z]:")
_LONGEST: Final = 4_096
_MOST_NAMES: Final = 10_000  # of one folder
ROAD: Final = ".xodr"
_COPY: Final = "copy the file beside the scenario, or "


class PathError(ValueError):
    """A path may not be opened, or leads nowhere; `code` and `hint` go into the finding."""

    def __init__(self, code: str, text: str, allowed: str = "", hint: str = "") -> None:
        super().__init__(text)
        self.code = code
        self.text = text
        self.allowed = allowed
        self.hint = hint


@dataclass(frozen=True, slots=True)
class Roots:
    """The allowed folders: `base` (the scenario's own, relative paths start there), then the declared ones."""

    base: Path
    folders: tuple[Path, ...]
    real: tuple[Path, ...]

    @classmethod
    def of(cls, base: Path, others: Sequence[Path] = ()) -> Roots:
        """Roots from the scenario's folder and declared folders."""
        folders = tuple(Path(os.path.abspath(folder)) for folder in (base, *others))
        return cls(folders[0], folders, tuple(Path(os.path.realpath(folder)) for folder in folders))

    def find(self, written: str, base: Path, *, folder: bool = False) -> Path:
        """What a path written in a file at `base` leads to, symlinks resolved.

        Raises:
            PathError: a scheme, outside the allowed folders (then the disk is not even asked), missing, not regular.
        """
        place = self.inside(written, base)
        try:
            mode = place.stat().st_mode
        except (OSError, ValueError):
            raise self._missing(place, "folder" if folder else "file") from None
        if not (stat.S_ISDIR(mode) if folder else stat.S_ISREG(mode)):
            what = "folder" if folder else "regular file"
            raise PathError("path.not_a_file", f"not a {what}: {place}", f"the path of a {what}")
        return place

    def find_road(self, written: str) -> Path:
        """What the path of a LogicFile leads to; if to nothing, the file of that name in an allowed folder.

        Scenarios name their roads by the layout of another machine (`Databases/e6mini.xodr`), and those of CARLA by the
        name of the town (`Town04`): then the path, and after it the bare name, are looked for in each allowed folder,
        with the ending `.xodr` if none is written; last the bare name in another letter case.

        Raises:
            PathError: as `find`; it lists the folders where it was looked for, and the nearest name there.
        """
        try:
            return self.find(written, self.base)
        except PathError as error:
            if error.code != "path.not_found":
                raise
            missing = error
        plain = written.replace("\\", "/")
        bare = plain.rpartition("/")[2]
        names = dict.fromkeys((plain, bare))
        if not PurePosixPath(plain).suffix:
            names = dict.fromkeys(each + ending for ending in ("", ROAD) for each in names)
        for folder in self.folders:
            for name in names:
                with contextlib.suppress(PathError):
                    return self.find(name, folder)
        for folder in self.folders:
            for name in _alike(bare, folder):
                with contextlib.suppress(PathError):
                    return self.find(name, folder)
        raise self._nowhere(next(reversed(names)), missing)

    def _nowhere(self, name: str, missing: PathError) -> PathError:
        """The error of a road that none of several folders has."""
        if len(self.folders) == 1:
            return missing
        there: dict[str, Path] = {}
        for folder in self.folders:
            with contextlib.suppress(OSError), os.scandir(folder) as entries:
                ours = (entry.name for entry in itertools.islice(entries, _MOST_NAMES))
                there.update((each, folder) for each in ours if each.endswith(ROAD))
        text = missing.text.partition("; looked in")[0]
        folders = listed([str(folder) for folder in dict.fromkeys(self.folders)], most=6)
        near = nearest(name, there)
        hint = (
            near or f"permit the folder of the road with --library DIR; roads there: {listed(sorted(there)) or 'none'}"
        )
        return PathError(missing.code, f"{text}; nor is {name} in any of {folders}", "", hint)

    def inside(self, written: str, base: Path) -> Path:
        """The path that is meant, below one of the allowed folders, without asking whether it exists.

        Raises PathError for a path that is too long, a URL, or one that leads out of these folders.
        """
        if len(written) > _LONGEST:
            raise PathError("path.too_long", f"longer than {_LONGEST} characters")
        if _SCHEME.match(written):
            raise PathError("path.scheme_forbidden", "a URL is refused", "a path to a local file")
        plain = written.replace("\\", "/")
        if _DRIVE.match(plain):
            raise self._outside()
        once = unquote(plain)
        # a path that climbs only when decoded is meant to climb: refused before anything looks at the disk
        for variant in dict.fromkeys((unquote(once), once, plain)):
            lexical = os.path.normpath(os.path.join(base, variant))
            if not _under(lexical, (*self.folders, *self.real)):
                raise self._outside()
        real = Path(os.path.realpath(lexical))
        if not _under(real, self.real):
            raise self._outside()
        return real

    def _outside(self) -> PathError:
        return PathError(
            "path.outside_root",
            "the path leaves the allowed folders",
            f"below {listed([str(folder) for folder in dict.fromkeys(self.folders)], most=6)}",
            f"{_COPY}permit its folder with --library DIR (dvp_library in the ini file), or put a pytest.ini into the "
            "folder above both",
        )

    def _missing(self, place: Path, what: str) -> PathError:
        """Relative paths start at the file that names them and nowhere else, so there is one folder to look at."""
        advice = f"{_COPY}write the path to it and permit that folder with --library DIR"
        folder = place.parent
        if not _under(folder, self.real):
            return PathError("path.not_found", f"no such {what}: {place}", "", advice)
        try:
            names = sorted(entry.name for entry in os.scandir(folder))
        except OSError:
            return PathError("path.not_found", f"no such {what}: {place}", "", f"no such folder: {folder}; {advice}")
        alike = listed([name for name in names if Path(name).suffix == place.suffix], most=6) or "nothing of this kind"
        near = nearest(place.name, names)
        return PathError(
            "path.not_found",
            f"no such {what}: {place}; looked in {folder} only, there: {alike}",
            "",
            f"{near} else {advice}" if near else advice,
        )


def _alike(name: str, folder: Path) -> list[str]:
    """Names in a folder that differ from a name in the case of letters only: other systems take them for the same."""
    try:
        with os.scandir(folder) as entries:
            names = [entry.name for entry in itertools.islice(entries, _MOST_NAMES)]
    except OSError:
        return []
    return sorted(each for each in names if each.casefold() in (name.casefold(), f"{name}{ROAD}".casefold()))


def _under(path: str | Path, folders: Sequence[Path]) -> bool:
    place = os.path.join(path, "")  # "/a/b/" is below "/a/" and "/a/b/", "/ab/" is not
    return any(place.startswith(os.path.join(folder, "")) for folder in folders)
