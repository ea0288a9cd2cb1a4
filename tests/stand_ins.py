"""Stand-ins of results, with the fields that a test gives."""

from types import SimpleNamespace

from bristle.simulation.result import VariantResult


class Loop(SimpleNamespace):
    """A simulated variant; which error reports compare is the library's own rule. Loops compare by identity."""

    at_load, load_reference, kind = False, None, "translational"
    compared, compared_error = VariantResult.compared, VariantResult.compared_error
    error_word, error = VariantResult.error_word, VariantResult.error
    __eq__, __hash__ = object.__eq__, object.__hash__
