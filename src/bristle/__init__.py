"""bristle: from the log of a motion axis to an identified friction model and a compensated loop.

Modules are loaded at first use, so ``import bristle`` is fast.

Examples
--------
>>> import bristle as br
>>> model = br.friction.lugre(F_C="34 mN*m", F_S="40 mN*m", v_S="0.5 rad/s", sigma_0="100 N*m/rad")
>>> br.response(model, [0.0, 1e-4, 2e-4], dt=1e-3).round(4)
array([0.    , 0.0046, 0.0124])
"""

from typing import TYPE_CHECKING

from bristle.core.aliases import install
from bristle.core.loading import loaded_from

if TYPE_CHECKING:
    from bristle import core, engine, simulation
    from bristle.apps import arm
    from bristle.apps.design import design
    from bristle.apps.study import read_study
    from bristle.core.axis import Axis
    from bristle.engine import response
    from bristle.exports import export
    from bristle.files import (
        load_code,
        propose_axis,
        read_axis,
        read_curves,
        read_experiment,
        read_log,
        read_model,
        write_model,
    )
    from bristle.identification.explain import explain
    from bristle.identification.hysteresis import identify_operator
    from bristle.logs.log import Log
    from bristle.models import controllers, friction, hysteresis, plants, references, sensors
    from bristle.prediction import predict
    from bristle.prediction.excitation import excite
    from bristle.report import figures
    from bristle.report.compared import compare
    from bristle.report.identified import identify
    from bristle.report.model_in_hand import load
    from bristle.report.prepared import prepare
    from bristle.simulation import simulate
    from bristle.simulation.certificates import check

__version__ = "0.3.0"
__getattr__ = loaded_from(__name__)
install()

__all__ = [
    "Axis",
    "Log",
    "__version__",
    "check",
    "compare",
    "controllers",
    "core",
    "design",
    "engine",
    "excite",
    "explain",
    "export",
    "figures",
    "friction",
    "hysteresis",
    "identify",
    "identify_operator",
    "load",
    "load_code",
    "plants",
    "predict",
    "prepare",
    "propose_axis",
    "read_axis",
    "read_curves",
    "read_experiment",
    "read_log",
    "read_model",
    "read_study",
    "references",
    "response",
    "sensors",
    "simulate",
    "simulation",
    "write_model",
]


def __dir__() -> list[str]:
    return __all__
