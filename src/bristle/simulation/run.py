"""Run an experiment: simulate all variants, and compute their results."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from bristle.core import Abreast, InputError, Model, Progress, Status, guarded
from bristle.core.experiment import Start, Variant
from bristle.engine import LoopTrace, Trace, run_closed_loop, settled
from bristle.engine.loop import sensed
from bristle.files.arguments import EXPERIMENT
from bristle.models.controllers.limits import within_drive
from bristle.models.friction.level import rises_with_effort
from bristle.simulation.compensation import carried_effort, compensator_of, motor_feedforward
from bristle.simulation.result import SimulationResult, VariantResult, mean_result
from bristle.simulation.statistics import statistics_of
from bristle.simulation.two_masses import feeds_inertia, screw_of, whole_inertia

RECORDED = (
    "time",
    "measured",
    "position",
    "velocity",
    "command",
    "effort",
    "friction",
    "status",
    "kind",
)
Motions = tuple[np.ndarray, np.ndarray, np.ndarray]  # position, velocity, acceleration
DIRECTIONS = {"forward": 1.0, "backward": -1.0}


@guarded(experiment=EXPERIMENT)
def simulate(experiment: Any, progress: Progress | None = None) -> SimulationResult:
    """Simulate every variant of an experiment.

    Parameters
    ----------
    experiment : Experiment, path-like, bytes, file object or dict
        The experiment, or a file with it. A controller with a ``limit`` respects the limit of the drive. The controller
        receives the feedforward earlier, by the delay of the loop.
    progress : callable, optional
        Called with the share done and the name of the next step.

    Returns
    -------
    SimulationResult
        Each variant with its errors and efforts, as means over its runs if there are several. The signals of a diverged loop
        end early, and its status reports the divergence.
    """
    total = sum(variant.run.seeds for variant in experiment.variants)
    finished = 0
    at_load = any(leads(variant) for variant in experiment.variants)
    results = {}
    for variant in experiment.variants:
        runs = []
        coming = _runs_of(variant)
        while len(runs) < variant.run.seeds:
            if progress is not None:
                progress((finished + len(runs)) / total, variant.name)
            runs.append(next(coming))
        finished += len(runs)
        results[variant.name] = replace(mean_result(runs), at_load=at_load)
    return SimulationResult(experiment, results)


def simulate_with(variant: Variant, effort: np.ndarray | None) -> VariantResult:
    """Return one run of a variant, with an additional effort [N or N*m] at each sample."""
    desired = _desired(variant)
    if effort is not None:
        desired[3] += effort
    return _run_of(variant)(desired, 0)


def _runs_of(variant: Variant) -> Iterator[VariantResult]:
    """Yield the runs of a variant. After the first run, which compiles, the others run in parallel without a lock."""
    run = partial(_run_of(variant), _desired(variant))
    yield run(0)
    if variant.run.seeds > 1:
        with Abreast() as pool:
            yield from pool.map(run, range(1, variant.run.seeds))


def _run_of(variant: Variant) -> Callable[[np.ndarray, int], VariantResult]:
    """Return a function that simulates one run of a variant along a desired motion, with learning if configured."""
    if variant.learning is None:
        return partial(_simulate_once, variant)
    return partial(learn, variant)


def seeded(model: Model, run: int) -> Model:
    """Return a component with the random numbers of this run."""
    if run and "seed" in model.values:
        return model.with_values(seed=model.values["seed"] + run)
    return model


def planned_motion(variant: Variant) -> Motions:
    """Return desired position, velocity and acceleration, at each sample and for the delay after the last."""
    run = variant.run
    for name, variable in variant.reference.component.variables.items():
        frequency = variant.reference.values[name]
        if variable.quantity == "frequency" and 2.0 * frequency * run.sample_time >= 1.0:
            raise InputError(
                "is not sampled often enough",
                path=f"reference.{name}",
                value=frequency,
                allowed=f"< {0.5 / run.sample_time:g} Hz",
            )
    t = run.sample_time * np.arange(round(run.duration / run.sample_time) + run.delay)
    return variant.reference.component.sample(t, variant.reference.parameters)


def _desired(variant: Variant) -> np.ndarray:
    """Return the desired motion and its feedforward, shape (4, sample)."""
    # Feedforward acts `delay` samples after the controller receives it: shift it ahead by that much.
    motion = planned_motion(variant)
    delay = variant.run.delay
    count = motion[0].size - delay
    if variant.effort is None:
        motor = motor_feedforward(
            variant.feedforward, motion[0], motion[2], variant.run.sample_time
        )
        effort = motor.effort
        if leads(variant):
            motion = motor.position, motion[1] + motor.rate, motion[2] + motor.acceleration
        screw = screw_of(variant.feedforward)
        plant = variant.feedforward.plant
        dt = variant.run.sample_time
        if plant is not None and screw is not None and feeds_inertia(variant.controller, dt):
            # The law multiplies the acceleration of its reference by the whole inertia.
            effort = effort - whole_inertia(plant, screw, dt) * motion[2]
        effort = effort[delay:]
    elif variant.effort.values.size == count:
        effort = variant.effort.values
    else:
        raise InputError(
            "has another length than the run",
            path="effort",
            value=variant.effort.values.size,
            allowed=f"{count} samples",
        )
    return np.stack((*(signal[:count] for signal in motion), effort))


def leads(variant: Variant) -> bool:
    """Return whether the reference of the controller leads that of the load by a wind-up that is fed forward."""
    return (
        variant.effort is None
        and variant.sensor_at == "motor"
        and screw_of(variant.feedforward) is not None
    )


def _simulate_once(variant: Variant, desired: np.ndarray, number: int) -> VariantResult:
    """Return one run of a variant; `number` shifts the seeds of its sensor and its friction."""
    if variant.run.tolerance:
        return _result_of(variant, desired, _by_tolerance(variant, desired, number))
    return _result_of(variant, desired, _by_steps(variant, desired, number))


def _result_of(variant: Variant, desired: np.ndarray, trace: Trace) -> VariantResult:
    """Return the signals of a run along a desired motion, and its errors and efforts after the settling time."""
    count = trace.time.size
    judged = slice(min(round(variant.run.settle / variant.run.sample_time), count), count)
    planned, velocity, _, effort = desired[:, :count]
    if variant.effort is None:
        reference = planned
    else:  # an open loop has no following error
        reference = np.full(count, np.nan)
    following = reference - trace.measured
    if leads(variant):
        wanted = planned_motion(variant)[0][:count]
        true = wanted - trace.position
    else:
        wanted = None
        true = reference - trace.position
    compensation = 0.0
    controller = None
    if isinstance(trace, LoopTrace):
        compensation = trace.compensation
        if variant.effort is None:
            controller = trace.controller
    return VariantResult(
        name=variant.name,
        following_error=statistics_of(following[judged]),
        true_error=statistics_of(true[judged]),
        by_direction={
            name: statistics_of(following[judged][side * velocity[judged] > 0.0])
            for name, side in DIRECTIONS.items()
        },
        effort_rms=statistics_of(trace.effort[judged]).rms,
        effort_peak=float(np.max(np.abs(trace.effort[judged]), initial=0.0)),
        reference=reference,
        feedforward=effort + compensation,
        motion=statistics_of(trace.position[judged]),
        load_reference=wanted,
        controller=controller,
        **{name: getattr(trace, name) for name in RECORDED},
    )


def _by_steps(variant: Variant, desired: np.ndarray, number: int) -> LoopTrace:
    """Return a run with constant steps, of a loop or of an open loop."""
    run = variant.run
    friction = seeded(variant.friction, number)
    feedforward = variant.feedforward
    carried = None
    if (
        feedforward.friction is not None
        and feedforward.along == "measured"
        and rises_with_effort(feedforward.friction)
    ):
        # Effort transmitted by the desired motion, as far ahead as the feedforward. It excludes the learned effort, which stands for
        # unknown forces.
        planned, _, planned_acceleration = planned_motion(variant)
        carried = carried_effort(feedforward, planned, planned_acceleration, run.sample_time)[
            run.delay :
        ]
    begun = variant.start
    if begun is None:
        motion = planned_motion(variant) if leads(variant) else desired[:-1]
        begun = Start(*(float(signal[0]) for signal in motion))
    state = None
    memory = None
    if variant.start is not None and begun.velocity:
        # For a motion in progress, friction starts in the steady state at its velocity.
        state, memory = settled(friction, begun.velocity)
    table = variant.table
    if table is not None:
        table = seeded(table, number)
    return run_closed_loop(
        variant.plant,
        friction,
        within_drive(variant.controller, run.effort_limit, variant.injected),
        seeded(variant.sensor, number),
        desired,
        run.sample_time,
        table=table,
        sensor_at=variant.sensor_at,
        steps=run.substeps,
        compensator=compensator_of(feedforward, carried),
        injected=variant.injected,
        disturbance=variant.disturbance,
        limit=run.effort_limit,
        delay=run.delay,
        lag=run.current_lag,
        effort_before=begun.effort or 0.0,
        resumed_effort=begun.effort,
        x=begun.position,
        v=begun.velocity,
        acceleration=begun.acceleration,
        state=state,
        memory=memory,
    )


def _by_tolerance(variant: Variant, desired: np.ndarray, number: int) -> Trace:
    """Return a run of an open loop with the steps that its tolerance needs."""
    from bristle.engine import run_adaptive

    run = variant.run
    effort = np.clip(desired[3], -run.effort_limit, run.effort_limit)
    unseen = 0.0 if variant.disturbance is None else variant.disturbance
    trace = run_adaptive(
        variant.plant,
        seeded(variant.friction, number),
        effort - unseen,
        run.sample_time,
        tolerance=run.tolerance,
        hold="zero",
    )
    reading = sensed(seeded(variant.sensor, number), trace.position, run.sample_time)
    return replace(
        trace, measured=reading, effort=effort[: reading.size], command=effort[: reading.size]
    )


def learn(variant: Variant, desired: np.ndarray, number: int) -> VariantResult:
    r"""Return the last of several trials; all trials have the same start and different noise.

    .. math:: u_{j+1} = Q\left[u_j + k_e\,e_j + k_d\,\dot e_j\right]

    `Q` is a zero-phase low-pass: the whole trial is known, so that the filter may look ahead [1]_. It bounds the band in
    which the loop learns. The loop learns repeating errors, but not friction that scatters between trials.

    References
    ----------
    .. [1] D. A. Bristow, M. Tharayil, A. G. Alleyne, "A survey of iterative learning control", IEEE Control Systems
       Magazine 26(3), 2006. doi:10.1109/MCS.2006.1636313
    """
    from scipy.signal import butter, sosfiltfilt

    learning = variant.learning
    dt = variant.run.sample_time
    if learning is None:
        raise TypeError("the variant has no learning")
    if not learning.cutoff < 0.5 / dt:
        raise InputError(
            "out of range",
            path="controller.learning.cutoff",
            value=learning.cutoff,
            allowed=f"< {0.5 / dt:g} Hz",
        )
    low_pass = butter(2, learning.cutoff, fs=1.0 / dt, output="sos")
    learned = np.zeros(desired.shape[1])
    errors: list[float] = []
    while True:
        result = _simulate_once(
            variant, desired + np.outer((0.0, 0.0, 0.0, 1.0), learned), number + 1000 * len(errors)
        )
        variant = replace(variant, controller=result.controller or variant.controller)
        errors.append(result.following_error.peak_to_peak)
        if len(errors) == learning.trials or result.status is Status.NOT_FINITE:
            return replace(result, trials=tuple(errors))
        error = result.reference - result.measured
        learned = sosfiltfilt(
            low_pass, learned + learning.k_e * error + learning.k_d * np.gradient(error, dt)
        )
