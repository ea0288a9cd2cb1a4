"""An export without options, what options become, and what is refused."""

from typing import Any

import pytest
from tests.exports.test_laws import variant_of
from tests.identification.known_logs import log_of, sines

import bristle as br
from bristle.exports import face
from bristle.exports.described import Source
from bristle.exports.targets import TARGETS, Product
from bristle.testing import example_of

COULOMB = br.friction.coulomb(F_C=1.0)


@pytest.fixture
def requested(monkeypatch):
    """Targets with the request, and whether harm is accepted."""
    seen = []

    def files(target, request, *, accept_harm):
        seen.append((target, request, accept_harm))
        return Product({"a.txt": "a"}, ("a note",))

    monkeypatch.setattr(face, "files_for", files)
    return seen


DEFAULTS = {"model": COULOMB, "name": "axis_x", "dt": 5e-4, "tunable": False, "single": False, "axis": None, "plant": None, "log": None}
DEFAULTS |= {"loop": None, "speed": 0.0, "points": 20, "mass": 1.0, "rest": "", "info": {}}


def test_default_options_are_fixed_parameters_half_a_millisecond_and_no_harm(requested, tmp_path):
    result = br.export(COULOMB, "c", tmp_path / "out")
    ((target, request, accept_harm),) = requested
    assert (target, accept_harm) == ("c", False)
    assert DEFAULTS.items() <= vars(request).items()
    assert (result.files, result.notes, result.effect) == (("a.txt",), ("a note",), None)
    assert (tmp_path / "out" / "a.txt").read_text() == "a"
    with pytest.raises(br.core.InputError):
        br.export(COULOMB, "c", tmp_path / "out")


def test_options_become_a_request(requested, tmp_path):
    br.export(COULOMB, "c", tmp_path / "out", accept_harm=True, tunable=True, float32=True, rest="middle", mass="2 kg")
    ((_, request, accept_harm),) = requested
    assert (request.tunable, request.single, request.rest, request.mass, accept_harm) == (True, True, "middle", 2.0, True)


@pytest.mark.parametrize(("points", "taken"), [(1, False), (2, True), (1000, True), (1001, False)])
def test_the_option_points_allows_two_to_a_thousand_entries(requested, tmp_path, points, taken):
    if taken:
        br.export(COULOMB, "table", tmp_path / "out", points=points)
        assert requested[0][1].points == points
    else:
        with pytest.raises(br.core.InputError, match="points"):
            br.export(COULOMB, "table", tmp_path / "out", points=points)


def test_text_and_missing_options_become_a_request(requested):
    options: dict[str, Any] = {"name": None, "step": None, "rest": None, "accept_harm": False}
    face.files_from_text(TARGETS["c"], COULOMB, Source(), **options)
    face.files_from_text(TARGETS["c"], COULOMB, Source(), **options | {"step": "2 ms", "name": "mine", "rest": "held", "accept_harm": True})
    assert [(request.name, request.dt, request.rest, harm) for _, request, harm in requested] == [
        ("axis_x", 5e-4, "", False),
        ("mine", 2e-3, "held", True),
    ]
    wrong: dict[str, Any]
    for wrong in ({"step": "0 s"}, {"rest": "moving"}, {"name": "int"}):
        with pytest.raises(br.core.InputError):
            face.files_from_text(TARGETS["c"], COULOMB, Source(), **options | wrong)


COULOMB, LUGRE, PLAY = br.friction.coulomb(F_C=1.0), example_of(br.friction.lugre), br.hysteresis.play(r=1.0)
MOTION = sines(duration=0.5)
LOG = {"log": log_of(MOTION, 12.0 * MOTION.acceleration)}
LAW = variant_of("cascade", "nothing")
NOT_A_TABLE = "is not a table"


@pytest.mark.parametrize(
    ("model", "to", "options", "words"),
    [
        (COULOMB, "cobol", {}, "no such target"),
        (COULOMB, "c", {"name": "int"}, "cannot name a function"),
        (COULOMB, "c", {"name": "Axis 1"}, "cannot name a function"),
        (COULOMB, "st", {"name": "limit"}, "cannot name a function block"),
        (COULOMB, "c", {"step": 0.0}, "step"),
        (COULOMB, "c", LOG, NOT_A_TABLE),
        (COULOMB, "mjcf", LOG, NOT_A_TABLE),
        (COULOMB, "sinumerik", LOG, NOT_A_TABLE),
        (LUGRE.with_values(sigma_0=1e39), "c", {"float32": True}, r"sigma_0: is too large for single precision.*float32"),
        (LUGRE, "c", {"derivatives": True, "float32": True}, "single precision"),
        (LUGRE, "st", {"derivatives": True}, "does not support derivatives"),
        (PLAY, "c", {"derivatives": True}, "of friction only"),
        (PLAY, "wasm", {}, "does not support hysteresis operators"),
        (PLAY, "casadi", {}, "operators"),
        (LAW, "wasm", {}, "does not support control laws"),
        (LAW, "fmu3", {"float32": True}, "single precision"),
    ],
)
def test_what_a_target_cannot_write_is_refused_without_a_file(tmp_path, model, to, options, words):
    with pytest.raises(br.core.InputError, match=words):
        br.export(model, to, tmp_path / "out", **options)
    assert not (tmp_path / "out").exists()
