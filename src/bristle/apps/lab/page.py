"""The page of the lab: one file that contains all scripts and styles, which the page identifies by their hashes."""

from collections.abc import Mapping
from functools import cache
from importlib import resources
from typing import Any

from markupsafe import Markup

from bristle import __version__
from bristle.apps.targets.page.loop import tracking_described
from bristle.apps.targets.page.packing import as_json
from bristle.apps.targets.page.switches import lab_described
from bristle.core import Experiment, Model, Variable, amount, guarded, optional
from bristle.core.palette import colour_variables
from bristle.engine import FRICTION
from bristle.files import read_experiment
from bristle.report.assets import environment, joined, policy

PACKAGE = "bristle.apps.lab"
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
    shared, script, style = (
        joined(SHARED, PACKAGE),
        joined(SCRIPTS, PACKAGE),
        colour_variables() + joined(STYLES, PACKAGE),
    )
    texts = {
        "mark": MARK,
        "style": style,
        "shared": shared,
        "script": script,
        "data": as_json(lab_described(FIRST if model is None else model, paper_loop(), **options)),
    }
    return (
        environment(PACKAGE)
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
    with resources.as_file(
        resources.files("bristle").joinpath("apps", "paper", "experiments")
    ) as folder:
        return read_experiment(folder / "set_a.toml")


@cache
def paper_loop() -> dict[str, Any]:
    """Return the module of the closed loop, and the numbers of the paper."""
    variants = {variant.name: variant for variant in paper_experiment().variants}
    return tracking_described(variants["none"], variants["observer"])
