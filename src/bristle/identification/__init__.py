"""From a log to friction models with honest uncertainty."""

from bristle.identification.identify import identify
from bristle.identification.result import Estimate, Fit, HeldOut, Identification, Traces

__all__ = ["Estimate", "Fit", "HeldOut", "Identification", "Traces", "identify"]
