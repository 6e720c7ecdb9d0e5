"""Files that a job needs, packed for another machine by what they hold, and put down there as they lie here."""

from __future__ import annotations

import dataclasses
import functools
import hashlib
import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from pytest_dvp.workers.errors import TuneError
from pytest_dvp.workers.job import Job, file_digest
from pytest_dvp.workers.scenario_files import reachable

MOST = 64 * 2**20  # bytes of one folder
MOST_FILES = 2000  # chosen, not measured: a folder with more is not that of a scenario alone

Contents = Mapping[str, Any]
"""What travels, plain data: {"name": of the parcel, "root": folder, "files": {name below it: bytes}}."""


@dataclasses.dataclass(frozen=True, slots=True)
class Parcel:
    """Files of one folder. root: absolute; files: name below it and SHA-256 of each, sorted."""

    root: str
    files: tuple[tuple[str, str], ...]

    @property
    def name(self) -> str:
        """Hash of place and contents: 64 hex digits."""
        return hashlib.sha256(repr((self.root, self.files)).encode()).hexdigest()

    def contents(self) -> dict[str, Any]:
        """What travels. Raises TuneError for a file that changes just now."""
        files = {name: (Path(self.root) / name).read_bytes() for name, _ in self.files}
        for name, digest in self.files:
            if hashlib.sha256(files[name]).hexdigest() != digest:
                raise TuneError(f"{self.root}/{name}: it changes while it is read")
        return {"name": self.name, "root": self.root, "files": files}


class Packing:
    """Packs jobs; looks at each folder once."""

    def __init__(self) -> None:
        self._below = functools.cache(_below)

    def parcels(self, job: Job) -> tuple[Parcel, ...]:
        """What a job needs besides what is installed, and a driving stack of a user's own. Raises TuneError."""
        found = [self._below(os.path.abspath(folder)) for folder in _folders(job)]
        for file in map(Path, _files(job)):
            found.append(Parcel(str(file.absolute().parent), ((file.name, file_digest(str(file))),)))
        return tuple(dict.fromkeys(parcel for parcel in found if parcel.files))


def put_down(contents: Sequence[Contents], below: Path) -> Path:
    """The folder, below one of this machine, that is to the files what the root of the file system is where they come
    from: relative paths between them lead as they do there. What lies there already is left."""
    name = hashlib.sha256("".join(sorted(each["name"] for each in contents)).encode()).hexdigest()[:20]
    target = below / name
    if target.is_dir():
        return target
    partial = below / f".{name}.part"
    partial.mkdir(parents=True, exist_ok=True)
    for each in contents:
        for file, data in each["files"].items():
            path = Path(placed(each["root"], partial), file)
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(data)
    return partial.replace(target)


def placed(path: str, root: Path) -> str:
    """Where a file of another machine lies below the root of `put_down`."""
    plain = Path(path)
    return str(root / plain.relative_to(plain.anchor))


def moved(job: Job, to: Callable[[str], str]) -> Job:
    """The job with every file it names at another place."""
    kind, colon, hidden = job.vehicle.partition(":")
    stack, _, made = (job.ads or "").rpartition(":")
    return dataclasses.replace(
        job,
        scenario=to(job.scenario) if job.scenario else "",
        model=to(job.model) if job.model else job.model,
        gates=to(job.gates) if job.gates else job.gates,
        log=to(job.log) if job.log else job.log,
        vehicle=f"{kind}:{to(hidden)}" if colon else job.vehicle,
        library=tuple(to(folder) for folder in job.library),
        ads=f"{to(stack)}:{made}" if stack else job.ads,
    )


def _folders(job: Job) -> list[str]:
    named = [job.scenario, job.gates] if not job.log else []
    return [*(str(Path(file).parent) for file in named if file), *job.library]


def _files(job: Job) -> list[str]:
    hidden = job.vehicle.partition(":")[2]
    found = [file for file in (job.scenario, job.model, job.gates, job.log, hidden) if file]
    if job.ads:
        robot = Path(job.ads.rpartition(":")[0])
        commands = robot.with_name(f"{robot.stem.removesuffix('_robot')}_commands.csv")
        if commands.is_file():
            found += [str(robot), str(commands)]
    return found


def _below(folder: str) -> Parcel:
    files: list[tuple[str, str]] = []
    size = 0
    for name, file in reachable(folder):
        size += file.stat().st_size
        files.append((name, file_digest(str(file))))
        if size > MOST or len(files) > MOST_FILES:
            raise TuneError(
                f"{folder}: scenarios, roads and tables below it are carried to the other machines, found more "
                f"than {MOST // 2**20} MB or {MOST_FILES} files; put the scenario into a folder of its own"
            )
    return Parcel(folder, tuple(sorted(files)))
