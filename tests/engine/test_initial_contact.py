"""A start that is searched for follows the parameters: derivatives leave out what it makes up for."""

from dataclasses import replace

import numpy as np
import pytest

import bristle as br
from bristle.identification.dataset import Dataset, Segment
from bristle.identification.estimation import context_of
from bristle.identification.inverse_dynamics import InverseDynamics
from bristle.identification.parameters import PriorKnowledge, parameters_of
from bristle.logs.log import Channel, Log
from bristle.models.plants import inertia
from bristle.report.messages import notes_of

DT = 1e-3
TRUTH = {"F_C": 20.0, "give": 2e-3, "gap": 4e-3, "n": 2.5, "share": 0.1, "sigma_2": 10.0}


@pytest.fixture(scope="module")
def problem():
    """Two stretches that begin elsewhere in the backlash, as one regression."""
    rng, model, segments = np.random.default_rng(4), br.friction.find("gap_slider")(**TRUTH), []
    for number, place in enumerate((0.6, -0.3)):
        t = np.arange(6000) * DT
        x = 8e-3 * np.sin(2.0 * np.pi * (0.4 + 0.2 * number) * t)
        v, a = np.gradient(x, DT), np.gradient(np.gradient(x, DT), DT)
        state = model.component.start(place, model.parameters)
        force = br.engine.force_along(model, v, DT, x + 0.5 * DT * v, state=state) + rng.normal(
            0.0, 0.2, t.size
        )
        segments.append(Segment(t + 6.0 * number, x, v, a, force + 2.0 * a, number))
    dataset = Dataset(tuple(segments), "translational", DT, 1e-9, 0.0, 100.0, 4, 50)
    parameters = parameters_of(model.component, PriorKnowledge(plant=inertia), dataset)
    return InverseDynamics(dataset, parameters)


def test_the_derivative_agrees_with_a_fit_that_searches_its_start_again(problem):
    values = {name: (TRUTH | {"M": 2.0, "offset": 0.0})[name] for name in problem.parameters.free}
    complete = problem.parameters.complete(values)
    contacts = problem.dataset.contacts(problem.model(complete), problem.plant(complete))
    assert contacts == pytest.approx((0.6, -0.3), abs=0.02)
    near, (_, columns) = replace(problem, contacts=contacts), problem.linearised(values)
    for name in ("F_C", "give", "share"):
        step = 0.01 * values[name]
        up, down = values | {name: values[name] + step}, values | {name: values[name] - step}

        def slope(of, up=up, down=down, step=step):
            return (of.residual(up) - of.residual(down)) / (2.0 * step)

        fixed, anew = slope(near), slope(problem)
        result = -columns[:, problem.parameters.free.index(name)]
        left, size = np.linalg.norm(result - anew), np.linalg.norm(anew)
        assert left < 0.05 * size
        assert left < 0.4 * np.linalg.norm(fixed - anew)


def test_the_search_also_updates_the_start(problem):
    search = context_of(problem.dataset, PriorKnowledge(plant=inertia)).search(problem)
    theta = search.space.theta(TRUTH | {"M": 2.0, "offset": 0.0})
    solution = search.descend(theta, limit=1)
    for step, result in zip(0.02 * np.eye(theta.size), solution.jacobian.T, strict=True):
        low, high = (
            problem.residual(search.space.values(theta + side * step)) for side in (-1.0, 1.0)
        )
        anew = (low - high) / 0.04
        assert np.linalg.norm(result - anew) < 0.08 * np.linalg.norm(anew)


def test_a_prediction_reports_the_initial_place_of_the_contact(problem):
    segment = problem.dataset.segments[0]
    log = Log(
        time=Channel(segment.time, "s", "t"),
        position=Channel(segment.position, "m", "q"),
        effort=Channel(segment.effort, "N", "u"),
        sample_time=DT,
        segments=(slice(0, segment.time.size),),
        kind="translational",
    )
    notes = notes_of(br.predict(inertia(M=2.0), br.friction.find("gap_slider")(**TRUTH), log))
    (message,) = [
        note for note in notes if note.startswith("at the start the contact was deflected by")
    ]
    assert float(message.split()[8]) == pytest.approx(60.0, abs=3.0)
    static = br.predict(inertia(M=2.0), br.friction.coulomb(F_C=20.0), log)
    assert not any("was deflected" in note for note in notes_of(static))
