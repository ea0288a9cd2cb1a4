"""Design of a motion from whose log friction can be identified, with a rehearsal of the result."""

from typing import TYPE_CHECKING

from bristle.core.loading import loaded_from
from bristle.prediction.excitation.excite import excite

if TYPE_CHECKING:
    from bristle.prediction.excitation.excite import NARROWER, Excitation
    from bristle.prediction.excitation.motion import ExcitationMotion, ExcitationPiece
    from bristle.prediction.excitation.purposes import PURPOSES
    from bristle.prediction.excitation.rehearsal import Rehearsal

__getattr__ = loaded_from(__name__)
