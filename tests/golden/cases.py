"""The golden cases: every method of identification, with fixed input. Each case returns its result as plain data."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from benchmarks.loops import AXIS as LOOP
from tests.golden import logs, simulated
from tests.golden.case import golden, register
from tests.golden.told import (
    of_break_aways,
    of_identification,
    of_operator_prediction,
    of_operators,
    of_prediction,
    predict_operator,
    unexplained,
)
from tests.identification.known_logs import (
    held_log,
    log_of,
    sines,
    sliding_effort,
    sliding_log,
    slow_log,
)

from bristle import friction, identify, identify_operator, plants, predict
from bristle.core import Axis, InputError
from bristle.logs.assembly import within
from bristle.logs.curves import Curves
from bristle.logs.log import Log

ALL = "all,stribeck+asymmetry"  # with what is no model of its own: a slot
STATIC = (
    "coulomb,viscous,coulomb_viscous,stribeck,coulomb_viscous+asymmetry,stribeck_free+asymmetry"
)

Found = dict[str, Any]


def fitted(
    log: Log | Sequence[Log], model: str, axis: Axis | None = None, **requested: Any
) -> Found:
    """Return what an identification says, without draws where none are asked for."""
    return of_identification(identify(log, model, axis=axis, **({"draws": 0} | requested)))


# --- one identification each ---------------------------------------------------------------------------------------------


class Fit(NamedTuple):
    """An identification: of which log and axis, with which models and options."""

    given: Callable[[], tuple[Log | Sequence[Log], Any]]
    models: str
    options: dict[str, Any] = {}  # noqa: RUF012  (it is only read)


def part(
    given: Callable[[], tuple[Log, Axis]], begin: float, end: float
) -> Callable[[], tuple[Log, Axis]]:
    """Return what gives a part of a log [s], and its axis."""

    def cut() -> tuple[Log, Axis]:
        log, axis = given()
        return within(log, (begin, end)), axis

    return cut


def free_sliding() -> Log:
    """Return slow motion on bristles that yield by a power of the force."""
    return slow_log(
        friction.dahl(F_C=20.0, sigma_0=5e6, sigma_2=200.0, exponent=0.7), duration=10.0
    )


REFINED = partial(logs.emps, "axis_refined.toml")
DAMPER = partial(logs.damper, "0.5Hz80lb", "1Hz80lb")
SLOWLY = {"mass": 12.0, "cutoff": 80.0, "decimation": 2}
# Every model but elastoplastic, which alone takes longer than all other cases.
OSCILLATOR = ",".join(
    [
        "stribeck+asymmetry",
        *(name for name in friction.MODELS if name not in ("elastoplastic", "maxwell_stribeck")),
    ]
)
FAST_MEASURED = {
    "emps_static": Fit(logs.emps, STATIC),
    "emps_draws": Fit(logs.emps, "coulomb_viscous+asymmetry,coulomb_viscous", {"draws": 20}),
    # Every number that can be known beforehand, and every number of the treatment.
    "emps_as_asked": Fit(
        logs.emps,
        "coulomb_viscous,stribeck",
        {"cutoff": "50 Hz", "decimation": 5, "blocks": 3, "mass": "95 kg", "offset": "-3 N"},
    ),
    # Friction that varies with the place and the turn of the screw, of an axis whose effort is held.
    "emps_varying": Fit(
        REFINED, "coulomb_viscous+periodic,coulomb_viscous+position+asymmetry", {"blocks": 4}
    ),
    # Friction that varies with the turn of a screw whose lead nobody wrote down.
    "emps_pitch": Fit(part(logs.emps, 0.0, 13.0), "coulomb_viscous+periodic", {"blocks": 0}),
    "damper_elements": Fit(DAMPER, "maxwell_slip,coulomb", {"blocks": 0}),
}
MEASURED = {
    "emps_all": Fit(part(logs.emps, 0.0, 6.5), ALL),
    "emps_whole": Fit(logs.emps, "dahl,lugre,lugre+asymmetry,maxwell_slip,gms"),
    "emps_lugre_draws_without_blocks": Fit(logs.emps, "lugre", {"draws": 20, "blocks": 0}),
    "emps_closed_loop_draws": Fit(
        part(REFINED, 0.0, 6.5),
        "coulomb_viscous+asymmetry",
        {"method": "output_error", "draws": 20, "blocks": 3},
    ),
    "tribometer_all": Fit(part(logs.tribometer, 12.0, 44.0), ALL),
    "tribometer_elements_draws": Fit(
        part(logs.tribometer, 12.0, 60.0), "maxwell_slip", {"draws": 20}
    ),
    "damper_all": Fit(DAMPER, ALL),
    "bouc_wen_all": Fit(
        part(logs.bouc_wen, 0.0, 10.92), OSCILLATOR, {"method": "inverse_dynamics", "blocks": 3}
    ),
    "bouc_wen_open_loop_others": Fit(
        part(logs.bouc_wen, 0.0, 21.84), "coulomb_viscous,dahl", {"blocks": 0}
    ),
}
FAST = {
    "closed_loop_draws": Fit(
        lambda: (simulated.in_loop(scatter=0.05), LOOP), "stribeck", {"draws": 20, "blocks": 0}
    ),
    "held_effort": Fit(
        lambda: (held_log(simulated.LUGRE), Axis(held=True, resolution=1e-7)),
        "lugre",
        {"blocks": 0},
    ),
    "held_effort_not_said": Fit(
        lambda: (held_log(simulated.LUGRE), Axis(resolution=1e-7)), "lugre,dahl", {"blocks": 2}
    ),
    "several_logs_draws": Fit(
        lambda: ([sliding_log(seed, noise=1.0) for seed in (1, 2, 3)], None),
        "coulomb_viscous,coulomb_viscous+asymmetry",
        {"draws": 20},
    ),
    "several_axes": Fit(
        lambda: ([sliding_log(1), sliding_log(2)], [Axis(resolution=1e-7), Axis(resolution=1e-6)]),
        "coulomb_viscous",
    ),
    "free_exponent": Fit(
        lambda: (free_sliding(), Axis(resolution=1e-7)), "dahl", {"free": "exponent", "mass": 12.0}
    ),
}
SLOW = {
    "demo_all": Fit(part(logs.demo, 0.0, 8.0), ALL),
    # Models of elements cannot be compared in a loop, and are left out.
    "demo_closed_loop": Fit(
        part(logs.demo, 0.0, 8.0), "coulomb_viscous,maxwell_slip", {"method": "output_error"}
    ),
    "ball_screw": Fit(logs.ball_screw, "maxwell_slip,gms,dahl"),
    "ball_screw_draws": Fit(logs.ball_screw, "maxwell_slip", {"draws": 20, "blocks": 2}),
    "open_loop": Fit(lambda: (simulated.ringing(), simulated.OPEN), "bouc_wen_classic"),
    "open_loop_draws": Fit(
        lambda: (simulated.ringing(), simulated.OPEN), "bouc_wen_classic,dahl", {"draws": 20}
    ),
    "closed_loop": Fit(
        lambda: (simulated.in_loop(), replace(LOOP, seeks_lag=True)),
        "stribeck,coulomb_viscous,dahl,lugre",
    ),
    # Two logs of one loop, each held out in turn, with intervals.
    "closed_loop_several_draws": Fit(
        lambda: ([simulated.in_loop(pairs=3), simulated.in_loop(pairs=4, scatter=0.05)], LOOP),
        "coulomb_viscous",
        {"draws": 20},
    ),
    "held_effort_all_draws": Fit(
        lambda: (held_log(simulated.LUGRE), Axis(held=True, resolution=1e-7)),
        ALL,
        {"draws": 20, "blocks": 0},
    ),
    "elements_draws": Fit(
        lambda: (simulated.elements_log(), None), "maxwell_slip,dahl", SLOWLY | {"draws": 20}
    ),
    "elements_with_stribeck_draws": Fit(
        lambda: (simulated.gms_log(scatter=0.03), None),
        "gms,maxwell_slip",
        SLOWLY | {"draws": 20, "blocks": 3},
    ),
    "elements_under_load": Fit(
        lambda: (
            simulated.elements_log(load=1.0 + 0.5 * np.sin(np.linspace(0.0, 20.0, 12_000))),
            None,
        ),
        "maxwell_slip+load",
        SLOWLY | {"decimation": 5, "blocks": 0},
    ),
}


def found_by(item: Fit) -> Found:
    """Return what an identification says."""
    log, axis = item.given()
    return fitted(log, item.models, axis, **item.options)


for _fits, _fast, _measured in (
    (FAST_MEASURED, True, True),
    (MEASURED, False, True),
    (FAST, True, False),
    (SLOW, False, False),
):
    for _name, _fit in _fits.items():
        register(_name, partial(found_by, _fit), fast=_fast, measured=_measured)


# --- a measured axis ------------------------------------------------------------------------------------------------


@golden(measured=True)
def emps_closed_loop() -> Found:
    """The first half in closed loop, and the second as predicted."""
    log, axis = logs.emps("axis_refined.toml")
    half = len(log) // 2
    first, second = (
        replace(log, segments=(part,)) for part in (slice(0, half), slice(half, len(log)))
    )
    identification = identify(
        first,
        "stribeck_free+asymmetry,coulomb_viscous",
        axis=axis,
        method="output_error",
        draws=0,
        blocks=0,
    )
    best = identification.best
    predictions = {
        mode: of_prediction(
            predict(best.plant, best.friction, second, axis, mode, lag=best.lag), best.friction
        )
        for mode in ("inverse", "closed-loop", "open-loop")
    }
    return of_identification(identification) | {"predictions": predictions}


# --- a reciprocating contact ----------------------------------------------------------------------------------------


@golden(measured=True)
def tribometer_halves() -> Found:
    """The first half with a free exponent, and the second as predicted."""
    log, axis = logs.tribometer()
    first, second = within(log, (12.0, 108.5)), within(log, (108.5, 205.0))
    identification = identify(
        first, "dahl,maxwell_slip,maxwell_slip+position,gms", axis=axis, free="exponent", draws=0
    )
    predictions = {
        fit.name: of_prediction(predict(fit.plant, fit.friction, second, axis), fit.friction)
        for fit in identification.fits
    }
    return of_identification(identification) | {"predictions": predictions}


# --- a friction damper: several logs --------------------------------------------------------------------------------


@golden(measured=True)
def damper_gap_draws() -> Found:
    """A contact with a gap, its intervals, and another test as predicted with its band."""
    several, axis = logs.damper("0.5Hz80lb", "1Hz80lb")
    (other,), _ = logs.damper("1Hz70lb")
    identification = identify(several, "gap_slider+asymmetry,coulomb", axis=axis, draws=20)
    best = identification.best
    assert best.resampling is not None
    text = predict(best.plant, best.friction, other, axis, bands=best.resampling.bands)
    return of_identification(identification) | {"prediction": of_prediction(text, best.friction)}


# --- an oscillator whose truth is known -----------------------------------------------------------------------------


@golden(measured=True)
def bouc_wen_open_loop_draws() -> Found:
    """The benchmark in open loop with intervals, and its test record as predicted."""
    log, axis = logs.bouc_wen()
    identification = identify(log, "bouc_wen_classic", axis=axis, draws=20)
    best = identification.best
    text = predict(best.plant, best.friction, logs.bouc_wen_test(), axis, "open-loop")
    return of_identification(identification) | {"prediction": of_prediction(text, best.friction)}


# --- the axis of the demonstration and the virtual ball screw --------------------------------------------------------


@golden()
def demo_draws() -> Found:
    """The models of the demonstration, and its unseen log as predicted with a band."""
    log, axis = logs.demo()
    unseen, _ = logs.demo(2)
    identification = identify(
        log, "coulomb_viscous,stribeck+asymmetry,lugre+asymmetry", axis=axis, draws=20
    )
    best = identification.best
    assert best.resampling is not None
    text = {
        mode: of_prediction(
            predict(best.plant, best.friction, unseen, axis, mode, bands=best.resampling.bands),
            best.friction,
        )
        for mode in ("inverse", "closed-loop")
    }
    force = unexplained(best.plant, best.friction, unseen, axis)
    return of_identification(identification) | {"predictions": text, "unexplained": force}


@golden()
def ball_screw_all() -> Found:
    log, axis = logs.ball_screw()
    return fitted(within(log, (0.0, 12.0)), ALL, replace(axis, seeks_delay=False), blocks=0)


# --- simulated axes: output error -----------------------------------------------------------------------------------


@golden(fast=True)
def closed_loop_without_blocks() -> Found:
    log, axis = simulated.in_loop(pairs=3), replace(LOOP, seeks_lag=True)
    identification = identify(log, "stribeck", axis=axis, draws=0, blocks=0)
    best = identification.best
    text = predict(best.plant, best.friction, log, LOOP, "closed-loop", lag=best.lag)
    return of_identification(identification) | {"prediction": of_prediction(text, best.friction)}


# --- simulated axes: inverse dynamics -------------------------------------------------------------------------------


@golden(fast=True)
def late_effort() -> Found:
    """An effort that is recorded three samples late, whose delay is found."""
    log = simulated.late()
    identification = identify(
        log, "coulomb_viscous,stribeck", axis=Axis(seeks_delay=True), draws=20
    )
    best = identification.best
    text = predict(best.plant, best.friction, log, delay=identification.treatment["delay"])
    return of_identification(identification) | {"prediction": of_prediction(text, best.friction)}


@golden(fast=True)
def rotational() -> Found:
    log = sliding_log(5)
    position = replace(log.position, unit="rad")
    assert log.effort is not None
    turned = replace(
        log, kind="rotational", position=position, effort=replace(log.effort, unit="N*m")
    )
    return fitted(turned, "coulomb_viscous,stribeck+asymmetry", Axis(kind="rotational"))


@golden(fast=True)
def refused() -> Found:
    """What cannot be identified, and what is said of it."""
    motion = sines(3.0)
    effort = sliding_effort(motion)
    requested: dict[str, dict[str, Any]] = {
        "no model": {"model": "lugr"},
        "twice": {"model": "dahl,dahl"},
        "no shape": {"model": "coulomb_viscous", "free": "exponent"},
        "lists": {"model": "maxwell_stribeck"},
        "cut-off": {"model": "coulomb_viscous", "cutoff": 900.0},
        "mass": {"model": "coulomb_viscous", "mass": -1.0},
        "blocks": {"model": "coulomb_viscous", "blocks": 900},
        "elements": {"model": "gms", "method": "output_error"},
        "no loop": {"model": "coulomb_viscous", "axis": Axis(loop="closed", method="output_error")},
        "one way": {"model": "coulomb_viscous+asymmetry", "log": _one_way()},
    }
    return {
        name: _refusal(**({"log": log_of(motion, effort)} | item))
        for name, item in requested.items()
    }


def _one_way() -> Log:
    motion = sines(3.0)
    onward = motion._replace(
        position=motion.position + 0.5 * motion.time, velocity=motion.velocity + 0.5
    )
    return log_of(onward, sliding_effort(onward))


def _refusal(**requested: Any) -> list[str]:
    try:
        identify(**requested, draws=0)
    except InputError as error:
        return [str(error)]
    return ["was not refused"]


@golden(fast=True)
def pulls_from_rest() -> Found:
    log = simulated.pulled(simulated.pulling())
    result = fitted(log, "coulomb_viscous,maxwell_slip", simulated.PULLED, cutoff=60.0)
    return result | {
        "break_aways": of_break_aways(
            log, simulated.PULLED, 60.0, plants.inertia(M=28.0), simulated.SLIPPING
        )
    }


# --- hysteresis operators -------------------------------------------------------------------------------------------


@golden(measured=True)
def magnet_operators() -> Found:
    return of_operators(identify_operator(logs.magnet()))


@golden(fast=True)
def friction_operators() -> Found:
    rng = np.random.default_rng(11)
    curves = simulated.recorded(
        simulated.MASING, simulated.to_and_fro(rng, turns=50, samples=800), rng, offset=0.3
    )
    result = identify_operator(curves, cells=12)
    unseen = simulated.recorded(simulated.MASING, simulated.to_and_fro(rng, turns=30, samples=500))
    text = predict_operator(result.best.operator, unseen, result.best.offset)
    return of_operators(result) | {
        "prediction": of_operator_prediction(text, result.best.operator, unseen)
    }


@golden()
def operators_of_reversal_curves() -> Found:
    curves = Curves(simulated.reversal_curves(simulated.MASING), start="saturated")
    return of_operators(identify_operator(curves, cells=12, stops=15))
