"""A motion as a list of moves: the same turning points, speeds and rests, without set points."""

import csv
import re
from dataclasses import replace

import pytest
from tests.excitation.axes import STAGE

from bristle.core.axis import Column
from bristle.excitation import excite
from bristle.excitation.motion import moves_of
from bristle.files.motion import gcode_of, moves_table

IN_MM = replace(STAGE, columns={"time": Column("t", "s", "s"), "position": Column("x", "mm", "m"), "effort": Column("u", "N", "N")})


@pytest.fixture(scope="module")
def motion():
    return excite(IN_MM, duration=30.0, purposes="presliding,break-away,damping,stribeck", rehearsed=False).motion


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
    assert [float(row[2]) for row in rows] == pytest.approx([1e3 * move.target for move in moves], abs=1e-6)
    assert [float(row[3]) for row in rows] == pytest.approx([1e3 * move.velocity for move in moves], rel=1e-5)


@pytest.mark.parametrize(("kind", "letter", "scale"), [("translational", "X", 1e3), ("rotational", "A", 57.29577951)])
def test_the_program_runs_at_the_same_feeds(moves, kind, letter, scale):
    program = gcode_of(moves, replace(STAGE, kind=kind), ())
    steps = re.findall(rf"^G1 {letter}(\S+) F(\S+)$", program, re.M)
    assert [float(target) for target, _ in steps] == pytest.approx([scale * move.target for move in moves], abs=1e-6)
    assert [float(feed) for _, feed in steps] == pytest.approx([60.0 * scale * item.velocity for item in moves], abs=1e-4)
    assert len(re.findall(r"^G4 P", program, re.M)) == sum(move.dwell > 0.0 for move in moves)
    assert program.endswith("M30\n")
