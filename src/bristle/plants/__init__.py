"""Plants, one a file: what friction acts on."""

from bristle.core.contracts import Plant
from bristle.plants.inertia import MODEL as inertia

PLANTS: dict[str, Plant] = {plant.name: plant for plant in (inertia,)}

__all__ = ["PLANTS", "inertia"]
