"""A job: one simulation, or one recorded log that a twin is held against; what it depends on is its key."""

from __future__ import annotations

import dataclasses
import functools
import hashlib
import json
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from pytest_dvp.rooms.side_by_side import ROOT
from pytest_dvp.workers.scenario_files import reachable

PACKAGES = ("machine_code", "openscenario", "vehicle", "ads", "pytest_dvp")
"""What a result depends on besides the files: the code."""
NOT_PHYSICS = ("cli", "tuning", "workers")  # folders of pytest_dvp in which no metric is made


@dataclasses.dataclass(frozen=True, slots=True)
class Job:
    """One drive of a scenario (`log` None), or one recorded log replayed through the twin.

    scenario, model, gates, log, vehicle  files as named; the key holds their bytes, so a changed file is another job
    parameters of the scenario; P, S      values by name
    gated  the twin behind the guard, as the car is
    ads    "FILE.py:Class" in place of the reference stack: one of a user's own, whose folder the key holds, or
           "NAME_robot.py:Class", which plays NAME_commands.csv beside it
    """

    scenario: str
    stage: str = "dt"
    seed: int = 7
    parameters: tuple[tuple[str, float], ...] = ()
    P: tuple[tuple[str, float], ...] = ()
    S: tuple[tuple[str, float], ...] = ()
    model: str | None = None
    gates: str | None = None
    vehicle: str = "surrogate"
    library: tuple[str, ...] = ()
    log: str | None = None
    gated: bool = False
    ads: str | None = None
    duration: float | None = None
    save: str | None = None

    @property
    def key(self) -> str:
        """Hash of everything that decides the result: 64 hex digits."""
        plain: dict[str, Any] = dataclasses.asdict(self)
        del plain["save"]
        for name in ("scenario", "model", "gates", "log"):
            if plain[name]:
                plain[name] = file_digest(plain[name])
        if plain["ads"]:
            plain["ads"] = _stack(plain["ads"])
        hidden = self.vehicle.partition(":")[2]
        plain["vehicle"] = [self.vehicle.partition(":")[0], file_digest(hidden) if hidden else ""]
        plain["library"] = [_library(folder) for folder in self.library]
        plain["beside"] = "" if self.log else _beside(self.scenario)
        plain["code"] = code_digest()
        return hashlib.sha256(json.dumps(plain, sort_keys=True).encode()).hexdigest()

    @property
    def title(self) -> str:
        """For progress: `overtaking dt seed 7`."""
        if self.log is not None:
            return f"replay of {Path(self.log).parent.name or self.log}"
        return f"{Path(self.scenario).stem} {self.stage} seed {self.seed}"


def pairs(values: Mapping[str, float]) -> tuple[tuple[str, float], ...]:
    """A mapping as a Job holds it: sorted, so that order makes no other job."""
    return tuple(sorted((name, float(value)) for name, value in values.items()))


def file_digest(name: str) -> str:
    """SHA-256 of a file's bytes, read anew when it changes."""
    path = Path(name)
    stat = path.stat()
    return _digest(str(path.absolute()), stat.st_mtime_ns, stat.st_size)


@functools.lru_cache(maxsize=4096)
def _digest(path: str, changed: int, size: int) -> str:
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()


def _stack(word: str) -> list[str]:
    """Digests of a robot and of the commands that it plays; or of the sources of a stack of a user's own."""
    name, _, made = word.rpartition(":")
    file = Path(name)
    commands = file.with_name(f"{file.stem.removesuffix('_robot')}_commands.csv")
    if commands.is_file():
        return [file_digest(str(each)) for each in (file, commands)]
    return [f"{file.name}:{made}", _sources(file.absolute().parent)]


@functools.cache
def _sources(folder: Path) -> str:
    """Digest of the Python files of a folder and below, without hidden folders and installed packages."""
    digest = hashlib.sha256()
    for file in sorted(folder.rglob("*.py")):
        inside = file.relative_to(folder)
        if not any(part.startswith(".") or part in ("site-packages", "node_modules") for part in inside.parts):
            digest.update(f"{inside.as_posix()} {file_digest(str(file))}\n".encode())
    return digest.hexdigest()


def _beside(scenario: str) -> str:
    """Digest of what a run can open of the scenario's folder: its net and its gates, and roads and catalogues there and
    below. Other scenarios of the folder do not count."""
    digest = hashlib.sha256()
    for name, file in reachable(Path(scenario).absolute().parent, (".xosc", ".xodr", ".xml", ".toml")):
        below = "/" in name
        if file.suffix == ".xosc":
            opened = below or _is_catalog(str(file), file.stat().st_mtime_ns)
        else:
            opened = file.suffix == ".xodr" or not below
        if opened:
            digest.update(f"{name} {file_digest(str(file))}\n".encode())
    return digest.hexdigest()


@functools.lru_cache(maxsize=4096)
def _is_catalog(path: str, changed: int) -> bool:
    """Whether a file holds a catalogue, not a scenario; read anew when it changes."""
    return re.search(rb"<Catalog[\s>]", Path(path).read_bytes()) is not None


@functools.cache
def _library(folder: str) -> str:
    """Digest of what scenarios can open of a folder of --library."""
    digest = hashlib.sha256()
    for name, file in reachable(Path(folder).absolute()):
        digest.update(f"{name} {file_digest(str(file))}\n".encode())
    return digest.hexdigest()


def package_folders() -> Iterator[tuple[str, Path]]:
    """Name and folder of each of PACKAGES that is installed."""
    for package in PACKAGES:
        if (ROOT / package / "__init__.py").is_file():
            yield package, ROOT / package


@functools.cache
def code_digest() -> str:
    """Digest of the sources that make a result."""
    digest = hashlib.sha256()
    for package, root in package_folders():
        for file in sorted(root.rglob("*.py")):
            inside = file.relative_to(root)
            if package == "pytest_dvp" and inside.parts[0] in NOT_PHYSICS:
                continue
            digest.update(f"{package}/{inside.as_posix()}\n".encode())
            digest.update(file.read_bytes())
    return digest.hexdigest()
