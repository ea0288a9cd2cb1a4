"""Elements of an irregular contact: shares of the force, and distances after which they break away."""

import numpy as np


def spectrum(count: int, distance: float, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return shares and break-away distances [m or rad] of an irregular contact, broken away after `distance`."""
    r = distance * np.linspace(0.15, 1.0, count) ** 1.6
    strength = (
        (r / distance) ** -0.75
        * np.exp(0.35 * np.random.default_rng(seed).standard_normal(count))
        * r
    )
    return strength / strength.sum(), r
