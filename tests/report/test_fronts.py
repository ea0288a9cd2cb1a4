"""The verdict on simulated loops and the title of their first page: which loop is better, and by what."""

from dataclasses import replace

import numpy as np
import pytest
from tests.report.test_compensation import with_error

from bristle import references
from bristle.report import simulation as report
from bristle.report.simulation import simulation_ruling


def looped(stage, *sizes):
    """The loop of the stage with given following errors, peak to peak [m]."""
    result = stage.looped
    for name, size in zip(result.variants, sizes, strict=True):
        result = with_error(result, name, lambda item, size=size: 0.5 * size * np.sin(40.0 * item.time))
    return result


@pytest.mark.parametrize(
    ("sizes", "level", "words", "change", "gain"),
    [
        ((20e-6, 9e-6, 4e-6), "usable", "Compensation helps", "9 → 4", ", ×2.2"),
        ((20e-6, 19.5e-6, 19.4e-6), "with_care", "Compensation hardly helps", "19.5 → 19.4", ": no improvement"),
        ((4e-6, 9e-6, 20e-6), "no", "Compensation does not help", "9 → 20", ": no improvement"),
        ((20e-6, 4e-6, 9e-6), "usable", "Another loop helps", "4 → 9", ": no improvement"),
        ((20e-6, 4.05e-6, 4e-6), "usable", "Another loop helps", "4.05 → 4", ": no improvement"),
    ],
)
def test_verdict_of_a_run_follows_the_errors(stage, sizes, level, words, change, gain):
    result = looped(stage, *sizes)
    assert simulation_ruling(result)[:2] == (level, words)
    assert report._front(result, ()).title.replace("\u00a0", " ") == f"Friction feedforward: {change} µm peak to peak{gain}"


def test_variants_with_another_motion_are_not_compared_with_the_base(stage):
    result = looped(stage, 20e-6, 19.5e-6, 4e-6)
    *first, last = result.experiment.variants
    other = replace(last, reference=references.sine(amplitude=1e-3, frequency=1.0))
    moved = replace(result, experiment=replace(result.experiment, variants=(*first, other)))
    assert simulation_ruling(result).words == "Compensation helps"
    assert simulation_ruling(moved).level == "with_care"
