"""Results of an identification: friction along the log, and notes of each log."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from tests.identification.known_logs import STATED, TRUTH, sliding_log

from bristle.core.diagnostic import Diagnostic
from bristle.friction import coulomb, viscous, with_slots
from bristle.identification import Identification, identify
from bristle.identification.estimate import Estimate

pytestmark = pytest.mark.usefixtures("of_one_mass")

QUICK = {"axis": STATED, "draws": 0, "blocks": 0}


def test_friction_is_the_effort_minus_that_of_the_plant():
    traces = identify(sliding_log(noise=0.01), "coulomb_viscous", **QUICK).best.traces
    expected = TRUTH["F_C"] * np.sign(traces.velocity) + TRUTH["F_v"] * traces.velocity + TRUTH["offset"]
    # The filter rounds what jumps at reversals.
    assert np.median(np.abs(traces.friction - expected)) < 0.1
    assert np.mean(traces.friction) == pytest.approx(np.mean(expected), abs=0.05)


def test_a_note_of_one_log_names_it_and_a_common_note_does_not():
    logs = [
        replace(sliding_log(seed), source=Path(f"{seed}.csv"), notes=("of all", *notes)) for seed, notes in enumerate(((), ("of one",)))
    ]
    assert identify(logs, "coulomb_viscous", **QUICK).notes == ("of all", "1.csv: of one")


def test_an_interval_is_that_of_the_larger_error_or_of_replicates():
    estimate = Estimate("F_C", "N", "level", -4.0, 0.1, robust_std=0.2)
    assert estimate.relative_std_percent == pytest.approx(2.5)
    assert estimate.larger_std == 0.2
    assert estimate.ends == pytest.approx((-4.392, -3.608), abs=1e-3)
    assert estimate.interval_percent == pytest.approx(9.8, abs=0.01)
    assert replace(estimate, interval=(-5.0, -3.0)).interval_percent == 25.0
    assert replace(estimate, std=None).larger_std == 0.2
    unknown = replace(estimate, std=None, robust_std=None)
    assert (unknown.relative_std_percent, unknown.larger_std, unknown.ends, unknown.interval_percent) == (None, None, None, None)
    zero = replace(estimate, value=0.0)
    assert (zero.relative_std_percent, zero.interval_percent) == (None, None)
    assert zero.ends is not None


def fit_with(name, *estimates, levels=True):
    component = with_slots(coulomb, ["asymmetry"]) if levels else viscous
    friction = SimpleNamespace(component=component)
    return SimpleNamespace(
        name=name, friction=friction, estimates=estimates, parameters={entry.name: entry for entry in estimates}, with_constant=()
    )


def notes_of(*fits, left_out=None, logs=((),)):
    recorded = [SimpleNamespace(notes=notes, source=Path(f"{number}.csv")) for number, notes in enumerate(logs)]
    return Identification(fits, recorded[0], {}, tuple(recorded[1:]), left_out=left_out or {}).notes


def constant(value, std=0.1, robust=None, status="identified"):
    return Estimate("offset", "N", "constant", value, std, status=status, robust_std=robust)


HELD = replace(constant(0.0, None), status="held", reason=Diagnostic("held_levels", "offset"))
LEVELS = (Estimate("F_C_pos", "N", "level", 8.0, 0.1), Estimate("F_C_neg", "N", "level", 6.0, 0.1))


@pytest.mark.parametrize(
    ("other", "noted"),
    [
        (constant(2.1), True),
        (constant(1.9), False),  # a quarter of the larger level
        (constant(-2.1), True),
        (constant(2.5, std=0.8, robust=0.9), False),
        (constant(2.5, std=0.9, robust=0.8), True),
        (constant(2.5, status="unidentifiable"), False),
        (constant(2.5, std=None), False),
    ],
)
def test_a_large_significant_constant_force_of_another_model_is_noted(other, noted):
    assert bool(notes_of(fit_with("best", *LEVELS, HELD), fit_with("other", other))) is noted


def test_the_note_about_a_constant_force_names_the_first_model_and_a_line():
    (note,) = notes_of(fit_with("best", *LEVELS, HELD), fit_with("other", constant(2.1)), fit_with("third", constant(5.0)))
    assert note.startswith("best holds offset at 0, as every model with +asymmetry does. other identified offset = 2.1 N")
    assert 'offset = "2.1 N" under [plant]' in note
    assert notes_of(fit_with("best", *LEVELS), fit_with("other", constant(5.0))) == ()
    assert len(notes_of(fit_with("best", HELD, levels=False), fit_with("other", constant(0.2, std=0.01)))) == 1  # no level to compare with


def test_omitted_models_are_named_last():
    notes = notes_of(fit_with("best", *LEVELS), left_out={"gms": "too few rows"}, logs=(("a", "b"), ("b",)))
    assert notes == ("0.csv: a", "b", "gms is omitted: too few rows")
