"""The page of the lab: one file that contains all scripts and styles, which the page identifies by their hashes."""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Iterable, Mapping
from functools import cache
from importlib import resources
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from bristle import __version__
from bristle.core import Experiment, Model, Variable, amount, guarded, optional
from bristle.engine import FRICTION
from bristle.exports import as_json, lab_described, tracking_described
from bristle.files import read_experiment
from bristle.palette import colour_variables

if TYPE_CHECKING:
    import jinja2

MARK = "<!-- A page of bristle lab -->"  # first line of a page, for recognition
FIRST = "preisach_lugre"  # the default model
SHARED = ("physics.js", "loop.js")  # also run by a worker
SCRIPTS = (
    "paths.js",
    "certificates.js",
    "plot.js",
    "pointing.js",
    "pictures.js",
    "controls.js",
    "views.js",
    "bench.js",
    "asking.js",
    "slots.js",
    "tracking.js",
    "machine.js",
    "handles.js",
    "chapters.js",
    "lab.js",
)
STYLES = ("lab.css", "controls.css")


@guarded(
    model=optional(FRICTION),
    mass=optional(amount(Variable("mass", "moved mass", min=0.0), exclusive=True)),
    fastest=amount(Variable("length/time", "largest speed", min=0.0)),
)
def lab_page(
    model: Model | None = None,
    *,
    uncertainty: Mapping[str, Mapping[str, Any]] | None = None,
    mass: float | None = None,
    fastest: float = 0.0,
    source: str = "",
    provenance: Mapping[str, str] | None = None,
) -> str:
    """Return the page: every friction model with example values, and one given model with its values.

    Parameters
    ----------
    model : Model, optional
        The model that the page shows first.
    uncertainty : mapping, optional
        Status and intervals of its parameters, from its model file.
    mass : float, optional
        Moved mass or inertia [kg or kg*m^2].
    fastest : float
        Largest speed of the fit, if known [m/s or rad/s].
    source : str
        Name of the model file.
    provenance : mapping of str to str, optional
        Origin of the page.
    """
    named = f"{model.name} of {source}" if model is not None and source else ""
    options = {"uncertainty": uncertainty, "mass": mass, "fastest": fastest, "named": named}
    shared, script, style = joined(SHARED), joined(SCRIPTS), colour_variables() + joined(STYLES)
    texts = {"mark": MARK, "style": style, "shared": shared, "script": script}
    texts["data"] = as_json(lab_described(FIRST if model is None else model, paper_loop(), **options))
    return (
        environment()
        .get_template("lab.html")
        .render(
            {name: Markup(text) for name, text in texts.items()},
            policy=policy([shared, script], [style]),
            provenance=dict(provenance or {}),
            version=__version__,
        )
    )


@cache
def paper_experiment() -> Experiment:
    """Return the tracking experiment of the paper."""
    with resources.as_file(resources.files("bristle").joinpath("paper", "experiments")) as folder:
        return read_experiment(folder / "set_a.toml")


@cache
def paper_loop() -> dict[str, Any]:
    """Return the module of the closed loop, and the numbers of the paper."""
    variants = {variant.name: variant for variant in paper_experiment().variants}
    return tracking_described(variants["none"], variants["observer"])


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


def joined(names: Iterable[str], package: str = "bristle.lab") -> str:
    """Return scripts or styles of a package, one after the other."""
    folder = resources.files(package).joinpath("templates")
    return "\n" + "\n".join(folder.joinpath(name).read_text(encoding="utf-8") for name in names)


@cache
def environment(package: str = "bristle.lab") -> jinja2.Environment:
    """Return the environment for the templates of a package."""
    import jinja2

    return jinja2.Environment(
        loader=jinja2.PackageLoader(package), autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
