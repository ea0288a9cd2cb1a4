"""Two rigs of another kind: a direct drive on a bearing that remembers, a linear motor on rollers that creep.

Each is an experiment in a file, with loops without and with friction feedforward. `compensated` identifies the
compensators from a log of the same rig, as on a machine: triangles of falling amplitude in the loop without compensation,
position of the encoder and effort command.
"""

import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np

import bristle as br
from bristle.core.errors import InputWarning

HERE = Path(__file__).parent
RIGS = {
    "direct drive, gms": HERE / "direct_drive.toml",
    "linear motor, lugre": HERE / "linear_motor.toml",
}
PRINTED, IDENTIFIED = "(5)–(7) as printed", "identified"


def log_of(experiment):
    """Return the log of the loop `log`, with the effort at its time of effect."""
    loop = next(one for one in experiment.variants if one.name == "log")
    result = br.simulate(replace(experiment, variants=(loop,))).variants["log"]
    samples = np.arange(result.command.size)
    late = loop.run.delay + loop.run.current_lag / loop.run.sample_time
    effort = np.interp(samples - late, samples, result.command)
    columns = {"time": result.time, "position": result.measured, "effort": effort}
    return br.Log.from_columns(columns, kind=experiment.kind)


def compensators(experiment, axis):
    """Return the models of the paper and of bristle, identified from one log of the rig."""
    log = log_of(experiment)
    with warnings.catch_warnings():
        # On the linear motor, which has no loops over the position, the fit ends next to the bound f_p > F_S of (9).
        warnings.simplefilter("ignore", InputWarning)
        printed = br.identify(
            log, "preisach_lugre", axis=axis, blocks=0, draws=0
        ).best.friction.with_values(transition="paper")
    ranked = br.identify(log, "maxwell_slip,lugre,dahl", axis=axis, draws=0)
    return {PRINTED: printed, IDENTIFIED: ranked.best.friction}


def compensated(file):
    """Return the following error peak to peak [m or rad] of each loop of a rig, the effort rms, and the names of the models."""
    experiment = br.read_experiment(file)
    none = next(one for one in experiment.variants if one.name == "none")
    axis = br.Axis(
        kind=experiment.kind,
        mass=none.plant.values["M"],
        held=True,
        resolution=none.sensor.values["resolution"],
    )
    models = compensators(experiment, axis)
    loops = [none] + [
        replace(none, name=name, feedforward=replace(none.feedforward, friction=model))
        for name, model in models.items()
    ]
    result = br.simulate(replace(experiment, variants=tuple(loops)))
    errors = {
        name: (one.following_error.peak_to_peak, one.effort_rms)
        for name, one in result.variants.items()
    }
    return errors, {name: model.name for name, model in models.items()}


if __name__ == "__main__":
    for rig, file in RIGS.items():
        print(rig, *compensated(file), sep="\n  ")
