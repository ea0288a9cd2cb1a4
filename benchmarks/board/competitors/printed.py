"""Equations (5)–(7) of the source paper as printed: fitted over the position, driven by the deflection."""

from __future__ import annotations

from benchmarks.board.of_bristle import friction_force, identified


def fit(train):
    return identified(train, "preisach_lugre")


def feedforward(fitted, reference):
    return friction_force(fitted, reference, transition="paper")
