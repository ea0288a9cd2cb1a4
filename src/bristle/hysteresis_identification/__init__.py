"""Hysteresis operators from recorded input and output, whatever sign their measure has."""

from bristle.hysteresis_identification.closed_form import fit_closed_form
from bristle.hysteresis_identification.congruency import Congruency, congruency_of
from bristle.hysteresis_identification.grid import fit_grid
from bristle.hysteresis_identification.identify import FITTED, identify_operator
from bristle.hysteresis_identification.result import OperatorFit, OperatorIdentification, OperatorPrediction, predict_operator
from bristle.hysteresis_identification.stops import fit_stops, thresholds_over

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
]
