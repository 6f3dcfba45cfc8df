"""The materials of Gazebo 11's gazebo.material, all of them."""
import pytest

from img_recog.formats import materials

NAMES = '''
Grey DarkGrey White FlatBlack Black Red RedBright Green Blue SkyBlue Yellow ZincYellow DarkYellow
Purple Turquoise Orange Indigo WhiteGlow RedGlow GreenGlow BlueGlow YellowGlow PurpleGlow
TurquoiseGlow TurquoiseGlowOutline RedTransparentOverlay BlueTransparentOverlay
GreenTransparentOverlay OrangeTransparentOverlay DarkOrangeTransparentOverlay RedTransparent
GreenTransparent BlueTransparent DarkMagentaTransparent GreyTransparent BlackTransparent
YellowTransparent LightOn LightOff LightBlueLaser BlueLaser OrangeTransparent JointAnchor CoM
WoodFloor CeilingTiled PaintedWall PioneerBody Pioneer2Body Gold GreyGradientSky CloudySky
WoodPallet Wood Bricks Road Residential Tertiary Pedestrian Footway Motorway Lanes_6 Trunk Lanes_4
Primary Lanes_2 Secondary Lane_1 Steps GaussianCameraNoise CameraDistortionMap WideLensMap
CameraLensFlare PointCloud PointHandle BuildingFrame Runway Grass Editor EditorPlane DepthMap
XYZPoints LaserScan1st LaserScan2nd Gray DarkGray'''.split()


@pytest.mark.parametrize('name', ['Gazebo/' + name for name in NAMES] + ['drc/san_fauxcity_sign'])
def test_every_material_has_a_color(name):
    material = materials.gazebo_material(name)
    assert 0 <= min(material.color) and max(material.color) <= 1 and material.color[3] > 0


@pytest.mark.parametrize('name', ['Gazebo/Plaid', 'Grey', 'Shop/Grey', ''])
def test_other_names_are_unknown(name):
    assert materials.gazebo_material(name) is None
