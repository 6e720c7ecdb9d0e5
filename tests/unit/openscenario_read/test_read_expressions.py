"""Expressions: values against arithmetic done by hand, and every limit."""

from __future__ import annotations

import math

import pytest

from openscenario.expressions import MAX_DEPTH, ExpressionError, Value, concatenate, evaluate

PARAMETERS: dict[str, Value] = {"a": 6.0, "b": -4.0, "yes": True}


def value(expression: str) -> Value:
    return evaluate(expression, PARAMETERS.__getitem__)


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        ("1 + 2 * 3", 7.0),
        ("(1 + 2) * 3", 9.0),
        ("2 - 3 - 4", -5.0),
        ("24 / 4 / 2", 3.0),
        ("7 % 4", 3.0),
        ("-7 % 4", -3.0),  # sign of the dividend, as C's fmod
        ("2 * -3", -6.0),
        ("--3", 3.0),
        ("$a / 3.6", 6.0 / 3.6),
        ("$a*$b", -24.0),
        ("1.5e2 + .5", 150.5),
        ("round(2.5)", 3.0),
        ("round(-2.5)", -3.0),
        ("floor(-1.2)", -2.0),
        ("ceil(1.2)", 2.0),
        ("sqrt(9)", 3.0),
        ("pow(2, 10)", 1024.0),
        ("abs(-3)", 3.0),
        ("2 * pi + e", math.tau + math.e),
        ("2e1 * e", 20.0 * math.e),
        ("sign(-8) + sign(0) + sign(9)", 0.0),
        ("min(3, 4) + max(3, 4)", 7.0),
        ("sin(pi / 2) + cos(0)", 2.0),
        ("atan(tan(0.3))", 0.3),
        ("acos(0.5)", math.pi / 3),
    ],
)
def test_arithmetic(expression: str, expected: float) -> None:
    assert value(expression) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        ("1 and 0", False),
        ("1 or 0 and 0", True),  # `and` binds stronger
        ("not 0", True),
        ("not $yes or 1", True),
        ("not not 1", True),
        ("2 < 3", True),
        ("$a == 6", True),
        ("true and false", False),
    ],
)
def test_logic(expression: str, expected: bool) -> None:
    assert value(expression) is expected


@pytest.mark.parametrize(
    ("expression", "code"),
    [
        ("1 / 0", "expr.division_by_zero"),
        ("1 % 0", "expr.division_by_zero"),
        ("pow(0, -1)", "expr.undefined"),
        ("sqrt(-1)", "expr.undefined"),
        ("acos(2)", "expr.undefined"),
        ("pow(9, pow(9, pow(9, 9)))", "expr.overflow"),
        ("1e15 * 2", "expr.overflow"),
        ("1e400", "expr.overflow"),
        ("", "expr.syntax"),
        ("1 +", "expr.syntax"),
        ("(1", "expr.syntax"),
        ("1 2", "expr.syntax"),
        ("2 ^ 3", "expr.syntax"),
        ("pow(1)", "expr.syntax"),
        ("1_000", "expr.syntax"),
        ("__import__('os')", "expr.syntax"),
        ("__import__(1)", "expr.unknown_name"),
        ("powerer(2, 3)", "expr.unknown_name"),
        ("(" * 5000 + "1", "expr.too_long"),
    ],
)
def test_what_is_no_value_says_why(expression: str, code: str) -> None:
    with pytest.raises(ExpressionError) as caught:
        value(expression)
    assert caught.value.code == code


def test_depth_is_limited_at_the_stated_depth() -> None:
    inside = MAX_DEPTH - 1  # the expression itself is the first level
    assert value("(" * inside + "1" + ")" * inside) == 1.0
    with pytest.raises(ExpressionError) as caught:
        value("(" * MAX_DEPTH + "1" + ")" * MAX_DEPTH)
    assert caught.value.code == "expr.too_deep"


def test_a_misspelt_function_gets_the_nearest_name() -> None:
    with pytest.raises(ExpressionError) as caught:
        value("squirt(9)")
    assert "sqrt" in caught.value.hint


def test_words_and_parameters_joined_by_plus_make_a_text() -> None:
    assert concatenate("Brake_HWT + _ + $h", {"h": "0.7"}.__getitem__) == "Brake_HWT_0.7"


@pytest.mark.parametrize("expression", ["f(x)", "1 * 2", "a -b", "+"])
def test_other_expressions_make_no_text(expression: str) -> None:
    assert concatenate(expression, str) is None
