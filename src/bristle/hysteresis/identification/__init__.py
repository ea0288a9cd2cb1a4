"""Hysteresis operators from recorded input and output, whatever sign their measure has."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bristle.core.lazy import loaded_from

if TYPE_CHECKING:
    from bristle.hysteresis.identification.identify import FITTED, identify_operator
    from bristle.hysteresis.identification.result import OperatorFit, OperatorIdentification, OperatorPrediction, predict_operator

__all__ = ["FITTED", "OperatorFit", "OperatorIdentification", "OperatorPrediction", "identify_operator", "predict_operator"]

__getattr__ = loaded_from(
    __name__,
    {
        "FITTED": "identify",
        "identify_operator": "identify",
        "OperatorFit": "result",
        "OperatorIdentification": "result",
        "OperatorPrediction": "result",
        "predict_operator": "result",
    },
)
