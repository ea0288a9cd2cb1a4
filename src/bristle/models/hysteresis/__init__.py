"""Hysteresis operators, each in a file: the output depends on the path of the input, not on its speed.

Call one with parameters to get an operator with values, and run the operator with `bristle.response`.

Examples
--------
>>> import bristle as br
>>> operator = br.hysteresis.preisach(kernel="reformed_dahl_exact", s="125 mN*m/rad", f_p="150 mN*m")
>>> br.response(operator, [1.0, 0.5, 1.0]).round(6)
array([0.056552, 0.008571, 0.056552])
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from bristle.core.contracts import HysteresisOperator
from bristle.core.loading import loaded_from
from bristle.models.family import Family

if TYPE_CHECKING:
    # Every operator of bristle, in the order of the lists.
    # isort: off
    from bristle.models.hysteresis.play import play as play
    from bristle.models.hysteresis.stop import stop as stop
    from bristle.models.hysteresis.prandtl_ishlinskii import (
        prandtl_ishlinskii as prandtl_ishlinskii,
    )
    from bristle.models.hysteresis.inverse_prandtl_ishlinskii import (
        inverse_prandtl_ishlinskii as inverse_prandtl_ishlinskii,
    )
    from bristle.models.hysteresis.preisach import preisach as preisach
    from bristle.models.hysteresis.inverse_preisach import inverse_preisach as inverse_preisach
    from bristle.models.hysteresis.everett_table import everett_table as everett_table
    from bristle.models.hysteresis.preisach_grid import preisach_grid as preisach_grid
    from bristle.models.hysteresis.reversal_table import reversal_table as reversal_table
    from bristle.models.hysteresis.relay_grid import relay_grid as relay_grid

    # isort: on
    from bristle.models.hysteresis.beside_constant import with_constant
    from bristle.models.hysteresis.initial import conditioned, saturated
    from bristle.models.hysteresis.inverse_preisach import inverse_of
    from bristle.models.hysteresis.relay_grid import relays_of
    from bristle.models.hysteresis.tabulate import from_reversal_curves, table_of_curves, tabulated
    from bristle.models.hysteresis.transition_branches import transition_branches

__getattr__ = loaded_from(__name__)

OPERATORS: Mapping[str, HysteresisOperator] = Family(__name__, "transition_branches")
"""Every hysteresis operator, by name."""

__all__ = [
    "OPERATORS",
    "conditioned",
    "from_reversal_curves",
    "inverse_of",
    "relays_of",
    "saturated",
    "table_of_curves",
    "tabulated",
    "transition_branches",
]


def __dir__() -> list[str]:
    return [*OPERATORS, *(name for name in __all__ if not name.isupper())]
