"""Rows along which a model is led on a page: the turns between them."""

import numpy as np

from bristle.exports.page.rows import turns_of


def test_turns_are_reversals_deeper_than_the_depth():
    x = np.array([0.0, 1.0, 3.0, 2.9, 4.0, 4.0, 1.0, 1.5, 0.0])
    assert turns_of(x, 0.0).tolist() == [0, 2, 3, 5, 6, 7, 8]
    assert turns_of(x, 0.3).tolist() == [0, 5, 6, 7, 8]
    assert turns_of(x, 1.0).tolist() == [0, 5, 8]
    assert turns_of(np.zeros(5), 0.0).tolist() == [0, 4]
