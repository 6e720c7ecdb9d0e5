"""Log: everything that is known of one run. What comes after a run reads a Log and nothing else."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING

from pytest_dvp.logs.log_contents import (
    LogContents,
)

if TYPE_CHECKING:
    import pandas as pd

    from pytest_dvp.logs.budget import Budget


@dataclasses.dataclass(frozen=True, eq=False, slots=True, weakref_slot=True, repr=False)
class Log(LogContents):
    """One run: see `LogContents` for what it holds, and `save` and `load` for its file."""

    def save(self, path: Path | str) -> None:
        """Write an MCAP file, whole or not at all: same log, same bytes. Raises LogError if it cannot be written."""
        from pytest_dvp.logs.mcap_write import save_log

        save_log(self, Path(path))

    @staticmethod
    def load(path: Path | str, budget: Budget | None = None) -> Log:
        """Read what `save` wrote, exactly; of a run folder its log.mcap.

        budget  how large it may be; None: the budget of the command or session
        Raises LogError for a missing, cut, corrupt, foreign or too large file.
        """
        from pytest_dvp.logs.mcap_read import load_log

        path = Path(path)
        return Log.of(load_log(path / "log.mcap" if path.is_dir() else path, budget))

    @staticmethod
    def of(contents: LogContents) -> Log:
        """The log with these contents; nothing is copied."""
        return Log(**{field.name: getattr(contents, field.name) for field in dataclasses.fields(contents)})

    def to_frame(self) -> pd.DataFrame:
        """The columns as a pandas table; pandas is imported here only."""
        import pandas as pd

        return pd.DataFrame(dict(self.columns))
