"""Identification of hysteresis operators from recorded input and output, with a measure of either sign."""

from typing import TYPE_CHECKING

from bristle.core.loading import loaded_from

if TYPE_CHECKING:
    from bristle.identification.hysteresis.identify import FITTED, identify_operator
    from bristle.identification.hysteresis.result import (
        OperatorFit,
        OperatorIdentification,
        OperatorPrediction,
        predict_operator,
    )

__getattr__ = loaded_from(__name__)

__all__ = [
    "FITTED",
    "OperatorFit",
    "OperatorIdentification",
    "OperatorPrediction",
    "identify_operator",
    "predict_operator",
]
