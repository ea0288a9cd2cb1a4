"""``bristle check``: test a model or user code, and find the parameters that a log determines."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from pkgutil import resolve_name
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from bristle.cli.options import Json, code_in, print_json, refuse, toml_content
from bristle.cli.terminal import complain, exit_code, progress, show, show_table

if TYPE_CHECKING:
    from bristle.contract import Check
    from bristle.report.table import Table

EXAMPLE = """Example:
  bristle check results
  bristle check model.toml --force-ripple "40 mN*m,80 mN*m"
  bristle check my_model.py"""


# What a file of a user's own may define beside a model: what it is called, what loads it, and the suite of its contract.
KINDS = {
    "TARGET": (
        "export target",
        "bristle.exports:load_target_file",
        "bristle.contract:check_target",
    ),
    "FIGURE": (
        "figure",
        "bristle.report.figures:load_figure_file",
        "bristle.report.figures.contract:check_figure",
    ),
    "FORMAT": ("log reader", "bristle.files:load_reader_file", "bristle.contract:check_reader"),
    "MACHINE": (
        "machine",
        "bristle.apps.tune.machines:load_machine_file",
        "bristle.apps.tune.contract:check_machine",
    ),
}


def check(
    model: Annotated[
        Path,
        typer.Argument(
            metavar="RESULTS|MODEL.toml|OWN.py",
            help="Results of identify, a model file, or a Python file with your model, slot, law, sensor, reader, figure or target.",
        ),
    ],
    force_ripple: Annotated[
        str | None,
        typer.Option(
            metavar="LOW,HIGH", help="Lowest and highest force of the ripple in the drift test."
        ),
    ] = None,
    loop: Annotated[
        str | None,
        typer.Option(
            metavar="X1,X2", help="Two reversal positions of the loop in the closure test."
        ),
    ] = None,
    log: Annotated[
        list[Path] | None,
        typer.Option(
            "--log",
            metavar="LOG",
            help="With RESULTS: the identified log, if its file has moved; repeatable.",
        ),
    ] = None,
    draws: Annotated[
        int | None,
        typer.Option(
            "--draws",
            metavar="COUNT",
            min=3,
            max=1000,
            help="With RESULTS: number of simulated logs, by default 10.",
        ),
    ] = None,
    move: Annotated[
        bool, typer.Option("--move", help="With a machine: its example() may move and be written.")
    ] = False,
    as_json: Json = False,
) -> int:
    """Check a model, your own code, or the information in a log.

    RESULTS (a folder written by identify, or its summary.json): bristle simulates logs of the identified axis with the
    motion of the recorded log, and identifies them with the same model and settings. The true parameters of these logs
    are known. Therefore the table shows which parameters the recorded log determines, how accurately, and how many 95 %
    intervals contain the true value.

    Model file: bristle computes the certificates of the model: bounded deflection, passivity, drift, closure of a minor loop, dissipation.

    Python file: bristle runs the file and tests whether its friction model, slot, control law, sensor, log reader, figure,
    export target or machine meets all requirements.

    bristle prints advice for every failed test. The exit code is 1 if a test fails.
    """
    options = {"--force-ripple": force_ripple, "--loop": loop}
    if model.is_dir() or model.name == "summary.json":
        refuse(
            options,
            "applies only to a model file",
            "Leave the option out, or check model.toml of this folder",
        )
        return _of_results(model, log or None, draws or 10, as_json=as_json)
    refuse({"--log": log, "--draws": draws}, "applies only to a folder of results")
    if model.suffix == ".toml":
        refuse({"--move": move}, "applies only to a machine")
    if model.suffix == ".toml":
        judged = _of_values(model, options)
    else:
        judged = _of_code(model, options, move=move)
    if as_json:
        print_json(
            {
                "model": judged.name,
                "passed": not judged.failures,
                "certificates": judged.certificates,
            }
        )
    else:
        show_table(judged.table)
    for failure in judged.failures:
        complain(failure)
    return exit_code(judged.failures)


def _of_results(results: Path, log: list[Path] | None, draws: int, *, as_json: bool) -> int:
    """Report how well the log of an identification determines its parameters."""
    from bristle.core import InputError
    from bristle.files import SUMMARY
    from bristle.report.known_truth import NOTE
    from bristle.report.model_in_hand import load

    folder = results
    if results.name == SUMMARY:
        folder = results.parent
    if not (folder / SUMMARY).is_file():
        raise InputError(
            "is not a folder of results",
            path=str(folder),
            allowed=f"a folder with {SUMMARY}",
            mend="Name a folder written by bristle identify --out",
        )
    with progress("simulating") as report:
        truth = load(folder).known_truth(log, draws=draws, progress=report)
    if as_json:
        print_json(truth.to_dict())
    else:
        show(truth.sentence, truth.table, f"Note: {NOTE}")
    return 0


class _Judged(NamedTuple):
    """A checked model: its name, its certificates as data, the reasons of failures, and a table."""

    name: str
    certificates: dict[str, Any]
    failures: list[str]
    table: Table


def _of_values(model: Path, options: dict[str, str | None]) -> _Judged:
    """Return the certificates of a model file or an operator."""
    from bristle.files import holds_operator, read_model, read_operator
    from bristle.report.model_tables import certificate_table
    from bristle.simulation.certificates import check as certificates_of

    file = toml_content(model)
    of_operator = holds_operator(file)
    if of_operator:
        chosen = read_operator(file).operator
    else:
        chosen = read_model(file, related=False).friction
    ripple, loop = (None if text is None else tuple(text.split(",")) for text in options.values())
    with progress("checking"):
        certificates = certificates_of(chosen, force_ripple=ripple, loop=loop)  # type: ignore[arg-type]
    failures = [
        f"{name}: {certificate.advice}"
        for name, certificate in certificates.items()
        if certificate.passed is False
    ]
    if not failures and not of_operator:
        # Refuses a broken condition that no certificate covers, such as F_S >= F_C.
        read_model(file)
    data = {name: vars(certificate) for name, certificate in certificates.items()}
    return _Judged(chosen.name, data, failures, certificate_table(chosen.name, certificates))


def _of_code(model: Path, options: dict[str, str | None], *, move: bool) -> _Judged:
    """Test a code file against its contract and return the result. The name on the command line allows its code."""
    from bristle.contract import check_model
    from bristle.core import InputError
    from bristle.files import SourceText, allow, load_checked, word_of
    from bristle.report.table import Table

    if model.suffix != ".py":
        raise InputError(
            "is neither a model file, nor user code, nor a folder of results",
            path=str(model),
            allowed="a file .toml or .py, or a folder of results",
            mend="For the built-in models see: bristle models",
        )
    refuse(
        options,
        "needs a model with parameter values",
        f'Write a model file with file = "{model.name}" and its parameters, and check the model file',
    )
    content = code_in(model)
    module = SourceText(content).module()
    if not {"MODEL", "SLOT", *KINDS} & vars(module).keys():
        raise InputError(
            "defines no object that can be checked",
            path=str(model),
            allowed="MODEL (friction model, control law or sensor), SLOT, FORMAT, TARGET, FIGURE or MACHINE",
            mend="End the file with such an object, for example MODEL = FrictionModel(...)",
        )
    kind = next(
        (kind for kind in KINDS if hasattr(module, kind) and not hasattr(module, "MODEL")), None
    )
    if kind != "MACHINE":
        refuse({"--move": move}, "applies only to a machine")
    if kind is None:
        subject: Any = load_checked(content)
        title = word_of(subject)
        checked = check_model
    else:
        title, loader, suite = KINDS[kind]
        subject = resolve_name(loader)(content)
        checked = resolve_name(suite)
    if kind == "MACHINE":
        checked = partial(checked, move=move)
    allow(content)
    with progress("checking"):
        results = checked(subject)
    keys = ("applies", "value", "unit", "threshold", "passed", "detail", "advice")
    rows = [
        {
            "Requirement": check.name,
            "Outcome": _outcome(check),
            "Finding": check.detail,
            "Advice": check.advice,
        }
        for check in results
    ]
    data = {check.name: {key: getattr(check, key) for key in keys} for check in results}
    failures = [
        f"{check.name}: {check.detail}. {check.advice}" for check in results if not check.passed
    ]
    name = getattr(subject, "name", None) or subject.__name__
    return _Judged(name, data, failures, Table.of(f"Contract of the {title} {name}", rows))


def _outcome(check: Check) -> str:
    """Return the outcome of a check in words; a dash if it does not apply."""
    if not check.applies:
        return "–"
    if check.passed:
        return "met"
    return "NOT MET"
