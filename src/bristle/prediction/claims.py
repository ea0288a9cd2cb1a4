r"""What a feedforward of friction promises: the share that harms no move, and the moves that it improves.

At a reversal after a rest the integral of a controller still carries the friction of the last direction, and a compensator
adds that of the next one. The axis jumps by about :math:`F/K`, the sliding friction over the stiffness of the position loop.
Therefore the share of the contact force returns to its gain within a small part of this reach, and fades at rest
(`bristle.models.controllers.feedforward`). Moves far longer than the reach improve; shorter moves may not.

If `K` is unknown, the share is constant, and bristle promises nothing.
"""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from bristle.core import NORMAL_95, Axis, InputError, Model, number
from bristle.engine.contact import level_of
from bristle.identification.position_loop import stiffness_of
from bristle.identification.result import Bands
from bristle.identification.simulated_bands import MEMBERS
from bristle.models.controllers.feedforward import Rule
from bristle.models.friction.slots import whole_parts

GAIN = 0.9  # share with a known reach, which returns and fades
CONSTANT_GAINS = (0.8, 0.7, 0.6)  # constant shares; the first without a known reach
RETURN = 0.05  # travel constant of the return, over the reach
FADE = 0.5  # time constant at rest [s]
SLOW_FADE = 1.0  # time constant at rest [s] that suits moves that go on in the same direction after short rests
LEAST = 3.0  # shortest promised move, over the reach
LONGEST_REST = 0.3  # between promised moves [s]
FASTEST = 0.1  # [m/s or rad/s] of an axis of unknown speed
NO_FRICTION = (
    1e-100  # level of a friction that drives the axis, such as that of a reversed effort [N or N*m]
)
NEGLIGIBLE = 0.05  # delay over the cycle of the controller that counts as none


class Claim(NamedTuple):
    """Moves that the feedforward does not make worse.

    Moves over `least_distance` [m or rad] or more, as quick as the axis allows or, with `slowest_move`, lasting up to this time
    [s], and rests between them of up to `longest_rest` [s]. Their following error falls at least by a `factor`, which only a
    simulation of the loop shows.
    """

    least_distance: float
    slowest_move: float | None
    longest_rest: float
    factor: float | None = None

    def text(self, length: str) -> str:
        """Return the moves in words, with the least distance as text."""
        pace = "quick moves"
        if self.slowest_move is not None:
            pace = f"moves of up to {self.slowest_move:g} s"
        moves = f"{pace} of {length} or more with rests up to {self.longest_rest:g} s"
        if self.factor is None or self.factor < 1.1:
            return moves
        at_least = math.floor(10.0 * self.factor) / 10.0
        return f"{moves} (error at least {number(at_least, digits=2)} times smaller)"


def doubt_of(model: Model, draws: Mapping[str, np.ndarray]) -> float:
    """Return the half-width of the 95 % interval of the friction level, over the level, from draws of the parameters; 0 without draws."""
    drawn = Bands(draws, scatter=0.0, noise=0.0, unexplained=0.0).models(model, MEMBERS)
    levels = [level_of(member, FASTEST) for member in drawn]
    if levels:
        return NORMAL_95 * float(np.std(levels)) / level_of(model, FASTEST)
    return 0.0


def reach_of(
    friction: Model,
    controller: Model | None,
    treatment: Mapping[str, Any],
    fastest: float = FASTEST,
) -> float | None:
    """Return the reach F/K of a friction in a position loop [m or rad], from its control law or from its log; None if unknown."""
    stiffness = treatment.get("stiffness")
    if controller is not None:
        of_law = stiffness_of(controller)
        if of_law is not None:
            stiffness = of_law.value
    if not stiffness:
        return None
    try:
        level = level_of(friction, fastest)
    except InputError:  # its output grows without bound
        return None
    if level > NO_FRICTION:
        return level / stiffness
    return None


def rule_for(friction: Model, reach: float | None) -> Rule:
    """Return the share of a friction that a compensator feeds forward in a loop of a known or unknown reach."""
    if reach is None:
        return Rule(CONSTANT_GAINS[0], 0.0, FADE, **whole_parts(friction))
    return Rule(GAIN, RETURN * reach, FADE, **whole_parts(friction))


def claims_for(reach: float | None) -> tuple[Claim, ...]:
    """Return the promise of the rule in a loop of this reach, without a simulation of the loop."""
    if reach is None:
        return ()
    return (Claim(LEAST * reach, None, LONGEST_REST),)


class Compensation(NamedTuple):
    """The share of a friction that is fed forward, the reach of its loop [m or rad], and the promise without a simulation."""

    rule: Rule
    reach: float | None
    claims: tuple[Claim, ...]


def compensation_of(
    friction: Model, axis: Axis | None, treatment: Mapping[str, Any]
) -> Compensation:
    """Return how a friction is fed forward in the loop of a log, known from its control law or from the treatment of the log."""
    reach = reach_of(friction, (axis or Axis()).controller, treatment)
    return Compensation(rule_for(friction, reach), reach, claims_for(reach))


def lateness_of(axis: Axis | None, treatment: Mapping[str, Any]) -> float:
    """Return the time by which an effort acts after its command [s].

    A recorded effort that precedes the motion (a negative delay) shows it. An effort that is recorded late belongs to the logger.
    """
    stated = axis or Axis()
    return max(0.0, -treatment.get("delay", 0.0) - stated.delay, treatment.get("lag") or stated.lag)


class Lateness(NamedTuple):
    """A lateness as delay of a loop [samples] and lag of its drive [s]."""

    delay: int
    lag: float


def in_samples(late: float, lag: float, dt: float) -> Lateness:
    """Return a lateness [s] as whole samples and a lag; a known `lag` of the drive [s] is a part of it."""
    if lag:
        return Lateness(max(0, round((late - lag) / dt)), lag)
    if late < NEGLIGIBLE * dt:
        return Lateness(0, 0.0)
    delay = math.floor(late / dt + NEGLIGIBLE)
    return Lateness(delay, max(0.0, late - delay * dt))


def samples_ahead(late: float, cycle: float) -> int:
    """Return the lead of a feedforward in cycles of the controller: one for the next step, and the lateness."""
    return 1 + round(late / cycle)
