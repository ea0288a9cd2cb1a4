"""A plant with friction and a drive, from one sample to the next."""

from typing import Any, NamedTuple

from bristle.core.kernel import kernel
from bristle.core.mathematics import expm1, relaxation
from bristle.engine.efim import Start, advance


class Drive(NamedTuple):
    """Effort of a drive [N or N*m], and the remaining share of its distance from a command after a step.

    ``at_end`` is the share at the end of the step, ``in_mean`` its mean over the step.
    """

    effort: float
    at_end: float
    in_mean: float


class Mechanism(NamedTuple):
    """A plant, its friction and its drive, and the start values of the next solve.

    ``slope`` is the slope of the last residual minus 1, divided by the step length [1/s], and ``acceleration`` the mean
    acceleration of the last step; both apply to any step length. ``force`` is the mean friction force [N or N*m] since
    the last sample, ``failures`` the number of failed solves since then.
    """

    plant: Any
    friction: Any
    effort: float
    slope: float
    acceleration: float
    force: float
    failures: float


@kernel
def drive_over(h, effort, lag):
    """Return the `Drive` for steps of length `h` [s]: exact for a constant command; without lag it follows at once."""
    if lag <= 0.0:
        return Drive(effort, 0.0, 0.0)
    rate = h / lag
    return Drive(effort, 1.0 + expm1(-rate), relaxation(rate))


@kernel
def mechanism(before, memory, command, command_end, lag, slack, dt, steps, q, p):
    """Return the `Mechanism` after a time `dt` [s] in `steps` equal steps, with a linear command.

    `lag` [s] is the time constant of the drive, `slack` [m/s or rad/s] the allowed error of the mean velocity in a solve;
    `q` are the parameters of the plant, `p` those of the friction model.
    """
    h = dt / steps
    drive = drive_over(h, before.effort, lag)
    body, s, drive_effort = before.plant, before.friction, before.effort
    slope, acceleration = 1.0 + before.slope * h, before.acceleration
    total, failures = 0.0, 0.0
    for i in range(steps):
        commanded = command + (command_end - command) * ((i + 0.5) / steps)
        u = commanded + drive.in_mean * (drive_effort - commanded)
        drive_effort = commanded + drive.at_end * (drive_effort - commanded)
        guess = 0.0 if body.v == 0.0 else body.v + 0.5 * h * acceleration
        advanced = advance(body, s, memory, u, h, q, p, Start(guess, slope, slack))
        body, s, slope = advanced.plant_state, advanced.friction_state, advanced.slope
        acceleration = 2.0 * (body.v - advanced.v_mean) / h
        total += advanced.force
        failures += advanced.failures
    return Mechanism(
        body, s, drive_effort, (slope - 1.0) / h, acceleration, total / steps, failures
    )
