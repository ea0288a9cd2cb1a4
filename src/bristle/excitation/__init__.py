"""The motion to run on an axis so that its friction can be identified from the log, and what that will tell."""

from bristle.excitation.excite import Excitation, excite
from bristle.excitation.motion import ExcitationMotion, ExcitationPiece
from bristle.excitation.purposes import PURPOSES
from bristle.excitation.rehearsal import Rehearsal

__all__ = ["PURPOSES", "Excitation", "ExcitationMotion", "ExcitationPiece", "Rehearsal", "excite"]
