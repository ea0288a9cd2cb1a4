"""Hysteresis operators from recorded input and output, whatever sign their measure has."""

from bristle.identification.operators.closed_form import fit_closed_form
from bristle.identification.operators.congruency import Congruency, congruency_of
from bristle.identification.operators.grid import fit_grid
from bristle.identification.operators.identify import FITTED, identify_operator
from bristle.identification.operators.result import (
    OperatorFit,
    OperatorIdentification,
    OperatorPrediction,
    predict_operator,
)
from bristle.identification.operators.stops import fit_stops, thresholds_over, virgin_curve_of

__all__ = [
    "FITTED",
    "Congruency",
    "OperatorFit",
    "OperatorIdentification",
    "OperatorPrediction",
    "congruency_of",
    "fit_closed_form",
    "fit_grid",
    "fit_stops",
    "identify_operator",
    "predict_operator",
    "thresholds_over",
    "virgin_curve_of",
]
