r"""All certificates of a model: dissipation, those of slow motion, and passivity.

Dissipation: the contact follows random closed cycles, small and large, slow and fast, until the force has settled on each. The
work done on the contact in the last round must not be negative. bristle repeats a negative result in finer steps, which removes
the work that comes from the summation over steps alone.

Bounded deflection: a bristle under a hysteresis force that saturates at :math:`f_p` stops deflecting when that force
reaches the break-away force :math:`F_S`. With :math:`f_p \le F_S` the deflection never stops, but grows as long as the
body slides. The test slides the contact slowly over growing distances and reads the deflection.

Drift: under a force that rises and falls below break-away a real contact settles into a closed loop. A model
that slips a little at every force drifts. Closure: a real contact that is loaded, moved half of the way back and forth again
returns to its former force. A model without turning points does not.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from bristle.core import (
    HysteresisOperator,
    InputError,
    Model,
    Variable,
    guarded,
    many,
    model as of_family,
    number,
    optional,
    quantity,
    unit_of,
    variables_of,
    with_unit,
)
from bristle.engine import Contact, force_along
from bristle.models.friction import unvaried
from bristle.simulation.certificates.certificate import (
    Certificate,
    OperatorParameters,
    as_friction,
    not_applicable,
)
from bristle.simulation.certificates.passive import passive
from bristle.simulation.certificates.quasi_static import CREEP, Holding, Path, holding_of

SEED = 20260
CYCLES = 200
SAMPLES = 400
ROUNDS = 4
ROUNDING = 1e-9
REACHES = np.geomspace(1e-9, 1e3, 49)  # m or rad


class Loop(NamedTuple):
    """A symmetric loop: its amplitude [m or rad], the share of the work that stays in the contact, and its sense.

    The loop of an operator may be magnetic: its output lags behind the input, whereas that of friction leads.
    """

    reach: float
    share: float
    is_magnetic: bool


def fattest_loop(model: Model) -> Loop:
    """Return the symmetric loop with the largest share of work lost or gained; it determines the scale and the sense."""
    phase = np.linspace(0.0, 2.0 * np.pi, SAMPLES + 1)
    shares = [
        (reach, _share_kept(model, reach * np.sin(phase), reach / CREEP))
        for reach in REACHES.tolist()
    ]
    reach, share = max(shares, key=lambda loop: abs(loop[1]))
    return Loop(
        reach, share, isinstance(model.parameters, OperatorParameters) and share < -ROUNDING
    )


def dissipation(model: Model, holding: Holding, loop: Loop) -> Certificate:
    """Return the least share of work that the contact keeps, over random closed cycles."""
    generator = np.random.default_rng(SEED)
    scale = holding.distance or loop.reach
    sense = 1.0
    if loop.is_magnetic:
        sense = -1.0
    least = min(_share_of_random_cycle(model, generator, scale, sense) for _ in range(CYCLES))
    passed = least >= -ROUNDING
    advice = f"No cycle of {CYCLES} returns energy"
    if not passed:
        advice = f"A closed cycle returns energy, {number(-100.0 * least, digits=3)} % of all work in it: see passive for the remedy"
    return Certificate(True, least, "1", 0.0, passed, advice)


def _share_of_random_cycle(
    model: Model, generator: np.random.Generator, scale: float, sense: float
) -> float:
    """Return the share of work kept over a closed path of three harmonics, 0.1 to 100 times as wide."""
    orders = generator.choice(np.arange(1, 9), 3, replace=False)
    heights = generator.normal(size=3) / orders
    phases = generator.uniform(0.0, 2.0 * np.pi, 3)
    width = scale * 10.0 ** generator.uniform(-1.0, 2.0)
    speed = 10.0 ** generator.uniform(-6.0, 2.0)

    def share(samples: int) -> float:
        turn = 2.0 * np.pi * np.arange(samples + 1) / samples
        x = width * (heights @ np.sin(np.outer(orders, turn) + phases[:, None]))
        return sense * _share_kept(model, x, float(np.sum(np.abs(np.diff(x)))) / speed)

    coarse = share(SAMPLES)
    if coarse >= -ROUNDING:
        return coarse
    fine = share(8 * SAMPLES)
    if fine < 0.5 * coarse:
        return fine
    return 0.0


def _share_kept(model: Model, x: np.ndarray, duration: float) -> float:
    """Return the share of work kept along a closed path, in the last of some rounds."""
    step = np.tile(np.diff(x), ROUNDS)
    dt = duration / (x.size - 1)
    force = force_along(model, step / dt, dt, np.tile(x[1:], ROUNDS))
    work = (force * step)[1 - x.size :]
    total = float(np.sum(np.abs(work)))
    if total > 0.0:
        return float(np.sum(work)) / total
    return 0.0


LEAST_RATIO = 1.05  # of f_p to F_S, and of a growing deflection to its value at half the distance
MISSING = 1e-3  # of break-away: a loop that misses more is not closed


def well_posed(model: Model, holding: Holding) -> Certificate:
    """Return whether the deflection is bounded in sliding, and its bound [m, rad, or N, N*m for a force]."""
    if isinstance(model.parameters, OperatorParameters):
        return not_applicable(
            "1",
            "The user gives the input of an operator, so there is no deflection that could grow",
        )
    # Read the deflection z if there is one, else the first state, else the force.
    states = variables_of(model.component.State)
    name = "z" if "z" in states else next(iter(states), "")
    unit = unit_of("force", model.kind)
    if name:
        unit = unit_of(states[name].quantity, model.kind)

    def read(contact: Contact, side: float) -> float:
        if name:
            return abs(float(contact.state[list(states).index(name)]))
        return abs(contact.force(side * 0.0))

    if not holding.has_presliding:
        return not_applicable(unit, "The model has no deflection that could grow")
    bound = _bound(model, read, holding)
    # F_S, the larger one if it differs by direction.
    static_force = max(
        (value for name, value in model.values.items() if name in ("F_S", "F_S_pos", "F_S_neg")),
        default=None,
    )
    saturation = model.values.get("f_p")
    if saturation is None or static_force is None:
        advice = "The deflection grows as long as the body slides: add a saturation"
        if math.isfinite(bound):
            advice = "The deflection is bounded for all parameters"
        return Certificate(True, bound, unit, math.inf, math.isfinite(bound), advice)
    least = LEAST_RATIO * static_force
    at_least = model.component(kind=model.kind, validate=False, **(model.values | {"f_p": least}))
    passed = bool(saturation >= least * (1.0 - 1e-12) and math.isfinite(bound))
    share = f"{100.0 * (saturation / static_force - 1.0):.3g}"
    raised = f"raise f_p to at least {with_unit(least, unit_of('force', model.kind), 4)}"
    if passed:
        advice = f"f_p is {share} % above F_S"
    elif math.isfinite(bound):
        advice = f"f_p is only {share} % above F_S: {raised}"
    else:
        advice = f"The deflection grows as long as the body slides: {raised}"
    return Certificate(True, bound, unit, _bound(at_least, read, holding), passed, advice)


def _bound(model: Model, read: Callable[[Contact, float], float], holding: Holding) -> float:
    """Return the largest deflection in slow sliding, in either direction; infinite if it still grows at the end."""
    largest = 0.0
    for side in (1.0, -1.0):
        contact = Contact(model)
        for reach in holding.distance * np.geomspace(1e-3, 1e6, 200):
            contact.move(side * reach - contact.x, CREEP)
        before = read(contact, side)
        contact.move(contact.x, CREEP)
        after = read(contact, side)
        if not after <= LEAST_RATIO * before:
            return math.inf
        largest = max(largest, after)
    return largest


def drift(
    model: Model, holding: Holding, ripple: tuple[float, float] | None, is_magnet: bool
) -> Certificate:
    """Return the displacement per settled cycle [m or rad] under a force between two levels [N or N*m]."""
    unit = unit_of("length", model.kind)
    if is_magnet:
        return not_applicable(
            unit,
            "Its loops run in the opposite sense, like those of a magnet: it cannot rest under a force",
        )
    if not holding.breaks_away:
        return not_applicable(
            unit, "It has no break-away force: any force moves it, or it is a spring without limit"
        )
    low, high = ripple or tuple(map(holding.level, (0.3, 0.6)))
    if not holding.backward < low < high < holding.forward:
        raise InputError(
            "must be two forces at which the contact rests, the lower first",
            path="force_ripple",
            value=(low, high),
            allowed=f"above {holding.backward:.6g} and below {holding.forward:.6g} {unit_of('force', model.kind)}",
        )
    if not holding.has_presliding:
        return Certificate(True, 0.0, unit, 0.0, True, "It rests: no motion below break-away")
    path = Path(model, holding)
    path.to_force(high)
    threshold = 1e-6 * abs(path.x)  # more in a cycle is drift
    moved = 0.0
    for _ in range(100):
        start = path.x
        before = moved
        path.to_force(low)
        path.to_force(high)
        moved = path.x - start
        if abs(moved - before) <= 1e-5 * abs(moved) or abs(moved) <= 1e-3 * threshold:
            break
    passed = abs(moved) <= threshold
    advice = "It does not drift"
    if not passed:
        creep = with_unit(abs(moved) * 36_000, unit)
        advice = f"It drifts {creep} in an hour at 10 Hz: take maxwell_slip, gms, or preisach_lugre with its gate"
    return Certificate(True, moved, unit, threshold, passed, advice)


def closure(model: Model, holding: Holding, loop: tuple[float, float] | None) -> Certificate:
    """Return the force error at the return to `x1` over ``0 -> x1 -> x2 -> x1``, as a fraction of break-away."""
    if not holding.has_presliding:
        return not_applicable(
            "1", "Its force does not build up over a distance: there is no minor loop"
        )
    x1, x2 = loop or default_loop(model, holding)
    if not (math.isfinite(x1) and math.isfinite(x2) and x1 != 0.0 and x2 / x1 < 1.0):
        raise InputError(
            "must be two reversal positions, the first away from 0 and the second back toward 0 or beyond",
            path="loop",
            value=(x1, x2),
            allowed=f"for example (3e-6, 1.5e-6) {unit_of('length', model.kind)}",
        )
    path = Path(model, holding)
    path.to_position(x1)
    loaded = path.force
    path.to_position(x2)
    path.to_position(x1)
    missing = math.copysign(1.0, x1) * (path.force - loaded) / holding.half
    passed = abs(missing) <= MISSING
    advice = "It returns to its former force"
    if not passed:
        share = number(100.0 * abs(missing), digits=3)
        advice = (
            f"{share} % of break-away is missing at the return: take maxwell_slip, gms, or preisach_lugre with a gate "
            "that is closed up to this load"
        )
    return Certificate(True, missing, "1", MISSING, passed, advice)


def default_loop(model: Model, holding: Holding) -> tuple[float, float]:
    """Return the turning points [m or rad]: at 0.85 of break-away, and halfway back."""
    path = Path(model, holding)
    path.to_force(holding.level(0.85))
    return path.x, 0.5 * path.x


PAIR = optional(many(lambda raw, path, kind: raw, least=2, most=2))  # in units of the model


@guarded(model=of_family("friction", "hysteresis"), force_ripple=PAIR, loop=PAIR)
def check(model: Model, *, force_ripple: Any = None, loop: Any = None) -> dict[str, Certificate]:
    """Test dissipation, passivity, drift, closure of loops and bounded deflection of a friction model, with a certificate each.

    Parameters
    ----------
    model : Model
        A friction model, or a hysteresis operator, with parameters. An operator counts as friction whose position is
        the input. If its loops run in the opposite sense (a magnet), bristle counts energy as in magnets. If friction
        varies along the axis, the tests apply to the middle of the range.
    force_ripple : (low, high), optional
        Forces between which the contact is loaded, for `drift`: numbers [N or N*m], or text with a unit.
        The default is 0.3 and 0.6 of the break-away force.
    loop : (x1, x2), optional
        Positions where the loop ``0 -> x1 -> x2 -> x1`` of `closure` turns: numbers [m or rad], or text with a unit. By
        default, the force at x1 is 0.85 of the break-away force, and x2 is half of x1.

    Returns
    -------
    dict of str to Certificate
        ``well_posed``, ``passive``, ``drift``, ``closure`` and ``dissipation``.

    Raises
    ------
    InputError
        If `model` is neither a friction model nor an operator, or the contact does not rest under the ripple.

    Examples
    --------
    >>> from bristle import friction
    >>> found = check(friction.coulomb(F_C=2.0))
    >>> found["drift"].value, found["closure"].applies
    (0.0, False)
    """
    force = Variable("force", "force of the ripple")
    length = Variable("length", "reversal position of the loop")
    if isinstance(model.component, HysteresisOperator):
        force, length = (
            Variable(name, name) for name in (model.component.output, model.component.input)
        )
        model = as_friction(model)
    else:
        model = unvaried(model)
    pairs: dict[str, Any] = {"force_ripple": None, "loop": None}
    for path, raw, variable in (("force_ripple", force_ripple, force), ("loop", loop, length)):
        if raw:
            pairs[path] = tuple(
                quantity(value, variable, model.kind, path=f"{path}[{i}]")
                for i, value in enumerate(raw)
            )
    holding = holding_of(model)
    fattest = fattest_loop(model)
    return {
        "well_posed": well_posed(model, holding),
        "passive": passive(model, fattest.is_magnetic),
        "drift": drift(model, holding, pairs["force_ripple"], fattest.is_magnetic),
        "closure": closure(model, holding, pairs["loop"]),
        "dissipation": dissipation(model, holding, fattest),
    }
