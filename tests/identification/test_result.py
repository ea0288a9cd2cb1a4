"""What an identification holds: friction along the log, what was noted of each log."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.identification.known_logs import TRUTH, sliding_log

from bristle.identification import identify

QUICK = {"draws": 0, "blocks": 0}


def test_friction_is_the_effort_less_what_moves_the_mass():
    traces = identify(sliding_log(noise=0.01), "coulomb_viscous", **QUICK).best.traces
    expected = TRUTH["F_C"] * np.sign(traces.velocity) + TRUTH["F_v"] * traces.velocity + TRUTH["offset"]
    # The filter rounds what jumps at reversals.
    assert np.median(np.abs(traces.friction - expected)) < 0.1
    assert np.mean(traces.friction) == pytest.approx(np.mean(expected), abs=0.05)


def test_what_is_noted_of_one_log_names_it_and_what_is_noted_of_all_does_not():
    logs = [
        replace(sliding_log(seed), source=Path(f"{seed}.csv"), notes=("of all", *notes)) for seed, notes in enumerate(((), ("of one",)))
    ]
    assert identify(logs, "coulomb_viscous", **QUICK).notes == ("of all", "1.csv: of one")
