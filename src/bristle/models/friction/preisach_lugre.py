r"""Preisach-LuGre: the bristles of LuGre with the hysteresis of a Preisach operator, (5) to (7) of the source paper.

.. math::
    F = f_h[z] + \sigma_1(v)\,\dot z + \sigma_2 v, \qquad
    \dot z = v\left[1 - \Phi\!\left(\frac{f_h \operatorname{sgn} v}{G(v)}\right)\right], \qquad
    G(v) = F_C + (F_S - F_C)\,e^{-(v/v_S)^2}

with :math:`\sigma_1(v) = \sigma_1 e^{-(v/v_d)^2}`, constant for :math:`v_d = \infty`. A Preisach operator
(`bristle.models.hysteresis.preisach`) computes the hysteretic force :math:`f_h` from the deflection :math:`z`. The parameter
``transition`` selects the function :math:`\Phi` of the ratio :math:`r = f_h \operatorname{sgn} v/G(v)`:

* ``paper``: :math:`\Phi = r`, as printed in the source paper. The memory is in :math:`z`, not in the position. The model
  therefore drifts under a force ripple, more than LuGre, and a minor loop in the position does not close.
* ``leuven``: :math:`\Phi = \operatorname{sgn}(r)\,|r|^n`. With a larger `n` the model drifts less, but passivity then
  needs a larger :math:`\sigma_2`.
* ``elastoplastic`` (the default): a gate, which prevents slip up to :math:`r = \rho`. Below the force :math:`\rho F_S`
  the deflection follows the position: loops close exactly and the model does not drift. The gate depends on the ratio,
  because a fixed break-away force above :math:`G(v)` would make :math:`\Phi` jump.

In sliding :math:`F_{ss} = G(v) \operatorname{sgn} v + \sigma_2 v` for each transition, as in LuGre. The saturation of
the operator must exceed the break-away force, :math:`f_p > F_S`; otherwise the deflection grows without bound while the
body slides. With ``dahl_masing`` of exponent 2 the deflection is at most :math:`f_p F_S/(s(f_p - F_S))`. With
``+asymmetry`` the directions of motion differ in sliding only, because both use one operator. The parameter ``kernel``
also takes a hysteresis operator, measured or identified, whose parameters then replace ``s`` and ``f_p``.

References
----------
.. [1] "Pre-sliding friction control using the sliding mode controller with hysteresis friction compensator",
   equations (5) to (11).
.. [2] J. Swevers, F. Al-Bender, C. G. Ganseman, T. Prajogo, "An integrated friction model structure with improved
   presliding behavior for accurate friction compensation", IEEE Transactions on Automatic Control 45(4), 2000.
   doi:10.1109/9.847103
.. [3] P. Dupont, V. Hayward, B. Armstrong, F. Altpeter, "Single state elastoplastic friction models", IEEE
   Transactions on Automatic Control 47(5), 2002. doi:10.1109/TAC.2002.1000274
"""

import math
from typing import Annotated, Any, NamedTuple

from bristle.core import Relation, Variable, kernel
from bristle.core.dispatch import operator_measure
from bristle.core.mathematics import direction
from bristle.models.friction.branchwise import Contact, deflection_rate, piece_at
from bristle.models.friction.deflection import TOLERANCE, deflect
from bristle.models.friction.lugre import micro_damping, stribeck_force
from bristle.models.friction.operator_kernel import (
    Form,
    Lean,
    Lengths,
    TakesOperator,
    leaning,
    slide,
)
from bristle.models.friction.quantities import (
    CoulombForceAboveZero,
    FadingVelocity,
    MicroDamping,
    ReversalStiffness,
    StaticForceAboveZero,
    StribeckVelocity,
    ViscousCoefficient,
)
from bristle.models.friction.slip_law import SlipLaw
from bristle.models.friction.stribeck import STATIC_ABOVE_COULOMB
from bristle.models.hysteresis.everett import KERNELS, ClosedForm
from bristle.models.hysteresis.turning_points import (
    SMALLEST_CAPACITY,
    Stack,
    stack_commit,
    stack_size,
    stack_trial,
)

TRANSITIONS = ("paper", "leuven", "elastoplastic")
PAPER, LEUVEN, ELASTOPLASTIC = range(3)
TRANSITION = Variable("1", "how slip sets in", choices=TRANSITIONS)
EXPONENT = Variable("1", "exponent of the transition leuven", min=1.0, max=50.0)
GATE = Variable(
    "1",
    "share of the sliding force up to which the transition elastoplastic does not slip",
    min=0.0,
    max=0.999,
)


class Parameters(NamedTuple):
    """Parameters of the Preisach-LuGre model."""

    s: ReversalStiffness
    f_p: Annotated[
        float,
        Variable(
            "force", "force at which the operator saturates", min=1e-12, excitation="presliding"
        ),
    ]
    F_C: CoulombForceAboveZero
    F_S: StaticForceAboveZero
    v_S: StribeckVelocity
    sigma_1: MicroDamping = 0.0
    sigma_2: ViscousCoefficient = 0.0
    v_d: FadingVelocity = math.inf
    kernel: Annotated[int, Variable("1", "Everett function of the operator", choices=KERNELS)] = 0
    exponent: Annotated[
        float, Variable("1", "Dahl exponent i of dahl_masing", min=0.1, max=5.0)
    ] = 2.0
    transition: Annotated[int, TRANSITION] = ELASTOPLASTIC
    n: Annotated[float, EXPONENT] = 2.0
    rho: Annotated[float, GATE] = 0.9
    capacity: Annotated[
        int, Variable("1", "turning points remembered", min=SMALLEST_CAPACITY, max=100_000)
    ] = 256


class Sliding(NamedTuple):
    """Parameters besides those of the kernel."""

    F_C: CoulombForceAboveZero
    F_S: StaticForceAboveZero
    v_S: StribeckVelocity
    sigma_1: MicroDamping = 0.0
    sigma_2: ViscousCoefficient = 0.0
    v_d: FadingVelocity = math.inf
    transition: Annotated[int, TRANSITION] = ELASTOPLASTIC
    n: Annotated[float, EXPONENT] = 2.0
    rho: Annotated[float, GATE] = 0.9


class OverTurningPoints(NamedTuple):
    """Parameters over an operator with turning points."""

    operator: Any
    own: Sliding
    lengths: Lengths


class OverStops(NamedTuple):
    """Parameters over stops in parallel."""

    operator: Any
    own: Sliding
    lengths: Lengths


SATURATION_ABOVE_STATIC = Relation(
    "f_p > F_S",
    lambda p: p.f_p > p.F_S,
    "Raise f_p to at least 1.05 F_S: otherwise the deflection grows without bound while the body slides",
)
SATURATION_WELL_ABOVE_STATIC = Relation(
    "f_p >= 1.05 * F_S",
    lambda p: p.f_p >= 1.05 * p.F_S,
    "Raise f_p: this close to F_S, the deflection in sliding is many times the deflection at break-away",
    advisory=True,
)


@kernel
def slip_law(p):
    """Return the slip law of the chosen transition."""
    if p.transition == ELASTOPLASTIC:
        return SlipLaw(p.rho, 1.0, 1.0)
    return SlipLaw(-1.0, p.n if p.transition == LEUVEN else 1.0, 1.0)


@kernel
def trial(state, memory, motion, dt, p):
    """Return the mean force [N or N*m] over a step at constant velocity, and the move of the memory."""
    v = motion.v
    q = ClosedForm(p.kernel, p.s, p.f_p, p.exponent)
    scale = p.f_p / p.s
    deflected = deflect(
        state,
        memory,
        v * dt,
        direction(v),
        stribeck_force(v, p),
        slip_law(p),
        q,
        scale,
        TOLERANCE * scale,
    )
    z_dot = deflected.change / dt if dt > 0.0 else 0.0
    return deflected.mean + micro_damping(v, p) * z_dot + p.sigma_2 * v, deflected.move


@kernel
def deflected_over(stack, memory, q, v, dt, p):
    """Return the mean force [N or N*m] over a step, and the move, for a measure `q` without closed form."""
    own = p.own
    deflected = deflect(
        stack,
        memory,
        v * dt,
        direction(v),
        stribeck_force(v, own),
        slip_law(own),
        q,
        p.lengths.turn,
        p.lengths.smallest,
    )
    z_dot = deflected.change / dt if dt > 0.0 else 0.0
    return deflected.mean + micro_damping(v, own) * z_dot + own.sigma_2 * v, deflected.move


@kernel
def trial_over_turning_points(state, memory, motion, dt, p):
    """Return the mean force [N or N*m] over a step, and the move, over an operator with turning points."""
    return deflected_over(state, memory, operator_measure(p.operator), motion.v, dt, p)


@kernel
def trial_over_stops(state, memory, motion, dt, p):
    """Return the mean force [N or N*m] over a step, and the move, over stops in parallel."""
    stack, q = leaning(state, memory, p.operator)
    force, move = deflected_over(stack, memory, q, motion.v, dt, p)
    return force, Lean(move.z, move.f)


@kernel
def commit_over_stops(state, memory, move, p):
    """Return the state after the step; every slider follows the deflection."""
    return slide(state, memory, move, p.operator)


@kernel
def commit(state, memory, move, p):
    """Return the state after the step; a reversal of the deflection stores a turning point."""
    return stack_commit(state, memory, move)


@kernel
def piece(state, memory, motion, p):
    """Return the deflection [m or rad], and the constants until the next event."""
    held = piece_at(state, memory, direction(motion.v), stribeck_force(motion.v, p), slip_law(p))
    return Contact(state.z), held


@kernel
def flow(contact, piece, motion, p):
    """Return the force [N or N*m], the rate of the deflection [m/s or rad/s], and the margin to the next event."""
    v = motion.v
    q = ClosedForm(p.kernel, p.s, p.f_p, p.exponent)
    now = deflection_rate(contact.z, piece, v, stribeck_force(v, p), slip_law(p), q)
    force = now.f + micro_damping(v, p) * now.z_dot + p.sigma_2 * v
    return force, Contact(now.z_dot), min(now.margin, piece.side * v / p.v_S)


@kernel
def arrival(state, memory, contact, p):
    """Return the move to the deflection at an event."""
    q = ClosedForm(p.kernel, p.s, p.f_p, p.exponent)
    return stack_trial(state, memory, contact.z, TOLERANCE * p.f_p / p.s, q)[1]


def memory_size(p: Parameters) -> int:
    """Return the room for the turning points of the deflection."""
    return stack_size(p.capacity)


MODEL = preisach_lugre = TakesOperator(
    name="preisach_lugre",
    description="bristles with the non-local memory of a Preisach operator; closes its loops, does not drift",
    Parameters=Parameters,
    State=Stack,
    trial=trial,
    commit=commit,
    piece=piece,
    flow=flow,
    arrival=arrival,
    memory_size=memory_size,
    relations=(STATIC_ABOVE_COULOMB, SATURATION_ABOVE_STATIC, SATURATION_WELL_ABOVE_STATIC),
    reference="doi:10.1109/9.847103",
    example={
        "s": 1e7,
        "f_p": 33.6,
        "F_C": 20.0,
        "F_S": 28.0,
        "v_S": 2e-3,
        "sigma_1": 1e3,
        "sigma_2": 800.0,
    },
    own=Sliding,
    turning=Form(OverTurningPoints, Stack, trial_over_turning_points, commit),
    stops=Form(OverStops, Lean, trial_over_stops, commit_over_stops),
    own_relations=(STATIC_ABOVE_COULOMB,),
    exceeded="F_S",
    example_over={"F_C": 3.0, "F_S": 4.0},
)
