"""List the licences of everything that pytest-dvp needs at run time.

    python -m scripts.third_party_licences > THIRD_PARTY_LICENCES.md

Walks the requirements of pytest-dvp through the metadata of the installed packages; what only an extra needs names
that extra, and is missing if the extra is not installed. Versions come from constraints.txt, so that the list does not
depend on the machine it was made on.
"""

from __future__ import annotations

import re
import sys
from importlib import metadata
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = "pytest-dvp"
CONSTRAINTS = Path(__file__).resolve().parents[1] / "constraints.txt"
# What an "OSI Approved" classifier calls a licence, as SPDX does.
SPDX = {
    "MIT License": "MIT",
    "Apache Software License": "Apache-2.0",
    "Apache 2.0": "Apache-2.0",
    "BSD License": "BSD",
    "Mozilla Public License 2.0 (MPL 2.0)": "MPL-2.0",
    "ISC License (ISCL)": "ISC",
    "Python Software Foundation License": "PSF-2.0",
    "GNU Lesser General Public License v3 (LGPLv3)": "LGPL-3.0-only",
    "Eclipse Public License 2.0 (EPL-2.0)": "EPL-2.0",
}
HEADER = """# Third-party licences

Made by `python -m scripts.third_party_licences`; do not edit. What pytest-dvp needs at run time, directly or through
others, with the versions of `constraints.txt`. Nothing of it is part of this repository, but each report of a run
carries a copy of plotly.js (MIT, its notice at the head of the script).

| package | version | licence | home page | only with extra |
|---|---|---|---|---|
"""


def closure(root: str, extra: str = "") -> list[str]:
    """Canonical names of all that `root` requires here, with an extra of its own or none, sorted; `root` left out.

    What is not installed, though a package of an extra would require it, is left out.
    """
    found: set[str] = set()
    waiting = [(root, extra)]
    while waiting:
        package, wanted = waiting.pop()
        for text in metadata.requires(package) or ():
            requirement = Requirement(text)
            name = canonicalize_name(requirement.name)
            if name in found or (requirement.marker and not requirement.marker.evaluate({"extra": wanted})):
                continue
            try:
                metadata.metadata(name)
            except metadata.PackageNotFoundError:
                if not extra:
                    raise
                continue
            found.add(name)
            waiting.append((name, ""))
    return sorted(found)


def licence(package: metadata.PackageMetadata) -> str:
    """SPDX expression if the package states one, else its licence field if that is short, else its classifiers."""
    expression = package.get("License-Expression")
    if expression:
        return str(expression)
    field = " ".join((package.get("License") or "").split())
    if field and len(field) <= 60 and field.upper() != "UNKNOWN":
        return SPDX.get(field, field)
    names = [text.split(" :: ")[-1] for text in package.get_all("Classifier") or () if text.startswith("License ::")]
    return " or ".join(SPDX.get(name, name) for name in names) or "not stated"


def home_page(package: metadata.PackageMetadata) -> str:
    """The page a package calls its home, else where its source is."""
    pages: dict[str, str] = {}
    for text in package.get_all("Project-URL") or ():
        label, _, address = text.partition(",")
        pages[re.sub(r"[^a-z]", "", label.lower())] = address.strip()
    if package.get("Home-page"):
        pages.setdefault("homepage", str(package["Home-page"]))
    order = ("homepage", "home", "source", "sourcecode", "repository", "github", "code", "documentation")
    return next((pages[label] for label in order if label in pages), next(iter(pages.values()), ""))


def pinned(constraints: Path) -> dict[str, str]:
    """Versions by canonical name; where they differ by Python version, all of them."""
    versions: dict[str, list[str]] = {}
    for line in constraints.read_text(encoding="utf-8").splitlines():
        match = re.match(r"([A-Za-z0-9._-]+)==([^\s;]+)", line)
        if match:
            versions.setdefault(canonicalize_name(match[1]), []).append(match[2])
    return {name: ", ".join(found) for name, found in versions.items()}


def main() -> None:
    versions = pinned(CONSTRAINTS)
    core = closure(ROOT)
    needed: dict[str, list[str]] = {name: [] for name in core}
    for extra in sorted(metadata.metadata(ROOT).get_all("Provides-Extra") or ()):
        for name in closure(ROOT, extra) if extra != "dev" else ():
            if name not in core:
                needed.setdefault(name, []).append(extra)
    lines = []
    for name in sorted(needed):
        package = metadata.metadata(name)
        cells = (
            str(package["Name"]),
            versions.get(name, "any"),
            licence(package),
            home_page(package),
            ", ".join(needed[name]),
        )
        lines.append("| " + " | ".join(cell.replace("|", "/") for cell in cells) + " |\n")
    sys.stdout.write(HEADER + "".join(lines))


if __name__ == "__main__":
    main()
