"""dynamic_reconfigure: the config type that is made from settings, and changes of settings."""
import dataclasses
import logging
from types import SimpleNamespace

import pytest
from dynamic_reconfigure import server
from dynamic_reconfigure.encoding import (decode_config, decode_description, encode_description,
                                          extract_params)
from dynamic_reconfigure.msg import (BoolParameter, Config, DoubleParameter, GroupState,
                                     IntParameter, StrParameter)
from dynamic_reconfigure.srv import ReconfigureRequest

from img_recog.errors import UserError
from img_recog.ros.reconfigure import Reconfigurable, config_type
from img_recog.settings import (Settings, above, at_least, between, clamped, not_empty,
                                one_of, setting)

INFINITY = float('inf')


@dataclasses.dataclass(frozen=True)
class Sample(Settings):
    """One field of each kind."""

    width: int = setting(640, between(1, 800), 'pixels in a row')
    count: int = setting(0, at_least(0))
    offset: int = setting(-3)
    rate: float = setting(30.0, above(0), 'frames a second')
    gain: float = setting(1.5)
    enabled: bool = setting(True, description='whether at all')
    mode: str = setting('slow', one_of('slow', 'fast'))
    name: str = setting('sample', not_empty())
    unchecked: object = None


@dataclasses.dataclass(frozen=True)
class Clamped(Settings):
    """Numbers as in a server in C++."""

    level: int = setting(9, clamped(1, 9))
    quality: int = setting(80, clamped(1, 100))


EXPECTED = {        # type, default, min, max, description
    'width': ('int', 640, 1, 800, 'pixels in a row'),
    'count': ('int', 0, 0, 2 ** 31 - 1, ''),
    'offset': ('int', -3, -2 ** 31, 2 ** 31 - 1, ''),
    'rate': ('double', 30.0, 0.0, INFINITY, 'frames a second'),
    'gain': ('double', 1.5, -INFINITY, INFINITY, ''),
    'enabled': ('bool', True, False, True, 'whether at all'),
    'mode': ('str', 'slow', '', '', ''),
    'name': ('str', 'sample', '', '', ''),
}


def test_tools_read_the_description():
    made = config_type(Sample)
    params = {each['name']: each
              for each in extract_params(decode_description(encode_description(made)))}
    assert list(params) == list(made.defaults) == list(EXPECTED)
    for name, each in params.items():
        assert (each['type'], each['default'], each['min'], each['max'],
                each['description']) == EXPECTED[name]
        assert (each['edit_method'] != '') == (name == 'mode') and made.level[name] == 0
        assert len({type(of[name]) for of in (made.defaults, made.min, made.max)}) == 1


def test_choices_are_a_list_to_choose_from():
    mode = {each['name']: each for each in config_type(Sample).config_description['parameters']}
    enum = eval(mode['mode']['edit_method'])['enum']        # like the tools
    assert [(each['name'], each['value'], each['type']) for each in enum] == [
        ('slow', 'slow', 'str'), ('fast', 'fast', 'str')]


@pytest.fixture
def errors():
    """The lines that rospy logs at ERROR."""
    lines = []
    handler = logging.Handler(logging.ERROR)
    handler.emit = lambda record: lines.append(record.getMessage())
    logger = logging.getLogger('rosout')
    logger.addHandler(handler)
    yield lines
    logger.removeHandler(handler)


@pytest.fixture
def serve(monkeypatch):
    """A function that serves Sample(width=2); it returns the server, and a function to call it.

    That returns the settings and the reply.
    """
    services = []
    topic = SimpleNamespace(publish=lambda msg: None)
    monkeypatch.setattr(server, 'rospy', SimpleNamespace(
        Publisher=lambda *_, **__: topic, set_param=lambda *_: None,
        Service=lambda *words: services.append(words)))

    def start(on_change=lambda settings: None, settings=Sample(width=2)):
        reconfigurable = Reconfigurable(settings, on_change, '/camera')
        (name, _, handler), = services
        assert name == '/camera/set_parameters'

        def request(config):
            reply = handler(ReconfigureRequest(config))
            assert reply.groups == [GROUP]
            return reconfigurable.settings, decode_config(reply)
        return reconfigurable, request
    return start


def ints(**values):
    return Config(ints=[IntParameter(*each) for each in values.items()])


def test_change_is_passed_to_the_receiver_and_applied(serve, errors):
    seen = []
    reconfigurable, request = serve(seen.append)
    assert reconfigurable.settings == Sample(width=2) and seen == []
    assert request(ints(width=5))[0] == Sample(width=5)
    request(ints(width=5, count=0))
    assert seen == [Sample(width=5)] and errors == []


def test_refused_value_changes_nothing_and_logs_one_line(serve, errors):
    seen = []
    _, request = serve(seen.append)
    assert request(ints(width=801, count=7))[0] == Sample(width=2)
    assert seen == []
    assert errors == ['parameter /camera/width: got 801, allowed is a whole number from 1 to 800; '
                      'nothing is changed']


def test_refusal_by_the_receiver_changes_nothing(serve, errors):
    def refuse(_):
        raise UserError('the camera\nis gone')
    _, request = serve(refuse)
    settings, reply = request(ints(width=5))
    assert settings == Sample(width=2) and reply['width'] == 2
    assert errors == ['parameters of /camera: the camera is gone; nothing is changed']


GROUP = GroupState('Default', True, 0, 0)
MALFORMED = {
    'group as a value': (ints(groups=5),
                         '/camera/groups: got 5, allowed is one of the parameters width'),
    'unknown name': (Config(bools=[BoolParameter('', True)]), 'got True, allowed is one of'),
    'wrong list': (Config(strs=[StrParameter('width', '6')]), "got '6', allowed is a whole"),
    'number for a bool': (ints(enabled=1), 'got 1, allowed is true'),
    'NaN': (Config(doubles=[DoubleParameter('rate', float('nan'))]), 'got nan, allowed is a fin'),
    'infinite': (Config(doubles=[DoubleParameter('gain', -INFINITY)]), 'got -inf, allowed is'),
    'one of several': (ints(count=3, width=0),
                       'width: got 0, allowed is a whole number from 1 to 800'),
}


@pytest.mark.parametrize('config, words', list(MALFORMED.values()), ids=list(MALFORMED))
def test_malformed_request_is_one_line_and_the_next_one_works(serve, errors, config, words):
    _, request = serve()
    settings, reply = request(config)
    assert settings == Sample(width=2) and reply['width'] == 2
    line, = errors
    assert words in line and '/camera' in line
    assert line.endswith(('; nothing is changed', '; it is not changed'))
    settings, reply = request(Config(ints=[IntParameter('width', 5)], groups=[GROUP]))
    assert settings == Sample(width=5) and reply['width'] == 5 and len(errors) == 1
    assert {name: reply[name] for name in EXPECTED} == {
        **{name: expected[1] for name, expected in EXPECTED.items()}, 'width': 5}


def test_a_wrong_name_or_type_does_not_drop_the_values_beside_it(serve, errors):
    settings, reply = serve()[1](Config(
        ints=[IntParameter('width', 5), IntParameter('enabled', 0), IntParameter('rate', 20)],
        strs=[StrParameter('count', '7'), StrParameter('mode', 'fast'), StrParameter('x', 'y')],
        doubles=[DoubleParameter('offset', 2.5)]))
    assert settings == Sample(width=5, rate=20.0, mode='fast') and reply['width'] == 5
    assert [line.split(':')[0] for line in errors] == ['parameter /camera/' + name for name in (
        'enabled', 'count', 'x', 'offset')]
    assert {line.rpartition('; ')[2] for line in errors} == {'it is not changed'}


def test_numbers_of_clamped_settings_become_the_nearest_bound(serve, errors):
    settings, reply = serve(settings=Clamped())[1](ints(level=-5, quality=200))
    assert settings == Clamped(level=1, quality=100) and (reply['level'], reply['quality']) == (
        1, 100)
    assert errors == []


def test_empty_request_and_states_of_groups_change_nothing(serve, errors):
    _, request = serve()
    for config in (Config(), Config(groups=[GROUP]),
                   Config(groups=[GroupState('Default', False, 0, 0)] * 3),
                   Config(groups=[GroupState('x', True, 7, -1)])):
        settings, reply = request(config)
        assert settings == Sample(width=2) and reply['width'] == 2
    assert errors == []
