r"""A slot of your own: friction that rises with the humidity of the air.

.. math:: F = \bigl(1 + k_H (h - h_0)\bigr) F_\text{model}

Check it with ``bristle check humidity.py``. Name the column under [columns] of the axis file: ``humidity = { column =
"rh", unit = "%" }``. Then fit it with ``bristle identify LOG --axis AXIS.toml --model lugre+humidity.py``.
"""

from typing import Annotated, NamedTuple

from bristle.core import Slot, Surrounding, Variable, kernel


class Parameters(NamedTuple):
    k_H: Annotated[
        float,
        Variable(
            "1", "change of friction from dry to saturated air", nominal=0.1, excitation="channel"
        ),
    ] = 0.0
    h_0: Annotated[
        float,
        Variable(
            "1",
            "humidity at which the parameters of the friction model are valid",
            min=0.0,
            max=1.0,
        ),
    ] = 0.5


@kernel
def factor(humidity, p):
    return 1.0 + p.k_H * (humidity - p.h_0)


SLOT = Slot(
    name="humidity",
    description="friction that rises with the humidity of the air",
    channel=Surrounding(
        "humidity", Variable("1", "relative humidity", min=0.0, max=1.0), usual=0.5
    ),
    Parameters=Parameters,
    factor=factor,
    example={"k_H": 0.4},
)
