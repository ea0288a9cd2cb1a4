"""A search over the whole range of every parameter, where a descent ends in the wrong place."""

from dataclasses import replace

import numpy as np
from benchmarks.loops import AXIS, recorded_in_loop
from tests.identification.test_output_error import AXIS as OPEN
from tests.identification.test_output_error import recorded

from bristle import friction
from bristle.identification import identify
from bristle.identification.global_search import box_of
from bristle.identification.interruption import BestSoFar
from bristle.identification.problem import Problem
from bristle.identification.refinement import Refinement
from bristle.identification.unknowns import coordinates_of

PRESLIDING = friction.dahl(F_C=20.0, sigma_0=5e6, sigma_2=200.0)


class Landscape:
    """What a fit searches, and where it ended."""

    def __init__(self, log, model, axis, monkeypatch):
        refine = Refinement.of

        def spied(refinement, inverse, start, report=None):
            self.solution, self.error = refine(refinement, inverse, start)
            self.search = refinement._search(inverse, 4)
            return self.solution, self.error

        with monkeypatch.context() as patch:
            patch.setattr(Refinement, "of", spied)
            identify(log, model, axis=axis, draws=0, blocks=0)
        self.goal = self.percent(self.solution.values)

    def percent(self, values, limit=60):
        """Where a descent ends, in percent of the signal."""
        return self.search.percent(self.search.refit(values, limit=limit).cost)

    @property
    def middle(self):
        """The middle of the box: a start that knows nothing."""
        coordinates = coordinates_of(self.search.problem.unknowns, self.search.scales)
        box = box_of(coordinates, self.search.phi_of(self.solution.values))
        return self.search.values_of(np.array([side.coordinate(0.5 * (side.low + side.high)) for side in box]))

    def explored(self, start, seed):
        rough = replace(self.search, problem=self.error.rough)
        return self.percent(rough.explored(start, BestSoFar(), seed=seed))


def test_an_oscillator_is_found_from_where_a_descent_fails(monkeypatch):
    there = Landscape(recorded(), "bouc_wen_classic", OPEN, monkeypatch)
    assert there.percent(there.middle) > 3.0 * there.goal
    assert there.explored(there.middle, 1) < 1.05 * there.goal


def test_presliding_in_a_loop_is_found_from_where_a_descent_fails(monkeypatch):
    there = Landscape(recorded_in_loop(PRESLIDING, 0, pairs=6, scatter=0.0), "dahl", AXIS, monkeypatch)
    bad = {name: {"sigma_0": 100.0, "M": 3.0}.get(name, 1.0) * one for name, one in there.solution.values.items()}
    assert there.percent(bad) > 3.0 * there.goal
    assert there.explored(bad, 1) < 1.05 * there.goal


def test_interrupted_on_the_way_it_returns_the_best_place_so_far():
    told = []

    def report(share, text):
        told.append(text)
        if sum("looking everywhere" in one for one in told) == 3:
            raise KeyboardInterrupt

    found = identify(recorded(), "bouc_wen_classic", axis=OPEN, draws=0, blocks=0, global_search=True, progress=report)
    assert found.best.unfinished
    assert found.best.position_error_percent < 5.0
    assert any("looking everywhere, best so far" in one for one in told)


def test_inverse_dynamics_looks_everywhere_too(monkeypatch):
    log, seen = recorded_in_loop(PRESLIDING, 0, pairs=2, scatter=0.0), []
    residual = Problem.residual
    monkeypatch.setattr(Problem, "residual", lambda self, free: (seen.append(1), residual(self, free))[1])
    counts, errors = [], []
    for everywhere in (False, True):
        seen.clear()
        fit = identify(
            log, "dahl", axis=AXIS, method="inverse_dynamics", draws=0, blocks=0, global_search=everywhere
        ).best
        counts.append(len(seen))
        errors.append(fit.force_error_percent)
    assert counts[1] > counts[0] + 500
    assert errors[1] <= 1.001 * errors[0]
