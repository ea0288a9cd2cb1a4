"""LuGre, identified by bristle."""

from benchmarks.board.of_bristle import effort, friction_force, identified, numbers


def fit(train):
    return identified(train, "lugre")


predict, feedforward, parameters = effort, friction_force, numbers
