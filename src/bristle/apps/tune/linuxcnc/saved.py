"""Sources of guard and model, and a kept feedforward as files beside the configuration of LinuxCNC."""

import hashlib
import re
from importlib.resources import files
from pathlib import Path

from bristle.apps.tune.linuxcnc.hal import Hal
from bristle.apps.tune.machine import MachineRefusedError
from bristle.files import write_whole

GUARD = "bristle-guard"  # prefix of its pins
MARK = "Written by bristle tune --save, sha256"


def guard() -> str:
    """Return the name of the guard: HAL cannot load that of another version of bristle, for it has another hash."""
    return f"bristle_guard_{_digest(_guard_text())[:8]}"


def source_of(name: str, folder: Path) -> str:
    """Return the source of the guard, or of the component of the model in a folder of results."""
    from bristle.report.exported import export_model_file

    if prefix_of(name) == GUARD:
        if name != guard():
            raise MachineRefusedError(
                "old_guard",
                f"HAL runs the guard of another version of bristle, {name}",
                "Use that version",
            )
        return _guard_text().replace("component bristle_guard ", f"component {name} ", 1)
    exported = export_model_file(folder / "model.toml", "hal", command="bristle tune", name=name)
    return str(exported.product.files[f"{name}.comp"])


def prefix_of(name: str) -> str:
    """Return the beginning of the pins of a component."""
    if name.startswith("bristle_guard"):
        return GUARD
    return name.replace("_", "-")


def hal_lines(hal: Hal, thread: str, motor: str, sampler: str) -> list[str]:
    """Return the HAL commands that rebuild guard, model and sampler as they are, with their links and places in the thread."""
    components = [name for name in hal.components() if name.startswith("bristle_")]
    pins = [*map(prefix_of, components), "sampler"]
    own = tuple(f"{name}." for name in pins)
    nets = {
        signal: [pin for pin in linked if pin.startswith(own) or pin == motor]
        for signal, linked in hal.links().items()
    }
    return [
        *(
            f"loadrt {name}{f' names={GUARD}' if prefix_of(name) == GUARD else ''}"
            for name in components
        ),
        sampler,
        *(f"setp {name} {value}" for name, value in hal.value_of_parameters(pins).items()),
        f"unlinkp {motor}",
        *(f"net {signal} {' '.join(linked)}" for signal, linked in nets.items() if linked),
        *(
            f"addf {name} {thread} {at}"
            for at, name in enumerate(hal.functions(thread), 1)
            if f"{name}.".startswith(own)
        ),
    ]


def places(path: Path) -> dict[str, str]:
    """Return the hash of each file that a saved HAL file needs, and its own; empty for a missing file."""
    names = re.findall(
        r"^loadrt (bristle_\w+)",
        path.read_text(encoding="utf-8", errors="replace") if path.exists() else "",
        re.MULTILINE,
    )
    return {
        str(file): _hash_of(file)
        for file in (*(path.with_name(f"{name}.comp") for name in names), path)
    }


def write_marked(texts: dict[Path, str]) -> dict[str, str]:
    """Write files with their hash in the first line, unless a file of the user has one of their names; return the hashes."""
    for path in texts:
        _hash_of(path)
    for path, text in texts.items():
        write_whole(
            path, f"{'#' if path.suffix == '.hal' else '//'} {MARK} {_digest(text)}\n{text}"
        )
    return {str(path): _digest(text) for path, text in texts.items()}


def _hash_of(path: Path) -> str:
    """Return the hash in the first line of a file that bristle wrote; refuse a file that is of the user, or was changed."""
    if not path.exists():
        return ""
    first, _, text = path.read_text(encoding="utf-8", errors="replace").partition("\n")
    if not first.endswith(f"{MARK} {_digest(text)}"):
        raise MachineRefusedError(
            "own_file",
            f"{path} is not a file of bristle tune --save, or was changed since",
            "Move it, or name another file in the key save of the machine file",
        )
    return _digest(text)


def _guard_text() -> str:
    return (files("bristle.apps.tune.linuxcnc") / "bristle_guard.comp").read_text(encoding="utf-8")


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()
