"""Design of a motion from whose log friction can be identified, with a rehearsal of the result."""

from typing import TYPE_CHECKING

from bristle.excitation.excite import excite
from bristle.loading import loaded_from

if TYPE_CHECKING:
    from bristle.excitation.excite import NARROWER, Excitation
    from bristle.excitation.motion import ExcitationMotion, ExcitationPiece
    from bristle.excitation.purposes import PURPOSES
    from bristle.excitation.rehearsal import Rehearsal

__getattr__ = loaded_from(__name__)
