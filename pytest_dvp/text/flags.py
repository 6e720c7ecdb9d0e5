"""Words for yes and no in options, ini files and the environment."""

from __future__ import annotations

from pytest_dvp.text.errors import SettingError


def is_on(text: str, origin: str) -> bool:
    """True for 1, true, yes, on; False for 0, false, no, off, in any case. Raises SettingError naming `origin`."""
    if text.lower() in ("1", "true", "yes", "on"):
        return True
    if text.lower() in ("0", "false", "no", "off"):
        return False
    raise SettingError(f"{origin} is {text!r}, expected true or false")
