"""What is wrong with a log, and which effects it could ever reveal. Runs before any physics is fitted to it."""

from pytest_dvp.doctor.checked_log import check_log, print_findings, read_checked_log
from pytest_dvp.doctor.comparable_log import comparable
from pytest_dvp.doctor.examine import examine
from pytest_dvp.doctor.excitation import Excitation, excitation

__all__ = [
    "Excitation", "check_log", "comparable", "examine", "excitation", "print_findings", "read_checked_log",
]  # fmt: skip
