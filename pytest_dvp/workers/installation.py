"""What is installed on a machine and decides a result, to be held against what another machine has."""

from __future__ import annotations

import functools
import hashlib
import importlib.metadata
import platform
from collections.abc import Mapping

from pytest_dvp.workers.job import package_folders

COMPUTE = ("numpy", "scipy", "numba", "llvmlite", "pymunk", "libsumo", "daqp")
"""Packages that compute: another version may round elsewhere."""


@functools.cache
def installed() -> Mapping[str, str]:
    """Each source file with its SHA-256, each package that computes with its version, Python, system, processor.

    Taken once a process, before anything of it runs: what a long-lived process has loaded is what it was then.
    """
    found = {
        "Python": ".".join(platform.python_version_tuple()[:2]),
        "system": platform.system(),
        "processor": platform.machine(),
    }
    for package in ("pytest-dvp", *COMPUTE):
        try:
            found[package] = importlib.metadata.version(package)
        except importlib.metadata.PackageNotFoundError:
            continue
    for package, root in package_folders():
        for file in sorted(root.rglob("*")):
            if file.is_file() and "__pycache__" not in file.parts:
                found[f"{package}/{file.relative_to(root).as_posix()}"] = hashlib.sha256(file.read_bytes()).hexdigest()
    return found


def first_difference(here: Mapping[str, str], there: Mapping[str, str]) -> str:
    """What differs first, said from `here`; "" if nothing does."""
    for name in dict.fromkeys((*here, *there)):
        one, other = here.get(name), there.get(name)
        if one == other:
            continue
        if "/" not in name:
            return f"{name} is {other or 'missing'} there, {one or 'missing'} here"
        if other is None:
            return f"it has no {name}"
        return f"its {name} differs" if one is not None else f"it has {name}, which is not here"
    return ""
