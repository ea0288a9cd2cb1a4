"""The result of an identification: models, uncertainty, errors, and diagnostics."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple, Self

import numpy as np

from bristle.core.contracts import Model
from bristle.core.diagnostic import HeldOut
from bristle.core.dimensions import exponents_of
from bristle.core.lazy import cached_property
from bristle.core.tabular import plain
from bristle.core.typography import with_unit
from bristle.core.values import numbers_of
from bristle.core.variable import Kind
from bristle.identification.estimate import Estimate
from bristle.identification.explanation import Explanation
from bristle.identification.parameters import Role, acts_in_sliding, constant_of, name_of, names_of
from bristle.identification.quantities import Quantity
from bristle.identification.settings import DEFAULT, Settings
from bristle.logs.passages import Passage, passages
from bristle.models.friction import find
from bristle.models.friction.next_model import goes_by_name, model_with
from bristle.models.plants import ball_screw
from bristle.simulation.statistics import relative_error_percent

if TYPE_CHECKING:
    from bristle.core.diagnostic import Diagnostic
    from bristle.identification.dahl_resonance import DahlResonance
    from bristle.identification.one_encoder import Response
    from bristle.logs.break_away import BreakAway
    from bristle.logs.log import Log

TRADED_IN = ("one_speed", "one_direction", "level_drifts", "never_slides")
"""Codes that name parameters with unreliable intervals."""
CONSTANT_HELD = ("held_levels", "held_constant")
TWO_MASSES = "the plant with two masses"  # in the parts of a result that are left out
# Of the level by direction, and standard errors: a constant force above both is reported.
LARGE_OFFSET, SURE_OFFSET = (0.25, 3.0)
LACKING = ("structure", "clipped", "saturates", "scale_steps", "high_passed")
"""Codes for a force missing in the model or in the effort of a log: the parameters in `names` absorb it."""


class ProposedLine(NamedTuple):
    """A line for the axis file: section, key, value in SI units of the axis, and the code of its reason."""

    section: str
    key: str
    value: Any
    reason: str


class SecondPass(NamedTuple):
    """Lines that bristle found for the axis, and the held-out errors of the linear stage without and with them [%]."""

    lines: tuple[ProposedLine, ...]
    error_without: float
    error_with: float
    taken: bool


@dataclass(frozen=True)
class Bands:
    """The data of the 95 % band around a prediction.

    Parameters
    ----------
    draws : mapping of str to array_like, shape (member,) or (member, element)
        Draws of the free parameters of the model [SI].
    scatter : float
        Relative standard deviation of the friction level between half-cycles.
    noise : float
        Standard deviation of the effort noise, independent between samples [N or N*m].
    unexplained : float
        Rms of the residual that noise, encoder and scatter do not explain [N or N*m].
    lasting : float
        Correlation time of the unexplained force [s].
    inflation : float
        Factor on the width of the band, from held-out blocks.
    left_in_closed_loop : float
        Standard deviation of the position error in closed loop that the values above and the rounding of the encoder do
        not explain [m or rad].
    left_in_open_loop : float
        Standard deviation of the position error in open loop that the values above do not explain [m or rad].
    """

    draws: Mapping[str, np.ndarray]
    scatter: float
    noise: float
    unexplained: float
    lasting: float = 0.0
    inflation: float = 1.0
    left_in_closed_loop: float = 0.0
    left_in_open_loop: float = 0.0

    @property
    def count(self) -> int:
        """Number of draws."""
        return min((len(draws) for draws in self.draws.values()), default=0)

    def models(self, model: Model, most: int) -> list[Model]:
        """Return a model with the parameters of the first draws, at most `most` models."""
        return [with_parameters(self, index, model) for index in range(min(self.count, most))]


def with_parameters(bands: Bands, index: int, model: Model) -> Model:
    """Return a model with its parameters from one draw."""
    own = {
        name: np.asarray(draws[index])[()]
        for name, draws in bands.draws.items()
        if name in model.values
    }
    component = model.component
    return Model(
        component, component.assemble(numbers_of(component, model.parameters) | own), model.kind
    )


class Information(NamedTuple):
    """Akaike's and the Bayesian information criterion minus those of the best model, and the effective number of measurements."""

    aic: float
    bic: float
    measurements: float


class Scatter(NamedTuple):
    """Relative standard deviation of the friction level between half-cycles, with its 95 % interval."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class Resampling:
    """Results of fits to replicates of the log and to parts of the log.

    Parameters
    ----------
    bands : Bands
        Draws of the free parameters, and the other data of a band around a prediction.
    scatter : Scatter
        Scatter of the friction level between half-cycles.
    half_cycles : int
        Number of half-cycles that determine the scatter.
    resolution : float
        Step of the position encoder [m or rad].
    curve : tuple of (float, float, float, float)
        Virgin curve of elements that slip: displacement [m or rad], force [N or N*m], and the ends of its 95 %
        interval.
    curve_from : float
        Displacement above which the log determines this curve [m or rad]; 0 if the log determines the whole curve.
    """

    bands: Bands
    scatter: Scatter
    half_cycles: int
    resolution: float
    curve: tuple[tuple[float, float, float, float], ...] = ()
    curve_from: float = 0.0


@dataclass(frozen=True)
class Traces:
    """Measured and predicted effort on the decimated grid of the identification, shape (sample,) each.

    `mechanical` is the effort of the plant without friction.
    """

    time: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    measured: np.ndarray
    predicted: np.ndarray
    mechanical: np.ndarray

    @property
    def friction(self) -> np.ndarray:
        """Measured effort minus that of the plant [N or N*m]."""
        return self.measured - self.mechanical

    @property
    def residual(self) -> np.ndarray:
        """Measured minus predicted effort [N or N*m]."""
        return self.measured - self.predicted


@dataclass(frozen=True)
class Fit:
    """One model fitted to one log.

    Parameters
    ----------
    plant : Model
        The plant with the identified values.
    friction : Model
        The friction model with the identified values.
    estimates : tuple of Estimate
        Every parameter, plant first, then friction in the order of the model.
    correlation : ndarray, shape (parameter, parameter)
        Correlation of the estimates named in `correlation_names`.
    condition_number : float
        Condition number of the regressor, with its columns scaled to unit length.
    traces : Traces
        The fitted signals.
    force_error_percent : float
        100 ||effort - predicted|| / ||effort|| over the log [%].
    held_out : HeldOut or None
        Error on held-out time blocks.
    diagnostics : tuple of Diagnostic
        Parameters that are not identified, with the reason, as ``warning``; assumptions as ``note``.
    rank : int
        1 for the best of the models compared.
    position_error_percent : float or None
        Error of the position simulated from the effort [%], if the fit minimised this error.
    position_rmse : float or None
        Rms error of the position simulated from the effort [m or rad].
    loop_error_percent : float or None
        Error of the controller effort in the simulated loop [%], if the fit minimised this error.
    loop_rmse : float or None
        Rms error of the controller effort in the simulated loop [N or N*m].
    lag : float or None
        Time constant with which the drive follows its controller [s], if the fit identified it.
    combinations : tuple of Estimate
        Products of parameters that the log determines, although it does not determine each factor.
    further : int
        Number of free numbers in addition to the parameters, such as the shape of the elements of ``maxwell_slip``.
    unfinished : bool
        Whether the search or the validation was interrupted.
    resampling : Resampling or None
        Uncertainty from replicates; None if not requested.
    information : Information or None
        Information criteria in comparison with the other models.
    """

    plant: Model
    friction: Model
    estimates: tuple[Estimate, ...]
    correlation: np.ndarray
    correlation_names: tuple[str, ...]
    condition_number: float
    traces: Traces
    force_error_percent: float
    held_out: HeldOut | None = None
    diagnostics: tuple[Diagnostic, ...] = ()
    rank: int = 1
    position_error_percent: float | None = None
    position_rmse: float | None = None
    loop_error_percent: float | None = None
    loop_rmse: float | None = None
    lag: float | None = None
    combinations: tuple[Estimate, ...] = ()
    further: int = 0
    unfinished: bool = False
    resampling: Resampling | None = None
    information: Information | None = None

    @property
    def name(self) -> str:
        """Name of the friction model with its slots."""
        return self.friction.name

    @property
    def parameters(self) -> dict[str, Estimate]:
        """The estimates by name."""
        return {estimate.name: estimate for estimate in self.estimates}

    @property
    def inertia(self) -> Estimate | None:
        """The estimate of the moving mass or inertia; None if it is not a parameter."""
        return self.parameters.get(name_of(Role.INERTIA, self.plant.component.variables) or "")

    @property
    def never_slid(self) -> bool:
        """Whether the log contains no sliding: the effort follows the position, or a level exceeds the largest effort."""
        beyond = [
            item.name
            for item in self.estimates
            if item.reason is not None and item.reason.code == "beyond_effort"
        ]
        levels = [
            variable
            for name, variable in self.friction.component.variables.items()
            if name in beyond
        ]
        is_stuck = any(diagnostic.code == "never_slides" for diagnostic in self.diagnostics)
        return is_stuck or any(
            acts_in_sliding(variable) and not Role.BREAK_AWAY.fits(variable) for variable in levels
        )

    @property
    def lacking(self) -> tuple[str, ...]:
        """Codes of diagnostics of a missing force: ``structure`` if the model lacks it, other codes if the effort of the log lacks it."""
        return tuple(
            code
            for code in LACKING
            if any(diagnostic.code == code for diagnostic in self.diagnostics)
        )

    @property
    def effective(self) -> tuple[str, ...]:
        """Identified parameters that absorb a force missing in the model or the effort."""
        return self._named_by(LACKING)

    @property
    def doubted(self) -> tuple[str, ...]:
        """Identified parameters with intervals that a diagnostic declares unreliable."""
        return self._named_by(TRADED_IN)

    def _named_by(self, codes: tuple[str, ...]) -> tuple[str, ...]:
        """Return the identified parameters named by diagnostics of these codes."""
        named = [
            diagnostic.numbers.get("names", ())
            for diagnostic in self.diagnostics
            if diagnostic.code in codes
        ]
        names = {name for group in named if isinstance(group, tuple) for name in group}
        return tuple(
            estimate.name
            for estimate in self.estimates
            if estimate.status == "identified" and estimate.name in names
        )

    @property
    def levels(self) -> tuple[str, ...]:
        """Names of the friction levels: one level, or one for each direction; empty without a level."""
        return tuple(names_of(Role.LEVEL, self.friction.component.variables))

    @property
    def with_constant(self) -> tuple[str, ...]:
        """Friction levels by direction that are confounded with a constant force, which was held constant."""
        reasons = [estimate.reason for estimate in self.estimates if estimate.reason is not None]
        held = [reason.numbers["levels"] for reason in reasons if reason.code in CONSTANT_HELD]
        return tuple(str(name) for levels in held if isinstance(levels, tuple) for name in levels)

    @property
    def friction_error_percent(self) -> float:
        """Residual as a percentage of the effort without that of the plant: 100 ||residual|| / ||u - M a||."""
        friction = self.traces.friction
        return relative_error_percent(friction, friction - self.traces.residual)

    @property
    def friction_alone_error_percent(self) -> float:
        """Residual as a percentage of the friction, without its constant part (weight, bias)."""
        friction = self.traces.friction - constant_of(
            self.friction.component.variables, self.friction.values
        )
        return relative_error_percent(friction, friction - self.traces.residual)

    @property
    def missed_percent(self) -> float:
        """Residual without effort noise and encoder steps, as a percentage of the friction; without replicates, the whole residual."""
        percent, size = (
            self.friction_alone_error_percent,
            float(np.sqrt(np.mean(self.traces.residual**2))),
        )
        if self.resampling is None or not size > 0.0:
            return percent
        bands = self.resampling.bands
        return min(
            float(np.hypot(percent * bands.unexplained / size, 100.0 * bands.scatter)), percent
        )

    @property
    def error_percent(self) -> float:
        """The minimised error [%]: the error of a simulation, or else of the effort."""
        simulated = (self.position_error_percent, self.loop_error_percent)
        return next(
            (percent for percent in simulated if percent is not None), self.force_error_percent
        )

    @property
    def metrics(self) -> dict[str, float]:
        """Measures of the quality of the fit."""
        metrics = {
            "force_error_percent": self.force_error_percent,
            "friction_error_percent": self.friction_error_percent,
            "friction_alone_error_percent": self.friction_alone_error_percent,
            "condition_number": self.condition_number,
        }
        simulated = {
            name: getattr(self, name)
            for name in (
                "position_error_percent",
                "position_rmse",
                "loop_error_percent",
                "loop_rmse",
            )
        }
        metrics |= {name: value for name, value in simulated.items() if value is not None}
        if self.held_out is not None:
            metrics["held_out_error_percent"] = self.held_out.mean_percent
            metrics["held_out_error_std_percent"] = self.held_out.std_percent
        if self.information is not None:
            metrics |= {"aic": self.information.aic, "bic": self.information.bic}
        return metrics


@dataclass(frozen=True)
class Identification:
    """Every model fitted to a log, best first, with the treatment of the log.

    Parameters
    ----------
    fits : tuple of Fit
        The chosen model, then the others by their error on held-out time blocks.
    log : Log
        The log, or the first of several.
    treatment : dict
        ``cutoff`` [Hz], ``decimation``, samples ``dropped`` at each edge, ``rows`` used, ``rest_percent``, the share
        of the samples at rest [%], and ``velocity_max``, the largest fitted speed [m/s or rad/s].
    unfinished : str
        Work that an interruption prevented, in words; empty if complete.
    further_logs : tuple of Log
        The other logs of the fit.
    break_aways : tuple of BreakAway
        Break-aways in the log by rate, the slowest first, with inertia and offset of the best model.
    left_out : mapping of str to str
        Requested models that bristle cannot compare, by name, with the reason.
    settings : Settings
        The thresholds of the diagnostics.
    second_pass : SecondPass or None
        The lines that bristle found for the axis file; None without such lines.
    two_masses : TwoMasses or None
        Motor and load as two masses; None without a second encoder and without an elastic coupling.
    response : Response or None
        Frequency response of the motor of an elastic axis with one encoder.
    explanation : Explanation or None
        All forces in the effort, see `explain`; None if the log does not tell them apart, or if bristle did not look for them.
    """

    fits: tuple[Fit, ...]
    log: Log
    treatment: Mapping[str, float] = field(default_factory=dict)
    further_logs: tuple[Log, ...] = ()
    unfinished: str = ""
    break_aways: tuple[BreakAway, ...] = ()
    left_out: Mapping[str, str] = field(default_factory=dict)
    settings: Settings = DEFAULT
    second_pass: SecondPass | None = None
    two_masses: TwoMasses | None = None
    response: Response | None = None
    explanation: Explanation | None = None

    @property
    def reason_for_one_mass(self) -> str:
        """The reason why an elastic axis, or two encoders, do not show both masses; empty if they do, and for a rigid axis."""
        return self.left_out.get(TWO_MASSES, "")

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes from reading the logs, on omitted models, and on a constant force that the best model fixes at 0."""
        logs, logs_by_note = (self.log, *self.further_logs), dict[str, list[str]]()
        for log in logs:
            for note in log.notes:
                logs_by_note.setdefault(note, []).append(log.source.name)
        remarks = [
            note if len(of) == len(logs) else f"{', '.join(of)}: {note}"
            for note, of in logs_by_note.items()
        ]
        # The best model describes by its two directions a constant force that another model found.
        reasons = {
            estimate.name: estimate.reason
            for estimate in self.best.estimates
            if estimate.reason is not None
        }
        name = next((name for name, reason in reasons.items() if reason.code == "held_levels"), "")
        levels = (
            names_of(Role.LEVEL, self.best.friction.component.variables) or self.best.with_constant
        )
        level = max((abs(self.best.parameters[part].value) for part in levels), default=0.0)
        for fit in self.fits:
            estimate = fit.parameters.get(name)
            if estimate is None or estimate.status != "identified" or estimate.std is None:
                continue
            error = estimate.std if estimate.robust_std is None else estimate.robust_std
            if abs(estimate.value) > max(LARGE_OFFSET * level, SURE_OFFSET * error):
                remarks.append(
                    f"{self.best.name} holds {name} at 0, as every model with +asymmetry does. {fit.name} identified {name} = "
                    f"{with_unit(estimate.value, estimate.unit)}. If a constant force acts, such as a weight, write "
                    f'{name} = "{estimate.value:.4g} {estimate.unit}" under [plant] of the axis file'
                )
                break
        return (
            *remarks,
            *(f"{name} is omitted: {reason}" for name, reason in self.left_out.items()),
        )

    @property
    def best(self) -> Fit:
        """The model of the first rank."""
        return self.fits[0]

    @property
    def finished(self) -> Self:
        """The identification itself; raises KeyboardInterrupt if it is unfinished."""
        if self.unfinished:
            raise KeyboardInterrupt
        return self

    @cached_property
    def sweep(self) -> DahlResonance | str | None:
        """Stiffness and damping from sweeps of small amplitude, or the reason against them; None if the logs have no such sweeps."""
        from bristle.identification.dahl_resonance import dahl_resonance
        from bristle.identification.elasticity import below_resonance

        facts = [
            self.treatment[name]
            for name in ("antiresonance", "inertia_ratio")
            if name in self.treatment
        ]
        return dahl_resonance(
            (self.log, *self.further_logs),
            self.log.position.step,
            below_resonance(*facts) if facts else math.inf,
        )

    @cached_property
    def passages(self) -> tuple[Passage, ...]:
        """The kinds of experiment that the log contains, in order."""
        return passages(self.log)


@dataclass(frozen=True)
class TwoMasses:
    """A motor and a load behind an elastic coupling, identified from a log with an encoder on either side, or at the motor.

    Parameters
    ----------
    quantities : tuple of Quantity
        Masses, stiffness and damping in SI units of the axis, with 95 % intervals; with two encoders also play and friction of
        the nut, and the hysteresis of the coupling, if the log shows it.
    motor : Identification
        Friction models of the bearings of the motor, best first, from motor position and effort minus forces of coupling and
        nut. With one encoder, the friction of both sides.
    load : Identification or None
        Friction models of the load side, best first, from load position and force of the coupling; None with one encoder,
        which does not separate the friction of both sides.
    delay : float
        Delay of the effort [s].
    arm : float
        Movement of the axis per radian of the motor [m/rad]; 1 if unknown, and on a rotational axis.
    nut_is_masked : bool
        Whether other forces mask the friction of a nut, and the force of the coupling is not too small to show it.
    measured : bool
        Whether a sensor of torque or force separates both sides. Friction of the load side is then all friction behind the
        sensor, without that of a nut that the log shows.
    rigid : str
        Reason why the log of a sensor does not show the deflection of the coupling; empty if it does.
    """

    quantities: tuple[Quantity, ...]
    motor: Identification
    load: Identification | None
    delay: float
    arm: float = 1.0
    nut_is_masked: bool = False
    measured: bool = False
    rigid: str = ""

    @property
    def is_elastic(self) -> bool:
        """Whether the log shows the stiffness of the coupling."""
        return "stiffness" in self.by_name

    @property
    def nut_is_separable(self) -> bool:
        """Whether the log separates friction of the nut from bearings, load and stiffness."""
        if self.load is None or "nut" not in self.by_name:
            return False
        nut, stiffness = self.by_name["nut"], self.by_name["stiffness"]
        return nut.value > 0.0 or nut.half_width < stiffness.half_width / stiffness.value

    @property
    def nut(self) -> float:
        """Friction of the nut per force of the coupling; 0 if the log does not show it."""
        return self.by_name["nut"].value if "nut" in self.by_name else 0.0

    @property
    def by_name(self) -> dict[str, Quantity]:
        """The quantities by name."""
        return {quantity.name: quantity for quantity in self.quantities}

    @property
    def sides(self) -> dict[str, Identification]:
        """Friction of motor and load by the name of the side; with one encoder, all friction is that of the motor."""
        return {"motor": self.motor} | ({} if self.load is None else {"load": self.load})

    @property
    def play_is_clear(self) -> bool:
        """Whether the log shows play."""
        return "play" in self.by_name and self.by_name["play"].value > 0.0

    @property
    def plant(self) -> Model:
        """The plant for simulations, a `ball_screw`; without a lead, its motor has the kind of the axis, and moves as far as the load."""
        value = {name: quantity.value for name, quantity in self.by_name.items()}
        J, lead = (value["motor"] + value.get("screw", 0.0)) * self.arm**2, 2.0 * math.pi * self.arm
        return ball_screw(
            kind=self.kind,
            J=J,
            M=value["load"],
            lead=lead,
            k=value["stiffness"],
            d=value["damping"],
            backlash=value.get("play", 0.0),
        )

    @property
    def kind(self) -> Kind:
        """The kind of the motor: that of the axis, or rotational behind a lead."""
        return self.motor.best.friction.kind if self.arm == 1.0 else "rotational"

    @property
    def motor_friction(self) -> Model:
        """Friction of bearings and nut in units of the motor; without that of the nut if the model has no slot ``+transmitted``."""
        friction, nut = _determined(self.motor.best), self.nut
        name = (
            model_with("transmitted", friction)
            if nut > 0.0 and goes_by_name(friction.component)
            else ""
        )
        return self.at_the_motor(
            find(name)(kind=friction.kind, **friction.values, c_T=nut) if name else friction
        )

    def at_the_motor(self, friction: Model) -> Model:
        """Return a friction of the axis in units of the motor."""
        values: dict[str, Any] = {}
        for name, value in friction.values.items():
            powers: Mapping[str, float] = exponents_of(friction.component.variables[name].quantity)
            factor = self.arm ** (powers.get("force", 0.0) - powers.get("length", 0.0))
            scaled = np.asarray(value, dtype=float) * factor if powers else value
            values[name] = scaled if np.ndim(scaled) else scaled.item() if powers else value
        return friction.component(kind=self.kind, **values)

    @property
    def table_friction(self) -> Model | None:
        """Friction of the table in N and m; of a rotational load in the same numbers. None with one encoder."""
        if self.load is None:
            return None
        friction = _determined(self.load.best)
        return friction.component(kind="translational", **friction.values)

    def as_data(self) -> dict[str, Any]:
        """Return quantities and friction as plain data."""
        sides = {f"{name}_friction": _friction_data(side.best) for name, side in self.sides.items()}
        numbers = {quantity.name: plain(quantity) for quantity in self.quantities}
        return {
            "quantities": numbers,
            "delay": self.delay,
            "play_is_clear": self.play_is_clear,
            **sides,
        }


def _determined(fit: Fit) -> Model:
    """Return the friction of a fit; a break-away level that the log does not determine is that of sliding."""
    values, variables = fit.friction.values, fit.friction.component.variables
    pairs = zip(names_of(Role.BREAK_AWAY, variables), names_of(Role.LEVEL, variables), strict=False)
    return fit.friction.with_values(
        **{
            peak: values[level]
            for peak, level in pairs
            if fit.parameters[peak].status not in ("identified", "held")
        }
    )


def _friction_data(fit: Fit) -> dict[str, Any]:
    """Return model, parameters and intervals of a side."""
    values = {
        item.name: {
            "value": item.value,
            "unit": item.unit,
            "interval": item.ends,
            "status": item.status,
        }
        for item in fit.estimates
        if item.name in fit.friction.values
    }
    return {"model": fit.name, "error_percent": fit.force_error_percent, "parameters": values}
