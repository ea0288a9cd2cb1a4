"""Identification of hysteresis operators from recorded input and output, with a measure of either sign."""

from bristle.identification.hysteresis.identify import FITTED, identify_operator
from bristle.identification.hysteresis.result import (
    OperatorFit,
    OperatorIdentification,
    OperatorPrediction,
    predict_operator,
)

__all__ = [
    "FITTED",
    "OperatorFit",
    "OperatorIdentification",
    "OperatorPrediction",
    "identify_operator",
    "predict_operator",
]
