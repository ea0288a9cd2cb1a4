"""A motion made of pieces: one after the other, from rest to rest, and as a list of moves."""

import csv
import re
from dataclasses import replace

import numpy as np
import pytest
from tests.prediction.excitation.axes import STAGE

from bristle.core.axis import Column
from bristle.files.motion import gcode_of, moves_table
from bristle.models.references import chirp, s_curve, triangle
from bristle.prediction.excitation import excite
from bristle.prediction.excitation.motion import (
    ExcitationMotion,
    ExcitationPiece,
    in_time,
    length_of,
    moves_of,
)


def slide(distance, speed, rest=0.2, acceleration=100.0):
    reference = s_curve(distance=distance, velocity=speed, acceleration=acceleration)
    return ExcitationPiece("stribeck", "slide", reference, rest, speed, distance)


# 1 m/s over 1 m takes 1 s and 10 ms for the corners, 2 m/s over 0.5 m 0.25 s and 20 ms.
MOTION = ExcitationMotion((slide(1.0, 1.0), slide(-0.5, 2.0, rest=0.4)), 1e-3, start=3.0)


def test_pieces_follow_each_other_after_their_rests_and_the_motion_rests_at_its_end():
    assert [piece.duration for piece in MOTION.pieces] == pytest.approx([1.01, 0.27])
    assert MOTION.begins == pytest.approx([0.2, 1.61])
    assert length_of(MOTION.pieces) == pytest.approx(1.88)
    assert MOTION.duration == pytest.approx(2.38)
    assert MOTION.time[-1] == pytest.approx(2.38, abs=1e-3)
    assert MOTION.time.size == pytest.approx(2381, abs=1)


@pytest.mark.parametrize(
    ("time", "position", "velocity"),
    [(0.1, 3.0, 0.0), (0.705, 3.5, 1.0), (1.4, 4.0, 0.0), (1.745, 3.75, -2.0), (2.2, 3.5, 0.0)],
)
def test_each_piece_begins_at_the_end_of_its_predecessor(time, position, velocity):
    at = round(time / 1e-3)
    assert (MOTION.position[at], MOTION.velocity[at], MOTION.acceleration[at]) == pytest.approx(
        (position, velocity, 0.0), abs=2e-3
    )


def test_samples_of_velocity_and_acceleration_belong_to_the_positions():
    assert np.gradient(MOTION.position, 1e-3) == pytest.approx(MOTION.velocity, abs=0.11)
    assert np.max(np.abs(MOTION.acceleration)) == 100.0


def test_the_end_of_a_piece_is_counted_from_its_begin():
    assert [piece.end for piece in MOTION.pieces] == pytest.approx([1.0, -0.5])


def to_and_fro(pace):
    return [slide(1.0, pace, 0.0, 1e9), slide(-1.0, pace, 0.0, 1e9)]


@pytest.mark.parametrize(
    ("low", "high", "pace"), [(0.1, 9.0, 0.5), (0.7, 9.0, 0.7), (0.1, 0.3, 0.3)]
)
def test_the_pace_of_pieces_fits_the_time_within_its_limits(low, high, pace):
    pieces = in_time(to_and_fro, 4.0, 5.0, low, high)
    assert [piece.speed for piece in pieces] == pytest.approx([pace, pace])


def test_a_pace_is_found_where_most_of_the_time_is_rest():
    def make(pace):
        return [slide(1.0, pace, 3.0, 1e9)]

    assert length_of(in_time(make, 4.0, 1.0, 1e-3, 1e3)) == pytest.approx(4.0, rel=1e-2)
    assert in_time(make, 4.0, 2.0, 1e-3, 1e3)[0].speed == pytest.approx(1.0, rel=0.05)


def test_moves_are_the_turning_points_with_the_speed_and_the_acceleration_to_each():
    reference = triangle(amplitude=2.0, velocity=1.0, acceleration=10.0, cycle_count=2, ratio=0.5)
    loops = ExcitationPiece("presliding", "triangles", reference, 0.3, 1.0, 2.0)
    moves, left_out = moves_of(
        ExcitationMotion((loops, slide(-1.0, 0.5, rest=0.7)), 1e-3, start=5.0)
    )
    assert left_out == ()
    assert [move.target for move in moves] == pytest.approx(
        [7.0, 4.0, 5.5, 4.75, 5.0, 4.0], abs=1e-6
    )
    assert [move.velocity for move in moves] == pytest.approx(
        [1.0, 1.0, 1.0, 1.0, 1.0, 0.5], rel=1e-3
    )
    assert [move.acceleration for move in moves] == pytest.approx([10.0] * 5 + [100.0])
    assert [move.dwell for move in moves] == pytest.approx([0.3, 0.0, 0.0, 0.0, 0.0, 0.7], abs=1e-3)
    assert [move.purpose for move in moves] == ["presliding"] * 5 + ["stribeck"]


def test_a_dwell_of_two_samples_is_ignored():
    moves, _ = moves_of(
        ExcitationMotion((slide(1.0, 1.0, rest=1.9e-3), slide(-1.0, 1.0, rest=2.2e-3)), 1e-3)
    )
    assert [move.dwell for move in moves] == pytest.approx([0.0, 2.2e-3], abs=1e-4)


def test_a_piece_within_an_eighth_of_a_sample_is_a_move():
    (move,), _ = moves_of(ExcitationMotion((slide(1e-6, 1.0, acceleration=1e6),), 0.1))
    assert move.target == pytest.approx(1e-6)
    assert move.velocity == pytest.approx(1.0)


def test_a_chirp_is_left_out_of_the_moves_and_named_in_the_program():
    reference = chirp(amplitude=1e-3, f_0=5.0, f_1=10.0, duration=1.0, ramp=0.2)
    chirps = [ExcitationPiece("damping", "chirp", reference, 0.2, 1.0, 1e-3)] * 2
    motion = ExcitationMotion((*chirps, slide(1.0, 1.0)), 1e-3)
    moves, left_out = moves_of(motion)
    assert left_out == ("damping",)
    assert [move.target for move in moves] == pytest.approx([1.0])
    table, program = moves_table(moves, STAGE), gcode_of(moves, STAGE, left_out)
    assert table.startswith("purpose,dwell [s],")
    assert "(omitted, because it is not a list of moves: damping)" in program
    assert program.count("G1 X") == 1


# --- moves of a whole motion ------------------------------------------------------------------------------------------


IN_MM = replace(
    STAGE,
    columns={
        "time": Column("t", "s", "s"),
        "position": Column("x", "mm", "m"),
        "effort": Column("u", "N", "N"),
    },
)


@pytest.fixture(scope="module")
def motion():
    return excite(
        IN_MM, duration=30.0, purposes="presliding,break-away,damping,stribeck", rehearsed=False
    ).motion


@pytest.fixture(scope="module")
def moves(motion):
    return moves_of(motion)[0]


def test_moves_keep_the_limits_of_the_motion(moves):
    assert max(move.velocity for move in moves) <= 0.9 * STAGE.velocity_limit * (1.0 + 1e-9)
    assert max(move.acceleration for move in moves) <= 0.9 * STAGE.acceleration_limit * (1.0 + 1e-9)
    assert min(move.velocity for move in moves) > 0.0
    assert any(move.dwell > 0.0 for move in moves)


def test_the_table_is_in_the_units_of_the_axis(moves):
    head, *rows = csv.reader(moves_table(moves, IN_MM).splitlines())
    assert head[2:4] == ["x [mm]", "velocity [mm/s]"]
    assert [float(row[2]) for row in rows] == pytest.approx(
        [1e3 * move.target for move in moves], abs=1e-6
    )
    assert [float(row[3]) for row in rows] == pytest.approx(
        [1e3 * move.velocity for move in moves], rel=1e-5
    )


@pytest.mark.parametrize(
    ("kind", "letter", "scale"), [("translational", "X", 1e3), ("rotational", "A", 57.29577951)]
)
def test_the_program_runs_at_the_same_feeds(moves, kind, letter, scale):
    program = gcode_of(moves, replace(STAGE, kind=kind), ())
    steps = re.findall(rf"^G1 {letter}(\S+) F(\S+)$", program, re.M)
    assert [float(target) for target, _ in steps] == pytest.approx(
        [scale * move.target for move in moves], abs=1e-6
    )
    assert [float(feed) for _, feed in steps] == pytest.approx(
        [60.0 * scale * item.velocity for item in moves], abs=1e-4
    )
    assert len(re.findall(r"^G4 P", program, re.M)) == sum(move.dwell > 0.0 for move in moves)
    assert program.endswith("M30\n")
