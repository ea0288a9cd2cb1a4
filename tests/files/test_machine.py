"""Machine files: each limit that a run needs, and a motion that a run can repeat."""

import numpy as np
import pytest
from tests.apps.tune.machine import AXIS, MACHINE

from bristle.core import InputError
from bristle.files import read_machine


def place(folder, position, *, axis="", machine="", step=1e-3):
    text = AXIS.format(limit=400.0, resolution=1e-7)
    (folder / "axis.toml").write_text(
        "\n".join(line for line in text.splitlines() if not axis or not line.startswith(axis))
    )
    (folder / "machine.toml").write_text(MACHINE.format(cycles=10) + machine)
    table = np.column_stack([step * np.arange(position.size), 1e6 * position])
    np.savetxt(
        folder / "motion.csv",
        table,
        fmt="%.9g",
        delimiter=",",
        header="time [s],ref [um]",
        comments="",
    )
    return folder / "machine.toml"


def stroke(amplitude=1e-3, samples=1001):
    return amplitude * (1.0 - np.cos(2.0 * np.pi * np.linspace(0.0, 1.0, samples)))


def test_a_motion_is_one_cycle_without_the_first_sample_of_the_next(tmp_path):
    file = read_machine(place(tmp_path, stroke()))
    assert file.cycle.size == 1000
    assert np.max(file.cycle) == pytest.approx(2e-3)
    assert (file.settings["sample_time"], file.cycles, file.effort_ratio) == (
        pytest.approx(1e-3),
        10,
        1.05,
    )


@pytest.mark.parametrize(
    ("position", "changed", "words"),
    [
        *(
            (
                stroke(),
                {"axis": f"{line} ="},
                rf"no limit for {line.replace('_', ' ')}.*Write {line} = ",
            )
            for line in ("velocity", "acceleration", "stroke", "following_error")
        ),
        (stroke(), {"axis": "limit ="}, r"effort\.limit: is needed"),
        # A run cannot repeat the motion.
        (stroke()[:700], {}, "does not end where it starts"),
        (stroke(amplitude=0.03), {}, "leaves the stroke of the axis"),
        (stroke(), {"step": 2e-3}, r"motion\.csv.*has a time step of 0\.002 s"),
    ],
)
def test_missing_limits_and_motions_that_do_not_repeat_are_refused(
    tmp_path, position, changed, words
):
    with pytest.raises(InputError, match=words):
        read_machine(place(tmp_path, position, **changed))
