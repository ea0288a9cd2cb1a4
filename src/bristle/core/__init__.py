"""Contracts, kernels, variables, units and errors: the foundation of all parts of bristle."""

from typing import TYPE_CHECKING

from bristle.core.kernel import kernel
from bristle.core.loading import loaded_from

if TYPE_CHECKING:
    from bristle.core.axis import Axis, Column, Injected, KnownColumn
    from bristle.core.content import (
        SIZE_LIMIT,
        Content,
        Origin,
        Readable,
        content_of,
        size_in_words,
        size_of,
    )
    from bristle.core.contracts import (
        Component,
        Controller,
        FrictionModel,
        HysteresisOperator,
        Model,
        Motion,
        Plant,
        Reference,
        Relation,
        Sensor,
        Trajectory,
        example_of,
    )
    from bristle.core.cores import Abreast, abreast, core_count, cores_for_simulations
    from bristle.core.diagnostic import Diagnostic
    from bristle.core.dimensions import NAMES, Kind
    from bristle.core.dispatch import everett
    from bristle.core.edge import (
        TEXT,
        Amount,
        Progress,
        amount,
        array,
        between,
        guarded,
        instance,
        many,
        model,
        optional,
        whole,
    )
    from bristle.core.errors import (
        BristleError,
        InputError,
        InputWarning,
        MissingExtraError,
        TooShortError,
        did_you_mean,
        error_text,
        in_one_line,
        located,
        place_in_own_code,
        said_by_library,
        shortened,
    )
    from bristle.core.experiment import Experiment, Feedforward, Run, Variant
    from bristle.core.fingerprint import digest
    from bristle.core.formula import spelt_out
    from bristle.core.lazy import cached_property
    from bristle.core.least_squares import apart_from, non_negative, unbounded
    from bristle.core.locks import LOADING
    from bristle.core.mathematics import exp
    from bristle.core.normal import DEVIATION_OVER_MEDIAN, NORMAL_95
    from bristle.core.random_numbers import SEED_MAX
    from bristle.core.slot import Slot
    from bristle.core.status import Status
    from bristle.core.surroundings import Surrounding
    from bristle.core.symbols import GREEK, symbolic
    from bristle.core.tabular import Card, WithCard, library
    from bristle.core.typography import (
        Scale,
        escaped,
        number,
        printable,
        scale_of,
        typeset,
        with_unit,
    )
    from bristle.core.units import compatible, convert, factor, is_unit, quantity, split
    from bristle.core.variable import KINDS, Variable, unit_of, variables_of

__getattr__ = loaded_from(__name__)

__all__ = [
    "Axis",
    "BristleError",
    "Column",
    "Component",
    "Controller",
    "Experiment",
    "Feedforward",
    "FrictionModel",
    "HysteresisOperator",
    "Injected",
    "InputError",
    "InputWarning",
    "MissingExtraError",
    "Model",
    "Motion",
    "Plant",
    "Reference",
    "Relation",
    "Run",
    "Sensor",
    "Slot",
    "Status",
    "Surrounding",
    "Trajectory",
    "Variable",
    "Variant",
    "kernel",
    "unit_of",
    "variables_of",
]
