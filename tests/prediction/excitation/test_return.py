"""The return of a motion to its start, for a motion whose parts end elsewhere."""

from dataclasses import replace

import numpy as np
import pytest
from tests.prediction.excitation.axes import STAGE

from bristle.core import InputError
from bristle.models.references import s_curve
from bristle.prediction.excitation import PURPOSES, ExcitationPiece, excite

IN_SI = replace(STAGE, velocity_limit=0.05, acceleration_limit=0.5, jerk_limit=20.0)
NAME = "return to the start"


@pytest.fixture
def away(monkeypatch):
    """Return a function that plans a motion whose part for break-away ends elsewhere."""

    def planned(distance, axis=IN_SI, **options):
        reference = s_curve(distance=distance, velocity=0.04, acceleration=0.4, jerk=20.0)
        slide = ExcitationPiece("break-away", "slide", reference, 0.2, 0.04, distance)
        monkeypatch.setitem(
            PURPOSES, "break-away", PURPOSES["break-away"]._replace(pieces=lambda *_: [slide])
        )
        return excite(axis, purposes="break-away", rehearsed=False, **options)

    return planned


@pytest.mark.parametrize("purposes", [None, *PURPOSES])
def test_motion_that_ends_at_its_start_has_no_return(purposes):
    motion = excite(STAGE, purposes=purposes, rehearsed=False).motion
    assert NAME not in {piece.name for piece in motion.pieces}
    assert motion.position[-1] == pytest.approx(motion.position[0], abs=1e-15)


@pytest.mark.parametrize("distance", [0.08, -0.08, 0.004])
def test_motion_that_ends_elsewhere_returns_within_all_limits(away, distance):
    motion = away(distance).motion
    assert [piece.name for piece in motion.pieces] == ["slide", NAME]
    last = motion.time >= motion.begins[-1] - 0.1
    assert motion.position[last][0] == pytest.approx(motion.start + distance)
    assert motion.position[-1] == pytest.approx(motion.position[0], abs=1e-12)
    assert motion.velocity[-1] == 0.0
    step = motion.sample_time
    assert np.max(np.abs(motion.velocity[last])) <= 0.9 * 0.05 * (1.0 + 1e-9)
    assert np.max(np.abs(motion.acceleration[last])) <= 0.9 * 0.5 * (1.0 + 1e-9)
    assert np.max(np.abs(np.diff(motion.acceleration[last]))) <= 20.0 * step * (1.0 + 1e-6)
    assert np.all(np.abs(np.diff(motion.position)) <= 0.05 * step)


def test_axis_without_limits_returns_in_about_a_second(away):
    motion = away(
        0.004,
        replace(STAGE, velocity_limit=None, acceleration_limit=None, jerk_limit=None, stroke=None),
    ).motion
    assert motion.pieces[-1].duration == pytest.approx(1.1, rel=0.1)
    assert motion.position[-1] == pytest.approx(motion.position[0], abs=1e-12)


def test_return_counts_towards_the_duration(away):
    assert away(0.08, duration="6 s").motion.duration <= 6.0
    with pytest.raises(InputError, match="duration: is too short"):
        away(0.08, duration="4 s")
