"""The populations of an SDF world: copies of a model, placed like Gazebo's Population does it."""
import copy
import math
import xml.etree.ElementTree as ElementTree
from typing import List

import numpy as np

from img_recog import rotations
from img_recog.errors import SimulationError
from img_recog.formats.reader import MAX_COUNT, name_of, value, words
from img_recog.formats.sdf_frames import pose_of
from img_recog.rotations import IDENTITY

# of the search for uniform places; points for each place; above, they are random
_ROUNDS, _SAMPLES, _MAX_UNIFORM = 20, 50, 300


def models(population: ElementTree.Element) -> List[ElementTree.Element]:
    """Return the models of a <population>, each with its name and its pose in the world.

    Random places are the same ones each time.
    Raises SimulationError when a number is wrong, or the distribution is not known.
    """
    name, model = name_of(population), population.find('model')
    if model is None:
        raise SimulationError('population {} has no <model>'.format(name))
    pose, found = pose_of(population), []
    for number, place in enumerate(_places(population)):
        made = copy.deepcopy(model)
        made.set('name', '{}_clone_{}'.format(name_of(model), number))
        for old in made.findall('pose'):
            made.remove(old)
        at = pose @ IDENTITY._replace(translation=place) @ pose_of(model)
        ElementTree.SubElement(made, 'pose').text = words(
            (*at.translation, *rotations.to_rpy(at.rotation)))
        found.append(made)
    return found


def _places(population: ElementTree.Element) -> np.ndarray:
    """Return where the models are, (n, 3), in the frame of the population."""
    kind, box = value(population, 'distribution/type'), population.find('box')
    if kind == 'grid':
        rows, columns = (value(population, 'distribution/' + tag) for tag in ('rows', 'cols'))
        cells = [(column, row, 0) for row in range(rows) for column in range(columns)][:MAX_COUNT]
        return np.array(cells, float).reshape(-1, 3) * value(population, 'distribution/step')
    number = value(population, 'model_count')
    size = np.zeros(3) if box is None else value(population, 'box/size')
    if kind.startswith('linear-') and kind[-1] in 'xyz' and box is not None:
        places = np.zeros((number, 3))
        axis = 'xyz'.index(kind[-1])
        places[:, axis] = np.linspace(-size[axis] / 2, size[axis] / 2, number)
        return places
    if kind not in ('random', 'uniform'):
        raise SimulationError('population {}, whose distribution is {}'.format(
            name_of(population), kind))
    generator = np.random.default_rng(0)
    if kind == 'random' or not 0 < number <= _MAX_UNIFORM:
        return _random(generator, population, size, number)
    samples = _random(generator, population, size, number * _SAMPLES)
    centers = samples[:number]
    for _ in range(_ROUNDS):        # Lloyd's algorithm
        nearest = np.argmin(((samples[:, None] - centers) ** 2).sum(axis=-1), axis=1)
        centers = np.array([samples[nearest == each].mean(axis=0) if np.any(nearest == each)
                            else center for each, center in enumerate(centers)])
    return centers.reshape(-1, 3)


def _random(generator: np.random.Generator, population: ElementTree.Element, size: np.ndarray,
            count: int) -> np.ndarray:
    """Return random points (n, 3) in the box, whose size is given, or the cylinder."""
    points = generator.uniform(-0.5, 0.5, (count, 3)) * size
    if population.find('cylinder') is not None:
        radius, length = (value(population, 'cylinder/' + tag) for tag in ('radius', 'length'))
        angle = generator.uniform(0, 2 * math.pi, count)
        distance = radius * np.sqrt(generator.uniform(0, 1, count))
        points = np.column_stack([distance * np.cos(angle), distance * np.sin(angle),
                                  generator.uniform(-length / 2, length / 2, count)])
    return points
