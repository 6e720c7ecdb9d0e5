"""The error that wrong model files and wrong parameter values raise."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


class ModelError(ValueError):
    """One clear line about a vehicle model: where, what was found, what is allowed, the nearest valid name."""

    def __init__(
        self,
        text: str,
        *,
        file: str = "",
        line: int | None = None,
        key: str = "",
        found: str = "",
        allowed: str = "",
        nearest: str = "",
    ) -> None:
        self.text, self.file, self.line, self.key = text, file, line, key
        self.found, self.allowed, self.nearest = found, allowed, nearest
        place = f"{file}:{line}: " if file and line else f"{file}: " if file else ""
        subject = f"{key}: " if key else ""
        parts = [f"found {found}" if found else "", f"allowed: {allowed}" if allowed else ""]
        detail = "; ".join(p for p in parts if p)
        hint = f"; did you mean {nearest!r}?" if nearest else ""
        super().__init__(f"{place}{subject}{text}" + (f" ({detail})" if detail else "") + hint)

    def at(self, file: str, line: int | None, key: str = "") -> ModelError:
        """The same error, placed in a file."""
        return ModelError(
            self.text,
            file=file,
            line=line,
            key=key or self.key,
            found=self.found,
            allowed=self.allowed,
            nearest=self.nearest,
        )


def nearest_name(name: str, known: Iterable[str]) -> str:
    """The known name most like `name`, or an empty string."""
    names = sorted(known)
    folded = {n.lower(): n for n in reversed(names)}
    found = difflib.get_close_matches(name.lower(), list(folded), n=1, cutoff=0.6)
    return folded[found[0]] if found else ""


def is_misspelt(name: str, known: str) -> bool:
    """True if a name is the known one but for its case or one slip: a letter left out, put in, exchanged, or two
    neighbours exchanged. With a letter before or behind it is a name of its own (`brake_lag2`)."""
    a, b = name.lower(), known.lower()
    if len(a) < len(b):
        return any(b[:k] + b[k + 1 :] == a for k in range(len(b)))
    if len(a) > len(b):
        return any(a[:k] + a[k + 1 :] == b for k in range(1, len(a) - 1))
    other = [k for k in range(len(a)) if a[k] != b[k]]
    swapped = len(other) == 2 and other[1] == other[0] + 1 and a[other[0]] + a[other[1]] == b[other[1]] + b[other[0]]
    return len(other) < 2 or swapped
