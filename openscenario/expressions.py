"""`${...}` expressions: an own small parser with limits on length, depth and magnitude. No eval.

Operators by rising precedence: `or`, `and`, `not`, comparisons, `+ -`, `* / %`, sign, calls. Logic yields truth.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from typing import Final, TypeAlias

from openscenario.findings import nearest

MAX_LENGTH: Final = 4_000  # characters of one expression
MAX_DEPTH: Final = 50  # nested parentheses, calls, signs
MAX_MAGNITUDE: Final = 1e15  # beyond this no figure of a scenario means anything

Value: TypeAlias = float | bool
Lookup: TypeAlias = Callable[[str], Value]

_TOKEN: Final = re.compile(
    r"\s*(?:(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)|(?P<parameter>\$[A-Za-z_]\w*)|(?P<word>[A-Za-z_]\w*)"
    r"|(?P<sign><=|>=|==|!=|[-+*/%(),<>]))"
)


class ExpressionError(ValueError):
    """An expression cannot be computed; `code` and `hint` go into the finding."""

    def __init__(self, code: str, text: str, hint: str = "") -> None:
        super().__init__(text)
        self.code = code
        self.text = text
        self.hint = hint


def evaluate(expression: str, lookup: Lookup) -> Value:
    """The value of what stands between `${` and `}`; `lookup` gives the value of a parameter by its name without `$`.

    Raises:
        ExpressionError: not an expression, too long or deep, division by zero, undefined, beyond 1e15.
    """
    parser = _Parser(expression, lookup)
    value = parser.disjunction()
    parser.expect_end()
    return value


def concatenate(expression: str, texts: Callable[[str], str]) -> str | None:
    """Text for a string attribute, `${Brake_ + $name}`: words, numbers and parameters joined by `+`; else None.

    The standard has no such operator; esmini and files written for it do.
    """
    parts = [part.strip() for part in expression[:MAX_LENGTH].split("+")]
    if any(not re.fullmatch(r"\$?[A-Za-z_]\w*|\d+(?:\.\d*)?", part) for part in parts):
        return None
    return "".join(texts(part[1:]) if part.startswith("$") else part for part in parts)


class _Parser:
    __slots__ = ("depth", "lookup", "position", "tokens")

    def __init__(self, expression: str, lookup: Lookup) -> None:
        self.tokens = _tokens(expression)
        self.position = 0
        self.depth = 0
        self.lookup = lookup

    def peek(self) -> str:
        return self.tokens[self.position]

    def take(self) -> str:
        token = self.tokens[self.position]
        self.position += 1
        return token

    def accept(self, *wanted: str) -> str:
        return self.take() if self.peek() in wanted else ""

    def expect(self, token: str) -> None:
        if not self.accept(token):
            found = self.peek() or "the end"
            raise ExpressionError("expr.syntax", f"'{token}' expected, '{found[:40]}' found")

    def expect_end(self) -> None:
        if self.peek():
            raise ExpressionError("expr.syntax", f"unexpected '{self.peek()[:40]}'")

    def disjunction(self) -> Value:
        self.depth += 1
        if self.depth > MAX_DEPTH:
            raise ExpressionError("expr.too_deep", f"nested deeper than {MAX_DEPTH}")
        value = self.conjunction()
        while self.accept("or"):
            other = self.conjunction()
            value = bool(value) or bool(other)
        self.depth -= 1
        return value

    def conjunction(self) -> Value:
        value = self.negation()
        while self.accept("and"):
            other = self.negation()
            value = bool(value) and bool(other)
        return value

    def negation(self) -> Value:
        inverted = False
        found = False
        while self.accept("not"):
            inverted, found = not inverted, True
        value = self.comparison()
        return bool(value) != inverted if found else value

    def comparison(self) -> Value:
        value = self.sum()
        while operator := self.accept("<", "<=", ">", ">=", "==", "!="):
            value = _COMPARE[operator](float(value), float(self.sum()))
        return value

    def sum(self) -> Value:
        value = self.product()
        while operator := self.accept("+", "-"):
            other = float(self.product())
            value = _bounded(float(value) + other if operator == "+" else float(value) - other)
        return value

    def product(self) -> Value:
        value = self.factor()
        while operator := self.accept("*", "/", "%"):
            other = float(self.factor())
            if operator == "*":
                value = _bounded(float(value) * other)
                continue
            if other == 0.0:
                raise ExpressionError("expr.division_by_zero", "division by zero")
            value = _bounded(float(value) / other if operator == "/" else math.fmod(float(value), other))
        return value

    def factor(self) -> Value:
        sign = 1.0
        found = False
        while operator := self.accept("-", "+"):
            found = True
            sign = -sign if operator == "-" else sign
        value = self.primary()
        return sign * float(value) if found else value

    def primary(self) -> Value:
        token = self.take() if self.peek() else ""
        if token == "(":
            value = self.disjunction()
            self.expect(")")
            return value
        if not token:
            raise ExpressionError("expr.syntax", "the expression ends too soon")
        if token[0] == "$":
            return self.lookup(token[1:])
        if token[0].isdigit() or token[0] == ".":
            return _bounded(float(token))
        if self.accept("("):
            return self.call(token)
        if token in _CONSTANTS:
            return _CONSTANTS[token]
        raise _unknown(token)

    def call(self, name: str) -> Value:
        arguments = [float(self.disjunction())]
        while self.accept(","):
            arguments.append(float(self.disjunction()))
        self.expect(")")
        entry = _FUNCTIONS.get(name)
        if entry is None:
            raise _unknown(name)
        count, function = entry
        if len(arguments) != count:
            raise ExpressionError("expr.syntax", f"{name} takes {count} argument(s), {len(arguments)} given")
        try:
            return _bounded(function(*arguments))
        except OverflowError:
            raise ExpressionError("expr.overflow", f"{name} exceeds {MAX_MAGNITUDE:g}") from None
        except ZeroDivisionError:
            raise ExpressionError("expr.division_by_zero", f"{name} divides by zero") from None
        except ValueError:
            raise ExpressionError("expr.undefined", f"{name} is not defined there") from None


def _tokens(expression: str) -> list[str]:
    if len(expression) > MAX_LENGTH:
        raise ExpressionError("expr.too_long", f"longer than {MAX_LENGTH} characters")
    tokens: list[str] = []
    position = 0
    end = len(expression.rstrip())
    while position < end:
        match = _TOKEN.match(expression, position)
        if match is None:
            raise ExpressionError("expr.syntax", f"'{expression[position:].strip()[:20]}' is no part of an expression")
        tokens.append(match.group().strip())
        position = match.end()
    tokens.append("")  # the end
    return tokens


def _bounded(value: float) -> float:
    if value != value:
        raise ExpressionError("expr.undefined", "the result is not a number")
    if not -MAX_MAGNITUDE <= value <= MAX_MAGNITUDE:
        raise ExpressionError("expr.overflow", f"the result exceeds {MAX_MAGNITUDE:g}")
    return value


def _unknown(name: str) -> ExpressionError:
    known = [*_FUNCTIONS, *_CONSTANTS, "and", "or", "not"]
    return ExpressionError("expr.unknown_name", f"unknown operator or function '{name[:40]}'", nearest(name, known))


def _round(x: float) -> float:
    return math.copysign(math.floor(abs(x) + 0.5), x)  # half away from zero, as C does


def _pow(x: float, y: float) -> float:
    return math.pow(x, y)  # on floats: overflows at once instead of computing a number of a billion digits


_COMPARE: Final[Mapping[str, Callable[[float, float], bool]]] = {
    "<": lambda a, b: a < b,
    "<=": lambda a, b: a <= b,
    ">": lambda a, b: a > b,
    ">=": lambda a, b: a >= b,
    "==": lambda a, b: a == b,
    "!=": lambda a, b: a != b,
}
_CONSTANTS: Final[Mapping[str, Value]] = {"pi": math.pi, "e": math.e, "true": True, "false": False}
_FUNCTIONS: Final[Mapping[str, tuple[int, Callable[..., float]]]] = {
    "round": (1, _round),
    "floor": (1, math.floor),
    "ceil": (1, math.ceil),
    "sqrt": (1, math.sqrt),
    "pow": (2, _pow),
    "abs": (1, abs),
    "sign": (1, lambda x: float((x > 0) - (x < 0))),
    "min": (2, min),
    "max": (2, max),
    "sin": (1, math.sin),
    "cos": (1, math.cos),
    "tan": (1, math.tan),
    "asin": (1, math.asin),
    "acos": (1, math.acos),
    "atan": (1, math.atan),
}
