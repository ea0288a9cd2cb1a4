"""What a person at a terminal reads of an identification before its table."""

from dataclasses import replace

import pytest
from tests.identification.known_logs import STATED, sliding_log

from bristle.cli.identify import identification_parts
from bristle.cli.terminal import show
from bristle.core.diagnostic import Diagnostic
from bristle.identification import identify


@pytest.mark.parametrize(("severity", "told"), [("note", True), ("warning", False)])
def test_a_table_that_calls_parameters_effective_is_led_by_why(capsys, severity, told):
    identification = identify(sliding_log(), "coulomb_viscous", axis=STATED, blocks=0, draws=0)
    numbers = {"missing": 0.07, "percent": 0.2, "chance": 0.1, "names": ("M",), "causes": ("speed",), "small": 1}
    structure = Diagnostic("structure", "", severity, numbers, "translational")
    best = replace(identification.best, diagnostics=(structure, *identification.best.diagnostics))
    show(*identification_parts(replace(identification, fits=(best,)), None))
    assert ("Parameters are effective: the model lacks a force, too small to matter" in " ".join(capsys.readouterr().out.split())) is told
