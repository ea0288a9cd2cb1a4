"""Ctrl-C or a model that fails leaves the other results; what is missing is named."""

import json
import signal
from itertools import chain, repeat
from unittest.mock import DEFAULT, Mock

import numpy as np
import pytest
from tests.identification.known_logs import STATED, log_of, sines, sliding_effort, slow_log
from tests.identification.rigid import IDENTIFYING, identify

from bristle import friction
from bristle.cli.signals import SignalledError
from bristle.core import InputError
from bristle.identification import fits, fitting, intervals
from bristle.identification.inverse_dynamics import InverseDynamics
from bristle.report.brief import first_answer
from bristle.report.messages import warnings_of

TRUTH = friction.lugre(sigma_0=1e5, sigma_1=200.0, F_C=8.0, F_S=10.0, v_S=2e-3, sigma_2=30.0)


@pytest.fixture(autouse=True)
def handled():
    """Handle Ctrl-C where the tests run in the background, which ignores it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture(scope="module")
def log():
    return slow_log(TRUTH, duration=8.0)


@pytest.fixture(scope="module")
def sliding():
    return log_of(sines(2.0), sliding_effort(sines(2.0)))


@pytest.fixture
def interrupted_after(monkeypatch):
    """Raise an interruption at a residual, counted from when a search of a model with more parameters begins."""

    def arrange(count, number=signal.SIGINT):
        calls = iter(range(1, 1_000_000))

        def counted(original):
            def counting(self, free):
                if next(calls) == count:
                    signal.raise_signal(number)
                return original(self, free)

            return counting

        for name in ("residual", "linearised"):
            monkeypatch.setattr(InverseDynamics, name, counted(getattr(InverseDynamics, name)))

    return arrange


@pytest.mark.slow
def test_the_best_result_so_far_is_returned_and_marked(log, interrupted_after):
    whole = identify(log, "lugre", axis=STATED, blocks=0)
    interrupted_after(30)
    part = identify(log, "lugre", axis=STATED, blocks=0)
    assert (part.best.unfinished, whole.best.unfinished) == (True, False)
    assert (part.unfinished, whole.unfinished) == (
        "interrupted: 0 of 1 models fitted; the fit of lugre is incomplete",
        "",
    )
    assert warnings_of(part.best)[0].startswith("unfinished: ")
    # Not yet the end, but better than any start alone.
    assert whole.best.force_error_percent <= part.best.force_error_percent < 60.0
    assert np.isfinite(part.best.parameters["M"].std)


@pytest.mark.slow
def test_finished_models_come_first_and_missing_models_are_named(interrupted_after):
    interrupted_after(35)
    identification = identify(
        log_of(sines(), sliding_effort(sines())),
        "lugre,coulomb_viscous,dahl",
        axis=STATED,
        blocks=2,
    )
    assert [(fit.name, fit.unfinished) for fit in identification.fits] == [
        ("coulomb_viscous", False),
        ("dahl", True),
    ]
    assert (
        identification.unfinished
        == "interrupted: 1 of 3 models fitted; the fit of dahl is incomplete; lugre was not fitted"
    )


def test_elements_are_kept_if_validation_is_interrupted(log, monkeypatch):
    monkeypatch.setattr(fitting, "held_out_error", Mock(side_effect=KeyboardInterrupt))
    identification = identify(log, "maxwell_slip,dahl", axis=STATED, blocks=2)
    assert [(fit.name, fit.unfinished, fit.held_out) for fit in identification.fits] == [
        ("maxwell_slip", True, None)
    ]
    assert len(identification.best.friction.values["k_i"]) >= 1
    assert (
        identification.unfinished
        == "interrupted: 0 of 2 models fitted; the fit of maxwell_slip is incomplete; dahl was not fitted"
    )


@pytest.mark.parametrize(
    ("draws", "said"), [(20, "interrupted: intervals from simulated logs are missing"), (0, "")]
)
def test_fits_are_kept_if_ranking_is_interrupted(log, monkeypatch, draws, said):
    ranking = Mock(
        side_effect=chain([KeyboardInterrupt], repeat(DEFAULT)), wraps=IDENTIFYING.with_structure
    )
    monkeypatch.setattr(IDENTIFYING, "with_structure", ranking)
    identification = identify(log, "coulomb_viscous", axis=STATED, blocks=2, draws=draws)
    assert ranking.call_count == 2
    assert (
        identification.best.unfinished,
        identification.best.rank,
        identification.unfinished,
    ) == (False, 1, said)


@pytest.fixture
def two_in_all(monkeypatch):
    """All models are two."""
    monkeypatch.setattr(
        IDENTIFYING.request,
        "models_of",
        lambda names, **options: (friction.find("coulomb"), friction.find("viscous")),
    )


@pytest.mark.usefixtures("two_in_all")
def test_fits_are_kept_if_the_search_for_slots_is_interrupted(log, monkeypatch):
    monkeypatch.setattr(fits, "next_models", Mock(side_effect=KeyboardInterrupt))
    identification = identify(log, "all", axis=STATED, blocks=2, draws=20)
    assert {fit.name for fit in identification.fits} == {"coulomb", "viscous"}
    assert (
        identification.unfinished
        == "interrupted: 2 of 2 models fitted; the search for models with slots is incomplete"
    )


@pytest.mark.usefixtures("two_in_all")
def test_slots_are_not_sought_after_an_interruption(log, monkeypatch):
    monkeypatch.setattr(
        fits, "fit", Mock(side_effect=chain([DEFAULT], repeat(KeyboardInterrupt)), wraps=fits.fit)
    )
    monkeypatch.setattr(fits, "next_models", Mock(side_effect=AssertionError))
    assert (
        identify(log, "all", axis=STATED, blocks=2).unfinished
        == "interrupted: 1 of 2 models fitted; viscous was not fitted"
    )


def test_an_interruption_before_the_first_result_is_raised(log, interrupted_after):
    interrupted_after(1)
    with pytest.raises(KeyboardInterrupt):
        identify(log, "lugre", axis=STATED, blocks=0)


def test_an_unfinished_identification_cannot_be_used_further(log, interrupted_after):
    identification = identify(log, "coulomb_viscous", axis=STATED, blocks=0, draws=0)
    assert identification.finished is identification
    interrupted_after(40)
    unfinished = identify(log, "coulomb_viscous,lugre", axis=STATED, blocks=0, draws=0)
    with pytest.raises(KeyboardInterrupt):
        assert unfinished.finished


@pytest.mark.parametrize("draws", [0, 20])
def test_the_remaining_time_is_known_after_the_first_verdict(sliding, draws):
    answers, known = [], set()
    identify(
        sliding,
        "coulomb,viscous,coulomb_viscous",
        axis=STATED,
        blocks=2,
        draws=draws,
        progress=lambda share, text: known.add((len(answers), share > 0.0)),
        answer=answers.append,
    )
    assert known == {(0, False), (1, True)}


@pytest.mark.parametrize(("draws", "is_near"), [(0, True), (20, False)])
def test_the_remaining_time_contains_intervals_if_they_follow(sliding, monkeypatch, draws, is_near):
    shares = []
    monkeypatch.setattr(IDENTIFYING, "durations_of", lambda *arguments: (5e3, 5e3))
    monkeypatch.setattr(IDENTIFYING, "with_intervals", lambda passed, *arguments: (passed, ""))
    models, options = (
        "coulomb,viscous,coulomb_viscous",
        {"axis": STATED, "blocks": 2, "draws": draws},
    )
    identify(sliding, models, **options, progress=lambda share, text: shares.append(share))
    assert (max(shares) > 1e-2) is is_near


@pytest.mark.parametrize(("coupling", "follow"), [(None, True), (Mock(), False)])
def test_observers_take_time_if_they_follow(monkeypatch, coupling, follow):
    monkeypatch.setattr(intervals, "observable", lambda *arguments: True)
    problem = Mock(dataset=Mock(segments=[Mock(time=np.zeros(100))]))
    passed = Mock(fits=[Mock()], context=Mock(coupling=coupling))
    passed.estimations = {passed.fits[0].name: Mock(resampled=(problem, Mock()))}
    drawing, climbing = intervals.durations_of(passed, 100, [(None, None)])
    assert (drawing > 0.0, climbing > 0.0) == (True, follow)


def test_each_fit_that_is_the_best_so_far_is_told(monkeypatch):
    fitted, told = (
        iter([Mock(unfinished=False, error_percent=percent) for percent in (5.0, 7.0, 2.0)]),
        [],
    )
    monkeypatch.setattr(fits, "fit", lambda *arguments: (next(fitted), None))
    models = [friction.find(name) for name in ("viscous", "coulomb", "coulomb_viscous")]
    fits._fits(
        None, models, 0, fits.Work(Mock()), fits.Collected(["several", "models"]), told.append
    )
    assert [fit.error_percent for fit in told] == [5.0, 2.0]


def test_the_time_of_models_to_come_is_in_proportion_to_their_parameters(monkeypatch):
    work, ahead = fits.Work(Mock(), after_fits=10.0, paces=[3.0, 2.0, 2.0, 9.0]), []
    monkeypatch.setattr(
        fits, "fit", lambda *arguments: (Mock(unfinished=False), ahead.append(work.ahead))
    )
    fits._fits(
        None,
        [friction.find("stribeck"), friction.find("coulomb_viscous")],
        0,
        work,
        fits.Collected([]),
        further=5,
    )
    assert (ahead, len(work.paces)) == ([2.0 * (3 + 5) + 10.0, 2.0 * 5 + 10.0], 6)


@pytest.mark.slow
def test_progress_reports_the_best_error_so_far(log):
    message = []
    identify(
        log,
        "lugre",
        axis=STATED,
        blocks=0,
        progress=lambda share, text: message.append((share, text)),
    )
    best = [
        float(text.split("best so far ")[1].split(" %")[0])
        for _, text in message
        if "best so far" in text
    ]
    assert len(best) == 2
    assert best == sorted(best, reverse=True)


@pytest.mark.slow
def test_progress_of_each_model_and_of_simulated_logs_runs_from_start_to_end(sliding):
    told = []
    identify(
        sliding,
        "coulomb_viscous,viscous",
        axis=STATED,
        blocks=0,
        draws=20,
        progress=lambda *message: told.append(message),
    )
    shares = [share for share, _ in told]
    assert (shares[0], shares[-1]) == (0.0, 1.0)
    assert len(set(shares)) > 4
    fitting = [text for _, text in told if "models fitted" in text]
    assert {
        "fitting coulomb_viscous, 0 of 2 models fitted",
        "fitting viscous, 1 of 2 models fitted",
    } == set(fitting)


def test_an_interruption_by_who_is_told_the_progress_is_raised(sliding):
    with pytest.raises(KeyboardInterrupt):
        identify(
            sliding,
            "coulomb_viscous",
            axis=STATED,
            progress=Mock(side_effect=KeyboardInterrupt),
            draws=0,
        )


def test_a_second_interruption_ends_the_work(log, monkeypatch):
    monkeypatch.setattr(
        fits, "fit", Mock(side_effect=chain([DEFAULT], repeat(KeyboardInterrupt)), wraps=fits.fit)
    )
    monkeypatch.setattr(IDENTIFYING, "with_structure", Mock(side_effect=KeyboardInterrupt))
    with pytest.raises(KeyboardInterrupt):
        identify(log, "coulomb,viscous", axis=STATED, blocks=2)


@pytest.mark.parametrize("error", [KeyboardInterrupt(), SignalledError(15)])
def test_interrupted_intervals_keep_the_fit(sliding, monkeypatch, error):
    monkeypatch.setattr(intervals, "with_uncertainty", Mock(side_effect=error))
    identification = identify(sliding, "coulomb_viscous", axis=STATED, blocks=0)
    assert identification.unfinished == "interrupted: intervals from simulated logs are missing"
    assert identification.best.parameters["F_C"].status == "identified"


@pytest.mark.slow
@pytest.mark.parametrize("number", [2, 15], ids=["Ctrl-C", "SIGTERM"])
def test_the_command_line_writes_an_interrupted_result_with_a_remark(
    tmp_path, log, interrupted_after, capsys, number
):
    from bristle.cli.main import main

    rows = np.stack([log.time.values, log.position.values, log.effort.values], axis=1)
    np.savetxt(tmp_path / "log.csv", rows, delimiter=",", header="t,q,u", comments="")
    (tmp_path / "axis.toml").write_text(
        'schema = 1\nkind = "translational"\n[columns]\ntime = { column = "t", unit = "s" }\n'
        'position = { column = "q", unit = "m" }\neffort = { column = "u", unit = "N" }\n'
    )
    interrupted_after(60, number)
    requested = [
        str(tmp_path / "log.csv"),
        "--axis",
        str(tmp_path / "axis.toml"),
        "--out",
        str(tmp_path / "out"),
    ]
    assert main(["identify", *requested, "--model", "lugre", "--json"]) == 128 + number
    printed = capsys.readouterr()
    assert json.loads(printed.out)["unfinished"].startswith(
        "interrupted: 0 of 1 models fitted; the fit of lugre"
    )
    assert "0 of 1 models fitted; the fit of lugre is incomplete" in printed.err
    assert 'unfinished = "interrupted' in (tmp_path / "out" / "model.toml").read_text()


@pytest.mark.parametrize(
    ("recorded", "first"), [("log", "reformed_dahl"), ("sliding", "coulomb_viscous")]
)
def test_the_model_of_the_best_regression_is_fitted_first_and_told(recorded, first, request):
    told = Mock(side_effect=KeyboardInterrupt)
    asked = "stribeck,viscous,coulomb_viscous,reformed_dahl"
    result = identify(
        request.getfixturevalue(recorded), asked, axis=STATED, blocks=2, draws=0, answer=told
    )
    assert [fit.name for fit in result.fits] == [told.call_args.args[0].best.name] == [first]
    assert result.unfinished.startswith("interrupted: 1 of 4 models fitted; ")
    assert first_answer(result)[0].label == "Provisional"


MODELS = "coulomb_viscous,viscous,coulomb"
ERRORS = [
    FloatingPointError("overflow"),
    np.linalg.LinAlgError("singular"),
    InputError("diverges", path="model"),
    InputError("empty", path="F_C"),
]


@pytest.fixture(scope="module")
def ranked(sliding):
    return [fit.name for fit in identify(sliding, MODELS, axis=STATED, blocks=2, draws=0).fits]


def failing_for(name, original, error):
    """The function, with an error if one of its arguments has this name."""

    def computed(*arguments):
        if any(getattr(argument, "name", "") == name for argument in arguments):
            raise error
        return original(*arguments)

    return computed


@pytest.mark.parametrize("error", ERRORS, ids=repr)
def test_a_model_whose_fit_fails_is_omitted(sliding, monkeypatch, error):
    monkeypatch.setattr(fits, "fit", failing_for("coulomb_viscous", fits.fit, error))
    result = identify(sliding, MODELS, axis=STATED, blocks=2, draws=0)
    assert {fit.name for fit in result.fits} == {"viscous", "coulomb"}
    assert result.left_out == {"coulomb_viscous": getattr(error, "message", str(error))}
    with pytest.raises(type(error)):
        identify(sliding, "coulomb_viscous", axis=STATED, blocks=2, draws=0)


def test_a_fault_of_the_log_is_no_fault_of_a_model(sliding, monkeypatch):
    error = InputError("has no load", path="log")
    monkeypatch.setattr(fits, "fit", failing_for("coulomb", fits.fit, error))
    with pytest.raises(InputError, match="has no load"):
        identify(sliding, MODELS, axis=STATED, blocks=2, draws=0)


@pytest.mark.parametrize("error", ERRORS, ids=repr)
def test_a_model_whose_intervals_fail_gives_way_to_the_next(sliding, ranked, monkeypatch, error):
    (best, second, last), drawn = ranked, []
    monkeypatch.setattr(
        intervals,
        "with_uncertainty",
        failing_for(best, lambda fit, *_: drawn.append(fit.name) or fit, error),
    )
    result = identify(sliding, MODELS, axis=STATED, blocks=2, draws=20)
    assert [(fit.name, fit.rank) for fit in result.fits] == [(second, 1), (last, 2)]
    assert drawn == [second]
    assert result.unfinished == ""
    assert result.notes[-1].startswith(
        f"{best} is omitted: its intervals from simulated logs failed: "
    )
    with pytest.raises(type(error)):
        identify(sliding, best, axis=STATED, blocks=2, draws=20)
