"""Public tests: the contract suites that friction models, laws, sensors and targets must pass, ours or a user's."""

from bristle.testing.admission import admit
from bristle.testing.contract import CHECKS, Check, check_model, example_of
from bristle.testing.kernel_subset import violations_of
from bristle.testing.targets import check_target

__all__ = ["CHECKS", "Check", "admit", "check_model", "check_target", "example_of", "violations_of"]
