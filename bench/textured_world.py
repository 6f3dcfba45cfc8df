"""A world like a furnished house: models of many triangles, each with a texture of its own."""
import os

import numpy as np
from PIL import Image

MODELS, TEXTURE_PX = 60, 1024
ROWS, COLUMNS = 24, 48              # of a model; two triangles in each place
DISTANCE_M, RADIUS_M = 2.0, 0.35    # of the models, which stand in rings around the robot
_COLLADA = '''<COLLADA version="1.4.1" xmlns="http://www.collada.org/2005/11/COLLADASchema">
<asset><unit meter="1" name="m"/></asset>
<library_images><image id="i"><init_from>{name}.png</init_from></image></library_images>
<library_effects><effect id="e"><profile_COMMON><newparam sid="s"><surface type="2D"><init_from>i
</init_from></surface></newparam><newparam sid="t"><sampler2D><source>s</source></sampler2D>
</newparam><technique sid="c"><lambert><diffuse><texture texture="t" texcoord="u"/></diffuse>
</lambert></technique></profile_COMMON></effect></library_effects>
<library_materials><material id="m"><instance_effect url="#e"/></material></library_materials>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="pa" count="{count3}">{positions}</float_array><technique_common>
<accessor source="#pa" count="{count}" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<source id="u"><float_array id="ua" count="{count2}">{uvs}</float_array><technique_common>
<accessor source="#ua" count="{count}" stride="2"><param name="S" type="float"/>
<param name="T" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="{triangles}" material="m"><input semantic="VERTEX" source="#v" offset="0"/>
<input semantic="TEXCOORD" source="#u" offset="0"/><p>{corners}</p></triangles>
</mesh></geometry></library_geometries><library_visual_scenes><visual_scene id="scene"><node>
<instance_geometry url="#g"><bind_material><technique_common><instance_material symbol="m"
target="#m"/></technique_common></bind_material></instance_geometry></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#scene"/></scene></COLLADA>
'''
_MODEL = '''<model name="{name}"><static>1</static><pose>{x} {y} 0 0 0 0</pose><link name="l">
<visual name="v"><geometry><mesh><uri>{name}.dae</uri></mesh></geometry></visual>
<collision name="c"><pose>0 0 0.5 0 0 0</pose><geometry><cylinder><radius>0.4</radius>
<length>1</length></cylinder></geometry></collision></link></model>
'''


def write(folder: str) -> str:
    """Write the world and its files into a folder; return the path of its SDF."""
    models = []
    for number in range(MODELS):
        name, random = 'model_{}'.format(number), np.random.RandomState(number)
        with open(os.path.join(folder, name + '.dae'), 'w') as file:
            file.write(_collada(name, random))
        _image(random).save(os.path.join(folder, name + '.png'), compress_level=6)
        ring, angle = 1 + number // 12, 2 * np.pi * (number + number // 12 / 2) / 12
        models.append(_MODEL.format(name=name, x=DISTANCE_M * ring * np.cos(angle),
                                    y=DISTANCE_M * ring * np.sin(angle)))
    path = os.path.join(folder, 'house.sdf')
    with open(path, 'w') as file:
        file.write('<sdf version="1.6"><world name="house"><include><uri>model://ground_plane'
                   '</uri></include>{}</world></sdf>'.format(''.join(models)))
    return path


def _collada(name: str, random: np.random.RandomState) -> str:
    """Return a vase with bumps of 1 m."""
    heights, turns = np.meshgrid(np.linspace(0, 1, ROWS + 1), np.linspace(0, 1, COLUMNS + 1),
                                 indexing='ij')
    radii = RADIUS_M * np.sin(np.pi * (0.05 + 0.9 * heights)) + random.uniform(
        0, 0.01, heights.shape)
    radii[:, -1] = radii[:, 0]
    positions = np.stack([radii * np.cos(2 * np.pi * turns), radii * np.sin(2 * np.pi * turns),
                          heights], axis=2).reshape(-1, 3)
    numbers = np.arange(len(positions)).reshape(heights.shape)
    a, b = numbers[:-1, :-1], numbers[:-1, 1:]
    c, d = numbers[1:, :-1], numbers[1:, 1:]
    corners = np.stack([a, b, d, a, d, c], axis=2).ravel()
    uvs = np.stack([turns, heights], axis=2).reshape(-1, 2)
    return _COLLADA.format(
        name=name, count=len(positions), count2=2 * len(positions), count3=3 * len(positions),
        triangles=len(corners) // 3, corners=' '.join(map(str, corners)),
        positions=' '.join(map('{:.5f}'.format, positions.ravel())),
        uvs=' '.join(map('{:.5f}'.format, uvs.ravel())))


def _image(random: np.random.RandomState) -> Image.Image:
    """Return a picture of spots of all sizes, which takes as long to decode as a photograph."""
    image = np.full((TEXTURE_PX, TEXTURE_PX, 3), random.uniform(80, 180, 3))
    for spots in (4, 16, 64, 256):
        spread = 25.0 * 4 / spots ** 0.5
        cells = random.uniform(-spread, spread, (spots, spots, 3))
        image += cells.repeat(TEXTURE_PX // spots, axis=0).repeat(TEXTURE_PX // spots, axis=1)
    return Image.fromarray(np.clip(image, 0, 255).astype(np.uint8))
