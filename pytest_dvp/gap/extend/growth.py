"""What a judged twin still lacks, by all of its logs together.

A search that fits one drive and lets another one judge refuses a lag of the drive as long as the dead time beside it is
that of the first drive: the second one is worse with both. Fitted on both together, both are better. Once the held-out
logs have judged a twin, they may help to fit it: all of its values anew, and effect after effect that all logs together
ask for. No log is left to judge that, so it is done only where a user asks for it.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from pytest_dvp.gap.diagnose.candidates import candidates, candidates_of
from pytest_dvp.gap.diagnose.diagnosis import NamedEffect
from pytest_dvp.gap.diagnose.experiment import ExperimentSet, Values, experiment_set
from pytest_dvp.gap.diagnose.fitted_twin import values_of, with_remainder
from pytest_dvp.gap.diagnose.fitted_values import Estimates, estimates
from pytest_dvp.gap.diagnose.input_scales import free_scales, repeats
from pytest_dvp.gap.diagnose.linear_algebra import square
from pytest_dvp.gap.diagnose.search import CHANNEL_MISFIT, Search, Tick
from pytest_dvp.gap.diagnose.trial import Trial
from pytest_dvp.gap.extend.extension import Extension
from pytest_dvp.gap.extend.fit_notes import assumed, edges
from pytest_dvp.gap.extend.fitted_model import fitted_model
from pytest_dvp.gap.extend.ladder import ladder_of, shares
from pytest_dvp.gap.extend.settled_fit import settled_fit
from pytest_dvp.gap.extend.twin_remainder import with_shape
from pytest_dvp.gap.words.comparison import NOTHING_LEFT
from pytest_dvp.logs.log import Log
from vehicle.model.remainder_shape import RemainderShape

if TYPE_CHECKING:
    from vehicle.model.effect import Effect
    from vehicle.model.vehicle_model import VehicleModel

LOSES = 1.0 / 3.0  # of what some logs gain by an effect, that others may lose; chosen: of ten effects of three twins of
# strangers' cars, found without this bound, one lost 60 % and the others up to 12
MOST = 99  # effects of a twin, no bound to their number: it has been judged already. Far from the noise the bound of a
# search holds all the same
ALL_SHOW = "all logs together show it, and none was held out to judge it"
NONE_SHOWN = "all logs together show no effect beside those that the model has"
NO_JUDGE = "none of these logs can judge the new model, for it was fitted on all of them: a further drive can"


def grow(
    logs: Mapping[str, Log],
    twin: VehicleModel,
    *,
    effects: Sequence[Effect] = (),
    fitted_on: Sequence[str] = (),
    tick: Tick = lambda text: None,
) -> Extension:
    """The twin with all of its values fitted anew to all logs together, and with the effects that these show together.

    logs by name; effects: the user's own; fitted_on: what the model file says of the logs. What the file says that the
    twin leaves is set aside: all is measured in units of the sensors' noise. Nothing is refused.

    Raises ModelError or CompareError (one line): an input missing, nothing to judge.
    """
    from vehicle.model.effect_catalogue import catalogue, run_setups

    tick("preparing")
    bare = dataclasses.replace(twin, remainder={}, remainder_shape=RemainderShape(slopes=twin.remainder_shape.slopes))
    target = experiment_set(logs, bare, extra=effects)
    present = [a.name for a in twin.effects]
    kept = candidates_of(bare, present)
    free, start = free_scales(bare, [c.effect for c in kept])
    known = {**catalogue(), **{e.name: e for e in effects}}
    others = [
        c for c in candidates(bare, known.values(), ay="ay" in target.channels)
        if c.name not in present and c.name not in run_setups() and not repeats(c.effect, free)
    ]  # fmt: skip
    search = Search(target, [*kept, *others], nuisance=free, start=start)
    target.settle({})
    final = grown(search, {**start, **values_of(bare)}, [c.name for c in kept], tick)
    tick("what is left")
    sure = estimates(final, search)
    ladder = tuple(ladder_of(search, final, len(kept), (), (), present))
    explains = shares([rung.step for rung in ladder])
    added = [search.known[name] for name in final.names[len(kept) :]]
    extended = fitted_model(bare, final, sure, (), [c.effect for c in added], tuple(fitted_on))
    last = ladder[-1].step
    found = [f"{c.name}: {ALL_SHOW}" for c in added] or [NONE_SHOWN]
    return Extension(
        model=with_shape(with_remainder(extended, search, final, ()), logs, {}, effects),
        effects=tuple(_named(c.name, sure, explains) for c in added),
        refitted={name: one for name, one in sure.items() if name[0] not in {c.name for c in added}},
        ladder=ladder,
        noise_floor=target.noise(),
        refusal="",
        notes=(*found, *edges(final), *assumed(final, twin), NO_JUDGE),
        explained=last.chi2_per_n <= NOTHING_LEFT and max(last.channels.values(), default=0.0) <= CHANNEL_MISFIT,
    )


def grown(search: Search, begin: Values, kept: Sequence[str], tick: Tick) -> Trial:
    """The twin's own effects fitted jointly, then with each effect more that pays as one of a diagnosis has to, if what
    some logs lose by it is less than LOSES of what the others gain. begin: values of the effects `kept`.

    An effect that the logs contradict each other in is not tried again.
    """
    now = settled_fit(search, search.trial(kept, begin))
    barred: list[str] = []
    while True:
        more = ", ".join(now.names[len(kept) :])
        tick(f"what all logs show together{f'; so far {more}' if more else ''}: chi²/N {now.chi2 / search.count:.3g}")
        options = search.paying(now, barred, MOST)
        best = next((trial for trial in options if not contradicts(search.target, now, trial)), None)
        if best is not None:
            search.target.settle(best.values)
            now = search.trial(best.names, best.values, like=best)
        elif options:
            barred += [name for trial in options for name in trial.names if name not in now.names]
        else:
            return settled_fit(search, now) if more else now


def contradicts(target: ExperimentSet, without: Trial, with_it: Trial) -> bool:
    """True if logs lose by what one trial has more than the other one, and that is LOSES of what other logs gain."""
    each = [dataclasses.replace(target, experiments=(e,)) for e in target.experiments]
    change = [square(one.whitened(without.values)) - square(one.whitened(with_it.values)) for one in each]
    return -sum(c for c in change if c < 0.0) >= LOSES * sum(c for c in change if c > 0.0)


def _named(name: str, sure: Estimates, explains: Mapping[str, float]) -> NamedEffect:
    mine = {key: one for (effect, key), one in sure.items() if effect == name}
    return NamedEffect(name, mine, gain=explains.get(name, 0.0), doubts=(ALL_SHOW,))
