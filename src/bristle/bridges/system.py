r"""An axis with its friction, or friction alone, as a system of python-control; and the describing functions of friction.

A describing function is the first harmonic of the force over a position that moves as a sine,

.. math::
    N(A, \omega) = \frac{1}{\pi A} \int_0^{2\pi} F\!\left(A \sin\theta\right)\,
        \left(\sin\theta + j\cos\theta\right) d\theta

of the loop that has settled, at :math:`\theta = \omega t`. The real part is a stiffness, the imaginary part dissipates.
Coulomb friction has :math:`N = 4jF_C/(\pi A)`. A loop around friction oscillates by harmonic balance where
:math:`H(j\omega)\,N(A, \omega) = -1`, with `H` from the friction force to the position that gives way to it.
"""

from bristle.core import Amount, MissingExtraError, Model
from bristle.engine import FirstHarmonic, system_of

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
    made = system_of(friction, plant, dt, steps, name, asked_by="to_control")
    signals = {"inputs": list(made.inputs), "outputs": list(made.outputs), "states": list(made.states)}
    system = FrictionSystem(made.following, made.output, name=made.name, dt=made.dt, **signals)
    system.friction, system.plant = friction, plant
    system.units = made.states | made.inputs | made.outputs
    return system


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
        self._harmonic = FirstHarmonic(friction, frequency, unit)
        self.friction, self.frequency, self.unit = self._harmonic.friction, self._harmonic.frequency, self._harmonic.unit

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
        return self._harmonic.over(A)

    def __call__(self, A: float) -> float:
        """Return the mean force [N or N*m] while the contact moves on to a position in a sample of a cycle.

        It moves on from where the last call has left it: python-control calls so, sample by sample, where it computes
        a harmonic itself (``try_method=False, num_points=2000``).
        """
        return self._harmonic.moved_to(A)
