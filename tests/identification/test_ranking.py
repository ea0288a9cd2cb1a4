"""Comparison of models: held-out errors, information criteria and the order."""

import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from tests.golden.simulated import elements_log
from tests.identification.known_logs import (
    STATED,
    log_of,
    sines,
    sliding_effort,
    sliding_log,
    slow_log,
)
from tests.identification.rigid import identify
from tests.identification.test_elements import KNOWN

from bristle import friction
from bristle.core import InputError
from bristle.files import load_code
from bristle.identification import HeldOut
from bristle.identification.excitation import spread_between_repeats
from bristle.identification.preprocessing import treat_all
from bristle.identification.settings import DEFAULT
from bristle.identification.validation import held_out_error, in_order, ranked, with_information
from bristle.models.friction import find
from bristle.report.messages import warnings_of
from bristle.report.model_tables import comparison_table

BLOCKS = (3.0, 3.4, 2.8, 3.2, 3.1)


@pytest.fixture(scope="module")
def fit():
    return identify(sliding_log(), "coulomb_viscous", draws=0).best


@pytest.fixture
def made(fit):
    """Make a fit with so many parameters, so many of them not identified, and these errors on the blocks."""

    def make(name, errors, parameters, unknown=0, component=None):
        estimates = [
            replace(fit.estimates[0], name=f"p{i}", status="identified") for i in range(parameters)
        ]
        estimates[:unknown] = [
            replace(estimate, status="unidentifiable") for estimate in estimates[:unknown]
        ]
        mean = sum(errors) / len(errors)
        spread = (sum((estimate - mean) ** 2 for estimate in errors) / (len(errors) - 1)) ** 0.5
        return replace(
            fit,
            friction=SimpleNamespace(name=name, component=component or fit.friction.component),
            estimates=tuple(estimates),
            correlation_names=tuple(estimate.name for estimate in estimates),
            held_out=HeldOut(tuple(errors), mean, spread),
        )

    return make


def order(*fits, spread=0.0):
    names = [item.name for item in ranked(fits, spread=spread)]
    assert [item.name for item in ranked(fits[::-1], spread=spread)] == names
    return names


@pytest.mark.parametrize(
    # By how much the simple model is worse on each block; parameters of the rich one, unidentified ones.
    ("worse", "rich", "first"),
    [
        pytest.param((0.1,) * 5, (6, 0), "rich", id="every block agrees"),
        # The simple model is worse by 0.06 on average, and by 0.06 +- 0.18 as far as five blocks tell.
        pytest.param((0.4, -0.3, 0.5, -0.4, 0.1), (6, 0), "simple", id="blocks disagree"),
        pytest.param((0.1,) * 5, (10, 5), "simple", id="half of the parameters are not identified"),
        pytest.param(
            (0.1,) * 5, (10, 4), "rich", id="more than half of the parameters are identified"
        ),
        pytest.param((2.0,) * 5, (10, 5), "rich", id="half unidentified, and far better"),
        pytest.param((1e-7,) * 5, (4, 0), "simple", id="errors equal up to rounding"),
    ],
)
def test_the_simpler_model_leads_unless_the_richer_one_predicts_better(made, worse, rich, first):
    simple = made(
        "simple", [block + change for block, change in zip(BLOCKS, worse, strict=True)], 3
    )
    assert order(simple, made("rich", BLOCKS, *rich))[0] == first


def test_after_the_chosen_model_the_order_is_that_of_the_error(made):
    better = made("better", BLOCKS, 6)
    others = [
        made(f"p{size}", [block + 0.5 - 0.1 * size for block in BLOCKS], size) for size in (2, 3, 4)
    ]
    assert order(better, *others) == ["better", "p4", "p3", "p2"]


def test_without_blocks_the_error_of_the_fit_decides(fit):
    worse = replace(
        fit, held_out=None, force_error_percent=2.0, friction=SimpleNamespace(name="worse")
    )
    better = replace(
        fit, held_out=None, force_error_percent=1.9, friction=SimpleNamespace(name="better")
    )
    assert order(worse, better) == ["better", "worse"]


def test_of_perfect_fits_the_simpler_one_wins(made):
    assert order(made("simple", (0.0,) * 5, 3), made("rich", (0.0,) * 5, 6)) == ["simple", "rich"]


def test_an_error_at_the_edge_of_the_spread_counts_as_within(made):
    leader = made("rich", (2.0, 4.0), 10, unknown=5)
    leader = replace(leader, held_out=HeldOut((2.0, 4.0), 3.0, 1.0))
    assert order(made("simple", (3.0, 5.0), 3), leader) == ["simple", "rich"]


def test_a_slot_over_the_position_needs_a_gain_above_the_spread_of_one_motion(made):
    plain = made("plain", [block + 0.5 for block in BLOCKS], 3)
    by_place = made("by place", BLOCKS, 6, component=find("coulomb_viscous+periodic"))
    by_direction = made("by direction", BLOCKS, 6, component=find("coulomb_viscous+asymmetry"))
    assert order(plain, by_place) == ["by place", "plain"]
    assert order(plain, by_place, spread=0.6) == ["plain", "by place"]
    assert order(plain, by_place, spread=0.4) == ["by place", "plain"]
    # What knows no place does not follow what comes back there.
    assert order(plain, by_direction, spread=0.6) == ["by direction", "plain"]


def test_a_half_unidentified_leader_over_the_position_leads_in_an_aperiodic_log(made):
    larger = made("larger", [block + 0.1 for block in BLOCKS], 12)
    by_place = made("by place", BLOCKS, 6, unknown=3, component=find("coulomb_viscous+periodic"))
    assert order(larger, by_place) == ["by place", "larger"]
    assert order(larger, by_place, spread=0.2) == ["larger", "by place"]


def test_the_spread_is_that_of_the_effort_between_repeats():
    motion = sines(12.0, amplitudes=(0.02,), frequencies=(0.5,), phases=(0.0,))
    effort = sliding_effort(motion, noise=0.0)
    second = (motion.time // 2.0) % 2.0 == 1.0
    spreads = []
    for share in (0.0, 0.05):
        dataset = treat_all(
            [log_of(motion, effort * np.where(second, 1.0 + share, 1.0))], [None], 50.0, 10
        )
        spreads.append(spread_between_repeats(dataset))
    assert spreads[0] < 1.0
    assert spreads[1] == pytest.approx(5.0, rel=0.1)
    aperiodic = sliding_log()
    for logs in ([aperiodic], [log_of(motion, effort), aperiodic]):
        assert spread_between_repeats(treat_all(logs, [None] * len(logs), 50.0, 10)) == 0.0


def test_an_interrupted_fit_leads_if_its_error_is_far_below_the_best(made, fit):
    # 3.1 % of the blocks
    finished, second = (
        made("finished", BLOCKS, 3),
        made("second", [2.0 * block for block in BLOCKS], 3),
    )
    for percent, names in (
        (2.1, ["part", "finished", "second"]),
        (2.2, ["finished", "second", "part"]),
    ):
        part = replace(
            fit,
            held_out=None,
            force_error_percent=percent,
            unfinished=True,
            friction=SimpleNamespace(name="part"),
        )
        assert [item.name for item in in_order([second, part, finished])] == names
        assert [item.name for item in in_order([part])] == ["part"]


def test_criteria_use_the_squares_of_rows_or_of_the_simulated_signal(made):
    noise = np.random.default_rng(3).standard_normal(2000)

    def fit_of(size, parameters, **changes):
        item = made("made", BLOCKS, parameters)
        traces = replace(item.traces, measured=size * noise, predicted=0.0 * noise)
        return replace(item, traces=traces, information=None, **changes)

    def criteria(*fits):
        return [item.information for item in with_information(fits)]

    small, large = criteria(fit_of(1.2, 3), fit_of(1.0, 5))
    count = small.measurements
    assert count == large.measurements == pytest.approx(2000, rel=0.1)
    assert (large.aic, large.bic) == (0.0, 0.0)
    assert small.aic == pytest.approx(count * np.log(1.44) - 2.0 * 2)
    assert small.bic == pytest.approx(count * np.log(1.44) - np.log(count) * 2)
    for name in ("position_rmse", "loop_rmse"):
        small, large = criteria(fit_of(9.0, 3, **{name: 1.2}), fit_of(7.0, 3, **{name: 1.0}))
        assert small.aic == pytest.approx(small.measurements * np.log(1.44))
        assert large.aic == 0.0
    assert criteria(fit_of(0.0, 3), fit_of(1.0, 3)) == [None, None]
    assert with_information([]) == []


def test_held_out_errors_are_relative_to_the_signal_of_each_part():
    measured = np.array([3.0, 4.0, 6.0, 8.0])
    folds = [
        SimpleNamespace(held_out=np.arange(4) // 2 == number, fitted=np.arange(4) // 2 != number)
        for number in range(2)
    ]
    problem = SimpleNamespace(
        folds=lambda blocks, settings: ("time blocks", folds), measured=measured
    )
    estimation = SimpleNamespace(
        problem=problem, residual_without=lambda rows: np.where(rows, 9.0, [0.3, 0.4, 1.2, 1.6])
    )
    shares = []
    held_out = held_out_error(estimation, 2, DEFAULT, shares.append)
    assert held_out.block_errors_percent == pytest.approx((10.0, 20.0))
    assert (held_out.mean_percent, held_out.std_percent) == pytest.approx((15.0, 50.0**0.5))
    assert shares == [0.0, 0.5]


def asymmetric_log():
    motion = sines()
    forward, backward = sliding_effort(motion, F_C=9.0), sliding_effort(motion, F_C=6.0, F_v=45.0)
    return log_of(motion, np.where(motion.velocity > 0.0, forward, backward))


@pytest.mark.parametrize("order", [1, -1])
def test_the_model_with_the_structure_of_the_truth_wins_in_any_requested_order(order):
    names = ["coulomb", "viscous", "coulomb_viscous", "coulomb_viscous+asymmetry"][::order]
    result = identify(asymmetric_log(), names, axis=STATED, draws=0)
    assert [(fit.rank, fit.name) for fit in result.fits][:2] == [
        (1, "coulomb_viscous+asymmetry"),
        (2, "coulomb_viscous"),
    ]
    errors = [fit.held_out.mean_percent for fit in result.fits]
    assert errors == sorted(errors)
    assert errors[0] < 0.5 * errors[1]


def test_a_block_is_not_fitted_by_the_parameters_that_predict_it():
    motion = sines()
    effort = sliding_effort(motion)
    last = motion.time >= 8.0
    strange = np.where(last, effort + 4.0 * np.sign(motion.velocity), effort)
    held_out, plain = (
        identify(
            log_of(motion, item),
            "coulomb_viscous",
            axis=STATED,
            draws=0,
            settings={"lines_gain": 1.0},
        ).best.held_out.block_errors_percent
        for item in (strange, effort)
    )
    # The last block alone has friction of its own: nothing fitted to the others knows of it.
    assert held_out[-1] > 10.0 * plain[-1]
    assert np.argmax(held_out) == 4


@pytest.mark.parametrize(("block", "beside"), [(1, -0.1), (0, 0.1)])
def test_rows_smeared_into_a_block_by_a_filter_are_not_fitted(block, beside):
    motion = sines(4.0)
    effort = sliding_effort(motion)
    # A push of 40 ms, two periods of the cut-off before or after the block.
    push = 100.0 * (np.abs(motion.time - (2.0 + beside)) < 0.02)
    pushed, plain = (
        identify(
            log_of(motion, item), "coulomb_viscous", axis=STATED, cutoff=20.0, blocks=2, draws=0
        ).best.held_out.block_errors_percent
        for item in (effort + push, effort)
    )
    # The other half, whose part it is, is predicted badly; this one as if there had been no push.
    assert pushed[1 - block] > 50.0
    assert pushed[block] < 2.0 * plain[block]


def test_without_blocks_models_rank_by_their_error():
    best = identify(
        asymmetric_log(), "coulomb,coulomb_viscous+asymmetry", axis=STATED, blocks=0, draws=0
    ).best
    assert (best.name, best.held_out) == ("coulomb_viscous+asymmetry", None)
    assert "held_out_error_percent" not in best.metrics


def test_a_short_log_has_as_many_blocks_as_fit():
    log = log_of(sines(1.5), sliding_effort(sines(1.5)))
    identification = identify(log, "coulomb_viscous,coulomb", axis=STATED, draws=0)
    assert len(identification.best.held_out.block_errors_percent) == 3
    with pytest.raises(InputError, match="too many for this log; found 5, allowed 2 to 3"):
        identify(log, "coulomb_viscous", axis=STATED, blocks=5, draws=0)


def test_a_log_without_room_for_two_blocks_has_a_warning():
    log = log_of(sines(0.7), sliding_effort(sines(0.7)))
    best = identify(log, "coulomb_viscous,coulomb", axis=STATED, draws=0).best
    assert (best.name, best.held_out) == ("coulomb_viscous", None)
    assert warnings_of(best)[0].startswith("the log is too short for held-out stretches")


@pytest.fixture(scope="module")
def compared():
    motion = sines(6.0)
    identification = identify(
        log_of(motion, sliding_effort(motion)),
        "viscous,coulomb_viscous,coulomb_viscous+asymmetry",
        axis=STATED,
        draws=0,
        blocks=0,
    )
    return {fit.name: fit for fit in identification.fits}


def test_the_truth_costs_least(compared):
    bic = {name: fit.information.bic for name, fit in compared.items()}
    assert min(bic, key=bic.get) == "coulomb_viscous"
    assert bic["viscous"] > 100.0
    assert bic["coulomb_viscous+asymmetry"] > 0.0


def test_each_criterion_is_the_difference_from_its_smallest_value(compared):
    assert [
        min(getattr(fit.information, criterion) for fit in compared.values())
        for criterion in ("aic", "bic")
    ] == [0.0, 0.0]


def price_between(item, other):
    """How many parameters one fit has more than another, from the prices of both criteria."""
    aic, bic = (
        getattr(other.information, name) - getattr(item.information, name)
        for name in ("aic", "bic")
    )
    return (bic - aic) / (np.log(item.information.measurements) - 2.0)


def test_both_criteria_differ_by_the_price_of_a_parameter(compared):
    item, other = compared["coulomb_viscous"], compared["coulomb_viscous+asymmetry"]
    assert price_between(item, other) == pytest.approx(
        len(other.correlation_names) - len(item.correlation_names)
    )
    assert item.information.measurements <= item.traces.time.size
    assert {"aic", "bic"} <= set(item.metrics)


def test_each_element_that_slips_has_its_price():
    identification = identify(
        elements_log(duration=6.0), "dahl,maxwell_slip", axis=KNOWN, draws=0, blocks=0
    )
    fits = {fit.name: fit for fit in identification.fits}
    item, other = fits["dahl"], fits["maxwell_slip"]
    elements = len(other.friction.values["k_i"])
    assert elements >= 3
    # Stiffness of each element, viscous friction and offset.
    assert price_between(item, other) == pytest.approx(elements + 2 - len(item.correlation_names))
    assert (
        int({row[0]: row[2] for row in comparison_table(identification).rows}["maxwell_slip"])
        == elements + 2
    )


@pytest.mark.slow
def test_a_model_that_ignores_its_parameters_identifies_none_of_them(tmp_path):
    text = (Path(__file__).parents[2] / "examples" / "quadratic_drag.py").read_text()
    (tmp_path / "own.py").write_text(re.sub(r"    return p\.F_C.*", "    return 5.0, Move()", text))
    log = slow_log(friction.coulomb_viscous(F_C=8.0, F_v=30.0), duration=10.0)
    identification = identify(
        log, load_code(tmp_path / "own.py"), axis=STATED, mass=28.0, offset=0.0, draws=0, blocks=0
    )
    assert identification.best.parameters["F_C"].status == "unidentifiable"
