"""The second opinion on known columns and noise, against least squares of numpy with each block left out."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.diagnose import equation_error
from pytest_dvp.gap.diagnose.equation_error import Opinion, _gain, _Joint, _linear, _Table, opinions, votes
from pytest_dvp.gap.diagnose.regressors import Form
from pytest_dvp.logs.log_contents import FloatArray

N = 600
T = 0.1 * np.arange(N)  # 60 s: twelve blocks of 5 s, and the folds 0 1 2 3 4 0 1 2 3 4 0 1
FOLD = np.repeat([0, 1, 2, 3, 4, 0, 1, 2, 3, 4, 0, 1], 50)
RNG = np.random.default_rng(11)
A, B, C = np.sin(0.7 * T) + 0.2, np.cos(1.9 * T), 0.03 * T - 0.8
ROUGH = RNG.normal(size=N)


def seen(dv: FloatArray, ax: FloatArray | None = None, *, accel: FloatArray | None = None, rows: Any = None) -> Any:
    """Signals of a car without commands, of which all that is measured is left over."""
    every = np.arange(N) if rows is None else rows
    measured = {"dv": dv[every]} | ({} if ax is None else {"ax": ax[every]})
    return SimpleNamespace(t=T, rows=every, measured=measured, noise={"dv": 0.1, "ax": 0.4}, accel=accel, steer=None,
                           mean=lambda y: y[every])  # fmt: skip


def form(name: str, *columns: FloatArray, also: bool = False, needs: tuple[str, ...] = ()) -> Form:
    """Linear in its unknowns; `also`: in the accelerometer, too."""
    both = np.column_stack(columns)
    return Form(name, needs, lambda s, p: dict.fromkeys(("dv", "ax") if also else ("dv",), both[s.rows]))


def shaped(name: str, *grid: float) -> Form:
    """A p with which A is what is missing, and B besides."""
    return Form(name, (), lambda s, p: {"dv": (p * A)[s.rows], "none": (p * B)[s.rows]}, grid)


def taken(rest: FloatArray, columns: FloatArray, fold: FloatArray) -> float:
    """chi^2 that columns take away on each fold with what least squares finds on the others."""
    total = 0.0
    for k in range(5):
        out = fold == k
        theta = np.linalg.lstsq(columns[~out], rest[~out], rcond=None)[0]
        total += float(rest[out] @ rest[out] - np.sum((rest[out] - columns[out] @ theta) ** 2))
    return total


DV, AX = 0.5 * A + 0.1 * ROUGH, 0.5 * A + 0.4 * ROUGH[::-1]


def test_a_table_has_its_equations_in_units_of_their_noise_and_its_blocks_in_turn() -> None:
    table = _Table(seen(DV, AX))
    assert table.rest["dv"] == pytest.approx(10.0 * DV)
    assert table.rest["ax"] == pytest.approx(2.5 * AX)
    assert (table.fold == FOLD).all()
    assert table.count == 2 * N
    assert table.chi2 == pytest.approx(100.0 * DV @ DV + 6.25 * AX @ AX)
    assert (_Table(seen(DV, rows=np.arange(140, 160))).fold == [2] * 10 + [3] * 10).all()


def test_the_normal_equations_are_those_of_each_block_over_what_was_measured() -> None:
    table = _Table(seen(DV, AX))
    columns = {"dv": np.column_stack([A, B]), "ax": np.column_stack([B, C]), "r": np.column_stack([A, A])}
    found = table.sums(columns)
    assert found is not None
    for k in range(5):
        own = k == FOLD
        phi = np.concatenate([10.0 * columns["dv"][own], 2.5 * columns["ax"][own]])
        rest = np.concatenate([table.rest["dv"][own], table.rest["ax"][own]])
        assert found[0][k] == pytest.approx(phi.T @ phi)
        assert found[1][k] == pytest.approx(phi.T @ rest)
    assert table.sums({"r": A}) is None
    plain = table.sums({"dv": A})
    assert plain is not None
    assert plain[0].shape == (5, 1, 1)


def test_each_block_is_judged_with_what_the_others_have() -> None:
    columns = np.column_stack([A, B, C])
    rest = DV + 0.2 * C
    a = np.stack([columns[k == FOLD].T @ columns[k == FOLD] for k in range(5)])
    b = np.stack([columns[k == FOLD].T @ rest[k == FOLD] for k in range(5)])
    assert _linear(a, b) == pytest.approx(taken(rest, columns, FOLD), rel=1e-6)
    assert np.isfinite(_linear(0.0 * a, 0.0 * b))  # a column of noughts


def test_a_linear_form_gains_over_all_logs_that_have_what_it_needs() -> None:
    tables = [_Table(seen(DV, AX)), _Table(seen(0.3 * A, accel=A))]
    rest = np.concatenate([10.0 * DV, 2.5 * AX, 10.0 * (0.3 * A - A)])
    columns = np.concatenate([np.column_stack([A, B]) * scale for scale in (10.0, 2.5)])
    whole = np.concatenate([columns, 10.0 * np.column_stack([A, B])])
    gain = _gain(form("x", A, B, also=True), tables)
    assert gain == (pytest.approx(taken(rest, whole, np.tile(FOLD, 3)), rel=1e-6), 2)
    needing = _gain(form("x", A, needs=("accel",)), tables)
    assert needing == (pytest.approx(taken(rest[2 * N :], 10.0 * A[:, None], FOLD), rel=1e-6), 1)
    assert _gain(form("x", A, needs=("steer",)), tables) is None
    assert _gain(Form("x", (), lambda s, p: {"r": A}), tables) is None


RATIOS = (0.55, 0.75, 0.9, 1.1, 1.25, 1.6)


def test_of_a_grid_the_best_point_and_six_about_it_are_tried() -> None:
    """DV is 0.5 A: of 0.2, 0.4 and 0.8 the point 0.4 is best, and 1.25 of it is exact. In steps of 4 the six lie twice
    as far apart, and none is."""
    table = _Table(seen(0.5 * A))
    assert _gain(shaped("x", 0.2, 0.4, 0.8), [table]) == (pytest.approx(table.chi2), 1)
    wide = _gain(shaped("x", 0.1, 0.4, 1.6), [table])
    nearest = min([0.1, 0.4, 1.6, *(0.4 * ratio**2 for ratio in RATIOS)], key=lambda p: abs(p - 0.5))
    assert wide == (pytest.approx(table.chi2 - 100.0 * (0.5 - nearest) ** 2 * A @ A), 1)
    assert _gain(Form("x", (), lambda s, p: {"r": A}, (1.0, 2.0)), [table]) is None


@pytest.mark.parametrize(("target", "exact"), [*((ratio, True) for ratio in (1.0, *RATIOS)),
                                               (0.4, False), (0.65, False), (1.4, False), (2.0, False)])  # fmt: skip
def test_the_points_about_the_best_one(target: float, exact: bool) -> None:
    table = _Table(seen(target * A))
    gain = _gain(shaped("x", 1.0, 100.0, 200.0), [table])  # 1 is best, and the step is 2
    assert gain is not None
    assert (gain[0] > 0.99 * table.chi2) is exact


def test_a_block_is_judged_by_the_point_that_suits_the_others() -> None:
    size = np.where(FOLD == 2, 1.25, 1.0)
    size[FOLD == 4] = 0.75
    weights = [100.0 * float(A[k == FOLD] @ A[k == FOLD]) for k in range(5)]
    sizes = [1.0, 1.0, 1.25, 1.0, 0.75]
    points = (1.0, 100.0, 200.0, *RATIOS)
    taken_by = {p: [w * (2.0 * p * c - p * p) for w, c in zip(weights, sizes, strict=True)] for p in points}
    expected = 0.0
    for k in range(5):
        best = max(points, key=lambda p: sum(taken_by[p]) - taken_by[p][k])
        expected += taken_by[best][k]
    gain = _gain(shaped("x", 1.0, 100.0, 200.0), [_Table(seen(size * A))])
    assert gain == (pytest.approx(expected), 1)


# --- votes


@pytest.fixture
def engine(monkeypatch: pytest.MonkeyPatch) -> Any:
    """votes and opinions on given signals and forms, in a world of effects a, b, c and one of perception."""
    whole = SimpleNamespace(details="")
    effects = {
        name: SimpleNamespace(slot="perception" if name == "p" else "command", diagnosed=whole) for name in "abcp"
    }
    effects["fine b"] = SimpleNamespace(slot="perception", diagnosed=SimpleNamespace(details="b"))
    monkeypatch.setattr("vehicle.model.effect_catalogue.catalogue", lambda: effects)
    monkeypatch.setattr(equation_error, "signals", lambda log, model: log)

    def use(*forms: Form) -> None:
        monkeypatch.setattr(equation_error, "FORMS", forms)

    return use


BARE: Any = SimpleNamespace(effects=(), base="kinematic_bicycle")


def test_a_score_is_the_share_of_the_misfit_less_a_price_for_each_further_unknown(engine: Any) -> None:
    engine(form("a", A), form("b", A, B), form("c", C, needs=("accel",)))
    table = _Table(seen(DV))
    found = votes({"x": seen(DV)}, BARE)
    excess = table.chi2 - N
    one = taken(table.rest["dv"], 10.0 * A[:, None], FOLD) / excess
    two = taken(table.rest["dv"], 10.0 * np.column_stack([A, B]), FOLD) / excess - 0.004
    assert found == {"first": "a", "ranking": [["a", round(one, 4)], ["b", round(two, 4)]], "not_judged": ["c"]}


def test_of_equal_ones_the_first_by_name_leads_and_worse_than_nothing_is_below_nought(engine: Any) -> None:
    engine(form("b", A), form("a", A), form("c", RNG.normal(size=N) * np.where(FOLD == 1, 1e3, 1.0)))
    ranking = votes({"x": seen(DV)}, BARE)["ranking"]
    assert [name for name, _ in ranking] == ["a", "b", "c"]
    assert ranking[2][1] < 0.0


@pytest.mark.parametrize(("share", "named"), [(0.045, False), (0.056, True)])
def test_a_gain_below_a_twentieth_of_what_is_left_names_nothing(engine: Any, share: float, named: bool) -> None:
    """What is left is 900 of chi^2 in 600 equations."""
    engine(form("a", A))
    noise = ROUGH - (ROUGH @ A) / (A @ A) * A
    noise *= np.sqrt(900.0 / (noise @ noise))
    found = votes({"x": seen(0.1 * (noise + np.sqrt(share * 900.0 / (A @ A)) * A))}, BARE)
    assert (found["first"] == "a") is named


@pytest.mark.parametrize(("gain", "named"), [(26.0, False), (36.0, True)])
def test_of_data_without_noise_a_gain_counts_from_a_twentieth_of_the_equations(
    engine: Any, gain: float, named: bool
) -> None:
    engine(form("a", A))
    found = votes({"x": seen(0.1 * np.sqrt(gain / (A @ A)) * A)}, BARE)
    assert (found["first"] == "a") is named


def test_where_less_than_the_noise_is_left_gains_count_in_billionths_of_the_equations(engine: Any) -> None:
    engine(form("a", A), form("b", B))
    quiet = 0.05 * ROUGH + 0.01 * A
    ranking = dict(votes({"x": seen(quiet)}, BARE)["ranking"])
    for name, column in (("a", A), ("b", B)):
        assert ranking[name] == pytest.approx(taken(10.0 * quiet, 10.0 * column[:, None], FOLD) / (1e-9 * N), rel=1e-6)


@pytest.mark.parametrize(("gain", "ranked"), [(3.0, True), (np.nan, False), (np.inf, False)])
def test_a_gain_that_is_no_number_is_none(
    gain: float, ranked: bool, engine: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    engine(form("a", A))
    monkeypatch.setattr(equation_error, "_gain", lambda form, tables: (gain, 1))
    found = votes({"x": seen(DV)}, BARE)
    assert [name for name, _ in found["ranking"]] == (["a"] if ranked else [])
    assert found["not_judged"] == (["b", "c"] if ranked else ["a", "b", "c"])


@pytest.mark.parametrize("p", [0.5, 1.0, *(0.5 * r for r in (0.55, 0.75, 0.9)), *(1.0 * r for r in (1.1, 1.25, 1.6))])
def test_about_the_best_point_of_a_grid_six_more_are_tried(p: float) -> None:
    """At steps of a ratio of 2, what has one of these is explained wholly, what lies between leaves a rest."""
    gain = _gain(shaped("c", 0.5, 1.0), [_Table(seen(p * A))])
    assert gain is not None
    assert gain == (pytest.approx(100.0 * p * p * A @ A), 1)
    off = _gain(shaped("c", 0.5, 1.0), [_Table(seen(1.03 * p * A))])
    assert off is not None
    assert off[0] < 0.9995 * 100.0 * (1.03 * p) ** 2 * A @ A


@pytest.mark.parametrize(("rows", "judged"), [(49, False), (50, True)])
def test_a_log_of_fewer_than_50_rows_and_a_model_with_effects_are_not_judged(
    engine: Any, rows: int, judged: bool
) -> None:
    engine(form("a", A))
    few = seen(DV, rows=np.arange(0, 12 * rows, 12) % N)
    assert bool(votes({"x": few}, BARE)["ranking"]) is judged
    assert (opinions({"x": few}, BARE, {"a": {}})["a"].says != "silent") is judged
    rich: Any = SimpleNamespace(effects=("e",), base="kinematic_bicycle")
    assert votes({"x": seen(DV)}, rich) == {"first": None, "ranking": [], "not_judged": ["a", "b", "c"]}
    assert opinions({"x": seen(DV)}, rich, {"a": {}}) == {"a": Opinion()}


# --- opinions


def opinion(engine: Any, forms: list[Form], rest: FloatArray, named: dict[str, dict[str, float]], name: str) -> Opinion:
    engine(*forms)
    return opinions({"x": seen(rest)}, BARE, named)[name]


def test_it_agrees_with_what_takes_most_away_and_is_silent_on_what_it_has_no_equation_for(engine: Any) -> None:
    forms = [form("a", A), form("b", B)]
    assert opinion(engine, forms, DV, {"a": {}}, "a") == Opinion("agrees")
    assert opinion(engine, forms, DV, {"z": {}}, "z") == Opinion()
    assert opinion(engine, forms, 0.001 * A, {"a": {}}, "a") == Opinion()  # too little to tell


def test_it_would_rather_name_another_one_that_takes_away_more_of_the_same(engine: Any) -> None:
    """b is nearly a; what it takes away leaves nothing for a."""
    forms = [form("a", A + 0.8 * B), form("b", A)]
    assert opinion(engine, forms, 0.5 * A, {"a": {}}, "a") == Opinion("disagrees", "b")
    assert opinion(engine, forms, 0.5 * A, {"a": {}, "b": {}}, "a") == Opinion()  # b is named already


@pytest.mark.parametrize(("mine", "says"), [(11.0, "agrees"), (9.0, "disagrees")])
def test_another_one_must_take_away_more_by_what_names_an_effect(
    engine: Any, monkeypatch: pytest.MonkeyPatch, mine: float, says: str
) -> None:
    """b takes 40 off 600 equations, of which 5 % are 30; it is no rival of an effect that takes away 10 or more."""
    engine(form("a", A), form("b", A))
    joint = _Joint([_Table(seen(DV))], sideways=True)
    monkeypatch.setattr(joint, "_left_out", lambda rest, columns: 600.0)
    monkeypatch.setattr(joint, "_gain", lambda name, rest, beside, left: ({"a": mine, "b": 40.0}[name], 0.0))
    assert joint.opinion("a", {"a": {}}).says == says


def test_what_is_named_in_a_finer_form_or_moves_another_signal_is_no_rival(engine: Any) -> None:
    forms = [form("a", A + 0.8 * B), form("b", A)]
    assert opinion(engine, forms, 0.5 * A, {"a": {}, "fine b": {}}, "a") == Opinion("agrees")
    elsewhere = Form("b", (), lambda s, p: {"dv": 0.0 * A, "ax": A})
    engine(forms[0], elsewhere)
    joint = _Joint([_Table(seen(0.5 * A, AX))], sideways=True)
    assert joint._moves["a"] == {"dv"}
    assert joint._moves["b"] == {"ax"}
    assert joint._rivals("a", {"a": {}}) == ["a"]


def test_an_effect_that_explains_something_else_is_no_rival(engine: Any) -> None:
    forms = [form("a", B), form("b", A)]
    assert opinion(engine, forms, 0.5 * A + 0.2 * B, {"a": {}}, "a") == Opinion("agrees")


def test_what_else_is_named_is_taken_out_at_its_value_or_freed(engine: Any) -> None:
    forms = [form("a", B), form("b", A), shaped("c", 0.1, 0.2)]
    rest = 0.7 * A + 0.2 * B
    assert opinion(engine, forms[:2], rest, {"a": {}, "b": {"k": 9.0}}, "a") == Opinion("agrees")
    engine(*forms[::2])
    joint = _Joint([_Table(seen(rest))], sideways=True)
    assert joint.opinion("a", {"a": {}, "c": {"p": 0.7}}) == Opinion("agrees")
    left = joint._left_out(joint.rest - 0.7 * 10.0 * A, np.zeros((N, 0)))
    assert left == pytest.approx(100.0 * 0.04 * B @ B)


def test_columns_are_in_units_of_the_noise_and_nought_where_a_form_says_nothing(engine: Any) -> None:
    engine(form("a", A, B), Form("b", (), lambda s, p: {"r": A}), Form("c", (), lambda s, p: {"dv": 0.0 * A}))
    joint = _Joint([_Table(seen(DV, AX))], sideways=True)
    assert joint.count == 2 * N
    assert (joint.fold == np.tile(FOLD, 2)).all()
    found = joint.columns("a", 0.0)
    assert found is not None
    assert found[:N] == pytest.approx(10.0 * np.column_stack([A, B]))
    assert not found[N:].any()
    assert joint.columns("b", 0.0) is None
    assert joint.columns("c", 0.0) is None
    beyond = Form("d", (), lambda s, p: {"dv": np.full(N, np.inf)})
    assert joint._made(beyond, 0.0) is None
    assert joint._made(Form("e", (), lambda s, p: {}), 0.0) is None


def test_equations_of_the_steering_are_left_out_where_the_models_tyres_slip(engine: Any) -> None:
    engine(form("a", A), Form("b", ("steer",), lambda s, p: {"r": A}))
    s = seen(DV)
    s.measured["r"], s.noise["r"], s.steer = np.ones(N), 0.1, np.zeros(N)
    s.v, s.wheelbase = np.ones(N), 2.5
    with_them, without = _Joint([_Table(s)], sideways=True), _Joint([_Table(s)], sideways=False)
    assert (with_them.count, without.count) == (2 * N, N)
    assert (list(with_them.forms), list(without.forms)) == (["a", "b"], ["a"])


def test_a_form_of_a_grid_gains_what_its_best_point_takes_off_beside_the_others(engine: Any) -> None:
    engine(form("a", B), shaped("c", 0.25, 0.5, 1.0))
    joint = _Joint([_Table(seen(0.5 * A + 0.1 * B))], sideways=True)
    beside = 10.0 * B[:, None]
    left = joint._left_out(joint.rest, beside)
    assert left == pytest.approx(joint.rest @ joint.rest - taken(joint.rest, beside, FOLD), rel=1e-6)
    gain = joint._gain("c", joint.rest, beside, left)
    assert gain == (pytest.approx(left, rel=1e-4), 0.5)
    alone = joint._gain("a", joint.rest, np.zeros((N, 0)), joint.rest @ joint.rest)
    assert alone == (pytest.approx(taken(joint.rest, beside, FOLD), rel=1e-6), 0.0)
    behind = joint._beside("a", "c", 0.5, joint.rest, np.zeros((N, 0)))
    assert behind == pytest.approx(100.0 * 0.01 * B @ B, rel=1e-4)
    assert joint._beside("c", "a", 0.0, joint.rest, np.zeros((N, 0))) == pytest.approx(left, rel=1e-4)
