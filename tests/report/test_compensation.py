"""What is said of the gain of compensation, from loops whose errors are known."""

from dataclasses import replace

import numpy as np
import pytest

from bristle import controllers, friction, plants
from bristle.core import Status
from bristle.report.compensation import gain_of, pair_of
from bristle.simulation import compensation_experiment, simulate, statistics_of


def with_error(result, name, error):
    """The result with a following error of our own in one variant."""
    item = result.variants[name]
    values = np.asarray(error(item), dtype=float)
    changed = replace(item, measured=item.reference - values, following_error=statistics_of(values))
    return replace(result, variants={**result.variants, name: changed})


def velocity_of(item):
    return np.gradient(item.reference, item.time[1] - item.time[0])


def test_the_pair_differs_in_nothing_but_the_friction(stage):
    plain, compensated = pair_of(stage.looped.experiment)
    assert (plain.name, compensated.name) == ("feedforward", "compensated")


def test_there_is_no_gain_without_a_compensated_variant(stage):
    experiment = replace(stage.looped.experiment, variants=stage.looped.experiment.variants[:2])
    assert gain_of(replace(stage.looped, experiment=experiment)) is None


@pytest.mark.parametrize(("after", "said"), [(0.5, "lowers"), (0.98, "hardly changes"), (1.02, "hardly changes"), (1.5, "raises")])
def test_the_words_follow_the_numbers(stage, after, said):
    wave = np.sin(40.0 * stage.looped.variants["feedforward"].time)
    result = with_error(stage.looped, "feedforward", lambda _: 1e-5 * wave)
    result = with_error(result, "compensated", lambda _: 1e-5 * after * wave)
    sentence = gain_of(result).sentences()[0]
    assert said in sentence
    assert ("do not use" in sentence) == (said == "raises")
    assert ("by a factor of 2.0" in sentence) == (after == 0.5)


def test_an_error_in_proportion_to_velocity_is_called_lag(stage):
    for name in ("feedforward", "compensated"):
        result = with_error(stage.looped, name, lambda item: 2.5e-3 * velocity_of(item))
    step = gain_of(result).steps[-1]
    assert step.lag == pytest.approx(2.5e-3)
    assert step.lag_share == pytest.approx(1.0)
    assert step.beyond_lag == pytest.approx(0.0, abs=1e-12)
    assert "a lag of 2.5 ms" in " ".join(gain_of(result).sentences())


def test_an_error_of_friction_alone_is_not_called_lag(stage):
    noise = np.random.default_rng(0).normal(size=stage.looped.variants["compensated"].time.size)
    result = with_error(stage.looped, "compensated", lambda _: 1e-6 * noise)
    assert not any("lag of" in sentence for sentence in gain_of(result).sentences())


def test_a_loop_that_diverged_promises_nothing(stage):
    changed = replace(stage.looped.variants["compensated"], status=Status.NOT_FINITE)
    result = replace(stage.looped, variants={**stage.looped.variants, "compensated": changed})
    gain = gain_of(result)
    assert gain.steps == ()
    assert "nothing can be said" in gain.sentences()[0]


def test_the_caveat_says_what_the_simulation_leaves_out(stage):
    def caveat(**changes):
        experiment = stage.looped.experiment
        variants = tuple(replace(variant, **changes) for variant in experiment.variants)
        return gain_of(replace(stage.looped, experiment=replace(experiment, variants=variants))).caveat

    known = stage.looped.experiment.variants[-1].feedforward.friction
    assert "most to be hoped for" in caveat(friction=known)
    assert "disturbed by what the model does not explain" in caveat(disturbance=np.zeros(6000))
    assert caveat() == "This is a simulation: confirm the gain on the machine."


def test_a_pair_that_differs_in_more_is_not_credited_to_friction(stage):
    experiment = stage.looped.experiment
    two = replace(experiment, variants=(experiment.variants[0], experiment.variants[2]))
    gain = gain_of(replace(stage.looped, experiment=two))
    assert not gain.alone
    assert "differ in more than the friction" in gain.sentences()[0]
    assert gain_of(stage.looped).alone


def test_velocity_that_is_fed_forward_already_is_not_advised(stage):
    result = with_error(stage.looped, "compensated", lambda item: 2.5e-3 * velocity_of(item))
    assert gain_of(result).velocity_fed
    words = " ".join(gain_of(result).sentences())
    assert "velocity fed forward removes" not in words
    assert "viscous friction of the compensator, F_v" in words


def test_viscous_friction_that_is_not_fed_forward_is_not_called_the_position_loop(stage):
    """The loop feeds velocity forward and Coulomb friction alone: what is left is viscous friction."""
    film = friction.coulomb_viscous(F_C=8.0, F_v=200.0)
    law = controllers.cascade(k_p=80.0, k_v=3000.0)
    experiment = compensation_experiment(plants.inertia(M=12.0), film, friction.coulomb(F_C=8.0), law, stage.log.reference.values, 1e-3)
    gain = gain_of(simulate(experiment))
    assert gain.steps[-1].lag_share > 0.9
    words = " ".join(gain.sentences())
    assert "viscous friction that is not fed forward" in words
    assert "is not friction" not in words
