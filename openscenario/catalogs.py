"""Catalogues: finding the file and the entry that a CatalogReference names, inside the allowed folders."""

from __future__ import annotations

import functools
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from openscenario.findings import ScenarioError, listed, nearest
from openscenario.model.catalogs import CatalogLocations, CatalogReference
from openscenario.model.kinds import At
from openscenario.paths import PathError, Roots
from openscenario.xml import Document, Node, parse_xml, read_bytes

KINDS: Final = ("Vehicle", "Controller", "Pedestrian", "MiscObject", "Environment", "Maneuver", "Trajectory", "Route")
_SHARED_BYTES: Final = 1 << 20  # larger files are not kept in memory
_MOST_FILES: Final = 1_000  # catalogue files looked at in one folder


class CatalogError(ValueError):
    """A reference leads nowhere; the fields go into the finding. `at` is where, if not at the reference."""

    def __init__(
        self,
        code: str,
        text: str,
        attribute: str = "",
        found: str = "",
        hint: str = "",
        at: At | None = None,
        allowed: str = "",
    ) -> None:
        super().__init__(text)
        self.code = code
        self.text = text
        self.attribute = attribute
        self.found = found
        self.hint = hint
        self.at = at
        self.allowed = allowed


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
    found: dict[str, Path | PathError] = field(default_factory=dict)  # what written paths lead to

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
            CatalogError: no such catalogue or entry (with the nearest name), two of the name, a path that leaves the
                allowed folders.
            ScenarioError: the catalogue's file is no XML, or there is no such catalogue but a file that is none.
        """
        names: list[str] = []
        entries: list[str] = []
        wrong_kind = ""
        broken: ScenarioError | None = None
        for path in self._candidates(reference.catalog_name, kinds):
            document = self._document(path)
            if isinstance(document, ScenarioError):
                if path.stem == reference.catalog_name:
                    raise document
                broken = broken or document
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
                            _only_one(catalog, node, document.file)
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
        if broken is not None and not nearest(reference.catalog_name, known):
            raise broken  # it may be in the file that cannot be read
        seen = f"found: {listed(known)}" if known else "no catalogue found there"
        hint = nearest(reference.catalog_name, known) or seen
        raise CatalogError(
            "catalog.unknown", "no such catalogue in the CatalogLocations", "@catalogName", reference.catalog_name, hint
        )

    def _candidates(self, name: str, kinds: Sequence[str]) -> Iterator[Path]:
        """Files to look into: named like the catalogue first, of the kind asked for first."""
        folders, problem = self._folders(kinds)
        for folder in folders:
            path = self._file(f"{name}.xosc", folder)
            if path is not None:
                yield path
                problem = None
        if problem is not None:
            raise problem  # the catalogue is not in the folders that can be reached, and this one cannot
        for folder in folders:
            for file in sorted(os.listdir(folder))[:_MOST_FILES]:
                path = self._file(file, folder) if file.endswith(".xosc") and file != f"{name}.xosc" else None
                if path is not None:
                    yield path

    def _folders(self, kinds: Sequence[str]) -> tuple[list[Path], CatalogError | None]:
        """Folders that can be reached, of the kinds first, and what is wrong with the first that cannot."""
        folders: dict[Path, None] = {}
        problem: CatalogError | None = None
        for kind, written, at in sorted(self.locations, key=lambda location: location[0] not in kinds):
            if written not in self.found:
                try:
                    self.found[written] = self._folder(written)
                except PathError as error:
                    self.found[written] = error
            found = self.found[written]
            if isinstance(found, Path):
                folders[found] = None
            elif kind in kinds and problem is None:
                problem = CatalogError(found.code, found.text, "@path", written, found.hint, at, found.allowed)
        return list(folders), problem

    def _folder(self, written: str) -> Path:
        """The folder that a Directory names; openPASS writes the path of the catalogue file, whose folder is meant."""
        try:
            return self.roots.find(written, self.base, folder=True)
        except PathError as error:
            if error.code != "path.not_a_file":
                raise
            return self.roots.find(written, self.base).parent

    def _file(self, name: str, folder: Path) -> Path | None:
        key = f"{folder}{os.sep}{name}"
        if key not in self.found:
            try:
                self.found[key] = self.roots.find(name, folder)
            except PathError as error:  # missing, a link that leaves the allowed folders, a folder called x.xosc
                self.found[key] = error
        found = self.found[key]
        return found if isinstance(found, Path) else None

    def _document(self, path: Path) -> Document | ScenarioError:
        known = self.documents.get(path)
        if known is None:
            try:
                known = read_shared(path)
            except ScenarioError as error:
                known = error
            self.documents[path] = known
        return known


def _only_one(catalog: Node, entry: Node, file: str) -> None:
    """Raises CatalogError at a second entry of that name and kind."""
    name = entry.get("name")
    for other in catalog.children:
        if other is not entry and other.tag == entry.tag and other.get("name") == name:
            at = At(file, other.line, f"OpenSCENARIO/Catalog/{other.path.rpartition('/')[2]}")
            text, hint = "two entries of the catalogue have one name", f"the first is in line {entry.line}"
            code = "reference_control.uniquely_resolvable_entity_references"
            raise CatalogError(code, text, "@name", name, hint, at)


def read_shared(path: Path) -> Document:
    """An XML file that many scenarios read; parsed once as long as its bytes stay the same.

    Raises:
        ScenarioError: no such file, no XML.
    """
    data = read_bytes(path, str(path))
    return _parsed(data, str(path)) if len(data) <= _SHARED_BYTES else parse_xml(data, str(path))


@functools.lru_cache(maxsize=16)
def _parsed(data: bytes, file: str) -> Document:
    return parse_xml(data, file)
