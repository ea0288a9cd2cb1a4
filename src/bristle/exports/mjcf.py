"""MJCF: a friction model in a complete scene of MuJoCo.

MuJoCo has LuGre, dry friction of a joint and damping, and no other friction. The scene sets the integrator, because it
decides the accuracy of LuGre.
"""

import math

from bristle.core.contracts import Model
from bristle.core.errors import InputError
from bristle.exports.described import Source, parameter_table, plain, version
from bristle.exports.targets import Product, Request
from bristle.friction import base_of
from bristle.friction.slots import directional, variations_of

MODELS_OF_MUJOCO = ("lugre", "coulomb", "viscous", "coulomb_viscous")
STEP = 1e-4  # [s]
TEXT = """<!-- Friction of an axis: {model}. Written by bristle {version}.
{facts}
{table}

The integrator is Euler, the more accurate one for the bristles of LuGre. implicitfast evaluates the damping of the joint
at the end of the step, but not the bristles: in stick-slip its error was forty times larger at the same step.
Choose a step that is much shorter than the time constant of the bristles, {time:.2g} s.
-->
<mujoco model="{name}">
  <compiler angle="radian"/>
  <option timestep="{step}" integrator="Euler" gravity="0 0 0"/>
  <worldbody>
    <body name="{name}_body">
      <joint name="{name}" type="{joint}" axis="{axis}"{of_joint}/>
      <inertial pos="0 0 0" mass="{mass}" diaginertia="{inertia}"/>
    </body>
  </worldbody>
  <actuator>
    <motor name="{name}_effort" joint="{name}"/>
{actuators}  </actuator>
{keyframe}</mujoco>
"""


def write(request: Request) -> Product:
    """Return the scene, with notes on differences of MuJoCo."""
    text = mjcf_text(request.model, request.name, request.source, request.mass)
    base = base_of(request.model.component).name
    notes = ["the scene uses the integrator Euler: implicitfast is far less accurate with LuGre"] if base == "lugre" else []
    if base in ("coulomb", "coulomb_viscous"):
        notes.append("MuJoCo models dry friction of a joint as a slightly compliant constraint: a loaded joint creeps")
    if request.model.values.get("offset"):
        notes.append("the offset is a motor with constant control: start from the keyframe offset, or set the control of this motor")
    return Product({f"{request.name}.xml": text}, tuple(notes))


def mjcf_text(model: Model, name: str, source: Source, mass: float) -> str:
    """Return a scene with one joint, its friction, and a motor for the effort."""
    (joint, actuator), values = friction_of_joint(model), model.values
    linear = model.kind == "translational"
    of_joint = "".join(f' {key}="{value}"' for key, value in joint.items())
    actuators, time = "", STEP
    if actuator:
        of_actuator = " ".join(f'{key}="{value}"' for key, value in actuator.items())
        actuators = f'    <dcmotor name="{name}_friction" joint="{name}" {of_actuator}/>\n'
        time = math.sqrt(mass / values["sigma_0"])
    offset, keyframe = values.get("offset", 0.0), ""
    if offset:
        actuators += f'    <motor name="{name}_offset" joint="{name}"/>\n'
        keyframe = f'  <keyframe>\n    <key name="offset" ctrl="0 {-offset!r}"/>\n  </keyframe>\n'
    # A comment in XML must not contain "--".
    facts, table = (text.replace("--", "- -") for text in ("\n".join(source.lines), parameter_table(model, source)))
    shape = {"joint": "slide", "axis": "1 0 0", "mass": repr(mass), "inertia": "1 1 1"}
    if not linear:
        shape = {"joint": "hinge", "axis": "0 0 1", "mass": "1", "inertia": f"{mass!r} {mass!r} {mass!r}"}
    parts = {"facts": facts, "table": table, "of_joint": of_joint, "actuators": actuators, "keyframe": keyframe} | shape
    return TEXT.format(model=plain(model.name), version=version(), time=time, name=name, step=STEP, **parts)


def friction_of_joint(model: Model) -> tuple[dict[str, str], dict[str, str]]:
    """Return the friction attributes of a joint, such as ``frictionloss``, and those of the actuator ``dcmotor``."""
    base, values = base_of(model.component).name, model.values
    if base not in MODELS_OF_MUJOCO:
        raise InputError(
            "MuJoCo lacks this friction model", path="mjcf", value=model.name, allowed=", ".join(MODELS_OF_MUJOCO), mend="Use --to c"
        )
    if directional(model.component) or variations_of(model.component):
        raise InputError(
            "MuJoCo has the same constant friction parameters for both directions",
            path="mjcf",
            value=model.name,
            mend="Identify the model without slots, or export it to c",
        )
    if base == "lugre" and math.isfinite(values["v_d"]):
        raise InputError(
            "the micro-damping of MuJoCo does not fade with speed", path="mjcf", value=values["v_d"], mend="Identify lugre without v_d"
        )
    if base == "lugre":
        lugre = " ".join(repr(float(values[key])) for key in ("sigma_0", "sigma_1", "F_C", "F_S", "v_S"))
        motor = {"motorconst": "0", "resistance": "1", "input": "none"}
        return {}, motor | {"damping": repr(float(values["sigma_2"])), "lugre": lugre}
    places = (("frictionloss", "F_C"), ("damping", "F_v"))
    return {key: repr(float(values[parameter])) for key, parameter in places if parameter in values}, {}
