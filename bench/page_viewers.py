"""Look at the page at ADDRESS in N connections until stdin ends; print the rate of a viewer."""
import asyncio
import json
import sys
import time

from websockets.asyncio.client import connect


async def view(origin: str, cookie: str, topics: list, counts: list, number: int) -> None:
    """Ask for all pictures as fast as the page sends them."""
    async with connect(origin.replace('http', 'ws') + '/live', origin=origin, max_size=None,
                       compression=None, additional_headers={'Cookie': cookie}) as socket:
        await socket.send(json.dumps({'look': topics}))
        while True:
            await socket.send('{"ready": 1}')
            data = await socket.recv()
            counts[number] += topics[0].encode() in data


async def main() -> None:
    """Look until stdin ends."""
    address, viewers, topics = sys.argv[1], int(sys.argv[2]), sys.argv[3:]
    origin, _, token = address.partition('/?token=')
    cookie = 'img_recog_{}={}'.format(origin.rpartition(':')[2], token)
    counts = [0] * viewers
    tasks = [asyncio.ensure_future(view(origin, cookie, topics, counts, number))
             for number in range(viewers)]
    sys.stdout.write('connected\n')
    sys.stdout.flush()
    first, begin_s = None, 0.0
    loop = asyncio.get_running_loop()
    end = loop.run_in_executor(None, sys.stdin.read)
    while not end.done():
        await asyncio.sleep(0.05)
        if first is None and counts and min(counts) > 0:
            first, begin_s, last = list(counts), time.perf_counter(), (counts[:], 0.0)
        elif first is not None and counts != last[0]:
            last = counts[:], time.perf_counter()
    for task in tasks:
        task.cancel()
    rate_hz = 0.0
    if first is not None and last[1] > begin_s:
        rate_hz = (sum(last[0]) - sum(first)) / len(counts) / (last[1] - begin_s)
    sys.stdout.write('{}\n'.format(rate_hz))


if __name__ == '__main__':
    asyncio.run(main())
