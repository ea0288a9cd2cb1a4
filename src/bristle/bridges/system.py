r"""An axis with its friction, or friction alone, as a system of python-control; and the describing functions of friction.

A describing function is the first harmonic of the force over a position that moves as a sine,

.. math::
    N(A, \omega) = \frac{1}{\pi A} \int_0^{2\pi} F\!\left(A \sin\theta\right)\,
        \left(\sin\theta + j\cos\theta\right) d\theta

of the loop that has settled, at :math:`\theta = \omega t`. The real part is a stiffness, the imaginary part dissipates.
Coulomb friction has :math:`N = 4jF_C/(\pi A)`. A loop around friction oscillates by harmonic balance where
:math:`H(j\omega)\,N(A, \omega) = -1`, with `H` from the friction force to the position that gives way to it.
"""

import numpy as np

from bristle.core import TEXT, Amount, InputError, MissingExtraError, Model, Variable, amount, factor, guarded, optional, unit_of
from bristle.engine import FRICTION, contact_step, response, system_of

try:
    from control import DescribingFunctionNonlinearity, NonlinearIOSystem
except ImportError as error:
    raise MissingExtraError.of("a system of python-control, or a describing function", "control") from error


class FrictionSystem(NonlinearIOSystem):
    """A system of python-control that `to_control` made, which tells the unit of each of its signals.

    Attributes
    ----------
    units : dict of str to str
        SI unit of each input, output and state.
    friction, plant : Model
        What it was made of; `plant` is None for friction alone.
    """

    units: dict[str, str]
    friction: Model
    plant: Model | None

    def __str__(self) -> str:
        # python-control would print functions that tell nobody anything.
        signals = {"Inputs": self.input_labels, "Outputs": self.output_labels, "States": self.state_labels}
        units = self.units
        named = {head: [f"{name} [{units[name]}]" if name in units else name for name in names] for head, names in signals.items()}
        lines = [f"{head}: {', '.join(names)}" for head, names in named.items()]
        time = "differential equation" if self.dt == 0 else f"sampled every {self.dt:g} s"
        on = f" on {self.plant}" if self.plant is not None else ""
        return "\n".join([f"{self.name}: {self.friction}{on}, {time}", *lines])


def to_control(
    friction: Model, plant: Model | None = None, *, dt: Amount | None = None, steps: int = 1, name: str | None = None
) -> FrictionSystem:
    r"""Return an axis with its friction, or friction alone, as a nonlinear system of python-control.

    With a plant: in goes the effort, out come position, velocity and friction force,

    .. math:: M \ddot x = u - F(x, \dot x, z), \qquad \dot z = g(\dot x, z)

    for an inertia. Without one: in goes a velocity, out comes the friction force.

    Parameters
    ----------
    friction : Model
        A friction model with parameters.
    plant : Model, optional
        What it acts on, such as ``plants.inertia(M="28 kg")``, or the ``plant`` of an identification.
    dt : float or str, optional
        Sample time [s]: a sampled system, for every model. Without it a differential equation, for a model that is one:
        one with a ``rate`` (`dahl`, `bouc_wen`, `bouc_wen_classic`, `lugre`, `elastoplastic`), or a map without a jump
        at rest (`viscous`).
    steps : int
        Integration steps in a sample, with a plant.
    name : str, optional
        What python-control calls it; the name of the model where not given.

    Returns
    -------
    FrictionSystem
        A ``control.NonlinearIOSystem`` with named signals and their `units`. Its state is all that axis and friction
        remember; zero is a virgin contact at rest, and what is another number there is counted from it. Its functions
        keep nothing, so that they may be called in any order. Sampled, its values are those of `run_open_loop` and of
        `force_along`, to the bit: position and velocity at the sample, the mean friction force until the next one.
        Load and temperature are the nominal ones.

    Raises
    ------
    InputError
        If the model is no differential equation and no `dt` is given, with the reason; if plant and friction are of
        different kinds of axis; if the plant has a table behind a screw.
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
    signals = {"inputs": list(described.inputs), "outputs": list(described.outputs), "states": list(described.states)}
    system = FrictionSystem(described.following, described.output, name=described.name, dt=described.dt, **signals)
    system.friction, system.plant = friction, plant
    system.units = described.states | described.inputs | described.outputs
    return system


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
