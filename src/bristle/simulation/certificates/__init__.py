"""Certificates: tests that a model is fit for use. Each has a file, a number and a limit."""

from typing import TYPE_CHECKING

from bristle.core.loading import loaded_from

if TYPE_CHECKING:
    from bristle.simulation.certificates.certificate import Certificate
    from bristle.simulation.certificates.certify import check
    from bristle.simulation.certificates.passive import needed_damping
    from bristle.simulation.certificates.quasi_static import Path, holding_of, traced

__getattr__ = loaded_from(__name__)
