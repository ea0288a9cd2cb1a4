r"""The virtual rig: a ball-screw table with the friction of thirty elements that slip one after the other.

Thirty spring-slider elements in parallel break away one after the other, the last one after 7 µm: distances
:math:`r_j = 7\,\text{µm} \cdot \rho_j^{1.6}`, :math:`\rho_j` even from 0.15 to 1, weights
:math:`w_j = (r_j/7\,\text{µm})^{-0.75} e^{0.35\,\xi_j}` with :math:`\xi_j` standard normal from one fixed seed, shares
:math:`\nu_j \propto w_j r_j`. Their limits follow a Stribeck curve, may be larger forward than backward,
and scatter by 5 % from reversal to reversal; an offset is added. A Maxwell-slip model is its kin, and what is
identified as one knows neither the fall with speed, nor the directions, nor the scatter. Everything is told for the
table: a torque of the screw is a force :math:`2\pi/\ell` times as large, an inertia a mass :math:`(2\pi/\ell)^2` times.

Nothing here comes from a measurement: inertia, torque and lead of the rig in the paper are not told, and these are
values with which its figures come out.
"""

from __future__ import annotations

import math

import numpy as np

from bristle import friction
from bristle.core.contracts import Model

__all__ = ["rig_friction", "screw_ratio"]

ELEMENTS, BREAK_AWAY, SEED = 30, 7e-6, 7
COULOMB, STATIC, VISCOUS = 34e-3, 40e-3, 3e-3  # torques [N*m], and torque over speed [N*m*s/rad]
STRIBECK = 0.5  # [rad/s]
SCATTER, SMALLEST_SPEED = 0.05, 5e-8
DAMPING = 0.4  # of the elements, over the root of stiffness times mass


def screw_ratio(lead: float) -> float:
    """Return the angle of the screw for one metre of the table [rad/m], for a lead [m]."""
    return 2.0 * math.pi / lead


def rig_friction(lead: float, inertia: float, offset: float, asymmetry: float) -> Model:
    """Return the friction of the virtual rig as the table feels it."""
    ratio = screw_ratio(lead)
    r = BREAK_AWAY * np.linspace(0.15, 1.0, ELEMENTS) ** 1.6
    irregular = np.exp(0.35 * np.random.default_rng(SEED).standard_normal(ELEMENTS))
    strength = (r / BREAK_AWAY) ** -0.75 * irregular * r
    nu = strength / strength.sum()
    k = nu * STATIC * ratio / r
    forward, backward = 1.0 + asymmetry, 1.0 - asymmetry
    viscous = VISCOUS * ratio**2
    return friction.find("maxwell_stribeck+asymmetry")(
        F_C_pos=forward * COULOMB * ratio,
        F_C_neg=backward * COULOMB * ratio,
        F_S_pos=forward * STATIC * ratio,
        F_S_neg=backward * STATIC * ratio,
        v_S=STRIBECK / ratio,
        k_i=k,
        nu_i=nu,
        sigma_1=DAMPING * math.sqrt(float(k.sum()) * inertia) * ratio,
        sigma_2_pos=viscous,
        sigma_2_neg=viscous,
        scatter=SCATTER,
        v_r=SMALLEST_SPEED,
        seed=1,
        offset=offset * ratio,
    )
