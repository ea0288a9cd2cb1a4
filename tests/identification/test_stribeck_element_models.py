"""Elements that slip by a curve: start, steps and end of the search."""

from types import SimpleNamespace

import numpy as np
import pytest

from bristle.friction import find
from bristle.identification import stribeck_element_models
from bristle.identification.fixed_shape import in_lists, shaped
from bristle.identification.stribeck_element_models import OF_THIS_SHAPE, Curve, StribeckElements, estimate_stribeck_elements

LEVEL, FORCE, SAMPLE_TIME, SLOWEST, FASTEST = 20.0, 6.0, 1e-3, 1e-4, 1.0


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
        values = dict.fromkeys(("F_C", "F_C_pos", "F_C_neg"), LEVEL) | {"sigma_2": 300.0}
        parameters = SimpleNamespace(component=len(self.context.told.curves), complete=dict)
        return SimpleNamespace(
            solution=lambda rows=None: (SimpleNamespace(parameters=parameters), SimpleNamespace(values=values)), curve=curve
        )

    def problem(self, view):
        statics = ("F_S_pos", "F_S_neg", "F_C_pos", "F_C_neg") if "asymmetry" in self.component.name else ("F_S", "F_C")
        return SimpleNamespace(
            parameters=SimpleNamespace(variables=self.component.variables, free=(*statics, "v_S", "C", "sigma_2")), view=view
        )


def solved(*costs, name="gms"):
    """The search, and what it ends with."""
    told = Search(costs)
    scales = SimpleNamespace(force=FORCE, sample_time=SAMPLE_TIME, range=lambda variable: (SLOWEST, FASTEST))
    context = SimpleNamespace(told=told, scales=scales, search=lambda problem: told)
    return told, Told(context, find(name)).solve(told.reports.append)


def test_a_search_starts_at_three_velocities_inside_their_range():
    told, _ = solved(3.0, 1.0, 2.0, 1.0)
    assert [start["v_S"] for start in told.starts[:3]] == pytest.approx([1e-3, 1e-2, 1e-1])
    assert told.curves[0] is None
    for start in told.starts[:3]:
        assert start["F_S"] == LEVEL
        assert 0.5 * LEVEL < start["F_C"] < 0.9 * LEVEL
        assert start["sigma_2"] == 300.0
        assert FORCE / start["C"] == pytest.approx(30 * SAMPLE_TIME)


def test_elements_get_the_curve_of_the_best_start_and_the_search_continues():
    told, (_, best, _) = solved(3.0, 1.0, 2.0, 1.0)
    second, last = told.starts[1], told.starts[3]
    assert last == second
    assert told.curves[1] == Curve(second["F_C"] / LEVEL, pytest.approx(1e-2), pytest.approx(second["C"] / LEVEL))
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
    assert len(told.curves) == 1 + count
    assert len(told.starts) == 3 + count
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
    assert (start["F_S_pos"], start["F_S_neg"]) == (LEVEL, LEVEL)
    assert start["F_C_pos"] == start["F_C_neg"] < LEVEL
    assert told.curves[1].ratio == pytest.approx(start["F_C_pos"] / LEVEL)


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
            return SimpleNamespace(parameters=SimpleNamespace(component=view)), best, SimpleNamespace(solution=of_rows)

        def problem(self, view):
            return SimpleNamespace(residual=lambda values: (view, values))

    def refit(start, chosen):
        asked.append((start, chosen))
        return SimpleNamespace(values={"F_C": 21.0})

    monkeypatch.setattr(stribeck_element_models, "StribeckElements", Told)
    estimation = estimate_stribeck_elements(SimpleNamespace(search=lambda problem: SimpleNamespace(refit=refit)), None, None)
    assert estimation.residual_without(rows) == ("shape of the rows", {"F_C": 21.0})
    assert asked[0] is rows
    assert asked[1] == (best.values, rows)
    assert (estimation.solution, estimation.further, estimation.written) == (best, 3, in_lists)
    assert estimation.finished == view.finished
    assert estimation.diagnostics == (OF_THIS_SHAPE,)
    assert not estimation.simulates
