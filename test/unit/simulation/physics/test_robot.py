"""Robots as others write them, driven straight and turning: the speed is the one that is asked."""
import pytest

from img_recog.formats import world_file
from img_recog.model import Tree
from img_recog.report import lines_of
from img_recog.simulation import assembly
from img_recog.simulation.simulation_settings import PhysicsSettings
from img_recog_helpers.robots import read
from img_recog_helpers.wheeled import TURN_SHARE, velocity

INERTIAL = ('<inertial><mass value="{}"/><inertia ixx="{}" ixy="{}" ixz="0" iyy="{}" iyz="0" '
            'izz="{}"/></inertial>')
BASE = INERTIAL.format(2, 0.01, 0, 0.01, 0.01)
WHEEL = INERTIAL.format(0.1, 1e-4, 0, 1e-4, 1e-4)
ROBOT = '''<robot name="cart">
<link name="base_footprint"/>
<joint name="base_joint" type="fixed"><axis xyz="0 0 0"/>
  <parent link="base_footprint"/><child link="base_link"/></joint>
<link name="base_link">{base}<collision><origin xyz="0 0 0.06"/>
  <geometry><box size="0.2 0.16 0.04"/></geometry></collision></link>
{wheels}{casters}
<gazebo reference="base_link"><mu1>0.3</mu1><mu2>0.3</mu2></gazebo>
<gazebo reference="caster_-1"><mu1>0</mu1><mu2>0</mu2></gazebo>
<gazebo reference="caster_1"><mu1 value="0.0"/><mu2 value="0.0"/></gazebo>
<gazebo><plugin name="drive" filename="libgazebo_ros_diff_drive.so">
  <leftJoint>joint_1</leftJoint><rightJoint>joint_-1</rightJoint>
  <wheelSeparation>0.2</wheelSeparation><wheelDiameter>0.08</wheelDiameter>
</plugin></gazebo></robot>'''
SIDE = '''<link name="wheel_{side}">{wheel}<collision><origin rpy="{roll} 0 0"/><geometry>
  <cylinder radius="0.04" length="0.02"/></geometry></collision></link>
<joint name="joint_{side}" type="continuous"><origin xyz="0 {side}e-1 0.04"/><axis xyz="0 1 0"/>
  <parent link="base_link"/><child link="wheel_{side}"/></joint>'''
CASTER = '''<link name="caster_{side}">{caster}<collision>
  <geometry><sphere radius="0.02"/></geometry></collision></link>
<joint name="caster_joint_{side}" type="fixed"><origin xyz="{side}e-1 0 0.02"/>
  <axis xyz="0 0 0"/><parent link="base_link"/><child link="caster_{side}"/></joint>'''


def build(base=BASE, wheel=WHEEL, caster='', roll='1.5707963', more='</robot>', is_model=False):
    """Return the simulator of a cart with these inertials, and the warnings about its URDF.

    roll: of the cylinders of the wheels; more: the end of its URDF; is_model: whether it is a
    model of the world.
    """
    urdf = ROBOT.format(
        base=base, wheels=''.join(SIDE.format(
            side=side, wheel=wheel, roll=roll.format(side=side)) for side in (1, -1)),
        casters=''.join(CASTER.format(side=side, caster=caster) for side in (1, -1)))
    robot = read(urdf.replace('</robot>', more))
    built = assembly.build(PhysicsSettings(world='empty'), world_file.read('empty', {}),
                           [] if is_model else [robot])
    if is_model:
        built.world.load([Tree('cart', robot.model)])
    return built, lines_of(robot.findings)


ROBOTS = {
    'fixed casters without inertial': {},
    'wheels that lean to different sides': {'roll': '{side}.57'},
    'fixed casters with mass 0': {'caster': INERTIAL.format(0, 0, 0, 0, 0)},
    'casters with a mass': {'caster': INERTIAL.format(0.05, 1e-5, 0, 1e-5, 1e-5)},
    'no body has the inertia of the wheels': {'wheel': INERTIAL.format(0.1, 1e-5, 0, 1e-4, 1e-5)},
    'wheels without moments': {'wheel': INERTIAL.format(0.1, 0, 0, 0, 0)},
    'a negative moment by ixy': {'base': INERTIAL.format(2, 0.01, 0.02, 0.01, 0.01)}}


@pytest.mark.parametrize('name', ROBOTS)
def test_robots_drive_as_fast_as_asked(name):
    simulator, _ = build(**ROBOTS[name])
    assert velocity(simulator, 0.2) == pytest.approx((0.2, 0, 0), rel=0.02, abs=0.005)
    # wheels that turn so easily do not roll on their outer edges alone
    share, rel = (1.0, 0.1) if 'without moments' in name else (TURN_SHARE, 0.025)
    assert velocity(simulator, 0.0, 0.5) == pytest.approx((0, 0, share * 0.5), rel=rel, abs=0.005)
    assert simulator.robots[0].body.motion().position[2] == pytest.approx(0, abs=0.002)


@pytest.mark.parametrize('parts, words', [
    ('no body has the inertia of the wheels',
     'got the principal moments of inertia 1e-05, 1e-05, 0.0001 kg m2; those of a body are more '
     'than 0, and none exceeds the sum of the others; simulated with 3.67e-05, 3.67e-05, '
     '7.33e-05'),
    ('wheels without moments', 'simulated with 1e-05, 1e-05, 1e-05')])
def test_a_warning_names_the_link_and_its_inertia(parts, words):
    _, warnings = build(**ROBOTS[parts])
    assert len(warnings) == 2
    assert warnings[0].startswith('robot.urdf: link wheel_1 and what is fixed to it: got')
    assert all(warning.endswith(words) for warning in warnings)


ARM = '''<link name="arm"><inertial><origin xyz="0.15 0 0"/><mass value="0.2"/>
  <inertia ixx="1e-4" ixy="0" ixz="0" iyy="1e-3" iyz="0" izz="1e-3"/></inertial></link>
<joint name="arm_joint" type="revolute"><origin xyz="0.1 0 0.3"/><axis xyz="0 1 0"/>
  <limit lower="{}" upper="1.5" effort="10" velocity="2"/>
  <parent link="base_link"/><child link="arm"/></joint>
<transmission name="t"><joint name="arm_joint"><hardwareInterface>{}JointInterface
  </hardwareInterface></joint></transmission>
<gazebo><plugin name="c" filename="libgazebo_ros_control.so"/></gazebo></robot>'''


@pytest.mark.parametrize('is_model', [False, True])
@pytest.mark.parametrize('interface, lower, angle', [
    ('Position', -1.5, 0.0), ('Position', 0.2, 0.2), ('Velocity', -1.5, 0.0),
    ('Effort', -1.5, 1.5)])
def test_ros_control_holds_an_arm_that_nothing_commands(interface, lower, angle, is_model):
    simulator, _ = build(more=ARM.format(lower, interface), is_model=is_model)
    body = simulator.world.scenery[-1] if is_model else simulator.robots[0].body
    simulator.advance(1000)
    assert body.pose().joints[list(body.joints).index('arm_joint')] == pytest.approx(
        angle, abs=0.01)
