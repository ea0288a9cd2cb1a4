"""The feed of an exported compensator: one rule, in C, in Structured Text and in HAL."""

from dataclasses import replace

import numpy as np
import pytest
from tests.exports.importing import needs_compiler
from tests.exports.native import built, differing, in_structured_text
from tests.exports.test_drive import export_request

import bristle as br
from bristle.exports.feed import fed
from bristle.exports.targets import TARGETS
from bristle.models.controllers.feedforward import Rule

RULE = Rule(0.9, 8e-6, 0.05, 3.0, 200.0)
REQUEST = export_request(rule=RULE, rest="held")


@needs_compiler
@pytest.mark.parametrize("options", [{}, {"single": True}, {"tunable": True}])
def test_the_self_test_of_c_holds_the_feed(tmp_path, options):
    files = TARGETS["c"].write(replace(REQUEST, **options)).files
    assert "#define AXIS_X_GAIN 0.9" in files["axis_x.h"]
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    assert built(tmp_path, "axis_x_selftest.c").returncode == 0
    (tmp_path / "axis_x.h").write_text(
        files["axis_x.h"].replace("#define AXIS_X_GAIN 0.9", "#define AXIS_X_GAIN 0.8")
    )
    assert ("the feed differs" in built(tmp_path, "axis_x_selftest.c").stdout) == (
        not options.get("single")
    )


@needs_compiler
def test_structured_text_feeds_the_same_share(tmp_path):
    """Moves with rests between them, in steps that cross pre-sliding."""
    files = TARGETS["st"].write(REQUEST).files
    texts = [str(files[f"axis_x{end}.st"]) for end in ("", "_selftest")]
    block = in_structured_text({"axis_x": texts}, tmp_path / "feed", outputs={"axis_x": "feed"})
    x = 1e-6 * np.repeat(np.cumsum(np.tile([1.0, 3.0, -2.0, -5.0, 8.0], 40)), 3)
    feed, flags = block.run("axis_x", x, 1e-3, gain=0.9, return_distance=8e-6, fade_time=0.05)
    forces = br.response(REQUEST.model, x, 1e-3, rest="held")
    expected = fed(x, forces.tolist(), 1e-3, RULE)
    assert not flags.any()
    assert np.max(np.abs(expected - forces)) > 1.0
    assert differing(feed, expected) == 0


def test_the_feed_of_the_whole_friction_is_the_friction():
    x = 1e-6 * np.cumsum(np.tile([1.0, 3.0, -2.0, 0.0, -5.0], 40))
    forces = br.response(REQUEST.model, x, 1e-3, rest="held")
    np.testing.assert_array_equal(fed(x, forces.tolist(), 1e-3, Rule())[1:], forces[1:])
