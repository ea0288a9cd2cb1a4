"""ROS 2: a package with a chainable controller of ros2_control around the C of a friction model, which it includes unchanged."""

from typing import Any

import numpy as np

from bristle.apps.targets.hal import LEAD_MAX, refuse_velocity_mode, settings_of
from bristle.core.variable import unit_of
from bristle.exports.c import CFiles
from bristle.exports.c_code import Printer
from bristle.exports.c_parts import meaning_within
from bristle.exports.described import Request, plain, rendered, with_rights
from bristle.exports.subject import settled_subject, subject_of
from bristle.exports.targets import Product
from bristle.exports.tunable import Tunable, tunable_of

OF_C = ("{}.h", "{}.c", "{}_selftest.c")  # files of the export to C
FILES = {
    "{}.cpp": "ros2/controller.cpp",
    "{}.xml": "ros2/plugin.xml",
    "{}.yaml": "ros2/controllers.yaml",
    "CMakeLists.txt": "ros2/CMakeLists.txt",
    "package.xml": "ros2/package.xml",
    "README.md": "ros2/README.md",
}


def write(request: Request) -> Product:
    """Return the package; its parameters lead and limit have the values of the loop and of the drive."""
    refuse_velocity_mode(request, "ros2")
    places = ()
    if request.tunable:
        places = tunable_of(request.sampled).places
    c = CFiles(settled_subject(subject_of(request.sampled), places), request, feeds=True)
    own = {file.format(request.name) for file in OF_C}
    of_c = {file: text for file, text in c.files().items() if file in own}
    settings = settings_of(request)
    force = unit_of("force", request.model.kind)
    joint = "revolute"
    if request.model.kind == "translational":
        joint = "prismatic"
    notes = (
        f"the joint must be {joint}, and its drive must accept an effort in {force}",
        "the controller was not run in ROS 2",
    )
    package = f"{request.name}_controller"
    facts = c.facts() | {
        "package": package,
        "notes": [plain(note) for note in notes],
        "lead_max": LEAD_MAX,
        "lead": _yaml(settings.lead),
    }
    facts |= {"limit": _yaml(settings.limit * abs(settings.effort.si)), "tuned": []}
    if request.tunable:
        facts["tuned"] = _tuned(tunable_of(request.sampled), c.new_printer())
    facts |= {"rate": max(1, round(1.0 / request.dt))}
    texts = {file.format(package): rendered(template, facts) for file, template in FILES.items()}
    return Product({**of_c, **with_rights(texts, request.source)}, notes)


def _tuned(tuned: Tunable, printer: Printer) -> list[dict[str, Any]]:
    """Return name, field of the structure, size, value and meaning of each parameter that can change."""
    return [
        {
            "name": name,
            "field": printer.names.variable(name),
            "size": value.size if isinstance(value, np.ndarray) else 0,
        }
        | {"value": _yaml(value)}
        | {"meaning": plain(meaning_within(tuned.variables[name], tuned.kind)).replace('"', "'")}
        for name, value in tuned.values.items()
    ]


def _yaml(value: Any) -> str:
    """Return numbers as text of YAML, where a number with an exponent needs a point."""
    if isinstance(value, np.ndarray):
        return f"[{', '.join(map(_yaml, value.tolist()))}]"
    text = repr(value)
    if "e" in text and "." not in text:
        return text.replace("e", ".0e")
    return text.replace("inf", ".inf")
