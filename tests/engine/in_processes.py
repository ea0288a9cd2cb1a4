"""A script as a person writes it: much work, sent to processes. It prints what came back otherwise than it was here.

``python in_processes.py METHOD FILE``: how the processes begin, and a file with a model of a user's own.
"""

import json
import multiprocessing
import sys
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from typing import Annotated, NamedTuple

import numpy as np
from tests.core.same_bits import bits_of
from tests.identification.known_logs import sliding_log

import bristle as br
from bristle.contract import example_of
from bristle.core import FrictionModel, Model, Variable, kernel
from bristle.core.experiment import Experiment, Feedforward, Run, Variant
from bristle.core.mathematics import direction
from bristle.files.user_model import load_code


class Parameters(NamedTuple):
    F_C: Annotated[float, Variable("force", "Coulomb friction force", min=0.0)] = 3.0


class State(NamedTuple):
    pass


class Move(NamedTuple):
    pass


@kernel
def trial(state, memory, motion, dt, p):
    return p.F_C * direction(motion.v) + motion.v, Move()


@kernel
def commit(state, memory, move, p):
    return state


OF_THE_SCRIPT = FrictionModel(
    name="of_the_script",
    description="made here",
    Parameters=Parameters,
    State=State,
    trial=trial,
    commit=commit,
)


def experiment(M: float, friction: Model) -> Experiment:
    """A short loop, in two runs with other noise."""
    return Experiment(
        "short",
        "translational",
        (
            Variant(
                "only",
                br.plants.inertia(M=M),
                friction,
                br.controllers.cascade(k_p=80.0, k_v=250.0 * M),
                br.sensors.encoder(resolution=1e-6, noise=1e-6),
                br.references.sine(amplitude=1e-3, frequency=5.0),
                Feedforward(mass=M),
                Run(0.05, 1e-3, seeds=2),
            ),
        ),
    )


def returned(model: Model) -> tuple[Model, bool]:
    """A model as it arrived, and whether it is of the component that another copy of it is of."""
    return model, br.friction.find("lugre").inner is br.friction.lugre


def main(method: str, file: str) -> list[str]:
    """What differs."""
    lugre = example_of(br.friction.find("lugre+asymmetry"))
    models = [
        lugre,
        example_of(br.friction.preisach_lugre),
        example_of(br.friction.find("maxwell_slip+position")),
        example_of(load_code(file)),
        OF_THE_SCRIPT(),
    ]
    experiments = [experiment(M, lugre) for M in np.linspace(1.0, 2.0, 100)]
    force = partial(br.response, x=1e-4 * np.sin(np.arange(100.0)), dt=1e-3)
    identify = partial(br.identify, sliding_log(), blocks=2, draws=20)
    work = {
        "simulations": (br.simulate, experiments),
        "forces": (force, models),
        "models": (returned, models),
        "identifications": (identify, ["coulomb_viscous", "stribeck+asymmetry"]),
    }
    here = {
        name: bits_of([function(item) for item in each]) for name, (function, each) in work.items()
    }
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context(method)) as pool:
        present = {
            name: list(pool.map(function, each, chunksize=5))
            for name, (function, each) in work.items()
        }
    return [name for name, result in present.items() if bits_of(result) != here[name]]


if __name__ == "__main__":
    print(json.dumps(main(*sys.argv[1:])))
