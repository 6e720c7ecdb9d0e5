"""Reading one element into its dataclass, by the plan of its class."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final

from openscenario.catalogs import CatalogError
from openscenario.expressions import ExpressionError
from openscenario.findings import ScenarioError, nearest
from openscenario.model.catalogs import CatalogReference
from openscenario.model.declarations import ParameterDeclaration
from openscenario.model.entities import Controller
from openscenario.model.global_actions import CustomCommandAction
from openscenario.model.kinds import At
from openscenario.model.storyboard import Action
from openscenario.parameters import BrokenParameter, Given, Scope, declare, resolve
from openscenario.plan import AttributePlan, ElementPlan, Leaf, Table, plan_of
from openscenario.read import assumed
from openscenario.read.checks import CHECKS
from openscenario.read.context import Context, Reference
from openscenario.values import BadValue
from openscenario.xml import Node

_SIMPLE_NAME: Final = re.compile(r"[\w .:+\-]{1,60}")
_DEEPEST_CATALOG: Final = 8  # catalogue entries that refer to catalogue entries
_UNKNOWN: Final = ""  # no field: a misspelt child was found, so that a missing one is no news
_NOTHING_GIVEN: Final[Mapping[str, Given]] = {}

Values = dict[str, Any]


class ElementReader:
    """Reads elements of one file; what is wrong goes to the context, and None comes back."""

    __slots__ = ("context", "file")

    def __init__(self, context: Context, file: str) -> None:
        self.context = context
        self.file = file

    def read(
        self,
        plan: ElementPlan,
        node: Node,
        scope: Scope,
        path: str,
        given: Mapping[str, Given] = _NOTHING_GIVEN,
    ) -> Any:
        """The element as an instance of the plan's class, or None if something in it is wrong.

        Args:
            path: of the element, for its findings and its `at`.
            given: values for the parameters that the element declares.
        """
        name = node.attributes.get("name")
        if name and _SIMPLE_NAME.fullmatch(name):
            path = f"{path}[{name}]"
        at = At(self.file, node.line, path)
        values: Values = {}
        if plan.declares:
            scope = self._declarations(plan, node, scope, path, given, values)
        whole = self._attributes(plan, node, scope, at, values)
        if plan.names and values.get("name"):
            self.context.names.setdefault(plan.names, []).append((values["name"], at))
        if plan.text_field:
            values[plan.text_field] = node.text.strip()
        elif node.text and not node.text.isspace():
            whole = self._stray_text(node, path)
        if node.children:
            whole = self._children(plan, plan.children, node, scope, path, values) and whole
        if plan.cls is Action and "action" not in values and whole:
            self.context.warning(
                "storyboard.empty_action", at, "", "the action is empty: it does nothing and ends at once"
            )
            values["action"] = CustomCommandAction("", at=at)  # the schemas up to 1.2 allow it, and files use it
        for field_name, wrapper, allowed in plan.required_children:
            if field_name not in values and not node.children and plan.cls in assumed.EMPTY:
                values[field_name] = []
                text = "the element is empty and does nothing"
                self.context.warning("xml.missing_element", at, "", text, allowed=allowed)
            elif not values.get(field_name):
                whole = False
                if field_name not in values and _UNKNOWN not in values:
                    self._missing_child(node, at, wrapper, allowed)
        if not whole:
            return None
        for field_name in plan.unset:
            values.setdefault(field_name, None)
        element = plan.cls(at=at, **{key: tuple(v) if type(v) is list else v for key, v in values.items()})
        for check in CHECKS.get(plan.cls, ()):
            check(element, self.context)
        return element

    def _attributes(self, plan: ElementPlan, node: Node, scope: Scope, at: At, values: Values) -> bool:
        whole = True
        known = plan.attributes
        for name, raw in node.attributes.items():
            attribute = known.get(name)
            if attribute is None:
                whole = self._unknown_attribute(plan, node, at, name) and whole
                continue
            text = raw
            if plan.cls is ParameterDeclaration and name == "name" and raw.startswith("$") and raw != "$":
                text = raw.removeprefix("$")  # as before 1.0; what refers to it means this one
                self.context.warning(
                    "param.name", at, "@name", "a parameter is declared without the $ that refers to it", found=raw
                )
            elif "$" in raw and not attribute.raw:
                resolved = self._resolved(attribute, raw if attribute.text else raw.strip(), scope, at)
                if resolved is None:
                    whole = False
                    values[attribute.field] = None
                    continue
                text = self._meant(attribute, raw, resolved, at)
            try:
                values[attribute.field] = attribute.convert(text)
            except BadValue as error:
                if self._assumed(attribute, text, at, name, values):
                    continue
                whole = False
                values[attribute.field] = None
                hint = nearest(text, attribute.allowed) if attribute.allowed else ""
                if "$" in text and text == raw:
                    hint = "calculations are written ${...}"
                found = (text if text == raw else f"{raw} = {text}") or "nothing"
                self.context.error(
                    error.code, at, f"@{name}", error.text, found=found, allowed=error.allowed, hint=hint
                )
                continue
            if attribute.ref is not None:
                self.context.references.append(Reference(attribute.ref, text, at, name, _origin(raw, text, scope, at)))
        for field_name, name in plan.required_attributes:
            if field_name not in values:
                whole = self._without(plan, field_name, name, at, values) and whole
        return whole

    def _unknown_attribute(self, plan: ElementPlan, node: Node, at: At, name: str) -> bool:
        """Note an attribute that is not in the standard; True if the element can be read without it."""
        known = plan.attributes
        hint = nearest(name, [each for each in known if each not in node.attributes])
        harmless = not hint and issubclass(plan.cls, assumed.DESCRIBING)
        text = "unknown attribute, left out" if harmless else "unknown attribute"
        allowed = ", ".join(sorted({entry.name for entry in known.values()})) or "no attribute"
        note = self.context.warning if harmless else self.context.error
        note("xml.unknown_attribute", at, f"@{name}", text, found=name, allowed=allowed, hint=hint)
        return harmless

    def _assumed(self, attribute: AttributePlan, text: str, at: At, name: str, values: Values) -> bool:
        """Take a text that is no value for what alone it can mean, with a warning; False if there is no such thing."""
        word = assumed.meant(attribute, text)
        if word is not None:
            values[attribute.field] = attribute.convert(word)
            said = f"taken for {word}: words are written in this case"
            self.context.warning("value.letter_case", at, f"@{name}", said, found=text)
            return True
        if attribute.optional and text.strip() in assumed.NOT_GIVEN:
            said = "an optional attribute without a value is left out"
            self.context.warning("value.not_given", at, f"@{name}", said, found=text or "nothing")
            return True
        return False

    def _without(self, plan: ElementPlan, field_name: str, name: str, at: At, values: Values) -> bool:
        """Note a missing attribute; True if it is known what it would be."""
        text = assumed.WITHOUT.get(plan.cls, {}).get(name)
        if text is None:
            self.context.error("xml.missing_attribute", at, f"@{name}", "a required attribute is missing", allowed=name)
            return False
        values[field_name] = plan.attributes[name].convert(text)
        said = f"a required attribute is missing, taken for '{text}'" if text else "a required attribute is missing"
        self.context.warning("xml.missing_attribute", at, f"@{name}", said, allowed=name)
        return True

    def _resolved(self, attribute: AttributePlan, raw: str, scope: Scope, at: At) -> str | None:
        try:
            text = resolve(raw, scope.text, as_text=attribute.text)
            # `${1 and 1}` is a truth value; where a number is wanted it counts as one
            return {"true": "1", "false": "0"}.get(text, text) if attribute.number else text
        except ExpressionError as error:
            self.context.error(error.code, at, f"@{attribute.name}", error.text, found=raw, hint=error.hint)
        except BrokenParameter:
            pass  # its declaration has the finding
        return None

    def _meant(self, attribute: AttributePlan, raw: str, resolved: str, at: At) -> str:
        """The name that a reference to a parameter means: `parameterRef="$v"` is often written for `v` itself."""
        names = [name for name, _ in self.context.names.get("parameter", ())]
        if attribute.ref != "parameter" or resolved in names or raw[1:] not in names:
            return resolved
        text = "a parameter is named here without the $ that stands for its value"
        self.context.warning("param.name", at, f"@{attribute.name}", text, found=raw)
        return raw[1:]

    def _declarations(
        self,
        plan: ElementPlan,
        node: Node,
        scope: Scope,
        path: str,
        given: Mapping[str, Given],
        values: Values,
    ) -> Scope:
        raw: list[ParameterDeclaration] = []
        row = plan_of(ParameterDeclaration)
        for group in node.children:
            if group.tag == "ParameterDeclarations":
                below = f"{path}/ParameterDeclarations"
                for child in group.children:
                    if child.tag == "ParameterDeclaration":
                        declaration = self.read(row, child, scope, f"{below}/ParameterDeclaration")
                        if declaration is not None:
                            raw.append(declaration)
        # what a controller's parameters mean is between the file and its tool
        declared, scope = declare(raw, scope, given, self.context.findings, strict=plan.cls is not Controller)
        if declared:
            values["parameter_declarations"] = declared
        return scope

    def _children(self, plan: ElementPlan, table: Table, node: Node, scope: Scope, path: str, values: Values) -> bool:
        whole = True
        for child in node.children:
            tag = child.tag
            entry = table.get(tag)
            below = f"{path}/{tag}"
            if isinstance(entry, Leaf):
                if entry.field == "parameter_declarations":
                    continue  # read before everything else, as it opens the scope
                value: Any = (
                    self.read(entry.plan, child, scope, below)
                    if entry.variants is None
                    else self._catalog_entry(entry, child, scope, below)
                )
                whole = self._fill(entry, value, child, below, values) and whole
            elif entry is not None:
                if child.attributes:
                    whole = False
                    name = next(iter(child.attributes))
                    at = At(self.file, child.line, below)
                    self.context.error("xml.unknown_attribute", at, f"@{name}", "unknown attribute", found=name)
                if child.text and not child.text.isspace():
                    whole = self._stray_text(child, below)
                if not child.children and tag in plan.choices and plan.cls is not Action:
                    whole = False
                    values[_UNKNOWN] = True
                    self._missing_child(child, At(self.file, child.line, below), "", ", ".join(sorted(entry)))
                whole = self._children(plan, entry, child, scope, below, values) and whole
            elif plan.cls is CustomCommandAction:
                text = "an element in a command, left out: no command is carried out"
                self.context.warning("xml.unknown_element", At(self.file, child.line, below), "", text, found=tag)
            else:
                whole = False
                values[_UNKNOWN] = True
                self.context.error(
                    "xml.unknown_element",
                    At(self.file, child.line, below),
                    "",
                    "unknown element here",
                    found=tag,
                    allowed=", ".join(sorted(table)) or "nothing",
                    hint=nearest(tag, table),
                )
        return whole

    def _fill(self, entry: Leaf, value: Any, child: Node, path: str, values: Values) -> bool:
        if entry.many:
            values.setdefault(entry.field, [])
            if value is not None and values[entry.field] is not None:
                values[entry.field].append(value)
            return value is not None
        if entry.field in values:
            self.context.error(
                "xml.too_many",
                At(self.file, child.line, path),
                "",
                "only one element of its kind may stand here",
                found=child.tag,
            )
            return False
        values[entry.field] = value
        return value is not None

    def _stray_text(self, node: Node, path: str) -> bool:
        at, found = At(self.file, node.line, path), " ".join(node.text.split())
        self.context.error(
            "xml.unexpected_text", at, "", "text where only elements belong", found=found, allowed="none"
        )
        return False

    def _missing_child(self, node: Node, at: At, wrapper: str, allowed: str) -> None:
        inside = node.find(wrapper) if wrapper else None
        if inside is not None:
            at = At(self.file, inside.line, f"{at.element}/{wrapper}")
        self.context.error("xml.missing_element", at, "", "a required element is missing", allowed=allowed)

    def _catalog_entry(self, leaf: Leaf, node: Node, scope: Scope, path: str) -> Any:
        reference: CatalogReference | None = self.read(leaf.plan, node, scope, path)
        context = self.context
        if reference is None or context.catalogs is None or leaf.variants is None:
            return None
        if context.nested_catalogs >= _DEEPEST_CATALOG:
            context.error("catalog.too_deep", reference.at, "", "catalogue entries refer to each other too deep")
            return None
        try:
            entry = context.catalogs.entry(reference, tuple(leaf.variants))
        except CatalogError as error:
            at = error.at or reference.at
            found, allowed, hint = error.found, error.allowed, error.hint
            context.error(error.code, at, error.attribute, error.text, found=found, allowed=allowed, hint=hint)
            return None
        except ScenarioError as error:
            context.findings.found.extend(error.findings)
            return None
        given = self._assignments(reference, entry.node)
        context.nested_catalogs += 1
        try:
            inner = ElementReader(context, entry.file)
            around = Scope(lent=self._lender(reference, scope, given))
            return inner.read(leaf.variants[entry.node.tag], entry.node, around, entry.element, given)
        finally:
            context.nested_catalogs -= 1

    def _lender(
        self, reference: CatalogReference, scope: Scope, given: Mapping[str, Given]
    ) -> Callable[[str], str | None]:
        """Values for parameters that an entry uses and does not declare: assigned ones, then the scenario's."""

        def lend(name: str) -> str | None:
            try:
                text = given[name].value if name in given else scope.text(name)
            except ExpressionError:
                return None
            self.context.warning(
                "parameters.valid_parameter_declaration_in_catalogs",
                reference.at,
                "",
                f"entry '{reference.entry_name}' uses parameter '${name}' without declaring it",
            )
            return text

        return lend

    def _assignments(self, reference: CatalogReference, entry: Node) -> dict[str, Given]:
        group = entry.find("ParameterDeclarations")
        names = [] if group is None else [child.get("name").removeprefix("$") for child in group.children]
        given: dict[str, Given] = {}
        for assignment in reference.parameter_assignments:
            name = assignment.parameter_ref.removeprefix("$")
            if name not in names:
                self.context.warning(
                    "param.undefined",
                    assignment.at,
                    "@parameterRef",
                    f"entry '{reference.entry_name}' declares no such parameter, the value has no effect",
                    found=name,
                    allowed=", ".join(names) or "none",
                    hint=nearest(name, names),
                )
            elif name in given:
                text, line = "the parameter is given two values", place.line if (place := given[name].at) else 0
                self.context.error(
                    "name.duplicate", assignment.at, "@parameterRef", text, found=name, hint=f"in line {line}"
                )
            given[name] = Given(assignment.value, assignment.at)
        return given


def _origin(raw: str, text: str, scope: Scope, at: At) -> str:
    """`from $owner, line 76`, of a value that is not written where it is used."""
    if raw == text:
        return ""
    place = scope.place(raw[1:])
    if place is None:
        return f"from {raw}"
    return f"from {raw}, line {place.line}" + (f" of {Path(place.file).name}" if place.file != at.file else "")
