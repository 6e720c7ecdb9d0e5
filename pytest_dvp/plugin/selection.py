"""What the command line of pytest asks for: stages, and paths that a user wrote."""

from __future__ import annotations

import re

import pytest


def asked_stage(stage: str, config: pytest.Config) -> bool:
    """Whether `-m`, `-k` or a node id names a stage: what takes a car, if only a surrogate, is not run unasked."""
    named = any(re.search(rf"::{stage}\b", argument) for argument in config.args)
    return named or _wants(config.option.markexpr, stage) or _wants(config.option.keyword, stage)


def _wants(expression: str, stage: str) -> bool:
    """Whether an expression of `-m` or `-k` names a stage that it wants: under no `not`, or under two."""
    unwanted, negated = [False], False  # of each open parenthesis; by a `not` right before
    for word in re.findall(r"[()]|[^\s()]+", expression or ""):
        here = unwanted[-1] != negated
        if word == "not":
            negated = not negated
            continue
        if word == "(":
            unwanted.append(here)
        elif word == ")":
            unwanted[1:] = unwanted[1:-1]
        elif not here and re.search(rf"\b{stage}\b", word):
            return True
        negated = False
    return False


def explicit_arguments(config: pytest.Config) -> bool:
    """True if a user wrote the paths on the command line (and not `testpaths` or the current folder)."""
    told = getattr(config, "workerinput", {}).get("dvp_explicit")
    return told if told is not None else config.args_source is pytest.Config.ArgsSource.ARGS
