r"""Linear systems in discrete time, measured on the functions of the simulation.

.. math:: s_{k+1} = A\,s_k + B\,u_k, \qquad y_k = C\,s_k + D\,u_k

Each column is the difference between two steps, one to either side. For piecewise linear functions, such as control laws
and mechanisms, the slope is exact to rounding. Friction is a spring and a damper, :math:`F = k\,x + c\,v`: stiff before
break-away, and in sliding the slope of the steady curve, which is negative if friction falls with velocity. A sampled
loop, including all its delays, is one linear system.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from bristle.core.contracts import Model, Motion, Reference, Screw
from bristle.core.experiment import Variant
from bristle.core.packing import pack, structure_of, unpacker
from bristle.engine.checks import finite
from bristle.engine.contact import steady_force
from bristle.models.plants import ball_screw

ALIKE = 1e-3  # largest relative change of a constant slope over a decade of amplitude
SAME = 1e-6  # largest relative difference of equal numbers
SMALL = (
    1e-12  # amplitude [SI] inside every boundary layer, dead band, backlash and break-away distance
)
DAMPED = 0.01  # assumed damping ratio of a coupling: that of a lightly damped machine
LARGE = 1e6  # amplitude [SI] at which bounded terms (switching, backlash) are negligible


class LinearSystem(NamedTuple):
    """Matrices A (n, n), B (n,), C (n,) and number D of a linear system in discrete time with n states."""

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    D: float

    def beside(self, system: LinearSystem) -> LinearSystem:
        """Return the parallel connection of two systems: a common input, the sum of the outputs."""
        n = self.B.size
        m = system.B.size
        A = np.block([[self.A, np.zeros((n, m))], [np.zeros((m, n)), system.A]])
        return LinearSystem(
            A, np.append(self.B, system.B), np.append(self.C, system.C), self.D + system.D
        )

    def response(self, z: np.ndarray) -> np.ndarray:
        """Return the transfer function at points `z` of the complex plane, shape (point,)."""
        if not self.B.size:
            return np.full(z.shape, self.D, dtype=complex)
        resolvent = z[:, None, None] * np.eye(self.B.size) - self.A
        return (
            np.linalg.solve(resolvent, np.broadcast_to(self.B[:, None], (z.size, self.B.size, 1)))[
                :, :, 0
            ]
            @ self.C
            + self.D
        )


def linear_law(controller: Model, dt: float, amplitude: float) -> LinearSystem:
    """Return the linearised control law from the measured position to the effort, about rest."""
    component = controller.component
    p = controller.parameters
    if "limit" in p._fields:
        p = p._replace(limit=float("inf"))
    rest = component.start(0.0, 0.0, 0.0, dt, p)
    load = unpacker(structure_of(rest))
    still = Reference(0.0, 0.0, 0.0, 0.0)

    def sample(state: np.ndarray, measured: float) -> tuple[np.ndarray, float]:
        effort, after = component.step(load(state), still, measured, dt, p)
        return pack(after), effort

    return measured_on(sample, pack(rest), varied_in(structure_of(rest)), amplitude)


def varied_in(structure: Any) -> np.ndarray:
    """Return the numbers of a packed state that are states of a linear system, without counters and modes."""
    flags: list[bool] = []
    for part in structure[1]:
        if isinstance(part, tuple):
            flags.extend(varied_in(part))
        else:
            flags.append(part == "number")
    return np.array(flags, dtype=bool)


def measured_on(
    sample: Callable[[np.ndarray, float], tuple[np.ndarray, float]],
    rest: np.ndarray,
    varied: np.ndarray,
    amplitude: float,
) -> LinearSystem:
    """Return the linear system of a function of state and input that returns the next state and the output."""
    directions = [
        np.where(np.arange(rest.size) == i, amplitude, 0.0) for i in np.flatnonzero(varied)
    ]
    moves = [(direction, 0.0) for direction in directions] + [(np.zeros(rest.size), amplitude)]
    columns = []
    outputs = []
    for move, push in moves:
        plus, out_plus = sample(rest + move, push)
        minus, out_minus = sample(rest - move, -push)
        columns.append((plus - minus)[varied] / (2.0 * amplitude))
        outputs.append((out_plus - out_minus) / (2.0 * amplitude))
    matrix = np.array(columns).T.reshape(-1, len(moves))
    return LinearSystem(matrix[:, :-1], matrix[:, -1], np.array(outputs[:-1]), float(outputs[-1]))


class LinearFriction(NamedTuple):
    """A spring `k` [N/m or N*m/rad] and a damper `c` [N*s/m or N*m*s/rad] between the port and the ground."""

    k: float = 0.0
    c: float = 0.0


NO_FRICTION = LinearFriction()


def stiffness_at_rest(friction: Model, dt: float) -> LinearFriction | None:
    """Return the friction of a stuck axis for small motions about its rest position."""
    slow, fast = (_slope(friction, SMALL, time) for time in (dt, 0.1 * dt))
    if abs(_slope(friction, 0.1 * SMALL, dt) - slow) > ALIKE * abs(slow):
        return None
    # Over a move of length d in a time T the mean force is k d/2 + c d/T.
    c = (fast - slow) * dt / 9.0
    k = 2.0 * (slow - c / dt)
    if k > SAME * slow:
        return LinearFriction(k, c)
    return LinearFriction(0.0, c)


def _slope(friction: Model, move: float, time: float) -> float:
    """Return the mean force of a first move divided by its length, mean of both directions."""
    component = friction.component
    p = friction.parameters
    forces = []
    for way in (move, -move):
        state = component.initial_state(p)
        memory = component.new_memory(p)
        force, _ = component.trial(state, memory, Motion(way / time, way), time, p)
        forces.append(force)
    finite(np.array(forces), friction)
    return (forces[0] - forces[1]) / (2.0 * move)


def slope_in_sliding(friction: Model, speed: float) -> LinearFriction:
    """Return the friction slope of an axis that slides at a constant `speed` [m/s or rad/s], mean of both directions."""
    fast = 1.05 * speed
    slow = 0.95 * speed
    return LinearFriction(
        0.0, (sliding_force(friction, fast) - sliding_force(friction, slow)) / (fast - slow)
    )


def sliding_force(friction: Model, speed: float) -> float:
    """Return the friction [N or N*m] at a constant `speed` [m/s or rad/s], mean of both directions."""
    return 0.5 * (steady_force(friction, speed) - steady_force(friction, -speed))


def linear_plant(
    variant: Variant,
    amplitude: float,
    friction: LinearFriction = NO_FRICTION,
    table: LinearFriction = NO_FRICTION,
) -> LinearSystem:
    r"""Return drive and plant of a loop, from the commanded effort (zero-order hold) to the sampled position.

    After a screw of stiffness `k` and damping `d` the table follows at the mean velocity :math:`v_t` while the motor turns
    at :math:`v_m`, both referred to the motor; over a step of length `h`

    .. math::
        f_s = k\left[\theta - x + \tfrac12 h (v_m - v_t)\right] + d\,(v_m - v_t), \qquad
        v_m = a + b\,(F_m + f_s), \qquad v_t = v_{t,0} + \frac{h}{2M}(f_s - F_t)

    A backlash counts as closed: at rest, the parts touch one flank.
    """
    component = variant.plant.component
    p = variant.plant.parameters
    run = variant.run
    rest = component.initial_state(p)
    load = unpacker(structure_of(rest))
    h = run.sample_time / run.substeps
    screw = None if component.screw is None else component.screw(p)
    reads_table = screw is not None and variant.sensor_at == "load"

    def sample(state: np.ndarray, command: float) -> tuple[np.ndarray, float]:
        body = load(state[:-3])
        x, v, drive_effort = state[-3:]
        position = body.x
        if reads_table:
            position = x
        for _ in range(run.substeps):
            effort = command
            before = drive_effort
            drive_effort = command
            if run.current_lag > 0.0:
                rate = h / run.current_lag
                decay = math.expm1(-rate)
                effort = command - (before - command) * decay / rate
                drive_effort = before - (command - before) * decay
            if screw is None:
                body = _moved(variant.plant, body, effort, friction, h)
            else:
                body, x, v = _pulled(variant.plant, body, effort, friction, screw, table, x, v, h)
        return np.append(pack(body), (x, v, drive_effort)), position

    varied = np.append(varied_in(structure_of(rest)), [True, True, True])
    return measured_on(sample, np.append(pack(rest), [0.0, 0.0, 0.0]), varied, amplitude)


def with_two_masses(variant: Variant) -> Variant:
    """Return a loop on its motor with the load behind an elastic screw, if its coupling is known."""
    coupling = variant.coupling
    mass = variant.plant.values.get("M")
    if coupling is None or mass is None or variant.plant.component.screw is not None:
        return variant
    omega = 2.0 * math.pi * coupling.antiresonance
    motor = mass / (1.0 + coupling.inertia_ratio)
    load = mass - motor
    # A lead of 2 pi: one radian of the motor is one unit of travel.
    values = {
        "J": motor,
        "M": load,
        "lead": 2.0 * math.pi,
        "k": load * omega**2,
        "d": 2.0 * DAMPED * load * omega,
    }
    return replace(
        variant,
        plant=ball_screw(kind="rotational", validate=False, **values),
        table=None,
        sensor_at="motor",
    )


def antiresonance_of(variant: Variant) -> float:
    """Return the angular frequency at which the table of a plant vibrates on the held motor [rad/s]; infinite for one mass."""
    screw = variant.plant.component.screw
    if screw is None:
        return math.inf
    parts = screw(variant.plant.parameters)
    return math.sqrt(parts.k / parts.M)


def _moved(plant: Model, body: Any, effort: float, friction: LinearFriction, h: float) -> Any:
    """Return the state of a plant after a step."""
    k, c = friction
    a, b = plant.component.port(body, effort, h, plant.parameters)
    # The mean force of the step is k (x + v h/2) + c v, and the mean velocity v is a + b times this force.
    v = (a + b * k * body.x) / (1.0 - b * (0.5 * k * h + c))
    force = k * (body.x + 0.5 * h * v) + c * v
    return plant.component.step(body, effort, force, h, plant.parameters)[1]


def _pulled(
    plant: Model,
    body: Any,
    effort: float,
    friction: LinearFriction,
    screw: Screw,
    table: LinearFriction,
    x: float,
    v: float,
    h: float,
) -> tuple[Any, float, float]:
    """Return the state of a motor, and position and velocity of its table referred to the motor."""
    square = screw.arm * screw.arm
    k_m, c_m = friction
    k_t, c_t = table
    k = square * screw.k
    half = 0.5 * h / (square * screw.M)
    a, b = plant.component.port(body, effort, h, plant.parameters)
    pulls = 0.5 * k * h + square * screw.d
    own = 0.5 * k_m * h + c_m
    behind = square * (0.5 * k_t * h + c_t)
    twisted = k * (body.x - x)
    means = np.linalg.solve(
        [[1.0 - b * (own + pulls), b * pulls], [-half * pulls, 1.0 + half * (pulls + behind)]],
        [a + b * (k_m * body.x + twisted), v + half * (twisted - square * k_t * x)],
    )
    v_m = float(means[0])
    v_t = float(means[1])
    force = k_m * body.x + own * v_m + twisted + pulls * (v_m - v_t)
    body = plant.component.step(body, effort, force, h, plant.parameters)[1]
    return body, x + h * v_t, 2.0 * v_t - v


PHASE_ENOUGH = 30.0  # smallest usual phase margin [deg]
GAIN_ENOUGH = 2.0  # smallest usual gain margin
POINTS = 2000  # evaluated frequencies of the open loop
HALVINGS = 50  # bisections between two of them


@dataclass(frozen=True)
class SampledLoop:
    """A plant and its control law, both linear and sampled."""

    plant: LinearSystem  # from the applied effort (zero-order hold) to the measured position
    law: LinearSystem  # from the measured position to the commanded effort
    delay: int  # samples from a measurement to the effort computed from it
    sample_time: float  # [s]

    @property
    def matrix(self) -> np.ndarray:
        """Transition matrix of the states of plant, delay line and law over a sample, without states that have no effect."""
        plant = self.plant
        law = self.law
        n = plant.B.size
        m = law.B.size
        d = self.delay
        full = np.zeros((n + d + m, n + d + m))
        full[:n, :n] = plant.A
        full[n + d :, n + d :] = law.A
        full[n + d :, :n] = np.outer(law.B, plant.C)
        command = np.concatenate((law.D * plant.C, np.zeros(d), law.C))
        if d:
            full[:n, n + d - 1] = plant.B
            full[n + 1 : n + d, n : n + d - 1] = np.eye(d - 1)
            full[n] = command
        else:
            full[:n] += np.outer(plant.B, command)
        # States that a disturbance reaches first, and states with an effect on the output.
        entered = np.concatenate((plant.B != 0.0, np.zeros(d, dtype=bool), law.B != 0.0))
        read = np.concatenate((plant.C != 0.0, np.zeros(d, dtype=bool), law.C != 0.0))
        linked = full != 0.0
        part = _reached(linked, entered) & _reached(linked.T, read)
        return full[np.ix_(part, part)]

    @property
    def poles(self) -> np.ndarray:
        """Poles of the closed loop, the largest first."""
        poles = np.linalg.eigvals(self.matrix)
        return poles[np.argsort(-np.abs(poles), kind="stable")]

    @property
    def spectral_radius(self) -> float:
        """Absolute value of the largest pole. Above 1, a disturbance grows from sample to sample."""
        return float(np.max(np.abs(self.poles), initial=0.0))

    @property
    def is_unstable(self) -> bool:
        """Whether a pole lies outside the unit circle."""
        return self.spectral_radius > 1.0 + 1e-6  # rounding of a double pole at 1, of a free body

    def response(self, omega: np.ndarray) -> np.ndarray:
        """Return the negative open-loop response, from effort to returned effort, at `omega` [rad/s]."""
        z = np.exp(1j * omega * self.sample_time)
        return -self.law.response(z) * z ** float(-self.delay) * self.plant.response(z)

    def with_gain(self, factor: float) -> SampledLoop:
        """Return the loop with the law multiplied by `factor`."""
        law = self.law
        return replace(self, law=LinearSystem(law.A, law.B, factor * law.C, factor * law.D))


def _reached(linked: np.ndarray, first: np.ndarray) -> np.ndarray:
    """Return the states reachable from `first`; ``linked[i, j]`` means that `j` acts on `i`."""
    reached = first
    for _ in range(first.size):
        reached = reached | (linked[:, reached].any(axis=1))
    return reached


class Margins(NamedTuple):
    r"""Margins of a sampled loop; None without a crossover of the open loop.

    At the crossover :math:`|L(e^{j\omega T})| = 1` the phase margin is :math:`180° + \arg L`; where :math:`L` crosses the
    negative real axis the gain margin is :math:`1/|L|` [1]_. The peak of the sensitivity is that of :math:`1/|1 + L|`.

    References
    ----------
    .. [1] K. J. Astrom, R. M. Murray, "Feedback Systems", 2nd ed., Princeton University Press, 2021, section 10.3.
       ISBN 978-0-691-19398-4
    """

    phase: float | None
    gain: float | None
    crossover: float | None
    delay: float | None
    sensitivity: float


def margins_of(loop: SampledLoop) -> Margins:
    """Return the margins of a loop."""
    nyquist = math.pi / loop.sample_time
    omega = np.geomspace(1e-6 * nyquist, nyquist, POINTS)
    response = loop.response(omega)
    crossovers = [
        (math.degrees(np.angle(-loop.response(np.array([w]))[0])), w)
        for w in _crossings(loop, omega, response, lambda response: np.abs(response) - 1.0)
    ]
    turns = [
        float(loop.response(np.array([w]))[0].real)
        for w in _crossings(loop, omega, response, np.imag)
    ]
    gains = [-1.0 / real for real in (*turns, float(response[-1].real)) if real < 0.0]
    sensitivity = float(np.max(1.0 / np.abs(1.0 + response)))
    if loop.is_unstable:
        return _margins_of_unstable(crossovers, gains, sensitivity, loop.sample_time)
    return _margins_of_stable(crossovers, gains, sensitivity, loop.sample_time)


def _margins_of_stable(
    crossovers: list[tuple[float, float]], gains: list[float], sensitivity: float, dt: float
) -> Margins:
    """Return the margins of a stable loop, from phases [deg] at crossovers [rad/s], and gains at which a pole is on the unit circle."""
    # A spring gives two crossovers; count the distance from -180 degrees on both sides.
    phase, crossover = min(crossovers, key=lambda crossing: abs(crossing[0]), default=(None, None))
    if phase is not None:
        phase = abs(phase)
    return Margins(
        phase=phase,
        # A stable loop becomes unstable at a larger gain.
        gain=min((g for g in gains if g > 1.0), default=None),
        crossover=crossover,
        # Delay that brings a crossover to -180 degrees, from above.
        delay=min(
            (math.radians(phase % 360.0) / (w * dt) for phase, w in crossovers), default=None
        ),
        sensitivity=sensitivity,
    )


def _margins_of_unstable(
    crossovers: list[tuple[float, float]], gains: list[float], sensitivity: float, dt: float
) -> Margins:
    """Return the margins of an unstable loop, from phases [deg] at crossovers [rad/s], and gains at which a pole is on the unit circle."""
    phase, crossover = min(crossovers, key=lambda crossing: crossing[0], default=(None, None))
    return Margins(
        phase=phase,
        # An unstable loop becomes stable at a smaller gain.
        gain=max((g for g in gains if g < 1.0), default=None),
        crossover=crossover,
        delay=min((math.radians(phase) / (w * dt) for phase, w in crossovers), default=None),
        sensitivity=sensitivity,
    )


def _crossings(
    loop: SampledLoop,
    omega: np.ndarray,
    response: np.ndarray,
    of: Callable[[np.ndarray], np.ndarray],
) -> list[float]:
    """Return the frequencies [rad/s] at which a quantity of the open loop changes sign, by parallel bisection."""
    values = of(response)
    at = np.flatnonzero(np.sign(values[:-1]) * np.sign(values[1:]) < 0.0)
    if not at.size:
        return []
    low = omega[at]
    high = omega[at + 1]
    side = np.sign(values[at])
    for _ in range(HALVINGS):
        middle = np.sqrt(low * high)
        same_side = np.sign(of(loop.response(middle))) == side
        low = np.where(same_side, middle, low)
        high = np.where(same_side, high, middle)
    return np.sqrt(low * high).tolist()
