"""The part of a report in which parameters move: the module of the model, the rows that it was fitted to, and the loop.

In the loop the axis stays as it was simulated, with what the model does not explain pushing it; what is fed forward is
the model with the values that are moved. Law and encoder are a module of their own, as they are in the lab.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from markupsafe import Markup

from bristle.controllers.limits import within_drive
from bristle.core.axis import Axis
from bristle.core.contracts import Model, Reference
from bristle.core.errors import InputError
from bristle.core.experiment import Feedforward, Start, Variant
from bristle.core.status import Status
from bristle.core.typography import typeset
from bristle.core.variable import unit_of
from bristle.engine.loop import begun
from bristle.engine.mechanism import drive_over
from bristle.engine.motion import settled
from bristle.exports.cycle import SOLVER
from bristle.friction.level import rises_with_effort
from bristle.identification.result import Fit, Identification
from bristle.lab.described import body_described, described, values_of, variables_of
from bristle.lab.loop import parts_described
from bristle.lab.packing import as_json, differences, packed_numbers
from bristle.lab.page import joined, policy
from bristle.lab.rows import fitted_rows
from bristle.plants.pulled_inertia import MODEL as BODY
from bristle.prediction.following import Following
from bristle.sensors.encoder import MODEL as ENCODER
from bristle.simulation.compensation import COMPENSATED
from bristle.simulation.result import SimulationResult

SHARED = ("inflate.js", "numbers.js", "physics.js", "loop.js", "move.js")
SCRIPTS = ("paths.js", "rows.js", "plot.js", "pointing.js", "controls.js", "asking.js", "following.js", "living.js")
STYLES = ("controls.css", "living.css")
AROUND = 3.0  # times up and down from an identified value


class Living(NamedTuple):
    """A part of a report in which parameters are moved; without scripts it is not there."""

    policy: str
    style: Markup
    shared: Markup
    script: Markup
    data: Markup
    follows: bool
    macro = "living"


def living_part(
    identification: Identification, axis: Axis | None, simulation: SimulationResult | None = None, following: Following | None = None
) -> Living | None:
    """Return what makes the report of an identification move; None where the model cannot be computed on a page."""
    fit = identification.best
    rows = fitted_rows(fit, identification.log, axis, identification.treatment)
    if rows is None:
        return None
    uncertainty = uncertainty_of(fit)
    try:
        model = described(fit.friction, uncertainty=uncertainty, around=AROUND, proven=False)
    except InputError:
        return None
    moved = [column.name for column in rows.mechanical if column.name]
    plant = [row for row in variables_of(fit.plant, moved, model["scales"]["force"], uncertainty, AROUND) if not row["fixed"]]
    data = {
        "model": model,
        "plant": plant,
        "rows": rows.as_data(),
        "effort": typeset(unit_of("force", fit.plant.kind)),
        "word": "torque" if fit.plant.kind == "rotational" else "force",
        "logs": 1 + len(identification.further_logs),
        "loop": followed_part(fit.friction, simulation, following),
    }
    shared, script = joined(SHARED), joined(SCRIPTS)
    texts = (Markup(text) for text in (joined(STYLES), shared, script, as_json(data)))
    return Living(policy([shared, script]), *texts, follows=data["loop"] is not None)


def uncertainty_of(fit: Fit) -> dict[str, Mapping[str, Any]]:
    """Return of each parameter whether it is identified, and its 95 % interval where there is one."""
    return {name: {"status": estimate.status, "interval": estimate.ends} for name, estimate in fit.parameters.items()}


def followed_part(friction: Model, simulation: SimulationResult | None, following: Following | None) -> dict[str, Any] | None:
    """Return how the loop followed, and what computes it; None where nothing followed."""
    errors = _errors(simulation, following)
    if not errors:
        return None
    loop: dict[str, Any] | None = None
    variants = () if simulation is None else simulation.experiment.variants
    variant = next((variant for variant in variants if variant.name == COMPENSATED), None)
    if following is not None and following.contradiction is not None:
        reason = "the log contradicts the simulated loop"
    elif variant is None:
        reason = "no loop was simulated, for which the axis file needs a controller"
    elif not (reason := _reason_against(variant, friction)):
        try:
            loop = _loop(variant, friction)
        except InputError:
            reason = "a part of it cannot be computed on a page"
    return {"traces": [_trace(name, time, error) for name, time, error in errors], "reason": reason, "loop": loop}


def _errors(simulation: SimulationResult | None, following: Following | None) -> list[tuple[str, np.ndarray, np.ndarray]]:
    """Return name, time and following error of the log and of each loop that the report tells of."""
    rows = [] if following is None else [("measured", following.time, following.error)]
    contradicted = following is not None and following.contradiction is not None
    if simulation is None:
        return rows
    variants = simulation.experiment.variants[: 1 if contradicted else None]
    results = [simulation.variants[variant.name] for variant in variants]
    return rows + [
        (result.name, result.time, result.reference - result.measured) for result in results if result.status is not Status.NOT_FINITE
    ]


def _trace(name: str, time: np.ndarray, error: np.ndarray) -> dict[str, Any]:
    """Return a following error over time as few points that look the same."""
    from bristle.figures.style import envelope

    samples = envelope(error, 1000)  # columns of its line
    step = float(np.max(np.abs(error))) / 4096.0 or 1.0  # so many steps to its largest value
    numbers = [differences(samples.astype(float), 2), differences(np.round(error[samples] / step), 1)]
    return {
        "name": name,
        "numbers": packed_numbers(numbers),
        "count": samples.size,
        "step": step,
        "time": float(time[0]),
        "sampleTime": float(time[1] - time[0]),
    }


def _reason_against(variant: Variant, friction: Model) -> str:
    """Return why a page cannot compute a loop; nothing where it can."""
    fed = variant.feedforward
    if variant.plant.name != "inertia" or variant.table is not None:
        return "the axis is more than one mass"
    if rises_with_effort(variant.friction):
        return "the friction of the axis rises with the effort"
    if fed.friction != friction or fed.along != "desired" or fed != Feedforward(mass=fed.mass, friction=friction):
        return "another force is fed forward than the friction alone"
    if variant.sensor.component is not ENCODER or variant.run.tolerance or variant.learning is not None:
        return "its measurement or its integration is another one"
    return ""


def _loop(variant: Variant, friction: Model) -> dict[str, Any]:
    """Return what computes a loop: laws, numbers, and how it begins."""
    run, dt = variant.run, variant.run.sample_time
    count = min(round(run.duration / dt), 25_000)  # as many samples as a page carries
    reference = variant.reference.component.sample(dt * np.arange(count), variant.reference.parameters)
    x, v, a = (float(signal[0]) for signal in reference)
    start, law = variant.start or Start(x, v, a), within_drive(variant.controller, run.effort_limit, variant.injected)
    # A perfect encoder reads the first position as it is; one with counts, the nearest of them.
    sensor = variant.sensor.parameters
    read, _ = ENCODER.step(ENCODER.initial_state(sensor), start.position, dt, sensor)
    state = begun(law, Reference(x, v, a, 0.0), read, start.velocity, start.acceleration, start.effort, dt)
    left = drive_over(dt / run.substeps, 0.0, run.current_lag)
    body = None if variant.friction == friction else body_described(variant.friction)
    return parts_described(variant.sensor, law=(law, state)) | {
        "body": body,
        "bodyValues": values_of(variant.friction) if body is None else body["values"],
        "count": count,
        "M": variant.plant.values["M"],
        "mass": variant.feedforward.mass,
        "all": round(run.duration / dt),
        "sampleTime": dt,
        "substeps": run.substeps,
        "delay": run.delay,
        "limit": run.effort_limit,
        "lag": {"inMean": left.in_mean, "atEnd": left.at_end},
        "effortBefore": start.effort or 0.0,
        "begin": _begin(variant, start),
        "settle": round(run.settle / dt),
        **_signals(variant, reference[0], count),
    }


def _begin(variant: Variant, start: Start) -> list[tuple[int, float]]:
    """Return the numbers that last of the mass and its contact at first: (place, number)."""
    numbers = [(0, start.position), (1, start.velocity)]
    if variant.start is None or not start.velocity:
        return numbers
    state, memory = settled(variant.friction, start.velocity)
    contact = len(BODY.State._fields)
    numbers += [(contact + i, float(number)) for i, number in enumerate(state)]
    return numbers + [(contact + len(state) + SOLVER + i, float(number)) for i, number in enumerate(memory)]


def _signals(variant: Variant, position: np.ndarray, count: int) -> dict[str, Any]:
    """Return the reference and what pushes the axis, as whole numbers times a step."""
    origin, moved = float(position[0]), position - position[0]
    # A fine step in a count of the encoder, or in the longest step of the reference itself.
    step = (variant.sensor.values["resolution"] or float(np.max(np.abs(np.diff(moved))))) / (2**12) or 1.0
    step = max(step, float(np.max(np.abs(moved))) / 2**29)
    force = np.zeros(count) if variant.disturbance is None else np.asarray(variant.disturbance)[:count]
    if variant.injected is not None:  # the same while the drive is not at its limit
        force = force - np.asarray(variant.injected)[:count]
    pushed = float(np.sqrt(np.mean(force**2))) / 16.0 or 1.0
    numbers = [differences(np.round(moved / step), 2), differences(np.round(force / pushed), 1)]
    return {"origin": origin, "step": step, "pushed": pushed, "numbers": packed_numbers(numbers)}
