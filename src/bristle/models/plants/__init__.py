"""Plants, each in a file: the equations of motion of an axis."""

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

from bristle.core.contracts import Plant
from bristle.core.errors import InputError, did_you_mean
from bristle.core.loading import loaded_from
from bristle.models.family import Family
from bristle.models.plants.terms import SPRINGS, TERMS, terms_in, with_terms

if TYPE_CHECKING:
    # Every plant of bristle, in the order of the lists.
    # isort: off
    from bristle.models.plants.inertia import inertia as inertia
    from bristle.models.plants.oscillator import oscillator as oscillator
    from bristle.models.plants.pulled_inertia import pulled_inertia as pulled_inertia
    from bristle.models.plants.ball_screw import ball_screw as ball_screw
    # isort: on

__getattr__ = loaded_from(__name__)

# Every plant, by name.
PLANTS: Mapping[str, Plant] = Family(__name__)

__all__ = ["PLANTS", "find", "with_terms"]


def __dir__() -> list[str]:
    return [*PLANTS, "find", "with_terms"]


def find(name: str, keys: Iterable[str] = (), path: str = "plant.model") -> Plant:
    """Return the plant of this name with its terms, such as ``"inertia+gravity"``.

    The names of the given parameters determine the harmonics of cogging and the known columns.

    Raises
    ------
    InputError
        If there is no such plant or term, or it has no parameters.
    """
    base, *terms = name.split("+") if isinstance(name, str) else [name]
    if not isinstance(base, str) or base not in PLANTS:
        raise InputError(
            "there is no such model",
            path=path,
            value=name,
            allowed=", ".join(PLANTS),
            mend=did_you_mean(base, PLANTS),
        )
    for term in terms:
        if term not in TERMS:
            allowed = ", ".join(f"+{choice}" for choice in TERMS)
            raise InputError(
                "there is no such term",
                path=path,
                value=f"+{term}",
                allowed=allowed,
                mend=did_you_mean(term, TERMS),
            )
    if not terms:
        return PLANTS[base]
    chosen = terms_in(keys)
    given = {
        "cogging": any(chosen["cogging"].values()),
        "spring": chosen["spring"],
        "known": chosen["columns"],
    }
    for term, example in (
        ("cogging", "motor_6_cos"),
        ("spring", "spring_1"),
        ("known", "known_NAME"),
    ):
        if term in terms and not given[term]:
            raise InputError(
                f"has +{term}, but no coefficient",
                path=path,
                value=name,
                mend=f"Write a coefficient below the name, such as {example} = 0.1",
            )
    return with_terms(
        PLANTS[base],
        gravity="gravity" in terms,
        cogging=chosen["cogging"] if "cogging" in terms else None,
        columns=chosen["columns"] if "known" in terms else (),
        spring=chosen["spring"] if "spring" in terms else None,
    )
