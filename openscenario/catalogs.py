"""Catalogues: finding the file and the entry that a CatalogReference names, inside the allowed folders."""

from __future__ import annotations

import functools
import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from openscenario.findings import ScenarioError, listed, nearest
from openscenario.model.catalogs import CatalogLocations, CatalogReference
from openscenario.model.kinds import At
from openscenario.paths import PathError, Roots
from openscenario.xml import MAX_BYTES, Document, Node, parse_xml, read_bytes

KINDS: Final = ("Vehicle", "Controller", "Pedestrian", "MiscObject", "Environment", "Maneuver", "Trajectory", "Route")
_SHARED_BYTES: Final = 1 << 20  # larger files are not kept in memory
_MOST_FILES: Final = 1_000  # catalogue files looked at in one folder


class CatalogError(ValueError):
    """A reference leads nowhere; the fields go into the finding. `at` is where, if not at the reference."""

    def __init__(
        self, code: str, text: str, attribute: str = "", found: str = "", hint: str = "", at: At | None = None
    ) -> None:
        super().__init__(text)
        self.code = code
        self.text = text
        self.attribute = attribute
        self.found = found
        self.hint = hint
        self.at = at


@dataclass(frozen=True, slots=True)
class Entry:
    """A catalogue entry: its element, the file it stands in, and its path there."""

    node: Node
    file: str
    element: str


@dataclass(slots=True)
class Catalogs:
    """The catalogues that a scenario's CatalogLocations lead to; files are read when a reference asks for them."""

    roots: Roots
    base: Path  # folder of the file that names the locations
    locations: tuple[tuple[str, str, At], ...] = ()  # kind, path as written, place
    documents: dict[Path, Document | ScenarioError] = field(default_factory=dict)

    @classmethod
    def of(cls, locations: CatalogLocations, roots: Roots, base: Path) -> Catalogs:
        """The catalogues at the locations."""
        by_kind = (
            ("Vehicle", locations.vehicle_catalog),
            ("Controller", locations.controller_catalog),
            ("Pedestrian", locations.pedestrian_catalog),
            ("MiscObject", locations.misc_object_catalog),
            ("Environment", locations.environment_catalog),
            ("Maneuver", locations.maneuver_catalog),
            ("Trajectory", locations.trajectory_catalog),
            ("Route", locations.route_catalog),
        )
        named = tuple((kind, at.directory.path, at.directory.at) for kind, at in by_kind if at is not None)
        return cls(roots, base, named)

    @property
    def hashes(self) -> list[str]:
        """Hashes of the files read so far, sorted."""
        return sorted(document.sha256 for document in self.documents.values() if isinstance(document, Document))

    def entry(self, reference: CatalogReference, kinds: Sequence[str]) -> Entry:
        """The entry that a reference names; `kinds` are the elements that may stand there.

        Raises:
            CatalogError: no such catalogue or entry (with the nearest name), a path that leaves the allowed folders.
            ScenarioError: the catalogue's file is no XML.
        """
        names: list[str] = []
        entries: list[str] = []
        wrong_kind = ""
        for path in self._candidates(reference.catalog_name, kinds):
            document = self._document(path)
            if isinstance(document, ScenarioError):
                if path.stem == reference.catalog_name:
                    raise document
                continue
            for catalog in document.root.findall("Catalog"):
                names.append(catalog.get("name"))
                if reference.catalog_name not in (names[-1], path.stem):  # esmini goes by the file's name
                    continue
                names.append(reference.catalog_name)
                for node in catalog.children:
                    if node.get("name") == reference.entry_name:
                        if node.tag in kinds:
                            element = f"OpenSCENARIO/Catalog/{node.tag}"
                            return Entry(node, document.file, element)
                        wrong_kind = node.tag
                    entries.append(node.get("name"))
        if wrong_kind:
            text = f"the entry is a {wrong_kind}, expected here: {', '.join(kinds)}"
            raise CatalogError("catalog.wrong_kind", text, "@entryName", reference.entry_name)
        if reference.catalog_name in names:
            hint = nearest(reference.entry_name, entries) or f"it has: {listed(sorted(set(entries)))}"
            text = f"catalogue '{reference.catalog_name}' has no such entry"
            raise CatalogError("catalog.unknown_entry", text, "@entryName", reference.entry_name, hint)
        known = sorted(set(names))
        seen = f"found: {listed(known)}" if known else "no catalogue found there"
        hint = nearest(reference.catalog_name, known) or seen
        raise CatalogError(
            "catalog.unknown", "no such catalogue in the CatalogLocations", "@catalogName", reference.catalog_name, hint
        )

    def _candidates(self, name: str, kinds: Sequence[str]) -> list[Path]:
        """Files to look into: of the kind asked for first, named like the catalogue first."""
        folders: list[Path] = []
        problem: CatalogError | None = None
        ordered = sorted(self.locations, key=lambda location: location[0] not in kinds)
        for kind, written, at in ordered:
            try:
                folders.append(self.roots.find(written, self.base, folder=True))
            except PathError as error:
                if kind in kinds and problem is None:
                    problem = CatalogError(error.code, error.text, "@path", written, error.hint, at)
        if problem is not None and not folders:
            raise problem
        files: dict[Path, None] = {}
        for folder in dict.fromkeys(folders):
            found = [name for name in os.listdir(folder) if name.endswith(".xosc")][:_MOST_FILES]
            for file in sorted(found, key=lambda file: (file != f"{name}.xosc", file)):
                try:
                    files[self.roots.find(file, folder)] = None
                except PathError:
                    continue  # a link that leaves the allowed folders, or a folder called x.xosc
        own = [path for path in files if path.stem == name]
        if problem is not None and not own:
            raise problem
        return own + [path for path in files if path.stem != name]

    def _document(self, path: Path) -> Document | ScenarioError:
        known = self.documents.get(path)
        if known is None:
            try:
                known = read_shared(path)
            except ScenarioError as error:
                known = error
            self.documents[path] = known
        return known


def read_shared(path: Path) -> Document:
    """An XML file that many scenarios read; parsed once as long as its bytes stay the same.

    Raises:
        ScenarioError: no such file, no XML.
    """
    data = read_bytes(path, str(path), MAX_BYTES)
    return _parsed(data, str(path)) if len(data) <= _SHARED_BYTES else parse_xml(data, str(path))


@functools.lru_cache(maxsize=16)
def _parsed(data: bytes, file: str) -> Document:
    return parse_xml(data, file)
