"""Derivatives along the recorded motion are those of the predicted rows; the search takes them."""

import math
from dataclasses import replace

import numpy as np
import pytest
from tests.identification.known_logs import STATED, log_of, sines, sliding_effort
from tests.identification.own_models import own_model
from tests.identification.rigid import identify

from bristle.core import InputWarning
from bristle.core.tangent import DIRECTIONS
from bristle.engine.translation.scope import NotExportableError
from bristle.identification import dataset, inverse_dynamics, sensitivities
from bristle.identification.estimation import context_of
from bristle.identification.inverse_dynamics import InverseDynamics
from bristle.identification.least_squares import Linearised, Search
from bristle.identification.parameters import PriorKnowledge, parameters_of
from bristle.identification.preprocessing import treat
from bristle.identification.sensitivities import by_differences, friction_rows
from bristle.models.friction import find
from bristle.models.plants import inertia

MOTION = sines(6.0)
LOG = log_of(MOTION, sliding_effort(MOTION, noise=0.05))
VALUES = {
    "lugre": {
        "F_C": 8.0,
        "F_S": 10.0,
        "v_S": 0.02,
        "sigma_0": 4e4,
        "sigma_1": 50.0,
        "sigma_2": 30.0,
        "v_d": 0.3,
    },
    "lugre+asymmetry": {
        "F_C_pos": 8.0,
        "F_C_neg": 9.0,
        "F_S_pos": 10.0,
        "F_S_neg": 11.0,
        "v_S": 0.02,
        "sigma_0": 4e4,
        "sigma_1": 50.0,
    },
    "gap_slider": {"F_C": 8.0, "give": 2e-4, "gap": 1e-4, "n": 2.2, "share": 0.1, "sigma_2": 30.0},
    "lugre+transmitted": {
        "F_C": 8.0,
        "F_S": 10.0,
        "v_S": 0.02,
        "sigma_0": 4e4,
        "sigma_1": 5.0,
        "sigma_2": 30.0,
        "k_L": 0.1,
    },
    "preisach_lugre": {
        "s": 4e4,
        "f_p": 14.0,
        "F_C": 8.0,
        "F_S": 10.0,
        "v_S": 0.02,
        "sigma_1": 5.0,
        "sigma_2": 30.0,
    },
}


@pytest.fixture(scope="module")
def rows():
    return treat(LOG, STATED, 100.0, 10)


def problem_of(name, rows):
    problem = InverseDynamics(rows, parameters_of(find(name), PriorKnowledge(plant=inertia), rows))
    values = {
        key: (VALUES[name] | {"M": 12.0, "offset": 1.5}).get(key, 20.0)
        for key in problem.parameters.free
    }
    return problem, values


def with_start(problem):
    """The problem of a contact that begins where it is told to, and does not follow the parameters."""
    object.__setattr__(problem, "_without_start", lambda *_: None)
    return problem


@pytest.mark.parametrize(
    ("name", "places"),
    [*((name, None) for name in VALUES), ("gap_slider", 0.4), ("lugre", "repeated")],
)
def test_derivatives_are_those_of_the_predicted_rows(rows, name, places):
    if places == "repeated":
        rows = replace(
            rows, segments=tuple(replace(segment, first_cycle=700) for segment in rows.segments)
        )
    problem, values = problem_of(name, rows)
    problem = replace(
        problem, contacts=(places if isinstance(places, float) else None,) * len(rows.segments)
    )
    residual, derivatives = with_start(problem).linearised(values)
    assert residual == pytest.approx(
        problem.residual(values), abs=1e-12 * np.abs(rows.effort).max()
    )
    assert derivatives.shape == (rows.effort.size, len(values))
    for column, (parameter, value) in zip(derivatives.T, values.items(), strict=True):
        step = 1e-6 * (abs(value) or 1.0)
        high, low = (
            problem.predicted(problem.parameters.complete({**values, parameter: value + h}))
            for h in (step, -step)
        )
        difference = (high - low) / (2.0 * step)
        assert np.linalg.norm(column - difference) < 1e-4 * np.linalg.norm(difference), parameter


def test_a_contact_that_never_slips_remembers_how_its_start_depends_on_the_parameters(rows):
    problem, values = problem_of("gap_slider", rows)
    problem, values = (
        replace(problem, contacts=(0.4,) * len(rows.segments)),
        values | {"give": 0.3, "gap": 0.1},
    )
    column = with_start(problem).linearised(values)[1][:, problem.parameters.free.index("give")]
    high, low = (
        problem.predicted(problem.parameters.complete({**values, "give": 0.3 + step}))
        for step in (1e-6, -1e-6)
    )
    assert column == pytest.approx((high - low) / 2e-6, rel=1e-5, abs=1e-6 * np.abs(column).max())


OWN = {
    name: find("coulomb_viscous").variables[of] for name, of in (("F_C", "F_C"), ("sigma_2", "F_v"))
}


def own_trial(state, memory, motion, dt, p):
    return p.F_C * math.tanh(motion.v / 1e-3) + p.sigma_2 * motion.v, state


def test_an_untranslatable_law_is_differentiated_by_differences_with_a_warning(rows):
    own = own_model(own_trial, OWN)
    problem = InverseDynamics(rows, parameters_of(own, PriorKnowledge(plant=inertia), rows))
    values = {"M": 12.0, "F_C": 8.0, "sigma_2": 30.0, "offset": 0.0}
    with pytest.warns(
        InputWarning, match="bristle differentiates own by finite differences: .*math.tanh"
    ):
        residual, columns = problem.linearised(values)
    assert residual == pytest.approx(
        problem.residual(values), abs=1e-12 * np.abs(rows.effort).max()
    )
    smooth = np.tanh(rows.segments[0].velocity / 1e-3)
    assert columns[:, problem.parameters.free.index("F_C")] == pytest.approx(
        rows.rows_of([rows.filtered(smooth)]), abs=1e-6
    )
    assert columns[:, problem.parameters.free.index("sigma_2")] == pytest.approx(
        rows.velocity, abs=1e-6
    )
    assert columns[:, problem.parameters.free.index("M")] == pytest.approx(rows.acceleration)


@pytest.mark.slow
def test_a_search_differentiates_along_the_motion_and_not_by_differences(monkeypatch):
    calls = []
    monkeypatch.setattr(
        sensitivities,
        "by_differences",
        lambda *arguments: calls.append(1) or by_differences(*arguments),
    )
    motion = sines(2.0)
    log = log_of(motion, sliding_effort(motion, noise=0.05))
    forward = identify(log, "lugre", axis=STATED, blocks=0, draws=0).best
    assert not calls

    def untranslated(*_):
        raise NotExportableError(own_trial, None, "it is told to be so")

    monkeypatch.setattr(inverse_dynamics, "friction_rows", untranslated)
    with pytest.warns(InputWarning, match="bristle differentiates lugre by finite differences"):
        stepwise = identify(log, "lugre", axis=STATED, blocks=0, draws=0).best
    assert forward.error_percent == pytest.approx(stepwise.error_percent, rel=1e-6)
    for parameter in ("F_C", "sigma_2", "M"):
        assert forward.parameters[parameter].value == pytest.approx(
            stepwise.parameters[parameter].value, rel=1e-4
        )


@pytest.mark.parametrize("order", [1, -1])
def test_the_jacobian_of_a_search_is_that_of_its_residual(rows, order):
    problem, values = problem_of("lugre", rows)
    problem = replace(
        problem, parameters=replace(problem.parameters, free=problem.parameters.free[::order])
    )
    search: Search = context_of(rows, PriorKnowledge(plant=inertia)).search(problem)
    # F_S is computed from F_C
    assert (search.space.names == problem.parameters.free) is (order == 1)
    theta, some = search.space.theta(values), np.arange(rows.effort.size) % 3 == 0
    linearised = Linearised(search, some)
    assert linearised.at(theta)[1] == pytest.approx(search.residuals([theta], some)[0], abs=1e-12)
    for column, step in zip(linearised.jacobian(theta).T, 1e-6 * np.eye(theta.size), strict=True):
        high, low = search.residuals([theta + step, theta - step], some)
        assert column == pytest.approx(
            (high - low) / 2e-6, rel=1e-3, abs=1e-4 * np.abs(column).max()
        )


class Weighed(InverseDynamics):
    """An estimator of one's own that predicts otherwise."""

    def predicted(self, values):
        return 0.5 * super().predicted(values)


class Halved(InverseDynamics):
    """An estimator of one's own, which differs in its residual only."""

    def residual(self, free):
        return 0.5 * super().residual(free) ** 2


def test_an_overridden_residual_is_minimised(rows):
    problem, values = problem_of("lugre", rows)
    own = Halved(problem.dataset, problem.parameters)
    residual, derivatives = own.linearised(values)
    assert np.array_equal(residual, own.residual(values))
    assert derivatives is None
    weighed = Weighed(problem.dataset, problem.parameters)
    assert np.array_equal(weighed.linearised(values)[0], weighed.residual(values))
    search = context_of(rows, PriorKnowledge(plant=inertia)).search(own)
    theta = search.space.theta(values)
    usual, columns = problem.linearised(values)
    expected = (
        -usual[:, None]
        * columns[:, [problem.parameters.free.index(name) for name in search.space.names]]
        @ search.space.derivative(theta)
    )
    jacobian = Linearised(search, slice(None)).jacobian(theta) * search.unit
    assert jacobian == pytest.approx(expected, rel=1e-3, abs=1e-4 * np.abs(expected).max())


def test_a_long_log_has_the_rows_of_a_short_one(rows, monkeypatch):
    problem, values = problem_of("preisach_lugre", rows)
    at_once = problem.linearised(values)
    monkeypatch.setattr(sensitivities, "BLOCK", 700)
    for result, expected in zip(problem.linearised(values), at_once, strict=True):
        assert result == pytest.approx(expected, abs=1e-12 * np.abs(expected).max())


def test_directions_beyond_one_run_are_not_lost(rows):
    problem, values = problem_of("lugre", rows)
    names = [name for name in values if name in problem.parameters.component.variables]
    contacts = (None,) * len(rows.segments)
    complete = problem.parameters.complete(values)
    few = friction_rows(problem.model, complete, names, rows, contacts)
    many = friction_rows(problem.model, complete, [*names, *names, *names], rows, contacts)
    assert np.array_equal(many.by_parameters, np.tile(few.by_parameters, 3))
    assert np.array_equal(few.force, many.force)
    eight = friction_rows(problem.model, complete, [*names, *names][:DIRECTIONS], rows, contacts)
    assert np.array_equal(eight.by_parameters, many.by_parameters[:, :DIRECTIONS])
    assert np.array_equal(eight.force, many.force)
    single = tuple(
        replace(segment, velocity=segment.velocity.astype(np.float32)) for segment in rows.segments
    )
    assert friction_rows(
        problem.model, complete, names, replace(rows, segments=single), contacts
    ).force == pytest.approx(few.force, abs=1e-2)
    assert (
        problem_of("lugre+transmitted", rows)[0]
        ._transmitted(problem.plant(complete), [])(rows.segments[0])[1]
        .shape[1]
        == 0
    )
    nothing = friction_rows(problem.model, complete, [], rows, contacts)
    assert nothing.by_parameters.shape == (few.force.size, 0)
    assert np.array_equal(nothing.force, few.force)


def test_a_start_at_an_end_of_its_range_does_not_follow_the_parameters(rows):
    problem, values = problem_of("gap_slider", rows)
    inner, outer = (
        replace(problem, contacts=(place,) * len(rows.segments)) for place in (0.5, 1.0)
    )
    _, held = with_start(replace(outer)).linearised(values)
    assert np.array_equal(outer.linearised(values)[1], held)
    assert not np.array_equal(
        inner.linearised(values)[1], with_start(replace(inner)).linearised(values)[1]
    )


def test_a_memory_full_along_a_log_is_reported(rows):
    component = find("preisach_lugre")

    def model_of(values):
        return component(**{**component.example, "capacity": 4})

    with pytest.warns(InputWarning, match="memory of turning points was full"):
        friction_rows(model_of, {}, [], rows, (None,) * len(rows.segments))


@pytest.mark.parametrize("on", ["a part", "all"])
def test_an_interrupted_search_of_a_long_log_returns_its_best_on_the_whole_log(monkeypatch, on):
    monkeypatch.setattr(dataset, "EXCERPT", 1500)
    sizes, linearised, ended = [], InverseDynamics.linearised, []

    def interrupted(self, free):
        sizes.append(self.dataset.effort.size)
        if not ended and (len(sizes) == 12 if on == "a part" else sizes[-1] > 2 * sizes[0]):
            ended.append(len(sizes))
            raise KeyboardInterrupt
        return linearised(self, free)

    monkeypatch.setattr(InverseDynamics, "linearised", interrupted)
    best = identify(LOG, "lugre", axis=STATED, blocks=0, draws=0).best
    assert best.unfinished
    assert min(sizes[ended[0] :]) > 2 * sizes[0]
    assert len(sizes) - ended[0] <= 2


@pytest.mark.slow
def test_a_search_of_a_long_log_starts_on_an_excerpt_and_ends_on_the_whole(monkeypatch):
    usual = identify(LOG, "lugre", axis=STATED, blocks=0, draws=0).best
    sizes, linearised = [], InverseDynamics.linearised
    monkeypatch.setattr(dataset, "EXCERPT", 1500)
    monkeypatch.setattr(
        InverseDynamics,
        "linearised",
        lambda self, free: sizes.append(self.dataset.effort.size) or linearised(self, free),
    )
    best = identify(LOG, "lugre", axis=STATED, blocks=0, draws=0).best
    count = max(sizes)
    assert sizes[0] < 0.4 * count
    assert 2 * sizes.count(count) < len(sizes)
    assert best.error_percent == pytest.approx(usual.error_percent, rel=1e-6)
    for parameter in ("F_C", "sigma_2", "M"):
        assert best.parameters[parameter].value == pytest.approx(
            usual.parameters[parameter].value, rel=1e-3
        )


def test_an_excerpt_consists_of_pieces_of_the_whole_log(rows, monkeypatch):
    assert rows.excerpt() is None
    monkeypatch.setattr(dataset, "EXCERPT", 1500)
    pieces, (whole,) = rows.excerpt().segments, rows.segments
    assert [piece.time.size for piece in pieces] == [500] * 4
    assert (pieces[0].time[0], pieces[-1].time[-1]) == (whole.time[0], whole.time[-1])
    first = int(np.flatnonzero(whole.time == pieces[2].time[0])[0])
    assert pieces[2].velocity.tolist() == whole.velocity[first : first + 500].tolist()
    assert (
        InverseDynamics(rows, problem_of("lugre", rows)[0].parameters, contacts=(None,)).excerpt()
        is None
    )
    assert Halved(rows, problem_of("lugre", rows)[0].parameters).excerpt() is None
    rests = replace(
        whole,
        velocity=np.where(
            np.isin(whole.time, np.concatenate([piece.time for piece in pieces])),
            0.0,
            whole.velocity,
        ),
    )
    # A cycle is not cut, the pieces may be no more than half of a log, nor may the motion lie between them.
    for changes in (
        {"segments": (replace(whole, first_cycle=700),)},
        {"dropped": 80},
        {"segments": (rests,)},
    ):
        assert replace(rows, **changes).excerpt() is None
    first, both = (
        np.isin(whole.time, np.concatenate([piece.time for piece in pieces[:count]]))
        for count in (1, 3)
    )
    for resting, is_enough in ((first, True), (both, False)):
        partly = replace(
            rows, segments=(replace(whole, velocity=np.where(resting, 0.0, whole.velocity)),)
        )
        assert (partly.excerpt() is not None) is is_enough
    monkeypatch.setattr(dataset, "EXCERPT", 1)
    assert [piece.time.size for piece in replace(rows, dropped=5).excerpt().segments] == [
        150
    ] * 4  # a tenth of the log
    monkeypatch.setattr(dataset, "EXCERPT", 1500)
    short = whole.cut(slice(0, 900))
    assert replace(rows, segments=(whole, short)).excerpt().segments[-1] is short
