"""What every run of components is checked for: what comes in, and that what comes out is finite."""

import numpy as np

from bristle.core.contracts import Model
from bristle.core.edge import amount, instance, is_finite, model, optional, whole
from bristle.core.errors import InputError
from bristle.core.variable import Variable

FRICTION, OPERATOR = model("friction"), model("hysteresis")  # take a friction model, or an operator, with parameters
PERIOD = amount(Variable("time", "time step", min=0.0), exclusive=True)  # takes a time step [s]
PLACE, SPEED = amount(Variable("length", "position")), amount(Variable("length/time", "velocity"))
STEPS = whole(1, 10**6)  # takes a number of steps
STATE = optional(instance(tuple, "the state of the model", "Take it from the trace of another run"))


def check_run(count: int, **signals: np.ndarray) -> None:
    """Refuse signals that compiled code would read beyond their end."""
    for name, signal in signals.items():
        if signal.shape != (count,):
            raise InputError("has the wrong length", path=name, value=np.shape(signal), allowed=f"shape ({count},)")


def finite(output: np.ndarray, model: Model, path: str = "model") -> np.ndarray:
    """Return what a model put out along a motion that is known to be finite."""
    if not is_finite(output):
        place = int(np.argwhere(~np.isfinite(output))[0][-1])
        raise InputError(
            f"{model.name} gives no finite number at sample {place} of a finite motion",
            path=path,
            mend="Look at its parameters; of a model of your own at its trial, too",
        )
    return output
