"""A parameter that the log sees in one direction is seen, though in the other one it may go for nothing."""

from types import SimpleNamespace
from typing import Annotated, NamedTuple

import numpy as np
import pytest
from tests.identification.known_logs import STATED, TRUTH, log_of, sines, sliding_effort, slow_log

from bristle.core import FrictionModel
from bristle.core.mathematics import direction
from bristle.core.variable import Variable
from bristle.friction import find
from bristle.identification import identify
from bristle.identification.uncertainty import Unidentifiable, _without_stiffness
from bristle.report.messages import warnings_of

pytestmark = pytest.mark.slow


class Spring(NamedTuple):
    F_C: Annotated[float, Variable("force", "level", min=0.0, excitation="sliding")]
    stiffness: Annotated[float, Variable("force/length", "of a spring", min=1e-9, excitation="place")]
    reach: Annotated[float, Variable("length", "where its force stays", min=1e-9, excitation="place")]


class Nothing(NamedTuple):
    pass


def along_spring(state, memory, motion, dt, p):
    return p.F_C * direction(motion.v) + p.stiffness * min(max(motion.x, -p.reach), p.reach), Nothing()


def as_it_was(state, memory, move, p):
    return state


SPRING = FrictionModel(name="spring", description="ends", Parameters=Spring, State=Nothing, trial=along_spring, commit=as_it_was)


@pytest.mark.parametrize(("noise", "seed", "status"), [(8.0, 2, "identified"), (25.0, 5, "unidentifiable")])
def test_what_shows_when_it_shrinks_is_seen_though_it_may_grow_for_nothing(noise, seed, status):
    motion = sines(6.0, amplitudes=(0.02,), frequencies=(1.0,), phases=(0.3,))
    # A spring that gives way shortly before the motion turns: were it longer, next to nothing would change.
    spring = 500.0 * np.clip(motion.position, -0.0192, 0.0192)
    effort = sliding_effort(motion, seed, noise, F_v=0.0, offset=0.0) + spring
    fit = identify(log_of(motion, effort), [SPRING], axis=STATED, mass=TRUTH["M"], offset=0.0, blocks=0, draws=20).best
    reach = fit.parameters["reach"]
    assert reach.status == status
    # What is hidden by noise but shows is not held for the sake of the others: it has an interval.
    assert reach.interval is not None
    assert reach.interval[0] < reach.value < reach.interval[1]


LUGRE = find("lugre")(F_C=8.0, F_S=11.0, v_S=2e-3, sigma_0=3e5, sigma_1=600.0, sigma_2=30.0)


@pytest.mark.parametrize(
    ("lost", "statuses"),
    [
        ((), ("identified", "identified")),
        (("sigma_0",), ("unidentifiable", "unidentifiable")),
        (("sigma_1",), ("identified", "unidentifiable")),
    ],
)
def test_a_damping_before_sliding_is_told_beside_its_stiffness_only(monkeypatch, lost, statuses):
    unseen = tuple(Unidentifiable(name, 0.0, flat=False, instead=(), percent=30.0) for name in lost)
    monkeypatch.setattr("bristle.identification.uncertainty.unidentifiable", lambda *_: unseen)
    fit = identify(slow_log(LUGRE), "lugre", axis=STATED, blocks=0, draws=20).best
    assert tuple(fit.parameters[name].status for name in ("sigma_0", "sigma_1")) == statuses
    message = [text for text in warnings_of(fit) if "sigma_1 cannot be identified" in text]
    assert any("beside sigma_0, which the log does not show" in text for text in message) is (lost == ("sigma_0",))


@pytest.mark.parametrize(("status", "lost"), [("held", ()), ("identified", ()), ("unidentifiable", ("sigma_1",))])
def test_a_stiffness_that_is_held_tells_its_damping(status, lost):
    estimates = [SimpleNamespace(name="sigma_0", status=status), SimpleNamespace(name="sigma_1", status="identified")]
    parameters = SimpleNamespace(variables=LUGRE.component.variables)
    problem = SimpleNamespace(parameters=parameters, dataset=SimpleNamespace(kind="translational"))
    assert tuple(_without_stiffness(estimates, (), problem)) == lost
