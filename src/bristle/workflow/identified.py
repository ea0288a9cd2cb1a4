"""`identify`: from a log, or the columns of one, to a model that is looked at, predicts, and is kept."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

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
from bristle.identification.settings import Settings
from bristle.logs.log import Log
from bristle.workflow.model_in_hand import ModelInHand
from bristle.workflow.outcome import Outcome, outcome_of

if TYPE_CHECKING:
    from bristle.figures import ReportFigure
    from bristle.identification.result import Fit
    from bristle.prediction.following import Following
    from bristle.simulation.result import Prediction, SimulationResult

__all__ = ["Identified", "identify"]

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


def identify(
    log: Any,
    model: Any = DEFAULT_MODELS,
    *,
    axis: Axis | str | PathLike[str] | Sequence[Axis | str | PathLike[str]] | None = None,
    cutoff: float | str | None = None,
    decimation: int | None = None,
    blocks: int | None = None,
    offset: float | str | None = None,
    mass: float | str | None = None,
    free: str | Sequence[str] = (),
    draws: int = 100,
    method: str | None = None,
    global_search: bool | None = None,
    settings: Settings | Mapping[str, float] | None = None,
    progress: Progress | None = None,
) -> Identified:
    """Identify one friction model or several from a log, with the inertia, and rank them.

    Parameters
    ----------
    log : Log, path-like, or table of columns; or list of these
        Position and effort, or the file that holds them. A data frame or a dictionary of arrays has columns ``time``,
        ``position`` and ``effort``, and where there are any ``velocity`` and ``reference``, in SI: it needs no axis.
        Of several logs, each is held out in turn.
    model : str, FrictionModel, or list of either
        ``"lugre"``, ``"lugre,maxwell_slip+asymmetry"``, a model of your own; ``"all"`` for every model of bristle.
    axis : Axis or path-like, or list of either, optional
        One for all logs, or one for each. What is known, or the file that says it: mass, offset, encoder resolution,
        cut-off and decimation.
    cutoff : float or str, optional
        Cut-off of the zero-phase filter [Hz], or text such as ``"100 Hz"``; a tenth of the sampling frequency by
        default.
    decimation : int, optional
        Of how many samples one row is kept; 10 by default, more where noise of the position would hide friction.
    blocks : int, optional
        Time blocks, each held out in turn, by whose error models are ranked; 0 for none. At most five by default.
    offset : float, str or "identify", optional
        Constant part of the force [N or N*m] if known, or text with a unit; as the axis says by default.
    mass : float or str, optional
        Moving mass [kg] or inertia [kg*m^2] if known, or text with a unit; the axis decides where it is not given.
    free : str or sequence of str
        Shapes to identify too instead of keeping their default: ``"exponent"`` of Dahl; several separated by commas.
    draws : int
        Logs that are simulated with the best model and fitted again, for its 95 % intervals; 0 for none.
    method : {"inverse_dynamics", "output_error"}, optional
        What is made small: the error of the effort along the measured motion, or that of a simulation; the axis decides
        where it is not given.
    global_search : bool, optional
        Whether the whole range of each parameter is looked at, where a search is needed at all; the axis decides where
        it is not given.
    settings : Settings or mapping of str to float, optional
        Thresholds from where on something is said or doubted, by name; those that are not given are as the axis says,
        or at their defaults.
    progress : callable, optional
        Called with the share of the work done and what is being done.

    Returns
    -------
    Identified
        The models, best first; what stands on it is that of the best one.

    Raises
    ------
    InputError
        If the log or the axis does not serve, or there is no such model.

    Examples
    --------
    >>> import numpy as np
    >>> t = np.arange(4000) * 1e-3
    >>> position = 0.02 * np.sin(3.0 * t) + 0.01 * np.sin(11.0 * t)
    >>> velocity = 0.06 * np.cos(3.0 * t) + 0.11 * np.cos(11.0 * t)
    >>> effort = 12.0 * np.gradient(velocity, t) + 5.0 * np.sign(velocity) + 80.0 * velocity
    >>> found = identify({"time": t, "position": position, "effort": effort}, draws=0)
    >>> found.parameters["M"].status, round(found.parameters["M"].value, 1), found.parameters["M"].unit
    ('identified', 12.0, 'kg')
    """
    pairs = logs_and_axes(log, axis)
    logs, axes = [pair[0] for pair in pairs], [pair[1] for pair in pairs]
    options: dict[str, Any] = {
        "cutoff": cutoff,
        "decimation": decimation,
        "blocks": blocks,
        "offset": offset,
        "mass": mass,
        "free": free,
        "draws": draws,
        "method": method,
        "global_search": global_search,
        "settings": settings,
    }
    fitted = models_fitted(logs, model, axis=axes, progress=progress, **options)  # type: ignore[arg-type]
    code = origins_of_code(models_of(model))
    return Identified(
        **{name: getattr(fitted, name) for name in Identification.__dataclass_fields__},
        axes=tuple(axes),
        code=code,
        call=_call(logs, model, axes, options),
    )


def _call(logs: Sequence[Log], model: Any, axes: Sequence[Axis | None], options: Mapping[str, Any]) -> str:
    """Return the call that repeats an identification, for who has the same log and axis."""
    names = [log.origin.name or log.source.name.strip("<>") or "log" for log in logs]
    words = [repr(names[0]) if len(names) == 1 else repr(names), repr(_model_name(model))]
    usual = {name: parameter.default for name, parameter in _parameters().items()}
    words += ["axis=axis"] if any(axes) else []
    words += [f"{name}={value!r}" for name, value in options.items() if value != usual[name]]
    return f"bristle.identify({', '.join(words)})"


def _model_name(model: Any) -> Any:
    if isinstance(model, (list, tuple)):
        return ",".join(map(_model_name, model))
    return model if isinstance(model, str) else str(getattr(model, "name", model))


def _parameters() -> Mapping[str, Any]:
    from inspect import signature

    return signature(identify).parameters
