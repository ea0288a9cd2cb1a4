"""Parameters as flat vectors and back: the layout, and what holds in every lane."""

from typing import NamedTuple

import numpy as np

from bristle.core.packing import (
    LANES,
    flattener,
    is_scalar,
    lane_constants,
    lane_packer,
    lane_unpacker,
    number_count,
    pack,
    packer,
    structure_of,
    unpacker,
)


class Inner(NamedTuple):
    a: float
    b: float


class Outer(NamedTuple):
    first: Inner
    count: int
    second: Inner
    last: float


class WithArray(NamedTuple):
    a: float
    k: np.ndarray
    inner: Inner
    z: np.ndarray


def same_array(value, other):
    return (
        np.array_equal(value.k, other.k)
        and np.array_equal(value.z, other.z)
        and (value.a, value.inner) == (other.a, other.inner)
    )


VALUE = Outer(Inner(1.0, 2.0), 7, Inner(3.0, 4.0), 5.0)
ARRAYS = WithArray(1.0, np.array([5.0, 6.0]), Inner(2.0, 3.0), np.zeros(0))


def test_numbers_lie_field_by_field_and_arrays_behind_their_length():
    assert pack(VALUE).tolist() == [1.0, 2.0, 7.0, 3.0, 4.0, 5.0]
    assert pack(ARRAYS).tolist() == [1.0, 2.0, 5.0, 6.0, 2.0, 3.0, 0.0]
    assert flattener(structure_of(VALUE))(VALUE) == (1.0, 2.0, 7, 3.0, 4.0, 5.0)
    assert number_count(structure_of(VALUE)) == 6


def test_a_structure_is_its_class_and_the_structures_of_its_fields():
    assert structure_of(VALUE) == (
        Outer,
        ((Inner, ("number", "number")), "integer", (Inner, ("number", "number")), "number"),
    )
    assert structure_of(Inner(True, np.float64(2.0)))[1] == ("number", "number")
    assert structure_of(Inner(np.int64(1), 2))[1] == ("integer", "integer")
    assert is_scalar(structure_of(VALUE))
    assert not is_scalar(structure_of(ARRAYS))

    class Around(NamedTuple):
        part: WithArray

    assert not is_scalar(structure_of(Around(ARRAYS)))


def test_packing_and_unpacking_are_inverse():
    back, vector = unpacker(structure_of(VALUE))(pack(VALUE)), np.zeros(6)
    assert (back, type(back), type(back.count)) == (VALUE, Outer, int)
    packer(structure_of(VALUE))(VALUE, vector)
    assert vector.tolist() == pack(VALUE).tolist()
    assert same_array(unpacker(structure_of(ARRAYS))(pack(ARRAYS)), ARRAYS)


def test_a_lane_is_every_so_many_numbers_of_a_block():
    for value in (VALUE, ARRAYS):
        numbers, structure = pack(value), structure_of(value)
        block = np.full((numbers.size + 3) * LANES, -1.0)
        block[2 * LANES + 3 : (2 + numbers.size) * LANES + 3 : LANES] = numbers
        assert pack(lane_unpacker(structure)(block, 2, 3)).tolist() == numbers.tolist()
    written, block = np.full(9 * LANES, -1.0), np.full(9 * LANES, -1.0)
    block[2 * LANES + 3 : 8 * LANES + 3 : LANES] = pack(VALUE)
    lane_packer(structure_of(VALUE))(VALUE, written, 2, 3)
    assert np.array_equal(written, block)


def test_infinite_and_equal_numbers_of_all_lanes_are_detected():
    rows = np.array([[1.0, 2.0, 7.0, 1.0, 2.0, np.inf], [3.0, 4.0, 8.0, 3.0, 4.0, np.inf]])
    constants = lane_constants(structure_of(VALUE), rows)
    assert constants.infinite == {5}
    assert constants.twins == {(3, 0), (4, 1)}
    apart = rows.copy()
    apart[1, 4], apart[0, 5] = 5.0, 6.0
    other = lane_constants(structure_of(VALUE), apart)
    assert (other.infinite, other.twins) == (frozenset(), frozenset())
    assert constants.word != other.word
    assert len(constants.word) == 8
    assert lane_constants(structure_of(ARRAYS), rows) == other
    negative = -rows
    assert lane_constants(structure_of(VALUE), negative).infinite == frozenset()


def test_equal_parts_of_a_lane_are_read_once():
    structure = structure_of(VALUE)
    rows = np.array([[1.0, 2.0, 7.0, 1.0, 2.0, np.inf]])
    unpack = lane_unpacker(structure, lane_constants(structure, rows))
    block = np.zeros(6 * LANES)
    block[::LANES] = [1.0, 2.0, 7.0, -9.0, -9.0, -9.0]
    assert unpack(block, 0, 0) == Outer(Inner(1.0, 2.0), 7, Inner(1.0, 2.0), np.inf)
