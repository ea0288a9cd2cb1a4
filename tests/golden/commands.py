"""The golden command lines: the JSON output of each command, in all situations that change its keys."""

from __future__ import annotations

import io
import json
from contextlib import chdir, redirect_stderr, redirect_stdout
from functools import partial
from typing import Any
from unittest.mock import patch

from benchmarks.board.command import main as board
from tests.golden.case import register
from tests.golden.skeleton import skeleton
from tests.golden.yard import yard

from bristle.cli.main import main

# What a command line prints, by the name of its case; "{out}" of one is a folder that others read.
COMMANDS = {
    "identify": "identify log.csv --axis axis.toml --model coulomb_viscous,stribeck+asymmetry --draws 20",
    "identify_without_loop": "identify log.csv --axis bare.toml --model lugre --draws 0",
    "identify_elements": "identify log.csv --axis bare.toml --model maxwell_slip,gms --draws 20",
    "identify_in_loop": "identify log.csv --axis loop.toml --model coulomb_viscous,maxwell_slip --draws 20",
    "identify_open_loop": "identify ringing.npz --axis ringing.toml --model bouc_wen_classic --draws 0",
    "identify_several": "identify log.csv second.csv --axis axis.toml --model coulomb_viscous --draws 0",
    "identify_late": "identify late.csv --axis late.toml --model coulomb_viscous --draws 0",
    "identify_second_pass": "identify cogged.csv --axis pulls.toml --model coulomb_viscous --draws 0",
    "identify_pulls": "identify pulls.csv --axis pulls.toml --model coulomb_viscous --draws 0 --cutoff 60Hz",
    "identify_own": "identify log.csv --axis axis.toml --model own.py --draws 0",
    "identify_curves": "identify curves.csv --axis curves.toml --model prandtl_ishlinskii,preisach",
    "identify_reversal_curves": "identify reversals.npz --axis reversals.toml --model reversal_table",
    "identify_each": "identify parts --each --axis bare.toml --draws 0 --workers 1 --out each",
    "predict": "predict model.toml log.csv --axis axis.toml",
    "predict_in_loop": "predict model.toml log.csv --axis axis.toml --mode closed-loop",
    "predict_open_loop": "predict model.toml log.csv --axis axis.toml --mode open-loop",
    "predict_with_band": "predict fit/model.toml log.csv --axis axis.toml --mode closed-loop",
    "predict_curves": "predict operator/model.toml curves.csv --axis curves.toml",
    "compare": "compare log.csv fed.csv --axis axis.toml",
    "compare_without_reference": "compare late.csv slower.csv --axis late.toml",
    "run": "run experiment.toml --log --out run",
    "run_seeds": "run seeds.toml",
    "run_learning": "run learning.toml",
    "run_diverging": "run diverging.toml",
    "study": "study study.toml --workers 1 --out study",
    "study_run": "study study.toml --run 3",
    "paper": "paper --figure 4 --figure 9",
    "paper_write": "paper --write experiments",
    "board": "board least_squares --task known_axis --date 2026-01-01 --workers 1 --out board",
    "board_list": "board --list",
    "design": "design experiment.toml",
    "design_diverging": "design diverging.toml",
    "check": "check composite.toml",
    "export": "export model.toml --to c --out axis_c",
    "lab": "lab model.toml --out lab.html",
    "check_lugre": "check lugre.toml",
    "check_own": "check own.py",
    "models": "models",
    "models_lugre": "models lugre",
    "explain": "explain one_direction",
    "excite": "excite axis_of_demo.toml --duration 10s --for break-away --out motion",
    "log": "log log.csv --axis axis.toml",
    "log_explained": "log log.csv --axis axis.toml --explain",
    "log_without_axis": "log constants.mat",
    "log_nameless": "log nameless.txt",
    "log_pulls": "log pulls.csv --axis pulls.toml",
    "log_problems": "log holes.csv --axis axis.toml",
    "demo": "demo --out demo",
    "tune": "tune machine/machine.toml --out tuned",
}
BEFORE = {
    "predict_with_band": "identify log.csv --axis axis.toml --model coulomb_viscous --draws 20 --out fit",
    "predict_curves": "identify curves.csv --axis curves.toml --model preisach --out operator",
}
# The last: the second pass is a near tie, so another processor decides otherwise.
SLOW = {"demo", "check", "board", "identify_pulls"}


def printed(name: str) -> dict[str, Any]:
    """Return the exit code of a command line, and the skeleton of what it printed."""
    place = yard()
    with chdir(place), patch.dict("os.environ", BRISTLE_STATE_DIR=str(place / "state")):
        if name in BEFORE:
            _run(BEFORE[name])
        code, text = _run(COMMANDS[name])
    return {"code": code, "json": skeleton(json.loads(text))}


def _run(line: str) -> tuple[int, str]:
    # A study, a fleet and a run on a machine go on in their own folder instead of replacing it.
    goes_on = line.startswith(("study ", "tune ", "board ")) or "--each" in line
    folder = ["--force"] if ("--out" in line or "--write" in line) and not goes_on else []
    with redirect_stdout(io.StringIO()) as out, redirect_stderr(io.StringIO()):
        code = (
            board([*line.split()[1:], "--json"])
            if line.startswith("board ")
            else main([*line.split(), *folder, "--json"])
        )
    return code, out.getvalue()


for _name in COMMANDS:
    register(f"json_{_name}", partial(printed, _name), fast=_name not in SLOW)
