r"""Friction with memory as a system of Drake.

At each sample :math:`n`, the contact moves to the position :math:`x_n`, and the output is the mean force of the next step,
predicted at the velocity :math:`v_n`, against the motion. A mass below break-away then comes to rest; the mean force of the
*last* step would feed energy into the contact.
"""

from typing import Any

import numpy as np

from bristle.core import Amount, MissingExtraError, Model
from bristle.engine import system_of

try:
    from pydrake.systems.framework import BasicVector, LeafSystem  # pyright: ignore[reportMissingImports]
except ImportError as error:
    raise MissingExtraError.of("a system of Drake", "drake") from error


class DrakeFriction(LeafSystem):
    """Friction of a joint as a ``pydrake.systems.framework.LeafSystem``, with its memory in the discrete state of the context.

    Input ports are ``position`` [m or rad] and ``velocity`` [m/s or rad/s], each of size 1. The output port ``effort``, of
    size 1, is the force of friction on the joint [N or N*m]: connect it to an actuation or a generalized force. The contact is
    virgin at the first position. Load and temperature have their nominal values.

    Parameters
    ----------
    friction : Model
        A friction model with parameters.
    dt : float or str
        Sample time [s]: that of a discrete plant, or a fraction of the period of a joint on the stiffness of the contact.

    Raises
    ------
    InputError
        If `friction` is not a friction model, or `dt` not a time.
    MissingExtraError
        If Drake is not installed.

    Examples
    --------
    >>> from bristle import friction
    >>> contact = DrakeFriction(friction.dahl(F_C="20 N", sigma_0="10 N/um"), "1 ms")
    >>> context = contact.CreateDefaultContext()
    >>> for port, value in zip(("position", "velocity"), (0.0, 0.01)):
    ...     _ = contact.GetInputPort(port).FixValue(context, [value])
    >>> round(float(contact.GetOutputPort("effort").Eval(context)[0]), 2)
    -16.03
    """

    def __init__(self, friction: Model, dt: Amount) -> None:
        LeafSystem.__init__(self)
        self._contact = system_of(friction, None, dt, 1, None, asked_by="DrakeFriction")
        self.set_name(self._contact.name)
        inputs = [self.DeclareVectorInputPort(name, 1) for name in ("position", "velocity")]
        # The first number is 1 after the first sample.
        state = self.DeclareDiscreteState(1 + len(self._contact.states))
        self.DeclarePeriodicDiscreteUpdateEvent(self._contact.dt, 0.0, self._update)
        tickets = {self.discrete_state_ticket(state), *(port.ticket() for port in inputs)}
        self.DeclareVectorOutputPort("effort", 1, self._effort, tickets)

    def _moved(self, context: Any) -> np.ndarray:
        """Return the state of the contact at the current position."""
        begun, *state = context.get_discrete_state_vector().value()
        x = self.EvalVectorInput(context, 0).GetAtIndex(0)
        if not begun:
            return np.array([x, *state[1:]])
        return self._contact.following(0.0, state, ((x - state[0]) / self._contact.dt,), None)

    def _update(self, context: Any, following: Any) -> None:
        following.set_value(np.array([1.0, *self._moved(context)]))

    def _effort(self, context: Any, output: BasicVector) -> None:
        force = self._contact.output(
            0.0, self._moved(context), (self.EvalVectorInput(context, 1).GetAtIndex(0),), None
        )
        output.SetAtIndex(0, -float(force[0]))
