"""Controls of a page for parameters and elements: sliders, scales, conditions, and slip limits of elements."""

import math
import re
from collections.abc import Container, Sequence
from typing import Any, NamedTuple

import numpy as np

from bristle.core import Component, Model, Variable, symbolic, typeset, unit_of
from bristle.exports.subject import Subject, presliding_distance
from bristle.models.friction import gms, maxwell_slip, maxwell_stribeck
from bristle.models.plants import pulled_inertia

SIDES = ("_pos", "_neg")


def of_side(names: Sequence[str], side: str, known: Container[str]) -> list[str]:
    """Return names of parameters, with the suffix of a direction if such parameters exist."""
    of_side = {name: name + side for name in names if name + side in known}
    return [of_side.get(name, name) for name in names]


def inner_of(p: Any) -> Any:
    """Return the parameters of one direction, without the layers of slots."""
    p = _layer(p, "forward") or p
    while (layer := _layer(p, "inner")) is not None:
        p = layer
    return p


def _layer(p: Any, name: str) -> Any:
    """Return the nested parameters under this name; None if it is a number, as in a user's model."""
    layer = getattr(p, name, None)
    if hasattr(layer, "_fields"):
        return layer
    return None


# A longer distance [m or rad] is no pre-sliding; the distance that replaces it.
WITHOUT_PRESLIDING = (1e-2, 2e-4)
AROUND = 100.0  # factor from the middle of an unbounded slider to either end


class Slider(NamedTuple):
    """The ends of a slider, in SI, with equal factors if ``logarithmic``; then it may reach 0 (``to_zero``) or infinity (``endless``)."""

    low: float
    high: float
    logarithmic: bool
    to_zero: bool = False
    endless: bool = False


def slider_for(
    variable: Variable,
    value: float,
    *,
    interval: tuple[float, float] | None = None,
    span: float = 0.0,
    around: float = AROUND,
) -> Slider:
    """Return the slider of a parameter.

    Examples
    --------
    >>> slider_for(Variable("force", "Coulomb friction force", min=0.0), 20.0)
    Slider(low=0.2, high=2000.0, logarithmic=True, to_zero=True, endless=False)
    """
    low = variable.min
    high = variable.max
    within = [number for number in (value, *(interval or ())) if math.isfinite(number)]
    if math.isfinite(low) and math.isfinite(high):
        # Equal factors from this value on.
        if low > 0.0 and high / low >= 100.0:
            return Slider(low, high, logarithmic=True)
        return Slider(low, high, logarithmic=False)
    if low >= 0.0:
        middle = value
        if not 0.0 < value < math.inf:
            middle = max(variable.nominal, low)
        first = min([middle / around, *(number for number in within if number > 0.0)])
        last = max([middle * around, *within])
        return Slider(
            max(first, low),
            min(last, high),
            logarithmic=True,
            to_zero=low == 0.0,
            endless=math.isinf(value),
        )
    # Four times the value, for a number of either sign.
    farthest = max([4.0 * abs(number) for number in within] + [span]) or abs(variable.nominal)
    return Slider(max(-farthest, low), min(farthest, high), logarithmic=False)


class Scales(NamedTuple):
    """Pre-sliding distance [m or rad], Stribeck velocity [m/s or rad/s], and force [N or N*m]."""

    reach: float
    speed: float
    force: float


def scales_of(subject: Subject) -> Scales:
    """Return the scales of a friction model."""
    model = subject.model
    reach = presliding_distance(subject)
    # A thousand pre-sliding distances per second for a model without a Stribeck velocity; five without pre-sliding.
    usual = 1000.0 * reach
    if not reach < WITHOUT_PRESLIDING[0]:
        reach = WITHOUT_PRESLIDING[1]
        usual = 5.0 * reach
    variables = model.component.variables
    forces = [
        float(np.max(np.abs(value)))
        for name, value in model.values.items()
        if variables[name].quantity == "force" and not isinstance(value, str)
    ]
    speed = float(model.values.get("v_S", usual))
    viscous = float(model.values.get("F_v", 0.0)) * 10.0 * speed
    return Scales(reach, speed, max([*forces, viscous], default=0.0) or 1.0)


def pulled_by(scales: Scales, model: Model, mass: float | None = None) -> Model:
    """Return a slowly pulled mass on a spring that sticks and slips with this friction."""
    # The far end of the spring moves at a quarter of the Stribeck velocity.
    v_e = float(f"{0.25 * scales.speed:.2g}")
    m = mass or 1.0  # [kg or kg*m^2]
    # The mass sticks for 30 natural periods, 2 * pi * sqrt(m / k), while the spring gains a share of 0.3 of friction.
    root = 0.3 * scales.force / (v_e * 30.0 * math.pi * math.sqrt(m))
    return pulled_inertia(M=m, k=float(f"{root**2:.2g}"), v_e=v_e, kind=model.kind)


_CONDITION = re.compile(r"([\w.]+(?: \* [\w.]+)*) (>=|>|<) ([\w.]+(?: \* [\w.]+)*)")
_SHARES = re.compile(r"sum of (\w+) = 1")


def conditions_of(component: Component) -> list[dict[str, Any]]:
    """Return the conditions that compare two products, per direction if parameters have one; omit other conditions."""
    conditions = []
    for relation in component.relations:
        if match := _CONDITION.fullmatch(relation.condition):
            left = match[1].split(" * ")
            sign = match[2]
            right = match[3].split(" * ")
            # Text after a semicolon is for Python.
            mend = str(symbolic(relation.mend.partition(";")[0]))
            pairs = [
                [of_side(part, side, component.variables) for part in (left, right)]
                for side in SIDES
            ]
            if pairs[0] == pairs[1]:
                pairs = pairs[:1]
            conditions += [
                {
                    "left": first,
                    "sign": sign,
                    "right": second,
                    "mend": mend,
                    "advisory": relation.advisory,
                }
                for first, second in pairs
            ]
    return conditions


def shares_of(component: Component) -> list[str]:
    """Return the names of arrays that contain shares of a whole."""
    matches = (_SHARES.fullmatch(relation.condition) for relation in component.relations)
    return [match[1] for match in matches if match]


# Memory of each element, and the parameters of its limit: one product divided by another. For friction that falls with
# speed, the limit is that at rest.
MEMORIES = {
    maxwell_slip.Parameters: ("length", ["nu_i", "F_C"], ["k_i"]),
    maxwell_stribeck.Parameters: ("force", ["nu_i", "F_S"], []),
    gms.Parameters: ("force", ["nu_i", "F_S"], []),
}


WORDS = {"length": "deflection", "force": "force"}


def elements_of(model: Model, memory_size: int) -> dict[str, Any] | None:
    """Return the data for drawing the elements of a model, from the first numbers of its memory; None without elements."""
    kind = inner_of(model.parameters)
    if type(kind) not in MEMORIES or memory_size == 0:
        return None
    quantity, times, over = MEMORIES[type(kind)]
    names = model.component.variables
    rows = {"times": times, "over": over}
    return {
        "numbers": int(np.size(kind.k_i)),
        "word": WORDS[quantity],
        "unit": typeset(unit_of(quantity, model.kind)),
        "limits": [
            {word: of_side(row, side, names) for word, row in rows.items()}
            for side in ("_neg", "_pos")
        ],
    }
