"""Items made in a thread, ahead of whoever uses them."""
from collections import deque
from concurrent.futures import ThreadPoolExecutor
from typing import Iterable, Iterator, TypeVar

_END = object()
Item = TypeVar('Item')


def ahead(items: Iterable[Item], depth: int) -> Iterator[Item]:
    """Yield the same items in the same order, up to `depth` of them made ahead in one thread.

    What the making of an item raises is raised in its place.
    """
    iterator = iter(items)
    with ThreadPoolExecutor(1) as pool:
        making = deque(pool.submit(next, iterator, _END)
                       for _ in range(depth))
        while True:
            item = making.popleft().result()
            if item is _END:
                return
            making.append(pool.submit(next, iterator, _END))
            yield item
