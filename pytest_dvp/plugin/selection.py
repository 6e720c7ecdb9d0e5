"""What the command line of pytest asks for: stages, and paths that a user wrote."""

from __future__ import annotations

import re

import pytest


def asked_stage(stage: str, config: pytest.Config) -> bool:
    """Whether `-m`, `-k` or a node id names a stage: what takes a car, if only a surrogate, is not run unasked."""
    words = f"{config.option.markexpr} {config.option.keyword}"
    named = any(f"::{stage}" in argument for argument in config.args)
    return named or re.search(rf"(?<!\bnot )\b{stage}\b", words) is not None


def explicit_arguments(config: pytest.Config) -> bool:
    """True if a user wrote the paths on the command line (and not `testpaths` or the current folder)."""
    told = getattr(config, "workerinput", {}).get("dvp_explicit")
    return told if told is not None else config.args_source is pytest.Config.ArgsSource.ARGS
