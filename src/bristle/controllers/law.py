"""One sample of a sampled loop: what a drive is commanded, from where the axis should be and where it is."""

from bristle.core.dispatch import controller_step
from bristle.core.kernel import kernel


@kernel
def law(state, reference, measured, injected, limit, dt, p):
    """Return the command [N or N*m] of a controller, and its state after the sample.

    `reference` carries what is fed forward, `injected` is added to what the controller gives; the sum is kept between
    plus and minus `limit`.
    """
    effort, state = controller_step(state, reference, measured, dt, p)
    return max(-limit, min(limit, effort + injected)), state
