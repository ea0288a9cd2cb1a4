"""A search over the whole range of every parameter, where a descent ends in the wrong place."""

from dataclasses import replace

import numpy as np
import pytest
from benchmarks.loops import AXIS, recorded_in_loop
from tests.identification.test_output_error import AXIS as OPEN
from tests.identification.test_output_error import recorded

from bristle import friction
from bristle.core.diagnostic import BestSoFar
from bristle.identification import identify, output_error
from bristle.identification.global_search import box_of
from bristle.identification.inverse_dynamics import InverseDynamics
from bristle.identification.output_error import Simulation

PRESLIDING = friction.dahl(F_C=20.0, sigma_0=5e6, sigma_2=200.0)


class Landscape:
    """What a fit searches, and where it ended."""

    def __init__(self, log, model, axis, monkeypatch):
        estimated = Simulation.estimate

        def spied(simulation, context, inverse, start, report):
            estimation = estimated(simulation, context, inverse, start, report)
            error = simulation.error(inverse)
            self.search = context.search(error, error.magnitude, simulates=True)
            self.solution, self.error = estimation.solution, estimation.problem
            return estimation

        with monkeypatch.context() as patch:
            patch.setattr(Simulation, "estimate", spied)
            patch.setattr(output_error, "FURTHER_STARTS", 0)  # the first one comes to the best place there is
            identify(log, model, axis=axis, draws=0, blocks=0)
        self.goal = self.percent(self.solution.values)

    def percent(self, values, limit=60):
        """Where a descent ends, in percent of the signal."""
        return self.search.percent(self.search.refit(values, limit=limit).cost)

    @property
    def places(self):
        """Places drawn from the box: starts that know nothing."""
        space, rng = self.search.space, np.random.default_rng(0)
        box = box_of(space.transforms, space.theta(self.solution.values))
        return [space.values(np.array([side.coordinate(rng.uniform(side.low, side.high)) for side in box])) for _ in range(3)]

    def explored(self, start):
        rough = replace(self.search, problem=self.error.rough)
        theta = rough.explored(self.search.space.theta(start), BestSoFar())
        return self.percent(self.search.space.values(theta))


def found_where_descents_fail(present):
    ends = [present.percent(place, limit=30) for place in present.places]
    assert sum(end > 1.5 * present.goal for end in ends) >= 2
    worst = present.places[int(np.argmax(ends))]
    assert present.explored(worst) < 1.05 * present.goal


@pytest.mark.slow
def test_an_oscillator_is_found_from_where_a_descent_fails(monkeypatch):
    found_where_descents_fail(Landscape(recorded(), "bouc_wen_classic", OPEN, monkeypatch))


@pytest.mark.slow
def test_presliding_in_a_loop_is_found_from_where_a_descent_fails(monkeypatch):
    log = recorded_in_loop(PRESLIDING, 0, pairs=4, scatter=0.0)
    found_where_descents_fail(Landscape(log, "dahl", AXIS, monkeypatch))


def test_interrupted_on_the_way_it_returns_the_best_place_so_far():
    message = []

    def report(share, text):
        message.append(text)
        if sum("looking everywhere" in item for item in message) == 3:
            raise KeyboardInterrupt

    identification = identify(recorded(), "bouc_wen_classic", axis=OPEN, draws=0, blocks=0, global_search=True, progress=report)
    assert identification.best.unfinished
    assert identification.best.position_error_percent < 5.0
    assert any("looking everywhere, best so far" in item for item in message)


def test_inverse_dynamics_looks_everywhere_too(monkeypatch):
    log, seen = recorded_in_loop(PRESLIDING, 0, pairs=2, scatter=0.0), []
    residual = InverseDynamics.residual
    monkeypatch.setattr(InverseDynamics, "residual", lambda self, free: (seen.append(1), residual(self, free))[1])
    counts, errors = [], []
    for everywhere in (False, True):
        seen.clear()
        fit = identify(log, "dahl", axis=AXIS, method="inverse_dynamics", draws=0, blocks=0, global_search=everywhere).best
        counts.append(len(seen))
        errors.append(fit.force_error_percent)
    assert counts[1] > counts[0] + 500
    assert errors[1] <= 1.001 * errors[0]
