"""The materials that Gazebo 11 has in its gazebo.material, by name."""
from typing import Dict, Optional, Sequence, Tuple

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
_ASPHALT, _PAVING = (0.3, 0.3, 0.3), (0.62, 0.61, 0.59)
# a mean color in place of that of the texture, and a pattern of rendering/patterns.py
_PATTERNED: Dict[str, Tuple[Sequence[float], str]] = {
    'Bricks': ((0.56, 0.38, 0.37), 'bricks'), 'BuildingFrame': ((0.8, 0.8, 0.8), 'frame'),
    'CeilingTiled': ((0.8, 0.8, 0.78), 'tiles'), 'CloudySky': ((0.62, 0.72, 0.84), 'clouds'),
    'CoM': ((0.5, 0.5, 0.5), 'quarters'), 'Footway': (_PAVING, 'tiles'),
    'Grass': ((0.3, 0.42, 0.18), 'grass'), 'GreyGradientSky': ((0.6, 0.6, 0.6), 'gradient'),
    'Lane_1': (_ASPHALT, 'lane'), 'Lanes_2': (_ASPHALT, 'lanes 2'),
    'Lanes_4': (_ASPHALT, 'lanes 4'), 'Lanes_6': (_ASPHALT, 'lanes 6'),
    'Motorway': (_ASPHALT, 'lanes 6'), 'PaintedWall': ((0.85, 0.82, 0.74), 'plaster'),
    'Pedestrian': (_PAVING, 'tiles'), 'Primary': (_ASPHALT, 'lanes 2'),
    'Residential': (_ASPHALT, 'lanes 2'), 'Road': (_ASPHALT, 'lanes 2'),
    'Runway': (_ASPHALT, 'lanes 2'), 'Secondary': (_ASPHALT, 'lane'),
    'Steps': ((0.5, 0.5, 0.48), 'steps'), 'Tertiary': (_ASPHALT, 'lanes 2'),
    'Trunk': (_ASPHALT, 'lanes 4'), 'WindowFrame': ((0.8, 0.8, 0.8), 'frame'),
    'Wood': ((0.74, 0.65, 0.64), 'wood'), 'WoodFloor': ((0.55, 0.4, 0.27), 'planks'),
    'WoodPallet': ((0.54, 0.38, 0.18), 'planks')}
_SIGN_COLOR: Color = (0.05, 0.35, 0.2, 1.0)


def named(name: str) -> Optional[Material]:
    """Return the material that Gazebo gives that name, like Gazebo/Blue; None if it has none.

    >>> named('Gazebo/Bricks').pattern, named('Gazebo/Plaid')
    ('bricks', None)
    """
    if name == _SIGN:
        return Material(_SIGN_COLOR)
    if not name.startswith(_PREFIX):
        return None
    name = name[len(_PREFIX):]
    color, pattern = _PATTERNED.get(name, (_COLORS.get(name, ()), ''))
    if not color:
        return None
    red, green, blue, opacity = (float(value) for value in [*color, 1.0][:4])
    return Material((red, green, blue, opacity), pattern=pattern)
