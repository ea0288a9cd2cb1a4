"""Identification of hysteresis operators from recorded input and output, with a measure of either sign."""

from bristle.hysteresis.identification.identify import FITTED, identify_operator
from bristle.hysteresis.identification.result import OperatorFit, OperatorIdentification, OperatorPrediction, predict_operator

__all__ = ["FITTED", "OperatorFit", "OperatorIdentification", "OperatorPrediction", "identify_operator", "predict_operator"]
