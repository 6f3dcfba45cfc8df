"""Physics clients."""
import pybullet
import pytest

from img_recog.simulation.bodies import loading
from img_recog.simulation.settings import SimulationError


@pytest.fixture(params=[-1, 0, 7])
def number(request, monkeypatch):
    """The number of the client that PyBullet gives; a negative one means that it has none."""
    monkeypatch.setattr(pybullet, 'connect', lambda mode: request.param)
    monkeypatch.setattr(pybullet, 'setPhysicsEngineParameter', lambda **values: None)
    return request.param


def test_first_client_has_the_number_0_and_a_negative_one_is_an_error(number):
    if number >= 0:
        assert loading.connect() == number
    else:
        with pytest.raises(SimulationError, match='cannot start a physics client'):
            loading.connect()


@pytest.mark.parametrize('padding', range(0, 40, 4))
def test_a_long_line_is_not_broken(padding):
    # the position of a visual stands at or near byte 8192
    begin = ('<robot name="r"><link name="l"><inertial><mass value="1"/><inertia ixx="1" ixy="0" '
             'ixz="0" iyy="1" iyz="0" izz="1"/></inertial>')
    shape = '<geometry><sphere radius="1"/></geometry>'
    visual = '<visual><origin xyz="1.23456789 2.34567891 3.45678912"/>' + shape + '</visual>'
    empty = '<gazebo/>'
    begin += empty * ((8192 - 30 - padding - len(begin)) // len(empty))
    client = loading.connect()
    body = loading.load_urdf(begin + visual + '</link></robot>', client, visuals=True)
    data, = pybullet.getVisualShapeData(body, physicsClientId=client)
    assert data[5] == pytest.approx((1.23456789, 2.34567891, 3.45678912))


NAMED = ('<robot name="{robot}"><link name="{link}"/><link name="b"/><joint name="{joint}" '
         'type="fixed"><parent link="{link}"/><child link="b"/></joint></robot>')


@pytest.mark.parametrize('key, kind', [
    ('robot', 'robot or model'), ('link', 'link'), ('joint', 'joint')])
def test_names_that_would_crash_pybullet(key, kind):
    longest = {'robot': 'r', 'link': 'a', 'joint': 'j', key: '\u00e4' * 250}
    client = loading.connect()
    body = loading.load_urdf(NAMED.format(**longest), client, fixed=True)
    assert pybullet.getNumJoints(body, physicsClientId=client) == 1
    longest[key] += 'x'
    with pytest.raises(SimulationError) as error:
        loading.load_urdf(NAMED.format(**longest), client, fixed=True)
    assert str(error.value) == ('the name of a {} that begins with {} has 501 bytes, allowed are '
                                '500; give a shorter name'.format(kind, '\u00e4' * 40))


def test_visual_meshes_that_would_crash_pybullet_are_not_seen(tmp_path):
    (tmp_path / 'a.dae').write_text('<COLLADA/>')
    shape = '<visual><geometry>{}</geometry></visual>'
    mesh = shape.format('<mesh filename="{}"/>'.format(tmp_path / 'a.dae'))
    text = ('<robot name="r"><link name="a">{}{}</link><link name="b">{}</link><joint name="j" '
            'type="fixed"><parent link="a"/><child link="b"/></joint></robot>'.format(
                mesh, shape.format('<box size="1 2 3"/>'), mesh))
    client = loading.connect()
    body = loading.load_urdf(text, client, fixed=True, visuals=True)
    seen = [data[1:4] for data in pybullet.getVisualShapeData(body, physicsClientId=client)]
    assert seen == [(-1, pybullet.GEOM_BOX, (1, 2, 3)), (0, pybullet.GEOM_BOX, (0, 0, 0))]
