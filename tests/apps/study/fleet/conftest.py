"""Folders of logs of small axes, whose friction is known."""

import numpy as np
import pytest

from bristle.core.axis import Axis, Column

OPTIONS = {"draws": 0, "blocks": 2}
AXIS = Axis(
    columns={
        name: Column(name, "", unit)
        for name, unit in (("time", "s"), ("position", "m"), ("effort", "N"), ("temperature", "K"))
    },
    mass=12.0,
)


def write_log(path, level=5.0, viscous=80.0, temperature=293.0, seed=0, rows=3000):
    """Write the log of an axis of 12 kg that is moved by hand, so to say: its effort is what the motion takes."""
    path.parent.mkdir(exist_ok=True, parents=True)
    t = np.arange(rows) * 1e-3
    position = 0.02 * np.sin(3.0 * t) + 0.01 * np.sin(11.0 * t)
    velocity = 0.06 * np.cos(3.0 * t) + 0.11 * np.cos(11.0 * t)
    noise = np.random.default_rng(seed).normal(0.0, 0.05, rows)
    effort = (
        12.0 * np.gradient(velocity, t) + level * np.sign(velocity) + viscous * velocity + noise
    )
    table = np.column_stack((t, position, effort, np.full(rows, temperature)))
    np.savetxt(
        path,
        table,
        fmt="%.9g",
        delimiter=",",
        header="time,position,effort,temperature",
        comments="",
    )
    return path


@pytest.fixture
def logs(tmp_path):
    """Three logs of one axis, of which the last one is cut off in its first line."""
    folder = tmp_path / "press_3"
    for day, level in ((1, 5.0), (2, 5.5)):
        write_log(folder / f"press_2026-03-0{day}T06-30.csv", level, seed=day)
    (folder / "press_2026-03-03T06-30.csv").write_text("time,position\n0.0")
    return folder
