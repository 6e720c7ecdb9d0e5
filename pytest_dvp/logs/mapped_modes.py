"""A mode of a foreign log, in numbers or words, as whether the car obeys its commands: the key `when` of a mapping."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from openscenario.findings import Findings, listed
from pytest_dvp.logs.combined_fields import MARK
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.log_error import LogError
from pytest_dvp.logs.stream import Stream

MODES = 'a list of numbers or of words, as [1] or ["AUTO"]'
_SHOWN = 8  # values of a field in a message


def is_mode_value(value: Any) -> bool:
    """Whether a value of TOML can be a mode: a number or a word."""
    if isinstance(value, str):
        return bool(value)
    return isinstance(value, int | float) and not isinstance(value, bool) and bool(np.isfinite(value))


def has_modes(stream: Stream, field: str) -> bool:
    """Whether a stream has a field, or each of the fields of "A + B", as numbers or words."""
    return all(one in stream.fields or one in stream.texts for one in field.split(MARK))


def obeyed_in(stream: Stream, field: str, when: Sequence[float | str], where: str) -> FloatArray:
    """1 (no unit) where a field (n,) holds one of `when`, 0 where it holds anything else, NaN where it holds nothing.

    Of "A + B" it is 1 where each of them does: who steers and who drives along the road may be two questions.

    Raises LogError, which begins with `where`, if `when` has words for a field of numbers, or the other way round.
    """
    return np.asarray(np.min([_obeyed(stream, one, when, where) for one in field.split(MARK)], axis=0))


def _obeyed(stream: Stream, field: str, when: Sequence[float | str], where: str) -> FloatArray:
    texts = stream.texts.get(field)
    if any(isinstance(one, str) == (texts is None) for one in when):
        kind = "numbers" if texts is None else "words"
        text = f"{where}: when: found {list(when)}, but {field!r} holds {kind}: {held_in(stream, field)}"
        raise LogError(text, "log.bad_mapping")
    values = stream.fields[field] if texts is None else texts.codes
    wanted = when if texts is None else [k for k, word in enumerate(texts.words) if word in when]
    return np.where(np.isfinite(values), np.isin(values, np.asarray(wanted, dtype=np.float64)), np.nan)


def check_modes(stream: Stream, field: str, when: Sequence[float | str], file: str, findings: Findings) -> None:
    """A warning for modes that a field never holds: a drive without them, or a word that is written otherwise."""
    for name in field.split(MARK) if when else ():
        texts = stream.texts.get(name)
        there = set(np.unique(stream.fields[name]).tolist()) if texts is None else set(texts.words)
        if missing := [one for one in when if one not in there]:
            findings.add(
                "log.mode_absent", file, None, f"{stream.topic} {name}".strip(),
                f"it never holds {listed([shown_mode(one) for one in missing], _SHOWN)}, which `when` names",
                found=held_in(stream, name), severity="warning",
            )  # fmt: skip


def held_in(stream: Stream, field: str) -> str:
    """The words or numbers that a field holds, as a mapping writes them."""
    texts = stream.texts.get(field)
    if texts is not None:
        return listed([shown_mode(word) for word in texts.words], _SHOWN)
    values = stream.fields[field]
    return listed([shown_mode(value) for value in np.unique(values[np.isfinite(values)]).tolist()], _SHOWN)


def shown_mode(mode: float | str) -> str:
    """A mode as a mapping writes it: a word in quotes, a number without decimals that it does not need."""
    quoted = str(mode).replace("\\", "\\\\").replace('"', '\\"')
    return f'"{quoted}"' if isinstance(mode, str) else f"{mode:g}"
