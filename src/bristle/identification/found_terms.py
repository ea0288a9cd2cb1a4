"""The terms that a log shows, beside which friction models are fitted.

A force over the position that a plant can have becomes lines of the axis: a spring, gravity of a link, cogging. The plant is
fitted with them from the start, so no slip element can be a spring. All other terms are taken out of the effort, unless a
slot of the model describes them: the fit of each model is that of friction alone.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from bristle.core.axis import Axis, Cogging
from bristle.core.contracts import FrictionModel
from bristle.core.diagnostic import Diagnostic, Number
from bristle.core.errors import InputError
from bristle.core.variable import KINDS
from bristle.identification.dataset import Alignment, Dataset, effort_of
from bristle.identification.dictionary import Group, memory_of
from bristle.identification.estimate import Estimate
from bristle.identification.explain import delay_of, explained, fitted_terms, floor_of
from bristle.identification.explanation import OF_CHANNEL, Explanation
from bristle.identification.friction_law import Refitted
from bristle.identification.gram import rms
from bristle.identification.parameters import acts_in_sliding
from bristle.identification.preprocessing import aligned
from bristle.identification.result import Fit, ProposedLine
from bristle.identification.work_rate import CUTOFF, motion_of
from bristle.logs.log import Log
from bristle.models.friction.next_model import SLOT_OF, model_with
from bristle.models.plants.inertia import MODEL as inertia

Pairs = Sequence[tuple[Log, Axis | None]]

# Doubts of a log whose terms are not told from pre-sliding.
UNSETTLED = ("not_saturated", "reverses_fast", "one_direction", "no_inertia", "delay_at_edge")
SPRINGS = {"spring": "linear", "cubic": "cubic"}
"""Term -> spring of an axis file."""
CAUSES = {
    "level": "position",
    "curve": "position",
    "load": "transmitted",
    "ripple": "ripple",
    "level ripple": "level",
}
"""Term -> cause of friction for which there is a slot."""
PERIODIC = SLOT_OF["ripple"]
UNSURE = 0.2  # half-width of the inertia, as a share of it, above which the log does not show it
CABLE = "cable"
WIDE = 0.1  # of the longest narrow threshold: mean threshold of a memory that reaches further
FOUND = "second_pass"  # code of the note about found lines
NEARLY = 0.1  # allowed deviation from a whole number of waves in a turn
MOST_ORDER = 400  # waves in a turn


class Force(NamedTuple):
    """A term that is no line of the axis: its force in each log, shape (sample,) [N or N*m], and the slot that describes it."""

    forces: tuple[np.ndarray, ...]
    slot: str


@dataclass(frozen=True, eq=False)
class Terms:
    """The terms of a log: lines of the axis with the held-out errors without and with them [%], and the other forces."""

    explanation: Explanation
    lines: tuple[ProposedLine, ...]
    error_without: float
    error_with: float
    forces: Mapping[str, Force]
    unlike_bodies: float = (
        0.0  # gravity that the bodies of an arm do not explain, its amplitude [N*m]
    )

    @property
    def causes(self) -> tuple[str, ...]:
        """Return the causes for which a slot describes a term that is no line of the axis."""
        kinds = [kind_of(name) for name in self.forces]
        # A slot has one wave and its double: further waves stay out of the effort.
        causes = [CAUSES.get(kind, kind) for kind in kinds if kind != "ripple"]
        return tuple(cause for cause in dict.fromkeys(causes) if cause in SLOT_OF)

    def beside(self, component: FrictionModel) -> tuple[str, ...]:
        """Return the terms that are no part of a model: they are taken out of the effort."""
        parts = {surrounding.name for surrounding in component.surroundings}
        parts.update(component.name.split("+"))
        return tuple(name for name, force in self.forces.items() if force.slot not in parts)

    def without(self, names: Sequence[str], number: int, log: Log) -> Log:
        """Return the log of a number with its effort without some terms."""
        assert log.effort is not None
        effort = effort_of(log) - sum(self.forces[name].forces[number] for name in names)
        return replace(log, effort=replace(log.effort, values=effort))


@dataclass(frozen=True, eq=False)
class Beside:
    """The rows of logs for each model, without the terms that are no part of it."""

    terms: Terms
    logs: Sequence[Log]
    treated: Callable[[Sequence[Log]], Dataset]

    def logs_for(self, component: FrictionModel) -> list[Log]:
        """Return the logs without the terms that are no part of a model."""
        names = self.terms.beside(component)
        logs = list(self.logs)
        if names:
            logs = [self.terms.without(names, number, log) for number, log in enumerate(logs)]
        return logs

    def dataset_for(self, component: FrictionModel, like: Dataset) -> Dataset:
        """Return the rows of these logs, aligned like those of other logs."""
        if len(self.terms.beside(component)) == len(self.terms.forces):
            return like
        dataset = self.treated(self.logs_for(component))
        if like.alignment is None:
            return dataset
        return aligned(dataset, like.alignment)

    def share_for(self, component: FrictionModel, components: Sequence[FrictionModel]) -> float:
        """Return the rms of the terms that are no part of a model but of another one, over that of the effort [%]."""
        forces = self.terms.forces
        of_none = set(forces).intersection(*map(self.terms.beside, components))
        names = [name for name in self.terms.beside(component) if name not in of_none]
        if not names:
            return 0.0
        effort = np.concatenate([effort_of(log) for log in self.logs])
        removed = [np.concatenate(forces[name].forces) for name in names]
        return 100.0 * rms(np.sum(removed, axis=0)) / rms(effort)


def about_terms(fit: Fit, beside: Beside, compared: Collection[str]) -> tuple[Diagnostic, ...]:
    """Return the note about the terms that are no part of a model with the next one to try, and a warning about the bodies of an arm."""
    names = beside.terms.beside(fit.friction.component)
    kind = fit.friction.kind
    friction = rms(fit.traces.predicted - fit.traces.mechanical)
    parts = {part.name: part for part in beside.terms.explanation.parts}
    about = list[Diagnostic]()
    if beside.terms.unlike_bodies:
        force = parts["gravity"].rms
        numbers: dict[str, Number] = {"amplitude": beside.terms.unlike_bodies, "force": force}
        numbers["percent"] = 100.0 * force / friction
        about.append(Diagnostic("bodies_differ", "", "warning", numbers, kind))
    texts = [
        f"{parts[name].label(kind)} ({100.0 * parts[name].rms / friction:.2g} % of friction)"
        for name in names
        if name in parts
    ]
    if texts:
        slots = [model_with(cause, fit.friction) for cause in beside.terms.causes]
        further = [name for name in slots if name and name not in compared]
        of_terms: dict[str, Number] = {"terms": tuple(texts), "model": next(iter(further), "")}
        about.append(Diagnostic("terms_beside", "", "note", of_terms, kind))
    return tuple(about)


def with_split(fit: Fit, beside: Beside) -> Fit:
    """Return a fit whose intervals of sliding friction include the error by which a cable is told from it."""
    F_C = beside.terms.explanation.F_C
    if F_C is None or CABLE not in beside.terms.beside(fit.friction.component):
        return fit
    share = F_C.half_width / max(abs(F_C.value), F_C.half_width)
    estimates = list[Estimate]()
    for estimate in fit.estimates:
        variable = fit.friction.component.variables.get(estimate.name)
        ends = estimate.ends
        if variable is not None and ends is not None and acts_in_sliding(variable):
            width = share * abs(estimate.value)
            low = estimate.value - math.hypot(estimate.value - ends[0], width)
            high = estimate.value + math.hypot(ends[1] - estimate.value, width)
            estimate = replace(estimate, interval=(low, high))
        estimates.append(estimate)
    return replace(fit, estimates=tuple(estimates))


def kind_of(name: str) -> str:
    """Return the kind of a term without the number of its waves, or the name of its channel."""
    if name.startswith(OF_CHANNEL):
        return name.removeprefix(OF_CHANNEL)
    return name.rstrip("0123456789.e+-").strip()


def terms_of(
    pairs: Pairs, highest: float = CUTOFF, components: Sequence[FrictionModel] = ()
) -> Terms | None:
    """Return the terms that logs show up to a `highest` frequency [Hz]; None if they do not show any, or are too short to tell.

    A wave that a slot of one of the models describes is no cogging of the axis.
    """
    try:
        final = fitted_terms(motion_of(pairs, highest), delay_of(pairs))
    except InputError:
        return None
    kind = pairs[0][0].kind
    explanation = explained(final, kind)
    if not is_settled(explanation):
        return None
    axis = pairs[0][1] or Axis(kind=kind)
    described = any(PERIODIC in component.name.split("+") for component in components)
    lines, in_plant = lines_of(final, axis, has_waves=described)
    forces = {
        group.name: Force(forces_of(group, final, pairs), slot_of(group.name))
        for group in final.groups
        if group.is_judged and group.role != "filter" and group.name not in in_plant
    }
    if is_wide(final):
        # Then the cable is a part of this memory.
        forces.pop(CABLE, None)
    shape = final.choice.shape
    if shape and shape not in in_plant:
        forces[shape] = Force(forces_of(final.named[shape], final, pairs), slot_of(shape))
    unlike_bodies = 0.0
    if shape == "gravity" and has_bodies(axis):
        unlike_bodies = math.hypot(*final.weights(final.named[shape]).tolist())
    effort = rms(final.motion.row(final.motion.u, final.band.delay.value))
    without = [group for group in final.groups if group.name not in in_plant]
    return Terms(
        explanation=explanation,
        lines=lines,
        error_without=100.0 * floor_of(final, without) / effort,
        error_with=100.0 * floor_of(final, final.groups) / effort,
        forces=forces,
        unlike_bodies=unlike_bodies,
    )


def with_explained(alignment: Alignment, explanation: Explanation, most: float) -> Alignment:
    """Return an alignment with the inertia of the explained log, if known better, and its delay, if known to `most` [s]."""
    if "loaded" in explanation.doubts:
        # Friction that rises with the inertial force looks like inertia.
        return alignment
    delay = explanation.delay
    seeks = alignment.sought and alignment.delay is None
    if seeks and delay is not None and delay.half_width <= most:
        alignment = replace(alignment, delay=delay.value, delay_half_width=delay.half_width)
    M = explanation.M
    if M is None or not alignment.slow or alignment.too_small:
        return alignment
    if M.half_width < (alignment.mass_half_width or math.inf):
        alignment = replace(alignment, mass=M.value, mass_half_width=M.half_width)
    return alignment


def is_settled(explanation: Explanation) -> bool:
    """Return whether a log tells its terms from pre-sliding: it shows inertia and Coulomb friction, or why not the latter."""
    M, F_C = explanation.M, explanation.F_C
    if M is None or M.half_width > UNSURE * M.value:
        return False
    if F_C is not None and F_C.value <= 0.0:
        return False
    return not set(UNSETTLED).intersection(explanation.doubts)


def is_wide(final: Refitted) -> bool:
    """Return whether the memory of friction reaches the longest thresholds that are no cable."""
    grid = final.choice.search.grid
    thresholds = 0.0
    limits = 0.0
    for name, members in memory_of(grid).items():
        group = final.named.get(name)
        if group is None or name == CABLE:
            continue
        weights = final.weights(group) * np.sqrt(np.mean(group.columns**2, axis=0))
        limits += float(weights.sum())
        thresholds += float(weights @ np.array([element.d for element in members]))
    return thresholds > WIDE * float(grid.narrow[-1]) * limits


def slot_of(name: str) -> str:
    """Return the slot of a friction model that describes a term; empty if there is none."""
    kind = kind_of(name)
    return SLOT_OF.get(CAUSES.get(kind, kind), "")


def forces_of(group: Group, final: Refitted, pairs: Pairs) -> tuple[np.ndarray, ...]:
    """Return the force of a group in each log, as late as its effort, shape (sample,) [N or N*m]."""
    force = group.force(final.weights(group))
    if group.role == "place":
        force = force - force.mean()
    forces = list[np.ndarray]()
    begin = 0.0
    for log, _ in pairs:
        time = log.time.values - log.time.values[0] + begin
        begin = float(time[-1]) + log.sample_time
        forces.append(np.interp(time - final.band.delay.value, final.motion.time, force))
    return tuple(forces)


# ---------------------------------------------------------------- lines of the axis
def lines_of(
    final: Refitted, axis: Axis, *, has_waves: bool
) -> tuple[tuple[ProposedLine, ...], set[str]]:
    """Return the lines for the axis file, and the terms that a plant with these lines contains.

    A friction model that `has_waves` takes those over the position.
    """
    lines = list[ProposedLine]()
    in_plant = set[str]()
    shape = final.choice.shape
    if shape in SPRINGS:
        in_plant.add(shape)
        if axis.spring is None and axis.plant == inertia.name:
            lines.append(ProposedLine("plant", "spring", SPRINGS[shape], FOUND))
    if shape == "gravity":
        in_plant.add(shape)
        if not axis.gravity and not has_bodies(axis):
            lines.append(ProposedLine("plant", "gravity", "link", FOUND))
    waves = {group.name: group.frequency for group in final.groups if is_wave(group)}
    if axis.cogging:
        in_plant |= {
            name for name, frequency in waves.items() if is_stated(frequency, axis.cogging)
        }
        return tuple(lines), in_plant
    if has_waves:
        return tuple(lines), in_plant
    turner, travel, orders = cogging_of(list(waves.values()), axis)
    if orders:
        values = {
            "turner": turner,
            "harmonics": tuple(sorted(set(orders.values()))),
            "travel": travel,
        }
        lines += [ProposedLine("cogging", key, value, FOUND) for key, value in values.items()]
        in_plant |= {name for name, frequency in waves.items() if frequency in orders}
    return tuple(lines), in_plant


def has_bodies(axis: Axis) -> bool:
    """Return whether a known effort of an axis is that of the bodies of an arm; it contains their gravity."""
    return any(column.log for column in axis.regressors)


def is_wave(group: Group) -> bool:
    """Whether a group is a wave of the force over the position."""
    return group.role == "place" and group.frequency > 0.0


def is_stated(frequency: float, coggings: Sequence[Cogging]) -> bool:
    """Whether a wave is an order of a turn that the axis file states."""
    return any(order_of(frequency, cogging.turn) for cogging in coggings)


def order_of(frequency: float, turn: float) -> int:
    """Return the whole number of waves in a turn; 0 if it is none."""
    waves = frequency * turn
    order = round(waves)
    if not 0.5 < waves < MOST_ORDER:
        return 0
    if abs(waves - order) > NEARLY:
        return 0
    return order


def cogging_of(frequencies: Sequence[float], axis: Axis) -> tuple[str, float, dict[float, int]]:
    """Return what turns, the movement for a turn [m or rad], and the orders of the waves that belong to it."""
    turn = axis.pitch
    if turn is None and axis.kind == KINDS[1]:
        turn = math.tau
    turner = "screw"
    orders = dict[float, int]()
    if turn is not None:
        orders = orders_in(frequencies, turn)
    if not orders and frequencies:
        turner = "motor"
        # As an axis file states it.
        turn = float(f"{1.0 / min(frequencies):.5g}")
        orders = orders_in(frequencies, turn)
    return turner, turn or 0.0, orders


def orders_in(frequencies: Sequence[float], turn: float) -> dict[float, int]:
    """Return the order of each wave that is one of this turn."""
    orders = {frequency: order_of(frequency, turn) for frequency in frequencies}
    return {frequency: order for frequency, order in orders.items() if order}
