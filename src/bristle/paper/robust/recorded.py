r"""A contact as it was recorded: friction over the place, half-cycle by half-cycle, elastic in between.

A record of one motion to and fro holds, for each half-cycle, friction over the position. Their mean forward is
:math:`U(x)`, backward :math:`L(x)`; what half-cycle `j` has beside the mean is :math:`\rho_j(x)`. From these

.. math::
    \frac{dF}{dx} = k \quad\text{while}\quad L(x) + \rho_j^-(x) \le F \le U(x) + \rho_j^+(x)

and moving forward no more than the upper limit, moving backward no less than the lower one. Each reversal draws the
half-cycle `j` whose residual holds until the next one. The stiffness `k` is the largest that the mean shows after a
reversal.

What a record of one amplitude and one speed cannot tell, this contact does not do: it knows no other speed, and of a
reversal within the stroke only that it is elastic until it meets the recorded loop again.
"""

from typing import Annotated, NamedTuple

import numpy as np

from bristle.core.contracts import FrictionModel, Model, Relation
from bristle.core.errors import InputError
from bristle.core.kernel import kernel
from bristle.core.mathematics import direction
from bristle.core.random_numbers import SEED_MAX, uniform
from bristle.core.variable import Variable
from bristle.friction import slotted
from bristle.logs.log import Log
from bristle.logs.turns import graininess, legs_of, rests_of

SLOWEST_REVERSAL = 5e-8  # [m/s]: slower ones are noise
POINTS = 231
STEEPEST_OVER = 0.02  # of the stroke, over which the stiffness is read
FEWEST = 4  # half-cycles in each direction
ALIKE = 0.05  # of the stroke, by which the turning points of one motion may differ


class Parameters(NamedTuple):
    """Parameters of a recorded contact."""

    x_0: Annotated[float, Variable("length", "where the stroke begins")]
    step: Annotated[float, Variable("length", "from one place of the lists to the next", min=1e-12)]
    k: Annotated[float, Variable("force/length", "stiffness between the limits", min=1e-9)]
    upper: Annotated[np.ndarray, Variable("force", "mean friction moving forward, by place")]
    lower: Annotated[np.ndarray, Variable("force", "mean friction moving backward, by place")]
    forward: Annotated[np.ndarray, Variable("force", "what each half-cycle forward has beside it, one after the other")]
    backward: Annotated[np.ndarray, Variable("force", "the same backward")]
    seed: Annotated[int, Variable("1", "seed of the order of half-cycles", min=0, max=SEED_MAX)] = 0


class State(NamedTuple):
    """Force, direction of the motion, count of reversals, and half-cycle whose residual holds."""

    f: Annotated[float, Variable("force", "friction force")] = 0.0
    side: Annotated[float, Variable("1", "direction of the motion; 0 before the first")] = 0.0
    reversals: Annotated[int, Variable("1", "reversals so far", min=0)] = 0
    row: Annotated[int, Variable("1", "half-cycle whose residual holds", min=0)] = 0


class Move(NamedTuple):
    """What a trial hands to commit."""

    f: float
    v: float


RELATIONS = (
    Relation(
        "upper and lower of one length, at least 2, forward and backward a multiple of it",
        lambda p: (
            len(p.upper) == len(p.lower) >= 2 and len(p.forward) == len(p.backward) >= len(p.upper) and len(p.forward) % len(p.upper) == 0
        ),
        "Give a number for each place",
        structural=True,
    ),
)


@kernel
def at_place(mean, residual, x, row, p):
    """Return a limit [N or N*m] at a position [m or rad], beyond the stroke that at its end."""
    last = mean.size - 1
    share = max(0.0, min((x - p.x_0) / p.step, 1.0 * last))
    i = min(int(share), last - 1)
    part = share - i
    j = row * mean.size + i
    return (1.0 - part) * (mean[i] + residual[j]) + part * (mean[i + 1] + residual[j + 1])


@kernel
def trial(state, memory, motion, dt, p):
    """Return the mean force [N or N*m] over a step at constant velocity, and the force at its end."""
    f = state.f + p.k * motion.v * dt
    if motion.v > 0.0:
        f = min(f, at_place(p.upper, p.forward, motion.x, state.row, p))
    elif motion.v < 0.0:
        f = max(f, at_place(p.lower, p.backward, motion.x, state.row, p))
    return 0.5 * (state.f + f), Move(f, motion.v)


@kernel
def commit(state, memory, move, p):
    """Return the state after the step; a reversal draws another half-cycle."""
    if abs(move.v) > SLOWEST_REVERSAL and (state.side == 0.0 or direction(move.v) * state.side < 0.0):
        count = p.forward.size // p.upper.size
        row = min(int(uniform(p.seed, state.reversals) * count), count - 1)
        return State(move.f, direction(move.v), state.reversals + 1, row)
    return State(move.f, state.side, state.reversals, state.row)


MODEL = FrictionModel(
    name="recorded_contact",
    description="friction over the place as it was recorded, with the residuals of half-cycles drawn anew",
    Parameters=Parameters,
    State=State,
    trial=trial,
    commit=commit,
    relations=RELATIONS,
)


class Record(NamedTuple):
    """Half-cycles of a record over the place."""

    x: np.ndarray
    forward: np.ndarray
    backward: np.ndarray

    @property
    def height(self) -> float:
        """Half of the largest height of the mean loop [N]."""
        return 0.5 * float(np.max(self.forward.mean(axis=0) - self.backward.mean(axis=0)))


def half_cycles_of(log: Log) -> Record:
    """Return the half-cycles of a log that goes to and fro over one stroke, its middle at 0."""
    if log.effort is None:
        raise InputError("has no effort, and a contact is what its friction is", path=str(log.source))
    x, force = log.position.values, log.effort.values
    middle, stroke = 0.5 * float(x.max() + x.min()), float(np.ptp(x))
    grain = graininess(x, log.position.step)
    legs = [
        leg for leg in legs_of(x, rests_of(x, grain, log.sample_time), grain, log.sample_time) if abs(leg.distance) > (1.0 - ALIKE) * stroke
    ]
    sides = [[leg for leg in legs if leg.distance * side > 0.0] for side in (1.0, -1.0)]
    if min(map(len, sides)) < FEWEST:
        raise InputError(
            "goes to and fro over its stroke too few times for a contact",
            path=str(log.source),
            value=min(map(len, sides)),
            allowed=f"at least {FEWEST} times in each direction",
            mend="Take a record of a motion that repeats itself",
        )
    reach = min(min(abs(x[end] - middle) for end in (leg.first, leg.last)) for leg in legs)
    places = np.linspace(-reach, reach, POINTS)
    forward, backward = (np.stack([_over_places(x, force, leg.first, leg.last + 1, places + middle) for leg in side]) for side in sides)
    return Record(places, forward, backward)


def _over_places(x: np.ndarray, force: np.ndarray, first: int, last: int, places: np.ndarray) -> np.ndarray:
    """Return friction at places along a stretch in one direction; steps back, as of noise, are passed over."""
    path, along = x[first:last], force[first:last]
    side = 1.0 if path[-1] > path[0] else -1.0
    onward = np.maximum.accumulate(side * path)
    fresh = np.concatenate([[True], np.diff(onward) > 0.0])
    order = slice(None, None, int(side))
    return np.interp(places, (side * onward[fresh])[order], along[fresh][order])


def recorded_contact(record: Record, factor: float = 1.0) -> Model:
    """Return a contact that does what was recorded, `factor` times as strong."""
    count = min(len(record.forward), len(record.backward))
    forward, backward = factor * record.forward[:count], factor * record.backward[:count]
    upper, lower = forward.mean(axis=0), backward.mean(axis=0)
    step = float(record.x[1] - record.x[0])
    window = max(round(STEEPEST_OVER * POINTS), 1)
    rises = [np.max(mean[window:] - mean[:-window]) for mean in (upper, lower)]
    lists = {"upper": upper, "lower": lower, "forward": (forward - upper).ravel(), "backward": (backward - lower).ravel()}
    k = float(max(rises)) / (window * step)
    return slotted(MODEL, asymmetry=False)(x_0=float(record.x[0]), step=step, k=k, **lists)
