"""CUDA C++: thousands of axes beside each other."""

from __future__ import annotations

from bristle.exports.target import Product, Request, Target

__all__ = ["TARGET"]


def write(request: Request) -> Product:
    """Return the source, and what of it is not that of C."""
    from bristle.exports.cuda import cuda_files
    from bristle.exports.subject import subject_of

    files, notes = cuda_files(subject_of(request.sampled), request.name, request.source, request.dt)
    return Product(dict(files), notes)


TARGET = Target(
    name="cuda",
    title="CUDA",
    write=write,
    rest="middle",
    operators=True,
    description="CUDA C++: lanes of a graphics processor, thousands of axes beside each other",
)
