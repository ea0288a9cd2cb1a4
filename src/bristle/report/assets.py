"""Scripts, styles and templates of pages: where they lie, and the policy that lets only them run."""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Iterable
from functools import cache
from importlib import resources
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import jinja2


def policy(scripts: Iterable[str], styles: Iterable[str] | None = None) -> str:
    """Return the content security policy of a page: run these scripts, also in a worker, and use these styles."""
    script = " ".join(hash_of(text) for text in scripts)
    style = "'unsafe-inline'" if styles is None else " ".join(hash_of(text) for text in styles)
    return (
        f"default-src 'none'; script-src {script} 'wasm-unsafe-eval'; style-src {style}; img-src data:; "
        "worker-src blob:; base-uri 'none'; form-action 'none'"
    )


def hash_of(text: str) -> str:
    """Return the hash of a script or a style for a policy."""
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode('utf-8')).digest()).decode('ascii')}'"


def joined(names: Iterable[str], package: str) -> str:
    """Return scripts or styles of a package, one after the other."""
    folder = resources.files(package).joinpath("templates")
    return "\n" + "\n".join(folder.joinpath(name).read_text(encoding="utf-8") for name in names)


@cache
def environment(package: str) -> jinja2.Environment:
    """Return the environment for the templates of a package."""
    import jinja2

    return jinja2.Environment(
        loader=jinja2.PackageLoader(package),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
