"""Several mechanisms along one recorded effort, as one batch: each moves as it does alone, to the bit."""

import numpy as np
import pytest

from bristle import friction, plants
from bristle.simulation.recorded import open_loop
from bristle.simulation.recorded.open_loop import SHORT, OpenLoop

SIZE, DT = 300, 2e-3
PLANTS = [plants.oscillator(M=mass, c=damping, k=400.0) for mass, damping in ((1.0, 20.0), (3.0, 0.2), (2.0, 8.0))]
FRICTIONS = [friction.dahl(F_C=level, sigma_0=3e3) for level in (1.0, 0.01, 2.0)]
EFFORT = 6.0 * np.sin(2.0 * np.pi * 2.0 * np.arange(SIZE) / SIZE)


@pytest.mark.parametrize("hold", ["linear", "zero"])
@pytest.mark.parametrize("steps", [1, 3])
@pytest.mark.parametrize("periodic", [True, False])
def test_each_moves_as_it_does_alone(periodic, steps, hold):
    loop = OpenLoop(EFFORT, steps, DT, SIZE // steps, periodic, hold)
    alone = [loop.position(plant, model)[0] for plant, model in zip(PLANTS, FRICTIONS, strict=True)]
    for together, item in zip(loop.positions(PLANTS, FRICTIONS), alone, strict=True):
        np.testing.assert_array_equal(together, item)
    assert np.ptp(alone[0]) > 1e-3


def test_only_what_has_not_run_in_is_run_again(monkeypatch):
    counts = []

    def spied(plants, *rest, **options):
        counts.append(len(plants))
        return run_batch(plants, *rest, **options)

    run_batch = open_loop.run_batch
    monkeypatch.setattr(open_loop, "run_batch", spied)
    OpenLoop(EFFORT, 1, DT, SIZE, periodic=True).positions(PLANTS, FRICTIONS)
    assert counts[0] == 3
    assert 0 < counts[-1] < 3


@pytest.mark.parametrize("periodic", [True, False])
def test_one_that_diverges_spoils_none_of_the_others(periodic):
    # A spring that pushes drives the mass away within the record.
    away = plants.oscillator(M=1e-3, c=0.0, k=400.0)
    away = type(away)(away.component, away.parameters._replace(k=-1e9), away.kind)
    several, models = [PLANTS[0], away, PLANTS[2]], FRICTIONS
    loop = OpenLoop(EFFORT + 1.0, 1, DT, SIZE, periodic)
    together = loop.positions(several, models)
    for plant, model, position in zip(several, models, together, strict=True):
        np.testing.assert_array_equal(position, loop.position(plant, model)[0])
    assert np.isfinite(together[[0, 2]]).all()


def test_long_records_are_not_taken_for_short():
    assert OpenLoop(np.zeros(SHORT // 2), 1, DT, SIZE, periodic=True).is_short
    assert not OpenLoop(np.zeros(SHORT // 2 + 1), 1, DT, SIZE, periodic=True).is_short
    assert OpenLoop(np.zeros(SHORT), 1, DT, SIZE, periodic=False).is_short
