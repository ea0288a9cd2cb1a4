"""Numbers and data on their way to a page."""

import math

import numpy as np
import pytest

from bristle.exports.page.packing import as_json, differences, packed, packed_numbers, plain, unpacked


def test_bytes_are_restored_and_may_refer_to_earlier_bytes():
    content = bytes(range(256)) * 8
    assert unpacked(packed(content)) == content
    assert len(packed(content, content)) < len(packed(content))


@pytest.mark.parametrize("times", [0, 1, 2])
def test_differences_are_summed_up_again(times):
    numbers = np.array([3.0, 5.0, 4.0, 4.0, -7.0])
    back = differences(numbers, times)
    for _ in range(times):
        back = np.cumsum(back)
    assert back.tolist() == numbers.tolist()
    assert differences(np.arange(1.0, 9.0), 2)[1:].tolist() == [0.0] * 7


def test_small_numbers_of_either_sign_have_small_bytes():
    parts = [np.array([0.0, -1.0, 1.0, -2.0]), np.array([127.0, -128.0, 40_000.0, -(2.0**31)])]
    message = packed_numbers(parts)
    assert message["count"] == 8
    planes = np.frombuffer(unpacked(message["code"]), dtype=np.uint8).reshape(4, 8)
    folded = sum(planes[place].astype(np.int64) << (8 * place) for place in range(4))
    back = np.where(folded % 2 == 0, folded // 2, -(folded + 1) // 2)
    assert back.tolist() == np.concatenate(parts).tolist()
    assert planes[1:, :6].tolist() == [[0] * 6] * 3
    assert packed_numbers([])["count"] == 0


def test_data_of_a_page_end_no_element_and_have_words_for_infinity():
    assert as_json({"a": "</script>", "b": (1, math.inf), "c": [-math.inf, 0.5]}) == (
        '{"a":"\\u003c/script>","b":[1,"Infinity"],"c":["-Infinity",0.5]}'
    )
    assert plain({"a": None}) == {"a": None}
