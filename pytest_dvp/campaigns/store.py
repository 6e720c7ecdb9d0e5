"""The store of a campaign: one SQLite file, one row a drive, written by one process, read by any number."""

from __future__ import annotations

import contextlib
import dataclasses
import json
import sqlite3
from collections.abc import Iterable, Iterator
from pathlib import Path
from types import TracebackType
from typing import Any

FILE = "campaign.sqlite"
"""A folder that holds this file is a campaign; any other folder is a folder of scenarios."""
LOGS = "logs"  # folder of the logs that are kept
LOCK = "campaign.lock"
EXCLUDED = "EXCLUDED"
"""Verdict of values that the constraints of the scenario exclude: no drive, and no part of any share."""
SHRINKING = "reproducer"
"""Purpose of the drives that shrink a failure: they lie around it, and count neither as samples nor as failures."""

_TABLES = """
CREATE TABLE IF NOT EXISTS runs(
  key TEXT PRIMARY KEY, scenario TEXT, parameters TEXT, seed INTEGER, verdict TEXT, margins TEXT, metrics TEXT,
  vacuous INTEGER, cpu REAL, commit_id TEXT, log TEXT);
CREATE TABLE IF NOT EXISTS judged(
  key TEXT PRIMARY KEY, base TEXT, purpose TEXT, objective REAL, gate TEXT, object TEXT, message TEXT);
CREATE TABLE IF NOT EXISTS about(name TEXT PRIMARY KEY, value TEXT);
"""
_PURPOSE = f"""ON CONFLICT(key) DO UPDATE SET purpose = excluded.purpose
  WHERE purpose = '{SHRINKING}' AND excluded.purpose != '{SHRINKING}'"""
_BOTH = """SELECT runs.key, scenario, parameters, seed, verdict, margins, metrics, vacuous, cpu, commit_id, log,
  base, purpose, objective, gate, object, message FROM runs JOIN judged USING(key)"""


class StoreError(ValueError):
    """A campaign that cannot be opened or written; one line."""


@dataclasses.dataclass(frozen=True)
class Row:
    """One drive.

    key        hash of scenario, road, gates, stack, model, code, options, seed and parameters: what decides the drive
    base       the same hash without the parameters
    parameters that were varied, as a file spells them
    margins    of each gate in its unit; metrics: all of the log; None where undefined
    vacuous    an event of the storyboard never fired
    cpu        [s] of CPU time; commit_id: of the project's checkout, "" outside of one
    log        relative to the campaign's folder, "" if it was not kept
    purpose    why it was driven: sample, search, probability, reproducer
    objective  least margin/scale over the gates, < 0 for a failure; None if nothing was measured
    gate, object, message  what the objective is of, with whom, and the verdict in one line
    """

    key: str
    scenario: str
    parameters: dict[str, str]
    seed: int
    verdict: str
    margins: dict[str, float | None]
    metrics: dict[str, float | None]
    vacuous: bool
    cpu: float
    commit_id: str
    log: str
    base: str
    purpose: str
    objective: float | None
    gate: str
    object: str
    message: str

    @property
    def failed(self) -> bool:
        """Whether the stack failed: a gate is broken, or the stack itself broke."""
        return self.verdict in ("FAIL", "ERROR")


class Store:
    """The rows of a campaign by key. `writes`: this process is the one that adds to it.

    Raises StoreError if the folder holds no campaign (reading), or another process writes it (writing).
    """

    def __init__(self, folder: Path, *, writes: bool = False) -> None:
        self.folder, self._lock = folder, contextlib.ExitStack()
        file = folder / FILE
        if writes:
            try:
                folder.mkdir(parents=True, exist_ok=True)
            except OSError as error:
                raise StoreError(f"{folder}: cannot be made: {error.strerror or error}") from None
            self._lock.enter_context(_locked(folder / LOCK))
        elif not file.is_file():
            raise StoreError(f"{folder}: no campaign: it holds no {FILE}")
        try:
            self._file = sqlite3.connect(file, timeout=30.0, isolation_level=None)
            if writes:
                # A commit in the log ahead survives the death of the process; of the machine it may lose the last rows,
                # never a whole one in part.
                self._file.execute("PRAGMA journal_mode=WAL")
                self._file.execute("PRAGMA synchronous=NORMAL")
                self._file.executescript(_TABLES)
            self._file.execute("SELECT key FROM runs LIMIT 1")
            self._file.execute("SELECT key FROM judged LIMIT 1")
        except sqlite3.Error as error:
            self._lock.close()
            raise StoreError(f"{file}: cannot be read as a campaign: {error}") from None

    def __enter__(self) -> Store:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._file.close()
        self._lock.close()

    def add(self, row: Row) -> None:
        """Add a drive, at once and whole; one with the same key stays as it is.

        But what was driven to shrink a failure, and is part of a sample as well, is told as a part of the sample,
        whichever came first.
        """
        run = (
            row.key, row.scenario, _json(row.parameters), row.seed, row.verdict, _json(row.margins), _json(row.metrics),
            int(row.vacuous), row.cpu, row.commit_id, row.log,
        )  # fmt: skip
        judged = (row.key, row.base, row.purpose, row.objective, row.gate, row.object, row.message)
        self._file.execute("BEGIN IMMEDIATE")
        self._file.execute(f"INSERT OR IGNORE INTO runs VALUES ({','.join('?' * len(run))})", run)
        self._file.execute(f"INSERT INTO judged VALUES ({','.join('?' * len(judged))}) {_PURPOSE}", judged)
        self._file.execute("COMMIT")

    def forget(self, key: str) -> None:
        """Remove a drive and its log, so that it can be driven again."""
        self.drop_log(key)
        self._file.execute("BEGIN IMMEDIATE")
        self._file.execute("DELETE FROM runs WHERE key = ?", (key,))
        self._file.execute("DELETE FROM judged WHERE key = ?", (key,))
        self._file.execute("COMMIT")

    def drop_log(self, key: str) -> None:
        """Forget the log of a drive, and remove its file."""
        row = self.get(key)
        if row is not None and row.log:
            self._file.execute("UPDATE runs SET log = '' WHERE key = ?", (key,))
            (self.folder / row.log).unlink(missing_ok=True)

    def get(self, key: str) -> Row | None:
        """The drive with a key; None if there is none."""
        found = self._file.execute(f"{_BOTH} WHERE runs.key = ?", (key,)).fetchone()
        return None if found is None else _row(found)

    def rows(self, bases: Iterable[str] | None = None) -> list[Row]:
        """All drives in the order in which they came; bases: only those of these settings."""
        chosen = None if bases is None else set(bases)
        found = (_row(each) for each in self._file.execute(f"{_BOTH} ORDER BY runs.rowid"))
        return [row for row in found if chosen is None or row.base in chosen]

    def tell(self, name: str, value: Any) -> None:
        """Keep something about the whole campaign, as JSON."""
        self._file.execute("INSERT OR REPLACE INTO about VALUES (?, ?)", (name, json.dumps(value)))

    def told(self, name: str) -> Any:
        """What `tell` kept; None if nothing."""
        found = self._file.execute("SELECT value FROM about WHERE name = ?", (name,)).fetchone()
        return None if found is None else json.loads(found[0])


def is_campaign(path: Path) -> bool:
    """Whether a path is the folder of a campaign."""
    return (path / FILE).is_file()


def _row(found: tuple[Any, ...]) -> Row:
    key, scenario, parameters, seed, verdict, margins, metrics, vacuous, *rest = found
    if not str(key).isalnum() or rest[2] not in ("", f"{LOGS}/{key}.mcap"):
        # A log is copied and removed by its name: one that leads out of the folder must not be followed.
        raise StoreError(f"{FILE}: row {str(key)[:60]!r}: log {str(rest[2])[:60]!r}, expected {LOGS}/KEY.mcap")
    try:
        values = {name: _spelled(value) for name, value in json.loads(parameters).items()}
        plain = json.loads(margins), json.loads(metrics)
    except (ValueError, TypeError, AttributeError) as error:
        raise StoreError(f"{FILE}: row {key}: no JSON in a text column: {error}") from None
    return Row(key, scenario, values, seed, verdict, plain[0], plain[1], bool(vacuous), *rest)


def _spelled(value: object) -> str:
    from openscenario.values import spelled

    return spelled(value) if isinstance(value, bool | int | float) else str(value)


def _json(values: dict[str, Any]) -> str:
    """JSON in which a number among parameters is a number."""
    return json.dumps({name: _plain(value) for name, value in values.items()}, sort_keys=True, allow_nan=False)


def _plain(value: Any) -> Any:
    if not isinstance(value, str):
        return value
    for kind in (int, float):
        with contextlib.suppress(ValueError, OverflowError):
            number = kind(value)
            if _spelled(number) == value:  # a word such as "007" or "nan" stays one
                return number
    return value


@contextlib.contextmanager
def _locked(path: Path) -> Iterator[None]:
    """The right to write a campaign, which the kernel takes back from a process that ends. Raises StoreError."""
    import fcntl

    with path.open("a") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise StoreError(f"{path.parent}: another process is writing this campaign: wait for it") from None
        yield
