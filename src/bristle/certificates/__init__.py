"""Certificates: is this model fit to be used? One file a question, each answered with a number and a limit."""

from bristle.certificates.certificate import Certificate
from bristle.certificates.certify import check
from bristle.certificates.passive import needed_damping
from bristle.certificates.quasi_static import Path, holding_of, traced

__all__ = ["Certificate", "Path", "check", "holding_of", "needed_damping", "traced"]
