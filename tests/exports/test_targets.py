"""Targets of the export: each is a file and a name, and meets the contract; one of a user's own does as they do."""

import importlib
import json
import re
import subprocess
import sys
import tomllib
from dataclasses import replace
from pathlib import Path

import pytest
from tests.exports.drives import LINEAR, STRIBECK

import bristle as br
from bristle.apps.lab.server.application import server_page
from bristle.apps.lab.server.limits import Limits
from bristle.cli.main import main
from bristle.contract import check_target, targets as contract
from bristle.engine.contact import steady_force
from bristle.exports import TARGETS, Product, Request, Target, load_target_file

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "examples" / "own_exporter.py"
HEAD = "from bristle.exports import Product, Target\n"
WRITES = "def write(request):\n    return {}\n\n\nTARGET = Target(name='mine', description='something', write=write)\n"
GOOD = "Product({request.name + '.txt': 'ok'}, ('a note on it',))"


def target_file(folder, result=GOOD, before=""):
    file = folder / "mine.py"
    file.write_text(before + HEAD + WRITES.format(result), encoding="utf-8")
    return file


# --- those of bristle -------------------------------------------------------------------------------------------


def test_functions_of_a_target_are_loaded_on_first_call():
    listed = "import sys; from bristle.exports import TARGETS; print(*[n for n in sys.modules if n.startswith('bristle.exports.')])"
    loaded = subprocess.run(
        [sys.executable, "-c", listed], capture_output=True, text=True, check=True
    ).stdout.split()
    assert loaded == ["bristle.exports.targets"]
    for name, target in TARGETS.items():
        module = importlib.import_module(target.module)
        assert target.name == name
        assert callable(module.write)
        assert (target.reads is not None) == callable(getattr(module, "reads", None))


@pytest.fixture
def few(monkeypatch):
    """Of the models of the contract those that are written at once: for an axis that is known, and without a speed."""
    requests = {
        name: request
        for name, request in contract.example_requests().items()
        if request.axis or not request.speed
    }
    monkeypatch.setattr(contract, "example_requests", lambda: requests)


@pytest.mark.parametrize(
    "name", [name for name in TARGETS if name not in ("fmu2", "fmu3", "mjcf", "casadi", "cogging")]
)
def test_each_target_meets_the_contract_for_an_axis_that_is_known(name, few):
    assert [check for check in check_target(TARGETS[name]) if not check.passed] == []


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (name != "cogging")) for name in TARGETS]
)
def test_each_target_meets_the_contract(name):
    assert [check for check in check_target(TARGETS[name]) if not check.passed] == []


@pytest.mark.parametrize(("option", "ability"), [("tunable", "tunable"), ("float32", "single")])
def test_an_unsupported_option_is_refused_with_the_targets_that_support_it(
    tmp_path, option, ability
):
    able = [name for name, target in TARGETS.items() if getattr(target, ability)]
    unable = next(name for name in TARGETS if name not in able)
    with pytest.raises(br.core.InputError, match=", ".join(able)):
        br.export(br.friction.coulomb(F_C=1.0), unable, tmp_path / "out", **{option: True})


def test_every_target_is_in_the_help(capsys):
    main(["export", "--help"])
    text = capsys.readouterr().out
    assert all(re.search(rf"^  {name}\b", text, flags=re.MULTILINE) for name in TARGETS)


def test_targets_that_need_a_compiler_are_not_served():
    page, _ = server_page(Limits())
    offered = json.loads(re.search(r'"targets":\s*(\[.*?\}\])', page)[1])
    assert {target["name"] for target in offered} == set(TARGETS) - {"fmu2", "fmu3"}
    assert [name for name, target in TARGETS.items() if target.needs] == ["fmu2", "fmu3"]


# --- one of a user's own ----------------------------------------------------------------------------------------


def test_the_example_meets_the_contract(few):
    checks = check_target(load_target_file(EXAMPLE))
    assert [check for check in checks if not check.passed] == []
    assert "refuses coulomb_viscous without a speed" in checks[1].detail


def test_the_example_writes_the_friction_in_the_units_of_the_log():
    product = load_target_file(EXAMPLE).write(
        Request(STRIBECK, "axis_x", 1e-3, speed=0.2, axis=br.read_axis(LINEAR))
    )
    table = tomllib.loads(product.files["axis_x.toml"])
    assert (table["velocity_unit"], table["effort_unit"]) == ("mm/s", "A")
    assert len(table["forward"]) <= 16
    for name, way in (("forward", 1.0), ("backward", -1.0)):
        speed, effort = table[name][-1]
        assert speed == pytest.approx(200.0)
        assert 50.0 * effort == pytest.approx(way * steady_force(STRIBECK, way * 0.2), rel=1e-4)
    assert sum(note.startswith("the drive takes 16 entries") for note in product.notes) == 1


@pytest.mark.parametrize(
    ("result", "said"),
    [
        ("{'a.txt': 'a'}", "returned no files"),
        ("Product({})", "wrote no file"),
        ("Product({'../a.txt': 'a'})", "an invalid name"),
        ("Product({'/tmp/a.txt': 'a'})", "an invalid name"),
        ("Product({'summary.json': 'a'})", "an invalid name"),
        ("Product({'.bristle-results': 'a'})", "an invalid name"),
        (
            "Product({'a.txt': 3.0})",
            "wrote no content for a.txt; found 'float', allowed text or bytes",
        ),
        ("Product({'a.txt': 'a'}, 'a note')", "has notes that are not text"),
    ],
)
def test_an_invalid_product_is_refused_without_writing_files(tmp_path, result, said):
    file = target_file(tmp_path, result)
    with pytest.raises(br.core.InputError, match=re.escape(said)):
        br.export(br.friction.coulomb(F_C=1.0), file, tmp_path / "out")
    assert {item.name for item in tmp_path.iterdir()} == {"mine.py"}
    unmet = [check.name for check in check_target(load_target_file(file)) if not check.passed]
    assert unmet == ["results of export"]


@pytest.mark.parametrize(
    ("result", "before", "demand", "said"),
    [
        (
            "1 / 0",
            "",
            "writes or refuses",
            "stops with ZeroDivisionError: division by zero (mine.py, line 3)",
        ),
        (
            "refuse()",
            "from bristle.core import InputError\ndef refuse():\n    raise InputError('no')\n",
            "writes or refuses",
            "it refuses every model: coulomb_viscous, no",
        ),
        (
            "Product({'a.txt': str(next(COUNT))})",
            "import itertools\nCOUNT = itertools.count()\n",
            "same bytes twice",
            "a.txt of coulomb_viscous differs in the second call",
        ),
        (
            "Product({'a.txt': str(__import__('pathlib').Path.cwd())})",
            "",
            "names no folder",
            "a.txt names",
        ),
        ("Product({'a.txt': 'a'}, ('note',))", "", "notes in words", "a note is 'note'"),
        ("Product({'a.txt': 'a'}, ('a note\\n of two lines',))", "", "notes in words", "a note is"),
    ],
)
def test_each_fault_is_reported_with_its_requirement(tmp_path, result, before, demand, said):
    failed = [
        item
        for item in check_target(load_target_file(target_file(tmp_path, result, before)))
        if not item.passed
    ]
    assert [item.name for item in failed] == [demand]
    assert said in failed[0].detail
    assert failed[0].advice


@pytest.mark.parametrize(
    ("old", "new"),
    [
        *(
            ("effort.of(force):.6g", f"{factor} * effort.of(force):.6g")
            for factor in (-1, 50, 0.001)
        ),
        ("velocity.of(v):.6g", "v:.6g"),
    ],
)
def test_a_reversed_sign_or_a_wrong_unit_is_detected(tmp_path, few, old, new):
    text = EXAMPLE.read_text(encoding="utf-8")
    assert old in text
    (tmp_path / "mine.py").write_text(text.replace(old, new), encoding="utf-8")
    target = load_target_file(tmp_path / "mine.py")
    assert [check.name for check in check_target(target) if not check.passed] == [
        "lowers the error"
    ]


@pytest.mark.parametrize("factor", [-1.0, 0.01])
def test_a_reversed_sign_or_a_wrong_unit_of_cogging_is_detected(factor):
    target = TARGETS["cogging"]

    def reads(files, request):
        drive = target.reads(files, request)
        return lambda x, dt: factor * drive(x, dt)

    assert [
        check.name for check in check_target(replace(target, reads=reads)) if not check.passed
    ] == ["lowers the error"]


def test_a_cogging_file_of_an_axis_without_cogging_is_valid():
    def write(request):
        try:
            return TARGETS["cogging"].write(request)
        except br.core.InputError:
            return Product({"axis_x.csv": "order\n"})

    def reads(files, request):
        return TARGETS["cogging"].reads(files, request) or (lambda x, dt: 0.0 * x)

    target = Target(name="here", description="harmonics", write=write, reads=reads, of_cogging=True)
    assert [check.detail for check in check_target(target) if not check.passed] == []


def test_a_target_that_acts_on_an_axis_requires_a_reader(tmp_path):
    with pytest.raises(
        br.core.InputError,
        match=r"here: acts on an axis .* cannot compute the effect\. Write reads=reads",
    ):
        Target(
            name="here",
            description="a file",
            write=lambda request: Product({"a": "b"}),
            pushes=True,
        )


def test_a_name_of_a_target_never_loads_a_file(tmp_path):
    """The served lab passes on a name that came over the network."""
    from bristle.report.exported import export_model_file

    file = target_file(tmp_path, before="raise RuntimeError('executed')\n")
    with pytest.raises(br.core.InputError, match="no such target"):
        export_model_file(tmp_path / "model.toml", str(file), command="")


def test_a_target_can_be_defined_in_python(tmp_path):
    target = Target(
        name="here", description="a file", write=lambda request: Product({"a.bin": b"\x00\xff"})
    )
    result = br.export(br.friction.coulomb(F_C=1.0), target, tmp_path / "out")
    assert result.files == ("a.bin",)
    assert (tmp_path / "out" / "a.bin").read_bytes() == b"\x00\xff"
