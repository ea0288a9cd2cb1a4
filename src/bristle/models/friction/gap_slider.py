r"""A slider in series with a hardening spring with backlash: a banded damper, or a loose joint that slips.

The spring deflects by `z`, limited to :math:`\pm r`, :math:`r = \tfrac12 h + a`, with the backlash `h` (``gap``) and the
deflection :math:`a` (``give``) from the end of the backlash to slip. The force is a monotone function of the deflection,

.. math::
    F(z) = F_C \operatorname{sgn}(z)\left[\lambda\,\frac{|z|}{r}
           + (1 - \lambda)\left(\frac{(|z| - \tfrac12 h)_+}{a}\right)^{n}\right] + \sigma_2 v,

with the linear share :math:`\lambda` (``share``); :math:`(\cdot)_+` is 0 for a negative argument. The force reaches
:math:`F_C` where the slider slips. At a reversal the force falls steeply, is small throughout the backlash, and then
rises on the other side with a growing slope. Between the ends :math:`\pm r` the contact is elastic: a cycle dissipates
energy in slip only. A sum of stops (Prandtl-Ishlinskii) cannot represent this force, because the stiffness of such a sum
only falls along a stroke.

At the beginning of a log the position of the contact within its backlash is unknown. With ``+asymmetry`` the two ends
have separate forces and springs, selected by the sign of the deflection.

References
----------
.. [1] A. Downey, L. Cao, S. Laflamme, D. Taylor, J. Ricles, "High capacity variable friction damper based on band
   brake technology", Engineering Structures 113, 2016: the device. doi:10.1016/j.engstruct.2016.01.035
"""

from typing import Annotated, NamedTuple

from bristle.core import FrictionModel, Variable, kernel
from bristle.core.mathematics import power
from bristle.models.friction.quantities import CoulombForce, ViscousCoefficient


class Parameters(NamedTuple):
    """Parameters of the slider behind a spring with backlash."""

    F_C: CoulombForce
    give: Annotated[
        float,
        Variable(
            "length",
            "deflection from the end of the backlash to slip",
            min=1e-12,
            nominal=1e-3,
            directional=True,
            excitation="displacement",
        ),
    ]
    gap: Annotated[
        float, Variable("length", "backlash, from end to end", min=0.0, excitation="displacement")
    ] = 0.0
    n: Annotated[
        float,
        Variable(
            "1",
            "exponent of the spring, above 1 for a hardening spring",
            min=1.0,
            max=12.0,
            nominal=2.0,
            excitation="displacement",
        ),
    ] = 1.0
    share: Annotated[
        float,
        Variable(
            "1",
            "share of the force that rises linearly, also within the backlash",
            min=0.0,
            max=1.0,
            nominal=0.1,
            excitation="displacement",
        ),
    ] = 0.0
    sigma_2: ViscousCoefficient = 0.0


class State(NamedTuple):
    """State of the slider behind a spring with backlash."""

    z: Annotated[
        float, Variable("length", "deflection of the spring, from the middle of its backlash")
    ] = 0.0


class Move(NamedTuple):
    """Result of a trial, applied by commit."""

    z_next: float


@kernel
def spring(z, p):
    """Return force [N or N*m] and energy [J] of one side of the spring at a deflection `z` >= 0."""
    r = 0.5 * p.gap + p.give
    beyond = max(z - 0.5 * p.gap, 0.0) / p.give
    steep = 0.0 if beyond == 0.0 else power(beyond, p.n)
    force = p.F_C * (p.share * z / r + (1.0 - p.share) * steep)
    energy = p.F_C * (
        0.5 * p.share * z * z / r + (1.0 - p.share) * steep * beyond * p.give / (p.n + 1.0)
    )
    return force, energy


@kernel
def signed(z, backward, forward):
    """Return force and energy of the spring, on the side that it leans to."""
    if z >= 0.0:
        return spring(z, forward)
    force, energy = spring(-z, backward)
    return -force, energy


@kernel
def trial_sided(state, memory, motion, dt, backward, forward):
    """Return the mean force [N or N*m] over a step, and the deflection at its end, with parameters for either side."""
    dx = motion.v * dt
    high = 0.5 * forward.gap + forward.give
    low = -0.5 * backward.gap - backward.give
    z = min(max(state.z, low), high)
    z_next = min(max(z + dx, low), high)
    force, energy = signed(z_next, backward, forward)
    moved = z_next - z
    if moved != 0.0:
        # The mean of a map over a stretch is the difference of its integrals; over a short stretch digits cancel.
        before, energy_before = signed(z, backward, forward)
        mean = (energy - energy_before) / moved
        if abs(moved) < 1e-5 * (high - low):
            mean = 0.5 * (before + force)
        force = (moved * mean + (dx - moved) * force) / dx
    sigma_2 = forward.sigma_2 if motion.v > 0.0 else backward.sigma_2
    return force + sigma_2 * motion.v, Move(z_next)


@kernel
def trial(state, memory, motion, dt, p):
    """Return the mean force [N or N*m] over a step at constant velocity, and the deflection at its end."""
    return trial_sided(state, memory, motion, dt, p, p)


@kernel
def commit(state, memory, move, p):
    """Return the state after the step."""
    return State(move.z_next)


def start(place, backward, forward):
    """Return the state at a place from -1, about to slip backward, to 1, about to slip forward."""
    side = forward if place >= 0.0 else backward
    return State(place * (0.5 * side.gap + side.give))


MODEL = gap_slider = FrictionModel(
    name="gap_slider",
    description="a slider in series with a hardening spring that has backlash",
    Parameters=Parameters,
    State=State,
    trial=trial,
    commit=commit,
    trial_sided=trial_sided,
    start=start,
    reference="doi:10.1016/j.engstruct.2016.01.035",
    example={"F_C": 20.0, "give": 4e-6, "gap": 4e-6, "n": 2.0, "share": 0.1, "sigma_2": 200.0},
)
