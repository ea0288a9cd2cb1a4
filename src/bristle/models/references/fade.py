"""Smooth rise of an amplitude from zero, by a quintic."""

import numpy as np


def fade(t: np.ndarray, ramp: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return a factor that rises from 0 to 1 over `ramp` seconds, and its two derivatives; 1 throughout for no ramp."""
    if ramp <= 0.0:
        return np.ones_like(t), np.zeros_like(t), np.zeros_like(t)
    # A quintic: the factor, its first and its second derivative begin and end at rest.
    r = np.clip(t / ramp, 0.0, 1.0)
    inside = (t < ramp).astype(float)
    return (
        r**3 * (10.0 - 15.0 * r + 6.0 * r**2),
        inside * 30.0 * r**2 * (1.0 - r) ** 2 / ramp,
        inside * 60.0 * r * (1.0 - r) * (1.0 - 2.0 * r) / ramp**2,
    )
