"""Masses at the limits of what is allowed, and another friction."""
import xml.etree.ElementTree as ElementTree

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


def test_another_friction_takes_the_place_of_the_first():
    link = ElementTree.Element('link')
    for value in (0.5, 0.25):
        urdf_elements.set_friction(link, value)
    assert [each.get('value') for each in link.iter('lateral_friction')] == ['0.25']
