"""Draws of what was identified."""

from __future__ import annotations

from bristle.exports.target import Product, Request, Target

__all__ = ["TARGET"]

DRAWS = 1000


def write(request: Request) -> Product:
    """Return the tables."""
    from bristle.exports.draws import draws_files

    return Product(*draws_files(request.model, request.plant, request.drawn, request.draws or DRAWS, request.name))


TARGET = Target(
    name="draws",
    write=write,
    takes_draws=True,
    needs="draws of an identification",
    description="what the bootstrap found, a row a draw with all correlations, and the same as attributes of a scene of MuJoCo",
)
