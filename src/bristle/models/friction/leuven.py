r"""The Leuven model: a hysteretic contact that slips by a power law.

.. math::
    F = f_h[z] + \sigma_1(v)\,\dot z + \sigma_2 v, \qquad
    \dot z = v\left[1 - \operatorname{sgn}(r)\,|r|^n\right], \qquad
    r = \frac{f_h \operatorname{sgn} v}{G(v)}, \qquad G(v) = F_C + (F_S - F_C)\,e^{-(v/v_S)^2}

with :math:`\sigma_1(v) = \sigma_1 e^{-(v/v_d)^2}`, constant for :math:`v_d = \infty`, and the hysteretic force
:math:`f_h` of a Preisach operator on the deflection :math:`z`. The model is ``preisach_lugre`` with the transition
``leuven``. A later modification [2]_ of the published model replaced the stack of turning points, which can overflow, by
Maxwell-slip elements. bristle keeps the exact stack and counts overflows. The memory is in the deflection, not in the
position: with a small exponent minor loops in the position do not close, and the model drifts. With a large exponent
passivity needs a larger :math:`\sigma_2`: :math:`\sigma_2 \ge \sigma_1 [(F_S/F_C)^n - 1]`. As in ``preisach_lugre``, the
saturation of the operator must exceed the break-away force, :math:`f_p > F_S`.

References
----------
.. [1] J. Swevers, F. Al-Bender, C. G. Ganseman, T. Prajogo, "An integrated friction model structure with improved
   presliding behavior for accurate friction compensation", IEEE Transactions on Automatic Control 45(4), 2000.
   doi:10.1109/9.847103
.. [2] V. Lampaert, J. Swevers, F. Al-Bender, "Modification of the Leuven integrated friction model structure", IEEE
   Transactions on Automatic Control 47(4), 683-687, 2002.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from bristle.core import FrictionModel, Variable, cached_property, variables_of
from bristle.core.read_only import ReadOnly
from bristle.models.friction.preisach_lugre import LEUVEN, MODEL as COMPOSITE

# Values that the model fixes.
HELD = {"transition": LEUVEN, "rho": 0.9}


@dataclass(frozen=True, kw_only=True)
class Leuven(FrictionModel):
    """Preisach-LuGre with a fixed transition."""

    @cached_property
    def variables(self) -> ReadOnly[str, Variable]:
        """Description of each parameter."""
        variables = variables_of(self.Parameters)
        return ReadOnly(
            {name: variable for name, variable in variables.items() if name not in HELD}
        )

    @property
    def defaults(self) -> dict[str, Any]:
        """Default values of the parameters."""
        return {name: value for name, value in super().defaults.items() if name not in HELD}

    def assemble(self, values: Mapping[str, Any]) -> Any:
        """Return the parameters of Preisach-LuGre from the values of the user."""
        return super().assemble({**values, **HELD})

    def values(self, parameters: Any) -> dict[str, Any]:
        """Return the values of the user from the parameters of Preisach-LuGre."""
        return {
            name: value for name, value in super().values(parameters).items() if name not in HELD
        }


MODEL = leuven = Leuven(
    name="leuven",
    module=__name__,
    description="a hysteretic contact that slips by a power law; drifts little with a large exponent",
    Parameters=COMPOSITE.Parameters,
    State=COMPOSITE.State,
    trial=COMPOSITE.trial,
    commit=COMPOSITE.commit,
    piece=COMPOSITE.piece,
    flow=COMPOSITE.flow,
    arrival=COMPOSITE.arrival,
    memory_size=COMPOSITE.memory_size,
    relations=COMPOSITE.relations,
    reference="doi:10.1109/9.847103",
    example={**COMPOSITE.example, "n": 4.0},
)
