"""A model that fails does not cost the results of the others: it is omitted with its reason."""

import numpy as np
import pytest
from tests.identification.known_logs import STATED, log_of, sines, sliding_effort
from tests.identification.rigid import IDENTIFYING, identify

from bristle.core import InputError
from bristle.identification import intervals

MODELS = "coulomb_viscous,viscous,coulomb"
ERRORS = [
    FloatingPointError("overflow"),
    np.linalg.LinAlgError("singular"),
    InputError("diverges", path="model"),
    InputError("empty", path="F_C"),
]


@pytest.fixture(scope="module")
def log():
    return log_of(sines(2.0), sliding_effort(sines(2.0)))


@pytest.fixture(scope="module")
def ranked(log):
    return [fit.name for fit in identify(log, MODELS, axis=STATED, blocks=2, draws=0).fits]


def failing_for(name, original, error):
    """The function, with an error if one of its arguments has this name."""

    def computed(*arguments):
        if any(getattr(argument, "name", "") == name for argument in arguments):
            raise error
        return original(*arguments)

    return computed


@pytest.mark.parametrize("error", ERRORS, ids=repr)
def test_a_model_whose_fit_fails_is_omitted(log, monkeypatch, error):
    monkeypatch.setattr(IDENTIFYING, "fit", failing_for("coulomb_viscous", IDENTIFYING.fit, error))
    result = identify(log, MODELS, axis=STATED, blocks=2, draws=0)
    assert {fit.name for fit in result.fits} == {"viscous", "coulomb"}
    assert result.left_out == {"coulomb_viscous": getattr(error, "message", str(error))}
    with pytest.raises(type(error)):
        identify(log, "coulomb_viscous", axis=STATED, blocks=2, draws=0)


def test_a_fault_of_the_log_is_no_fault_of_a_model(log, monkeypatch):
    error = InputError("has no load", path="log")
    monkeypatch.setattr(IDENTIFYING, "fit", failing_for("coulomb", IDENTIFYING.fit, error))
    with pytest.raises(InputError, match="has no load"):
        identify(log, MODELS, axis=STATED, blocks=2, draws=0)


@pytest.mark.parametrize("error", ERRORS, ids=repr)
def test_a_model_whose_intervals_fail_gives_way_to_the_next(log, ranked, monkeypatch, error):
    (best, second, last), drawn = ranked, []
    monkeypatch.setattr(intervals, "with_uncertainty", failing_for(best, lambda fit, *_: drawn.append(fit.name) or fit, error))
    result = identify(log, MODELS, axis=STATED, blocks=2, draws=20)
    assert [(fit.name, fit.rank) for fit in result.fits] == [(second, 1), (last, 2)]
    assert drawn == [second]
    assert result.unfinished == ""
    assert result.notes[-1].startswith(f"{best} is omitted: its intervals from simulated logs failed: ")
    with pytest.raises(type(error)):
        identify(log, best, axis=STATED, blocks=2, draws=20)
