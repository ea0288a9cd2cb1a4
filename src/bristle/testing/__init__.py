"""Public tests: the contract suite that every friction model must pass, ours or a user's."""

from bristle.testing.admission import admit, admit_friction_of
from bristle.testing.contract import CHECKS, Check, check_model, example_of

__all__ = ["CHECKS", "Check", "admit", "admit_friction_of", "check_model", "example_of"]
