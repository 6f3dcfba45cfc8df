"""Masses at the limits of what is allowed."""
import pytest

from img_recog.simulation.descriptions import urdf_elements
from img_recog_testing.refusals import refusal


@pytest.mark.parametrize('mass', [1e-20, 1, 1e9])
def test_masses_that_can_be_used(mass):
    urdf_elements.check_mass('m', mass)


@pytest.mark.parametrize('mass, words', [
    (0, 'got 0 kg, expected more than 0'), (-1, 'got -1 kg, expected more than 0'),
    (1e-21, 'got 1e-21 kg, expected more than 0'), (1.1e9, 'kg, expected at most 1e+09')])
def test_masses_that_are_refused(mass, words):
    line = refusal(urdf_elements.check_mass, 'm', mass, ' or none')
    assert line.startswith('m: got ') and line.endswith(words + ' or none')
