"""A contact in continuous time, piece by piece: where each piece ends, and how the contact deflects until then."""

import math

import numpy as np
import pytest

from bristle.models.friction.branchwise import PASSED, deflection_rate, piece_at
from bristle.models.friction.slip_law import SlipLaw, slip
from bristle.models.hysteresis.everett import ClosedForm
from bristle.models.hysteresis.turning_points import Stack, stack_commit, stack_size, stack_trial

Q = ClosedForm(0, 10.0, 4.0, 2.0)  # 10 N/m at a reversal, 4 N at saturation
GATE, POWER, CREEPING = SlipLaw(0.6, 1.0, 1.0), SlipLaw(-1.0, 2.0, 1.0), SlipLaw(-1.0, 1.0, 1.0)
G = 2.0


def stack_after(*turns):
    """Return the memory of a contact after some turns, and the room for it."""
    memory, stack = np.zeros(stack_size(16)), Stack()
    for u in turns:
        stack = stack_commit(stack, memory, stack_trial(stack, memory, u, 1e-12, Q)[1])
    return stack, memory


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_virgin_contact_deflects_with_its_motion_on_a_curve_without_end(side):
    stack, memory = stack_after()
    piece = piece_at(stack, memory, side, G, GATE)
    assert piece == (side, side, 0.0, 0.0, 0, side * math.inf, 0.0)
    flow = deflection_rate(0.0, piece, 3.0 * side, G, GATE, Q)
    assert (flow.f, flow.z_dot) == (0.0, 3.0 * side)
    # The gate is 0.6 of sliding away.
    assert flow.margin == pytest.approx(0.6)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_below_the_gate_a_contact_moves_with_the_body_until_it_opens(side):
    stack, memory = stack_after(side * 0.1)
    piece = piece_at(stack, memory, side, G, GATE)
    flow = deflection_rate(side * 0.12, piece, side * 2.0, G, GATE, Q)
    assert 0.3 < side * flow.f / G < 0.6
    assert (flow.z_dot, piece.is_open) == (side * 2.0, 0.0)
    assert flow.margin == pytest.approx(0.6 - side * flow.f / G)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_branch_ends_where_a_loop_is_wiped_out(way):
    first, memory = stack_after(way * 0.2, way * 0.05)
    onward = piece_at(first, memory, -way, G, GATE)
    assert onward.end == pytest.approx(-way * 0.2)  # the mirror image of the first turn
    assert (onward.way, onward.depth) == (-way, 1)
    back = piece_at(first, memory, way, G, GATE)
    assert back.end == pytest.approx(way * 0.2)
    assert (back.way, back.depth, back.z) == (way, 2, pytest.approx(way * 0.05))
    # Deflections are told over f_p/s, 0.4 m; the gate is far enough away.
    flow = deflection_rate(way * 0.15, back, way * 1e-3, 1e3, GATE, Q)
    assert flow.margin == pytest.approx(0.05 / 0.4)
    assert deflection_rate(way * 0.21, back, way * 1e-3, 1e3, GATE, Q).margin < 0.0


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize(
    ("law", "z"), [(POWER, 0.1), (CREEPING, 0.1), (GATE, 0.2), (GATE, 0.24), (GATE, 0.28)]
)
def test_the_slipping_share_follows_a_power_law_or_an_open_gate(side, law, z):
    stack, memory = stack_after(side * z)
    piece = piece_at(stack, memory, side, G, law)
    flow, r = deflection_rate(stack.z, piece, side * 2.0, G, law, Q), side * stack.f / G
    assert max(law.rho, 0.2) < r < 1.0
    assert law is not GATE or (piece.is_open, piece.way) == (1.0, side)
    assert flow.z_dot == pytest.approx(side * 2.0 * (1.0 - slip(r, law)))
    assert flow.margin == pytest.approx(min(1.0 - r, r - law.rho) + PASSED)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_contact_above_the_force_in_sliding_returns_to_it(side):
    stack, memory = stack_after(side * 0.3)
    level = 0.8 * side * stack.f
    piece = piece_at(stack, memory, side, level, GATE)
    assert (piece.side, piece.way, piece.is_open) == (side, -side, 1.0)
    flow = deflection_rate(stack.z, piece, side * 2.0, level, GATE, Q)
    # All of the motion slips, and a quarter more.
    assert flow.z_dot == pytest.approx(side * 2.0 * (1.0 - 1.25))
    assert flow.margin == pytest.approx(0.25 + PASSED)


def test_a_contact_turns_only_after_passing_the_force_in_sliding():
    stack, memory = stack_after(0.3)
    for level, way in (
        (stack.f, 1.0),
        (stack.f * (1.0 - 0.5e-9), 1.0),
        (stack.f * (1.0 - 2e-9), -1.0),
    ):
        assert piece_at(stack, memory, 1.0, level, GATE).way == way
    # On its way back it turns around in its turn where it is as far below.
    back, memory = stack_after(0.3, 0.25)
    for level, way in (
        (back.f, -1.0),
        (back.f * (1.0 + 0.5e-9), -1.0),
        (back.f * (1.0 + 2e-9), 1.0),
    ):
        assert piece_at(back, memory, 1.0, level, GATE).way == way


def test_a_step_back_past_a_turning_point_follows_the_mirrored_branch():
    stack, memory = stack_after(0.2)
    piece = piece_at(stack, memory, -1.0, 1e3, GATE)
    behind, at, ahead = (
        deflection_rate(0.2 + dz, piece, -1.0, 1e3, GATE, Q).f for dz in (1e-3, 0.0, -1e-3)
    )
    assert at == pytest.approx(stack.f)
    assert behind - at == pytest.approx(at - ahead, rel=1e-9)
    assert (behind - at) / 1e-3 == pytest.approx(10.0, rel=0.01)
