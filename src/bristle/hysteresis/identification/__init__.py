"""Hysteresis operators from recorded input and output, whatever sign their measure has."""

from bristle.hysteresis.identification.identify import FITTED, identify_operator
from bristle.hysteresis.identification.result import OperatorFit, OperatorIdentification, OperatorPrediction, predict_operator

__all__ = ["FITTED", "OperatorFit", "OperatorIdentification", "OperatorPrediction", "identify_operator", "predict_operator"]
