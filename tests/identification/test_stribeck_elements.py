"""Elements that slip by a curve: recovered from logs, and the search for them."""

from types import SimpleNamespace

import numpy as np
import pytest
from tests.golden.simulated import SHAPE, SLIDING, gms_log
from tests.identification.known_logs import STATED, virgin_curve

from bristle.files.model import read_model, write_model
from bristle.identification import identify, stribeck_element_models
from bristle.identification.fixed_shape import in_lists, shaped
from bristle.identification.result import Bands
from bristle.identification.stribeck_element_models import (
    OF_THIS_SHAPE,
    Curve,
    StribeckElements,
    estimate_stribeck_elements,
)
from bristle.models.friction import find
from bristle.prediction import predict
from bristle.report.messages import assumptions_of, note_of

MASS = 12.0
ASKED = {"axis": STATED, "mass": MASS, "cutoff": 80.0, "decimation": 2, "blocks": 0}


@pytest.fixture(scope="module")
def result():
    return identify(gms_log(), "gms", draws=20, **ASKED)


@pytest.mark.slow
def test_curve_attraction_and_stiffness_are_recovered(result):
    fit = result.best
    truth = SLIDING | {"v_S": SHAPE["v_S"], "C": SHAPE["C"]}
    for name, value in truth.items():
        estimate = fit.parameters[name]
        assert estimate.status == "identified", note_of(estimate)
        assert estimate.value == pytest.approx(value, rel=0.05), name
    assert fit.parameters["s"].value == pytest.approx(float(np.sum(SHAPE["k_i"])), rel=0.05)
    assert any("assume the given shape of the elements" in item for item in assumptions_of(fit))


@pytest.mark.slow
def test_intervals_contain_curve_and_attraction_for_scattering_friction():
    fit = identify(gms_log(seed=1, scatter=0.03), "gms", draws=30, **ASKED).best
    for name, value in {"F_C": 20.0, "F_S": 28.0, "v_S": 1e-3, "C": 2e3}.items():
        low, high = fit.parameters[name].interval
        assert low < value < high, name
        assert high - low < 0.5 * value, name


@pytest.mark.slow
def test_the_virgin_curve_is_recovered_for_any_single_elements(result):
    values, x = result.best.friction.values, np.linspace(0.5e-6, 18e-6, 30)
    assert (
        np.max(np.abs(virgin_curve(values, x, "F_S") - virgin_curve(SHAPE | SLIDING, x, "F_S")))
        < 0.02 * SLIDING["F_S"]
    )


@pytest.mark.slow
def test_its_model_file_predicts_another_log_with_bands(result, tmp_path):
    fit = result.best
    write_model(
        tmp_path / "model.toml",
        fit.plant,
        fit.friction,
        estimates=fit.estimates,
        bands=fit.resampling.bands,
    )
    read = read_model(tmp_path / "model.toml")
    assert read.friction == fit.friction
    bands = Bands(**read.info["bands"])
    text = predict(
        read.plant, read.friction, gms_log(seed=5), cutoff=80.0, decimation=2, bands=bands
    )
    assert text.metrics["force_error_percent"] == pytest.approx(fit.force_error_percent, rel=0.1)
    assert text.inside_percent > 85.0


@pytest.mark.slow
def test_it_ranks_before_elements_without_a_curve():
    fits = identify(gms_log(), "maxwell_slip,gms", draws=0, **(ASKED | {"blocks": 2})).fits
    assert fits[0].name == "gms"
    assert fits[0].force_error_percent < 0.3 * fits[1].force_error_percent


@pytest.mark.slow
def test_by_direction():
    levels = {"F_C_pos": 24.0, "F_C_neg": 16.0, "F_S_pos": 32.0, "F_S_neg": 24.0}
    log = gms_log("gms+asymmetry", **levels, sigma_2_pos=300.0, sigma_2_neg=300.0)
    fit = identify(log, "gms+asymmetry", draws=0, **ASKED).best
    for name, value in levels.items():
        assert fit.parameters[name].value == pytest.approx(value, rel=0.02), name


FULL, FORCE, SAMPLE_TIME, SLOWEST, FASTEST = 20.0, 6.0, 1e-3, 1e-4, 1.0


class Search:
    """A search that ends where it begins, with the errors that a test tells it."""

    def __init__(self, costs):
        self.costs, self.starts, self.curves, self.reports = iter(costs), [], [], []

    def refit(self, start, rows=None, limit=None):
        self.starts.append(start)
        return SimpleNamespace(values=start, cost=next(self.costs), number=len(self.starts))


class Told(StribeckElements):
    """Elements whose problems are laid out, and whose search is told how it ends."""

    search: Search

    def _elements(self, curve=None):
        self.context.told.curves.append(curve)
        values = dict.fromkeys(("F_C", "F_C_pos", "F_C_neg"), FULL) | {"sigma_2": 300.0}
        parameters = SimpleNamespace(component=len(self.context.told.curves), complete=dict)
        return SimpleNamespace(
            solution=lambda rows=None: (
                SimpleNamespace(parameters=parameters),
                SimpleNamespace(values=values),
            ),
            curve=curve,
        )

    def problem(self, view):
        statics = (
            ("F_S_pos", "F_S_neg", "F_C_pos", "F_C_neg")
            if "asymmetry" in self.component.name
            else ("F_S", "F_C")
        )
        return SimpleNamespace(
            parameters=SimpleNamespace(
                variables=self.component.variables, free=(*statics, "v_S", "C", "sigma_2")
            ),
            view=view,
        )


def solved(*costs, name="gms"):
    """The search, and what it ends with."""
    told = Search(costs)
    scales = SimpleNamespace(
        force=FORCE, sample_time=SAMPLE_TIME, range=lambda variable: (SLOWEST, FASTEST)
    )
    context = SimpleNamespace(told=told, scales=scales, search=lambda problem: told)
    return told, Told(context, find(name)).solve(told.reports.append)


def test_a_search_starts_at_three_velocities_inside_their_range():
    told, _ = solved(3.0, 1.0, 2.0, 1.0)
    assert [start["v_S"] for start in told.starts[:3]] == pytest.approx([1e-3, 1e-2, 1e-1])
    assert told.curves[0] is None
    for start in told.starts[:3]:
        assert start["F_S"] == FULL
        assert 0.5 * FULL < start["F_C"] < 0.9 * FULL
        assert start["sigma_2"] == 300.0
        assert FORCE / start["C"] == pytest.approx(30 * SAMPLE_TIME)


def test_elements_get_the_curve_of_the_best_start_and_the_search_continues():
    told, (_, best, _) = solved(3.0, 1.0, 2.0, 1.0)
    second, last = told.starts[1], told.starts[3]
    assert last == second
    assert told.curves[1] == Curve(
        second["F_C"] / FULL, pytest.approx(1e-2), pytest.approx(second["C"] / FULL)
    )
    assert best.number == 2  # the round that followed was no better


@pytest.mark.parametrize(
    ("rounds", "count", "taken"),
    [
        ((1.1,), 1, None),
        ((0.99,), 1, 1),  # better, by less than 2 %: it is taken, and the last one
        ((0.97, 0.96), 2, 2),
        ((0.9, 0.8, 0.7, 0.6), 4, 4),
        ((0.9, 0.95), 2, 1),
    ],
)
def test_elements_and_curve_alternate_as_long_as_the_error_falls(rounds, count, taken):
    told, (problem, best, elements) = solved(3.0, 1.0, 2.0, *rounds)
    assert (len(told.curves), len(told.starts)) == (1 + count, 3 + count)
    assert best.cost == min(1.0, *rounds)
    number = 1 if taken is None else 1 + taken
    assert problem.view == number
    assert elements.curve == told.curves[number - 1]


def test_reports_rise_from_the_first_start_to_the_last_round():
    told, _ = solved(3.0, 1.0, 2.0, 0.9, 0.8, 0.7, 0.6)
    assert len(told.reports) == 7
    assert told.reports == sorted(set(told.reports))
    assert 0.0 < told.reports[0] < 0.1
    assert 0.8 < told.reports[-1] < 1.0
    assert told.reports[3] == pytest.approx(3.0 / 7.0)


def test_with_directions_each_has_its_level_and_elements_have_the_mean():
    told, _ = solved(3.0, 1.0, 2.0, 1.0, name="gms+asymmetry")
    start = told.starts[0]
    assert (start["F_S_pos"], start["F_S_neg"]) == (FULL, FULL)
    assert start["F_C_pos"] == start["F_C_neg"] < FULL
    assert told.curves[1].ratio == pytest.approx(start["F_C_pos"] / FULL)


def test_an_element_of_a_curve_breaks_away_at_its_deflection():
    element = Curve(0.8, 2e-3, 50.0).element(3e-6)
    values = element.values
    assert (values["F_S"], values["F_C"]) == (3e-6, pytest.approx(0.8 * 3e-6))
    assert (values["v_S"], values["C"]) == (2e-3, pytest.approx(50.0 * 3e-6))
    assert values["F_S"] * values["nu_i"][0] / values["k_i"][0] == pytest.approx(3e-6)


def test_held_out_rows_fit_neither_the_shape_nor_the_parameters(monkeypatch):
    view, rows, asked = shaped(find("gms"), np.ones(5), np.ones(5)), np.array([True, False]), []
    best = SimpleNamespace(values={"F_C": 20.0})

    def of_rows(chosen):
        asked.append(chosen)
        return SimpleNamespace(parameters=SimpleNamespace(component="shape of the rows")), best

    class Told(StribeckElements):
        def solve(self, report):
            return (
                SimpleNamespace(parameters=SimpleNamespace(component=view)),
                best,
                SimpleNamespace(solution=of_rows),
            )

        def problem(self, view):
            return SimpleNamespace(residual=lambda values: (view, values))

    def refit(start, chosen):
        asked.append((start, chosen))
        return SimpleNamespace(values={"F_C": 21.0})

    monkeypatch.setattr(stribeck_element_models, "StribeckElements", Told)
    estimation = estimate_stribeck_elements(
        SimpleNamespace(search=lambda problem: SimpleNamespace(refit=refit)), None, None
    )
    assert estimation.residual_without(rows) == ("shape of the rows", {"F_C": 21.0})
    assert asked[0] is rows
    assert asked[1] == (best.values, rows)
    assert (estimation.solution, estimation.further, estimation.written) == (best, 3, in_lists)
    assert estimation.finished == view.finished
    assert estimation.diagnostics == (OF_THIS_SHAPE,)
    assert not estimation.simulates
