"""Plants, one a file: what friction acts on."""

from bristle.core.contracts import Plant
from bristle.plants.inertia import MODEL as inertia
from bristle.plants.pulled_inertia import MODEL as pulled_inertia

PLANTS: dict[str, Plant] = {plant.name: plant for plant in (inertia, pulled_inertia)}

__all__ = ["PLANTS", "inertia", "pulled_inertia"]
