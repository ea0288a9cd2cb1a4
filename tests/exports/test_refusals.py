"""What a target cannot write is refused by name, and leaves no file."""

import pytest
from tests.exports.test_laws import variant_of
from tests.identification.known_logs import log_of, sines

import bristle as br
from bristle.testing import example_of

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
