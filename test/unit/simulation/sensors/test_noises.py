"""The <noise> of sensors of an SDF: the figures are those of Gazebo 11.1."""
import numpy as np
import pytest

from img_recog.conversions.sensor_table import SENSORS
from img_recog.formats import world_file
from img_recog.formats.noises import Noise
from img_recog.report import lines_of
from img_recog.simulation import assembly
from img_recog.simulation.simulation_settings import PhysicsSettings
from img_recog_helpers.sdf import BOX, sdf

WALL = '<link name="wall"><pose>2 0 0 0 0 0</pose>' + BOX.format('collision', '', '1 9 9')
MODEL = ('<model name="m"><static>1</static><pose>0 0 9 0 0 0</pose>' + WALL + '</link><link '
         'name="l"><sensor name="s" type="{}"><update_rate>100</update_rate>{}</sensor></link>'
         '</model>')
RAY = '<ray><range><min>0.1</min><max>5</max></range><noise{}</noise></ray>'
AXIS = '<imu><{0}><{1}><noise type="{2}">{3}</noise></{1}></{0}></imu>'
GYRO, ACCELERATION = 'angular_velocity', 'linear_acceleration'
OLD = ('<imu><noise><type>gaussian</type><rate><mean>0.5</mean></rate><accel><bias_mean>2'
       '</bias_mean></accel></noise></imu>')


def readings(kind, inside, version='1.6', count=1):
    file = world_file.read('world.sdf', {}, read_file=lambda path: sdf(
        MODEL.format(kind, inside), version=version))
    sim = assembly.build(PhysicsSettings(), file, [], kinds=SENSORS, with_bare=True)
    sim.advance(10)
    found = [each.value for each in sim.advance(10 * count)]
    assert len(found) >= count
    return found, lines_of(file.findings)


@pytest.mark.parametrize('noise, wanted', [
    ('><mean>0.25</mean>', 1.75), (' type="gaussian"><mean>0.25</mean>', 1.75),
    ('><type>none</type><mean>0.25</mean><stddev>1</stddev>', 1.5),
    ('><bias_mean>0.5</bias_mean>', (1.0, 2.0)),
    ('><type>gaussian_quantized</type><precision>0.4</precision>', 1.6),
    ('><type>gaussian</type><precision>0.4</precision>', 1.5)])
def test_of_a_scanner(noise, wanted):
    (ranges, *_), _ = readings('ray', RAY.format(noise))
    assert any(ranges[0] == pytest.approx(value) for value in np.atleast_1d(wanted))


@pytest.mark.parametrize('version, inside, gyro, acceleration', [
    ('1.6', AXIS.format(GYRO, 'x', 'gaussian', '<mean>0.5</mean>'), (0.5, 0, 0), (0, 0, 9.8)),
    ('1.4', AXIS.format(ACCELERATION, 'z', 'gaussian', '<mean>1</mean>'), (0, 0, 0), (0, 0, 10.8)),
    ('1.7', AXIS.format(GYRO, 'y', 'none', '<mean>1</mean>'), (0, 0, 0), (0, 0, 9.8)),
    ('1.6', AXIS.format(GYRO, 'z', 'gaussian_quantized', '<mean>1.3</mean><precision>0.5'
                        '</precision>'), (0, 0, 1.5), (0, 0, 9.8)),
    ('1.6', OLD, (0, 0, 0), (0, 0, 9.8)), ('1.7', OLD, (0, 0, 0), (0, 0, 9.8))])
def test_of_an_inertial_unit(version, inside, gyro, acceleration):
    (value, *_), warnings = readings('imu', inside, version)
    assert (value.angular_velocity, value.linear_acceleration) == (
        pytest.approx(gyro), pytest.approx(acceleration))
    assert bool(warnings) == (inside == OLD)


@pytest.mark.parametrize('version', ['1.4', '1.5'])
def test_until_sdf_1_5_the_older_form_is_that_of_each_axis(version):
    (value, *_), warnings = readings('imu', OLD, version)
    assert value.angular_velocity == pytest.approx((0.5, 0.5, 0.5))
    assert np.abs(np.subtract(value.linear_acceleration, (0, 0, 9.8))) == pytest.approx(2.0)
    assert not warnings


def test_each_axis_has_its_deviation():
    noise = AXIS.format(GYRO, 'y', 'gaussian', '<stddev>0.5</stddev>')
    values, _ = readings('imu', noise, count=500)
    deviations = np.std([value.angular_velocity for value in values], axis=0)
    assert deviations == pytest.approx((0, 0.5, 0), abs=0.05)


def test_a_bias_is_drawn_once_with_a_random_sign():
    random = np.random.RandomState(0)
    offsets = np.array([Noise(1.0, 9.0, 2.0, 0.1).offset(random) for _ in range(500)])
    biases = offsets - 1.0
    assert 200 < np.count_nonzero(biases > 0) < 300
    assert (np.abs(biases).mean(), np.abs(biases).std()) == pytest.approx((2.0, 0.1), abs=0.02)
