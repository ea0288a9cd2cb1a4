"""What the literature sets against friction, side by side at one bandwidth: ``python -m benchmarks.baselines``.

Following error peak to peak and effort of each variant of ``baselines.toml``, mean and standard deviation of six runs
of 28 s, the smallest phase margin of its linear loops, and how long the law that learns takes, from weights of zero,
until the worst period from then on is within 15 percent of that of the compensator that was identified beforehand.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from importlib.resources import files

import numpy as np

LAW, IDENTIFIED = "adaptive_hysteresis", "maxwell_slip_feedforward"
# [s], one of the motion; share of the error of the compensator that was identified
PERIOD, NEAR = (4.0, 1.15)


def errors_by_period(outcome) -> np.ndarray:
    """Return the following error of each period, peak to peak [m]."""
    error = outcome.reference - outcome.measured
    count = round(outcome.time[-1] / PERIOD)
    masks = [(outcome.time >= PERIOD * k) & (outcome.time < PERIOD * (k + 1)) for k in range(count)]
    return np.array([np.ptp(error[mask]) for mask in masks])


def learning_time(variants) -> tuple[float, np.ndarray]:
    """Return from when on the law that learns is near the compensator that was identified [s], and both by period."""
    both = np.array([errors_by_period(variants[name]) for name in (LAW, IDENTIFIED)])
    worst = np.maximum.accumulate(both[:, ::-1], axis=1)[:, ::-1]  # from each period on
    near = worst[0] <= NEAR * worst[1]
    return PERIOD * (int(np.argmax(near)) if np.any(near) else near.size), both


def main() -> int:
    """Print the table; exit code 1 if observer and feedforward together are not the best of them."""
    from bristle.apps.design import runnable
    from bristle.files.experiment import read_experiment
    from bristle.simulation import simulate

    experiment = read_experiment(files("bristle.apps.paper") / "experiments" / "baselines.toml")
    margins = {
        name: min(
            (p.margins.phase for p in judged.points if p.margins.phase is not None), default=np.nan
        )
        for name, judged in runnable(experiment)[1].items()
    }
    result = simulate(experiment)
    print(f"{'variant':<26} {'µm':>7} {'±':>7} {'effort, N rms':>14} {'phase margin, °':>16}")
    errors = {}
    for name, outcome in result.variants.items():
        errors[name] = outcome.following_error.peak_to_peak
        spread, effort, margin = (
            outcome.spread["following_error"]["peak_to_peak"],
            outcome.effort_rms,
            margins[name],
        )
        print(
            f"{name:<26} {1e6 * errors[name]:>7.3f} {1e6 * spread:>7.3f} {effort:>14.1f} {margin:>16.1f}",
            flush=True,
        )
    chosen = [v for v in experiment.variants if v.name in (LAW, IDENTIFIED)]
    whole = tuple(replace(v, run=replace(v.run, settle=0.0, seeds=1)) for v in chosen)
    start, both = learning_time(simulate(replace(experiment, variants=whole)).variants)
    print(f"error of each period, learned:    {', '.join(f'{1e6 * e:.2f}' for e in both[0])} µm")
    print(f"error of each period, identified: {', '.join(f'{1e6 * e:.2f}' for e in both[1])} µm")
    print(f"from {start:.0f} s on, the learned law is within 15 % of the identified compensator")
    return 0 if min(errors, key=lambda name: errors[name]) == "observer_and_feedforward" else 1


if __name__ == "__main__":
    sys.exit(main())
