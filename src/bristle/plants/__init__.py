"""Plants, one a file: what friction acts on."""

from bristle.core.contracts import Plant
from bristle.plants.ball_screw import MODEL as ball_screw
from bristle.plants.inertia import MODEL as inertia
from bristle.plants.oscillator import MODEL as oscillator
from bristle.plants.pulled_inertia import MODEL as pulled_inertia

PLANTS: dict[str, Plant] = {plant.name: plant for plant in (inertia, oscillator, pulled_inertia, ball_screw)}

__all__ = ["PLANTS", "ball_screw", "inertia", "oscillator", "pulled_inertia"]


def __dir__() -> list[str]:
    return [name for name in __all__ if not name.isupper()]
