"""Figures 5 and 6: loops of the rig, loops of the reformed Dahl model, and how many loops a model needs."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from bristle.core.typography import number
from bristle.paper.economy import WAYS, Economy, economy, fitted_reformed_dahl, seeded
from bristle.paper.measurement import Record, measured, measured_loop
from bristle.paper.reproduced import Reproduced, percent
from bristle.paper.setting import Setting
from bristle.report.table import Table

__all__ = ["figure_5", "figure_6"]

RIG = "virtual rig"


def figure_5(setting: Setting) -> Reproduced:
    """Return figure 5: loops before break-away, as the rig would record them."""
    from bristle.figures import loop_family

    loops, repeats = _loops(setting), round(setting["measurement", "repeats"])
    largest = float(np.max(setting["measurement", "amplitudes"]))
    again = measured_loop(setting, setting.contact(RIG), largest, repeats, np.random.default_rng(1))
    tops = np.array([one.torque.max() for one in again])
    top, bottom = float(loops[-1].torque.max()), float(loops[-1].torque.min())
    return Reproduced(
        number=5,
        title="Loops before break-away, measured on the virtual rig",
        claim="Friction before break-away is a hysteresis, and not the same forward and backward, nor from time to time.",
        verdict="holds",
        said="“Figures 5 and 6 show the results of the experimental and simulation hysteresis loops in the pre-sliding "
        "region of a ball-screw system.” And: “the friction motion of mechanical systems is not almost reappeared "
        "equally … This is due to the irregularity of friction dependant on the contacting surface.”",
        found=[
            f"The largest loop runs from {number(1e3 * bottom, digits=3)} to {number(1e3 * top, digits=3)} mN·m.",
            f"Repeated {repeats} times, its forward tip lies within {number(1e3 * float(np.ptp(tops)), digits=2)} mN·m.",
        ],
        differs="These are loops of thirty spring-slider elements with other limits in each direction, read in counts of "
        f"{number(1e6 * setting['measurement', 'resolution'], digits=3)} µm; those of the paper cannot be had in "
        "numbers.",
        draw=lambda: loop_family(
            {"amplitude by amplitude": {"measured": [(one.x, one.torque) for one in loops]},
             f"the largest, {repeats} times": {"measured": [(one.x, one.torque) for one in again]}},
            "translational", "rotational",
        ),
        alternative="Hysteresis loops of the virtual rig, of several amplitudes, and the largest repeated",
        source=setting.source,
        numbers={"largest_loop": [bottom, top], "forward_tips": tops.tolist()},
    )  # fmt: skip


def _loops(setting: Setting) -> list[Record]:
    """Return one loop of each amplitude, the smallest first, each on a contact that scatters in its own way."""
    amplitudes = sorted(setting["measurement", "amplitudes"].tolist())
    return [
        measured_loop(setting, seeded(setting.contact(RIG), index), one, 1, np.random.default_rng(index))[0]
        for index, one in enumerate(amplitudes)
    ]


def figure_6(setting: Setting, progress: Callable[[float], None] | None = None) -> Reproduced:
    """Return figure 6: loops of the reformed Dahl model beside those measured, and the error over what was measured.

    Parameters
    ----------
    setting : Setting
        The experiment.
    progress : callable, optional
        Called with the share done.
    """
    from bristle.figures import loop_family

    loops = _loops(setting)
    extent = setting["measurement", "extent"]
    run_in = measured(
        setting, setting.contact(RIG), [-extent, extent, -extent, extent, -extent], np.random.default_rng(0)
    ).since(2)  # fmt: skip
    fitted = fitted_reformed_dahl(run_in, setting.arm)
    modelled = [_round(fitted.torque, one, setting.arm) for one in loops]
    shares = [
        float(np.sqrt(np.mean((m - one.torque) ** 2)) / np.max(np.abs(one.torque)))
        for m, one in zip(modelled, loops, strict=True)
    ]
    cost = economy(setting, setting.contact(RIG), progress)
    values = fitted.operator.values
    return Reproduced(
        number=6,
        title="Loops of the reformed Dahl model, and what measuring more would bring",
        claim="Two numbers from a few loops replace the many experiments of a Preisach plane.",
        verdict=_verdict(cost),
        said="To know F(α, β), “a lot of experiments should be executed and it takes a long time. … Therefore, the "
        "reformed Dahl model should be used for obtaining the transition curve.” And in the conclusion: “By using the "
        "deformed Dahl model, the number and time for experiment could be reduced and the satisfactory results were "
        "obtained.”",
        found=[
            f"One large loop gives s = {number(values['s'], digits=3)} N·m/rad and f_p = "
            f"{number(1e3 * values['f_p'], digits=3)} mN·m; the loops of other amplitudes, which were not fitted, are "
            f"then missed by {percent(min(shares))} to {percent(max(shares))} of their largest torque.",
            *_economy_sentences(cost),
        ],
        differs="The model is the same forward and backward and has an offset for the rest. Its loops grow with the "
        "amplitude in one way only, fixed by two numbers; those of the rig in another.",
        draw=lambda: loop_family(
            {"as measured, and the model fitted to one loop": {
                "measured": [(one.x, one.torque) for one in loops],
                "reformed Dahl": [(one.x, m) for one, m in zip(loops, modelled, strict=True)]}},
            "translational", "rotational",
        ),
        alternative="Hysteresis loops of the reformed Dahl model over those measured",
        source=setting.source,
        numbers={"s": values["s"], "f_p": values["f_p"], "error_of_loops": shares,
                 "branches": cost.counts, "error_percent": {name: one.mean(axis=1) for name, one in cost.errors.items()},
                 "scatter_percent": cost.floor},
        tables=(_economy_table(cost),),
        extras={"economy": (lambda: _draw_economy(cost),
                            "Error on motions that were not measured, over the number of branches measured",
                            "Error on random motions that were not measured, of models made from more and more measured "
                            "branches: the mean over seeds, and the range. Dotted: what a model that knew the mean of the "
                            "rig would leave, because the rig does not repeat itself.")},
    )  # fmt: skip


def _round(torque: Callable[[np.ndarray], np.ndarray], loop: Record, arm: float) -> np.ndarray:
    """Return what a model gives on a loop after a round that runs it in."""
    twice = np.concatenate([loop.x, loop.x])
    return torque(twice / arm)[loop.x.size :]


def _means(cost: Economy) -> dict[str, np.ndarray]:
    return {name: one.mean(axis=1) for name, one in cost.errors.items()}


def _verdict(cost: Economy):  # noqa: ANN202
    """Return whether the reformed Dahl model from the fewest branches does as well as the table from the most."""
    means = _means(cost)
    few, many = float(means["reformed Dahl"][0]), float(means["tabulated surface"][-1])
    if few > 1.5 * many:
        return "does not hold"
    return "holds in part" if float(means["Prandtl-Ishlinskii"][0]) < few else "holds"


def _economy_sentences(cost: Economy) -> list[str]:
    means = _means(cost)
    told = {name: f"{number(float(one[-1]), digits=2)} %" for name, one in means.items()}
    first = {name: float(one[0]) for name, one in means.items() if np.isfinite(one[0])}
    few, many = cost.counts[0], cost.counts[-1]
    listed = ", ".join(f"{name} {number(value, digits=2)} %" for name, value in first.items())
    return [
        f"On motions that were not measured, from {few} branch{'es' if few > 1 else ''}: {listed}.",
        f"From {many}: " + ", ".join(f"{name} {value}" for name, value in told.items())
        + f". A branch takes {number(cost.duration, digits=2)} s and the scatter of the rig alone is "
        f"{number(cost.floor, digits=2)} %, so that measuring more brings little to any of them.",
    ]  # fmt: skip


def _economy_table(cost: Economy) -> Table:
    rows = [
        (str(count), *(number(float(cost.errors[name][row].mean()), resolution=0.1) for name in WAYS))
        for row, count in enumerate(cost.counts)
    ]
    return Table(
        "Error on motions that were not measured, in percent of the largest torque, mean over seeds",
        ("Branches", *WAYS), rows,
    )  # fmt: skip


def _draw_economy(cost: Economy):  # noqa: ANN202
    from bristle.figures import error_over_count

    return error_over_count(
        cost.counts, cost.errors, cost.floor, "Branches measured", "Error on other motions [%]"
    )  # fmt: skip
