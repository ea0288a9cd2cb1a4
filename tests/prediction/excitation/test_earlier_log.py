"""An earlier log of the axis in place of an earlier model."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from tests.prediction.excitation.axes import STAGE

from bristle.core import InputError
from bristle.models.friction import dahl, lugre
from bristle.models.plants import inertia
from bristle.prediction.excitation import excite
from bristle.prediction.excitation.excite import Excitation, _in_time
from bristle.prediction.excitation.limits import prior_of
from bristle.prediction.excitation.rehearsal import recorded

TRUTH = lugre(F_C=60.0, F_S=60.0, v_S=2e-3, sigma_0=1.2e7, sigma_1=4e3, sigma_2=0.0)
KNOWN = replace(STAGE, resolution=1e-8, decimation=10)
UNKNOWN = replace(KNOWN, mass=None, presliding=None)


def log_of(**options):
    """Return a log of the true axis."""
    motion = excite(KNOWN, model=TRUTH, rehearsed=False, **options).motion
    return recorded(motion, KNOWN, prior_of(KNOWN, None, TRUTH))[0]


@pytest.fixture(scope="module")
def log():
    """A log of loops and of slides."""
    return log_of(duration="24 s", purposes="presliding,stribeck")


@pytest.fixture(scope="module")
def result(log):
    return excite(UNKNOWN, log=log, rehearsed=False)


def test_a_log_gives_mass_friction_level_and_presliding_distance(result):
    bare = excite(UNKNOWN, rehearsed=False)
    assert {piece.purpose for piece in bare.motion.pieces} == {"stribeck"}
    assert {"presliding", "stribeck"} <= {piece.purpose for piece in result.motion.pieces}
    assert result.prior.plant.values["M"] == pytest.approx(28.0, rel=0.05)
    assert result.prior.friction.values["F_C"] == pytest.approx(60.0, rel=0.1)
    assert result.prior.presliding == pytest.approx(
        prior_of(KNOWN, None, TRUTH).presliding, rel=0.5
    )
    assert result.prior.mass_known
    assert result.prior.assumed == ()


def test_a_log_acts_as_the_model_that_it_gives(result):
    by_model = excite(UNKNOWN, model=(result.prior.plant, result.prior.friction), rehearsed=False)
    assert result.prior.friction.name == "dahl"
    assert np.array_equal(result.motion.position, by_model.motion.position)


@pytest.mark.parametrize(
    ("reach", "seconds", "fastest", "is_repeat", "told"),
    [
        (
            0.2,
            40.0,
            0.1,
            False,
            "raise limits.velocity to 222 mm/s, limits.stroke to a range of 222 mm",
        ),
        (0.2, 40.0, 0.1, True, "raise --duration to 160 s, which halves"),
        (0.05, 20.0, 0.1, False, "raise --duration to 44.4 s"),
        (0.05, 40.0, 0.1, False, "raise --duration to 160 s, which halves"),
        # A limit to write comes before a longer motion.
        (0.05, 20.0, None, False, "the motion begins in the middle"),
    ],
)
def test_a_motion_that_is_worse_than_the_log_names_the_limits_below_it(
    monkeypatch, reach, seconds, fastest, is_repeat, told
):
    log = SimpleNamespace(position=SimpleNamespace(values=np.array([0.0, reach])), duration=40.0)
    traces = SimpleNamespace(velocity=np.array([reach]), acceleration=np.zeros(1))
    best = SimpleNamespace(
        plant=inertia(M=30.0), friction=TRUTH, inertia=SimpleNamespace(status="held"), traces=traces
    )
    monkeypatch.setitem(
        _in_time.__globals__, "identify", lambda *asked, **how: SimpleNamespace(best=best, log=log)
    )
    monkeypatch.setattr(Excitation, "is_worse", True)
    monkeypatch.setattr(Excitation, "is_repeat", is_repeat)
    axis = replace(STAGE, velocity_limit=fastest, stroke=(0.0, 0.1))
    assert (
        told
        in excite(
            axis, log="any.csv", duration=seconds, purposes="presliding", rehearsed=False
        ).notes[-1]
    )


@pytest.mark.parametrize(
    ("status", "known"), [("identified", True), ("held", True), ("unidentifiable", False)]
)
def test_a_mass_that_the_log_does_not_give_is_that_of_the_limits(monkeypatch, status, known):
    friction = dahl(F_C=60.0, sigma_0=1e7)
    best = SimpleNamespace(
        plant=inertia(M=30.0), friction=friction, inertia=SimpleNamespace(status=status)
    )
    monkeypatch.setitem(
        _in_time.__globals__, "identify", lambda log, *asked, **how: SimpleNamespace(best=best)
    )
    prior = excite(UNKNOWN, log="any.csv", rehearsed=False).prior
    of_limits = prior_of(UNKNOWN).plant.values["M"]
    assert (prior.mass_known, prior.plant.values["M"]) == (
        known,
        pytest.approx(30.0 if known else of_limits),
    )


@pytest.mark.slow
def test_a_log_without_acceleration_leaves_the_mass_to_the_limits():
    slow = log_of(duration="16 s", purposes="presliding")
    result = excite(UNKNOWN, log=slow, rehearsed=False)
    assert not result.prior.mass_known
    assert result.prior.plant.values["M"] == pytest.approx(prior_of(UNKNOWN).plant.values["M"])
    assert result.prior.assumed[0].startswith("mass of")


def test_a_log_and_a_model_are_refused_together():
    with pytest.raises(
        InputError, match=r"^log: cannot be combined with model\. Leave out log or model"
    ):
        excite(UNKNOWN, log="any.csv", model=TRUTH, rehearsed=False)
