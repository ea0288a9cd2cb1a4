"""Checks of every run of components: valid arguments, and finite results."""

import numpy as np

from bristle.core import InputError, Model, Variable
from bristle.core.edge import amount, instance, is_finite, model, optional, whole

# Converters to a friction model and to a hysteresis operator.
FRICTION, OPERATOR = (model("friction"), model("hysteresis"))
PERIOD = amount(Variable("time", "time step", min=0.0), exclusive=True)  # accepts a time step [s]
PLACE, SPEED = amount(Variable("length", "position")), amount(Variable("length/time", "velocity"))
STEPS = whole(1, 10**6)  # accepts a number of steps
STATE = optional(
    instance(tuple, "the state of the model", "Take the state from the trace of another run")
)


def check_run(count: int, **signals: np.ndarray) -> None:
    """Refuse signals that compiled code would read beyond their end."""
    for name, signal in signals.items():
        if signal.shape != (count,):
            raise InputError(
                "has the wrong length",
                path=name,
                value=np.shape(signal),
                allowed=f"shape ({count},)",
            )


def finite(output: np.ndarray, model: Model, path: str = "model") -> np.ndarray:
    """Return the output of a model along a finite motion; refuse an output that is not finite."""
    if not is_finite(output):
        place = int(np.argwhere(~np.isfinite(output))[0][-1])
        raise InputError(
            f"the output of {model.name} is not finite at sample {place} of a finite motion",
            path=path,
            mend="Check the parameters of the model; for a model of your own, also check its function trial",
        )
    return output
