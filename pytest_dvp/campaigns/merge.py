"""Several campaigns put together: the parts that CI jobs drove side by side."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from pytest_dvp.campaigns.store import LOGS, Store, StoreError
from pytest_dvp.campaigns.summary import CURRENT
from reports.whole_file import write_whole


def merge(folders: Sequence[Path], store: Store) -> None:
    """Add the rows of the campaigns in these folders to a store, with the logs that they keep; a drive that several
    have is there once. Their order changes nothing but the order of the rows.

    A probability that was measured from one part alone is not taken over: it is none of the whole.

    Raises StoreError for a folder that holds no campaign, or is the store's own; WriteError for a log that cannot be
    written.
    """
    bases: list[str] = list(store.told(CURRENT) or ())
    for folder in folders:
        if folder.resolve() == store.folder.resolve():
            raise StoreError(f"{folder}: it is --out itself: name another folder for the whole")
        with Store(folder) as part:
            bases += part.told(CURRENT) or ()
            for row in part.rows():
                if row.log and (folder / row.log).is_file():
                    (store.folder / LOGS).mkdir(parents=True, exist_ok=True)
                    write_whole(store.folder / LOGS / f"{row.key}.mcap", (folder / row.log).read_bytes())
                store.add(row)
    store.tell(CURRENT, list(dict.fromkeys(bases)))
