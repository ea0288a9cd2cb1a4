"""References, each in a file: the commanded motion of a loop."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from bristle.core.contracts import Trajectory
from bristle.core.loading import loaded_from
from bristle.models.family import Family

if TYPE_CHECKING:
    # Every reference of bristle, in the order of the lists.
    # isort: off
    from bristle.models.references.recorded import recorded as recorded
    from bristle.models.references.sine import sine as sine
    from bristle.models.references.varied_sine import varied_sine as varied_sine
    from bristle.models.references.triangle import triangle as triangle
    from bristle.models.references.s_curve import s_curve as s_curve
    from bristle.models.references.chirp import chirp as chirp
    from bristle.models.references.circle import circle as circle

    # isort: on
    from bristle.models.references.legs import legs_through

__getattr__ = loaded_from(__name__)

REFERENCES: Mapping[str, Trajectory] = Family(__name__)

__all__ = ["REFERENCES"]


def __dir__() -> list[str]:
    return [*REFERENCES]
