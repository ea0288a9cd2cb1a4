"""The targets of the export: what one is asked for and writes, how one is declared, and those of bristle as help lists them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from bristle.core.axis import Axis
    from bristle.core.contracts import Model
    from bristle.core.experiment import Variant
    from bristle.exports.described import Source
    from bristle.exports.effect import Drive, Effect
    from bristle.exports.law import Law
    from bristle.logs.log import Log


def _no_source() -> Source:
    from bristle.exports.described import Source  # whoever asks for help waits for nothing that computes

    return Source()


@dataclass(frozen=True)
class Request:
    """What is to be exported, and how.

    Parameters
    ----------
    model : Model
        A friction model with parameters.
    name : str
        What files, types and functions are called.
    dt : float
        Time step [s].
    source : Source
        Where the values come from.
    tunable : bool
        Whether parameters may be changed at run time.
    single : bool
        Whether numbers are of single precision.
    axis : Axis or None
        The axis, whose columns tell the units of a table.
    speed : float
        Largest speed of a table [m/s or rad/s].
    points : int
        Entries of a table, at most; 3 of a ``table`` are gravity and one level for each direction.
    mass : float
        What a scene moves [kg or kg*m^2].
    plant : Model or None
        What the friction is on, where it is known.
    log : Log or None
        Along whose motion a table is compared with the model.
    info : mapping
        What a model file tells besides: ``provenance``, which log it was fitted to, and how that was treated,
        ``treatment``.
    rest : {"held", "middle", ""}
        Force of a memoryless model at rest: that of the side it came from, or the mean of both sides; that of the
        target where nothing is said.
    loop : Variant or None
        The loop of the axis along the motion of its log, in which the effect of the files is simulated.
    """

    model: Model
    name: str
    dt: float
    source: Source = field(default_factory=_no_source)
    tunable: bool = False
    single: bool = False
    axis: Axis | None = None
    speed: float = 0.0
    points: int = 20
    mass: float = 1.0
    plant: Model | None = None
    log: Log | None = None
    info: Mapping[str, Any] = field(default_factory=dict)
    rest: str = ""
    loop: Variant | None = None

    @property
    def sampled(self) -> Model:
        """The model as it is evaluated along samples: one without memory has a rule at rest."""
        from bristle.friction.resting import with_rest

        return with_rest(self.model, self.rest) if self.rest else self.model


@dataclass(frozen=True)
class Product:
    """The files of an export.

    Parameters
    ----------
    files : dict of str to str or bytes
        Content by name.
    notes : tuple of str
        What the target loses or does otherwise, a sentence each.
    effect : Effect or None
        What the files do to the axis, where bristle can tell.
    """

    files: dict[str, str | bytes]
    notes: tuple[str, ...] = ()
    effect: Effect | None = None


@dataclass(frozen=True, kw_only=True)
class Target:
    """A target that a model can be exported to: one file of Python, in `bristle.exports.targets` or of a user's own.

    Parameters
    ----------
    name : str
        What ``--to`` asks for: small letters, digits and underscores.
    description : str
        What is written, in one sentence.
    write : callable
        ``write(request)``, a `Request`: the `Product`. What it cannot hold it refuses with an `InputError`.
    title : str
        What people call it, where that is not its name.
    write_law : callable or None
        ``write_law(law, name, source)``: the files of a control law, or a `Product` where there are notes on them, for
        a target that holds one; ``law.tunable`` and ``law.single`` are as those of a `Request`.
    tunable : bool
        Whether it can leave parameters to be changed at run time.
    single : bool
        Whether it can write numbers of single precision.
    operators : bool
        Whether it holds a hysteresis operator, too.
    compares : bool
        Whether it tells how far it is from the model along a log.
    rest : {"held", "middle", ""}
        Its usual rule for the force of a memoryless model at rest; empty where it evaluates no model along samples.
    reads : callable or None
        ``reads(files, request)``: what a drive computes from the numbers of the files, as a `Drive`; None where
        that is not known.
    pushes : bool
        Whether the files act on an axis: one that makes the error larger is then refused.
    of_cogging : bool
        Whether the files compensate cogging instead of friction.
    needs : str
        What it takes besides a model file and an axis file: the served lab offers none of these.
    """

    name: str
    description: str
    write: Callable[[Request], Product]
    title: str = ""
    write_law: Callable[[Law, str, Source], dict[str, str | bytes] | Product] | None = None
    tunable: bool = False
    single: bool = False
    operators: bool = False
    compares: bool = False
    rest: str = ""
    reads: Callable[[Mapping[str, str | bytes], Request], Drive | None] | None = None
    pushes: bool = False
    of_cogging: bool = False
    needs: str = ""

    def __post_init__(self) -> None:
        """Refuse files that act on an axis where bristle cannot tell how."""
        if self.pushes and self.reads is None and not self.rest:
            from bristle.core.errors import InputError

            mend = "Write reads=reads, a function reads(files, request) that returns the force the drive computes from the files"
            raise InputError("acts on an axis (pushes=True), and its effect is not known", path=f"target {self.name}", mend=mend)

    @property
    def module(self) -> str:
        """The module that defines it."""
        return self.write.__module__


def _of_module(module: str, function_name: str, **fixed: Any) -> Callable[..., Any]:
    """Return a function of a module of the exports, which is loaded when it is called."""

    def called(*arguments: Any) -> Any:
        return getattr(import_module(f"bristle.exports.{module}"), function_name)(*arguments, **fixed)

    called.__module__ = f"bristle.exports.{module}"
    return called


def _target(name: str, title: str, rest: str, able: str, functions: str, description: str, *, needs: str = "", **fixed: Any) -> Target:
    """Return a target that is `able` to do some things, and whose functions stand in modules: ``write=module.function``."""
    pairs = (word.partition("=")[::2] for word in functions.split())
    facts: dict[str, Any] = {key: _of_module(*place.split("."), **fixed) for key, place in pairs} | dict.fromkeys(able.split(), True)
    return Target(name=name, title=title, rest=rest, description=description, needs=needs, **facts)


_C = (
    "C99: a header, a source that compiles alone, an example, and a self-test that proves that the target gives the same bits; nothing "
    "is compiled here, and no compiler is needed"
)
_ST = "a function block in Structured Text for a PLC, its self-test, and both as XML of PLCopen"
_TABLE = (
    "effort over velocity as CSV, in the units of the log and of the drive that AXIS.toml describes; with --points 3, gravity, level and "
    "viscous friction for each direction, and the inertia"
)
_TF5200 = (
    "the list of compensation values of the friction compensation of a Beckhoff TF5200 CNC; it takes the rated effort of the drive from "
    "AXIS.toml"
)
_AX8000 = (
    "static and dynamic friction of a Beckhoff AX8000 or AMP8000 drive, objects 0x3144:02 and :03, and its spring rate, :01, where the "
    "model knows it"
)
_START_VALUES = "start values for the friction compensation of a SINUMERIK, to be tuned by the circularity test"
_COGGING = "harmonics of cogging, where they were identified"
_FMU = (
    "FMUs for FMI {}.0, of the friction and, where the model file has a plant, of both, for co-simulation and, where the model has "
    "continuous time, model exchange, with a library for each platform that there is a compiler for; of a control law, for co-simulation"
)
_WASM = "a module of WebAssembly and the script that loads it, for a browser or node"
_CUDA = "CUDA C++: lanes of a graphics processor, thousands of axes beside each other"
_OF_FMU = "write=fmu.write write_law=fmu.write_law"
_ALL = "pushes tunable single operators"
_LISTED = (
    _target("c", "C", "held", _ALL, "write=c.write write_law=c.law_files", _C),
    _target("wasm", "WebAssembly", "middle", "", "write=wasm.write", _WASM),
    _target("st", "Structured Text", "held", _ALL, "write=st.write write_law=st.st_law_files", _ST),
    _target("cuda", "CUDA", "middle", "operators", "write=cuda.write", _CUDA),
    _target("table", "table for a drive", "held", "pushes compares", "write=drive.write reads=drive.reads", _TABLE),
    _target("tf5200", "Beckhoff TF5200", "", "pushes compares", "write=tf5200.write reads=tf5200.reads", _TF5200),
    _target("ax8000", "Beckhoff AX8000", "", "pushes", "write=ax8000.write reads=ax8000.reads", _AX8000),
    _target("sinumerik", "SINUMERIK", "", "pushes", "write=sinumerik.write reads=sinumerik.reads", _START_VALUES),
    _target("cogging", "", "", "pushes of_cogging", "write=cogging.write reads=cogging.reads", _COGGING),
    _target("mjcf", "MuJoCo", "", "", "write=mjcf.write", "a scene of MuJoCo with what it has of friction"),
    *(_target(f"fmu{fmi}", f"FMU {fmi}", "middle", "tunable", _OF_FMU, _FMU.format(fmi), needs="a compiler", fmi=fmi) for fmi in (2, 3)),
)
TARGETS: dict[str, Target] = {target.name: target for target in _LISTED}  # Every target of bristle, by name
