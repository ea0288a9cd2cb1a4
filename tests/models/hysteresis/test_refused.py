"""What makes no operator, no table and no input of one is refused by name, with advice."""

import numpy as np
import pytest
from tests.models.hysteresis.paths import of

from bristle import friction, response
from bristle.core.errors import InputError
from bristle.engine.path import output_along
from bristle.models.hysteresis import (
    conditioned,
    everett_table,
    from_reversal_curves,
    inverse_of,
    play,
    prandtl_ishlinskii,
    preisach,
    preisach_grid,
    relay_grid,
    relays_of,
    reversal_table,
    table_of_curves,
    tabulated,
)

RISE = np.linspace(0.0, 1.0, 9)
FALLING, RISING = ([1.0, 0.0], [1.0, 0.0]), ([0.0, 1.0], [1.0, 0.0])
DAHL, COULOMB = of("dahl_masing"), friction.coulomb(F_C=1.0)
STOPS = prandtl_ishlinskii(thresholds=[0.3], weights=[2.0])


def table(**sizes):
    return tabulated(lambda alpha, beta: alpha - beta, 1.0, **sizes)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: table(rows=1), "rows: out of range"),
        (lambda: table(rows=4), "rows: must be odd.*Take 5"),
        (lambda: table(columns=2), "columns: out of range"),
        (lambda: everett_table(extent=1.0, E=np.zeros(8), upper=np.zeros(4)), "odd number of rows"),
        (
            lambda: everett_table(extent=1.0, E=[0.0] * 6, upper=[0.0] * 3),
            "E with an odd number of rows",
        ),
        (
            lambda: everett_table(extent=1.0, E=[0.0] * 10, upper=[0.0] * 2),
            "E with an odd number of rows",
        ),
        (
            lambda: everett_table(extent=1.0, E=[1.0, *[0.0] * 8], upper=[0.0] * 3),
            "E = 0 at alpha = beta",
        ),
        (lambda: from_reversal_curves([FALLING]), "at least 2"),
        (lambda: from_reversal_curves([FALLING, RISING]), r"curves\[1\]: must fall throughout"),
        (lambda: table_of_curves([(RISE, RISE)]), "at least 2"),
        (
            lambda: table_of_curves([(RISE, RISE), (-RISE, RISE)]),
            r"curves\[1\]: must rise throughout",
        ),
        (lambda: table_of_curves([(RISE, RISE), (RISE, RISE)]), "start at different inputs"),
        (lambda: table_of_curves([(RISE, RISE), (RISE, RISE)], columns=1), "columns: out of range"),
        (lambda: preisach_grid(low=1.0, high=1.0, E=[1.0]), "low < high"),
        (lambda: preisach_grid(low=0.0, high=1.0, E=[1.0, 1.0]), "values of E for n cells"),
        (lambda: relay_grid(levels=[0.0, 0.0, 1.0], weights=[1.0, 1.0, 1.0]), "levels that rise"),
        (lambda: relay_grid(levels=[0.0, 1.0], weights=[1.0, 1.0]), "weights for n cells"),
        (
            lambda: reversal_table(
                reversals=[0.0, 0.0, 1.0], ends=[1.0] * 3, E=[0.0] * 6, E_top=[0.0] * 3
            ),
            "reversals that rise",
        ),
        (lambda: relays_of(STOPS, 1.0, 10), "no Everett function"),
        (
            lambda: prandtl_ishlinskii(thresholds=[], weights=[]),
            "thresholds and weights of the same length",
        ),
        (lambda: prandtl_ishlinskii(thresholds=[1.0, 2.0], weights=[1.0]), "same length"),
        (
            lambda: prandtl_ishlinskii(thresholds=[-1.0], weights=[1.0]),
            r"thresholds\[0\]: out of range",
        ),
        (lambda: preisach(kernel="dahl", s=1.0, f_p=1.0), "is not a valid choice"),
        (lambda: preisach(s=1.0, f_p=1.0, capacity=2), "capacity: out of range"),
        (lambda: conditioned(0.0), "amplitude"),
        (lambda: conditioned(1.0, 0), "reversals"),
        # A force at saturation has no displacement.
        *(
            (
                lambda force=force: response(inverse_of(DAHL), [0.5, force]),
                "model: the output of inverse_preisach is not finite at sample 1",
            )
            for force in (1.0, -1.5)
        ),
        (
            lambda: inverse_of(prandtl_ishlinskii(thresholds=[1e-6], weights=[6e6])),
            r"prandtl_ishlinskii: must have an output that rises everywhere; found 0.*allowed slope > 0. Add a parallel spring",
        ),
        (
            lambda: inverse_of(prandtl_ishlinskii(thresholds=[1.0], weights=[-2.0], spring=1.0)),
            "rises everywhere",
        ),
        (lambda: inverse_of(play(r=1.0)), "has no inverse in bristle"),
        (lambda: response(DAHL, [0.0, 1.0], 1e-3), "does not apply to a hysteresis operator"),
        (lambda: response(DAHL, [0.0, np.nan]), "finite"),
        (lambda: response(DAHL, [0.0], history=[np.inf]), "finite"),
        (lambda: output_along(COULOMB, [0.0]), "hysteresis operator"),
        (
            lambda: response(COULOMB, [0.0, 1.0], 1.0, history=[1.0]),
            "applies only to hysteresis operators",
        ),
    ],
)
def test_invalid_operators_tables_and_inputs_are_refused_by_name(call, words):
    with pytest.raises(InputError, match=words):
        call()
