"""References, one a file: the motion that a loop is asked to follow."""

from bristle.core.contracts import Trajectory
from bristle.references.circle import MODEL as circle
from bristle.references.recorded import MODEL as recorded
from bristle.references.sine import MODEL as sine
from bristle.references.triangles import MODEL as triangles
from bristle.references.varied_sine import MODEL as varied_sine

REFERENCES: dict[str, Trajectory] = {
    reference.name: reference for reference in (circle, recorded, sine, triangles, varied_sine)
}

__all__ = ["REFERENCES", "circle", "recorded", "sine", "triangles", "varied_sine"]
