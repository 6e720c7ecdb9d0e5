"""What a user can do wrong with a study."""

from __future__ import annotations


class TuneError(ValueError):
    """A study that cannot be tuned; one line with file, place, what was found and what is allowed.

    line  in the file, None where it has none; text: what is said without the place
    """

    def __init__(self, text: str, *, file: str = "", line: int | None = None) -> None:
        self.text, self.file, self.line = text, file, line
        place = f"{file}:{line}: " if file and line else f"{file}: " if file else ""
        super().__init__(place + text)
