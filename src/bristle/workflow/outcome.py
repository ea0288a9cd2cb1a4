"""What is told of an identification: the table for the drive, the loop, certificates; its summary and its report.

Commands, demonstration and calls from Python do this part of the work here.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bristle.core.axis import Axis
from bristle.core.errors import InputError
from bristle.core.lazy import cached_property
from bristle.prediction.drive_table import drive_table, steady_curve

if TYPE_CHECKING:
    from bristle.certificates import Certificate
    from bristle.core.contracts import Model
    from bristle.core.experiment import Experiment
    from bristle.figures import ReportFigure
    from bristle.files.experiment_text import NextExperiment
    from bristle.files.results import Results
    from bristle.identification.result import Identification
    from bristle.prediction.following import Following
    from bristle.simulation.result import Prediction, SimulationResult

    Loop = tuple[SimulationResult | None, Prediction | None, Following | None]

__all__ = ["ENTRIES", "EXPERIMENT", "Outcome", "outcome_of"]

ENTRIES = 20  # of the table for the drive
EXPERIMENT = "experiment.toml"
"""What the experiment file is called that an identification leaves."""

Progress = Callable[[float, str], None]


@dataclass(frozen=True)
class Outcome:
    """An identification and what follows from it.

    Parameters
    ----------
    identification : Identification
        The models, best first.
    table : list of (float, float)
        Velocity and friction for a drive [m/s or rad/s, N or N*m].
    simulation : SimulationResult or None
        The loop without and with compensation.
    prediction : Prediction or None
        A log as the best model predicts it.
    certificates : mapping of str to Certificate
        Whether the best model is fit to be used.
    uncertified : str
        Why there are no certificates; empty where there are.
    provenance : mapping of str to str
        Versions, files, checksums.
    command : str
        What repeats it.
    axis_name : str
        What people call the axis.
    banner : str or None
        What a reader of the report must know before anything else.
    axes : tuple of bytes
        The axis files as used, that of the first log first.
    following : Following or None
        How the axis followed its reference in the log, and whether the simulation agrees.
    axis : Axis or None
        That of the first log: the units of its drive.
    figures : tuple of ReportFigure
        A user's own, for the report.
    looped : Experiment or None
        The loop of the log with the best model; None without a loop.
    """

    identification: Identification
    table: list[tuple[float, float]]
    simulation: SimulationResult | None
    prediction: Prediction | None
    certificates: Mapping[str, Certificate]
    uncertified: str
    provenance: Mapping[str, str]
    command: str
    axis_name: str
    banner: str | None = None
    axes: tuple[bytes, ...] = ()
    following: Following | None = None
    axis: Axis | None = None
    figures: tuple[ReportFigure, ...] = ()
    looped: Experiment | None = None

    @cached_property
    def summary(self) -> dict[str, Any]:
        """The numbers, as ``summary.json`` holds them."""
        from bristle.report.summary import identification_summary

        return identification_summary(
            self.identification,
            table=self.table,
            simulation=self.simulation,
            prediction=self.prediction,
            provenance=self.provenance,
            certificates=self.certificates,
            following=self.following,
            axis=self.axis,
        )

    @cached_property
    def page(self) -> str:
        """The report, one HTML page, whose parameters can be moved where a page can compute the model."""
        from bristle.lab.living import living_part
        from bristle.report.identification import identification_report

        return identification_report(
            self.identification,
            prediction=self.prediction,
            simulation=self.simulation,
            table=self.table,
            command=self.command,
            axis_name=self.axis_name,
            provenance=self.provenance,
            certificates=self.certificates,
            banner=self.banner,
            following=self.following,
            axis=self.axis,
            figures=self.figures,
            living=living_part(self.identification, self.axis, self.simulation, self.following),
        )

    def following_experiment(self, folder: Path) -> NextExperiment:
        """Return the experiment file that lies in a folder beside the model: the next step."""
        from bristle.files.experiment_text import next_experiment

        log, plant = self.identification.log, self.identification.best.plant
        return next_experiment(
            plant,
            self.axis or Axis(kind=log.kind),
            log,
            folder,
            has_axis_file=bool(self.axes),
            loop=self.looped.variants[0] if self.looped is not None and self.axes else None,
        )

    def write(self, folder: Results, **further: Any) -> None:
        """Write all of it into a folder of results.

        Parameters
        ----------
        folder : Results
            The folder.
        **further
            Entries of the summary beside its own.
        """
        from bristle.files.arrays import write_arrays
        from bristle.files.experiment_text import LOOP
        from bristle.report.model_tables import as_csv
        from bristle.report.results import write_identification

        best = self.identification.best
        write_identification(
            folder, self.identification, table=self.table, report=self.page, summary=self.summary | further, provenance=self.provenance
        )
        for number, text in enumerate(self.axes, 1):
            folder.write("axis.toml" if number == 1 else f"axis_{number}.toml", text)
        following = self.following_experiment(folder.path)
        folder.write(EXPERIMENT, following.text)
        if following.loop:
            folder.write(LOOP, following.loop)
        if self.table:
            folder.write("friction_curve.csv", as_csv(steady_curve(best), best.friction.kind) + "\n")
        if best.resampling is not None:
            write_arrays(folder, "draws", best.resampling.bands.draws)
        write_arrays(folder, "traces", vars(best.traces))


def outcome_of(
    identification: Identification,
    axis: Axis | None = None,
    *,
    provenance: Mapping[str, str],
    command: str,
    axis_name: str,
    progress: Progress | None = None,
    banner: str | None = None,
    axes: tuple[bytes, ...] = (),
    loop: Loop | None = None,
    figures: tuple[ReportFigure, ...] = (),
) -> Outcome:
    """Return what follows from an identification."""
    unfinished, source = identification.unfinished, dict(provenance)
    source |= {"unfinished": unfinished} if unfinished else {}
    table = drive_table(identification.best, ENTRIES)
    looped = _loop_of(identification, axis or Axis())
    simulation, prediction, following = loop or _in_the_loop(identification, axis or Axis(), looped, progress)
    certificates, uncertified = _certificates(identification.best.friction)
    return Outcome(
        identification,
        table,
        simulation,
        prediction,
        certificates,
        uncertified,
        source,
        command,
        axis_name,
        f"Unfinished; {unfinished}." if unfinished else banner,
        axes,
        following,
        axis,
        figures,
        looped,
    )


def _certificates(friction: Model) -> tuple[Mapping[str, Certificate], str]:
    """Return the certificates of a model, or why they cannot be asked for, as of one without friction."""
    from bristle.certificates import check

    try:
        return check(friction), ""
    except InputError as error:
        return {}, str(error)


def _loop_of(identification: Identification, axis: Axis) -> Experiment | None:
    """Return the loop of the log with the best model: the one that is simulated, written down, run and designed."""
    from bristle.prediction.following import loop_of
    from bristle.prediction.predict import TREATED

    best = identification.best
    if best.position_rmse is not None:  # fitted to the position: there was no loop
        return None
    treatment = {name: identification.treatment.get(name) for name in TREATED}
    return loop_of(best.plant, best.friction, identification.log, axis, lag=best.lag, **treatment)


def _in_the_loop(identification: Identification, axis: Axis, experiment: Experiment | None, progress: Progress | None) -> Loop:
    """Return the loop with and without compensation, the log as predicted, and how it followed; None without a loop.

    What was fitted to the position is told by the position, and that takes no loop.
    """
    from bristle.prediction.following import following_of
    from bristle.prediction.predict import predict
    from bristle.simulation import simulate

    best, log = identification.best, identification.log
    if best.position_rmse is not None:
        return None, predict(best.plant, best.friction, log, axis, "open-loop"), following_of(log)
    if experiment is None:
        return None, None, following_of(log)
    simulation = simulate(experiment, progress)
    prediction = predict(best.plant, best.friction, log, axis, "closed-loop", lag=best.lag)
    return simulation, prediction, following_of(log, simulation, identification.settings)
