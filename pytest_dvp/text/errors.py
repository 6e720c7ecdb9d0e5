"""Errors that say in one line what is wrong with an option or file of a user."""

from __future__ import annotations


class SettingError(ValueError):
    """A wrong option, ini key or environment variable, said in one line."""


def is_users_mistake(error: BaseException) -> bool:
    """True for the errors that say in one line what is wrong with a user's file or option.

    These are ScenarioError and every class of ours derived from ValueError; they are shown without a traceback.
    """
    kind = type(error)
    ours = kind.__module__.split(".")[0] in ("openscenario", "vehicle", "ads", "pytest_dvp", "reports")
    return ours and (isinstance(error, ValueError) or kind.__name__ == "ScenarioError")
