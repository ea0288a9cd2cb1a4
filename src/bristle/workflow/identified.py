"""`identify`: from a log, or the columns of one, to a model that is looked at, predicts, and is kept."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import wraps
from inspect import Signature, signature
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, ParamSpec

from bristle.core.axis import CHANNELS, Axis, Column, Injected
from bristle.core.content import Origin
from bristle.core.lazy import cached_property
from bristle.files.arguments import logs_and_axes
from bristle.files.axis import axis_text
from bristle.files.results import results_folder
from bristle.files.single import write_whole
from bristle.files.summary import provenance
from bristle.files.user_model import origins_of_code
from bristle.friction import DEFAULT_MODELS
from bristle.identification.identify import identify as models_fitted
from bristle.identification.request import models_of
from bristle.identification.result import Identification
from bristle.logs.log import Log
from bristle.workflow.model_in_hand import ModelInHand
from bristle.workflow.outcome import Outcome, outcome_of

if TYPE_CHECKING:
    from bristle.figures import ReportFigure
    from bristle.identification.result import Fit
    from bristle.prediction.following import Following
    from bristle.simulation.result import Prediction, SimulationResult

__all__ = ["Identified", "identify"]

P = ParamSpec("P")
Progress = Callable[[float, str], None]


@dataclass(frozen=True, eq=False)
class Identified(ModelInHand, Identification):
    """Models identified from a log, best first; what stands on it is that of the best one.

    Parameters
    ----------
    axes : tuple of Axis or None
        What was known of the axis of each log.
    code : tuple of Origin
        Files of those models that are a user's own.
    call : str
        What repeats it.
    """

    axes: tuple[Axis | None, ...] = (None,)
    code: tuple[Origin, ...] = ()
    call: str = "bristle.identify(log)"

    @property
    def best(self) -> Fit:
        """The model of the first rank."""
        return self.fits[0]

    @property
    def axis(self) -> Axis | None:
        """What was known of the axis of the first log."""
        return self.axes[0]

    @property
    def _treatment(self) -> Mapping[str, float]:
        return self.treatment

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
        loop: tuple[SimulationResult | None, Prediction | None, Following | None] | None = None,
        figures: Sequence[ReportFigure] = (),
    ) -> Outcome:
        """Return what follows from the models, with words of one's own.

        Parameters
        ----------
        command : str, optional
            What repeats it.
        axis_name : str, optional
            What people call the axis.
        progress : callable, optional
            Called with the share done and what comes next.
        banner : str, optional
            What a reader of the report must know before anything else.
        files : mapping, optional
            What was read, by what it is, where it is more than is known here.
        loop : tuple of SimulationResult, Prediction and Following, optional
            Where these were made elsewhere, as on an axis that is simulated.
        figures : sequence of ReportFigure
            Your own, for the report.

        Returns
        -------
        Outcome
            Table, loop, prediction, certificates, summary and report.
        """
        logs, texts = (self.log, *self.further_logs), self._axis_texts()
        read = {"log": logs, "code": self.code} | dict(files or {})
        name = self.axis.name if self.axis is not None else Path(self.log.source.name.strip("<>")).stem
        return outcome_of(
            self,
            self.axis,
            provenance=provenance(command or self.call, **read),
            command=command or self.call,
            axis_name=axis_name or name,
            progress=progress,
            banner=banner,
            loop=loop,
            axes=texts,
            figures=tuple(figures),
        )

    def _axis_texts(self) -> tuple[bytes, ...]:
        """Return the axis files as used, each once."""
        logs = (self.log, *self.further_logs)
        texts = [axis_text(_with_columns(axis, log)) for axis, log in zip(self.axes, logs, strict=True)]
        return tuple(dict.fromkeys(text for text in texts if text is not None))

    def report(self, path: str | PathLike[str], *, figures: Sequence[ReportFigure | str | PathLike[str]] = ()) -> Path:
        """Write the report, one HTML file that needs nothing else.

        Parameters
        ----------
        path : path-like
            The file; one that is there is replaced.
        figures : sequence of ReportFigure or path-like
            Your own, or the files that define them, which are executed: they stand behind all else.

        Returns
        -------
        Path
            The file.
        """
        outcome = self.outcome
        if figures:
            from bristle.figures.own import figures_named

            outcome = replace(outcome, figures=figures_named(figures, "identify"))
        return write_whole(path, outcome.page)

    def save(self, folder: str | PathLike[str], *, force: bool = False) -> Path:
        """Write everything into a folder that `bristle.load` reads.

        Parameters
        ----------
        folder : path-like
            A new folder: ``model.toml``, ``axis.toml`` as used, ``drive_table.csv``, ``friction_curve.csv``,
            ``summary.json``, ``report.html``, and as Parquet, or NPZ without pyarrow, ``draws`` (the parameters as
            that the log allows, one row a simulated log) and ``traces`` (measured and predicted effort).
        force : bool
            Whether results that are there already are replaced.

        Returns
        -------
        Path
            The folder.

        Raises
        ------
        InputError
            If it is there already, or cannot be written.
        """
        with results_folder(folder, force=force) as results:
            self.outcome.write(results)
        return Path(folder)

    def to_dict(self) -> dict[str, Any]:
        """Return the numbers as plain data, as ``summary.json`` holds them.

        Returns
        -------
        dict
            Of text, numbers and lists. With a controller the loop is simulated for it, once.
        """
        from bristle.files.summary import plain

        return plain(self.outcome.summary)

    def _source(self) -> str:
        words = ", ".join(log.origin.name for log in (self.log, *self.further_logs) if log.origin.name)
        return f" from {words}" if words else ""

    def _beside(self) -> tuple[str, ...]:
        behind = ", ".join(f"{fit.name} ({fit.error_percent:.3g} %)" for fit in self.fits[1:])
        return (*((f"ranked behind it: {behind}",) if behind else ()), *((self.unfinished,) if self.unfinished else ()))


def _with_columns(axis: Axis | None, log: Log) -> Axis:
    """Return an axis that says which columns a log was read from, where nobody did; units are those of the log."""
    if axis is not None and axis.columns:
        return axis
    columns = {name: Column(channel.column, "", channel.unit) for name, channel in log.channels() if name in CHANNELS}
    injected = tuple(Injected(name, 1.0) for name, _ in log.channels() if name.startswith("injected."))
    return replace(axis or Axis(kind=log.kind), columns=columns, injected=injected)


def _in_hand(fitted: Callable[P, Identification]) -> Callable[P, Identified]:
    """Return an identification whose result is looked at, predicts and is kept; arguments and words are the same."""
    parameters = signature(fitted)

    @wraps(fitted)
    def identify(*arguments: P.args, **further: P.kwargs) -> Identified:
        options = parameters.bind(*arguments, **further).arguments
        log, model = options.pop("log"), options.pop("model", DEFAULT_MODELS)
        pairs = logs_and_axes(log, options.pop("axis", None))
        logs, axes = [log for log, _ in pairs], [axis for _, axis in pairs]
        result = fitted(logs, model, axis=axes, **options)  # type: ignore[call-arg]
        words = {name: options[name] for name in parameters.parameters if name in options and name != "progress"}
        return Identified(
            **{name: getattr(result, name) for name in Identification.__dataclass_fields__},
            axes=tuple(axes),
            code=origins_of_code(models_of(model)),
            call=_call(logs, model, axes, words, parameters),
        )

    identify.__module__, identify.__qualname__ = __name__, "identify"  # so that a process may be sent it by name
    identify.__signature__ = parameters.replace(return_annotation="Identified")  # type: ignore[attr-defined]
    return identify


identify = _in_hand(models_fitted)


def _call(logs: Sequence[Log], model: Any, axes: Sequence[Axis | None], options: Mapping[str, Any], parameters: Signature) -> str:
    """Return the call that repeats an identification, for who has the same log and axis."""
    names = [log.origin.name or log.source.name.strip("<>") or "log" for log in logs]
    words = [repr(names[0]) if len(names) == 1 else repr(names), repr(_model_name(model))]
    words += ["axis=axis"] if any(axes) else []
    words += [f"{name}={value!r}" for name, value in options.items() if value != parameters.parameters[name].default]
    return f"bristle.identify({', '.join(words)})"


def _model_name(model: Any) -> Any:
    if isinstance(model, (list, tuple)):
        return ",".join(map(_model_name, model))
    return model if isinstance(model, str) else str(getattr(model, "name", model))
