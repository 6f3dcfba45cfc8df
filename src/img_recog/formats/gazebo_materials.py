"""The materials that Gazebo 11 has in its gazebo.material, by name."""
from typing import Dict, Optional, Sequence, Tuple

from img_recog.model import WHITE, Color, Material, Rgb

_PREFIX = 'Gazebo/'
_SIGN = 'drc/san_fauxcity_sign'         # the only one of that file with another prefix
_DIM = (0.1, 0.1, 0.1)
# colors, which ambient and directed light share; of the highlight; its exponent
_PLAIN: Dict[str, Tuple[Sequence[float], float, float]] = {
    'Black': ((0, 0, 0), 0.1, 5), 'Blue': ((0, 0, 1), 0.1, 1),
    'DarkGrey': ((0.175, 0.175, 0.175), 0.175, 1.5), 'DarkYellow': ((0.7, 0.7, 0), 0, 0),
    'Editor': ((1, 1, 1), 0.1, 128), 'FlatBlack': (_DIM, 0.01, 1), 'Green': ((0, 1, 0), 0.1, 1),
    'Indigo': ((0.33, 0, 0.5), 0.1, 1), 'Orange': ((1, 0.5088, 0.0468), 0.5, 128),
    'PioneerBody': ((0.884, 0, 0), 0, 0), 'Purple': ((1, 0, 1), 0.1, 1),
    'Red': ((1, 0, 0), 0.1, 1), 'Turquoise': ((0, 1, 1), 0.1, 1), 'White': ((1, 1, 1), 0.1, 128),
    'Yellow': ((1, 1, 0), 0, 0), 'TurquoiseGlowOutline': ((0, 1, 1), 0.1, 128),
    'BlackTransparent': ((0, 0, 0, 0.5), 0, 0), 'BlueLaser': ((0, 0, 1, 0.4), 0, 0),
    'BlueTransparent': ((0, 0, 1, 0.5), 0, 0), 'GreenTransparent': ((0, 1, 0, 0.5), 0, 0),
    'DarkMagentaTransparent': ((0.6, 0, 0.6, 0.5), 0, 0),
    'GreyTransparent': ((0.5, 0.5, 0.5, 0.5), 0, 0),
    'LightBlueLaser': ((0.5, 0.5, 1, 0.4), 0, 0), 'OrangeTransparent': ((1, 0.44, 0, 0.4), 0, 0),
    'YellowTransparent': ((1, 1, 0, 0.5), 0, 0)}
# what is the same in any light, or with a light of its own
_BRIGHT: Dict[str, Sequence[float]] = {
    'BlueGlow': (0, 0, 1), 'BlueTransparentOverlay': (0, 0, 1, 0.5),
    'CloudySky': (0.678, 0.736, 0.994), 'DarkOrangeTransparentOverlay': (0.6, 0.305, 0.028, 0.8),
    'GreenGlow': (0, 1, 0), 'GreenTransparentOverlay': (0, 1, 0, 0.5),
    'GreyGradientSky': (0.6, 0.6, 0.6), 'JointAnchor': (1, 1, 1), 'LightOff': (1, 0, 0),
    'LightOn': (0, 1, 0), 'OrangeTransparentOverlay': (1, 0.5088, 0.0468, 0.8),
    'PointHandle': (1, 1, 1), 'PurpleGlow': (1, 0, 1), 'RedGlow': (1, 0, 0),
    'RedTransparent': (1, 0, 0, 0.5), 'RedTransparentOverlay': (1, 0, 0, 0.5),
    'TurquoiseGlow': (0, 1, 1), 'WhiteGlow': (1, 1, 1), 'YellowGlow': (1, 1, 0)}
# of the others that glow, the glow is added to white
_WHITE_BELOW = ('BlueGlow', 'GreenGlow', 'PurpleGlow', 'TurquoiseGlow', 'YellowGlow')
_GREY = Material((0.7, 0.7, 0.7, 1.0), ambient=(0.3, 0.3, 0.3), specular=(0.01, 0.01, 0.01),
                 shininess=1.5)
_OTHERS: Dict[str, Material] = {
    'EditorPlane': _GREY, 'Grey': _GREY,
    'Gold': Material((0.8, 0.649, 0.121, 1.0), ambient=(0.4, 0.249, 0.021),
                     specular=(0.4, 0.4, 0.4), shininess=12.5),
    'Pioneer2Body': Material((0.681, 0.001, 0.001, 1.0), ambient=(0.481, 0.0, 0.0),
                             specular=(0.5, 0.5, 0.5), shininess=12.5),
    'RedBright': Material((0.87, 0.26, 0.07, 1.0), specular=(0.87, 0.26, 0.07), shininess=1.0),
    'SkyBlue': Material((0.0, 0.0, 1.0, 1.0), ambient=(0.13, 0.44, 0.7), specular=_DIM,
                        shininess=1.0),
    'ZincYellow': Material((0.9725, 0.9529, 0.2078, 1.0), specular=(0.9725, 0.9529, 0.2078),
                           shininess=1.0)}
# The mean color of a texture, which is not a part of this package; the shares of ambient and of
# directed light that it sends; of the highlight; its exponent
_LANES_1, _LANES_2 = (0.483, 0.457, 0.418), (0.412, 0.411, 0.404)
_LANES_4, _LANES_6 = (0.486, 0.459, 0.419), (0.411, 0.406, 0.396)
_HOUSES, _PAVING = (0.476, 0.452, 0.424), (0.583, 0.582, 0.53)
_ROADS: Dict[str, Rgb] = {
    'Footway': _PAVING, 'Lane_1': _LANES_1, 'Lanes_2': _LANES_2, 'Lanes_4': _LANES_4,
    'Lanes_6': _LANES_6, 'Motorway': _LANES_6, 'Pedestrian': _PAVING, 'Primary': _LANES_2,
    'Residential': _HOUSES, 'Road': _LANES_2, 'Secondary': _LANES_1, 'Steps': (0.47, 0.47, 0.47),
    'Tertiary': _HOUSES, 'Trunk': _LANES_4}
_TEXTURED: Dict[str, Tuple[Rgb, float, float, float, float]] = {
    **{name: (mean, 0.1, 0.8, 0.01, 2.0) for name, mean in _ROADS.items()},
    'Bricks': ((0.562, 0.378, 0.37), 1.0, 1.0, 0.2, 12.5),
    'BuildingFrame': ((0.64, 0.64, 0.64), 1.0, 1.0, 0.2, 12.5),
    'CeilingTiled': ((0.918, 0.918, 0.918), 0.5, 1.0, 0.0, 0.0),
    'CoM': ((0.5, 0.5, 0.5), 0.5, 1.0, 0.0, 0.0),
    'Grass': ((0.246, 0.48, 0.053), 0.5, 1.0, 0.0, 0.0),
    'PaintedWall': ((0.898, 0.772, 0.463), 1.0, 1.0, 0.0, 0.0),
    'Runway': ((0.403, 0.403, 0.388), 0.5, 1.0, 0.0, 0.0),
    'Wood': ((0.763, 0.506, 0.266), 1.0, 1.0, 0.2, 12.5),
    'WoodFloor': ((0.54, 0.25, 0.05), 0.5, 1.0, 0.0, 0.0),
    'WoodPallet': ((0.542, 0.383, 0.184), 0.5, 1.0, 0.0, 0.5)}
_SAME = {'Gray': 'Grey', 'DarkGray': 'DarkGrey'}
# those for the passes of its own renderer, on nothing that is seen
_INTERNAL = ('CameraDistortionMap', 'CameraLensFlare', 'DepthMap', 'GaussianCameraNoise',
             'LaserScan1st', 'LaserScan2nd', 'PointCloud', 'Reflectance', 'WideLensMap',
             'XYZNormals', 'XYZPoints')


def named(name: str) -> Optional[Material]:
    """Return the material that Gazebo gives that name, like Gazebo/Blue; None if it has none.

    >>> named('Gazebo/Gold').ambient, named('Gazebo/Plaid')
    ((0.4, 0.249, 0.021), None)
    """
    if name == _SIGN:
        return Material((0.05, 0.35, 0.2, 1.0), specular=_DIM, shininess=2.0)
    if not name.startswith(_PREFIX):
        return None
    name = name[len(_PREFIX):]
    name = _SAME.get(name, name)
    if name in _PLAIN:
        color, specular, shininess = _PLAIN[name]
        return Material(_color(color), specular=(specular,) * 3, shininess=shininess)
    if name in _BRIGHT:
        red, green, blue, opacity = _color(_BRIGHT[name])
        color = (1.0, 1.0, 1.0) if name in _WHITE_BELOW else (0.0, 0.0, 0.0)
        return Material((*color, opacity), emissive=(red, green, blue))
    if name in _TEXTURED:
        mean, ambient, diffuse, specular, shininess = _TEXTURED[name]
        red, green, blue = (diffuse * value for value in mean)
        return Material((red, green, blue, 1.0), specular=(specular,) * 3, shininess=shininess,
                        ambient=(ambient * mean[0], ambient * mean[1], ambient * mean[2]))
    return WHITE if name in _INTERNAL else _OTHERS.get(name)


def _color(values: Sequence[float]) -> Color:
    red, green, blue, opacity = (float(value) for value in [*values, 1.0][:4])
    return red, green, blue, opacity
