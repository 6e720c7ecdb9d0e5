"""Logs that judge must not be those that were fitted on: neither by their path nor by what they hold."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from pytest_dvp.cli.shared.arguments import WrongArgument

if TYPE_CHECKING:
    from pytest_dvp.logs.log import Log


def refuse_same_path(fitted: Sequence[str], judging: Sequence[str]) -> None:
    """Raises WrongArgument if a log of --held-out is, or overlaps, one that is fitted on. Reads nothing."""
    from pytest_dvp.logs.log_part import parse_argument

    for group in (fitted, judging):
        for text in group:
            if list(group).count(text) > 1:
                raise WrongArgument(f"{text}: named {list(group).count(text)} times: name it once")
    for text in judging:
        judge = parse_argument(text)
        for one in map(parse_argument, fitted):
            same = one.path.resolve() == judge.path.resolve()
            if same and max(one.start, judge.start) < min(one.stop, judge.stop):
                raise WrongArgument(f"--held-out {text}: it is fitted on as well, and so would judge itself")


def refuse_same_drive(fitted: Mapping[str, Log], judging: Mapping[str, Log]) -> None:
    """Raises WrongArgument if a log of --held-out holds the same rows as one fitted on, under another name; or two that
    are fitted on do, of which each is predicted from the other where nothing is held out."""
    from pytest_dvp.cli.shared.same_drive import shared_rows

    for name, judge in judging.items():
        for other, log in fitted.items():
            if rows := shared_rows(log, judge):
                same = f"the same drive as {other} ({rows} rows are the same)"
                raise WrongArgument(f"--held-out {name}: {same}, and so would judge itself")
    for (name, one), (other, log) in itertools.combinations(fitted.items(), 2):
        if rows := shared_rows(one, log):
            raise WrongArgument(f"{other}: the same drive as {name} ({rows} rows are the same): name it once")
