"""The sentences of all diagnostics, by their codes, with what each means and what to do."""

from bristle.report.sentences.checks import CHECKS
from bristle.report.sentences.comparisons import COMPARISONS
from bristle.report.sentences.fits import FITS
from bristle.report.sentences.loops import LOOPS
from bristle.report.sentences.parameters import PARAMETERS
from bristle.report.sentences.predictions import PREDICTIONS
from bristle.report.sentences.sentence import Sentence
from bristle.report.sentences.structure import STRUCTURE

__all__ = ["SENTENCES", "Sentence"]

SENTENCES: dict[str, Sentence] = {**CHECKS, **PARAMETERS, **FITS, **STRUCTURE, **PREDICTIONS, **LOOPS, **COMPARISONS}
"""The sentence of each code."""
