r"""Friction of the seals of a hydraulic or pneumatic cylinder, which rises with the pressure.

.. math:: F = F_\text{model} + k_P\,(P - P_0)\,(F_\text{model} - F_v v)

The interference fit and the pressure press the lip of a seal on rod and bore. The level of friction rises with both [1]_,
to first order linearly [2]_. Viscous friction does not change.

References
----------
.. [1] X. B. Tran, H. Yanada, "Dynamic friction behaviors of pneumatic cylinders", Intelligent Control and Automation
   4(2), 2013. doi:10.4236/ica.2013.42022
.. [2] F. A. Sârbu, F. Arnăuţ, A. Deaconescu, T. Deaconescu, "Theoretical and experimental research concerning the
   friction forces developed in hydraulic cylinder coaxial sealing systems made from polymers", Polymers 16(1), 2024.
   doi:10.3390/polym16010157
"""

from typing import Annotated, NamedTuple

from bristle.core import Surrounding, Variable, kernel
from bristle.core.slot import LEVEL, Slot

# A rotational axis may also have a pressure, such as that of a vane actuator.
PRESSURE = "force of travel/travel^2"


class Parameters(NamedTuple):
    """Parameters of the slot."""

    k_P: Annotated[
        float,
        Variable(
            "travel^2/force of travel",
            "relative change of the friction level per unit of pressure",
            nominal=1e-7,
            excitation="channel",
        ),
    ] = 0.0
    P_0: Annotated[
        float,
        Variable(PRESSURE, "pressure at which the parameters of the model apply", nominal=1e6),
    ] = 0.0


@kernel
def factor(pressure, p):
    """Return the factor of the level of friction at a pressure [Pa]."""
    return 1.0 + p.k_P * (pressure - p.P_0)


SLOT = Slot(
    name="pressure",
    description="a level of dry friction that rises with the pressure on the seals",
    channel=Surrounding(
        "pressure", Variable(PRESSURE, "pressure on the seals", min=0.0, nominal=1e7), usual=0.0
    ),
    Parameters=Parameters,
    factor=factor,
    of=LEVEL,
    reference="doi:10.4236/ica.2013.42022",
    example={"k_P": 1e-7},
)
