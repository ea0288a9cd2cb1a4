"""An identification as scikit-learn has its estimators: cloned, in a pipeline, in folds, in a search."""

import pickle

import numpy as np
import pytest
from sklearn.exceptions import NotFittedError
from sklearn.utils import estimator_checks
from tests.identification.test_delay import late

import bristle as br
from bristle.apps.targets import FrictionRegressor
from bristle.core.errors import InputError

DT = 1e-3
TRUTH = br.friction.coulomb_viscous(F_C=5.0, F_v=80.0)


def recorded(rows):
    """Time and position of an axis of 12 kg, and the effort that drove it, of which half a newton is noise."""
    t = DT * np.arange(rows)
    effort = 30.0 * np.sin(6.0 * t) + 12.0 * np.sin(np.sqrt(3.0) * 10.0 * t) + 8.0 * np.sin(0.7 * t)
    trace = br.engine.run_open_loop(br.plants.inertia(M=12.0), TRUTH, effort, DT)
    return np.column_stack((t, trace.position)), effort + 0.5 * np.random.default_rng(
        2
    ).standard_normal(t.size)


@pytest.fixture(scope="module")
def log():
    return recorded(3600)


@pytest.fixture(scope="module")
def fitted(log):
    return FrictionRegressor(cutoff=60.0).fit(*log)


def moving(position):
    """Where the axis surely slides, so that friction has one value."""
    return np.abs(np.gradient(position, DT)) > 0.02


@pytest.mark.slow
def test_the_regressor_gives_the_result_of_identify(log, fitted):
    X, y = log
    same = br.identify(
        {"time": X[:, 0], "position": X[:, 1], "effort": y}, "coulomb_viscous", cutoff=60.0, draws=0
    )
    assert fitted.identified_.parameters == same.parameters
    assert fitted.identified_.parameters["M"].value == pytest.approx(12.0, rel=0.01)
    assert fitted.n_features_in_ == 2


def test_the_regressor_predicts_the_effort_of_every_row(log, fitted):
    X, y = log
    predicted = fitted.predict(X)
    assert predicted.shape == y.shape
    inner = moving(X[:, 1])[200:-200]
    left = (y - predicted)[200:-200][inner]
    assert np.std(left) == pytest.approx(0.5, rel=0.25)
    assert fitted.score(X, y) == pytest.approx(
        1.0 - np.sum((y - predicted) ** 2) / np.sum((y - y.mean()) ** 2)
    )
    assert fitted.score(X, y) > 0.98


def test_the_weight_of_a_row_counts_in_the_score(log, fitted):
    X, y = log
    spoilt = y.copy()
    spoilt[2000:2100] += 500.0
    weight = np.ones(y.size)
    weight[2000:2100] = 0.0
    assert fitted.score(X, spoilt) < 0.9 < 0.98 < fitted.score(X, spoilt, sample_weight=weight)


@pytest.mark.slow
def test_a_delayed_effort_is_predicted_with_its_delay(log):
    X, y = log
    late = np.concatenate((np.full(50, y[0]), y[:-50]))
    regressor = FrictionRegressor(cutoff=60.0, axis=br.Axis(delay=0.05)).fit(X, late)
    assert regressor.score(X[300:-300], late[300:-300]) > 0.97
    assert regressor.score(X[300:-300], y[300:-300]) < 0.9


@pytest.mark.slow
def test_a_filtered_position_predicts_the_true_effort():
    recorded = late(position_lag=6e-3)
    X, y = np.column_stack((recorded.time.values, recorded.position.values)), recorded.effort.values
    regressor = FrictionRegressor().fit(X, y)
    assert regressor.identified_.treatment["position_smoothing"] == pytest.approx(6e-3, rel=0.05)
    # Friction that jumps by 16 N is rounded by the filter of the treatment; along the late position 1.6 N are missed.
    error = (regressor.predict(X) - y)[300:-300]
    assert np.sqrt(np.mean(error**2)) < 1.2


def test_missing_rows_split_a_log(log, fitted):
    X, y = log
    kept = np.concatenate((np.arange(1500), np.arange(2500, 3600)))
    regressor = FrictionRegressor(cutoff=60.0).fit(X[kept], y[kept])
    assert len(regressor.identified_.log.segments) == 2
    apart = regressor.predict(X[kept])
    assert apart[200:1300] == pytest.approx(regressor.predict(X)[200:1300], abs=1e-6)
    with pytest.raises(
        InputError, match=r"\d+ rows are in segments that are too short.*row 1500, 2 s"
    ):
        fitted.predict(X[np.concatenate((np.arange(1500), np.arange(2000, 2050)))])


@pytest.mark.slow
def test_named_columns_are_used_by_name_and_a_third_one_is_a_velocity(log):
    pandas = pytest.importorskip("pandas")
    X, y = log
    velocity = np.gradient(X[:, 1], DT)
    frame = pandas.DataFrame(
        {"position": X[:, 1], "velocity": velocity, "time": X[:, 0], "more": 9.0}
    )
    named = FrictionRegressor(cutoff=60.0).fit(frame, y)
    assert list(named.feature_names_in_) == ["time", "position", "velocity"]
    np.testing.assert_array_equal(named.identified_.log.velocity.values, velocity)
    np.testing.assert_array_equal(named.identified_.log.position.values, X[:, 1])
    assert named.score(frame, y) > 0.97
    with pytest.raises(InputError, match="X: lacks a column"):
        named.predict(frame.rename(columns={"time": "t"}))
    with pytest.raises(
        InputError,
        match="X: has a different number of columns than the X of fit; found 2, allowed 3",
    ):
        named.predict(X)


def test_the_best_of_several_models_predicts_with_the_kind_of_axis(log):
    X, y = log
    axis = br.Axis(kind="rotational")
    regressor = FrictionRegressor("viscous,coulomb_viscous", axis=axis, cutoff=60.0).fit(
        X[:2500], y[:2500]
    )
    assert regressor.identified_.best.name == "coulomb_viscous"
    assert regressor.identified_.parameters["F_C"].unit == "N*m"
    assert regressor.score(X, y) > 0.98


@pytest.mark.parametrize(
    ("X", "y", "words"),
    [
        (
            np.zeros((500, 4)),
            np.zeros(500),
            "X: must have the columns time, position and, optionally, velocity",
        ),
        (
            np.column_stack((DT * np.arange(500), np.zeros(500))),
            np.zeros(400),
            "y: has a different number of rows than X; found 400, allowed 500",
        ),
        (
            np.column_stack((DT * np.arange(500), np.zeros(500))),
            np.zeros((500, 1)),
            "^y: must be a 1-D array",
        ),
        (np.zeros(500), np.zeros(500), "X: must be a 2-D array"),
    ],
)
def test_invalid_logs_are_refused(X, y, words):
    with pytest.raises(InputError, match=words):
        FrictionRegressor().fit(X, y)


def test_missing_fit_and_unknown_parameters_are_reported(log):
    with pytest.raises(NotFittedError, match=r"not fitted yet\. Call 'fit'"):
        FrictionRegressor().predict(log[0])
    with pytest.raises(ValueError, match="Invalid parameter 'modle'"):
        FrictionRegressor().set_params(modle="lugre")
    assert (
        repr(FrictionRegressor("lugre", cutoff=60.0))
        == "FrictionRegressor(cutoff=60.0, model='lugre')"
    )


def test_the_regressor_can_be_pickled(log, fitted):
    np.testing.assert_array_equal(
        pickle.loads(pickle.dumps(fitted)).predict(log[0]), fitted.predict(log[0])
    )


# --- in scikit-learn ----------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_the_regressor_works_in_pipelines_folds_and_searches():
    from sklearn.base import clone, is_regressor
    from sklearn.model_selection import GridSearchCV, KFold, TimeSeriesSplit, cross_val_score
    from sklearn.pipeline import make_pipeline
    from sklearn.preprocessing import FunctionTransformer
    from sklearn.utils.validation import check_is_fitted

    X, y = recorded(9000)
    regressor = FrictionRegressor(cutoff=60.0, axis=br.Axis(name="stage"))
    assert is_regressor(regressor)
    assert clone(regressor.fit(X, y)).get_params() == regressor.get_params()
    assert not hasattr(clone(regressor), "identified_")
    check_is_fitted(regressor)

    millimetres = X * (1.0, 1e3)
    pipeline = make_pipeline(
        FunctionTransformer(lambda columns: columns * (1.0, 1e-3)), clone(regressor)
    )
    assert pipeline.fit(millimetres, y).score(millimetres, y) == pytest.approx(
        regressor.score(X, y), abs=1e-6
    )

    for folds in (KFold(3), TimeSeriesSplit(3)):
        scores = cross_val_score(clone(regressor), X, y, cv=folds)
        assert scores.shape == (3,)
        assert np.all(scores > 0.95)
    search = GridSearchCV(
        clone(regressor), {"model": ["viscous", "coulomb_viscous"]}, cv=KFold(3)
    ).fit(X, y)
    assert search.best_params_ == {"model": "coulomb_viscous"}

    with pytest.raises(InputError, match="is too short for this filter"):
        cross_val_score(
            clone(regressor), X, y, cv=KFold(3, shuffle=True, random_state=1), error_score="raise"
        )


# Those checks that hand in no columns of random numbers, which are no log.
CHECKS = (
    "estimator_cloneable",
    "estimator_tags_renamed",
    "valid_tag_types",
    "estimator_repr",
    "no_attributes_set_in_init",
    "do_not_raise_errors_in_init_or_set_params",
    "mixin_order",
    "parameters_default_constructible",
    "get_params_invariance",
    "set_params",
)


@pytest.mark.parametrize("name", CHECKS)
def test_the_regressor_passes_the_checks_of_scikit_learn(name):
    getattr(estimator_checks, f"check_{name}")("FrictionRegressor", FrictionRegressor())


@pytest.mark.parametrize("rows", [slice(None, None, -1), [*range(2500, 3500), *range(1000)]])
def test_rows_that_run_backward_are_refused(log, fitted, rows):
    X, y = log
    for call in (FrictionRegressor(cutoff=60.0).fit, fitted.score):
        with pytest.raises(InputError, match="X: has rows that run backward in time"):
            call(X[rows], y[rows])
