"""A sample of a sampled loop: the command of a drive from the desired and the measured position."""

from bristle.core.dispatch import controller_step
from bristle.core.kernel import kernel


@kernel
def law(state, reference, measured, injected, limit, dt, p):
    """Return the command [N or N*m] of a controller, and its state after the sample.

    `reference` has the feedforward, `injected` is added to the output of the controller; the sum is limited to
    plus and minus `limit`.
    """
    effort, state = controller_step(state, reference, measured, dt, p)
    return max(-limit, min(limit, effort + injected)), state
