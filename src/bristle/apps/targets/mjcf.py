"""MJCF: a friction model in a complete scene of MuJoCo.

`lugre` without slots is the actuator ``dcmotor``, whose accuracy depends on the integrator. Dry friction is the
``frictionloss`` of the joint. With ``noslip_iterations``, a load below it moves the joint at exactly zero speed, while a
stiff element would oscillate. All other friction is a sum of elasto-slip elements: each is a tendon whose spring
slips at its deflection ``springyield``. Elements of friction that differs by direction start deflected behind a constant force.
"""

import math
from typing import NamedTuple
from xml.etree import ElementTree as Xml

import numpy as np

from bristle.core.contracts import Model
from bristle.exports.described import Request, parameter_table, plain, version
from bristle.exports.maxwell import Deviation, Elements, elements_of
from bristle.exports.targets import Product
from bristle.identification.parameters import offset_of
from bristle.models.friction import base_of
from bristle.models.friction.level import rises_with_effort
from bristle.models.friction.slots import directional, variations_of

STEP = 1e-4  # [s]
ITERATIONS = 20  # of the solver that makes dry friction hold
OF_LUGRE = """The integrator is Euler, the more accurate one for the bristles of LuGre. implicitfast evaluates the damping of the joint
at the end of the step, but not the bristles: in stick-slip its error was forty times larger at the same step.
Choose a step that is much shorter than the time constant of the bristles, {time:.2g} s."""
OF_ELEMENTS = """Needs MuJoCo 4. Each tendon is a spring that slips at its deflection springyield. Move the joint by forces or velocities: a
change of qpos between steps does not deflect the elements.
Choose a step that is much shorter than the time constant of the elements, {time:.2g} s.
{error}."""
NOTE_OF_LUGRE = "the scene uses the integrator Euler: implicitfast is far less accurate with LuGre"
TEXT = """<!-- Friction of an axis: {model}. Written by bristle {version}.
{facts}
{table}

{about}
-->
<mujoco model="{name}">
  <compiler angle="radian"/>
  <option timestep="{step}" integrator="Euler" gravity="0 0 0"{option}/>
  <worldbody>
    <body name="{name}_body">
      <joint name="{name}" type="{joint}" axis="{axis}"{of_joint}/>
      <inertial pos="0 0 0" mass="{mass}" diaginertia="{inertia}"/>
    </body>
  </worldbody>
{tendons}  <actuator>
    <motor name="{name}_effort" joint="{name}"/>
{actuators}  </actuator>
</mujoco>
"""


class JointFriction(NamedTuple):
    """Friction of a joint: its attributes, its tendons and actuators, their stiffness in all, the error, and notes."""

    attributes: dict[str, str]
    tendons: list[Xml.Element]
    actuators: list[Xml.Element]
    stiffness: float = 0.0
    deviation: Deviation | None = None
    notes: tuple[str, ...] = ()


def write(request: Request) -> Product:
    """Return the scene, with notes on differences of MuJoCo."""
    friction = friction_of_joint(request)
    error = None
    if friction.deviation is not None:
        error = friction.deviation._asdict()
        if not friction.deviation.reach:
            del error["reach"]
    return Product(
        {f"{request.name}.xml": _scene(request, friction)},
        (*friction.notes, *_left_out(request.plant)),
        error=error,
    )


def _left_out(plant: Model | None) -> tuple[str, ...]:
    """Return a note on the forces of a plant that the scene does not contain."""
    if plant is None:
        return ()
    names = [
        name
        for name, value in plant.values.items()
        if name not in ("M", "J", "lead") and np.any(value)
    ]
    return (f"the scene contains the mass of the plant only, without {', '.join(names)}",) * bool(
        names
    )


def _scene(request: Request, friction: JointFriction) -> str:
    """Return a scene with one joint, its friction, and a motor for the effort."""
    model = request.model
    mass = request.mass
    name = request.name
    step = STEP
    time = STEP
    if friction.stiffness:
        time = math.sqrt(mass / friction.stiffness)
    about = OF_LUGRE
    error = ""
    if friction.deviation is not None:
        about = "{error}."
        error = friction.deviation.text(model.kind)
        if friction.tendons:
            about = OF_ELEMENTS
            step = min(STEP, float(f"{0.2 * time:.1g}"))
    # A comment in XML must not contain "--".
    facts, table = (
        text.replace("--", "- -")
        for text in ("\n".join(request.source.lines), parameter_table(model, request.source))
    )
    shape = {"joint": "slide", "axis": "1 0 0", "mass": repr(mass), "inertia": "1 1 1"}
    if model.kind != "translational":
        shape = {
            "joint": "hinge",
            "axis": "0 0 1",
            "mass": "1",
            "inertia": f"{mass!r} {mass!r} {mass!r}",
        }
    tendons, actuators = (
        "".join(f"    {Xml.tostring(part, encoding='unicode')}\n" for part in parts)
        for parts in friction[1:3]
    )
    parts = {
        "facts": facts,
        "table": table,
        "about": about.format(time=time, error=error),
        "actuators": actuators,
    } | shape
    parts["option"] = ""
    if "frictionloss" in friction.attributes:
        parts["option"] = f' noslip_iterations="{ITERATIONS}"'
    parts |= {
        "of_joint": "".join(f' {key}="{value}"' for key, value in friction.attributes.items()),
        "tendons": tendons and f"  <tendon>\n{tendons}  </tendon>\n",
    }
    return TEXT.format(model=plain(model.name), version=version(), name=name, step=step, **parts)


def friction_of_joint(request: Request) -> JointFriction:
    """Return the friction of a joint, named like the request."""
    component = request.model.component
    values = request.model.values
    name = request.name
    slots = variations_of(component)
    if (
        base_of(component).name == "lugre"
        and not (slots or directional(component))
        and math.isinf(values["v_d"])
    ):
        lugre = " ".join(
            repr(float(values[key])) for key in ("sigma_0", "sigma_1", "F_C", "F_S", "v_S")
        )
        attributes = {
            "motorconst": "0",
            "resistance": "1",
            "input": "none",
            "damping": repr(float(values["sigma_2"])),
            "lugre": lugre,
        }
        constant, notes = _constant(name, offset_of(component.variables, values))
        motor = Xml.Element("dcmotor", {"name": f"{name}_friction", "joint": name} | attributes)
        return JointFriction(
            {}, [], [motor, *constant], values["sigma_0"], None, (NOTE_OF_LUGRE, *notes)
        )
    elements, deviation = elements_of(request)
    actuators, notes = _constant(name, elements.whole_constant)
    if not slots and rises_with_effort(request.model):
        slots = ("transmitted effort",)
    if slots:
        notes = (
            f"the scene omits {', '.join(slots)}: its friction is that at nominal values, in the middle of the range",
            *notes,
        )
    attributes = {
        key: repr(float(value))
        for key, value in (("frictionloss", elements.dry), ("damping", elements.damping))
        if value
    }
    if elements.stiffness.size:
        notes = ("the scene needs MuJoCo 4 or later", *notes)
    notes = (deviation.text(request.model.kind), *notes)
    return JointFriction(
        attributes,
        _tendons(name, elements),
        actuators,
        float(np.sum(elements.stiffness)),
        deviation,
        notes,
    )


def _tendons(name: str, elements: Elements) -> list[Xml.Element]:
    """Return a tendon for each element of a joint that has a force; a springyield of 0 would mean a spring that never slips."""
    tendons = []
    for k, d in zip(elements.stiffness.tolist(), elements.yields.tolist(), strict=True):
        if k * d > 0.0:
            lengths = {"springlength": "0"}
            if math.isfinite(d):
                lengths = {"springlength": repr(elements.ratio * d), "springyield": repr(d)}
            tendons.append(
                Xml.Element(
                    "fixed",
                    {"name": f"{name}_element_{len(tendons)}", "stiffness": repr(k)} | lengths,
                )
            )
            Xml.SubElement(tendons[-1], "joint", joint=name, coef="1")
    return tendons


def _constant(name: str, force: float) -> tuple[list[Xml.Element], tuple[str, ...]]:
    """Return the actuator of a constant friction force [N or N*m], and a note; both empty without this force."""
    if not force:
        return [], ()
    bias = {
        "name": f"{name}_constant",
        "joint": name,
        "gainprm": "0",
        "biastype": "affine",
        "biasprm": f"{-force!r} 0 0",
    }
    return [Xml.Element("general", bias)], (
        f"the actuator {name}_constant applies a constant force; its control has no effect",
    )
