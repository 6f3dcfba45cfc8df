"""Gazebo's tags in, settings out: each value with its type, each refusal, and what is left."""
import numpy as np
import pytest

from img_recog.conversions.sensor_table import SENSORS
from img_recog.formats.drive_tags import DIFF_DRIVE, PLUGINS
from img_recog.formats.noises import Noise
from img_recog.settings import setting_fields
from img_recog_helpers import parsed
from img_recog_helpers.refusals import refusal
from img_recog_helpers.robots import burger

DRIVE_TAGS = {
    'leftJoint': 'wheel_left_joint', 'rightJoint': 'wheel_right_joint',
    'wheelSeparation': '0.160', 'wheelDiameter': '0.066', 'wheelTorque': '10',
    'wheelAcceleration': '1', 'odometrySource': 'world', 'publishOdomTF': 'true',
    'odometryFrame': 'odom', 'robotBaseFrame': 'base_footprint', 'commandTopic': 'cmd_vel',
    'odometryTopic': 'odom', 'updateRate': '30', 'publishTf': 'true', 'rosDebugLevel': 'na'}
DRIVE_SETTINGS = {
    'left_joint': 'wheel_left_joint', 'right_joint': 'wheel_right_joint',
    'wheel_separation': 0.16, 'wheel_diameter': 0.066, 'wheel_torque': 10.0,
    'wheel_acceleration': 1.0, 'odometry_source': 'world', 'publish_odom_tf': True,
    'odom_frame': 'odom', 'base_frame': 'base_footprint', 'command_topic': 'cmd_vel',
    'odometry_topic': 'odom', 'odometry_period_s': 0.033, 'joint_states_period_s': 0.033,
    'drive_period_s': 0.033}
SCAN_SETTINGS = {
    'scan_period_s': 0.2, 'scan_samples': 360, 'scan_angle_min': 0.0, 'scan_angle_max': 6.28319,
    'scan_range_min': 0.12, 'scan_range_max': 3.5, 'scan_noise': 0.01,
    'scan_resolution': 1.0, 'scan_frame': 'base_scan', 'scan_topic': 'scan'}
RANGE_TAGS = {'updateRate': '4', 'gaussianNoise': '0.5', 'fov': '0.2', 'radiation': 'Ultrasound',
              'frameName': 'ear', 'topicName': 'sonar'}
RANGE_SETTINGS = {
    'range_period_s': 0.25, 'range_samples': 360, 'range_angle_min': 0.0,
    'range_angle_max': 6.28319, 'range_min': 0.12, 'range_max': 3.5, 'range_noise': 0.5,
    'range_field_of_view': 0.2, 'range_radiation': 'ultrasound', 'range_frame': 'ear',
    'range_topic': 'sonar'}
IMU_SETTINGS = {'imu_frame': 'imu_link', 'imu_topic': 'imu', 'imu_period_s': 0.005,
                'imu_gravity': False}
NOISE = ('<imu><noise><type>gaussian</type><rate><mean>0.0</mean><stddev>2e-4</stddev></rate>'
         '<accel><mean>0.0</mean><stddev>1.7e-2</stddev></accel></noise></imu>')
LASER = '<frameName>base_scan</frameName><topicName>scan</topicName>'
SILENT_IMU = '<sensor type="imu" name="imu"><visualize>false</visualize></sensor>'
FRICTION = '<mu1>0.1</mu1><kp>1e6</kp><kd>100</kd><material>Gazebo/FlatBlack</material>'


def tags(values):
    return ''.join('<{0}>{1}</{0}>'.format(*item) for item in values.items())


def robot(*elements):
    return '<?xml version="1.0"?><robot name="r"><link name="a"/>{}</robot>'.format(
        ''.join(elements))


def gazebo(inside, link=None):
    return '<gazebo{}>{}</gazebo>'.format(
        '' if link is None else ' reference="{}"'.format(link), inside)


def plugin(inside, library, name='p'):
    return '<plugin name="{}" filename="lib{}.so">{}</plugin>'.format(name, library, inside)


def drive(library='gazebo_ros_diff_drive', **changed):
    return gazebo(plugin(tags({**DRIVE_TAGS, **changed}), library, 'wheels'))


def ray(kind='ray', library='gazebo_ros_laser', samples='360', far='3.5', noise='0.01', rate='5',
        laser=LASER, link='base_scan'):
    scan = tags({'samples': samples, 'resolution': '1', 'min_angle': '0.0',
                 'max_angle': '6.28319'})
    sensor = (
        '<sensor type="{}" name="lds"><update_rate>{}</update_rate><ray><scan><horizontal>{}'
        '</horizontal></scan><range><min>0.120</min><max>{}</max><resolution>0.015</resolution>'
        '</range><noise><type>gaussian</type><mean>0.0</mean><stddev>{}</stddev></noise></ray>'
        '{}</sensor>')
    inside = '' if library is None else plugin(laser, library)
    return gazebo(sensor.format(kind, rate, scan, far, noise, inside), link)


def imu(noise=NOISE, **changed):
    values = {'alwaysOn': 'true', 'bodyName': 'imu_link', 'topicName': 'imu',
              'gaussianNoise': '0.0', 'updateRate': '200'}
    return gazebo(plugin(tags({**values, **changed}) + noise, 'gazebo_ros_imu', 'inertia'))


def axis_noise(group, axis, kind='gaussian', **values):
    return '<{0}><{1}><noise type="{2}">{3}</noise></{1}></{0}>'.format(
        group, axis, kind, tags(values))


def imu_sensor(inside, noise='', rate='100'):
    sensor = '<sensor type="imu" name="imu"><update_rate>{}</update_rate>{}{}</sensor>'
    return gazebo(sensor.format(rate, noise, plugin(inside, 'gazebo_ros_imu_sensor')), 'imu_link')


def found(urdf, step_s=0.001):
    return parsed.tags(urdf, step_s, DIFF_DRIVE.tags)


def overrides(urdf, step_s=0.001):
    return found(urdf, step_s).values


def not_simulated(urdf):
    return found(urdf).not_simulated


@pytest.mark.parametrize('rate, step_s, period_s', [
    ('30', 0.001, 0.033), ('30', 0.004, 0.032), ('60', 0.001, 0.017), ('50', 0.001, 0.02),
    ('5000', 0.001, 0.001), ('1', 0.001, 1.0)])
def test_period_is_the_nearest_that_divides_and_at_least_a_step(rate, step_s, period_s):
    values = overrides(robot(drive(updateRate=rate)), step_s)
    assert values['odometry_period_s'] == pytest.approx(period_s)
    assert values['joint_states_period_s'] == values['odometry_period_s']


def test_missing_tags_are_missing_settings():
    assert overrides(robot()) == {}
    assert overrides(robot(gazebo(FRICTION, 'a'), gazebo('<static>true</static>'))) == {}
    assert overrides(robot(gazebo(SILENT_IMU, 'imu_link'))) == {}
    assert overrides(robot(gazebo(plugin('', 'gazebo_ros_diff_drive')))) == {
        'left_joint': 'left_joint', 'right_joint': 'right_joint'}     # of the plugin
    assert not_simulated(robot(gazebo(FRICTION, 'a'), gazebo(SILENT_IMU, 'a'))) == []


def test_our_own_burger():
    urdf = burger()
    wanted = {**DRIVE_SETTINGS, 'drive_period_s': 0.01, **SCAN_SETTINGS, **IMU_SETTINGS,
              'imu_gravity': True, 'gyro_noise': 2e-4, 'accel_noise': 1.7e-2}
    values = overrides(urdf)
    assert values == wanted and not_simulated(urdf) == []
    assert {name: type(value) for name, value in values.items()} == {
        name: type(value) for name, value in wanted.items()}


@pytest.mark.parametrize('rate', ['0', '-0.5', '-7'])
def test_rates_of_zero_or_less_are_each_step(rate):
    values = overrides(robot(drive(updateRate=rate), ray(rate=rate), imu(updateRate=rate)), 0.004)
    assert {name: value for name, value in values.items() if name.endswith('_period_s')} == {
        'odometry_period_s': 0.004, 'drive_period_s': 0.004, 'joint_states_period_s': 0.004,
        'imu_period_s': 0.004, 'scan_period_s': 0.004}


@pytest.mark.parametrize('elements, wanted', [
    *((drive(odometrySource=text), {'odometry_source': 'world'})
      for text in ('world', 'WORLD', '1')),
    *((drive(odometrySource=text), {'odometry_source': 'encoder'})
      for text in ('encoder', 'ENCODER', '0')),
    *((drive(publishOdomTF=text), {'publish_odom_tf': True}) for text in ('true', 'True', '1')),
    *((drive(publishOdomTF=text), {'publish_odom_tf': False}) for text in ('false', 'False', '0')),
    # the torque of the old plugin counts where the new name is missing
    (drive(torque='7'), {'wheel_torque': 10.0}),
    # names lose spaces and leading slashes
    (drive(odometryFrame=' /odom\n', commandTopic='/r1/cmd_vel'),
     {'odom_frame': 'odom', 'command_topic': 'r1/cmd_vel'}),
    # the frame of a sensor is its link where the plugin names none
    (ray(laser='', link='laser'), {'scan_frame': 'laser'}),
    # one without a plugin is none
    (ray(library=None, link='laser') + ray(), {'scan_frame': 'base_scan'}),
    (ray(library=None, link='laser'), {'scan_frame': None}),
    # topics are in the namespace of the plugin, unless they have a leading slash
    (ray(laser='<robotNamespace>/r1/</robotNamespace><topicName>scan</topicName>'),
     {'scan_topic': 'r1/scan'}),
    (ray(laser='<robotNamespace>r1</robotNamespace><topicName>/scan</topicName>'),
     {'scan_topic': 'scan'}),
    (drive(robotNamespace='r1', odometryTopic='odom'),
     {'odometry_topic': 'r1/odom', 'command_topic': 'r1/cmd_vel', 'odom_frame': 'odom'}),
    (ray(laser='', link=None), {'scan_frame': None}),
    (ray(link='laser'), {'scan_frame': 'base_scan'}),
    (imu_sensor(''), {'imu_frame': 'imu_link'}), (imu(frameName='imu'), {'imu_frame': 'imu'}),
    # the plugin does not look at <imu>
    (imu('', gaussianNoise='0.3'), {'gyro_noise': 0.3, 'accel_noise': 0.3}),
    (imu(gaussianNoise='0.3'), {'gyro_noise': 0.3, 'accel_noise': 0.3, 'imu_noises': None}),
    (imu(''), {'gyro_noise': None, 'accel_noise': None}),
    # a noise of zero that is given is a setting
    (ray(noise='0'), {'scan_noise': 0.0, 'scan_noises': None}),
    (ray().replace('gaussian', 'none').replace('<mean>0.0', '<mean>1'),
     {'scan_noise': 0.0, 'scan_noises': None}),
    (ray().replace('<mean>0.0', '<mean>0.5'), {'scan_noise': 0.01, 'scan_noises': (Noise(0.5),)}),
    # each plugin has its own defaults
    (gazebo(plugin('<bodyName>b</bodyName>', 'gazebo_ros_imu')),
     {'imu_topic': 'default_imu', 'imu_period_s': 0.001, 'imu_gravity': False, 'imu_frame': 'b'}),
    (imu_sensor('', rate='0'), {'imu_topic': 'imu', 'imu_period_s': 0.001, 'imu_gravity': True}),
    (imu_sensor('').replace('<update_rate>100</update_rate>', ''), {'imu_period_s': 1.0}),
    (imu_sensor('<updateRateHZ>50</updateRateHZ>'), {'imu_period_s': 0.02}),
    (ray(library='gazebo_ros_range', laser=''), {'range_radiation': None}),
    (ray(library='hector_gazebo_ros_sonar', laser='<frameId>f</frameId>'),
     {'range_radiation': 'ultrasound', 'range_frame': 'f', 'range_topic': 'sonar',
      'range_field_of_view': 0.0}),
    # of a whole number the digits at the beginning count: Gazebo 11 casts as many rays
    *((ray(samples=text), {'scan_samples': rays}) for text, rays in (
        ('360.5', 360), ('360.0', 360), (' 360 ', 360), ('0x168', 360), ('12 rays', 12),
        ('3.6e2', 3)))])
def test_values(elements, wanted):
    values = overrides(robot(elements))
    assert {name: values.get(name) for name in wanted} == wanted


@pytest.mark.parametrize('elements, wanted', [
    (gazebo(plugin('<torque>7</torque>', 'gazebo_ros_diff_drive')), {
        'wheel_torque': 7.0, 'left_joint': 'left_joint', 'right_joint': 'right_joint'}),
    (ray('gpu_ray', 'gazebo_ros_gpu_laser'), SCAN_SETTINGS),
    (ray(library='gazebo_ros_range', laser=tags(RANGE_TAGS)), RANGE_SETTINGS),
    (gazebo(plugin(
        '<bodyName>b</bodyName><frameId>f</frameId><topicName>t</topicName><updateRate>50'
        '</updateRate><accelGaussianNoise>3 4 0</accelGaussianNoise><rateGaussianNoise>0.1'
        '</rateGaussianNoise>', 'hector_gazebo_ros_imu')),
     {'imu_frame': 'f', 'imu_topic': 't', 'imu_period_s': 0.02, 'imu_gravity': True,
      'gyro_noise': 0.1, 'accel_noise': pytest.approx((25 / 3) ** 0.5)}),
    # the form for all axes is not read since SDF 1.6, which a URDF is
    (imu_sensor('<topicName>imu</topicName>', NOISE),
     {**IMU_SETTINGS, 'imu_gravity': True, 'imu_period_s': 0.01}),
    (imu_sensor('<frameName>imu_link</frameName>', '<imu>' + axis_noise(
        'linear_acceleration', 'y', mean='1', stddev='2', bias_mean='3', bias_stddev='4',
        precision='5') + axis_noise('angular_velocity', 'z', 'gaussian_quantized', precision='5')
        + '</imu>'), {**IMU_SETTINGS, 'imu_gravity': True, 'imu_period_s': 0.01, 'imu_noises': (
            Noise(), Noise(), Noise(precision=5), Noise(), Noise(1, 2, 3, 4), Noise())})])
def test_these_values_alone(elements, wanted):
    assert overrides(robot(elements)) == wanted


def test_of_two_drives_the_first_counts_and_all_sensors_are_simulated():
    urdf = robot(drive(), drive(wheelSeparation='9'), ray(), ray('gpu_ray', samples='9'),
                 imu(), imu_sensor('<updateRateHZ>9</updateRateHZ><topicName>b</topicName>'),
                 ray(library='gazebo_ros_range', laser='<topicName>sonar</topicName>'))
    values = overrides(urdf)
    assert {name: value for name, value in values.items() if not name.startswith('range_')} == {
        **DRIVE_SETTINGS, **SCAN_SETTINGS, **IMU_SETTINGS}
    assert values['range_topic'] == 'sonar'
    assert [(each.values.get('scan_samples'), each.values.get('imu_topic'),
             each.values.get('range_topic')) for each in found(urdf).sensors] == [
        (360, None, None), (9, None, None), (None, 'imu', None), (None, 'b', None),
        (None, None, 'sonar')]
    assert not_simulated(urdf) == ['second plugin libgazebo_ros_diff_drive.so']


def test_place_of_a_sensor_is_its_link_and_pose_and_of_a_plugin_its_body():
    posed = ray(laser='<frameName>nowhere</frameName>').replace(
        '<update_rate>', '<pose>1 2 3 0 0 0</pose><update_rate>')
    scanner, unit, middle = found(robot(posed, imu(bodyName='b', frameName='f'), ray())).sensors
    assert (scanner.place.link, scanner.values['scan_frame']) == ('base_scan', 'nowhere')
    assert scanner.place.pose.translation.tolist() == [1, 2, 3]
    assert (unit.place.link, unit.values['imu_frame']) == ('b', 'f')
    assert np.array_equal(middle.place.pose.matrix(), np.eye(4))


@pytest.mark.parametrize('kind', SENSORS, ids=lambda kind: kind.name)
def test_tags_and_defaults_of_plugins_are_of_settings_that_there_are(kind):
    named = {row.setting for row in kind.tags.rows if not row.reader.of_element}.union(
        [kind.tags.frame] * bool(kind.tags.frame), *kind.tags.defaults.values())
    assert named <= {field.name for field in setting_fields(kind.settings)}


def test_what_the_plugin_of_kobuki_measures_is_listed():
    kobuki = next(row.tags for row in PLUGINS if 'gazebo_ros_kobuki' in row.tags.plugins)
    assert parsed.tags(robot(gazebo(plugin('', 'gazebo_ros_kobuki'))), drive=kobuki
                       ).not_simulated == [
        'bumpers, cliff sensors and inertial unit of plugin libgazebo_ros_kobuki.so']


@pytest.mark.parametrize('rate, period_s', [('<updateRate>50</updateRate>', 0.02), ('', 0.01)])
def test_joint_state_publisher_counts_more_than_a_drive(rate, period_s):
    publisher = gazebo(plugin('<jointName>b, a</jointName>' + rate,
                              'gazebo_ros_joint_state_publisher'))
    wanted = {'joint_states_period_s': period_s, 'joint_states_joints': 'b, a'}
    assert overrides(robot(publisher)) == wanted
    assert not_simulated(robot(publisher)) == []
    for elements in ((publisher, drive()), (drive(), publisher)):
        assert overrides(robot(*elements)) == {**DRIVE_SETTINGS, **wanted}


def test_periods_of_defaults_are_whole_steps():
    publisher = gazebo(plugin('', 'gazebo_ros_joint_state_publisher'))
    assert overrides(robot(publisher), 0.004) == {'joint_states_period_s': 0.008}


def test_what_is_not_simulated_is_listed_in_order():
    camera = '<sensor type="camera" name="c">{}</sensor>'.format(
        plugin('', 'gazebo_ros_camera'))
    urdf = robot(gazebo(camera, 'a'), gazebo(plugin('', 'gazebo_ros_p3d') + '<plugin/>'),
                 gazebo('<sensor type="magnetometer" name="b"/>', 'a'), ray())
    assert not_simulated(urdf) == [
        'plugin libgazebo_ros_p3d.so',
        'plugin without filename', 'sensor magnetometer']
    assert overrides(urdf) == SCAN_SETTINGS


def test_a_laser_plugin_must_be_in_a_sensor_and_other_plugins_and_rows_are_listed():
    stray = gazebo(plugin(LASER, 'gazebo_ros_laser'))
    cloud = ray(library='gazebo_ros_block_laser')
    rows = ray().replace('</horizontal>', '</horizontal><vertical><samples>3</samples></vertical>')
    assert not_simulated(robot(stray, cloud, rows)) == [
        'plugin libgazebo_ros_laser.so', 'sensor ray', 'plugin libgazebo_ros_block_laser.so',
        'rows of rays of sensor lds above and below the middle one']


@pytest.mark.parametrize('elements, wanted', [
    (drive(updateRate='often'), "<updateRate> of plugin wheels: got 'often', expected a finite n"),
    *((drive(wheelSeparation=text), '<wheelSeparation> of plugin wheels: got {!r}, expected a '
       'finite number'.format(text))
      for text in ('x', '', 'nan', 'inf', '1e999', '${separation}')),
    (drive(publishOdomTF='yes'), "<publishOdomTF> of plugin wheels: got 'yes', expected true"),
    (drive(odometrySource='gps'),
     "<odometrySource> of plugin wheels: got 'gps', expected world or"),
    (drive(commandTopic=' '), "<commandTopic> of plugin wheels: got '', expected a name"),
    (drive(odometryFrame='/'), "<odometryFrame> of plugin wheels: got '/', expected a name"),
    (ray(samples='many'),
     "<ray/scan/horizontal/samples> of sensor lds: got 'many', expected a who"),
    (ray(far='far'), "<ray/range/max> of sensor lds: got 'far', expected a finite number"),
    (imu_sensor('', '<imu>{}</imu>'.format(axis_noise('angular_velocity', 'x', stddev='a\nb'))),
     "<stddev> of angular_velocity/x/noise of imu of sensor imu: got 'a\\nb', expected 1 finite"),
    (imu('', gaussianNoise='low'),
     "<gaussianNoise> of plugin inertia: got 'low', expected a finite"),
    (gazebo('<plugin filename="libgazebo_ros_imu.so"><updateRate>x</updateRate></plugin>'),
     "<updateRate> of plugin without name: got 'x'")])
def test_refusals_name_the_element_its_owner_and_what_is_expected(elements, wanted):
    assert refusal(overrides, robot(elements)).startswith(wanted)
