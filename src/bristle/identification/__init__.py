"""From a log to friction models with honest uncertainty."""

from typing import TYPE_CHECKING

from bristle.identification.identify import identify
from bristle.loading import loaded_from

if TYPE_CHECKING:
    from bristle.identification.parameters import Role, name_of
    from bristle.identification.request import models_of, prior_knowledge_of
    from bristle.identification.result import LACKING, Estimate, Fit, HeldOut, Identification, Resampling, Traces
    from bristle.identification.settings import Settings, thresholds
    from bristle.identification.simulated_bands import Bands

__getattr__ = loaded_from(__name__)
