"""Parameters: declarations, scopes, values given from outside, constraint groups, `$name` and `${...}`."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final, Unpack

from openscenario.expressions import ExpressionError, Value, concatenate, evaluate
from openscenario.findings import Details, Findings, Severity, listed, nearest
from openscenario.model.declarations import ParameterDeclaration, ValueConstraint
from openscenario.model.kinds import At
from openscenario.values import BadValue, check_type, spelled, to_bool, to_double

_COMPARE: Final[Mapping[str, Callable[[float, float], bool]]] = {
    "equalTo": lambda a, b: a == b,
    "notEqualTo": lambda a, b: a != b,
    "greaterThan": lambda a, b: a > b,
    "greaterOrEqual": lambda a, b: a >= b,
    "lessThan": lambda a, b: a < b,
    "lessOrEqual": lambda a, b: a <= b,
}
_SIGNS: Final[Mapping[str, str]] = {
    "equalTo": "=",
    "notEqualTo": "not",
    "greaterThan": ">",
    "greaterOrEqual": ">=",
    "lessThan": "<",
    "lessOrEqual": "<=",
}
_MOST_NESTED: Final = 50  # parameters that refer to parameters that refer to ...


class BrokenParameter(Exception):
    """The value depends on a declaration that was already found wrong: no second finding for it."""


@dataclass(frozen=True, slots=True)
class Given:
    """A value assigned to a parameter from elsewhere; `at` is the place of the assignment, if it has one."""

    value: str
    at: At | None = None


@dataclass(slots=True)
class Scope:
    """The parameters that can be seen from some element; None as text marks a declaration found wrong.

    `lent`: a last resort for names that are not declared: a catalogue entry that leans on the scenario around it.
    """

    parent: Scope | None = None
    texts: dict[str, str | None] = field(default_factory=dict)
    places: dict[str, At] = field(default_factory=dict)  # where each got its value
    lent: Callable[[str], str | None] | None = None

    def text(self, name: str) -> str:
        """The value of a parameter.

        Raises:
            ExpressionError: not declared (with the nearest name); BrokenParameter: declared wrongly.
        """
        scope: Scope | None = self
        while scope is not None:
            if name in scope.texts:
                text = scope.texts[name]
                if text is None:
                    raise BrokenParameter
                return text
            lent = scope.lent(name) if scope.lent is not None else None
            if lent is not None:
                return lent
            scope = scope.parent
        raise undefined(name, self.names())

    def place(self, name: str) -> At | None:
        """Where a parameter got its value: its declaration, or the assignment of a catalogue reference."""
        scope: Scope | None = self
        while scope is not None:
            if name in scope.texts:
                return scope.places.get(name)
            scope = scope.parent
        return None

    def names(self) -> list[str]:
        """All names that can be seen, sorted."""
        names: set[str] = set()
        scope: Scope | None = self
        while scope is not None:
            names.update(scope.texts)
            scope = scope.parent
        return sorted(names)


def undefined(name: str, names: Sequence[str]) -> ExpressionError:
    """The error for a parameter that nobody declares."""
    near = nearest(name, names).replace("'", "'$", 1)
    hint = near or (f"declared: {listed(['$' + known for known in names])}" if names else "none is declared here")
    return ExpressionError("param.undefined", f"parameter '${name[:60]}' is not declared", hint)


def resolve(raw: str, text_of: Callable[[str], str], *, as_text: bool = False) -> str:
    """An attribute's value with `$name` replaced or `${...}` computed; other text as it is.

    `as_text`: the attribute is a string, where `${word_ + $name}` joins texts.

    Raises:
        ExpressionError, BrokenParameter
    """
    if not raw.startswith("$") or len(raw) < 2:
        return raw
    if raw[1] != "{":
        name = raw[1:]
        return text_of(name) if name.isidentifier() else raw
    if not raw.endswith("}"):
        raise ExpressionError("expr.syntax", "the expression is not closed by '}'")
    inner = raw[2:-1]
    try:
        return spelled(evaluate(inner, lambda name: _number(name, text_of(name))))
    except ExpressionError as error:
        joined = concatenate(inner, text_of) if as_text and error.code in ("expr.unknown_name", "expr.type") else None
        if joined is None:
            raise
        return joined


def _number(name: str, text: str) -> Value:
    if text in ("true", "false"):
        return to_bool(text)
    try:
        return to_double(text)
    except BadValue as error:
        raise ExpressionError("expr.type", f"parameter '${name}' is {error.text}: '{text[:40]}'") from None


def declare(
    declarations: Sequence[ParameterDeclaration],
    parent: Scope | None,
    given: Mapping[str, Given],
    findings: Findings,
    *,
    strict: bool = True,
) -> tuple[tuple[ParameterDeclaration, ...], Scope]:
    """Values of the declarations as read (raw) in their scope, given ones in place of the declared.

    A declaration may refer to others of the same group and to outer ones; what is wrong becomes findings. Not `strict`:
    a value that does not fit its type is a warning, for parameters that nothing here computes with.
    An ExpressionError of one declaration becomes a finding, too.
    """
    scope = Scope(parent)
    by_name: dict[str, ParameterDeclaration] = {}
    for declaration in declarations:
        first = by_name.get(declaration.name)
        if first is not None:
            same = (first.value, first.parameter_type) == (declaration.value, declaration.parameter_type)
            text = "declared twice" + (", with the same value" if same else " with different values")
            found, hint = declaration.name, f"first declared in line {first.at.line}"
            severity: Severity = "warning" if same else "error"
            _add(findings, "name.duplicate", declaration.at, "@name", text, found=found, hint=hint, severity=severity)
        by_name.setdefault(declaration.name, declaration)
    open_names: list[str] = []
    cyclic: set[str] = set()

    def text_of(name: str) -> str:
        if name in by_name and name not in scope.texts:
            if name in open_names:
                cyclic.update(open_names[open_names.index(name) :])
                raise ExpressionError("param.cycle", f"parameter '${name}' depends on itself")
            if len(open_names) >= _MOST_NESTED:
                raise ExpressionError("param.too_deep", f"more than {_MOST_NESTED} parameters refer to one another")
            settle(by_name[name])
        if name not in by_name and parent is None:
            raise undefined(name, sorted(by_name))
        return scope.text(name)

    def settle(declaration: ParameterDeclaration) -> None:
        open_names.append(declaration.name)
        try:
            scope.places[declaration.name] = _given_at(given.get(declaration.name)) or declaration.at
            scope.texts[declaration.name] = _value(declaration, given.get(declaration.name), text_of, findings, strict)
        finally:
            open_names.pop()
        if declaration.name in cyclic and open_names == []:  # where the circle was entered; where it closes has one
            text = f"parameter '${declaration.name}' depends on itself"
            _add(findings, "param.cycle", declaration.at, "@value", text, found=declaration.value)

    settled = []
    for declaration in declarations:
        if declaration.name not in scope.texts:
            settle(declaration)
        groups = tuple(
            dataclasses.replace(
                group,
                value_constraints=tuple(
                    _constraint(c, declaration.parameter_type, text_of, findings) for c in group.value_constraints
                ),
            )
            for group in declaration.constraint_groups
        )
        settled_text = scope.texts[declaration.name]
        finished = dataclasses.replace(declaration, value=declaration.value if settled_text is None else settled_text)
        finished = dataclasses.replace(finished, constraint_groups=groups) if groups else finished
        if settled_text is not None and not allows(finished, settled_text):
            given_at = _given_at(given.get(declaration.name))
            _add(
                findings,
                "param.outside_constraint",
                given_at or declaration.at,
                "@value",
                f"the value of parameter '{declaration.name}' is outside its constraints",
                found=settled_text,
                allowed=constraints(finished),
            )
        settled.append(finished)
    return tuple(settled), scope


def allows(declaration: ParameterDeclaration, text: str) -> bool:
    """Whether a value meets all constraints of at least one group of its declaration."""
    groups = declaration.constraint_groups
    return not groups or any(all(_meets(text, c) for c in group.value_constraints) for group in groups)


def constraints(declaration: ParameterDeclaration) -> str:
    """The constraints as a message shows them: `>= 1 and <= 3 or = 7`."""
    return " or ".join(
        " and ".join(f"{_SIGNS[c.rule]} {c.value}" for c in group.value_constraints)
        for group in declaration.constraint_groups
    )


def _meets(text: str, constraint: ValueConstraint) -> bool:
    try:
        left, right = to_double(text), to_double(constraint.value)
    except BadValue:
        return {"equalTo": text == constraint.value, "notEqualTo": text != constraint.value}.get(constraint.rule, False)
    return _COMPARE[constraint.rule](left, right)


def _constraint(
    constraint: ValueConstraint, kind: str, text_of: Callable[[str], str], findings: Findings
) -> ValueConstraint:
    """The constraint with its value computed, which must be one of the parameter's type."""
    try:
        finished = constraint
        if "$" in constraint.value:
            finished = dataclasses.replace(constraint, value=resolve(constraint.value, text_of))
        check_type(finished.value, kind)
        return finished
    except ExpressionError as error:
        _add(findings, error.code, constraint.at, "@value", error.text, found=constraint.value, hint=error.hint)
    except BadValue as error:
        text, allowed = f"the constraint is {error.text}", f"{error.allowed} ({kind})"
        _add(findings, error.code, constraint.at, "@value", text, found=constraint.value or "nothing", allowed=allowed)
    except BrokenParameter:
        pass
    return constraint


def _value(
    declaration: ParameterDeclaration,
    given: Given | None,
    text_of: Callable[[str], str],
    findings: Findings,
    strict: bool,
) -> str | None:
    raw = declaration.value if given is None else given.value
    at = _given_at(given) or declaration.at
    text = raw
    try:
        text = resolve(raw, text_of, as_text=declaration.parameter_type == "string") if given is None else raw
        check_type(text, declaration.parameter_type)
    except ExpressionError as error:
        _add(findings, error.code, at, "@value", error.text, found=raw, hint=error.hint)
        return None
    except BadValue as error:
        where = f"the value of parameter '{declaration.name}' is {error.text}"
        allowed = f"{error.allowed} ({declaration.parameter_type})"
        found = (raw if raw == text else f"{raw} = {text}") or "nothing"
        severity: Severity = "error" if strict else "warning"
        _add(findings, error.code, at, "@value", where, found=found, allowed=allowed, severity=severity)
        return None if strict else text
    except BrokenParameter:
        return None
    return text


def _given_at(given: Given | None) -> At | None:
    return None if given is None else given.at


def _add(
    findings: Findings,
    code: str,
    at: At,
    attribute: str,
    text: str,
    **details: Unpack[Details],
) -> None:
    findings.add(code, at.file, at.line, at.element + attribute, text, **details)
