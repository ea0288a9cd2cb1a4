"""A scene of MuJoCo."""

from __future__ import annotations

from bristle.exports.target import Product, Request, Target

__all__ = ["TARGET"]


def write(request: Request) -> Product:
    """Return the scene."""
    from bristle.exports.mjcf import mjcf_notes, mjcf_text

    text = mjcf_text(request.model, request.name, request.source, request.mass)
    return Product({f"{request.name}.xml": text}, mjcf_notes(request.model))


TARGET = Target(name="mjcf", title="MuJoCo", write=write, description="a scene of MuJoCo with what it has of friction")
