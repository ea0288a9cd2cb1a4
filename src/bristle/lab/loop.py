"""The tracking loop of the page: that of the source paper."""

from functools import cache
from importlib import resources
from typing import Any

from bristle.core import Experiment
from bristle.exports import body_described, parts_described
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
    plain, observing = variants["none"], variants["observer"]
    return parts_described(plain.sensor, sliding=(plain.controller, None), observer=(observing.controller, None)) | {
        "rig": body_described(plain.friction),
        "paper": {
            "K_2": plain.controller.values["K_2"],
            "g": observing.controller.values["g"],
            "frequency": plain.reference.values["frequency"],
        },
        "sampleTime": plain.run.sample_time,
        "delay": plain.run.delay,
    }
