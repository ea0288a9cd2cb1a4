"""Plants, one a file: what friction acts on."""

from bristle.core.contracts import Plant
from bristle.plants.inertia import MODEL as inertia
from bristle.plants.oscillator import MODEL as oscillator
from bristle.plants.pulled_inertia import MODEL as pulled_inertia

PLANTS: dict[str, Plant] = {plant.name: plant for plant in (inertia, oscillator, pulled_inertia)}

__all__ = ["PLANTS", "inertia", "oscillator", "pulled_inertia"]
