"""Axes that motions are designed for."""

from bristle.core import Axis

STAGE = Axis(
    name="stage",
    presliding=7e-6,
    resolution=0.125e-6,
    sample_time=1e-3,
    mass=28.0,
    effort_limit=700.0,
    velocity_limit=0.3,
    acceleration_limit=3.0,
    jerk_limit=5000.0,
    stroke=(-0.1, 0.2),
)
