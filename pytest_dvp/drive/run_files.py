"""What a run leaves on disk: its folder from its first tick on, its files at its end, and what could not be written.

A disk that is full, or goes away, loses files and never a verdict.
"""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING

from pytest_dvp.logs.log_error import LogError
from pytest_dvp.logs.unfinished_run import FULL, PART
from pytest_dvp.text.paths import shown
from pytest_dvp.verdicts.result_text import NOT_WRITTEN

if TYPE_CHECKING:
    from pytest_dvp.drive.result import RunResult
    from pytest_dvp.drive.run_folder import Place
    from pytest_dvp.logs.partial_log import LogPart
    from pytest_dvp.logs.recorder import LogRecorder


class Kept:
    """The folder of one run below `root`, and the part of its log there while it drives."""

    def __init__(self, root: Path, name: str, place: Place | None, part: LogPart | None, *, single_file: bool) -> None:
        self._root, self._name, self._place, self._single_file = root, name, place, single_file
        self.part = part

    @classmethod
    def reserve(cls, root: Path | None, name: str, recorder: LogRecorder, *, single_file: bool) -> Kept | None:
        """Take a number and begin the part; None if nothing is to be written.

        Raises ResultError if no folder can be made there, unless it is for a disk that is full.
        """
        if root is None:
            return None
        from pytest_dvp.drive.run_folder import Place, ResultError
        from pytest_dvp.logs.partial_log import LogPart

        stage = str(recorder.meta.get("stage", "dt"))
        try:
            place = Place.reserve(root, name, stage)
        except ResultError as error:
            if getattr(error.__cause__, "errno", None) not in FULL:
                raise
            return cls(root, name, None, None, single_file=single_file)
        return cls(root, name, place, LogPart(place.folder / PART, recorder), single_file=single_file)

    def finish(self, result: RunResult, *, brief: bool = False) -> RunResult:
        """The result with its folder, and a note for each file that could not be written; the verdicts are the same.

        brief  log and verdicts alone, in a second even of a long run
        Without a log there is no folder: what is left is the part.
        """
        from pytest_dvp.drive.run_folder import ResultError, save_run

        part = self.part
        if part is not None:
            part.write()
            part.close()
        lost: list[str] = []
        folder = None
        try:
            folder = save_run(
                result, self._root, self._name, place=self._place, brief=brief, single_file=self._single_file,
                lost=lost,
            )  # fmt: skip
        except (ResultError, LogError) as error:
            lost.append(str(error))
            if self._place is not None:  # by the name that it would have had
                lost[-1] = lost[-1].replace(str(self._place.hidden), shown(self._place.folder))
            if part is not None and part.path.is_file():
                lost[-1] += f"; what there is of the log: dvp recover {shown(part.path.parent)} --out FILE.mcap"
        notes = (*result.notes, *(f"{NOT_WRITTEN}{line}" for line in lost))
        return dataclasses.replace(result, folder=folder, notes=notes)

    def drop(self) -> None:
        """Leave nothing: the run ended without a result."""
        if self.part is not None:
            self.part.drop()
        if self._place is not None:
            self._place.give_up()
