"""Former places of modules: until release 0.4 a former name gives the same module, with one warning for each package."""

import sys
import warnings
from collections.abc import Sequence
from importlib import import_module
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec, PathFinder
from types import ModuleType

from bristle.core.former import refusal

PLACES = {
    "arm": "apps.arm",
    "bridges": "apps.targets",
    "certificates": "simulation.certificates",
    "comparison": "prediction.comparison",
    "controllers": "models.controllers",
    "demo": "cli.demonstration",
    "excitation": "prediction.excitation",
    "exports": "apps.targets",  # of the targets that left the package
    "figures": "report.figures",
    "figures.joints": "apps.arm.joints",
    "figures.loop_design": "apps.design.loop_design",
    "figures.many_runs": "apps.study.many_runs",
    "figures.rig_layout": "apps.paper.rig_layout",
    "fleet": "apps.study.fleet",
    "friction": "models.friction",
    "hysteresis": "models.hysteresis",
    "hysteresis.identification": "identification.hysteresis",
    "lab": "apps.lab",
    "loading": "core.loading",
    "loop": "apps.design",
    "loop.design": "apps.design.analysis",
    "loop.assessment": "simulation.assessment",
    "loop.linear_system": "simulation.linear_system",
    "loop.tuning": "simulation.tuning",
    "palette": "core.palette",
    "paper": "apps.paper",
    "paper.reproduce": "apps.paper.reproduction",
    "plants": "models.plants",
    "references": "models.references",
    "report.arm": "apps.arm.report",
    "report.design": "apps.design.report",
    "report.fleet": "apps.study.fleet.report",
    "report.study": "apps.study.report",
    "sensors": "models.sensors",
    "server": "apps.lab.server",
    "study": "apps.study",
    "testing": "contract",
    "testing.figures": "report.figures.contract",
    "translation": "engine.translation",
    "tune": "apps.tune",
}


def present_name(former: str) -> str:
    """Return the present name of a module of bristle; empty if no module had the former one."""
    parts = former.split(".")[1:]
    for count in range(len(parts), 0, -1):
        place = PLACES.get(".".join(parts[:count]))
        if place is not None:
            return ".".join(["bristle", place, *parts[count:]])
    return ""


class Former(MetaPathFinder, Loader):
    """Finder and loader of former names, asked first: it finds those that moved, and refuses those that were deleted."""

    def __init__(self) -> None:
        self._warned: set[str] = set()
        self._specs: dict[str, ModuleSpec | None] = {}

    def find_spec(
        self, fullname: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return how to load a former name, None for any other; refuse a deleted one with its successor."""
        if not fullname.startswith("bristle."):
            return None
        refused = refusal(*fullname.rsplit(".", 1))
        present = present_name(fullname)
        if not (refused or present) or _is_present(fullname, path):
            return None
        if refused:
            raise ModuleNotFoundError(refused)
        try:
            import_module(present)
        except ModuleNotFoundError as error:
            if error.name == present:
                return None
            raise
        return ModuleSpec(fullname, self)

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        """Return the present module."""
        present = present_name(spec.name)
        module = sys.modules[present]
        self._specs[spec.name] = module.__spec__
        self._warn(spec.name, present)
        return module

    def exec_module(self, module: ModuleType) -> None:
        """Give the module its own specification back: importing it under another name replaced it."""
        assert module.__spec__ is not None
        module.__spec__ = self._specs.pop(module.__spec__.name)

    def _warn(self, former: str, present: str) -> None:
        package = ".".join(former.split(".")[:2])
        if package in self._warned:
            return
        self._warned.add(package)
        warnings.warn(
            f"{former} is now {present}. The former name is removed in bristle 0.4",
            DeprecationWarning,
            stacklevel=3,
        )


def _is_present(name: str, path: Sequence[str] | None) -> bool:
    """Return whether a module has a former name today. Python would load children of a moved package from its files again."""
    package = name.rpartition(".")[0]
    is_moved = sys.modules[package].__name__ != package
    return not is_moved and PathFinder.find_spec(name, path) is not None


def install() -> None:
    """Let Python find the former names."""
    if not any(isinstance(finder, Former) for finder in sys.meta_path):
        sys.meta_path.insert(0, Former())
