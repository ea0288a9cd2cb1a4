"""The targets of the export: the product, the declaration of a target, and the targets of bristle as help lists them."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pkgutil import resolve_name
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from bristle.exports.described import Request, Source
    from bristle.exports.effect import Drive, Effect
    from bristle.exports.law import Law


VALID_NAME = re.compile("[a-z][a-z0-9_]{0,40}")
NAME = "axis_x"  # The default name of an export


@dataclass(frozen=True)
class Product:
    """The files of an export.

    Parameters
    ----------
    files : dict of str to str or bytes
        Content by name.
    notes : tuple of str
        Losses and differences of the target, one sentence each.
    effect : Effect or None
        Effect of the files on the axis, if bristle knows it.
    error : mapping or None
        Force error of files that approximate the model: ``rms`` and ``largest`` in % of ``level``, the sliding friction
        [N or N*m].
    """

    files: dict[str, str | bytes]
    notes: tuple[str, ...] = ()
    effect: Effect | None = None
    error: Mapping[str, float] | None = None


@dataclass(frozen=True, kw_only=True)
class Target:
    """A target of the export, defined by bristle or by a Python file of the user.

    Parameters
    ----------
    name : str
        Name for ``--to``: small letters, digits and underscores.
    description : str
        Contents of the export, in one sentence.
    write : callable
        ``write(request)`` takes a `Request` and returns the `Product`. It raises an `InputError` for a model that the
        target cannot represent.
    title : str
        Title, if it differs from the name.
    write_law : callable or None
        ``write_law(law, name, source)`` returns the files of a control law, or a `Product` with notes. ``law.tunable``
        and ``law.single`` have the meaning of a `Request`. None if the target has no control laws.
    tunable : bool
        Whether the target supports parameters that change at run time.
    single : bool
        Whether the target supports single precision.
    derivatives : bool
        Whether the target supports derivatives of friction.
    operators : bool
        Whether the target supports hysteresis operators.
    compares : bool
        Whether the target compares its files with the model along a log.
    rest : {"held", "middle", ""}
        Default rule for the force of a memoryless model at rest; empty if the target evaluates no model along samples.
    reads : callable or None
        ``reads(files, request)`` returns the force that a drive computes from the files, as a `Drive`. None if the
        computation is unknown.
    pushes : bool
        Whether the files act on an axis. bristle then refuses an export that makes the error larger.
    of_cogging : bool
        Whether the files compensate cogging and not friction.
    needs : str
        Requirements besides a model file and an axis file. The served lab does not offer such targets.
    """

    name: str
    description: str
    write: Callable[[Request], Product]
    title: str = ""
    write_law: Callable[[Law, str, Source], dict[str, str | bytes] | Product] | None = None
    tunable: bool = False
    single: bool = False
    derivatives: bool = False
    operators: bool = False
    compares: bool = False
    rest: str = ""
    reads: Callable[[Mapping[str, str | bytes], Request], Drive | None] | None = None
    pushes: bool = False
    of_cogging: bool = False
    needs: str = ""

    def __post_init__(self) -> None:
        """Refuse a target that cannot be used, or that acts on an axis in an unknown way."""
        from bristle.core.errors import InputError

        needed = {
            "name": (
                isinstance(self.name, str) and VALID_NAME.fullmatch(self.name),
                "small letters, digits and _",
            ),
            "description": (
                isinstance(self.description, str) and self.description.strip(),
                "a sentence",
            ),
            "write": (callable(self.write), "a function of a Request"),
            "write_law": (
                self.write_law is None or callable(self.write_law),
                "a function of a law, a name and a source",
            ),
            "reads": (
                self.reads is None or callable(self.reads),
                "a function of files and a Request",
            ),
            "tunable": (isinstance(self.tunable, bool), "True or False"),
            "rest": (self.rest in ("", "held", "middle"), "held, middle, or empty text"),
        }
        for name, (is_valid, allowed) in needed.items():
            if not is_valid:
                raise InputError(
                    f"has no valid {name}",
                    path=f"target {self.name}",
                    value=getattr(self, name),
                    allowed=allowed,
                )
        if self.pushes and self.reads is None and not self.rest:
            raise InputError(
                "acts on an axis (pushes=True), but bristle cannot compute the effect",
                path=f"target {self.name}",
                mend="Write reads=reads, a function reads(files, request) that returns the force the drive computes from the files",
            )

    @property
    def module(self) -> str:
        """Module of the target."""
        return self.write.__module__

    @property
    def useless(self) -> list[str]:
        """Options without effect on a target of bristle; a target of your own may use each of them."""
        return [
            key for key, users in USERS.items() if self.name in TARGETS and self.name not in users
        ]


def at(place: str, **fixed: Any) -> Callable[..., Any]:
    """Return the function at ``module:name``; its first call loads the module."""

    def called(*arguments: Any) -> Any:
        return resolve_name(place)(*arguments, **fixed)

    called.__module__ = place.partition(":")[0]
    return called


_FMU = (
    "FMUs for FMI {}.0. The first FMU contains the friction. If the model file has a plant, a second FMU contains friction and plant. Both "
    "support co-simulation and, if the model has continuous time, model exchange. The FMU of a control law supports co-simulation. "
    "Each FMU contains a library for each platform whose compiler is installed"
)


def _fmu(fmi: int) -> Target:
    return Target(
        name=f"fmu{fmi}",
        title=f"FMU {fmi}",
        rest="middle",
        tunable=True,
        write=at("bristle.apps.targets.fmu:write", fmi=fmi),
        write_law=at("bristle.apps.targets.fmu:write_law", fmi=fmi),
        description=_FMU.format(fmi),
        needs="a compiler",
    )


_LISTED = (
    Target(
        name="c",
        title="C",
        rest="held",
        pushes=True,
        tunable=True,
        single=True,
        operators=True,
        derivatives=True,
        write=at("bristle.exports.c:write"),
        write_law=at("bristle.exports.c:law_files"),
        description="C99: a header, a source without dependencies, an example, and a self-test that checks the results of"
        " the target bit by bit. The export needs no compiler",
    ),
    Target(
        name="wasm",
        title="WebAssembly",
        rest="middle",
        write=at("bristle.apps.targets.wasm:write"),
        description="a WebAssembly module and the script that loads it, for a browser or node",
    ),
    Target(
        name="st",
        title="Structured Text",
        rest="held",
        pushes=True,
        tunable=True,
        single=True,
        operators=True,
        write=at("bristle.apps.targets.st:write"),
        write_law=at("bristle.apps.targets.st:st_law_files"),
        description="a function block in Structured Text for a PLC, its self-test, and both as XML of PLCopen",
    ),
    Target(
        name="hal",
        title="LinuxCNC",
        rest="held",
        pushes=True,
        compares=True,
        write=at("bristle.apps.targets.hal:write"),
        write_law=at("bristle.apps.targets.hal:hal_law_files"),
        description="a HAL component of LinuxCNC for an amplifier in torque mode, a HAL file for the machine, a table for"
        " the component lincurve, and a self-test that checks the results bit by bit. The component needs "
        "halcompile",
    ),
    Target(
        name="ros2",
        title="ROS 2",
        rest="held",
        pushes=True,
        tunable=True,
        write=at("bristle.apps.targets.ros2:write"),
        description="a ROS 2 package with a chainable controller of ros2_control: it adds the friction along the "
        "reference of joints to their effort. The controller contains the C files, bit-identical to Python",
    ),
    Target(
        name="cuda",
        title="CUDA",
        rest="middle",
        operators=True,
        write=at("bristle.apps.targets.cuda:write"),
        description="CUDA C++: thousands of axes in parallel on a graphics processor",
    ),
    Target(
        name="warp",
        title="Warp",
        write=at("bristle.apps.targets.warp:write"),
        description="friction of thousands of joints in Warp, as a drive of Newton and as an actuator of Isaac Lab",
    ),
    Target(
        name="casadi",
        title="CasADi",
        rest="held",
        write=at("bristle.apps.targets.casadi:write"),
        description="C with exact first derivatives, as external functions of CasADi. The parameters are inputs",
    ),
    Target(
        name="table",
        title="table for a drive",
        rest="held",
        pushes=True,
        compares=True,
        write=at("bristle.exports.drive:write"),
        reads=at("bristle.exports.drive:reads"),
        description="effort over velocity as CSV, in the units of the log and of the drive of AXIS.toml. With --points 3:"
        " gravity, the inertia, and level and viscous friction of each direction",
    ),
    Target(
        name="tf5200",
        title="Beckhoff TF5200",
        pushes=True,
        compares=True,
        write=at("bristle.exports.tf5200:write"),
        reads=at("bristle.exports.tf5200:reads"),
        description="the list of compensation values for the friction compensation of a Beckhoff TF5200 CNC. AXIS.toml "
        "must contain the rated effort of the drive",
    ),
    Target(
        name="ax8000",
        title="Beckhoff AX8000",
        pushes=True,
        write=at("bristle.exports.ax8000:write"),
        reads=at("bristle.exports.ax8000:reads"),
        description="static and dynamic friction for objects 0x3144:02 and 0x3144:03 of a Beckhoff AX8000 or AMP8000 "
        "drive; also the spring rate, object 0x3144:01, if the model has a pre-sliding distance",
    ),
    Target(
        name="sinumerik",
        title="SINUMERIK",
        pushes=True,
        write=at("bristle.exports.sinumerik:write"),
        reads=at("bristle.exports.sinumerik:reads"),
        description="start values for the friction compensation of a SINUMERIK. Tune them with the circularity test",
    ),
    Target(
        name="cogging",
        pushes=True,
        of_cogging=True,
        write=at("bristle.exports.cogging:write"),
        reads=at("bristle.exports.cogging:reads"),
        description="the identified harmonics of the cogging force",
    ),
    Target(
        name="mjcf",
        title="MuJoCo",
        write=at("bristle.apps.targets.mjcf:write"),
        description="a MuJoCo scene with the friction of the model",
    ),
    _fmu(2),
    _fmu(3),
)
# Every target of bristle, by name.
TARGETS: dict[str, Target] = {target.name: target for target in _LISTED}
WITHOUT_STEP = {"table", "tf5200", "ax8000", "sinumerik", "cogging", "mjcf"}
WITHOUT_SPEED = {"wasm", "cuda", "warp", "casadi", "mjcf", "fmu2", "fmu3"}
USERS = {  # the targets of options
    "mass": {"mjcf"},
    "points": {"table", "tf5200"},
    "table": {"fmu2", "fmu3"},
    "step": TARGETS.keys() - WITHOUT_STEP,
    "speed": TARGETS.keys() - WITHOUT_SPEED,
}
