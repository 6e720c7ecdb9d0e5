"""The command line `dvp`: one file a command, and in `shared/` what several of them need.

Begin with `command_line.py`.
"""

from __future__ import annotations

from typing import Any


def __getattr__(name: str) -> Any:
    if name != "main":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    import warnings

    from pytest_dvp.cli.command_line import main

    warnings.warn("pytest_dvp.cli.main is pytest_dvp.cli.command_line.main now", DeprecationWarning, stacklevel=2)
    return main
