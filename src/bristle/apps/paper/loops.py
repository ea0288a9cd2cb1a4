"""Figures 5 and 6: loops of the rig, loops of the reformed Dahl model, and how many loops a model needs."""

from collections.abc import Callable

import numpy as np

from bristle.apps.paper.bench import (
    Record,
    bench_of,
    led,
    measured,
    measured_loop,
    sensor_numbers,
    sensor_says,
)
from bristle.apps.paper.economy import (
    CAPTION,
    economy,
    fitted_reformed_dahl,
    numbers,
    quiet,
    seeded,
    sentences,
    table,
    verdict,
)
from bristle.apps.paper.reproduced import Reproduced, in_millinewtons, percent, spread, verdict_if
from bristle.apps.paper.setting import Setting
from bristle.core import number
from bristle.report.figures.loop_rows import error_over
from bristle.report.figures.small_multiples import loop_family
from bristle.report.table import Table

RIG = "virtual rig"


def figure_5(setting: Setting) -> Reproduced:
    """Return figure 5: loops before break-away, read by the torque sensor of the rig."""
    bench = bench_of(setting)
    rig = setting.contact(RIG)
    repeats = round(setting["measurement", "repeats"])
    rounds = _loops(setting, repeats)
    loops = [first for first, *_ in rounds.values()]
    largest = max(rounds)
    again = measured_loop(setting, rig, largest, repeats, np.random.default_rng(1))
    tops = np.array([record.torque.max() for record in again])
    top = float(loops[-1].torque.max())
    bottom = float(loops[-1].torque.min())
    uneven = abs(top + bottom)
    apart = float(np.ptp(tops))
    # A difference beyond six standard deviations comes from friction.
    noise = 6.0 * setting["measurement", "noise"]
    sensor = sensor_numbers(
        [led(setting, rig, [largest, -largest, largest], setting["measurement", "speed"]).sensed]
    )
    rows = [
        (
            number(1e6 * amplitude, digits=2),
            str(len(records)),
            *(_tips(records, edge) for edge in (np.max, np.min)),
        )
        for amplitude, records in (rounds | {largest: again}).items()
    ]
    caption = "Torque at the tips of the loops [mN·m], mean and standard deviation over the rounds"
    panels = {"amplitude by amplitude": loops, f"the largest, {repeats} times": again}
    return Reproduced(
        number=5,
        verdict=verdict_if(uneven > noise and apart > noise, "built in"),
        found=[
            f"The largest loop runs from {number(1e3 * bottom, digits=3)} to {in_millinewtons(top)}.",
            f"Repeated {repeats} times, its forward tip is at {spread(1e3 * tops)} mN·m, with a range of {in_millinewtons(apart, 2)}.",
            sensor_says(bench, sensor, "At this speed"),
        ],
        # Measured loops, narrow and dark, over friction itself.
        draw=lambda: loop_family(
            {
                title: {
                    "friction": [(record.actual.x, record.actual.torque) for record in records],
                    "torque sensor": [(record.x, record.torque) for record in records],
                }
                for title, records in panels.items()
            },
            "translational",
            "rotational",
        ),
        origin=setting.origin,
        numbers={
            "largest_loop": [bottom, top],
            "forward_tips": tops.tolist(),
            "torque_sensor": sensor,
        },
        tables=(Table(caption, ("Amplitude [µm]", "Rounds", "Forward tip", "Backward tip"), rows),),
    )


def _tips(records: list[Record], edge: Callable[[np.ndarray], float]) -> str:
    """Return the torque at the tips of loops, as text."""
    return spread(1e3 * np.array([edge(record.torque) for record in records]))


def _loops(setting: Setting, rounds: int = 1) -> dict[float, list[Record]]:
    """Return rounds of each amplitude [m], the smallest first, each on a contact with its own scatter."""
    amplitudes = sorted(setting["measurement", "amplitudes"].tolist())
    return {
        amplitude: measured_loop(
            setting,
            seeded(setting.contact(RIG), index),
            amplitude,
            rounds,
            np.random.default_rng(index),
        )
        for index, amplitude in enumerate(amplitudes)
    }


def figure_6(setting: Setting, progress: Callable[[float, str], None] | None = None) -> Reproduced:
    """Return figure 6: measured loops and those of the reformed Dahl model, and the error over the number of branches."""
    loops = [record for (record,) in _loops(setting).values()]
    extent = setting["measurement", "extent"]
    run_in = measured(
        setting,
        setting.contact(RIG),
        [-extent, extent, -extent, extent, -extent],
        np.random.default_rng(0),
    ).since(2)
    fitted = fitted_reformed_dahl(run_in, setting.arm)
    # After a run-in round.
    modelled = [fitted.torque(np.tile(record.x, 2))[record.x.size :] for record in loops]
    shares = [
        float(np.sqrt(np.mean((m - record.torque) ** 2)) / np.max(np.abs(record.torque)))
        for m, record in zip(modelled, loops, strict=True)
    ]
    cost = economy(setting, setting.contact(RIG), round(setting["measurement", "seeds"]), progress)
    still = economy(setting, quiet(setting.contact(RIG)), 1)
    s, f_p = (fitted.operator.values[name] for name in ("s", "f_p"))
    offset = fitted.offset / setting.arm
    return Reproduced(
        number=6,
        verdict=verdict(cost),
        found=[
            f"One large loop gives s = {number(1e-6 * s, digits=3)} N/µm and f_p = {number(f_p, digits=3)} N at the "
            f"table, with a constant of {number(offset, digits=3)} N. The error of the other amplitudes, which were not "
            f"fitted, is {percent(min(shares))} to {percent(max(shares))} of their largest torque.",
            *sentences(cost, still),
        ],
        draw=lambda: loop_family(
            {
                "measured, and the model fitted to one loop": {
                    "measured": [(record.x, record.torque) for record in loops],
                    "reformed Dahl": [
                        (record.x, m) for record, m in zip(loops, modelled, strict=True)
                    ],
                }
            },
            "translational",
            "rotational",
        ),
        origin=setting.origin,
        numbers={
            "s": s,
            "f_p": f_p,
            "offset": offset,
            "error_of_loops": shares,
            **numbers(cost, still),
        },
        tables=(table(cost, still),),
        extras={
            "economy": (
                lambda: error_over(
                    cost.counts,
                    {
                        way: np.stack(
                            [pick(errors, axis=1) for pick in (np.mean, np.min, np.max)], axis=1
                        )
                        for way, errors in cost.errors.items()
                    },
                    {"scatter of the rig": cost.floor},
                    "Branches measured",
                    "Error on other motions [%]",
                    counted=True,
                ),
                *CAPTION,
            )
        },
    )
