"""The sentences of all diagnostics by code, each with its meaning and advice."""

from bristle.report.sentences.checks import CHECKS, COMPARISONS
from bristle.report.sentences.fits import FITS, PREDICTIONS
from bristle.report.sentences.loops import LOOPS
from bristle.report.sentences.parameters import PARAMETERS, STRUCTURE
from bristle.report.sentences.sentence import Sentence

__all__ = ["FORMER_CODES", "SENTENCES", "Sentence"]

# The sentence of each code.
SENTENCES: dict[str, Sentence] = {**CHECKS, **PARAMETERS, **FITS, **STRUCTURE, **PREDICTIONS, **LOOPS, **COMPARISONS}

# Codes of release 0.2 and their successors, until 0.4; without a successor bristle does not report them any more.
FORMER_CODES: dict[str, str] = {
    "begins_at_rest": "start_of_contact",
    "clock_suspect": "unit_suspect",
    "coloured_residual": "",
    "creeps": "rests",
    "effort_worse_than_none": "worse_than_none",
    "fast_reversals": "few_reversals",
    "filtered_rows": "filtered",
    "half_cycles_differ": "",
    "half_sample": "",
    "intervals_loop": "intervals",
    "logs_repeat": "motion_repeats",
    "missing_load": "missing_channel",
    "missing_temperature": "missing_channel",
    "no_bend": "few_strokes",
    "no_interval": "few_cycles",
    "no_presliding": "missing_presliding",
    "no_reversal": "few_reversals",
    "no_steady_slide": "no_fall",
    "noisy_position": "coarse_position",
    "one_amplitude": "",
    "position_worse_than_none": "worse_than_none",
    "rates_differ": "resampled",
    "repeats_one_motion": "motion_repeats",
    "rests_left_out": "rests",
    "run_in": "start_of_contact",
    "seen_together": "small_effect",
    "slow_sampling": "filtered",
    "stamps_jitter": "resampled",
    "unseen": "small_effect",
}
