"""Lines as they are drawn: of few corners, and close to each point."""

import numpy as np
import pytest
from tests.lab.scripts import needs_node, node

pytestmark = needs_node
CLOSE = 0.2  # [px]
DRAWN = """
const x = POINTS.map(([across]) => across), y = POINTS.map(([, up]) => up), corners = [];
const context = { moveTo: (...point) => corners.push(point), lineTo: (...point) => corners.push(point) };
straightened(context, 0, x.length - 1, (k) => x[k], (k) => y[k]);
say(corners);
"""
TURN = np.linspace(0.0, 2.0 * np.pi, 20_000)
LINES = {
    "a loop": np.column_stack((250.0 * np.sin(TURN), 150.0 * np.tanh(6.0 * np.cos(TURN)))),
    "there and back, further out each time": np.column_stack((TURN * 30.0 * np.sin(6.0 * TURN), np.zeros(TURN.size))),
    "a corner at each point": np.column_stack((np.arange(200.0), 40.0 * (np.arange(200) % 2))),
    "a spiral into a point": np.column_stack((np.cos(9.0 * TURN), np.sin(9.0 * TURN))) * (80.0 - 12.7 * TURN)[:, None],
    "noise": np.random.default_rng(5).normal(0.0, 3.0, (3000, 2)).cumsum(axis=0),
    "one point": np.zeros((1, 2)),
}


def corners(points, folder):
    return np.array(node(folder, [], DRAWN.replace("POINTS", str(points.tolist()))))


def off(points, line):
    """Return how far points are from a line of straight pieces."""
    start, end = line[:-1], line[1:]
    along = end - start
    squares = np.maximum(np.sum(along**2, axis=1), 1e-30)
    part = np.clip(np.sum((points[:, None] - start) * along, axis=2) / squares, 0.0, 1.0)
    return np.min(np.linalg.norm(points[:, None] - (start + part[..., None] * along), axis=2), axis=1)


@pytest.mark.slow
@pytest.mark.parametrize("name", LINES)
def test_no_point_is_further_from_the_line_than_a_fifth_of_a_pixel(name, tmp_path):
    points = LINES[name]
    line = corners(points, tmp_path)
    assert np.array_equal(line[[0, -1]], points[[0, -1]])
    assert np.max(off(points[::7], line)) <= 1.05 * CLOSE
    # Nor does the line lead where no point is.
    assert np.max(off(line, points[:1].repeat(2, axis=0) if len(points) == 1 else points)) <= 1e-9


def test_a_loop_of_20_000_samples_has_few_corners(tmp_path):
    assert len(corners(LINES["a loop"], tmp_path)) < 250
    assert len(corners(LINES["there and back, further out each time"], tmp_path)) < 30
