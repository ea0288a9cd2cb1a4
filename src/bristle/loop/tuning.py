r"""Gains for a loop: as high as its delay allows, none higher than its encoder stands.

Each law has one number that all its gains follow from, the bandwidth :math:`\omega`:

=================== ======================================================================================
cascade             :math:`k_v = M\omega,\ k_p = \omega/4,\ k_i = k_v\,\omega/10` where it has an integral
sliding mode        :math:`\lambda = \omega,\ K_1 = \tfrac23\omega,\ K_2/\phi = \tfrac13\omega`; :math:`\phi` is
                    what one count of the encoder makes of the surface, so that no count leaves the layer
disturbance         :math:`\lambda = K_1 = \omega,\ g = \omega/5`
observer
=================== ======================================================================================

:math:`\omega` is the largest with which the exact sampled loop keeps a phase margin of 40 degrees and a factor of two
on its gain. With 0.5 ms more lag of the current loop than is stated, 30 degrees and the same factor must be left. No
current loop is without a lag: where none is stated, the margins must hold from 0.2 to 1 ms. The rule of thumb
:math:`(\lambda + K_1)\,T_\text{tot} \lesssim \tfrac12` is close to that.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from bristle.controllers import CONTROLLERS
from bristle.core.contracts import Model, Reference, make_model
from bristle.core.experiment import Experiment, Variant
from bristle.core.least_squares import unbounded
from bristle.core.status import Status
from bristle.loop.assessment import Assessment, Verdict, assess, law_stiffness
from bristle.loop.linear_system import GAIN_ENOUGH, HALVINGS, LARGE, PHASE_ENOUGH, SMALL, SampledLoop, linear_law, linear_plant, margins_of
from bristle.simulation import Statistics, simulate

PHASE = 40.0  # margin that the loop is to keep [deg]
UNSTATED = (2e-4, 1e-3)  # lags of a current loop that nobody stated: the least and the largest [s]
WIDEST, NARROWEST = 3.0, 1e-4  # bandwidths that are tried, in 1/sample time
RUNS_MAX = 2  # simulations of each loop
AS_IT_IS, TUNED, OBSERVER = "as it is", "tuned", "with an observer"
ALONG_DESIRED = "along the desired motion"
POINTS = 40  # of the fit of a lag

Gains = Callable[[float, Mapping[str, Any], Variant], dict[str, Any]]


class Tuned(NamedTuple):
    """A control law, and the bandwidth that its gains follow from [rad/s]."""

    law: Model
    bandwidth: float


def tuned(variant: Variant, name: str, bandwidth: float | None = None) -> Tuned | None:
    """Return a law with the gains that a loop allows it, of a `bandwidth` [rad/s] at most; None where none are known."""
    if name not in GAINS:
        return None

    def law(omega: float) -> Model:
        component = CONTROLLERS[name]
        own = {key: value for key, value in variant.controller.values.items() if key in component.variables}
        fixed = {"J": inertia_of(variant)} | own if "J" in component.variables else own
        return make_model(component, fixed | GAINS[name](omega, fixed, variant), kind=variant.plant.kind, validate=True)

    run = variant.run
    # No current loop is without a lag: each lag [s] with the phase margin [deg] that the loop must keep there.
    stated = run.current_lag
    # More lag than is stated, at which the usual phase margin is left [s].
    lags = ((stated, PHASE), (stated + 5e-4, PHASE_ENOUGH)) if stated > 0.0 else tuple((lag, PHASE) for lag in UNSTATED)
    plants = [(amplitude, phase, linear_plant(lagging(variant, lag), amplitude)) for lag, phase in lags for amplitude in (SMALL, LARGE)]

    def keeps_margins(omega: float) -> bool:
        controllers = {amplitude: linear_law(law(omega), run.sample_time, amplitude) for amplitude in (SMALL, LARGE)}
        for amplitude, phase, plant in plants:
            loop = SampledLoop(plant, controllers[amplitude], run.delay, run.sample_time)
            if loop.is_unstable:
                return False
            margins = margins_of(loop)
            if margins.phase is None or margins.phase < phase or (margins.gain is not None and margins.gain < GAIN_ENOUGH):
                return False
        return True

    if bandwidth is not None and keeps_margins(bandwidth):
        return Tuned(law(bandwidth), bandwidth)
    widest = _widest(keeps_margins, 1.0 / run.sample_time, bandwidth)
    return None if widest is None else Tuned(law(widest), widest)


def lagging(variant: Variant, lag: float) -> Variant:
    """Return a loop with another lag of its current control [s]."""
    return replace(variant, run=replace(variant.run, current_lag=lag))


def _widest(keeps: Callable[[float], bool], rate: float, most: float | None) -> float | None:
    """Return the largest bandwidth that keeps the margins, found from above, to two digits."""
    high = WIDEST * rate if most is None else min(WIDEST * rate, most)
    while not keeps(high / 1.25):
        high /= 1.25
        if high < NARROWEST * rate:
            return None
    low = high / 1.25
    for _ in range(HALVINGS):
        if _rounded_down(low) == _rounded_down(high):
            break
        middle = math.sqrt(low * high)
        low, high = (middle, high) if keeps(middle) else (low, middle)
    return _rounded_down(low)


def _rounded_down(value: float) -> float:
    """Return a number to two digits."""
    step = 10.0 ** (math.floor(math.log10(value)) - 1)
    return step * math.floor(value / step)


def _cascade(bandwidth: float, fixed: Mapping[str, Any], variant: Variant) -> dict[str, Any]:
    k_v = inertia_of(variant) * bandwidth
    integral = fixed.get("k_i", 0.0) > 0.0
    return {"k_v": k_v, "k_p": 0.25 * bandwidth, "k_i": 0.1 * k_v * bandwidth if integral else 0.0}


def _sliding_mode(bandwidth: float, fixed: Mapping[str, Any], variant: Variant) -> dict[str, Any]:
    if fixed.get("K_2", 0.0) == 0.0:
        return {"lambda_": bandwidth, "K_1": bandwidth}
    count, dt = variant.sensor.values.get("resolution", 0.0), variant.run.sample_time
    # With these gains the effort of the law is the velocity that it estimates.
    estimate = dict(fixed, J=1.0, lambda_=0.0, K_1=1.0, K_2=0.0)
    bare = make_model(CONTROLLERS["sliding_mode"], estimate, kind=variant.plant.kind, validate=True)
    surface = count * (bandwidth + float(np.max(np.abs(_step_response(bare, dt)))))
    phi = max(surface, fixed.get("phi", 0.0))
    return {"lambda_": bandwidth, "K_1": bandwidth / 1.5, "K_2": phi * bandwidth / 3.0, "phi": phi}


GAINS: dict[str, Gains] = {
    "cascade": _cascade,
    "sliding_mode": _sliding_mode,
    "disturbance_observer": lambda bandwidth, fixed, variant: {"lambda_": bandwidth, "K_1": bandwidth, "g": 0.2 * bandwidth},
}


def inertia_of(variant: Variant) -> float:
    """Return the mass or inertia that the effort moves, as it shows well below the sample rate [kg or kg*m^2]."""
    run = variant.run
    plant = linear_plant(variant, LARGE)
    omega = 1e-2 / run.sample_time
    return float(1.0 / (omega**2 * np.abs(plant.response(np.exp([1j * omega * run.sample_time]))[0])))


def count_response(variant: Variant) -> float:
    """Return the effort that one count of the encoder calls up, at its peak [N or N*m]."""
    count = variant.sensor.values.get("resolution", 0.0)
    return float(count * np.max(np.abs(_step_response(variant.controller, variant.run.sample_time, SMALL))))


def _step_response(controller: Model, dt: float, amplitude: float = LARGE) -> np.ndarray:
    """Return the effort of a law after the position has stepped by 1, shape (50,)."""
    law = linear_law(controller, dt, amplitude)
    state, outputs = np.zeros(law.B.size), []
    for _ in range(50):
        outputs.append(law.C @ state + law.D)
        state = law.A @ state + law.B
    return np.array(outputs)


class Delays(NamedTuple):
    r"""The parts of the delay of a loop [s].

    A held effort lags by half a sample, the computation by whole ones, the current by its time constant, and the velocity
    by what it takes to estimate it. To a crossover far below all of them they are one delay, :math:`T_\text{tot}`.
    """

    hold: float
    computation: float
    drive: float
    velocity: float

    @property
    def total(self) -> float:
        """All of them [s]."""
        return sum(self)


def delays_of(variant: Variant) -> Delays:
    r"""Return where the delay of a loop comes from.

    That of the velocity on which a law acts is fitted by :math:`-k_p - k_i/s - k_d s\,e^{-sT}`.
    """
    dt = variant.run.sample_time
    omega = np.geomspace(0.005, 0.05, POINTS) * np.pi / dt
    response = -linear_law(variant.controller, dt, LARGE).response(np.exp(1j * omega * dt))
    # e^{-sT} is 1 - sT there, so that k_d T stands beside the square of the frequency in the real part.
    _, lagging = unbounded(np.stack((np.ones(POINTS), omega**2), axis=1), np.real(response))
    _, k_d = unbounded(np.stack((-1.0 / omega, omega), axis=1), np.imag(response))
    return Delays(0.5 * dt, variant.run.delay * dt, variant.run.current_lag, float(lagging / k_d) if k_d > 0.0 else 0.0)


def feeds_inertia(controller: Model, dt: float) -> bool:
    """Return whether a control law answers the acceleration of its reference by itself."""
    component, p = controller.component, controller.parameters
    efforts = []
    for acceleration in (1e-6, 0.0):
        rest = component.start(0.0, 0.0, 0.0, dt, p)
        efforts.append(component.step(rest, Reference(0.0, 0.0, acceleration, 0.0), 0.0, dt, p)[0])
    return efforts[0] != efforts[1]


def told_the_motion(variant: Variant) -> Variant:
    """Return the loop with velocity and inertia of the desired motion fed forward, where it was not already."""
    controller, feedforward = variant.controller, variant.feedforward
    if controller.values.get("k_ff", 1.0) != 1.0:
        controller = controller.with_values(k_ff=1.0)
    mass = 0.0 if feeds_inertia(controller, variant.run.sample_time) else inertia_of(variant)
    if not math.isclose(mass, feedforward.mass, rel_tol=0.01):
        feedforward = replace(feedforward, mass=mass)
    return replace(variant, controller=controller, feedforward=feedforward)


@dataclass(frozen=True)
class Proposal:
    """A loop that is proposed.

    Parameters
    ----------
    variant : Variant
        The loop, under the name of the proposal.
    assessment : Assessment
        Its poles and margins; with the largest lag of a current loop where none is stated and gains are proposed.
    bandwidth : float or None
        What its gains follow from [rad/s]; None for the loop as it is.
    stiffness : float
        Effort over a deviation that lasts [N/m or N*m/rad].
    count_effort : float
        Effort that one count of the encoder calls up, at its peak [N or N*m].
    following_error : Statistics or None
        Simulated [m or rad]; None where it was not, or diverged.
    effort_rms : float or None
        Of the effort [N or N*m].
    """

    variant: Variant
    assessment: Assessment
    bandwidth: float | None
    stiffness: float
    count_effort: float
    following_error: Statistics | None
    effort_rms: float | None

    @property
    def name(self) -> str:
        """What the proposal is called."""
        return self.variant.name

    @property
    def peak_to_peak(self) -> float:
        """Simulated following error, peak to peak [m or rad]; infinite where there is none."""
        return math.inf if self.following_error is None else self.following_error.peak_to_peak


def proposals_for(
    variant: Variant, *, bandwidth: float | None = None, simulated: bool = True, progress: Callable[[float, str], None] | None = None
) -> tuple[Proposal, ...]:
    """Return the loop as it is and others in its place, the ones that would not diverge simulated.

    Parameters
    ----------
    variant : Variant
        The loop.
    bandwidth : float, optional
        Bandwidth wanted of what is proposed [rad/s]; by default as much as the margins allow.
    simulated : bool
        Whether the loop as it is can be simulated.
    progress : callable, optional
        Called with the share done and the name of what comes next.
    """
    loops, bandwidths = _loops(variant, bandwidth)
    # Gains are proposed for the largest lag of a current loop that nobody stated.
    judged = {
        name: assess(loop if loop.run.current_lag or name not in bandwidths else lagging(loop, UNSTATED[1])) for name, loop in loops.items()
    }
    runs = min(variant.run.seeds, RUNS_MAX)
    able = tuple(
        replace(loop, run=replace(loop.run, seeds=runs))
        for name, loop in loops.items()
        if judged[name].verdict is not Verdict.DIVERGES and (simulated or name != AS_IT_IS)
    )
    outcomes = simulate(Experiment(variant.name, variant.plant.kind, able), progress).variants
    proposals = []
    for name, loop in loops.items():
        outcome = outcomes.get(name)
        completed = None if outcome is None or outcome.status is Status.NOT_FINITE else outcome
        proposal = Proposal(
            loop,
            judged[name],
            bandwidths.get(name),
            law_stiffness(linear_law(loop.controller, loop.run.sample_time, LARGE)),
            count_response(loop),
            completed and completed.following_error,
            completed and completed.effort_rms,
        )
        proposals.append(proposal)
    return tuple(proposals)


def _loops(variant: Variant, bandwidth: float | None) -> tuple[dict[str, Variant], dict[str, float]]:
    """Return the loop as it is and those proposed by name, and the bandwidths of these."""
    desired = replace(variant, feedforward=replace(variant.feedforward, along="desired"), learning=None)
    loops, bandwidths = {AS_IT_IS: variant}, {}
    if variant.feedforward.along != "desired":
        loops[ALONG_DESIRED] = desired
    laws = {TUNED: variant.controller.name, OBSERVER: "disturbance_observer"}
    for name, law in laws.items():
        tuning = None if name == OBSERVER and law == laws[TUNED] else tuned(variant, law, bandwidth)
        if tuning is not None and tuning.law != variant.controller:
            loops[name], bandwidths[name] = told_the_motion(replace(desired, controller=tuning.law)), tuning.bandwidth
    return {name: replace(loop, name=name) for name, loop in loops.items()}, bandwidths
