"""The materials that Gazebo 11 has in its gazebo.material, by name."""
from typing import Dict, Optional, Sequence

from img_recog.model import Color, Material

_PREFIX = 'Gazebo/'
_SIGN = 'drc/san_fauxcity_sign'         # the only one of that file with another prefix
# diffuse colors; SkyBlue, whose ambient color is another one, has what both give together
_COLORS: Dict[str, Sequence[float]] = {
    'Black': (0, 0, 0), 'BlackTransparent': (0, 0, 0, 0.5), 'Blue': (0, 0, 1),
    'BlueGlow': (0, 0, 1), 'BlueLaser': (0, 0, 1, 0.4), 'BlueTransparent': (0, 0, 1, 0.5),
    'BlueTransparentOverlay': (0, 0, 1, 0.5), 'DarkGray': (0.175, 0.175, 0.175),
    'DarkGrey': (0.175, 0.175, 0.175), 'DarkMagentaTransparent': (0.6, 0, 0.6, 0.5),
    'DarkOrangeTransparentOverlay': (0.6, 0.305, 0.028, 0.8), 'DarkYellow': (0.7, 0.7, 0),
    'Editor': (1, 1, 1), 'EditorPlane': (0.8, 0.8, 0.8), 'FlatBlack': (0.1, 0.1, 0.1),
    'Gold': (0.8, 0.649, 0.121), 'Gray': (0.7, 0.7, 0.7), 'Green': (0, 1, 0),
    'GreenGlow': (0, 1, 0), 'GreenTransparent': (0, 1, 0, 0.5),
    'GreenTransparentOverlay': (0, 1, 0, 0.5), 'Grey': (0.7, 0.7, 0.7),
    'GreyTransparent': (0.5, 0.5, 0.5, 0.5), 'Indigo': (0.33, 0, 0.5), 'JointAnchor': (1, 1, 1),
    'LightBlueLaser': (0.5, 0.5, 1, 0.4), 'LightOff': (1, 0, 0), 'LightOn': (0, 1, 0),
    'Orange': (1, 0.5088, 0.0468), 'OrangeTransparent': (1, 0.44, 0, 0.4),
    'OrangeTransparentOverlay': (1, 0.5088, 0.0468, 0.8), 'Pioneer2Body': (0.681, 0.001, 0.001),
    'PioneerBody': (1, 0, 0), 'PointCloud': (1, 1, 1), 'PointHandle': (1, 1, 1),
    'Purple': (1, 0, 1), 'PurpleGlow': (1, 0, 1), 'Red': (1, 0, 0),
    'RedBright': (0.87, 0.26, 0.07), 'RedGlow': (1, 0, 0), 'RedTransparent': (1, 0, 0, 0.5),
    'RedTransparentOverlay': (1, 0, 0, 0.5), 'SkyBlue': (0.05, 0.18, 0.88),
    'Turquoise': (0, 1, 1), 'TurquoiseGlow': (0, 1, 1), 'TurquoiseGlowOutline': (0, 1, 1),
    'White': (1, 1, 1), 'WhiteGlow': (1, 1, 1), 'Yellow': (1, 1, 0), 'YellowGlow': (1, 1, 0),
    'YellowTransparent': (1, 1, 0, 0.5), 'ZincYellow': (0.9725, 0.9529, 0.2078),
    # those for the passes of its own renderer, on nothing that is seen
    **dict.fromkeys(('CameraDistortionMap', 'CameraLensFlare', 'DepthMap', 'GaussianCameraNoise',
                     'LaserScan1st', 'LaserScan2nd', 'WideLensMap', 'XYZPoints'), (1, 1, 1))}
# the mean colors of their textures, which are not a part of this package
_MEANS: Dict[str, Sequence[float]] = {
    'Bricks': (0.562, 0.378, 0.37), 'BuildingFrame': (0.64, 0.64, 0.64),
    'CeilingTiled': (0.918, 0.918, 0.918), 'CloudySky': (0.678, 0.736, 0.994),
    'CoM': (0.5, 0.5, 0.5), 'Footway': (0.583, 0.582, 0.53), 'Grass': (0.246, 0.48, 0.053),
    'GreyGradientSky': (0.6, 0.6, 0.6), 'Lane_1': (0.483, 0.457, 0.418),
    'Lanes_2': (0.412, 0.411, 0.404), 'Lanes_4': (0.486, 0.459, 0.419),
    'Lanes_6': (0.411, 0.406, 0.396), 'Motorway': (0.411, 0.406, 0.396),
    'PaintedWall': (0.898, 0.772, 0.463), 'Pedestrian': (0.583, 0.582, 0.53),
    'Primary': (0.412, 0.411, 0.404), 'Residential': (0.476, 0.452, 0.424),
    'Road': (0.412, 0.411, 0.404), 'Runway': (0.403, 0.403, 0.388),
    'Secondary': (0.483, 0.457, 0.418), 'Steps': (0.47, 0.47, 0.47),
    'Tertiary': (0.476, 0.452, 0.424), 'Trunk': (0.486, 0.459, 0.419),
    'WindowFrame': (0.8, 0.8, 0.8), 'Wood': (0.763, 0.506, 0.266),
    'WoodFloor': (0.54, 0.25, 0.05), 'WoodPallet': (0.542, 0.383, 0.184)}
_SIGN_COLOR: Color = (0.05, 0.35, 0.2, 1.0)


def named(name: str) -> Optional[Material]:
    """Return the material that Gazebo gives that name, like Gazebo/Blue; None if it has none.

    >>> named('Gazebo/Blue').color, named('Gazebo/Plaid')
    ((0.0, 0.0, 1.0, 1.0), None)
    """
    if name == _SIGN:
        return Material(_SIGN_COLOR)
    if not name.startswith(_PREFIX):
        return None
    name = name[len(_PREFIX):]
    color = _COLORS.get(name) or _MEANS.get(name)
    if not color:
        return None
    red, green, blue, opacity = (float(value) for value in [*color, 1.0][:4])
    return Material((red, green, blue, opacity))
