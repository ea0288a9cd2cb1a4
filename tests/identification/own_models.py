"""Friction models of a user's own, without a state."""

from collections.abc import Callable, Mapping
from typing import Annotated, Any, NamedTuple

from bristle.core import FrictionModel, Variable, kernel


class State(NamedTuple):
    pass


@kernel
def commit(state, memory, move, p):
    return state


def own_model(
    trial: Callable, variables: Mapping[str, Variable], name: str = "own", **further: Any
) -> FrictionModel:
    """A model with this force and these parameters, in their order."""
    fields: Any = [
        (parameter, Annotated[float, variable]) for parameter, variable in variables.items()
    ]
    parameters = NamedTuple("Parameters", fields)
    return FrictionModel(
        name=name,
        description="a user's own model",
        Parameters=parameters,
        State=State,
        trial=trial,
        commit=commit,
        **further,
    )
