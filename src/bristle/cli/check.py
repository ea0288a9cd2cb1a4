"""``bristle check``: whether a model is fit to be used."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from bristle.cli.failure import NO
from bristle.cli.options import Json
from bristle.cli.terminal import complain, progress, show_table

if TYPE_CHECKING:
    from bristle.core import FrictionModel, Model
    from bristle.testing import Check

__all__ = ["EXAMPLE", "check"]

EXAMPLE = """Example:
  bristle check my_model.py"""


def check(
    model: Annotated[Path, typer.Argument(metavar="MODEL.py|MODEL.toml", help="A model of your own, or a model file.")],
    as_json: Json = False,
) -> int:
    """Check a friction model against the contract.

    Where one of its demands is not met, tells what to change.
    A Python file is executed. The exit code is 1 if a demand is not met.
    """
    from bristle.files.summary import as_json as json_text
    from bristle.testing import check_model

    chosen = _read(model)
    with progress("checking"):
        results = check_model(chosen)
    failed = [one for one in results if not one.passed]
    if as_json:
        sys.stdout.write(
            json_text({"model": chosen.name, "passed": not failed, "certificates": _certificates(results)})
        )
    else:
        _show(chosen.name, results)
    for one in failed:
        complain(f"{one.name}: {one.detail}. {one.advice}")
    return NO if failed else 0


def _read(model: Path) -> FrictionModel | Model:
    from bristle.core import InputError

    if model.suffix == ".py":
        from bristle.files.user_model import load_model_file

        return load_model_file(model)
    if model.suffix == ".toml":
        from bristle.files.model import read_model

        return read_model(model).friction
    raise InputError(
        "is neither a model of your own nor a model file", path=str(model), allowed="a file .py or .toml",
        mend="For the models of bristle itself see: bristle models",
    )  # fmt: skip


def _certificates(results: list[Check]) -> dict[str, dict[str, object]]:
    return {
        one.name: {
            "applies": one.applies,
            "value": one.value,
            "unit": one.unit,
            "threshold": one.threshold,
            "passed": one.passed,
            "detail": one.detail,
            "advice": one.advice,
        }
        for one in results
    }


def _outcome(one: Check) -> str:
    if not one.applies:
        return "–"
    return "met" if one.passed else "NOT MET"


def _show(name: str, results: list[Check]) -> None:
    from bristle.report.table import Table

    rows = [(one.name, _outcome(one), one.detail, one.advice) for one in results]
    show_table(Table(f"The contract of a friction model: {name}", ("Demand", "Outcome", "Seen", "What to do"), rows))
