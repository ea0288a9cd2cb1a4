"""``bristle explain``: the meaning of each code."""

import pytest

from bristle.report.sentences import FORMER_CODES, SENTENCES


@pytest.mark.parametrize("code", ["one_direction", "structure", "delay_found"])
def test_a_code_has_its_meaning_and_advice(bristle, code):
    ended = bristle("explain", code)
    text = " ".join(ended.out.split()).lower()
    assert ended.code == 0
    assert SENTENCES[code].means.lower() in text
    advice = SENTENCES[code].advice.lower()
    assert ("no action needed" if advice == "nothing" else advice) in text


def test_all_codes_are_listed_and_the_json_has_the_names_of_numbers(bristle):
    listed = bristle("explain").out
    assert all(code in listed for code in SENTENCES)
    data = bristle("explain", "one_direction", "--json").data
    assert data["codes"]["one_direction"]["numbers"] == ["direction", "percent", "names"]


@pytest.mark.parametrize("code", FORMER_CODES)
def test_a_code_of_the_last_release_names_its_successor(bristle, code):
    successor = FORMER_CODES[code]
    assert code not in SENTENCES
    assert not successor or successor in SENTENCES
    ended = bristle("explain", code)
    assert ended.code == 0
    assert (f"Its successor is {successor}" if successor else "has no successor") in ended.err
