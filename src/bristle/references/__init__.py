"""References, one a file: the motion that a loop is asked to follow."""

from typing import TYPE_CHECKING

from bristle.core.contracts import Trajectory
from bristle.loading import loaded_from
from bristle.references.chirp import MODEL as chirp
from bristle.references.circle import MODEL as circle
from bristle.references.recorded import MODEL as recorded
from bristle.references.s_curve import MODEL as s_curve
from bristle.references.sine import MODEL as sine
from bristle.references.triangle import MODEL as triangle
from bristle.references.varied_sine import MODEL as varied_sine

if TYPE_CHECKING:
    from bristle.references.legs import legs_through

__getattr__ = loaded_from(__name__)

REFERENCES: dict[str, Trajectory] = {
    reference.name: reference for reference in (recorded, sine, varied_sine, triangle, s_curve, chirp, circle)
}

__all__ = ["REFERENCES", "chirp", "circle", "recorded", "s_curve", "sine", "triangle", "varied_sine"]


def __dir__() -> list[str]:
    return [name for name in __all__ if not name.isupper()]
