r"""Inverse dynamics: measured effort as the sum of plant and friction, on the rows of a data set.

.. math:: u = M \ddot q + F(\dot q, \dots) + \text{offset}

holds in every row; the parameters minimise the sum of squares of the residual. It needs no simulation and no
controller.

References
----------
.. [1] L. Kaufman, "A variable projection method for solving separable nonlinear least squares problems", BIT 15(1),
   1975. doi:10.1007/BF01932995
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from bristle.core.axis import Axis
from bristle.core.contracts import Model
from bristle.core.errors import InputError
from bristle.core.lazy import cached_property
from bristle.core.normal import NORMAL_95
from bristle.core.variable import unit_of
from bristle.engine.translation.scope import NotExportableError
from bristle.identification import half_cycles as cycles
from bristle.identification.dataset import Dataset, Segment, mechanical, transmitted_by
from bristle.identification.parameters import ParameterSet
from bristle.identification.preprocessing import differentiated, treat
from bristle.identification.problem import Away, Fold, has_own
from bristle.identification.sensitivities import (
    Transmitted,
    by_differences,
    friction_rows,
    warn_of_differences,
)
from bristle.identification.settings import Settings
from bristle.logs.filters import derivative
from bristle.logs.log import Channel, Log
from bristle.models.friction.level import TRANSMITTED
from bristle.models.plants.terms import TURN

HOLD = 0.25  # samples, as a standard error: a held effort may act half a sample earlier or later
# Of the mean offset of fits to replicates; addition if the motion is not visible beyond the filter.
DOUBT, UNSEEN = (0.8, 0.4)
# Distance from a reversal: periods of the cut-off; seconds, for filters in the channels.
AWAY, AWAY_TIME = (2.0, 15e-3)


@dataclass(frozen=True)
class InverseDynamics:
    """Rows ``effort = M acceleration + ... + F(motion)``; by default the `contacts` before each segment fit the effort best."""

    dataset: Dataset
    parameters: ParameterSet
    contacts: tuple[float | None, ...] | None = None

    def friction(self, values: Mapping[str, float]) -> np.ndarray:
        """Return the friction force of each row [N or N*m] along the recorded motion."""
        component = self.parameters.component
        asks = component.start is not None or TRANSMITTED in component.variables.values()
        plant = self.plant(values) if asks else None
        return self.dataset.rows_of(
            self.dataset.friction_along(self.model(values), plant, self.contacts)
        )

    def model(self, values: Mapping[str, float]) -> Model:
        """Return the friction model with these values, without validation."""
        component = self.parameters.component
        return Model(
            component,
            component.assemble({name: values[name] for name in component.variables}),
            self.dataset.kind,
        )

    def plant(self, values: Mapping[str, float]) -> Model:
        """Return the plant with these values, without validation."""
        plant = self.parameters.plant
        return Model(
            plant,
            plant.assemble({name: values[name] for name in plant.variables}),
            self.dataset.kind,
        )

    def predicted(self, values: Mapping[str, float]) -> np.ndarray:
        """Return the effort of each row [N or N*m] from all parameters, fixed ones included."""
        return self.dataset.rows_of(
            self.dataset.explained(self.plant(values), self.model(values), self.contacts)
        )

    def mechanical(self, values: Mapping[str, float]) -> np.ndarray:
        """Return the effort of the plant in each row, without friction [N or N*m]."""
        return self.dataset.mechanical_rows(self.plant(values))

    def residual(self, free: Mapping[str, float]) -> np.ndarray:
        """Return measured minus predicted effort of each row [N or N*m], from the free parameters."""
        return self.dataset.effort - self.predicted({**self.parameters.held, **free})

    def excerpt(self) -> Self | None:
        """Return the problem for a part of a long log; None for a short log or a derived class."""
        dataset = (
            self.dataset.excerpt()
            if self.contacts is None and type(self) is InverseDynamics
            else None
        )
        return None if dataset is None else replace(self, dataset=dataset)

    def linearised(self, free: Mapping[str, float]) -> tuple[np.ndarray, np.ndarray | None]:
        """Return the residual of each row, and the derivative of the predicted effort by each free parameter, shape (row, free)."""
        # Derivatives are integrated with the force, or computed by differences if a kernel cannot be translated. The contact
        # before a segment depends on the parameters: the part that it explains is removed. Derived classes have no
        # derivative.
        if has_own(self, InverseDynamics, "residual", "predicted", "friction"):
            return self.residual(free), None
        parameters, values = self.parameters, self.parameters.complete(free)
        component, plant, model = parameters.component, self.plant(values), self.model(values)
        passes_on = TRANSMITTED in component.variables.values()
        contacts = self.dataset.contacts(model, plant) if self.contacts is None else self.contacts
        names = [name for name in parameters.free if passes_on or name in component.variables]
        try:
            rows = friction_rows(
                self.model,
                values,
                names,
                self.dataset,
                contacts,
                self._transmitted(plant, names) if passes_on else None,
            )
        except NotExportableError as error:
            warn_of_differences(component, error)
            rows = by_differences(
                lambda near, places: replace(self, contacts=tuple(places)).friction(near),
                values,
                names,
                contacts,
            )
        columns = np.zeros((rows.force.size, len(parameters.free)))
        columns[:, [parameters.free.index(name) for name in names]] = rows.by_parameters
        for at, name in enumerate(parameters.free):
            if name not in component.variables:
                columns[:, at] += self.plant_columns[name]
        if rows.by_contact is not None:
            self._without_start(columns, rows.by_contact, contacts)
        return self.dataset.effort - self.mechanical(values) - rows.force, columns

    def _transmitted(self, plant: Model, names: Sequence[str]) -> Transmitted:
        """Return a function of a segment: the effort transmitted to the load, and its derivatives by these parameters."""
        units = [
            self.plant(self.unit(name)) if name in self.parameters.plant.variables else None
            for name in names
        ]

        def along(segment: Segment) -> tuple[np.ndarray, np.ndarray]:
            columns = [
                np.zeros(segment.time.size) if unit is None else mechanical(unit, segment)
                for unit in units
            ]
            return mechanical(plant, segment), np.reshape(
                columns, (len(units), segment.time.size)
            ).T

        return along

    def _without_start(
        self, columns: np.ndarray, change: np.ndarray, contacts: Sequence[float | None]
    ) -> None:
        """Project off the effect of the initial contact (variable projection [1]_), unless it is at an end of its range."""
        for number, contact in enumerate(contacts):
            within = self.dataset.segment_of_row == number
            direction = change[within]
            length = float(direction @ direction)
            if contact is not None and abs(contact) < 1.0 and length > 0.0:
                columns[within] -= np.outer(direction, direction @ columns[within]) / length

    @cached_property
    def plant_columns(self) -> dict[str, np.ndarray]:
        """The effort of each row for each free parameter of the plant, in which it is linear [N or N*m per SI]."""
        return {
            name: self.mechanical(self.unit(name))
            for name in self.parameters.free
            if name in self.parameters.plant.variables
        }

    def found_first(self) -> list[np.ndarray]:
        """Return the change of the effort by one standard error of delay, bend and each measured parameter, shape (row,) each."""
        changes, step = list[np.ndarray](), self.dataset.sample_time
        for name, entry in self.parameters.fixed.items():
            if entry.half_width is not None:
                changes.append(entry.half_width / NORMAL_95 * self.mechanical(self.unit(name)))
        slopes = [derivative(segment.effort, step) for segment in self.dataset.segments]
        if self.delay_std:
            changes.append(self.delay_std * self.dataset.rows_of(slopes))
        if self.bend_std:
            changes.append(
                self.bend_std * self.dataset.rows_of([derivative(slope, step) for slope in slopes])
            )
        return changes

    @cached_property
    def delay_std(self) -> float:
        """Standard error of the removed delay [s]; that of a hold if delay and hold are unknown."""
        alignment = self.dataset.alignment
        if alignment is None or not alignment.sought:
            return 0.0
        if alignment.delay is None:
            return HOLD * self.dataset.sample_time if self.dataset.held is None else 0.0
        return (alignment.delay_half_width or 0.0) / NORMAL_95

    @property
    def bend_std(self) -> float:
        """Standard error of half the square of the time constant of a removed filter [s^2]."""
        alignment = self.dataset.alignment
        if (
            alignment is None
            or alignment.smoothing is None
            or alignment.smoothing_half_width is None
        ):
            return 0.0
        return abs(alignment.smoothing) * alignment.smoothing_half_width / NORMAL_95

    def errors(self, free: Mapping[str, float]) -> dict[str, float]:
        """Return an empty dictionary: every fit has the error of the effort along the motion."""
        return {}

    def effort_residual(self, free: Mapping[str, float], residual: np.ndarray) -> np.ndarray:
        """Return the residual unchanged: it is that of the effort of each row [N or N*m]."""
        return residual

    @cached_property
    def measured(self) -> np.ndarray:
        """Effort of each row [N or N*m]."""
        return self.dataset.effort

    @property
    def row_time(self) -> float:
        """Time from row to row [s]."""
        return self.dataset.decimation * self.dataset.sample_time

    @cached_property
    def half_cycles(self) -> cycles.Groups:
        """The rows of each half-cycle."""
        return cycles.half_cycles(self.dataset)

    @cached_property
    def away(self) -> Away:
        """The rows away from reversals and rests; after six times this distance, a slide is steady."""
        dataset, x, speed = self.dataset, self.dataset.position, np.abs(self.dataset.velocity)
        time, least = (
            dataset.samples_from_rest * dataset.sample_time,
            max(AWAY / dataset.cutoff, AWAY_TIME),
        )
        turns = (
            float(np.ptp(x)) * dataset.cutoff / max(float(np.median(speed)), np.finfo(float).tiny)
        )
        # Times as long: from here on, a slide is steady.
        return Away(time > least, time > 6.0 * least, x, dataset.velocity, turns)

    @cached_property
    def columns(self) -> np.ndarray:
        """Regressor of a linear model, shape (row, free): the response to one parameter of 1 with all others 0."""
        plant = self.parameters.plant.variables
        columns = [
            self.plant_columns[name] if name in plant else self.friction(self.unit(name))
            for name in self.parameters.free
        ]
        return np.stack(columns, axis=1) if columns else np.empty((self.dataset.effort.size, 0))

    def unit(self, *names: str) -> dict[str, float]:
        """Return these parameters at 1 and the others at 0; nonlinear parameters, such as a length, keep their fixed values."""
        values, of_friction = (
            {name: float(name in names) for name in self.parameters.variables},
            self.parameters.component.variables,
        )
        for name, fixed in self.parameters.fixed.items():
            variable = self.parameters.variables[name]
            if (
                "force" not in variable.quantity
                if name in of_friction
                else variable in TURN.values()
            ):
                values[name] = fixed.value
        return values

    @cached_property
    def fixed_effort(self) -> np.ndarray:
        """Effort of each row [N or N*m] due to the fixed parameters alone, for a linear model."""
        return self.predicted(self.parameters.complete(dict.fromkeys(self.parameters.free, 0.0)))

    def friction_slope(self, values: Mapping[str, float]) -> np.ndarray:
        """Return the derivative of the effort of each row by the relative friction level [N or N*m]."""
        return (
            self.friction(cycles.scaled(self.parameters.component, values, 1.0 + cycles.NUDGE))
            - self.friction(values)
        ) / cycles.NUDGE

    def replicates(
        self, values: Mapping[str, float], slope: np.ndarray, residual: np.ndarray
    ) -> RowReplicates:
        """Return the replicates of the fitted model."""
        return RowReplicates(self, values)

    def folds(self, count: int, settings: Settings | None = None) -> tuple[str, list[Fold]]:
        """Return time blocks of the logs; rows next to a block share samples with it through the filters, and are not fitted."""
        if settings is not None and count > (
            most := cycles.room_for_blocks(self.dataset, settings)
        ):
            raise InputError(
                "are too many for this log",
                path="blocks",
                value=count,
                allowed=f"2 to {max(most, 2)}, or 0",
            )
        name, blocks = cycles.time_blocks(self.dataset, count)
        return name, [
            Fold(block, cycles.beside(block, self.dataset.reach), block) for block in blocks
        ]


@dataclass(frozen=True)
class RowReplicates:
    """Replicates of the rows of a fitted `problem`, with all its parameters `values` [SI]."""

    # Plant and friction act along the motion of the log, with a scattering friction level, noise of the effort and an
    # encoder with a random phase. Filters, encoder and scatter therefore bias a fit to a replicate as they bias the
    # estimate.
    problem: InverseDynamics
    values: Mapping[str, float]
    left: tuple[np.ndarray, ...] | None = None

    @property
    def doubt(self) -> float:
        """Doubt of the offset of the fits; it grows as the position shows less of the reversals beyond the filter."""
        pairs = zip(self._recovered, self._starts, strict=True)
        return DOUBT + UNSEEN * (
            1.0
            - float(
                np.mean(np.concatenate([motion.visible[list(starts)] for motion, starts in pairs]))
            )
        )

    def made_with(self, values: Mapping[str, float]) -> RowReplicates:
        """Return replicates of the same model with other parameters."""
        return replace(self, values=values, left=self._residual)

    def draw(
        self, disturbance: cycles.Disturbance, rng: np.random.Generator, side: float = 1.0
    ) -> InverseDynamics:
        """Return the same problem on a new random log."""
        dataset, log = self.problem.dataset, self.log(disturbance, rng, side)
        axis = Axis(kind=dataset.kind, resolution=dataset.resolution)
        drawn = treat(log, axis, dataset.cutoff, dataset.decimation, like=dataset)
        segments = tuple(
            replace(
                new,
                surroundings=old.surroundings,
                first_cycle=old.first_cycle,
                log=old.log,
                regressors=old.regressors,
            )
            for new, old in zip(drawn.segments, dataset.segments, strict=True)
        )
        drawn = replace(drawn, segments=segments)
        finely = dataset.alignment is not None and dataset.alignment.slow > 0.0
        return replace(self.problem, dataset=differentiated(drawn) if finely else drawn)

    def log(
        self, disturbance: cycles.Disturbance, rng: np.random.Generator, side: float = 1.0
    ) -> Log:
        """Return a new random log: the segments of the motion in sequence."""
        dataset = self.problem.dataset
        scatter, noise, jitter = (
            side * size for size in (disturbance.scatter, disturbance.noise, disturbance.jitter)
        )
        efforts, positions, segments, first = [], [], [], 0
        late, bent, plant = self._wrong(rng, side)
        motions = zip(self._recovered, self._between, self._starts, self._residual, strict=True)
        for (segment, _), between, starts, residual in motions:
            transmitted = transmitted_by(self._friction, self._plant, between)
            fine = cycles.force_with_scatter(
                self._friction,
                between,
                [cycles.FINER * start for start in starts],
                dataset.sample_time / cycles.FINER,
                scatter,
                rng,
                transmitted=transmitted,
            )
            pure = fine[:: cycles.FINER] + mechanical(plant, segment)
            slope = derivative(pure, dataset.sample_time)
            pure += bent * derivative(slope, dataset.sample_time) - late * slope
            pure += side * disturbance.unexplained * cycles.signs(pure.size, rng) * residual
            efforts.append(pure + noise * rng.standard_normal(pure.size))
            positions.append(segment.position + jitter * rng.standard_normal(pure.size))
            segments.append(slice(first, first + pure.size))
            first += pure.size
        position, step = np.concatenate(positions), disturbance.resolution
        if step > 0.0:
            phase = side * rng.uniform(0.0, step)
            position = step * np.round((position + phase) / step) - phase
        length, force = (unit_of(quantity, dataset.kind) for quantity in ("length", "force"))
        return Log(
            time=Channel(
                np.concatenate([segment.time for segment in dataset.segments]), "s", "time"
            ),
            position=Channel(position, length, "position"),
            effort=Channel(np.concatenate(efforts), force, "effort"),
            sample_time=dataset.sample_time,
            segments=tuple(segments),
            kind=dataset.kind,
        )

    def _wrong(self, rng: np.random.Generator, side: float) -> tuple[float, float, Model]:
        """Return random errors of delay [s] and filter [s^2], and a plant with random errors."""
        fixed = self.problem.parameters.fixed.items()
        widths = {name: entry.half_width for name, entry in fixed if entry.half_width is not None}
        if not widths and not self.problem.delay_std:
            return 0.0, 0.0, self._plant
        # A separate random stream, independent of other draws and equal in the mirror image.
        assert isinstance(rng.bit_generator, np.random.PCG64)
        apart = np.random.Generator(rng.bit_generator.jumped())
        late, *errors, bent = side * apart.standard_normal(2 + len(widths))
        drawn = {
            name: self.values[name] + error / NORMAL_95 * width
            for (name, width), error in zip(widths.items(), errors, strict=True)
        }
        return (
            float(late) * self.problem.delay_std,
            float(bent) * self.problem.bend_std,
            self.problem.plant({**self.values, **drawn}),
        )

    @cached_property
    def _friction(self) -> Model:
        return self.problem.model(self.values)

    @cached_property
    def _plant(self) -> Model:
        return self.problem.plant(self.values)

    @cached_property
    def _starts(self) -> tuple[tuple[int, ...], ...]:
        return cycles.half_cycle_starts(self.problem.dataset)

    @cached_property
    def _recovered(self) -> tuple[cycles.Recovered, ...]:
        """The unfiltered motion of the log."""
        return tuple(
            cycles.recovered(segment, self.problem.dataset)
            for segment in self.problem.dataset.segments
        )

    @cached_property
    def _between(self) -> tuple[Segment, ...]:
        """The same motion on a finer grid."""
        return tuple(
            cycles.between_samples(motion.segment, self.problem.dataset.sample_time)
            for motion in self._recovered
        )

    @cached_property
    def _residual(self) -> tuple[np.ndarray, ...]:
        """Residual of the fitted model along each segment [N or N*m]."""
        if self.left is not None:
            return self.left
        dataset = self.problem.dataset
        explained = dataset.explained(self._plant, self._friction)
        return tuple(
            segment.effort - effort
            for segment, effort in zip(dataset.segments, explained, strict=True)
        )
