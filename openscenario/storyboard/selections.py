"""Entity selections: which entities stand behind a name."""

from __future__ import annotations

from openscenario import model


def selections(scenario: model.Scenario) -> dict[str, tuple[str, ...]]:
    """Selection name -> names of its members."""
    found: dict[str, tuple[str, ...]] = {}
    for selection in scenario.entity_selections:
        names: list[str] = []
        for member in selection.members:
            if isinstance(member, model.EntityRef):
                names.append(member.entity_ref)
            else:
                wanted = "misc" if member.object_type == "miscellaneous" else member.object_type
                names.extend(each.name for each in scenario.entities if each.kind == wanted)
        found[selection.name] = tuple(dict.fromkeys(names))
    return found
