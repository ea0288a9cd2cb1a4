"""What may be missing where the tests run: the reasons for which a run of CI may skip a test."""

import re

LIBRARIES = "casadi|jax|torch|warp|newton|gymnasium|pydrake"
ALLOWED = {
    "simulators and derivatives, in an environment of their own": re.compile(
        rf"could not import '(?:{LIBRARIES})|needs (?:{LIBRARIES})"
    ),
    "a graphics processor": re.compile("needs a graphics processor|cuda.bindings.driver"),
    "LinuxCNC, MATIEC, and compilers for other processors": re.compile(
        r"halcompile|LinuxCNC|HAL is in use|cannot install a component|MATIEC|needs (?:[\w-]+-gcc|qemu-|clang)"
    ),
    "a user who is not the superuser": re.compile("superuser"),
    "a second browser": re.compile("firefox"),
    "measured logs, which the project does not contain": re.compile(
        "BRISTLE_DATA|measured logs|logs? of the (?:arms|motor)"
    ),
}


def allowed_reason(text):
    """Return the name of the reason that a skip states, None if it is none of those that are allowed."""
    return next((name for name, pattern in ALLOWED.items() if pattern.search(text)), None)
