"""The models of the bench, which stand beside its experiments: the friction of the rig, and what is identified on it.

The friction of the rig and the compensators identified from its logs are numbers in files, so that an experiment can be
run, read and changed without this module. `write_models` makes them again, to the bit on one machine.
"""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import NamedTuple

import numpy as np

from bristle.core.axis import Axis
from bristle.core.contracts import Model
from bristle.core.experiment import Experiment
from bristle.core.fingerprint import digest
from bristle.core.variable import unit_of
from bristle.files.experiment import read_experiment
from bristle.files.model import FITTED_TO, write_model
from bristle.identification import identify
from bristle.logs.log import Channel, Log
from bristle.paper.rig import rig_friction
from bristle.simulation import simulate

__all__ = ["SETS", "Rig", "axis_of", "compensator_from_log", "logged", "write_models"]

CUTOFF, DECIMATION = 15.0, 33  # [Hz], samples: the motion to be compensated is slow


class Rig(NamedTuple):
    """What the two sets differ in: lead [m], inertia [kg*m^2], offset [N*m] and asymmetry of the friction."""

    lead: float
    inertia: float
    offset: float
    asymmetry: float


SETS = {"set_a": Rig(5e-3, 4e-4, 5e-3, 0.3), "set_b": Rig(10e-3, 8e-4, 12.6e-3, 0.0)}


def write_models(folder: str | PathLike[str]) -> None:
    """Write the friction of the rig and the identified compensator of each set beside its experiments in a folder."""
    target = Path(folder)
    for name, rig in SETS.items():
        write_model(target / f"{name}_rig.toml", None, rig_friction(*rig), provenance={"made by": "bristle.paper.rig"})
        log = target / f"{name}_log.toml"
        source = {"identified from a run of": log.name, FITTED_TO: digest(read_experiment(log).variants[0].friction)}
        write_model(target / f"{name}_identified.toml", None, compensator_from_log(log), provenance=source)
        if name == "set_a":  # what stands beside it in baselines.toml
            write_model(target / f"{name}_gms.toml", None, compensator_from_log(log, "gms"), provenance=source)


def compensator_from_log(experiment: str | PathLike[str], model: str = "maxwell_slip") -> Model:
    """Return the friction that is identified from the encoder and the effort command of an experiment's run."""
    described = read_experiment(experiment)
    return identify(logged(described), model, axis=axis_of(described), blocks=0, draws=0).best.friction


def logged(described: Experiment) -> Log:
    """Return what the first loop of an experiment logs of itself: the encoder, and the effort command as it acted."""
    variant = described.variants[0]
    result, run = simulate(described).variants[variant.name], variant.run
    samples = np.arange(result.command.size)
    acting = np.interp(samples - run.delay - run.current_lag / run.sample_time, samples, result.command)
    length, force = unit_of("length", described.kind), unit_of("force", described.kind)
    return Log(
        time=Channel(result.time, "s", "time"),
        position=Channel(result.measured, length, "encoder"),
        effort=Channel(acting, force, "command"),
        sample_time=run.sample_time,
        segments=(slice(0, samples.size),),
        kind=described.kind,
    )


def axis_of(described: Experiment) -> Axis:
    """Return what is known of the axis of an experiment before anything is identified from its log."""
    variant = described.variants[0]
    return Axis(
        kind=described.kind,
        mass=variant.plant.values["M"],
        held=True,
        cutoff=CUTOFF,
        decimation=DECIMATION,
        resolution=variant.sensor.values["resolution"],
    )
