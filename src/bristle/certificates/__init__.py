"""Certificates: tests that a model is fit for use. Each has a file, a number and a limit."""

from typing import TYPE_CHECKING

from bristle.loading import loaded_from

if TYPE_CHECKING:
    from bristle.certificates.certificate import Certificate
    from bristle.certificates.certify import check
    from bristle.certificates.passive import needed_damping
    from bristle.certificates.quasi_static import Path, holding_of, traced

__getattr__ = loaded_from(__name__)
