"""``bristle check``: whether a model is fit to be used."""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from bristle.cli.failure import NO
from bristle.cli.options import AllowCode, Json
from bristle.cli.terminal import complain, progress, show_table

if TYPE_CHECKING:
    from bristle.core.content import Content
    from bristle.testing import Check

__all__ = ["EXAMPLE", "check"]

EXAMPLE = """Example:
  bristle check model.toml --force-ripple "40 mN*m,80 mN*m"
  bristle check my_model.py"""


def check(
    model: Annotated[
        Path,
        typer.Argument(
            metavar="MODEL.toml|OWN.py",
            help="A model file, or a model, slot, law, sensor, reader, figure or target of the export of your own.",
        ),
    ],
    force_ripple: Annotated[str | None, typer.Option(metavar="LOW,HIGH", help="Forces between which drift is looked for.")] = None,
    loop: Annotated[str | None, typer.Option(metavar="X1,X2", help="Where the loop turns that has to close.")] = None,
    allow_code: AllowCode = False,
    as_json: Json = False,
) -> int:
    """Check whether a model, or what else you wrote, is fit.

    Where it is not, tells what to change.
    A model file has its certificates: bounded deflection, passivity, drift, closure of a minor loop, dissipation.
    A Python file is executed, and its friction model, slot, control law, sensor, reader of logs, figure or target of
    the export held against its contract.
    The exit code is 1 if one of them fails.
    """
    if model.suffix == ".toml":
        return _check_values(model, _pair(force_ripple), _pair(loop), as_json, allow_code)
    return _check_code(model, {"--force-ripple": force_ripple, "--loop": loop}, as_json)


def _pair(text: str | None) -> tuple[str, ...] | None:
    return None if text is None else tuple(text.split(","))


def _check_values(model: Path, force_ripple: Any, loop: Any, as_json: bool, allow_code: bool) -> int:
    from bristle.certificates import check as certificates_of
    from bristle.core.content import content_of
    from bristle.files.model import read_model
    from bristle.files.operator import holds_operator, read_operator
    from bristle.files.toml import TOML_LIMIT

    file = content_of(model, limit=TOML_LIMIT)
    of_operator = holds_operator(file)
    if of_operator:
        chosen = read_operator(file).operator
    else:
        chosen = read_model(file, related=False, allow_code=allow_code).friction
    with progress("checking"):
        certificates = certificates_of(chosen, force_ripple=force_ripple, loop=loop)
    failed = {name: certificate for name, certificate in certificates.items() if certificate.passed is False}
    if not failed and not of_operator:
        # Refuses what breaks a condition that no certificate speaks of, such as F_S >= F_C.
        read_model(file, allow_code=allow_code)
    if as_json:
        _print_json(chosen.name, not failed, {name: vars(certificate) for name, certificate in certificates.items()})
    else:
        from bristle.report.certificates import certificate_table

        show_table(certificate_table(chosen.name, certificates))
    for name, certificate in failed.items():
        complain(f"{name}: {certificate.advice}")
    return NO if failed else 0


def _check_code(model: Path, options: dict[str, str | None], as_json: bool) -> int:
    from bristle.core import InputError
    from bristle.core.content import content_of
    from bristle.files.permission import CODE_LIMIT, allow

    if model.suffix != ".py":
        raise InputError(
            "is neither a model file nor a model of your own",
            path=str(model),
            allowed="a file .toml or .py",
            mend="For the models of bristle itself see: bristle models",
        )
    for name, value in options.items():
        if value is not None:
            raise InputError(
                "needs a model with parameters",
                path=name,
                value=value,
                mend=f'Write a model file with file = "{model.name}" and its parameters, and check that',
            )
    content = content_of(model, limit=CODE_LIMIT)
    subject = _subject_in(content)
    allow(content)
    with progress("checking"):
        results = subject.checks()
    failed = [check for check in results if not check.passed]
    if as_json:
        _print_json(subject.name, not failed, {check.name: _as_certificate(check) for check in results})
    else:
        _show_demands(f"The contract of a {subject.title}: {subject.name}", results)
    for check in failed:
        complain(f"{check.name}: {check.detail}. {check.advice}")
    return NO if failed else 0


class _Subject(NamedTuple):
    """What is held against a contract: its name, what people call such a thing, and what tries it."""

    name: str
    title: str
    checks: Callable[[], list[Check]]


def _subject_in(content: Content) -> _Subject:
    """Return what a file defines that has a contract."""
    from bristle.exports import load_target_file
    from bristle.files.user_model import SourceText, load_checked, word_of
    from bristle.testing import check_figure, check_model, check_reader, check_target

    module = SourceText(content).module()
    if hasattr(module, "TARGET") and not hasattr(module, "MODEL"):
        target = load_target_file(content)
        return _Subject(target.name, "target of the export", partial(check_target, target))
    if hasattr(module, "FIGURE") and not hasattr(module, "MODEL"):
        from bristle.figures import load_figure_file

        figure = load_figure_file(content)
        return _Subject(figure.name, "figure", partial(check_figure, figure))
    if hasattr(module, "FORMAT") and not hasattr(module, "MODEL"):
        from bristle.files.user_model import load_reader_file

        log_format = load_reader_file(content)
        return _Subject(log_format.name, "reader of logs", partial(check_reader, log_format))
    component = load_checked(content)
    return _Subject(component.name, word_of(component), partial(check_model, component))


def _print_json(name: str, passed: bool, certificates: dict[str, Any]) -> None:
    from bristle.files.summary import as_json

    sys.stdout.write(as_json({"model": name, "passed": passed, "certificates": certificates}))


def _as_certificate(check: Check) -> dict[str, object]:
    return {
        "applies": check.applies,
        "value": check.value,
        "unit": check.unit,
        "threshold": check.threshold,
        "passed": check.passed,
        "detail": check.detail,
        "advice": check.advice,
    }


def _outcome(check: Check) -> str:
    if not check.applies:
        return "–"
    return "met" if check.passed else "NOT MET"


def _show_demands(title: str, results: list[Check]) -> None:
    from bristle.report.table import Table

    rows = [(check.name, _outcome(check), check.detail, check.advice) for check in results]
    show_table(Table(title, ("Demand", "Outcome", "Seen", "What to do"), rows))
