"""`identify`: from a log or its columns to an identified model, with its table, loop, report and files."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import wraps
from inspect import Signature, signature
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, ParamSpec

from bristle.core import Axis, Experiment, InputError, Origin, Progress, cached_property
from bristle.files import axis_text, logs_and_axes, origins_of_code, provenance
from bristle.identification import Identification, axis_with, identify as models_fitted, models_of
from bristle.logs import Log
from bristle.models.friction import DEFAULT_MODELS
from bristle.prediction import drive_table, steady_curve
from bristle.report.model_in_hand import ModelInHand
from bristle.report.results import Result

if TYPE_CHECKING:
    from bristle.files import NextExperiment, Results
    from bristle.prediction import Compensation, Following
    from bristle.report.figures import ReportFigure
    from bristle.simulation import Prediction, SimulationResult
    from bristle.simulation.certificates import Certificate

    Loop = tuple[SimulationResult | None, Prediction | None, Following | None]

P = ParamSpec("P")
ENTRIES = 20  # of the table for the drive
EXPERIMENT = "experiment.toml"  # name of the experiment file that an identification leaves


@dataclass(frozen=True, eq=False)
class Identified(Identification, ModelInHand, Result):
    """Models identified from a log, best first; attributes belong to the best model.

    Parameters
    ----------
    axes : tuple of Axis or None
        The axis of each log.
    code : tuple of Origin
        Files of user-defined models.
    call : str
        Python call that repeats the identification.
    """

    command: ClassVar[str] = "identify"
    axes: tuple[Axis | None, ...] = (None,)
    code: tuple[Origin, ...] = ()
    call: str = "bristle.identify(log)"

    @property
    def axis(self) -> Axis | None:
        """The axis of the first log."""
        return self.axes[0]

    @cached_property
    def outcome(self) -> Outcome:
        """The table for the drive, the loop with and without compensation, certificates, summary and report."""
        return self.outcome_with()

    def outcome_with(
        self,
        *,
        command: str | None = None,
        axis_name: str | None = None,
        progress: Progress | None = None,
        banner: str | None = None,
        files: Mapping[str, Any] | None = None,
        loop: Loop | None = None,
        figures: Sequence[ReportFigure] = (),
    ) -> Outcome:
        """Return the results of the models, with given names, and with further `files` in the provenance.

        A `loop` is the result of an earlier simulation, such as that of a simulated axis.
        """
        from bristle.simulation.certificates import check

        read = {"log": (self.log, *self.further_logs), "code": self.code} | dict(files or {})
        source = provenance(command or self.call, **read) | (
            {"unfinished": self.unfinished} if self.unfinished else {}
        )
        table, looped = drive_table(self.best, ENTRIES), self._looped[0]
        simulation, prediction, following = loop or self._in_the_loop(looped, progress)
        certificates, uncertified = {}, ""
        try:
            certificates = check(self.model)
        except InputError as error:  # of a model without friction
            uncertified = str(error)
        return Outcome(
            self,
            table,
            simulation,
            prediction,
            certificates,
            uncertified,
            source,
            command or self.call,
            axis_name
            or (
                self.axis.name
                if self.axis is not None
                else Path(self.log.source.name.strip("<>")).stem
            ),
            f"Unfinished; {self.unfinished}." if self.unfinished else banner,
            following,
            tuple(figures),
            looped,
        )

    @cached_property
    def compensation(self) -> Compensation:
        """The share of the friction to feed forward, and the moves that it helps."""
        return self._looped[1]

    @cached_property
    def _looped(self) -> tuple[Experiment | None, Compensation]:
        """The loop of the log with the best model, for simulation, experiment file and design, and its compensation."""
        from bristle.exports import compensated_loop
        from bristle.prediction import compensation_of, loop_of

        usual, looped = compensation_of(self.best.friction, self.axis, self.treatment), None
        draws = self.best.resampling.bands.draws if self.best.resampling else {}
        if self.best.position_rmse is None:  # fitted to the position: there was no loop
            looped = loop_of(self.plant, self.model, self.log, self.axis or Axis(), self.treatment)
        # After an interruption, the results are due at once: simulations of the loop take seconds.
        return (
            (looped, usual)
            if looped is None or self.unfinished
            else compensated_loop(looped, self.axis, draws, usual)
        )

    def _in_the_loop(self, experiment: Experiment | None, progress: Progress | None) -> Loop:
        """Return the loop with and without compensation, the predicted log, and the following error; None without a loop."""
        # A fit to the position is judged by the position, without a loop.
        from bristle.prediction import following_of, predict
        from bristle.simulation import simulate

        of_axis = self.plant, self.model, self.log, self.axis or Axis()
        if self.best.position_rmse is not None:
            return None, predict(*of_axis, "open-loop"), following_of(self.log)
        if experiment is None or self.unfinished:
            return None, None, following_of(self.log)
        simulation = simulate(experiment, progress)
        return (
            simulation,
            predict(*of_axis, "closed-loop", lag=self.best.lag),
            following_of(self.log, simulation, self.settings),
        )

    def _summary(self) -> dict[str, Any]:
        return self.outcome.summary

    def _page(self, figures: tuple[ReportFigure, ...]) -> str:
        return (replace(self.outcome, figures=figures) if figures else self.outcome).page

    def write(self, folder: Results) -> None:
        """Write all results into an open folder."""
        self.outcome.write(folder)

    def _recorded(self, log: Any) -> tuple[list[Log], list[Axis | None], Mapping[str, float]]:
        if log is not None:
            raise InputError(
                "is known, because this result is not from a folder", path="log", mend="Omit log"
            )
        return [self.log, *self.further_logs], list(self.axes), self.settings.as_data()

    def _words(self) -> tuple[str, list[str]]:
        from bristle.report.two_masses import two_masses_lines

        logs = ", ".join(
            log.origin.name for log in (self.log, *self.further_logs) if log.origin.name
        )
        behind = [f"{fit.name} ({fit.error_percent:.3g} %)" for fit in self.fits[1:]]
        remarks = [f"next in rank: {', '.join(behind)}"] * bool(behind) + [self.unfinished] * bool(
            self.unfinished
        )
        return logs, [*remarks, *(line.text for line in two_masses_lines(self)[:5])]


@dataclass(frozen=True)
class Outcome:
    """An identification with its results.

    The `table` for a drive has velocities and efforts, `uncertified` is the reason for missing certificates, `banner` is
    the text at the top of the report, and `looped` is the loop of the log with the best model.
    """

    identification: Identified
    table: list[tuple[float, float]]
    simulation: SimulationResult | None
    prediction: Prediction | None
    certificates: Mapping[str, Certificate]
    uncertified: str
    provenance: Mapping[str, str]
    command: str
    axis_name: str
    banner: str | None
    following: Following | None
    figures: tuple[ReportFigure, ...]
    looped: Experiment | None

    def _facts(self) -> dict[str, Any]:
        """Return the facts that summary and report share."""
        names = ("table", "simulation", "prediction", "provenance", "certificates", "following")
        return {name: getattr(self, name) for name in names} | {"axis": self.identification.axis}

    @cached_property
    def summary(self) -> dict[str, Any]:
        """The numbers of ``summary.json``."""
        from bristle.report.summary import identification_summary

        return identification_summary(self.identification, **self._facts())

    @cached_property
    def page(self) -> str:
        """The report, an HTML page, with movable parameters if the page can compute the model."""
        from bristle.report.apps import part
        from bristle.report.identification import identification_report

        living = part("living")(
            self.identification, self.identification.axis, self.simulation, self.following
        )
        words = {"command": self.command, "axis_name": self.axis_name, "banner": self.banner}
        return identification_report(
            self.identification, figures=self.figures, living=living, **words, **self._facts()
        )

    def following_experiment(self, folder: Path) -> NextExperiment:
        """Return the experiment file for the folder of the model: the next step."""
        from bristle.files import NextExperiment

        log, axis = (
            self.identification.log,
            self.identification.axis or Axis(kind=self.identification.log.kind),
        )
        loop, has_file = (
            None if self.looped is None else self.looped.variants[0],
            bool(self._axis_texts),
        )
        plant = self.identification.plant
        rule, loop = self.identification.compensation.rule, loop if has_file else None
        return NextExperiment.beside_model(
            plant, axis, log, folder, has_axis_file=has_file, loop=loop, rule=rule
        )

    @cached_property
    def _axis_texts(self) -> tuple[bytes, ...]:
        """The axis files as used, without duplicates, in the order of the logs."""
        logs = (self.identification.log, *self.identification.further_logs)
        texts = [
            axis_text(axis, log) for axis, log in zip(self.identification.axes, logs, strict=True)
        ]
        return tuple(dict.fromkeys(text for text in texts if text is not None))

    def write(self, folder: Results, **further: Any) -> None:
        """Write all results into a folder, with further entries in the summary."""
        from bristle.files import LOOP, codes_of, write_arrays, write_model
        from bristle.report.messages import note_of
        from bristle.report.model_tables import as_csv
        from bristle.report.results import write_report
        from bristle.report.sentences import SENTENCES
        from bristle.report.two_masses import write_two_masses

        best = self.identification.best
        for code in codes_of(best.friction.component):
            folder.write(code.source.name, code.data)
        notes = {estimate.name: note_of(estimate) for estimate in best.estimates}
        # Notes for parameters that come only from a log without sliding.
        sticking = next(
            (diagnostic for diagnostic in best.diagnostics if diagnostic.code == "never_slides"),
            None,
        )
        names = sticking.numbers.get("names", ()) if sticking is not None else ()
        explained = {estimate.name for estimate in best.estimates if estimate.reason is not None}
        if isinstance(names, tuple):
            notes |= {
                str(name): SENTENCES["never_slides"].means
                for name in names
                if name not in explained
            }
        write_model(
            folder / "model.toml",
            best.plant,
            best.friction,
            estimates=best.estimates,
            provenance=self.provenance,
            treatment=self.identification.treatment,
            bands=best.resampling.bands if best.resampling else None,
            notes=notes,
        )
        if self.table:
            folder.write("drive_table.csv", as_csv(self.table, best.friction.kind) + "\n")
        write_report(folder, self.page, self.summary | further)
        for number, text in enumerate(self._axis_texts, 1):
            folder.write("axis.toml" if number == 1 else f"axis_{number}.toml", text)
        following = self.following_experiment(folder.path)
        folder.write(EXPERIMENT, following.text)
        if following.loop:
            folder.write(LOOP, following.loop.text)
        if self.table:
            folder.write(
                "friction_curve.csv", as_csv(steady_curve(best), best.friction.kind) + "\n"
            )
        if best.resampling is not None:
            write_arrays(folder, "draws", best.resampling.bands.draws)
        write_arrays(folder, "traces", vars(best.traces))
        write_two_masses(folder, self.identification, self.provenance)


def _in_hand(fitted: Callable[P, Identification]) -> Callable[P, Identified]:
    """Return the wrapped identification that returns `Identified`; arguments and documentation are the same."""
    parameters = signature(fitted)

    @wraps(fitted)
    def identify(*arguments: P.args, **further: P.kwargs) -> Identified:
        options = parameters.bind(*arguments, **further).arguments
        log, model = options.pop("log"), options.pop("model", DEFAULT_MODELS)
        pairs = logs_and_axes(log, options.pop("axis", None))
        logs, axes = [log for log, _ in pairs], [axis for _, axis in pairs]
        result = fitted(logs, model, axis=axes, **options)  # type: ignore[call-arg]
        # Logs that are too short are left out.
        used_logs = {id(log.time) for log in (result.log, *result.further_logs)}
        if len(used_logs) < len(pairs):
            pairs = [pair for pair in pairs if id(pair[0].time) in used_logs]
            axes = [axis for _, axis in pairs]
        words = {
            name: options[name]
            for name in parameters.parameters
            if name in options and name not in ("progress", "answer")
        }
        call = _call(logs, model, axes, words, parameters)
        if result.second_pass is not None and result.second_pass.taken:
            named = [
                axis or Axis(Path(log.source.name.strip("<>")).stem, log.kind)
                for log, axis in pairs
            ]
            axes = [axis_with(axis, result.second_pass.lines) for axis in named]
        return Identified(
            **{name: getattr(result, name) for name in Identification.__dataclass_fields__},
            axes=tuple(axes),
            code=origins_of_code(models_of(model)),
            call=call,
        )

    # So that a process may be sent it by name.
    identify.__module__, identify.__qualname__ = (__name__, "identify")
    identify.__signature__ = parameters.replace(return_annotation="Identified")  # type: ignore[attr-defined]
    return identify


identify = _in_hand(models_fitted)


def _call(
    logs: Sequence[Log],
    model: Any,
    axes: Sequence[Axis | None],
    options: Mapping[str, Any],
    parameters: Signature,
) -> str:
    """Return the call that repeats an identification with the same log and axis."""
    names = [log.origin.name or log.source.name.strip("<>") or "log" for log in logs]
    words = [repr(names[0]) if len(names) == 1 else repr(names), repr(_model_name(model))]
    words += ["axis=axis"] if any(axes) else []
    words += [
        f"{name}={value!r}"
        for name, value in options.items()
        if value != parameters.parameters[name].default
    ]
    return f"bristle.identify({', '.join(words)})"


def _model_name(model: Any) -> Any:
    if isinstance(model, (list, tuple)):
        return ",".join(map(_model_name, model))
    return model if isinstance(model, str) else str(getattr(model, "name", model))
