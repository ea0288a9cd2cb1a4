"""Standard errors of least squares, against those that textbooks give for a mean and a straight line."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import stats
from tests.identification.known_logs import Motion, log_of, sliding_effort
from tests.identification.rigid import identify
from tests.identification.test_redundancy import one_way

from bristle.core import Axis
from bristle.core.diagnostic import Diagnostic
from bristle.friction import lugre
from bristle.identification import uncertainty
from bristle.identification.dataset import Alignment
from bristle.identification.estimate import Estimate
from bristle.identification.half_cycles import Disturbance
from bristle.identification.parameter_space import ParameterSpace, Solution
from bristle.identification.problem import Fold, _root
from bristle.identification.settings import DEFAULT
from bristle.identification.uncertainty import _bands, _inflation, _judged, _with_interval
from bristle.plants import inertia

BLOCKS = 40  # over which residuals may be correlated
ROWS = 20 * BLOCKS


def one_way_log(**friction):
    # Ten samples a row, and fifty more at either edge.
    motion = Motion(*(signal[: 10 * ROWS + 100] for signal in one_way()))
    return log_of(motion, sliding_effort(motion, **friction))


def test_a_level_alone_is_a_mean():
    log, message = one_way_log(F_v=0.0, offset=0.0), {"mass": 12.0, "offset": 0.0, "axis": Axis(held=False)}
    fit = identify(log, "coulomb", blocks=0, draws=0, **message).best
    level, friction = fit.parameters["F_C"], fit.traces.friction
    assert friction.size == ROWS
    assert level.value == pytest.approx(friction.mean())
    assert level.std == pytest.approx(stats.sem(friction), rel=1e-9)
    # For errors that last: of the means over blocks, which are independent then.
    assert level.robust_std == pytest.approx(stats.sem(friction.reshape(BLOCKS, -1).mean(axis=1)), rel=1e-9)


def test_viscous_friction_with_an_offset_is_a_straight_line():
    fit = identify(one_way_log(F_C=0.0), "viscous", mass=12.0, blocks=0, draws=0).best
    line = stats.linregress(fit.traces.velocity, fit.traces.friction)
    slope, intercept = (fit.parameters[name] for name in ("F_v", "offset"))
    assert (slope.value, intercept.value) == pytest.approx((line.slope, line.intercept), rel=1e-6)
    assert (slope.std, intercept.std) == pytest.approx((line.stderr, line.intercept_stderr), rel=1e-6)


def test_a_variance_negative_by_rounding_has_no_error():
    with np.errstate(all="raise"):
        assert _root(np.array([-1e-30, 0.0, 4.0])).tolist() == [np.inf, 0.0, 2.0]


# Patterns of eight rows that are orthogonal on each chunk of eight, so on each quarter of the rows too.
WALSH = [np.tile(part, 40) for part in ([1.0, -1.0] * 4, [1.0, 1.0, -1.0, -1.0] * 2, [1.0] * 4 + [-1.0] * 4, [1.0] * 8)]
COUNT = 320


def fitted(values, columns, size, space=ParameterSpace):
    """The fit of a signal to columns, which leaves a residual of this size beside all of them, and its problem."""
    names, theta = tuple(values), np.array(list(values.values()))
    jacobian = np.column_stack(columns)
    signal = jacobian @ theta + size * WALSH[3]
    problem = SimpleNamespace(
        residual=lambda free: signal - jacobian @ np.array([free[name] for name in names]),
        dataset=SimpleNamespace(kind="translational"),
        parameters=SimpleNamespace(complete=dict),
    )
    ends = np.full(theta.size, np.inf)
    return problem, Solution(space(names, -ends, ends), theta, jacobian)


@pytest.mark.parametrize(
    ("quantity", "effect", "half_width", "status"),
    [
        ("mass", 1e-3, 1.1, "unidentifiable"),
        ("mass", 1e-3, 0.9, "identified"),
        ("mass", 0.1, 1.1, "identified"),  # it matters: known roughly
        ("force", 1e-3, 1.1, "identified"),  # known to be small
    ],
)
def test_a_parameter_of_small_effect_and_wide_interval_is_not_identified(quantity, effect, half_width, status):
    estimate = Estimate("M", "kg", "", 2.0, 0.1, interval=(2.0 - half_width, 2.0 + half_width), effect=effect)
    result = _judged(estimate, SimpleNamespace(quantity=quantity), "translational")
    assert result.status == status
    assert (result.reason.code if result.reason else None) == ("small_effect" if status == "unidentifiable" else None)


NEAR = (12.4, 12.8), (11.0, 11.6), (11.9, 12.1), (12.5, 12.8), (11.0, 11.5)
STAGES = Diagnostic("stages_differ", "M", "warning", {"first": 12.0, "value": 12.0})


@pytest.mark.parametrize(
    ("name", "ends", "first", "interval", "warning"),  # of replicates; of the first stage; of the estimate
    [
        ("M", (12.6, 12.8), (12.0, 0.5), (11.5, 12.8), STAGES),
        ("M", (11.0, 11.4), (12.0, 0.5), (11.0, 12.5), STAGES),
        # What was fitted lies in its interval.
        *(("M", ends, (12.0, 0.5), (min(ends[0], 12.0), max(ends[1], 12.0)), None) for ends in NEAR),
        *(
            (name, (12.6, 12.8), first, (12.0, 12.8), None)
            for name, first in (("F_C", (12.0, 0.5)), ("M", (12.0, None)), ("M", (None, 0.5)))
        ),
        ("M", (12.6, 12.6), (12.0, 0.5), None, None),  # all replicates on the edge
        ("F_v", (12.6, 12.8), (12.0, 0.5), None, None),  # not fitted to replicates
    ],
)
def test_the_interval_of_an_inertia_includes_that_of_the_first_stage_if_disjoint(name, ends, first, interval, warning):
    replicates = SimpleNamespace(reported=("M", "F_C"), interval=lambda name: ends)
    dataset = SimpleNamespace(alignment=Alignment(mass=first[0], mass_half_width=first[1]), kind="translational")
    problem = SimpleNamespace(dataset=dataset, parameters=SimpleNamespace(plant=SimpleNamespace(variables=inertia.variables)))
    estimate, told = _with_interval(Estimate(name, "kg", "", 12.0, 0.1), replicates, problem)
    assert estimate.interval == interval
    assert (told and replace(told, kind=STAGES.kind)) == warning


@pytest.mark.parametrize(("size", "factor"), [(0.5, 1.0), (3.0, 1.5)])
def test_bands_grow_until_they_contain_19_of_20_held_out_rows(monkeypatch, size, factor):
    problem, solution = fitted({"a": 2.0}, WALSH[:1], size)
    outside = np.arange(COUNT) < 160
    folds = [
        Fold(outside, ~outside, outside),
        Fold(outside, ~outside, np.zeros(COUNT, dtype=bool)),
        Fold(~outside, np.zeros(COUNT, dtype=bool), outside),
    ]
    problem.folds = lambda count: ("time blocks", folds)
    problem.effort_residual = lambda free, residual: residual
    monkeypatch.setattr(uncertainty, "half_width", lambda *_: np.full(COUNT, 2.0))
    fit, estimation = SimpleNamespace(plant=None, friction=None), SimpleNamespace(resampled=(problem, solution))
    assert _inflation(None, fit, estimation, linear=True) == pytest.approx(factor)


@pytest.mark.parametrize(("is_effort", "unexplained"), [(True, 0.3), (False, 0.0)])
def test_bands_contain_the_draws_the_disturbance_and_the_unexplained_effort(is_effort, unexplained):
    problem = SimpleNamespace(is_effort=is_effort, row_time=0.01, parameters=SimpleNamespace(loop={"lag": None}))
    replicates = SimpleNamespace(
        members=[{"F_C": 1.0, "lag": 2.0}, {"F_C": 3.0, "lag": 4.0}],
        unexplained=0.3,
        residual=np.full(COUNT, 0.3),
        disturbance=Disturbance(0.0, 0.2, 1e-6, 1e-7),
        scatter=SimpleNamespace(value=0.0),
    )
    bands = _bands(replicates, SimpleNamespace(resampled=(problem, None), finished=dict))
    assert {name: draws.tolist() for name, draws in bands.draws.items()} == {"F_C": [1.0, 3.0]}
    assert (bands.scatter, bands.noise, bands.unexplained) == (0.0, 0.2, unexplained)
    assert (bands.left_in_closed_loop, bands.left_in_open_loop) == (1e-7, 1e-7)
    assert bands.lasting == pytest.approx(0.01 * COUNT / 40 if is_effort else 0.0)


class AskedError(Exception):
    """What a bootstrap is asked for."""


@pytest.mark.parametrize(
    ("structure", "scale"), [(None, 1.0), ((3.0, 4.0), 1.25), ((0.0, 4.0), 1.0), ((10.0, 4.0), 2.0), ((1.0, 0.0), 2.0)]
)
def test_errors_of_replicates_grow_by_a_missing_force_and_a_doubtful_treatment(monkeypatch, structure, scale):
    problem, solution = fitted({"F_C": 2.0, "sigma_0": 3.0}, WALSH[:2], 0.5)
    problem.parameters.variables, problem.refits_linearly = lugre.variables, lambda friction: True
    asked = []

    def bootstrap(problem, solution, draws, **requested):
        asked.append(requested | {"draws": draws})
        raise AskedError

    monkeypatch.setattr(uncertainty, "bootstrap", bootstrap)
    about = [Diagnostic("structure", numbers={"missing": structure[0], "chance": structure[1]})] if structure else []
    for doubts, wide in (([], None), ([Diagnostic("delay_rough")], [1.0, 2.5])):
        fit = SimpleNamespace(estimates=[], diagnostics=[*about, *doubts], friction=None)
        with pytest.raises(AskedError):
            uncertainty.with_uncertainty(fit, SimpleNamespace(resampled=(problem, solution)), 7, DEFAULT)
        requested = asked[-1]
        assert (requested["draws"], requested["linear"], requested["scale"]) == (7, True, pytest.approx(scale))
        assert (None if requested["wide"] is None else requested["wide"].tolist()) == wide
