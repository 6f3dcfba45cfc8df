"""For which colors the search is of use; test_masks.py tests that it finds all of their pixels."""
import pytest

from img_recog.recognition.candidates import Search
from img_recog.recognition.recognition_settings import with_colors


def is_useful(**limits):
    colors = with_colors(['a'])(a_hue_min=0, a_hue_max=180, **limits).colors
    return Search((48, 64), colors).is_useful


def test_it_is_of_use_for_the_colors_of_the_article():
    assert Search((48, 64), with_colors()().colors).is_useful


@pytest.mark.parametrize('saturation_min, expected', [(0, False), (3, False), (60, True)])
def test_it_is_of_no_use_for_colors_that_are_nearly_grey(saturation_min, expected):
    assert is_useful(a_saturation_min=saturation_min, a_saturation_max=255, a_value_min=0,
                     a_value_max=255) == expected


def test_it_finds_nothing_of_colors_that_no_pixel_has():
    assert is_useful(a_saturation_min=255, a_saturation_max=255, a_value_min=0, a_value_max=0)
