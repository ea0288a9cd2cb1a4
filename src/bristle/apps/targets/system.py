r"""An axis with its friction, or friction alone, as a system of python-control, and describing functions of friction.

A describing function is the first harmonic of the force over a sinusoidal position,

.. math::
    N(A, \omega) = \frac{1}{\pi A} \int_0^{2\pi} F\!\left(A \sin\theta\right)\,
        \left(\sin\theta + j\cos\theta\right) d\theta

of the settled loop, at :math:`\theta = \omega t`. The real part is a stiffness, the imaginary part dissipates.
Coulomb friction has :math:`N = 4jF_C/(\pi A)`. A loop around friction oscillates by harmonic balance where
:math:`H(j\omega)\,N(A, \omega) = -1`, with `H` from the friction force to the position.
"""

import numpy as np

from bristle.core import (
    Amount,
    InputError,
    MissingExtraError,
    Model,
    Variable,
    amount,
    factor,
    guarded,
    unit_of,
)
from bristle.engine import FRICTION, contact_step, response, system_of

try:
    from control import DescribingFunctionNonlinearity, NonlinearIOSystem
except ImportError as error:
    raise MissingExtraError.of(
        "a system of python-control, or a describing function", "control"
    ) from error


class FrictionSystem(NonlinearIOSystem):
    """A system of python-control from `to_control`, with the units of its signals.

    Attributes
    ----------
    units : dict of str to str
        SI unit of each input, output and state.
    friction, plant : Model
        Models of the system; `plant` is None for friction alone.
    """

    units: dict[str, str]
    friction: Model
    plant: Model | None

    def __str__(self) -> str:
        # python-control would print meaningless addresses of functions.
        signals = {
            "Inputs": self.input_labels,
            "Outputs": self.output_labels,
            "States": self.state_labels,
        }
        units = {name: f"{name} [{unit}]" for name, unit in self.units.items()}
        named = {
            head: [units.get(name, str(name)) for name in names] for head, names in signals.items()
        }
        lines = [f"{head}: {', '.join(names)}" for head, names in named.items()]
        time = "differential equation"
        if self.dt != 0:
            time = f"sampled every {self.dt:g} s"
        on = ""
        if self.plant is not None:
            on = f" on {self.plant}"
        return "\n".join([f"{self.name}: {self.friction}{on}, {time}", *lines])


def to_control(
    friction: Model,
    plant: Model | None = None,
    *,
    dt: Amount | None = None,
    steps: int = 1,
    name: str | None = None,
) -> FrictionSystem:
    r"""Return an axis with its friction, or friction alone, as a nonlinear system of python-control.

    With a plant, the input is the effort, and the outputs are position, velocity and friction force,

    .. math:: M \ddot x = u - F(x, \dot x, z), \qquad \dot z = g(\dot x, z)

    for an inertia. Without a plant, the input is the velocity, and the output is the friction force.

    Parameters
    ----------
    friction : Model
        A friction model with parameters.
    plant : Model, optional
        Plant with this friction, such as ``plants.inertia(M="28 kg")`` or the ``plant`` of an identification.
    dt : float or str, optional
        Sample time [s] of a sampled system, for every model. Without it, the system is a differential equation. This
        needs a model with a ``rate`` (`dahl`, `bouc_wen`, `bouc_wen_classic`, `lugre`, `elastoplastic`), or a map
        without a jump at rest (`viscous`).
    steps : int
        Integration steps in a sample, with a plant.
    name : str, optional
        Name in python-control; the name of the model by default.

    Returns
    -------
    FrictionSystem
        A ``control.NonlinearIOSystem`` with named signals and their `units`. Its state contains the whole state of axis
        and friction, relative to a virgin contact at rest, which is zero. Its functions have no hidden state, so that
        they can be called in any order. The outputs of a sampled system are identical to those of `run_open_loop` and
        `force_along`: position and velocity at the sample, and the mean friction force until the next sample. Load and
        temperature have their nominal values.

    Raises
    ------
    InputError
        If no `dt` is given and the model is not a differential equation; if plant and friction have different kinds of
        axis; if the plant has a table behind a screw.
    MissingExtraError
        If python-control is not installed.

    Examples
    --------
    >>> from bristle import friction, plants
    >>> lugre = friction.lugre(F_C="20 N", F_S="28 N", v_S="2 mm/s", sigma_0="10 N/um", sigma_1="1 kN*s/m")
    >>> axis = to_control(lugre, plants.inertia(M="28 kg"))
    >>> axis.state_labels, axis.units["velocity"]
    (['position', 'velocity', 'z'], 'm/s')
    """
    described = system_of(friction, plant, dt, steps, name, asked_by="to_control")
    signals = {
        "inputs": list(described.inputs),
        "outputs": list(described.outputs),
        "states": list(described.states),
    }
    system = FrictionSystem(
        described.following, described.output, name=described.name, dt=described.dt, **signals
    )
    system.friction = friction
    system.plant = plant
    system.units = described.states | described.inputs | described.outputs
    return system


SAMPLES = 2000  # in a cycle; with 4 as a factor, the turns of the path are samples
CYCLES = 4
MOST_CYCLES = 512
SETTLED = 1e-6  # relative change of the harmonic from cycle to cycle
FREQUENCY = amount(Variable("frequency", "frequency", min=0.0), exclusive=True)


@guarded(friction=FRICTION, frequency=FREQUENCY)
class DescribingFunction(DescribingFunctionNonlinearity):
    """The describing function of a friction model over the amplitude of its position, memory included.

    It serves as the nonlinearity of `control.describing_function`, `control.describing_function_response` and
    `control.describing_function_plot`.

    Parameters
    ----------
    friction : Model
        A friction model with parameters. If its force differs by direction, the first harmonic omits the mean force.
    frequency : float or str
        Frequency of the motion [Hz], or text with a unit. It has no influence on rate-independent friction, such as
        `coulomb`, `dahl` and `maxwell_slip`. For other models, give the frequency of the predicted oscillation.
    unit : str, optional
        Unit of the amplitude, such as ``"um"``; m or rad by default. python-control compares amplitudes with fixed
        tolerances, so that they should be near 1: for micrometres, use ``"um"``, and `H` in um/N.

    Notes
    -----
    The path is linear between 2000 samples of a cycle, with a relative error of about 1e-5. The motion begins with a
    virgin contact, and continues until the harmonic changes by less than 1e-6 of its value in a cycle.

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
        self.friction = friction
        self.frequency = frequency
        length = unit_of("length", friction.kind)
        self.unit = unit or length
        self._scale = factor(self.unit, length, path="unit")
        self._dt = 1.0 / (SAMPLES * frequency)
        self._step = contact_step(friction, self._dt)
        p = friction.parameters
        component = friction.component
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
        amplitude = float(A) * self._scale
        cycles = CYCLES
        if not 0.0 < amplitude < np.inf:
            raise InputError("must be positive", path="A", value=A, allowed=f"> 0 {self.unit}")
        # The same phases for each cycle, so that all cycles have an identical path.
        phase = 2.0 * np.pi * np.arange(SAMPLES + 1) / SAMPLES
        # Each force is the mean of a step: integrate its factor over that step.
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
            mend="Run bristle.check(model): the model may drift",
        )

    def __call__(self, A: float) -> float:
        """Return the mean force [N or N*m] on the way from the last position, as python-control asks sample by sample."""
        force, self._state = self._step(
            self._state, (float(A) * self._scale - self._state[0]) / self._dt
        )
        return force
