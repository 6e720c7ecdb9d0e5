"""PySINDy and gplearn on the missing inputs of the hidden laws; in an environment of their own.

    pip install pysindy gplearn
    python benchmarks/discover/peers.py residuals.npz [--only K/N]

Needs nothing of this project. The peers are told where the law acts, and are given its memories with one time constant.
A form is true if the answer consists of the hidden term alone; for gplearn, whose answers are trees, if the answer is
the hidden term to 1 % of its variance. `removed`: share of the variance of the missing input on the held-out drive.
"""

from __future__ import annotations

import argparse
import itertools
import json
import time

import numpy as np

ROWS = 1500  # of the fitted drive, evenly taken


def cases(file: str) -> dict[str, dict[str, dict[str, np.ndarray]]]:
    """case|form -> side -> feature -> values (n,)."""
    found: dict[str, dict[str, dict[str, np.ndarray]]] = {}
    with np.load(file) as data:
        for key in data.files:
            case, form, side, feature = key.split("|", 2)[0], *_rest(key)
            found.setdefault(f"{case}|{form}", {}).setdefault(side, {})[feature] = data[key]
    return found


def _rest(key: str) -> tuple[str, str, str]:
    tail = key.split("|", 1)[1]
    for side in ("fit", "held"):
        mark = f"|{side}|"
        if mark in tail:
            form, _, feature = tail.partition(mark)
            return form, side, feature
    raise ValueError(key)


def library(x: dict[str, np.ndarray]) -> tuple[list[str], np.ndarray]:
    """Products of up to three quantities, and of a memory with up to one: names and columns (n, m)."""
    names = [name for name in x if name != "u" and "lag" not in name]
    memories = [name for name in x if "lag" in name]
    terms = [t for n in (1, 2, 3) for t in itertools.combinations_with_replacement(names, n)]
    terms += [(*more, memory) for memory in memories for more in ((), *((name,) for name in names))]
    columns = [np.prod([x[name] for name in term], axis=0) for term in terms]
    return [" ".join(term) for term in terms], np.column_stack(columns)


def sindy(fit: dict[str, np.ndarray], held: dict[str, np.ndarray], kind: str) -> tuple[list[str], float]:
    """Terms that are left, and the share of the held-out variance that they explain."""
    import pysindy

    names, table = library(fit)
    size = np.sqrt(np.mean(table**2, axis=0)) + 1e-12
    optimizer = (
        pysindy.SSR(criteria="model_residual", kappa=1e-2)
        if kind == "SSR"
        else pysindy.STLSQ(threshold=0.1 * float(np.std(fit["u"])), alpha=1e-3)
    )
    optimizer.fit(table / size, fit["u"][:, None])
    coefficients = np.ravel(optimizer.coef_)
    chosen = [names[k] for k in np.flatnonzero(coefficients)]
    guess = (library(held)[1] / size) @ coefficients
    return chosen, explained(held["u"], guess)


def genetic(fit: dict[str, np.ndarray], held: dict[str, np.ndarray], form: str) -> tuple[str, float, bool]:
    """The expression, its share of the held-out variance, and whether it is the hidden term."""
    from gplearn.genetic import SymbolicRegressor

    names = [name for name in fit if name != "u"]
    a, b = (np.column_stack([x[name] for name in names]) for x in (fit, held))
    size = np.sqrt(np.mean(a**2, axis=0)) + 1e-12
    scale = float(np.std(fit["u"])) + 1e-12
    search = SymbolicRegressor(
        population_size=600, generations=12, function_set=("add", "sub", "mul"), random_state=0,
        parsimony_coefficient=0.005, feature_names=[f"x{k}" for k in range(len(names))],
    )  # fmt: skip
    search.fit(a / size, fit["u"] / scale)
    guess = search.predict(b / size) * scale
    true = False
    if form:
        term = np.prod([held[name] for name in split(form)], axis=0)
        true = bool(np.std(guess) > 0 and abs(np.corrcoef(term, guess)[0, 1]) ** 2 > 0.99)
    text = str(search._program)
    for k in reversed(range(len(names))):
        text = text.replace(f"x{k}", names[k])
    return text, explained(held["u"], guess), true


def explained(u: np.ndarray, guess: np.ndarray) -> float:
    """Share of the mean square of u (n,) that a guess (n,) explains."""
    return float(1.0 - np.mean((u - guess) ** 2) / np.mean(u**2))


def split(form: str) -> list[str]:
    """The factors of a form, memories as one."""
    inside = form[form.index("lag(") : form.index(")") + 1] if "lag(" in form else ""
    return [*form.replace(inside, "").split(), *([inside] if inside else [])]


def main() -> int:
    """Print a line of JSON for each case. Returns 0."""
    parser = argparse.ArgumentParser(description="PySINDy and gplearn on the same missing inputs")
    parser.add_argument("residuals")
    parser.add_argument("--only", default="0/1", metavar="K/N", help="every Nth case, from the Kth on")
    args = parser.parse_args()
    part, parts = map(int, args.only.split("/"))
    for k, (key, sides) in enumerate(cases(args.residuals).items()):
        if k % parts != part:
            continue
        case, _, form = key.partition("|")
        every = max(1, len(sides["fit"]["u"]) // ROWS)
        sides["fit"] = {name: values[::every] for name, values in sides["fit"].items()}
        line: dict[str, object] = {"case": case, "form": form}
        for kind in ("STLSQ", "SSR"):
            begin = time.process_time()
            terms, share = sindy(sides["fit"], sides["held"], kind)
            true = bool(form) and ";" not in form and [sorted(split(t)) for t in terms] == [sorted(split(form))]
            line[kind] = {"terms": len(terms), "first": terms[:3], "removed": round(share, 3), "true": true,
                          "cpu": round(time.process_time() - begin, 1)}  # fmt: skip
        begin = time.process_time()
        text, share, true = genetic(sides["fit"], sides["held"], "" if ";" in form else form)
        line["gplearn"] = {"expression": text, "removed": round(share, 3), "true": true,
                           "cpu": round(time.process_time() - begin, 1)}  # fmt: skip
        print(json.dumps(line), flush=True)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
