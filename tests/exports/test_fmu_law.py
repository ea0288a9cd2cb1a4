"""Control laws as FMUs: what they are told goes in as in C, and the effort comes out with the bits of C."""

import zipfile
from functools import cache

import numpy as np
import pytest
from tests.exports.importing import described_by, needs_compiler, needs_fmpy
from tests.exports.native import FLAGS, WARNINGS, compiled, differing, library_of_laws
from tests.exports.test_laws import CHANGED, DT, RUN_CHANGED, replayed, told, variant_of

from bristle.exports import fmu
from bristle.exports.c import law_files
from bristle.exports.described import Source, hash_of_law
from bristle.exports.law import law_of, law_walk

pytestmark = [pytest.mark.slow, needs_compiler, needs_fmpy]
COUNT = 600
# A law without a compensator, one along the measured motion, one led ahead with a past, and one that gravity passes to.
LAWS = {
    "cascade_nothing": ("cascade", "nothing", 2),
    "twisting_measured": ("twisting", "measured", 3),
    "sliding_mode_all": ("sliding_mode", "all", 2),
    "cascade_toothed": ("cascade", "toothed", 3),
}
TUNED = ("cascade", "toothed")


@cache
def law(controller, fed, *, tunable=False):
    return law_of(variant_of(controller, fed), tunable=tunable)


@cache
def inputs_of(controller, fed):
    """Return what a law is told along the walk of its self-test, a row for each sample."""
    message = law(controller, fed)
    walk, count, _ = law_walk(message, 2)
    x = walk.positions(COUNT + count)
    v = np.diff(x) / DT
    return told(message, x[:-1], v, 100.0 * v, np.append(x[0], x[:-2]))[:COUNT]


@pytest.fixture(scope="module")
def in_c(tmp_path_factory):
    """The same laws in C, as one library; parameters of one of them are changed where that is asked for."""
    texts, callers = {}, {}
    for name, (controller, fed, _) in LAWS.items():
        tuned = (controller, fed) == TUNED
        texts[name] = law_files(law(controller, fed, tunable=tuned), name, Source())
        changes = CHANGED[TUNED][0].items() if tuned else ()
        lines = " ".join(f"axis.parameters.{field} = {value!r};" for field, value in changes) or "(void)changed;"
        callers[name] = RUN_CHANGED.format(name=name, lines=lines)
    return library_of_laws(tmp_path_factory.mktemp("in_c"), texts, callers)


@pytest.fixture(scope="module")
def fmus(tmp_path_factory):
    folder = tmp_path_factory.mktemp("law_fmus")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(fmu, "zig", list)
        for name, (controller, fed, fmi) in LAWS.items():
            message = law(controller, fed)
            source = Source(model_hash=hash_of_law(message))
            written = fmu.write_law(message, name, source, fmi=fmi)
            assert any("sample time of the law, 0.0005 s" in note for note in written.notes)
            assert any(note.startswith("step the law before the plant") for note in written.notes)
            (folder / name).mkdir()
            (folder / name / "axis_x.fmu").write_bytes(written.files[f"{name}.fmu"])
    return folder


def stepped(unit, rows, first=0, dt=DT):
    """Return the effort after each sample; the inputs of an FMU stand in the order of those in C."""
    names = [variable.name for variable in unit.described.modelVariables if variable.causality == "input"]
    inputs = [dict(zip(names, row.tolist(), strict=True)) for row in rows]
    return unit.along(dt, inputs, "effort", first=first)[:, 0]


@pytest.mark.parametrize("name", LAWS)
def test_an_importer_finds_no_problem(fmus, name):
    from fmpy.validation import validate_fmu

    assert validate_fmu(str(fmus / name / "axis_x.fmu")) == []


@pytest.mark.parametrize("name", LAWS)
def test_efforts_are_identical_to_the_law_in_c(in_c, opened, name):
    controller, fed, _ = LAWS[name]
    rows = inputs_of(controller, fed)
    result = stepped(opened(name).start(), rows)
    assert np.ptp(result) > 20.0
    assert differing(result, replayed(in_c, name, rows, 0)) == 0


def test_changed_parameters_act_as_in_the_law_in_c(in_c, opened):
    rows = inputs_of(*TUNED)
    unit = opened("cascade_toothed").start()
    unit.set(**CHANGED[TUNED][0])
    result = stepped(unit, rows)
    assert differing(result, replayed(in_c, "cascade_toothed", rows, 1)) == 0
    assert differing(result, replayed(in_c, "cascade_toothed", rows, 0)) > COUNT // 2
    for values in ({"controller_k_p": -1.0}, {"measured": np.nan}, {"effort": 1.0}):
        with pytest.raises(Exception, match="SetFloat64 failed"):
            unit.set(**values)


@pytest.mark.parametrize("name", ["sliding_mode_all", "cascade_toothed"])
def test_a_saved_state_continues_and_damaged_bytes_are_refused(opened, name):
    rows = inputs_of(*LAWS[name][:2])
    unit, other = opened(name).start(), opened(name).start()
    virgin = unit.saved()
    first = stepped(unit, rows[:300])
    saved = unit.saved()
    rest = stepped(unit, rows[300:], 300)
    other.restore(saved)
    assert differing(stepped(other, rows[300:], 300), rest) == 0
    other.restore(virgin)
    assert differing(stepped(other, rows[:300]), first) == 0
    for place in (0, 17, len(saved) // 2, len(saved) - 1):
        with pytest.raises(Exception, match=r"erialize.* failed"):
            unit.restore(saved[:place] + bytes([saved[place] ^ 4]) + saved[place + 1 :])


def test_the_source_compiles_without_warnings(fmus, tmp_path):
    for name in LAWS:
        with zipfile.ZipFile(fmus / name / "axis_x.fmu") as archive:
            archive.extractall(tmp_path / name)
        compiled(tmp_path / name / "sources", *FLAGS, "-O1", "-fsyntax-only", *WARNINGS, f"{name}.c")


def test_the_description_lists_inputs_and_the_order_of_steps(fmus):
    described = described_by(fmus / "cascade_toothed" / "axis_x.fmu")
    variables = {each.get("name"): each for each in described.find("ModelVariables")}
    assert [name for name, each in variables.items() if each.get("causality") == "input"] == [
        "position",
        "velocity",
        "acceleration",
        "measured",
        "place_ahead[1]",
        "place_ahead[2]",
        "acceleration_ahead[1]",
        "acceleration_ahead[2]",
    ]
    assert (variables["effort"].get("unit"), variables["controller_k_p"].get("variability")) == ("N", "tunable")
    assert described.find("CoSimulation").get("fixedInternalStepSize") == repr(DT)
    assert described.find("ModelExchange") is None
