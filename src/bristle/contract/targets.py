"""The contract of an export target, built-in or a user's: files written for different kinds of models."""

import math
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

from bristle.contract.check import Check, Fact, UnmetError, outcomes
from bristle.core import InputError, cached_property
from bristle.engine import response
from bristle.exports import Product, Request, Source, Target
from bristle.exports.effect import Drive, effect_of_files
from bristle.exports.writing import checked_product
from bristle.files.axis import axis_from
from bristle.models import friction
from bristle.models.plants import inertia
from bristle.models.plants.terms import effort_of_place, terms_of, with_terms

STEP = 1e-3  # [s]
LONGEST_NOTE = 400  # letters
LEAST_SHARE = 0.2  # of the effort of the axis: a target that feeds less, or more than the inverse times as much, has a wrong unit
FEWEST_LETTERS = 4  # of the path of a folder of this machine: "/" occurs in every text
REFUSE = (
    "Refuse unsupported models: raise InputError(message, path=..., mend=...) from bristle.core"
)
AXIS = {
    "schema": 1,
    "kind": "translational",
    "columns": {
        "time": {"column": "t", "unit": "s"},
        "position": {"column": "q", "unit": "mm"},
        "effort": {"column": "u", "unit": "A"},
    },
    "effort": {"force_constant": "50 N/A", "rated": "200 N"},
    "controller": {"model": "cascade", "k_p": "30 1/s", "k_v": "4 N*s/mm", "T_n": "20 ms"},
}


class _Trial:
    """A target, and its products of the first call by name of the model, and of a second call."""

    def __init__(self, target: Target) -> None:
        self.target = target
        self.refused: dict[str, InputError] = {}

    @cached_property
    def first(self) -> dict[str, Product]:
        """The products of the first call."""
        return self.written()

    def written(self) -> dict[str, Product]:
        """Return the products of the target for each model; note the refused models."""
        products: dict[str, Product] = {}
        for name, request in example_requests().items():
            try:
                products[name] = self.target.write(replace(request, rest=self.target.rest))
            except InputError as error:
                self.refused[name] = error
        return products


@cache
def example_requests() -> Mapping[str, Request]:
    """Return the test requests for every target by name: models of both kinds of axis, with and without an axis file."""
    source = Source(
        {"model": "model.toml", "command": "bristle export model.toml"},
        {"F_C": {"interval": (7.0, 9.0)}},
    )
    cogging = with_terms(inertia, cogging={"motor": [6]})(
        kind="rotational", M=1e-3, motor_turn=2.0 * math.pi, motor_6_cos=1e-2, motor_6_sin=2e-2
    )
    stribeck = friction.with_slots(friction.stribeck, ["asymmetry"])(
        F_C_pos=8.0,
        F_C_neg=7.0,
        F_S_pos=11.0,
        F_S_neg=10.0,
        v_S=4e-3,
        F_v_pos=100.0,
        F_v_neg=90.0,
        offset=1.5,
    )
    lugre = friction.lugre(kind="rotational", F_C=0.034, F_S=0.04, v_S=0.5, sigma_0=100.0)
    return {
        "coulomb_viscous": Request(
            friction.coulomb_viscous(F_C=8.0, F_v=100.0), "axis_x", STEP, source, speed=0.2
        ),
        "stribeck+asymmetry with an axis file": Request(
            stribeck,
            "axis_x",
            STEP,
            axis=axis_from(AXIS),
            speed=0.2,
            points=10,
            plant=inertia(M=20.0),
        ),
        "lugre, rotational, on a motor that cogs": Request(
            lugre, "axis_x", STEP, speed=5.0, plant=cogging
        ),
        "coulomb_viscous without a speed": Request(
            friction.coulomb_viscous(F_C=8.0, F_v=100.0), "axis_x", STEP
        ),
    }


def check_target(target: Target) -> list[Check]:
    """Run the contract suite on an export target.

    Parameters
    ----------
    target : Target
        A built-in target, or your own.

    Returns
    -------
    list of Check
        One for each demand, in order; if no file is written, the others are skipped.
    """
    return outcomes(TARGET_CHECKS, _Trial(target), FORM, REFUSE)


def described_target(trial: _Trial) -> Fact:
    """Describe the output in one line."""
    if not trial.target.description.strip() or "\n" in trial.target.description.strip():
        raise UnmetError(
            f"the description is {trial.target.description!r:.60}",
            "Describe the output in one line",
        )
    return Fact(trial.target.description)


def writes_or_refuses(trial: _Trial) -> Fact:
    """Write each model or refuse it with an `InputError`; write at least one."""
    written = trial.first
    refused = trial.refused
    if not written:
        name, error = next(iter(refused.items()))
        raise UnmetError(
            f"it refuses every model: {name}, {error}", "Write at least one of the test models"
        )
    words = "".join(f"; refuses {name}" for name in refused)
    return Fact(f"{len(written)} of {len(written) + len(refused)} models{words}")


def results_of_export(trial: _Trial) -> Fact:
    """Return files with plain names, as text or bytes, and notes."""
    written = trial.first
    for product in written.values():
        try:
            checked_product(product, trial.target)
        except InputError as error:
            raise UnmetError(str(error)) from None
    names = dict.fromkeys(name for product in written.values() for name in product.files)
    return Fact(", ".join(names))


def same_bytes_twice(trial: _Trial) -> Fact:
    """Write the same bytes again on a second call: results are compared by their checksums."""
    written = trial.first
    again = trial.written()
    for model, product in written.items():
        for name, content in product.files.items():
            if (
                model not in again
                or again[model].files.get(name) != content
                or again[model].notes != product.notes
            ):
                raise UnmetError(
                    f"{name} of {model} differs in the second call",
                    "Write no date, no counter, no random number, and no unordered set",
                )
    return Fact(f"{sum(len(product.files) for product in written.values())} files")


def names_no_folder(trial: _Trial) -> Fact:
    """Name no folder of this machine: exported files are mailed."""
    places = [
        str(place) for place in (Path.home(), Path.cwd()) if len(str(place)) >= FEWEST_LETTERS
    ]
    for product in trial.first.values():
        for name, content in product.files.items():
            text = content if isinstance(content, str) else content.decode("latin-1")
            place = next((place for place in places if place in text), None)
            if place is not None:
                raise UnmetError(
                    f"{name} names {place}", "Use the file names in request.source.lines"
                )
    return Fact()


def notes_in_words(trial: _Trial) -> Fact:
    """State every simplification in a note of one line, in words."""
    notes = [note for product in trial.first.values() for note in product.notes]
    for note in notes:
        if not note.isprintable() or len(note.split()) < 2 or len(note) > LONGEST_NOTE:
            raise UnmetError(
                f"a note is {note!r:.60}",
                f"Write each in one line of {LONGEST_NOTE} letters at most, in words",
            )
    return Fact(f"{len(notes)} notes")


def lowers_the_error(trial: _Trial) -> Fact:
    """Lower the error of the axis: a reversed sign or a wrong unit raises the error, or feeds almost no force."""
    target = trial.target
    if target.reads is None:
        return Fact(
            "the target has no reads, so bristle does not know the force of the drive",
            applies=False,
        )
    advice = "Write the sign and the units of the drive, and return the force in N or N*m from reads, positive forward"
    ratios = [1.0]
    for name, product in trial.first.items():
        request = replace(example_requests()[name], rest=target.rest)
        drive = target.reads(product.files, request)
        if drive is None:
            continue
        effect = effect_of_files(request, drive, of_cogging=target.of_cogging, promises=False)
        share = _share_fed(request, drive, target)
        if effect is not None and effect.along:
            ratios.append(effect.ratio)
            if not ratios[-1] <= 1.0:
                raise UnmetError(f"{effect.lines()[0]} ({name})", advice)
        if not LEAST_SHARE <= share <= 1.0 / LEAST_SHARE:
            raise UnmetError(
                f"it feeds forward {share:.2g} times the effort of the axis ({name})", advice
            )
    return Fact(
        f"with the target, the error is at best {min(ratios):.2g} times the error without it",
        min(ratios),
        "1",
        1.0,
    )


def _share_fed(request: Request, drive: Drive, target: Target) -> float:
    """Return the share of friction, or of cogging, that a drive feeds along a sine of 1 s, by least squares."""
    turn = 2.0 * np.pi * np.arange(0.0, 2.0, request.dt)
    x = (request.speed or 0.1) / (2.0 * np.pi) * np.sin(turn)
    if target.of_cogging:
        terms = None
        if request.plant is not None:
            terms = terms_of(request.plant)
        effort = np.zeros(x.size)
        if terms is not None:
            effort = effort_of_place(x, terms)
    else:
        effort = response(request.model, x, request.dt, rest=request.rest or "held")
    size = effort @ effort
    if size:
        return float(drive(x, request.dt) @ effort / size)
    return 1.0


FORM = (described_target, writes_or_refuses, results_of_export)
TARGET_CHECKS = (*FORM, same_bytes_twice, names_no_folder, notes_in_words, lowers_the_error)
