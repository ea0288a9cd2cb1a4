"""Data for simulations on a page: laws and an encoder as a module, a loop of an experiment, and the loops of a report.

The mass, its friction and the feedforward are modules of friction models. A law starts like a simulation; its state contains its
inputs at a sample. In a report the simulated axis stays the same, under the unexplained force.
"""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from bristle.apps.targets.page.described import (
    body_described,
    model_described,
    values_of,
    variables_of,
)
from bristle.apps.targets.page.packing import differences, packed, packed_numbers
from bristle.apps.targets.page.rows import fitted_rows
from bristle.apps.targets.wasm import Part, module_of_parts
from bristle.core import Axis, Controller, InputError, Model, Reference, Status, typeset, unit_of
from bristle.core.experiment import Feedforward, Start, Variant
from bristle.engine.loop import begun
from bristle.engine.mechanism import drive_over
from bristle.engine.motion import settled
from bristle.engine.translation.build import Builder
from bristle.engine.translation.scope import defined
from bristle.engine.translation.tree import REAL, Array, type_of
from bristle.exports.cycle import SOLVER
from bristle.identification.result import Identification
from bristle.models.controllers.law import law
from bristle.models.controllers.limits import within_drive
from bristle.models.friction.level import rises_with_effort
from bristle.models.plants.pulled_inertia import MODEL as BODY
from bristle.models.sensors.encoder import MODEL as ENCODER
from bristle.prediction.following import Following
from bristle.simulation import COMPENSATED, SimulationResult

# State array of a law: flag for the first sample, inputs, state of the controller.
BEGUN = 0
SAMPLE = ("position", "velocity", "acceleration", "effort")
STATE = 1 + len(SAMPLE)
WORDS = {"translational": "force", "rotational": "torque"}
LAW = """
def command(lasting, x, dt, p):
    state = State({load})
    if lasting[0] == 0.0:
        state = start(x, lasting[2], lasting[3], dt, p)
    reference = Reference(lasting[1], lasting[2], lasting[3], lasting[4])
    effort, after = law(state, reference, x, 0.0, LIMIT, dt, p)
    lasting[0] = 1.0
{store}
    return effort
"""
SENSE = """
def sense(lasting, x, dt, p):
    read, after = step(State(int(lasting[0])), x, dt, p)
    lasting[0] = after.samples
    return read
"""
LIMIT = 1e300  # [N or N*m]


def law_kernel(component: Controller) -> Any:
    """Return the law of a controller as a kernel of its state array, measured position, time step and parameters."""
    names = component.State._fields
    load = ", ".join(f"lasting[{STATE + i}]" for i in range(len(names)))
    store = "\n".join(f"    lasting[{STATE + i}] = after.{name}" for i, name in enumerate(names))
    scope = {
        "State": component.State,
        "start": component.start,
        "Reference": Reference,
        "law": law,
        "LIMIT": LIMIT,
    }
    return defined("command", LAW.format(load=load, store=store), {"__name__": __name__, **scope})


def law_part(builder: Builder, controller: Model, state: Any) -> Part:
    """Return a law as a part of a module; without a given state, it initializes itself."""
    begin = np.zeros(STATE + len(controller.component.State._fields))
    if state is not None:
        begin[BEGUN] = 1.0
        begin[STATE:] = state
    component = controller.component
    assert isinstance(component, Controller)
    entry = builder.function(
        law_kernel(component),
        [Array(begin.size, writable=True), REAL, REAL, type_of(controller.parameters)],
    )
    return Part(entry, begin, controller)


def sensor_part(builder: Builder, sensor: Model) -> Part:
    """Return an encoder as a part of a module."""
    scope = {"__name__": __name__, "State": ENCODER.State, "step": ENCODER.step}
    kernel = defined("sense", SENSE, scope)
    entry = builder.function(
        kernel, [Array(1, writable=True), REAL, REAL, type_of(sensor.parameters)]
    )
    return Part(entry, np.zeros(1), sensor)


def parts_described(sensor: Model, **laws: tuple[Model, Any]) -> dict[str, Any]:
    """Return a packed module of laws, each with its initial state, and an encoder."""
    builder = Builder()
    parts = {name: law_part(builder, law, state) for name, (law, state) in laws.items()}
    binary, addresses = module_of_parts(builder, parts | {"sense": sensor_part(builder, sensor)})
    return {"code": packed(binary), "parts": addresses}


def tracking_described(plain: Variant, observing: Variant) -> dict[str, Any]:
    """Return module and numbers of a loop for a page, with sliding mode alone and with a disturbance observer."""
    laws = {"sliding": (plain.controller, None), "observer": (observing.controller, None)}
    return parts_described(plain.sensor, **laws) | {
        "rig": body_described(plain.friction),
        "paper": {
            "K_2": plain.controller.values["K_2"],
            "g": observing.controller.values["g"],
            "frequency": plain.reference.values["frequency"],
        },
        "sampleTime": plain.run.sample_time,
        "delay": plain.run.delay,
    }


def _reason_against(variant: Variant, friction: Model) -> str:
    """Return the reason why a page cannot compute a loop; empty if it can."""
    fed = variant.feedforward
    if variant.plant.name != "inertia" or variant.table is not None:
        return "the axis has more than one mass"
    if rises_with_effort(variant.friction):
        return "the friction of the axis rises with the effort"
    if (
        fed.friction != friction
        or fed.along != "desired"
        or fed != Feedforward(mass=fed.mass, friction=friction)
    ):
        return "the feedforward contains more than this friction"
    if (
        variant.sensor.component is not ENCODER
        or variant.run.tolerance
        or variant.learning is not None
    ):
        return "the sensor, the integrator or learning is not available on a page"
    return ""


def _loop(variant: Variant, friction: Model) -> dict[str, Any]:
    """Return the data of a loop of an experiment: its law, its numbers, and its start."""
    run = variant.run
    dt = variant.run.sample_time
    count = min(round(run.duration / dt), 25_000)  # limit of samples on a page
    reference = variant.reference.component.sample(
        dt * np.arange(count), variant.reference.parameters
    )
    x, v, a = (float(signal[0]) for signal in reference)
    start = variant.start or Start(x, v, a)
    law = within_drive(variant.controller, run.effort_limit, variant.injected)
    # A perfect encoder reads the exact first position, an encoder with counts the nearest count.
    sensor = variant.sensor.parameters
    read, _ = ENCODER.step(ENCODER.initial_state(sensor), start.position, dt, sensor)
    state = begun(
        law, Reference(x, v, a, 0.0), read, start.velocity, start.acceleration, start.effort, dt
    )
    left = drive_over(dt / run.substeps, 0.0, run.current_lag)
    body = None
    values = values_of(variant.friction)
    if variant.friction != friction:
        body = body_described(variant.friction)
        values = body["values"]
    return parts_described(variant.sensor, law=(law, state)) | {
        "body": body,
        "bodyValues": values,
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
    """Return the initial state of the mass and its contact: (index, number)."""
    numbers = [(0, start.position), (1, start.velocity)]
    if variant.start is None or not start.velocity:
        return numbers
    state, memory = settled(variant.friction, start.velocity)
    contact = len(BODY.State._fields)
    numbers += [(contact + i, float(number)) for i, number in enumerate(state)]
    return numbers + [
        (contact + len(state) + SOLVER + i, float(number)) for i, number in enumerate(memory)
    ]


def _signals(variant: Variant, position: np.ndarray, count: int) -> dict[str, Any]:
    """Return the reference and the forces on the axis, as whole numbers times a step."""
    origin = float(position[0])
    moved = position - position[0]
    # A fine step within a count of the encoder, or within the longest step of the reference.
    within = variant.sensor.values["resolution"]
    if not within:
        within = float(np.max(np.abs(np.diff(moved))))
    step = within / 2**12 or 1.0
    step = max(step, float(np.max(np.abs(moved))) / 2**29)
    if variant.disturbance is None:
        force = np.zeros(count)
    else:
        force = np.asarray(variant.disturbance)[:count]
    if variant.injected is not None:  # the same while the drive is not at its limit
        force = force - np.asarray(variant.injected)[:count]
    pushed = float(np.sqrt(np.mean(force**2))) / 16.0 or 1.0
    numbers = [differences(np.round(moved / step), 2), differences(np.round(force / pushed), 1)]
    return {"origin": origin, "step": step, "pushed": pushed, "numbers": packed_numbers(numbers)}


def loop_described(variant: Variant, friction: Model) -> tuple[dict[str, Any] | None, str]:
    """Return the data of a loop of an experiment and an empty text, or None and the reason if a page cannot compute it."""
    if reason := _reason_against(variant, friction):
        return None, reason
    try:
        return _loop(variant, friction), ""
    except InputError:
        return None, "a page cannot compute a part of the loop"


def trace_described(
    name: str, time: np.ndarray, error: np.ndarray, samples: np.ndarray
) -> dict[str, Any]:
    """Return selected samples of a following error over time, as whole numbers times a step."""
    step = float(np.max(np.abs(error))) / 4096.0 or 1.0  # steps up to its largest value
    numbers = [
        differences(samples.astype(float), 2),
        differences(np.round(error[samples] / step), 1),
    ]
    return {
        "name": name,
        "numbers": packed_numbers(numbers),
        "count": samples.size,
        "step": step,
        "time": float(time[0]),
        "sampleTime": float(time[1] - time[0]),
    }


def living_described(
    identification: Identification,
    axis: Axis | None,
    simulation: SimulationResult | None,
    following: Following | None,
    *,
    uncertainty: Mapping[str, Mapping[str, Any]],
    around: float,
    thinned: Callable[[np.ndarray], np.ndarray],
) -> dict[str, Any] | None:
    """Return the data of an interactive report of an identification; None if a page cannot compute the model.

    Sliders reach from an identified value over `around` to the value times `around`; `thinned` returns the samples of a line
    to draw.
    """
    fit = identification.best
    rows = fitted_rows(fit, identification.log, axis, identification.treatment)
    if rows is None:
        return None
    try:
        model = model_described(fit.friction, uncertainty=uncertainty, around=around, proven=False)
    except InputError:
        return None
    moved = [column.name for column in rows.mechanical if column.name]
    plant = [
        row
        for row in variables_of(fit.plant, moved, model["scales"]["force"], uncertainty, around)
        if not row["fixed"]
    ]
    return {
        "model": model,
        "plant": plant,
        "rows": rows.as_data(),
        "effort": typeset(unit_of("force", fit.plant.kind)),
        "word": WORDS[fit.plant.kind],
        "logs": 1 + len(identification.further_logs),
        "loop": followed_described(fit.friction, simulation, following, thinned),
    }


def followed_described(
    friction: Model,
    simulation: SimulationResult | None,
    following: Following | None,
    thinned: Callable[[np.ndarray], np.ndarray],
) -> dict[str, Any] | None:
    """Return the following errors of the loop, and the data to compute it; None without a following error."""
    errors = _errors(simulation, following)
    if not errors:
        return None
    loop: dict[str, Any] | None = None
    variants = ()
    if simulation is not None:
        variants = simulation.experiment.variants
    variant = next((variant for variant in variants if variant.name == COMPENSATED), None)
    if following is not None and following.contradiction is not None:
        reason = "the log contradicts the simulated loop"
    elif variant is None:
        reason = "no loop was simulated: the axis file has no controller"
    else:
        loop, reason = loop_described(variant, friction)
    traces = [trace_described(name, time, error, thinned(error)) for name, time, error in errors]
    return {"traces": traces, "reason": reason, "loop": loop}


def _errors(
    simulation: SimulationResult | None, following: Following | None
) -> list[tuple[str, np.ndarray, np.ndarray]]:
    """Return name, time and following error of the log and of each loop in the report."""
    rows = []
    if following is not None:
        rows = [("measured", following.time, following.error)]
    if simulation is None:
        return rows
    variants = simulation.experiment.variants
    if following is not None and following.contradiction is not None:
        variants = variants[:1]
    results = [simulation.variants[variant.name] for variant in variants]
    return rows + [
        (result.name, result.time, result.reference - result.measured)
        for result in results
        if result.status is not Status.NOT_FINITE
    ]
