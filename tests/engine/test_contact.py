"""A contact moved by hand, where it stood at first, and the force that it settles to."""

import math

import numpy as np
import pytest

from bristle import friction
from bristle.engine import contact, force_along
from bristle.engine.contact import Contact, _forgotten, place_of, state_at, steady_force

pytestmark = pytest.mark.usefixtures("in_plain_python")

LUGRE = friction.lugre(F_C=20.0, F_S=28.0, v_S=2e-3, sigma_0=1e6, sigma_1=1e3, sigma_2=200.0)
SLIDER = friction.find("gap_slider")(**friction.gap_slider.example)
SLIDERS = friction.maxwell_slip(F_C=20.0, k_i=[6e6, 4e6], nu_i=[0.5, 0.5])


def test_a_contact_moves_in_equal_steps_at_a_speed():
    contact = Contact(LUGRE)
    force = contact.move(-4e-6, 2e-3, 4)
    # A micrometre at 2 mm/s takes half a millisecond.
    assert force.tolist() == force_along(LUGRE, np.full(4, -2e-3), 0.5e-3).tolist()
    assert contact.x == -4e-6
    assert contact.state.tolist() == pytest.approx([-4e-6], rel=0.1)
    contact.move(1e-6, 1e-3)
    assert contact.x == pytest.approx(-3e-6)


def test_friction_depends_on_the_position_of_a_contact():
    contact = Contact(
        friction.find("viscous+position")(
            F_v=10.0, x_0=0.0, x_L=1.0, p_1=0.0, p_2=0.0, a_1=3.0, a_2=0.0
        )
    )
    assert contact.move(0.4, 1.0, 2).tolist() == pytest.approx([10.3, 10.9])
    assert contact.force(0.0) == pytest.approx(1.2)
    assert contact.move(-0.4, 1.0).tolist() == pytest.approx([-10.0 + 0.6])


def test_reading_the_force_does_not_move_the_contact():
    contact = Contact(SLIDERS)
    contact.move(1e-6, 1e-3)
    assert contact.force(1e-3) == contact.force(1e-3) == pytest.approx(10.0)
    assert contact.move(1e-6, 1e-3)[0] == pytest.approx(15.0, rel=0.1)


@pytest.mark.parametrize("model", [SLIDERS, LUGRE])
def test_a_copy_of_a_contact_is_independent(model):
    contact = Contact(model)
    contact.move(1e-6, 1e-3)
    before, other = contact.force(1e-3), contact.copy()
    other.move(-1e-6, 1e-3)
    assert (contact.x, other.x) == (1e-6, 0.0)
    assert contact.force(1e-3) == before > other.force(1e-3)


def motion_of(count=300, dt=1e-3):
    v = 2e-3 * np.sin(2.0 * np.pi * np.arange(1, count + 1) / 150.0)
    return {"v": v, "x": dt * np.cumsum(v)}


@pytest.mark.parametrize("place", [-1.0, -0.77, 0.0, 0.3, 1.0])
def test_the_initial_place_of_a_contact_is_found_from_its_force(place):
    motion = motion_of()
    measured = force_along(SLIDER, motion["v"], 1e-3, motion["x"], state=state_at(SLIDER, place))
    assert place_of(SLIDER, motion, 1e-3, measured) == pytest.approx(place, abs=2e-3)


@pytest.mark.parametrize("place", [-0.93, -0.317, 0.041, 0.7])
def test_a_parabola_interpolates_the_initial_place_between_trials(monkeypatch, place):
    motion, tried = motion_of(), []
    monkeypatch.setattr(contact, "state_at", lambda friction, at: tried.append(at) or at)
    monkeypatch.setattr(
        contact,
        "along",
        lambda friction, dt, state, **motion: np.full(motion["v"].size, 7.0 * state),
    )
    assert place_of(SLIDER, motion, 1e-3, np.full(300, 7.0 * place)) == pytest.approx(
        place, abs=1e-9
    )
    assert min(abs(at - place) for at in tried) > 1e-6  # none of them was tried
    assert len(tried) < 40


def test_the_initial_place_is_found_in_noise():
    motion = motion_of(3000)
    measured = force_along(SLIDER, motion["v"], 1e-3, motion["x"], state=state_at(SLIDER, 0.4))
    measured += 0.2 * np.random.default_rng(3).standard_normal(3000)
    measured[1500:] += 50.0  # long after the start is forgotten
    assert place_of(SLIDER, motion, 1e-3, measured) == pytest.approx(0.4, abs=0.05)


def test_a_contact_without_memory_of_its_start_has_the_middle_place():
    flat = SLIDER.with_values(give=1e-12, gap=1e-12)
    v = np.full(300, 1.0)
    assert place_of(flat, {"v": v, "x": 1e-3 * np.cumsum(v)}, 1e-3, np.full(300, 20.0)) == 0.0


UNEVEN = friction.find("coulomb+position")(
    F_C=20.0, x_0=0.1, x_L=0.1, p_1=0.5, p_2=0.1, a_1=3.0, a_2=1.0
)


@pytest.mark.parametrize(
    ("model", "v", "force"),
    [
        *(
            (LUGRE, v, math.copysign(20.0 + 8.0 * math.exp(-((v / 2e-3) ** 2)), v) + 200.0 * v)
            for v in (1e-4, -2e-3, 0.3)
        ),
        *((friction.dahl(F_C=20.0, sigma_0=sigma_0), 1e-5, 20.0) for sigma_0 in (1e2, 1e9)),
        (friction.coulomb_viscous(F_C=20.0, F_v=5.0), -2.0, -30.0),
        (UNEVEN, 1.0, 20.0),  # its value in the middle
    ],
)
def test_a_force_settles_to_that_of_steady_sliding(model, v, force):
    assert steady_force(model, v) == pytest.approx(force, rel=1e-9)


@pytest.mark.parametrize(
    ("speed", "count", "gap", "steps"),
    [
        # From end to end the spring deflects by the gap and twice by what gives, here in steps of a micrometre.
        *((speed, 400, 4e-6, 12) for speed in (1e-3, -1e-3)),
        (1e-3, 400, 0.0, 8),
        (1e-3, 5, 4e-6, 5),  # the whole log
        (1e-5, 1500, 4e-6, 1200),  # beyond the samples that are looked at first
    ],
)
def test_the_start_has_no_influence_after_both_extremes_slipped(speed, count, gap, steps):
    v = np.full(count, speed)
    assert (
        _forgotten(SLIDER.with_values(gap=gap), {"v": v, "x": 1e-3 * np.cumsum(v)}, 1e-3) == steps
    )
