"""Parameters that change on the way: what the contact remembers carries over."""

import numpy as np
import pytest

from bristle import friction
from bristle.core.packing import pack
from bristle.engine import force_along
from bristle.engine.motion import in_turns

DT = 1e-3
V = np.concatenate([np.full(300, 2e-5), np.full(300, -2e-5), np.full(300, 2e-5)])
MODELS = [
    friction.lugre(F_C=20.0, F_S=28.0, v_S=2e-3, sigma_0=1e7, sigma_1=1e3),
    friction.maxwell_slip(F_C=20.0, k_i=[6e6, 3e6], nu_i=[0.5, 0.5]),
    friction.preisach_lugre(s=1e7, f_p=40.0, F_C=20.0, F_S=28.0, v_S=2e-3),
]


@pytest.mark.parametrize("model", MODELS, ids=lambda item: item.name)
def test_turns_with_equal_parameters_equal_a_single_run(model):
    rows = np.tile(pack(model.parameters), (3, 1))
    x = DT * np.cumsum(V)
    np.testing.assert_array_equal(
        in_turns(model, rows, V, DT, x, [0, 250, 700]), force_along(model, V, DT, x)
    )


@pytest.mark.parametrize("model", MODELS, ids=lambda item: item.name)
def test_a_level_that_changes_at_a_reversal_causes_no_jump(model):
    forces = {name: value for name, value in model.values.items() if name in ("F_C", "F_S", "f_p")}
    rows = np.array(
        [
            pack(
                model.with_values(
                    **{name: level * value for name, value in forces.items()}
                ).parameters
            )
            for level in (1.0, 1.05, 0.9)
        ]
    )
    force = in_turns(model, rows, V, DT, DT * np.cumsum(V), [0, 300, 600])
    steps = np.abs(np.diff(force))
    assert (
        steps[[299, 599]].max() < 3.0 * np.abs(np.diff(force_along(model, V, DT)))[[299, 599]].max()
    )
    same = force_along(model, V, DT)
    np.testing.assert_array_equal(force[:300], same[:300])
    assert np.max(np.abs(force - same)[300:]) > 0.1
