import numpy as np
import pytest
from tests.identification.known_logs import STATED, log_of, sines, sliding_effort, sliding_log
from tests.identification.rigid import identify

from bristle.core import InputError
from bristle.report.messages import warnings_of


def asymmetric_log():
    motion = sines()
    forward, backward = sliding_effort(motion, F_C=9.0), sliding_effort(motion, F_C=6.0, F_v=45.0)
    return log_of(motion, np.where(motion.velocity > 0.0, forward, backward))


@pytest.mark.parametrize("order", [1, -1])
def test_the_model_with_the_structure_of_the_truth_wins_in_any_requested_order(order):
    names = ["coulomb", "viscous", "coulomb_viscous", "coulomb_viscous+asymmetry"][::order]
    result = identify(asymmetric_log(), names, axis=STATED, draws=0)
    assert [(fit.rank, fit.name) for fit in result.fits][:2] == [(1, "coulomb_viscous+asymmetry"), (2, "coulomb_viscous")]
    errors = [fit.held_out.mean_percent for fit in result.fits]
    assert errors == sorted(errors)
    assert errors[0] < 0.5 * errors[1]


def test_a_block_is_not_fitted_by_the_parameters_that_predict_it():
    motion = sines()
    effort = sliding_effort(motion)
    last = motion.time >= 8.0
    strange = np.where(last, effort + 4.0 * np.sign(motion.velocity), effort)
    held_out, plain = (
        identify(log_of(motion, item), "coulomb_viscous", axis=STATED, draws=0).best.held_out.block_errors_percent
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
        identify(log_of(motion, item), "coulomb_viscous", axis=STATED, cutoff=20.0, blocks=2, draws=0).best.held_out.block_errors_percent
        for item in (effort + push, effort)
    )
    # The other half, whose part it is, is predicted badly; this one as if there had been no push.
    assert pushed[1 - block] > 50.0
    assert pushed[block] < 2.0 * plain[block]


def test_mean_and_spread_are_those_of_the_blocks():
    held_out = identify(sliding_log(), "coulomb_viscous", axis=STATED, blocks=4, draws=0).best.held_out
    errors = held_out.block_errors_percent
    assert len(errors) == 4
    assert (held_out.mean_percent, held_out.std_percent) == (pytest.approx(np.mean(errors)), pytest.approx(np.std(errors, ddof=1)))


def test_without_blocks_models_rank_by_their_error():
    best = identify(asymmetric_log(), "coulomb,coulomb_viscous+asymmetry", axis=STATED, blocks=0, draws=0).best
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
