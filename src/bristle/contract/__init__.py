"""Public contract suites for built-in and user models, slots, laws, sensors, log readers, figures and export targets."""

from typing import TYPE_CHECKING

from bristle.core.loading import loaded_from

if TYPE_CHECKING:
    from collections.abc import Callable

    from bristle.contract.admission import admit, admit_friction_of
    from bristle.contract.check import Fact, UnmetError, outcomes
    from bristle.contract.contract import CHECKS, Check, check_model, example_of
    from bristle.contract.readers import check_reader
    from bristle.contract.targets import check_target

    check_figure: Callable[..., list[Check]]

__getattr__ = loaded_from(__name__, above={"check_figure": "bristle.report.figures.contract"})

__all__ = [
    "CHECKS",
    "Check",
    "admit",
    "admit_friction_of",
    "check_figure",
    "check_model",
    "check_reader",
    "check_target",
    "example_of",
]
