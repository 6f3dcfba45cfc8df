"""What the programs with hostile messages share: hypothesis without a database, with a seed."""
import contextlib
import os
import random
import tempfile
import warnings
from typing import Callable, Iterator

import hypothesis
from hypothesis import strategies

# more messages than examples: drawing an example takes longer than handling a message
PER_EXAMPLE = 100
_INTERESTING = (b'\x00\x00\x00\x00', b'\xff\xff\xff\xff', b'\xff\xff\xff\x7f', b'\x00\x00\x00\x80',
                b'\x00\x00\xf8\x7f', b'\x00\x00\xf0\x7f', b'\x01\x00\x00\x00', b'%n%s')


def explore(count: int, seed: int, strategy, check: Callable) -> None:
    """Call check(drawn, rng) for `count` values drawn from a strategy, and fail with a small one.

    rng: a random generator, drawn too, for everything that hypothesis does not need to shrink.
    """
    @hypothesis.seed(seed)
    @hypothesis.settings(max_examples=count, database=None, deadline=None,
                         suppress_health_check=list(hypothesis.HealthCheck.all())
                         if hypothesis.__version_info__ < (6,) else list(hypothesis.HealthCheck))
    @hypothesis.given(strategy, strategies.integers(0, 2 ** 32 - 1))
    def run(drawn, number):
        check(drawn, random.Random(number))
    run()


def damaged(data: bytes, rng: random.Random) -> bytes:
    """Return bytes with some of them changed, removed, repeated or inserted."""
    changed = bytearray(data)
    for _ in range(rng.randint(1, 4)):
        place = rng.randrange(len(changed) + 1)
        kind = rng.randrange(5)
        if kind == 0 and place < len(changed):
            changed[place] ^= 1 << rng.randrange(8)
        elif kind == 1:
            changed[place:place + 4] = rng.choice(_INTERESTING)
        elif kind == 2:
            del changed[place:place + rng.randint(1, 16)]
        elif kind == 3:
            changed[place:place] = bytes(rng.randrange(256) for _ in range(rng.randint(1, 16)))
        else:
            changed[place:place] = changed[place:place + rng.randint(1, 16)]
    return bytes(changed)


@contextlib.contextmanager
def quiet_libraries() -> Iterator[None]:
    """Discard what libraries print about damaged images."""
    with tempfile.TemporaryFile() as sink, warnings.catch_warnings():
        warnings.simplefilter('ignore')
        saved = os.dup(2)
        os.dup2(sink.fileno(), 2)
        try:
            yield
        finally:
            os.dup2(saved, 2)
            os.close(saved)
