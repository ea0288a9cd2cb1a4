r"""Describing functions of friction: its first harmonic over a position that moves as a sine.

.. math::
    N(A, \omega) = \frac{1}{\pi A} \int_0^{2\pi} F\!\left(A \sin\theta\right)\,
        \left(\sin\theta + j\cos\theta\right) d\theta

of the loop that has settled, at :math:`\theta = \omega t`. The real part is a stiffness, the imaginary part dissipates.
Coulomb friction has :math:`N = 4jF_C/(\pi A)`. A loop around friction oscillates by harmonic balance where
:math:`H(j\omega)\,N(A, \omega) = -1`, with `H` from the friction force to the position that gives way to it.
"""

import numpy as np

from bristle.bridges.equations import contact_step
from bristle.core.contracts import Model
from bristle.core.edge import TEXT, Amount, amount, guarded, optional
from bristle.core.errors import InputError, MissingExtraError
from bristle.core.units import factor
from bristle.core.variable import Variable, unit_of
from bristle.engine.checks import FRICTION
from bristle.engine.motion import response

try:
    from control import DescribingFunctionNonlinearity
except ImportError as error:
    raise MissingExtraError.of("a describing function of python-control", "control") from error

SAMPLES = 2000  # in a cycle; with 4 as a factor, the turns of the path are samples
CYCLES, MOST_CYCLES = 4, 512
SETTLED = 1e-6  # relative change of the harmonic from cycle to cycle
FREQUENCY = amount(Variable("frequency", "frequency", min=0.0), exclusive=True)


@guarded(friction=FRICTION, frequency=FREQUENCY, unit=optional(TEXT))
class DescribingFunction(DescribingFunctionNonlinearity):
    """The describing function of a friction model over the amplitude of its position, memory included.

    What `control.describing_function`, `control.describing_function_response` and `control.describing_function_plot`
    take as their nonlinearity.

    Parameters
    ----------
    friction : Model
        A friction model with parameters. The mean of a force that differs by direction is not in a first harmonic.
    frequency : float or str
        Of the motion [Hz], or text with a unit. Friction of which only the path counts, such as `coulomb`, `dahl` and
        `maxwell_slip`, is the same at every one; for any other, give the frequency that the loop is found to have.
    unit : str, optional
        Unit of the amplitude, such as ``"um"``; m or rad where not given. What python-control compares with fixed
        tolerances should be near 1: for amplitudes of micrometres, give them so, and `H` in um/N.

    Notes
    -----
    The path runs straight between 2000 samples of a cycle, which leaves a relative error of some 1e-5. The motion
    begins with a virgin contact, and goes on until the harmonic changes by less than 1e-6 of itself in a cycle.

    Examples
    --------
    >>> from bristle import friction
    >>> relay = DescribingFunction(friction.coulomb(F_C="20 N"), "5 Hz")
    >>> round(relay.describing_function(0.01).imag / (4 * 20 / (np.pi * 0.01)), 9)
    1.0
    """

    friction: Model
    frequency: float
    unit: str

    def __init__(self, friction: Model, frequency: Amount, unit: str | None = None) -> None:
        super().__init__()
        self.friction, self.frequency = friction, frequency
        length = unit_of("length", friction.kind)
        self.unit = unit or length
        self._scale = factor(self.unit, length, path="unit")
        self._dt = 1.0 / (SAMPLES * frequency)
        self._step = contact_step(friction, self._dt)
        p, component = friction.parameters, friction.component
        self._state = np.zeros(1 + len(component.State._fields) + component.memory_size(p))

    def describing_function(self, A: float) -> complex:
        """Return the first harmonic of the force over the amplitude.

        Parameters
        ----------
        A : float
            Amplitude of the position, in `unit`.

        Returns
        -------
        complex
            Force over position [N or N*m over `unit`]; its imaginary part leads by a quarter of a cycle, as a damper
            does.

        Raises
        ------
        InputError
            If the amplitude is not positive, or the loop does not settle.
        """
        amplitude, cycles = float(A) * self._scale, CYCLES
        if not 0.0 < amplitude < np.inf:
            raise InputError("must be positive", path="A", value=A, allowed=f"> 0 {self.unit}")
        # Phases of one cycle, used again for each: to the bit the same path every time.
        phase = 2.0 * np.pi * np.arange(SAMPLES + 1) / SAMPLES
        # Each force is the mean of a step: what it is multiplied with is integrated over that step.
        weight = -np.diff(np.cos(phase)) + 1j * np.diff(np.sin(phase))
        while cycles <= MOST_CYCLES:
            path = amplitude * np.concatenate((np.tile(np.sin(phase[:-1]), cycles), [0.0]))
            force = response(self.friction, path, self._dt)[1:].reshape(cycles, SAMPLES)
            before, last = (force @ weight / (np.pi * amplitude))[-2:] * self._scale
            if abs(last - before) <= SETTLED * abs(last):
                return complex(last)
            cycles *= 4
        raise InputError(
            f"the loop of {self.friction.name} still changes after {MOST_CYCLES} cycles",
            path="A",
            value=A,
            mend="Look at bristle.check(model): it may drift",
        )

    def __call__(self, A: float) -> float:
        """Return the mean force [N or N*m] while the contact moves on to a position in a sample of a cycle.

        It moves on from where the last call has left it: python-control calls so, sample by sample, where it computes
        a harmonic itself (``try_method=False, num_points=2000``).
        """
        force, self._state = self._step(self._state, (float(A) * self._scale - self._state[0]) / self._dt)
        return force
