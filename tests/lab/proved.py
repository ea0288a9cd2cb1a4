"""How many blocks of walks a page of the lab proves itself with."""

from bristle.exports.page import described, switches
from bristle.friction import MODELS

GIVEN = "gms+asymmetry"


def blocks_with_given():
    """Return the blocks of the page of the model that is given: of every set of slots sixteen are one block.

    Of the given model, each slot and all of them are one.
    """
    return sum(21 + 2 ** len(switches.offered(described.example_named(name))) // 16 + 1 for name in MODELS) + 5 + 1 + 1
