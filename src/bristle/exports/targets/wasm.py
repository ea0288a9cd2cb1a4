"""WebAssembly, for a browser or node."""

from __future__ import annotations

from bristle.exports.target import Product, Request, Target

__all__ = ["TARGET"]


def write(request: Request) -> Product:
    """Return the module and its loader."""
    from bristle.exports.subject import subject_of
    from bristle.exports.wasm import wasm_files

    return Product(wasm_files(subject_of(request.sampled), request.name, request.source))


TARGET = Target(
    name="wasm",
    title="WebAssembly",
    write=write,
    rest="middle",
    description="a module of WebAssembly and the script that loads it, for a browser or node",
)
