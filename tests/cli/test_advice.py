"""Advice of a command: once it is followed, the same command does not give it again."""

from pathlib import Path

import numpy as np
import pytest
from tests.cli.conftest import MODEL

AXIS = """
schema = 1
kind = "translational"
columns.time = { column = "t", unit = "s" }
columns.position = { column = "q", unit = "m" }
columns.reference = { column = "r", unit = "m" }
columns.effort = { column = "u", unit = "UNIT" }
"""
VELOCITY = 'velocity = "0.1 m/s"\n'
FAST = f'[limits]\n{VELOCITY}acceleration = "1 m/s^2"\n'
CONTACT = '[plant]\nmass = "28 kg"\npresliding = "7 um"\n[encoder]\nresolution = "1 um"\n[effort]\nlimit = "700 N"\n[limits]\njerk = '


@pytest.fixture(scope="module")
def uneven(tmp_path_factory):
    """A folder with a brief log of uneven time stamps, and a model."""
    folder, t = tmp_path_factory.mktemp("advice"), 1e-3 * np.arange(140.0)
    stamps = t + 3e-4 * np.random.default_rng(1).uniform(-1.0, 1.0, t.size)
    q = 0.02 * np.sin(20.0 * stamps)
    rows = np.column_stack([stamps, q, q, 20.0 * np.cos(20.0 * t)])
    np.savetxt(folder / "log.csv", rows, delimiter=",", header="t,q,r,u", comments="", fmt="%.7f")
    (folder / "model.toml").write_text(MODEL)
    return folder


@pytest.mark.parametrize(
    ("command", "advice", "before", "followed"),
    [
        ("excite axis.toml", "Write velocity under [limits]", "", f"[limits]\n{VELOCITY}"),
        ("excite axis.toml --for stribeck", "Write acceleration under [limits]", f"[limits]\n{VELOCITY}", FAST),
        ("excite axis.toml --for stribeck --duration 2s", "Write stroke under [limits]", FAST, f'{FAST}stroke = ["-1 m", "1 m"]'),
        ("excite axis.toml --for presliding,stribeck", "Write presliding under", "", '[plant]\npresliding = "7 um"'),
        ("excite axis.toml --for damping,stribeck", "Raise jerk to 4900", f'{CONTACT}"1 m/s^3"', f'{CONTACT}"4900 m/s^3"'),
        ("identify log.csv --axis axis.toml", "lower the decimation", "", "[identification]\ndecimation = 1"),
        ("log log.csv --axis axis.toml", "and write sample_time under [timing]", "", '[timing]\nsample_time = "1 ms"'),
        ("identify log.csv --axis axis.toml", "Write rated = ", "%", '[effort]\nrated = "240 N"'),
        ("predict model.toml log.csv --axis axis.toml --mode closed-loop", "Describe the controller", "", "[controller]\nk_p = 80.0"),
    ],
)
def test_advice_that_is_followed_is_not_given_again(bristle, uneven, monkeypatch, command, advice, before, followed):
    monkeypatch.chdir(uneven)
    unit = "%" if before == "%" else "N"
    for lines in (before.strip("%"), followed):
        Path("axis.toml").write_text(AXIS.replace("UNIT", unit) + lines, encoding="utf-8")
        ended = bristle(*command.split())
        assert (advice in " ".join((ended.out + ended.err).split())) == (lines != followed)
