"""Names of release 0.2 that moved or were removed: each works with a warning until 0.4, or its error states the successor."""

import sys
import warnings
from collections.abc import Sequence
from functools import partial
from importlib import import_module
from importlib.machinery import ModuleSpec
from importlib.util import find_spec
from types import ModuleType
from typing import Any

# Modules that hold the names which a package of 0.2 offered; the first four packages do not exist any more.
HOMES = {
    "bristle.workflow": ("report.identified", "report.compared", "report.model_in_hand", "report.prepared"),
    "bristle.stability": ("loop.assessment", "loop.linear_system", "loop"),
    "bristle.loop_design": ("loop.design", "loop.tuning", "loop.budget"),
    "bristle.hysteresis_identification": (
        "hysteresis.identification.identify",
        "hysteresis.identification.linear",
        "hysteresis.identification.result",
    ),
    "bristle.certificates": ("certificates.quasi_static",),
    "bristle.demo": ("demo.run",),
    "bristle.figures": (
        "figures.rig_layout",
        "figures.loop_rows",
        "figures.small_multiples",
        "figures.loop_design",
        "figures.comparison",
        "figures.fit",
        "figures.many_runs",
        "figures.following_error",
        "figures.preisach",
        "figures.recorded",
    ),
    "bristle.fleet": ("fleet.plan",),
    "bristle.identification": ("identification.result",),
    "bristle.paper": ("paper.reproduced",),
    "bristle.study": ("study.run",),
}
PACKAGES = tuple(HOMES)[:4]
SUCCESSORS = {
    "bristle.certificates.traced_by_force": "Call traced(model, Path.to_force, levels)",
    "bristle.certificates.traced_by_position": "Call traced(model, Path.to_position, turns)",
    "bristle.engine.force_in_turns": "Call force_along for each trajectory",
    "bristle.figures.comparison_in_short": "Call figures.comparison.change_at_reversal(compared)",
    "bristle.figures.drive_table": "The reports have the table",
    "bristle.figures.first_page": "Call figures.gain_at_reversal and figures.friction_over_velocity",
    "bristle.figures.loops_at_reversal": "Call figures.gain_at_reversal(result, names)",
    "bristle.figures.model_comparison": "The reports have the table",
    "bristle.figures.parameters": "The reports have the table",
    "bristle.figures.study_influence": "The reports have the table",
    "bristle.fleet.watch": "Run bristle identify LOGS --each instead",
    "bristle.logs.sign_of_effort": "Run bristle log",
}


def removed_name(package: str, name: str) -> Any:
    """Return the object that a package of 0.2 offered under this name, with a warning.

    Raises
    ------
    AttributeError
        If bristle has no such name; the message states its successor, if there was such a name.
    """
    if name.startswith("_"):
        raise AttributeError(f"module {package!r} has no attribute {name!r}")
    is_module = package not in PACKAGES and package in HOMES and find_spec(f"{package}.{name}") is not None
    for home in () if is_module else HOMES.get(package, ()):
        module = import_module(f"bristle.{home}")
        value = vars(module).get(name)
        is_own = (
            value is not None and not isinstance(value, ModuleType) and getattr(value, "__module__", module.__name__) == module.__name__
        )
        if is_own and f"{package}.{name}" not in SUCCESSORS:
            text = f"{package}.{name} moved to bristle.{home}.{name}. The old name is removed in bristle 0.4"
            warnings.warn(text, DeprecationWarning, stacklevel=3)
            return value
    advice = SUCCESSORS.get(f"{package}.{name}")
    raise AttributeError(
        f"{package}.{name} was removed in bristle 0.3. {advice}" if advice else f"module {package!r} has no attribute {name!r}"
    )


class _FormerPackages:
    """Finder and loader of the packages of 0.2 that do not exist any more."""

    def find_spec(self, fullname: str, path: Sequence[str] | None = None, target: ModuleType | None = None) -> ModuleSpec | None:
        return ModuleSpec(fullname, self) if fullname in PACKAGES else None  # type: ignore[arg-type]

    def create_module(self, spec: ModuleSpec) -> None:
        return None

    def exec_module(self, module: ModuleType) -> None:
        vars(module)["__getattr__"] = partial(removed_name, module.__name__)


def install() -> None:
    """Let Python find the former packages."""
    if not any(isinstance(finder, _FormerPackages) for finder in sys.meta_path):
        sys.meta_path.append(_FormerPackages())  # type: ignore[arg-type]
