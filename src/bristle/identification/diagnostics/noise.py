"""What noise of the position, and half a sample between the channels, do to a fit."""

from __future__ import annotations

from collections.abc import Sequence

from bristle.core.diagnostic import Diagnostic
from bristle.identification.inverse_dynamics import InverseDynamics
from bristle.identification.result import Estimate
from bristle.identification.roles import Role, name_of
from bristle.identification.settings import Settings

__all__ = ["about_held_effort", "about_noise"]

FALLS_WITH = 5.0  # power of the cut-off that the noise of the acceleration grows with
MENDED = 0.1  # of the share of noise that is told


def about_held_effort(
    problem: InverseDynamics, estimates: Sequence[Estimate], settings: Settings
) -> tuple[Diagnostic, ...]:  # fmt: skip
    """Return a warning where half a sample between effort and position decides on the damping of the bristles."""
    dataset, variables = problem.dataset, problem.parameters.variables
    identified = [
        estimate
        for estimate in estimates
        if estimate.status == "identified" and variables[estimate.name].excitation == "presliding"
    ]
    stiffness = max(
        (estimate.value for estimate in identified if variables[estimate.name].quantity == "force/length"), default=0.0
    )
    shift = 0.5 * dataset.sample_time * stiffness
    touched = tuple(
        estimate.name
        for estimate in identified
        if variables[estimate.name].quantity == "force*time/length"
        and shift > settings.half_sample_damping * abs(estimate.value)
    )
    if dataset.held is not None or not touched:
        return ()
    return (
        Diagnostic("half-sample", touched[0], "warning", {"names": touched, "shift": shift}, dataset.kind),
    )  # fmt: skip


def about_noise(problem: InverseDynamics, settings: Settings) -> tuple[Diagnostic, ...]:
    """Return a warning where noise of the position makes the inertia too small."""
    dataset, least = problem.dataset, settings.acceleration_noise
    share = dataset.acceleration_noise_share
    inertia = name_of(Role.INERTIA, problem.parameters.plant.variables)
    if inertia not in problem.parameters.free or share < least:
        return ()
    enough = dataset.bandwidth * (MENDED * least / share) ** (1.0 / FALLS_WITH)
    return (Diagnostic("noisy-acceleration", inertia, "warning", {"percent": 100.0 * share, "cutoff": enough}),)
