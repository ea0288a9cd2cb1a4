r"""Gains for a loop, as high as its delay and its encoder allow.

The bandwidth :math:`\omega` determines all gains of each law:

=================== ======================================================================================
cascade             :math:`k_v = M\omega,\ k_p = \omega/4,\ k_i = k_v\,\omega/10` if it has an integral
sliding mode        :math:`\lambda = \omega,\ K_1 = \tfrac23\omega,\ K_2/\phi = \tfrac13\omega`; :math:`\phi` is
                    the effect of one encoder count on the surface, so that counts stay in the layer
disturbance         :math:`\lambda = K_1 = \omega,\ g = \omega/5`
observer
=================== ======================================================================================

:math:`\omega` is the largest bandwidth at which the exact sampled loop has a phase margin of 40 degrees and a gain margin
of two. If the lag of the current loop grows by 0.5 ms, a phase margin of 30 degrees and a gain margin of two must remain.
Every current loop has a lag: if none is given, the margins must hold for lags from 0.2 to 1 ms. The rule of thumb
:math:`(\lambda + K_1)\,T_\text{tot} \lesssim \tfrac12` is close to this limit. If the load is coupled elastically, the
margins are those of two masses, and :math:`\omega` is at most the antiresonance, above which the motor does not move the load.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from bristle.core import Experiment, Status, Variable, Variant, amount, guarded, optional, unbounded
from bristle.core.contracts import Model, make_model
from bristle.models.controllers import CONTROLLERS
from bristle.simulation import Statistics, simulate
from bristle.simulation.assessment import Assessment, Verdict, assess, law_stiffness
from bristle.simulation.linear_system import (
    GAIN_ENOUGH,
    HALVINGS,
    LARGE,
    PHASE_ENOUGH,
    SMALL,
    SampledLoop,
    antiresonance_of,
    linear_law,
    linear_plant,
    margins_of,
    with_two_masses,
)
from bristle.simulation.two_masses import feeds_inertia

PHASE = 40.0  # required phase margin [deg]
UNSTATED = (2e-4, 1e-3)  # assumed lags of an unspecified current loop: smallest and largest [s]
WIDEST = 3.0  # largest trial bandwidth, in 1/sample time
NARROWEST = 1e-4  # smallest trial bandwidth, in 1/sample time
RUNS_MAX = 2  # simulations of each loop
AS_IT_IS = "as it is"
TUNED = "tuned"
OBSERVER = "with an observer"
ALONG_DESIRED = "along the desired motion"
POINTS = 40  # of the fit of a lag

Gains = Callable[[float, Mapping[str, Any], Variant], dict[str, Any]]


class Tuned(NamedTuple):
    """A control law, and the bandwidth behind its gains [rad/s]."""

    law: Model
    bandwidth: float


def tuned(variant: Variant, name: str, bandwidth: float | None = None) -> Tuned | None:
    """Return a law with the gains that a loop allows, up to a `bandwidth` [rad/s]; None for a law without a tuning rule."""
    if name not in GAINS:
        return None

    def law(omega: float) -> Model:
        component = CONTROLLERS[name]
        own = {
            key: value
            for key, value in variant.controller.values.items()
            if key in component.variables
        }
        fixed = own
        if "J" in component.variables:
            fixed = {"J": inertia_of(variant)} | own
        return make_model(
            component,
            fixed | GAINS[name](omega, fixed, variant),
            kind=variant.plant.kind,
            validate=True,
        )

    run = variant.run
    # Every current loop has a lag: each lag [s] with the required phase margin [deg].
    lags = [(lag, PHASE) for lag in UNSTATED]
    stated = run.current_lag
    if stated > 0.0:
        # Additional lag with which the usual phase margin must remain [s].
        lags = [(stated, PHASE), (stated + 5e-4, PHASE_ENOUGH)]
    elastic = with_two_masses(variant)
    plants = [
        (amplitude, phase, linear_plant(lagging(elastic, lag), amplitude))
        for lag, phase in lags
        for amplitude in (SMALL, LARGE)
    ]

    def keeps_margins(omega: float) -> bool:
        if omega > antiresonance_of(elastic):
            return False
        controllers = {
            amplitude: linear_law(law(omega), run.sample_time, amplitude)
            for amplitude in (SMALL, LARGE)
        }
        for amplitude, phase, plant in plants:
            loop = SampledLoop(plant, controllers[amplitude], run.delay, run.sample_time)
            if loop.is_unstable:
                return False
            margins = margins_of(loop)
            if (
                margins.phase is None
                or margins.phase < phase
                or (margins.gain is not None and margins.gain < GAIN_ENOUGH)
            ):
                return False
        return True

    if bandwidth is not None and keeps_margins(bandwidth):
        return Tuned(law(bandwidth), bandwidth)
    widest = _widest(keeps_margins, 1.0 / run.sample_time, bandwidth)
    if widest is None:
        return None
    return Tuned(law(widest), widest)


def lagging(variant: Variant, lag: float) -> Variant:
    """Return a loop with a different lag of its current control [s]."""
    return replace(variant, run=replace(variant.run, current_lag=lag))


def _widest(keeps: Callable[[float], bool], rate: float, most: float | None) -> float | None:
    """Return the largest bandwidth that keeps the margins, searched from above, to two digits."""
    high = WIDEST * rate
    if most is not None:
        high = min(high, most)
    while not keeps(high / 1.25):
        high /= 1.25
        if high < NARROWEST * rate:
            return None
    low = high / 1.25
    for _ in range(HALVINGS):
        if _rounded_down(low) == _rounded_down(high):
            break
        middle = math.sqrt(low * high)
        if keeps(middle):
            low = middle
        else:
            high = middle
    return _rounded_down(low)


def _rounded_down(value: float) -> float:
    """Return a number rounded down to two digits."""
    step = 10.0 ** (math.floor(math.log10(value)) - 1)
    return step * math.floor(value / step)


def _cascade(bandwidth: float, fixed: Mapping[str, Any], variant: Variant) -> dict[str, Any]:
    k_v = inertia_of(variant) * bandwidth
    gains = {"k_v": k_v, "k_p": 0.25 * bandwidth, "k_i": 0.0}
    if fixed.get("k_i", 0.0) > 0.0:
        gains["k_i"] = 0.1 * k_v * bandwidth
    return gains


def _sliding_mode(bandwidth: float, fixed: Mapping[str, Any], variant: Variant) -> dict[str, Any]:
    if fixed.get("K_2", 0.0) == 0.0:
        return {"lambda_": bandwidth, "K_1": bandwidth}
    count = variant.sensor.values.get("resolution", 0.0)
    dt = variant.run.sample_time
    # With these gains the effort of the law equals its estimate of the velocity.
    estimate = dict(fixed, J=1.0, lambda_=0.0, K_1=1.0, K_2=0.0)
    bare = make_model(CONTROLLERS["sliding_mode"], estimate, kind=variant.plant.kind, validate=True)
    surface = count * (bandwidth + float(np.max(np.abs(_step_response(bare, dt)))))
    phi = max(surface, fixed.get("phi", 0.0))
    return {"lambda_": bandwidth, "K_1": bandwidth / 1.5, "K_2": phi * bandwidth / 3.0, "phi": phi}


GAINS: dict[str, Gains] = {
    "cascade": _cascade,
    "sliding_mode": _sliding_mode,
    "disturbance_observer": lambda bandwidth, fixed, variant: {
        "lambda_": bandwidth,
        "K_1": bandwidth,
        "g": 0.2 * bandwidth,
    },
}


def inertia_of(variant: Variant) -> float:
    """Return the mass or inertia that the effort moves, well below the sample rate [kg or kg*m^2]."""
    run = variant.run
    plant = linear_plant(variant, LARGE)
    omega = 1e-2 / run.sample_time
    return float(
        1.0 / (omega**2 * np.abs(plant.response(np.exp([1j * omega * run.sample_time]))[0]))
    )


def count_response(variant: Variant) -> float:
    """Return the peak effort caused by one count of the encoder [N or N*m]."""
    count = variant.sensor.values.get("resolution", 0.0)
    return float(
        count * np.max(np.abs(_step_response(variant.controller, variant.run.sample_time, SMALL)))
    )


def _step_response(controller: Model, dt: float, amplitude: float = LARGE) -> np.ndarray:
    """Return the effort of a law after a unit step of the position, shape (50,)."""
    law = linear_law(controller, dt, amplitude)
    state = np.zeros(law.B.size)
    outputs = []
    for _ in range(50):
        outputs.append(law.C @ state + law.D)
        state = law.A @ state + law.B
    return np.array(outputs)


class Delays(NamedTuple):
    r"""The parts of the delay of a loop [s].

    The zero-order hold of the effort lags by half a sample, the computation by whole samples, the current by its time constant,
    and the velocity by the lag of its estimate. At frequencies far below the inverse of these delays, they act as one delay,
    their sum :math:`T_\text{tot}`.
    """

    hold: float
    computation: float
    drive: float
    velocity: float

    @property
    def total(self) -> float:
        """Sum of all delays [s]."""
        return sum(self)


@guarded()
def delays_of(variant: Variant) -> Delays:
    r"""Return the parts of the delay of a loop.

    The delay of the velocity estimate is fitted by :math:`-k_p - k_i/s - k_d s\,e^{-sT}`.
    """
    dt = variant.run.sample_time
    omega = np.geomspace(0.005, 0.05, POINTS) * np.pi / dt
    response = -linear_law(variant.controller, dt, LARGE).response(np.exp(1j * omega * dt))
    # With e^{-sT} = 1 - sT, the real part contains k_d T times the square of the frequency.
    _, lagging = unbounded(np.stack((np.ones(POINTS), omega**2), axis=1), np.real(response))
    _, k_d = unbounded(np.stack((-1.0 / omega, omega), axis=1), np.imag(response))
    velocity = 0.0
    if k_d > 0.0:
        velocity = float(lagging / k_d)
    return Delays(0.5 * dt, variant.run.delay * dt, variant.run.current_lag, velocity)


def with_known_motion(variant: Variant) -> Variant:
    """Return the loop with velocity and inertia of the desired motion fed forward."""
    controller = variant.controller
    feedforward = variant.feedforward
    if controller.values.get("k_ff", 1.0) != 1.0:
        controller = controller.with_values(k_ff=1.0)
    fed = feedforward.plant
    mass = 0.0
    # A plant with a screw feeds both of its masses forward.
    if (fed is None or fed.component.screw is None) and not feeds_inertia(
        controller, variant.run.sample_time
    ):
        mass = inertia_of(variant)
    if not math.isclose(mass, feedforward.mass, rel_tol=0.01):
        feedforward = replace(feedforward, mass=mass)
    return replace(variant, controller=controller, feedforward=feedforward)


@dataclass(frozen=True)
class Proposal:
    """A proposed loop.

    Parameters
    ----------
    variant : Variant
        The loop, with the name of the proposal.
    assessment : Assessment
        Poles and margins of the loop. If the experiment states no lag of the current loop, proposals with other gains
        use the largest usual lag.
    bandwidth : float or None
        Bandwidth from which the gains follow [rad/s]; None for the present loop.
    stiffness : float
        Effort per constant deviation of the position [N/m or N*m/rad].
    count_effort : float
        Peak effort caused by one count of the encoder [N or N*m].
    following_error : Statistics or None
        Simulated following error [m or rad]; None if the loop was not simulated, or diverged.
    effort_rms : float or None
        Rms of the simulated effort [N or N*m]; None if the loop was not simulated, or diverged.
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
        """Name of the proposal."""
        return self.variant.name

    @property
    def peak_to_peak(self) -> float:
        """Simulated following error, peak to peak [m or rad]; infinite without a simulation."""
        if self.following_error is None:
            return math.inf
        return self.following_error.peak_to_peak


@guarded(bandwidth=optional(amount(Variable("frequency", "bandwidth", min=0.0), exclusive=True)))
def proposals_for(
    variant: Variant,
    *,
    bandwidth: float | None = None,
    simulated: bool = True,
    progress: Callable[[float, str], None] | None = None,
) -> tuple[Proposal, ...]:
    """Return the present loop and alternatives, simulated unless they diverge.

    Parameters
    ----------
    variant : Variant
        The loop.
    bandwidth : float, optional
        Desired bandwidth of the proposals [rad/s]; by default the largest that the margins allow.
    simulated : bool
        Whether the present loop can be simulated.
    progress : callable, optional
        Called with the share done and the name of the next step.
    """
    loops, bandwidths = _loops(variant, bandwidth)
    judged = {}
    for name, loop in loops.items():
        if name in bandwidths and not loop.run.current_lag:
            # Propose gains for the largest lag of an unspecified current loop.
            judged[name] = assess(lagging(loop, UNSTATED[1]))
        else:
            judged[name] = assess(loop)
    able = tuple(
        replace(loop, run=replace(loop.run, seeds=min(variant.run.seeds, RUNS_MAX)))
        for name, loop in loops.items()
        if judged[name].verdict is not Verdict.DIVERGES and (simulated or name != AS_IT_IS)
    )
    outcomes = simulate(Experiment(variant.name, variant.plant.kind, able), progress).variants
    proposals = []
    for name, loop in loops.items():
        following_error = None
        effort_rms = None
        outcome = outcomes.get(name)
        if outcome is not None and outcome.status is not Status.NOT_FINITE:
            following_error = outcome.following_error
            effort_rms = outcome.effort_rms
        proposals.append(
            Proposal(
                loop,
                judged[name],
                bandwidths.get(name),
                law_stiffness(linear_law(loop.controller, loop.run.sample_time, LARGE)),
                count_response(loop),
                following_error,
                effort_rms,
            )
        )
    return tuple(proposals)


def _loops(
    variant: Variant, bandwidth: float | None
) -> tuple[dict[str, Variant], dict[str, float]]:
    """Return the present loop and the proposals by name, and the bandwidths of the proposals."""
    desired = replace(
        variant, feedforward=replace(variant.feedforward, along="desired"), learning=None
    )
    loops = {AS_IT_IS: variant}
    bandwidths = {}
    if variant.feedforward.along != "desired":
        loops[ALONG_DESIRED] = desired
    laws = {TUNED: variant.controller.name, OBSERVER: "disturbance_observer"}
    for name, law in laws.items():
        if name == OBSERVER and law == laws[TUNED]:
            continue
        tuning = tuned(variant, law, bandwidth)
        if tuning is not None and tuning.law != variant.controller:
            loops[name] = with_known_motion(replace(desired, controller=tuning.law))
            bandwidths[name] = tuning.bandwidth
    return {name: replace(loop, name=name) for name, loop in loops.items()}, bandwidths
