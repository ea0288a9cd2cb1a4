"""The text of a control law as one kernel: its feedforward along the desired or the measured motion, and its controller."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from bristle.core import Feedforward, InputError, Model, Variant
from bristle.models.controllers.wind_up import AROUND
from bristle.models.friction.level import rises_with_effort
from bristle.models.plants import inertia
from bristle.models.plants.terms import Place, Termed, place_of
from bristle.simulation.run import leads
from bristle.simulation.two_masses import feeds_inertia, screw_of


class Gravity(NamedTuple):
    """Gravity of a link [N or N*m], of a plant without cogging."""

    g_sin: float
    g_cos: float


class Load(NamedTuple):
    """An effort along the desired motion, of inertia and of position, and the prefix of its parameters."""

    prefix: str
    mass: float
    place: Any

    @property
    def numbers(self) -> tuple[float, ...]:
        """All numbers of the effort."""
        return (
            self.mass,
            *(float(number) for part in self.place or () for number in np.atleast_1d(part)),
        )

    def text(self, before: str, after: str) -> str:
        """Return the effort between two samples as text, by their indices among the samples ahead; empty for the present one."""
        parts = []
        if self.mass:
            parts.append(
                f"inertial({_ahead('acceleration', before)}, acceleration_ahead[{after}], p.{self.prefix}mass)"
            )
        if self.place:
            kernel_name = "gravity_at"
            if isinstance(self.place, Place):
                kernel_name = "effort_at"
            middle = f"0.5 * ({_ahead('position', before)} + place_ahead[{after}])"
            parts.append(f"{kernel_name}({middle}, p.{self.prefix}place)")
        return " + ".join(parts) or "0.0"


def _ahead(name: str, place: str) -> str:
    if not place:
        return name
    ahead = f"{name}_ahead[{place}]"
    if name == "position":
        ahead = f"place_ahead[{place}]"
    if "i" in place:
        return f"({ahead} if i > 0 else {name})"
    return ahead


def loads_of(feedforward: Feedforward, *, apart: bool = False) -> tuple[Load, Load]:
    """Return the load that is fed forward in addition to friction, and the load that friction transmits, as one if equal."""
    if screw_of(feedforward) is not None:
        empty = Load("", 0.0, None)
        return empty, empty
    fed = Load("", float(feedforward.mass), _place(feedforward.plant))
    carries = feedforward.carries
    if (
        feedforward.friction is None
        or carries is None
        or not rises_with_effort(feedforward.friction)
    ):
        return fed, fed
    inner = carries.component
    if isinstance(carries.parameters, Termed):
        inner = inner.inner
    if inner is not inertia:
        raise InputError(
            "has forces besides inertia, gravity, cogging and a spring, so bristle cannot export the law",
            path="feedforward.carries",
            value=carries.name,
            mend="Omit carries: the feedforward then defines the transmitted effort",
        )
    carried = Load("carried_", float(carries.values["M"]), _place(carries))
    if carried.numbers == fed.numbers and not apart:
        return fed, fed
    return fed, carried


def _place(plant: Model | None) -> Any:
    """Return the data of the position-dependent effort of a plant; None if it has no such effort."""
    place = place_of(plant)
    if not place.is_link:
        return place
    if place.g_sin or place.g_cos:
        return Gravity(place.g_sin, place.g_cos)
    return None


# Position, velocity, acceleration are desired; `begun` is false at the first sample. Indices of samples ahead count
# from the next sample.
HEAD = "def command({arguments}):\n    fed = lasting.fed"
AT_FIRST = """
    if not begun:
        fed = Fed(fed.state, {begins}, fed.share, fed.effort)"""
BEFORE_THE_FIRST = """
        for i in range({delay}):
            fed = led(fed, memory, {passing}, {to_come}, dt, p.shape, p.friction)"""
ALONG_DESIRED = """
    planned = {planned}
    fed = led(fed, memory, {place}, {carried}, dt, p.shape, p.friction)
    planned = planned + fed.effort{less}
    told = planned"""
ALONG_MEASURED = """
    planned = {planned}
    fed = led(fed, memory, measured, {carried}, dt, p.shape, p.friction){lessened}
    told = planned + fed.effort"""
NO_FRICTION = """
    planned = {planned}{less}
    told = planned"""
LEADING = """
    table, wound = lasting.table, lasting.wound
    if not begun:
        table = Fed(table.state, p.screw.arm * position, table.share, table.effort)
        for i in range({last}):
            before = acceleration_ahead[i - 1] if i > 0 else acceleration
            table, wound = pulled(table, wound, table_memory, leads, place_ahead[i], before, acceleration_ahead[i], i == 0, dt, p)
    before = acceleration_ahead[{last} - 1]
    table, wound = pulled(table, wound, table_memory, leads, place_ahead[{last}], before, acceleration_ahead[{last}], False, dt, p)
    motor = position + lead_at(leads, {at}, dt, p.screw)
    motor_velocity = velocity + rate_at(leads, {at}, dt, p.screw)
    motor_acceleration = acceleration + bend_at(leads, {at}, dt, p.screw)"""
CONTROLLED = """
    controller = lasting.controller
    if not begun:
        controller = start(measured, velocity, acceleration, dt, p.controller){resumed}
    reference = Reference({desired}, told)
    effort, controller = law(controller, reference, measured, 0.0, p.limit, dt, p.controller)
    return effort, {lasting}
"""
RESUMED = """
        followed = Reference({desired}, planned)
        controller = resume(controller, followed, measured, NOT_KNOWN, dt, p.controller)"""
ALWAYS = ("position", "velocity", "acceleration", "measured")


class Parts(NamedTuple):
    """Texts of the feedforward: in the present step, before the first, and the positions of the compensator of the motor."""

    begins: str
    planned: str
    carried: str
    to_come: str
    passing: str
    place: str
    less: str = ""


def law_text(
    arguments: Sequence[str], variant: Variant, fed: Load, carried: Load, weights: int
) -> str:
    """Return the text of the law; `weights` is the number of samples in the mean of the wind-up, 0 without a screw."""
    feedforward = variant.feedforward
    delay = variant.run.delay
    along_desired = feedforward.along == "desired"
    before = ""
    if delay:
        before = str(delay - 1)
    text = HEAD.format(arguments=", ".join(arguments))
    lasting = "Lasting(controller, fed)"
    desired = "position, velocity, acceleration"
    if weights:
        at = weights + AROUND
        text += LEADING.format(last=samples_of_wind_up(weights, delay) - 1, at=at)
        lasting = "LeadingLasting(controller, fed, table, wound)"
        if leads(variant):
            desired = "motor, motor_velocity, motor_acceleration"
        parts = _leading(variant, at, before)
    else:
        planned = fed.text(before, str(delay))
        passed = "planned"
        if carried is not fed:
            passed = carried.text(before, str(delay))
        parts = Parts(
            "position",
            planned,
            passed,
            carried.text("i - 1", "i"),
            "place_ahead[i]",
            f"place_ahead[{delay}]",
        )
    texts = parts._asdict()
    if feedforward.friction is None:
        text += NO_FRICTION.format(**texts)
    else:
        begins = "measured"
        along = ALONG_MEASURED
        if along_desired:
            begins = parts.begins
            along = ALONG_DESIRED
        text += AT_FIRST.format(begins=begins)
        if along_desired and delay:
            text += BEFORE_THE_FIRST.format(delay=delay, **texts)
        lessened = ""
        if parts.less:
            lessened = f"\n    planned = planned{parts.less}"
        text += along.format(lessened=lessened, **texts)
    resumed = ""
    if variant.controller.component.resume:
        resumed = RESUMED.format(desired=desired)
    return text + CONTROLLED.format(resumed=resumed, desired=desired, lasting=lasting)


def samples_of_wind_up(weights: int, delay: int) -> int:
    """Return the number of samples ahead that a law with the wind-up of a screw needs."""
    return delay + weights // 2 + AROUND + 1


def _leading(variant: Variant, at: int, before: str) -> Parts:
    """Return the parts of a law whose motor leads its table; `at` is the place of the present sample in the memory of leads."""
    delay = variant.run.delay
    now = at + delay
    less = ""

    def effort(place: str, step: str, after: str) -> str:
        return f"winding_effort(leads, {place}, 0.5 * ({_ahead('acceleration', step)} + acceleration_ahead[{after}]), dt, p.screw)"

    if feeds_inertia(variant.controller, variant.run.sample_time):
        acceleration = _ahead("acceleration", before)
        less = f" - p.total_inertia * {acceleration}"
        if leads(variant):
            less = f" - p.total_inertia * ({acceleration} + bend_at(leads, {now}, dt, p.screw))"
    return Parts(
        begins="motor",
        planned=effort(str(now), before, str(delay)),
        carried="planned",
        to_come=effort(f"{at} + i", "i - 1", "i"),
        passing=f"place_ahead[i] + lead_at(leads, {at + 1} + i, dt, p.screw)",
        place=f"place_ahead[{delay}] + lead_at(leads, {now + 1}, dt, p.screw)",
        less=less,
    )
