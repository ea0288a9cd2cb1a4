"""The tracking loop of the page: that of the source paper."""

from functools import cache
from importlib import resources
from typing import Any

from bristle.core import Experiment
from bristle.exports import tracking_described
from bristle.files import read_experiment


@cache
def paper_experiment() -> Experiment:
    """Return the tracking experiment of the paper."""
    with resources.as_file(resources.files("bristle").joinpath("paper", "experiments")) as folder:
        return read_experiment(folder / "set_a.toml")


@cache
def paper_loop() -> dict[str, Any]:
    """Return what the page knows of the loop: its module, and the numbers of the paper."""
    variants = {variant.name: variant for variant in paper_experiment().variants}
    return tracking_described(variants["none"], variants["observer"])
