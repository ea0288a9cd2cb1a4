"""The sentences of all diagnostics by code, each with its meaning and advice."""

from bristle.report.sentences.checks import CHECKS, COMPARISONS
from bristle.report.sentences.fits import FITS, PREDICTIONS
from bristle.report.sentences.loops import LOOPS
from bristle.report.sentences.parameters import PARAMETERS, STRUCTURE
from bristle.report.sentences.sentence import Sentence

__all__ = ["SENTENCES", "Sentence"]

# The sentence of each code.
SENTENCES: dict[str, Sentence] = {
    **CHECKS,
    **PARAMETERS,
    **FITS,
    **STRUCTURE,
    **PREDICTIONS,
    **LOOPS,
    **COMPARISONS,
}
