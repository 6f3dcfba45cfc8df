"""Hostile calls of XML-RPC: whole requests whose content is the attack."""
import gzip
import random
import xmlrpc.client
from typing import Any, Callable, Dict, Iterator

from img_recog_testing.reliability import hostile

# `shutdown` ends a node, as it should
_METHODS = ('getBusStats', 'getBusInfo', 'getMasterUri', 'getPid', 'getSubscriptions',
            'getPublications', 'paramUpdate', 'publisherUpdate', 'requestTopic',
            'system.multicall', 'system.listMethods', '__class__', '_shutdown', '')
_TOPICS = ('/usb_cam/image_raw', '/cmd_vel', '/odom', '/rosout', '/clock', '/joint_states')
_BOMB = (b'<?xml version="1.0"?><!DOCTYPE a [<!ENTITY b0 "xxxxxxxxxx">' + b''.join(
    b'<!ENTITY b%d "%s">' % (level, b'&b%d;' % (level - 1) * 10) for level in range(1, 9))
    + b']><methodCall><methodName>getPid</methodName><params><param><value>&b8;</value></param>'
    b'</params></methodCall>')


def _request(body: bytes, *headers: bytes) -> bytes:
    return b'\r\n'.join((b'POST /RPC2 HTTP/1.1', b'Content-Length: %d' % len(body), *headers, b'',
                         body))


def _with(value: bytes, count: int) -> bytes:
    return (b'<methodCall><methodName>getPid</methodName><params><param><value><array><data>'
            + value * count + b'</data></array></value></param></params></methodCall>')


def _value(rng: random.Random, depth: int = 0) -> Any:
    simple = (0, -1, 2 ** 31 - 1, 1e308, float('nan'), True, '', '/', 'x' * 1000, '\x7f%n',
              rng.choice(_TOPICS), 'TCPROS', 'UDPROS', 'http://127.0.0.1:1/',
              xmlrpc.client.Binary(b'\0' * 100))
    kind = rng.randrange(6)
    if depth > 4 or kind < 4:
        return rng.choice(simple)
    children = [_value(rng, depth + 1) for _ in range(rng.randrange(4))]
    return children if kind == 4 else {str(number): each for number, each in enumerate(children)}


def _call(rng: random.Random) -> bytes:
    arguments = tuple(_value(rng) for _ in range(rng.randrange(5)))
    return xmlrpc.client.dumps(arguments, rng.choice(_METHODS)).encode()


def _calls(rng: random.Random) -> Iterator[bytes]:
    for _ in range(rng.randrange(1, 30)):
        yield _request(_call(rng))


def _damaged(rng: random.Random) -> Iterator[bytes]:
    for _ in range(rng.randrange(1, 30)):
        yield _request(hostile.damaged(_call(rng), rng))


def _publishers(rng: random.Random) -> Iterator[bytes]:
    """Name publishers that do not exist, are no URIs, or do not answer."""
    hosts = ('127.0.0.1:1', '127.0.0.1:9', 'nowhere.invalid:1', '', ':', '[::1]:1', 'x' * 300)
    uris = [rng.choice(('http', 'http', 'https', 'ftp', '')) + '://' + rng.choice(hosts) + '/'
            + str(number) for number in range(rng.choice((1, 3, 100, 2000)))]
    yield _request(xmlrpc.client.dumps(('/master', rng.choice(_TOPICS), uris),
                                       'publisherUpdate').encode())


def _fixed(make: Callable[[], bytes]) -> Callable[[random.Random], Iterator[bytes]]:
    def pieces(rng: random.Random) -> Iterator[bytes]:
        yield make()
    return pieces


CALLS: Dict[str, Callable[[random.Random], Iterator[bytes]]] = {
    'calls': _calls, 'damaged calls': _damaged, 'publishers': _publishers,
    'packed call': _fixed(lambda: _request(
        gzip.compress(_with(b'<value><array><data></data></array></value>', 400000)),
        b'Content-Encoding: gzip')),
    'many values': _fixed(lambda: _request(_with(b'<value><i4>1</i4></value>', 150000))),
    'many structs': _fixed(lambda: _request(_with(b'<value><struct></struct></value>', 100000))),
    'deep call': _fixed(lambda: _request(_with(b'<value><array><data>', 100000))),
    'entities': _fixed(lambda: _request(_BOMB))}
