"""Prediction of a log by a model, compared with the measurement."""

from collections.abc import Mapping
from dataclasses import replace
from os import PathLike
from typing import Any

import numpy as np

from bristle.core import Diagnostic, InputError, Model, Status, unit_of
from bristle.core.axis import DELAY, Axis
from bristle.core.edge import Amount, among, amount, guarded, instance, model, optional
from bristle.engine.checks import finite
from bristle.files.arguments import AXIS, LOG, log_and_axis
from bristle.files.model import TREATMENT
from bristle.identification.dataset import Dataset
from bristle.identification.parameters import refuse_unrecorded
from bristle.identification.preprocessing import differentiated, treat_all
from bristle.identification.request import treatment_of
from bristle.identification.result import Bands, Fit, Traces
from bristle.identification.simulated_bands import half_width, simulated_widths
from bristle.logs.check import RECORDED, checked, parted
from bristle.logs.log import Channel, Log
from bristle.logs.look import CheckThresholds
from bristle.models.friction import is_static, with_presliding
from bristle.simulation.recorded.closed_loop import LOOPS, START_SAMPLES, Course, Stretch
from bristle.simulation.result import Prediction
from bristle.simulation.statistics import relative_error_percent

MODES = ("inverse", *LOOPS)
MOST_SAMPLES = 200_000  # in traces of every sample
# Settings that repeat the treatment of a log.
TREATED = ("cutoff", "delay", "smoothing", "slow", "position_smoothing")
SPAN = 20  # samples of a difference for a speed
# A converter for each number of a treatment.
OF_TREATMENT = {
    name: optional(amount(variable)) for name, variable in (TREATMENT | {"delay": DELAY}).items()
}


@guarded(
    plant=model("plant"),
    friction=model("friction"),
    mode=among(*MODES),
    **{
        name: converter
        for name, converter in OF_TREATMENT.items()
        if name not in ("cutoff", "decimation")
    },
    bands=optional(
        instance(
            Bands,
            "an object of class Bands",
            read=lambda table: Bands(**table) if isinstance(table, dict) else table,
        )
    ),
)
def predict(
    plant: Model,
    friction: Model,
    log: Any,
    axis: Axis | str | PathLike[str] | None = None,
    mode: str = "inverse",
    *,
    cutoff: float | str | None = None,
    decimation: int | None = None,
    velocity_max: Amount | None = None,
    delay: Amount | None = None,
    smoothing: Amount | None = None,
    slow: Amount | None = None,
    lag: Amount | None = None,
    bands: Any = None,
    position_smoothing: Amount | None = None,
    stiffness: Amount | None = None,
    stiffness_half_width: Amount | None = None,
) -> Prediction:
    """Predict a log with a model.

    Parameters
    ----------
    plant, friction : Model
        The inertia and the friction model.
    log : Log or path-like
        The measurement, or its file. Its known inputs are injected in closed loop.
    axis : Axis or path-like, optional
        Gives the controller of the log (needed in closed loop), encoder resolution, limit of the effort.
    mode : {"inverse", "closed-loop", "open-loop"}
        ``inverse``: the effort from the measured motion, filtered and decimated as in the identification.
        ``closed-loop``: effort and motion from the reference. ``open-loop``: the motion from the measured effort. It
        begins at the 20th sample, where the velocity is known from both sides, or at the first sample if the axis file
        states that logs begin at rest.
    cutoff, decimation : float or str, int, optional
        Cut-off [Hz, or text with a unit] and decimation of the identification, for the inverse mode; by default the
        values of the axis file.

    velocity_max : float or str, optional
        Largest speed of the fitted data [m/s or rad/s]: the prediction warns about a log with much higher speeds.
    delay : float or str, optional
        Delay of the effort after the position, found by the identification [s], for the inverse mode.
    smoothing : float or str, optional
        Time constant of a filter on the effort in addition to that of the position, found by the identification [s];
        negative if the effort is filtered less. For the inverse mode.
    slow : float or str, optional
        Cut-off of the instruments [Hz], if the identification estimated the channels before the fit: accelerations
        then have the same bandwidth as in the identification. For the inverse mode.
    lag : float or str, optional
        Time constant of the drive after its controller, found by the identification [s], for the closed loop;
        by default the lag in the axis file.
    bands : Bands or dict, optional
        Uncertainty of the model, or its table in a model file; the prediction then has a 95 % band.
    position_smoothing : float or str, optional
        Time constant of a filter on the position, found by the identification [s], for the inverse mode.
    stiffness, stiffness_half_width : float or str, optional
        Further numbers of the treatment of an identification, which do not change a prediction [N/m or N*m/rad].

    Returns
    -------
    Prediction
        Measured and predicted signals, and the errors ``100 ||y - y_hat|| / ||y||`` [%].

    Raises
    ------
    InputError
        If the log or the axis lacks what the mode needs.
    """
    log, axis = log_and_axis(log, axis)
    if plant.kind != log.kind:
        raise InputError(
            "is of another kind of axis than the log",
            path="model",
            value=plant.kind,
            allowed=log.kind,
            mend="Give the axis file of the identification",
        )
    if log.effort is None:
        raise InputError(
            "has no effort to compare with or to apply",
            path="log",
            mend="Name the column of the effort in the axis file",
        )
    log = parted(log, axis)
    if mode == "inverse":
        frequency, stride = treatment_of(cutoff, decimation, log.kind)
        remarks = ()
        limit = frequency
        if limit is None and axis is not None:
            limit = axis.cutoff
        # Sampled too slowly for the filter of the identification.
        if limit is not None and limit * log.sample_time >= 0.5:
            frequency = 0.4 / log.sample_time  # a cut-off that fits the sampling
            stride = 1
            remarks = (
                Diagnostic(
                    "filtered", severity="note", numbers={"wanted": limit, "cutoff": frequency}
                ),
            )
        channels = {
            "delay": delay,
            "smoothing": smoothing,
            "slow": slow,
            "position_smoothing": position_smoothing,
        }
        dataset = rows_as_fitted(log, axis, {"cutoff": frequency, **channels}, stride)
        refuse_unrecorded(friction.component, dataset)
        width = None
        if bands is not None:
            width = half_width(bands, plant, friction, dataset)
        return with_doubts(
            _inverse(plant, friction, log, dataset, width, remarks), log, axis, velocity_max
        )
    if axis is None:
        axis = Axis(kind=log.kind)
    if lag is not None:
        axis = replace(axis, lag=lag)
    return with_doubts(_simulated(plant, friction, log, axis, mode, bands), log, axis, velocity_max)


def _simulated(
    plant: Model, friction: Model, log: Log, axis: Axis, mode: str, bands: Bands | None
) -> Prediction:
    about: list[Diagnostic] = []
    if axis.presliding and is_static(friction):
        friction = with_presliding(friction, axis.presliding)
        about.append(
            Diagnostic("presliding_distance", "", "note", {"distance": axis.presliding}, log.kind)
        )
    segments = log.segments or (slice(0, len(log)),)
    runs = []
    used = []
    widths = []
    for part in segments:
        stretch = Stretch.of(log, axis, mode, part)
        if stretch.count <= START_SAMPLES:
            about.append(
                Diagnostic("short_stretch", severity="note", numbers={"samples": stretch.count})
            )
            continue
        runs.append(stretch.run(plant, friction, np.zeros(stretch.count)))
        first = stretch.samples.start
        used.append(slice(first, first + runs[-1].position.size))
        about += runs[-1].diagnostics
        if bands is not None:
            widths.append(simulated_widths(bands, plant, friction, runs[-1], stretch))
    if not runs:
        raise InputError(
            "no stretch of the log is long enough",
            path="log",
            allowed=f"> {2 * START_SAMPLES} samples",
        )
    prediction = _compare(
        mode,
        log,
        runs,
        used,
        tuple(about[i] for i in range(len(about)) if about[i] not in about[:i]),
    )
    if not widths:
        return prediction
    position, effort = (np.concatenate([pair[side] for pair in widths]) for side in range(2))
    if prediction.effort_predicted is None:
        effort = None
    return replace(prediction, position_half_width=position, half_width=effort)


def _inverse(
    plant: Model,
    friction: Model,
    log: Log,
    dataset: Dataset,
    width: np.ndarray | None,
    remarks: tuple[Diagnostic, ...],
) -> Prediction:
    notes = list(remarks)
    predicted = finite(dataset.rows_of(dataset.explained(plant, friction)), friction, "friction")
    # The initial state of the contact in each stretch, if it matters.
    percents = tuple(
        100.0 * place for place in dataset.contacts(friction, plant) if place is not None
    )
    if percents:
        notes.append(
            Diagnostic("start_of_contact", severity="note", numbers={"percents": percents})
        )
    notes.append(
        Diagnostic(
            "filtered",
            severity="note",
            numbers={"cutoff": dataset.cutoff, "decimation": dataset.decimation},
        )
    )
    signals = (
        dataset.time,
        dataset.effort,
        predicted,
        dataset.rows_of([segment.position for segment in dataset.segments]),
        None,
    )
    return replace(
        _prediction("inverse", log, *signals), half_width=width, diagnostics=tuple(notes)
    )


def _compare(
    mode: str, log: Log, runs: list[Course], used: list[slice], about: tuple[Diagnostic, ...]
) -> Prediction:
    assert log.effort is not None
    time, effort, position = (
        np.concatenate([channel.values[part] for part in used])
        for channel in (log.time, log.effort, log.position)
    )
    command = None
    if mode == "closed-loop":
        command = np.concatenate([run.command for run in runs])
    reached = np.concatenate([run.position for run in runs])
    status = max((run.status for run in runs), key=int)
    return replace(
        _prediction(mode, log, time, effort, command, position, reached, status), diagnostics=about
    )


def _prediction(
    mode: str,
    log: Log,
    time: np.ndarray,
    effort: Any,
    effort_hat: Any,
    position: Any,
    position_hat: Any,
    status: Status = Status.OK,
) -> Prediction:
    """Return measurement and prediction, with their errors; no errors for a simulation that diverged."""
    metrics: dict[str, float | str | None] = {}
    for name, quantity, signal, predicted in (
        ("force", "force", effort, effort_hat),
        ("position", "length", position, position_hat),
    ):
        metrics[f"{name}_error_percent"] = None
        metrics[f"{name}_rmse"] = None
        if predicted is not None and status != Status.NOT_FINITE:
            metrics[f"{name}_error_percent"] = relative_error_percent(signal, predicted)
            metrics[f"{name}_rmse"] = float(np.sqrt(np.mean((signal - predicted) ** 2)))
        metrics[f"{name}_unit"] = unit_of(quantity, log.kind)
    return Prediction(
        mode,
        time,
        effort,
        effort_hat,
        position,
        position_hat,
        metrics,
        status,
        log=log.source.name.strip("<>"),
    )


def rows_as_fitted(
    log: Log,
    axis: Axis | None,
    treatment: Mapping[str, float | None],
    decimation: int | None = None,
) -> Dataset:
    """Return the rows of a log, treated as in identification, by the settings in `TREATED`."""
    times = {
        name: treatment.get(name) or 0.0 for name in ("delay", "smoothing", "position_smoothing")
    }
    for name, seconds in times.items():
        if not abs(seconds) < log.duration:
            raise InputError(
                "is longer than the log",
                path=name,
                value=seconds,
                allowed=f"< {log.duration:.3g} s",
            )
    dataset = treat_all([log], [axis], treatment.get("cutoff"), decimation, *times.values())
    if treatment.get("slow"):
        return differentiated(dataset)
    return dataset


def effort_of_motion(
    plant: Model,
    friction: Model,
    columns: Mapping[str, np.ndarray],
    axis: Axis | None,
    treatment: Mapping[str, float],
) -> np.ndarray:
    """Return the effort of a motion, treated as the log of an identification; NaN in rows outside all stretches."""
    # The delay is that of an effort: without an effort, samples are neither shifted nor lost.
    log = Log.from_columns(columns, axis=axis and replace(axis, delay=0.0))
    # The effort is unknown: rows are treated as those of a log with zero effort.
    log = replace(log, effort=Channel(np.zeros(len(log)), unit_of("force", log.kind), "y"))
    dataset = rows_as_fitted(
        log,
        axis,
        {name: treatment.get(name) for name in ("cutoff", "position_smoothing", "slow")},
        1,
    )
    # Without an effort the initial state of a contact in a segment is unknown.
    efforts = dataset.explained(plant, friction, contacts=(None,) * len(dataset.segments))
    time = columns["time"]
    around = 0.5 * dataset.sample_time
    lag = treatment.get("delay", 0.0)
    if axis is not None:
        lag += axis.delay
    predicted = np.full(time.size, np.nan)
    for segment, effort in zip(dataset.segments, efforts, strict=True):
        inside = (time >= segment.time[0] - around) & (time <= segment.time[-1] + around)
        predicted[inside] = np.interp(time[inside] - lag, segment.time, effort)
    return predicted


@guarded(
    plant=model("plant"),
    friction=model("friction"),
    log=LOG,
    axis=optional(AXIS),
    **{name: OF_TREATMENT[name] for name in TREATED},
)
def unexplained_force(
    plant: Model,
    friction: Model,
    log: Log,
    axis: Axis | None = None,
    *,
    cutoff: Amount | None = None,
    delay: Amount | None = None,
    smoothing: Amount | None = None,
    slow: Amount | None = None,
    position_smoothing: Amount | None = None,
) -> np.ndarray:
    """Return the residual force of a model, at the rate of the log.

    It is the effort minus inertia and friction, after the filter of the identification. It is zero at
    rest, where friction balances any effort, and at the edges of a stretch. Replayed as a disturbance, it
    adds the force that the model lacks to a simulation, so that a compensator is not tested on its own model.

    Parameters
    ----------
    plant, friction : Model
        The model.
    log : Log
        The log.
    axis : Axis, optional
        Its cut-off and encoder resolution are used.
    cutoff : float or str, optional
        Cut-off of the identification [Hz]; by default that of the axis file.
    delay, smoothing, slow, position_smoothing : float or str, optional
        Treatment of the channels in the identification, as in `predict`; without treatment by default.

    Returns
    -------
    ndarray, shape (sample,)
        Force [N or N*m].
    """
    channels = {
        "delay": delay,
        "smoothing": smoothing,
        "slow": slow,
        "position_smoothing": position_smoothing,
    }
    dataset = rows_as_fitted(log, axis, {"cutoff": cutoff, **channels})
    force = np.zeros(len(log))
    for segment, explained in zip(
        dataset.segments, dataset.explained(plant, friction), strict=True
    ):
        residual = np.where(segment.velocity == 0.0, 0.0, segment.effort - explained)
        residual[: dataset.dropped] = residual[residual.size - dataset.dropped :] = 0.0
        first = int(np.searchsorted(log.time.values, segment.time[0]))
        force[first : first + residual.size] = residual
    return finite(force, friction, "friction")


def with_doubts(
    prediction: Prediction, log: Log, axis: Axis | None, velocity_max: float | None
) -> Prediction:
    """Return a prediction with its warnings."""
    settings = CheckThresholds.among(axis.settings if axis else {})
    wrong = (
        diagnostic for diagnostic in checked(log, axis, settings) if diagnostic.code in RECORDED
    )
    doubts: list[Diagnostic] = []
    for key, signal in (("position", "position"), ("force", "effort")):
        percent = prediction.metrics.get(f"{key}_error_percent")
        if not doubts and isinstance(percent, float) and percent > 100.0:
            doubts.append(
                Diagnostic("worse_than_none", numbers={"signal": signal, "percent": percent})
            )
    positions = [log.position.values[part] for part in log.segments or (slice(None),)]
    travels = [
        np.max(np.abs(position[SPAN:] - position[:-SPAN]))
        for position in positions
        if position.size > SPAN
    ]
    top = float(max(travels, default=0.0)) / (SPAN * log.sample_time)
    if velocity_max is not None and top > 1.5 * velocity_max:
        doubts.append(
            Diagnostic(
                "beyond_speed",
                "",
                "warning",
                {"speed": top, "fitted_speed": velocity_max},
                log.kind,
            )
        )
    return replace(prediction, diagnostics=(*doubts, *wrong, *prediction.diagnostics))


def fit_at_samples(fit: Fit, log: Log, axis: Axis | None, treatment: Mapping[str, float]) -> Fit:
    """Return a fit with traces of each sample of a log, filtered but not decimated; of at most `MOST_SAMPLES`."""
    stride = -(-len(log) // MOST_SAMPLES)
    rows = rows_as_fitted(log, axis, treatment, min(stride, int(treatment.get("decimation", 1))))
    predicted = rows.rows_of(rows.explained(fit.plant, fit.friction))
    traces = Traces(
        rows.time,
        rows.velocity,
        rows.acceleration,
        rows.effort,
        predicted,
        rows.mechanical_rows(fit.plant),
    )
    return replace(fit, traces=traces)
