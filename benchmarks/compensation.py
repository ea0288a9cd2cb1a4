"""Controllers and compensators past the paper, side by side: ``python -m benchmarks.compensation``.

Following error peak to peak [µm], mean of six runs, on the virtual rig: sets A and B at 0.25 Hz over 26 s, set A at 1,
2 and 4 Hz over 8 s, after 2 s of settling. Beside each number stands that of an earlier study with another program, and
by how much both differ.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path

EARLIER = {
    "past_a": {
        "none": 1.42,
        "mismatched": 0.66,
        "mismatched_measured": 0.70,
        "fitted": 0.48,
        "fitted_measured": 0.43,
        "pd": 1.50,
        "pd_mismatched": 0.70,
        "observer": 0.37,
        "observer_mismatched": 0.34,
        "super_twisting": 0.65,
        "super_twisting_slow": 1.98,
        "super_twisting_slow_mismatched": 0.57,
        "learning": 0.38,
    },
    "past_b": {
        "none": 1.52,
        "mismatched": 0.76,
        "mismatched_measured": 0.76,
        "fitted": 0.77,
        "fitted_measured": 0.73,
        "pd": 1.59,
        "pd_mismatched": 0.72,
        "observer": 0.68,
        "observer_mismatched": 0.65,
        "super_twisting": 0.97,
        "super_twisting_slow": 2.24,
        "super_twisting_slow_mismatched": 0.60,
        "learning": 0.67,
    },
    "faster_a": {
        "observer_1hz": 0.49,
        "observer_2hz": 0.65,
        "observer_4hz": 0.91,
        "fitted_1hz": 0.40,
        "fitted_2hz": 0.42,
        "fitted_4hz": 0.43,
        "observer_feedforward_1hz": 0.34,
        "observer_feedforward_2hz": 0.35,
        "observer_feedforward_4hz": 0.40,
        "observer_mismatched_1hz": 0.37,
        "observer_mismatched_2hz": 0.44,
        "observer_mismatched_4hz": 0.53,
    },
    "low_gain": {"desired": 6.8, "measured": 14.3},
}
WITHIN = 12.0  # percent


def file_of(name: str) -> Path:
    """Return an experiment file of this benchmark, or of the paper."""
    own = Path(__file__).parent / "experiments" / f"{name}.toml"
    return (
        own if own.exists() else Path(str(files("bristle.apps.paper"))) / "experiments" / own.name
    )


def rows() -> Iterator[tuple[str, str, float, float]]:
    """Yield experiment, variant, following error and that of the earlier study, both in micrometres."""
    from bristle.files.experiment import read_experiment
    from bristle.simulation import simulate

    for name, earlier in EARLIER.items():
        result = simulate(read_experiment(file_of(name)))
        for variant, before in earlier.items():
            yield name, variant, 1e6 * result.variants[variant].following_error.peak_to_peak, before


def main() -> int:
    """Print the table; exit code 1 if a number differs by more than 12 percent."""
    print(f"{'experiment':<12} {'variant':<32} {'µm':>7} {'earlier':>8} {'%':>7}")
    apart = 0
    for name, variant, now, before in rows():
        change = 100.0 * (now / before - 1.0)
        apart += abs(change) > WITHIN
        print(f"{name:<12} {variant:<32} {now:>7.3f} {before:>8.2f} {change:>+7.1f}", flush=True)
    return 1 if apart else 0


if __name__ == "__main__":
    sys.exit(main())
