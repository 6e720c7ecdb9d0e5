"""The command `dvp`; `dispatch.py` has its commands and says what its exit codes mean."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence

from pytest_dvp.plugin.shadowed_packages import hidden_package


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command; returns the exit code. Where a package of the user's hides one of ours, that is all it says.

    So nothing that imports those packages is loaded before it is known that they are ours.
    """
    hidden = hidden_package()
    if hidden is None:
        from pytest_dvp.cli.dispatch import main as dispatch

        return dispatch(argv)
    print(f"dvp: {hidden}", file=sys.stderr)
    if "--json" in (sys.argv[1:] if argv is None else argv):
        print(json.dumps({"error": hidden, "findings": []}, ensure_ascii=False))
    return 2
