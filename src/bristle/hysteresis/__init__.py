"""Hysteresis operators, one a file: what comes out depends on the path of the input, not on its speed.

Each name is a descriptor: call it with parameters to have an operator, and run it with `bristle.response`.

Examples
--------
>>> import bristle as br
>>> operator = br.hysteresis.preisach(kernel="reformed_dahl_exact", s="125 mN*m/rad", f_p="150 mN*m")
>>> br.response(operator, [1.0, 0.5, 1.0]).round(6)
array([0.056552, 0.008571, 0.056552])
"""

from typing import TYPE_CHECKING

from bristle.core.contracts import HysteresisOperator, Model
from bristle.core.edge import guarded, model
from bristle.core.errors import InputError
from bristle.hysteresis.everett_table import MODEL as everett_table
from bristle.hysteresis.initial import conditioned, saturated
from bristle.hysteresis.inverse_prandtl_ishlinskii import MODEL as inverse_prandtl_ishlinskii
from bristle.hysteresis.inverse_prandtl_ishlinskii import inverse_of as _inverse_of_stops
from bristle.hysteresis.inverse_preisach import MODEL as inverse_preisach
from bristle.hysteresis.play import MODEL as play
from bristle.hysteresis.prandtl_ishlinskii import MODEL as prandtl_ishlinskii
from bristle.hysteresis.preisach import MODEL as preisach
from bristle.hysteresis.preisach_grid import MODEL as preisach_grid
from bristle.hysteresis.relay_grid import MODEL as relay_grid
from bristle.hysteresis.relay_grid import relays_of
from bristle.hysteresis.reversal_table import MODEL as reversal_table
from bristle.hysteresis.stop import MODEL as stop
from bristle.hysteresis.tabulate import from_reversal_curves, table_of_curves, tabulated
from bristle.hysteresis.transition_branches import transition_branches
from bristle.loading import loaded_from

if TYPE_CHECKING:
    from bristle.hysteresis.beside_constant import with_constant

__getattr__ = loaded_from(__name__)

OPERATORS: dict[str, HysteresisOperator] = {
    operator.name: operator
    for operator in (
        play,
        stop,
        prandtl_ishlinskii,
        inverse_prandtl_ishlinskii,
        preisach,
        inverse_preisach,
        everett_table,
        reversal_table,
        preisach_grid,
        relay_grid,
    )
}
"""Every hysteresis operator, by name."""

__all__ = [
    "OPERATORS",
    "conditioned",
    "everett_table",
    "from_reversal_curves",
    "inverse_of",
    "inverse_prandtl_ishlinskii",
    "inverse_preisach",
    "play",
    "prandtl_ishlinskii",
    "preisach",
    "preisach_grid",
    "relay_grid",
    "relays_of",
    "reversal_table",
    "saturated",
    "stop",
    "table_of_curves",
    "tabulated",
    "transition_branches",
]


@guarded(operator=model("hysteresis"))
def inverse_of(operator: Model) -> Model:
    """Return the inverse of an operator: the displacement from the force.

    Parameters
    ----------
    operator : Model
        A `prandtl_ishlinskii` or `preisach` operator with parameters.

    Returns
    -------
    Model
        The operator from force [N or N*m] to displacement [m or rad].

    Raises
    ------
    InputError
        If there is no inverse.
    """
    if operator.component is prandtl_ishlinskii:
        return _inverse_of_stops(operator)
    if operator.component is preisach:
        return inverse_preisach(kind=operator.kind, **operator.values)
    raise InputError("has no inverse here", path="operator", value=operator.name, allowed="prandtl_ishlinskii, preisach")


def __dir__() -> list[str]:
    return [name for name in __all__ if not name.isupper()]
