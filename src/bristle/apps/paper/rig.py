r"""The virtual rig: a ball-screw table with the friction of thirty elements that slip in sequence.

Thirty spring-slider elements in parallel break away in sequence, the last one after 7 µm: distances
:math:`r_j = 7\,\text{µm} \cdot \rho_j^{1.6}`, :math:`\rho_j` even from 0.15 to 1, weights
:math:`w_j = (r_j/7\,\text{µm})^{-0.75} e^{0.35\,\xi_j}` with :math:`\xi_j` standard normal from one fixed seed, shares
:math:`\nu_j \propto w_j r_j`. Their limits follow a Stribeck curve, may be larger forward than backward,
and scatter by 5 % from reversal to reversal; an offset is added. A Maxwell-slip model is related, but an identified one
lacks the fall with speed, the asymmetry and the scatter. All values are those at the table: a torque of the screw is a
force :math:`2\pi/\ell` times as large, an inertia a mass :math:`(2\pi/\ell)^2` times.

No number here is measured: the paper omits inertia, torque and lead of its rig. With these values its figures are
reproduced.

Its friction and the compensators identified from its logs are numbers in files, so that an experiment can be run, read
and changed without this module. `write_models` computes them again, to the bit on one machine.
"""

import math
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from bristle.core import Axis, Experiment, Model, digest
from bristle.files import FITTED_TO, read_experiment, write_model
from bristle.identification import identify
from bristle.logs import Log
from bristle.models import friction
from bristle.models.friction import spectrum
from bristle.simulation import simulate

ELEMENTS = 30
BREAK_AWAY = 7e-6  # distance at which the last element slips [m]
SEED = 7  # of the weights
COULOMB = 34e-3  # [N*m]
STATIC = 40e-3  # [N*m]
VISCOUS = 3e-3  # [N*m*s/rad]
STRIBECK = 0.5  # [rad/s]
SCATTER = 0.05  # of the limits, from reversal to reversal
SMALLEST_SPEED = 5e-8  # of a reversal [m/s]
DAMPING = 0.4  # of the elements, over the root of stiffness times mass


def screw_ratio(lead: float) -> float:
    """Return the angle of the screw for one metre of the table [rad/m], for a lead [m]."""
    return 2.0 * math.pi / lead


def rig_friction(lead: float, inertia: float, offset: float, asymmetry: float) -> Model:
    """Return the friction of the virtual rig at the table."""
    ratio = screw_ratio(lead)
    nu, r = spectrum(ELEMENTS, BREAK_AWAY, SEED)
    k = nu * STATIC * ratio / r
    levels = {}
    for side, share in (("pos", 1.0 + asymmetry), ("neg", 1.0 - asymmetry)):
        levels |= {
            f"F_C_{side}": share * COULOMB * ratio,
            f"F_S_{side}": share * STATIC * ratio,
            f"sigma_2_{side}": VISCOUS * ratio**2,
        }
    elements = {
        "k_i": k,
        "nu_i": nu,
        "sigma_1": DAMPING * math.sqrt(float(k.sum()) * inertia) * ratio,
    }
    scatter = {"scatter": SCATTER, "v_r": SMALLEST_SPEED, "seed": 1}
    rig = friction.find("maxwell_stribeck+asymmetry")
    return rig(**levels, **elements, **scatter, v_S=STRIBECK / ratio, offset=offset * ratio)


class Rig(NamedTuple):
    """Differences of the two sets: lead [m], inertia [kg*m^2], offset [N*m] and asymmetry of the friction."""

    lead: float
    inertia: float
    offset: float
    asymmetry: float


SETS = {"set_a": Rig(5e-3, 4e-4, 5e-3, 0.3), "set_b": Rig(10e-3, 8e-4, 12.6e-3, 0.0)}


def write_models(folder: str | PathLike[str]) -> None:
    """Write the friction of the rig and the identified compensator of each set next to its experiments in a folder."""
    target = Path(folder)
    for name, rig in SETS.items():
        write_model(
            target / f"{name}_rig.toml",
            None,
            rig_friction(*rig),
            provenance={"made by": "bristle.apps.paper.rig"},
        )
        log = target / f"{name}_log.toml"
        source = {
            "identified from a run of": log.name,
            FITTED_TO: digest(read_experiment(log).variants[0].friction),
        }
        write_model(
            target / f"{name}_identified.toml", None, compensator_from_log(log), provenance=source
        )
        if name == "set_a":  # its neighbour in baselines.toml
            write_model(
                target / f"{name}_gms.toml",
                None,
                compensator_from_log(log, "gms"),
                provenance=source,
            )


def compensator_from_log(experiment: str | PathLike[str], model: str = "maxwell_slip") -> Model:
    """Return the friction identified from the encoder and the effort command of an experiment's run."""
    described = read_experiment(experiment)
    return identify(
        logged(described), model, axis=axis_of(described), blocks=0, draws=0
    ).finished.best.friction


def logged(described: Experiment) -> Log:
    """Return the log of the first loop of an experiment: the encoder, and the effort command at its time of effect."""
    variant = described.variants[0]
    result = simulate(described).variants[variant.name]
    run = variant.run
    samples = np.arange(result.command.size)
    acting = np.interp(
        samples - run.delay - run.current_lag / run.sample_time, samples, result.command
    )
    signals: dict[str, Any] = {"time": result.time, "position": result.measured, "effort": acting}
    return Log(
        **signals,
        sample_time=run.sample_time,
        segments=(slice(0, samples.size),),
        kind=described.kind,
    )


def axis_of(described: Experiment) -> Axis:
    """Return the axis of an experiment, before the identification of a log."""
    variant = described.variants[0]
    treated = {"cutoff": 15.0, "decimation": 33}  # [Hz], samples: the compensated motion is slow
    resolution = variant.sensor.values["resolution"]
    return Axis(
        kind=described.kind,
        mass=variant.plant.values["M"],
        held=True,
        resolution=resolution,
        **treated,
    )
