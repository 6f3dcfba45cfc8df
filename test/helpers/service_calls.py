"""Service calls as of rosservice, by one process: each rosservice takes half a second to start."""
import json
import re
import subprocess
import sys

import yaml

from img_recog_helpers.waiting import wait_for

_CALLER = '''
import json, sys
import rosservice
for line in sys.stdin:
    name, request = json.loads(line)
    try:
        text = str(rosservice.call_service(name, [request])[1])
    except rosservice.ROSServiceException as error:
        text = 'ERROR: ' + str(error)
    print(json.dumps(text), flush=True)
'''
# rosservice, before it calls a service: the node has not advertised it yet
_MISSING = r'ERROR: (Service \[.*\] is not available|Unable to (communicate|determine type))'


class ServiceCalls:
    """Calls services in the environment of a Ros."""

    def __init__(self, ros):
        self._process = ros.start(sys.executable, '-c', _CALLER, stdin=subprocess.PIPE)
        self._answers = 0

    def call(self, service, request):
        """Return the response as plain values; request: its fields, or the first ones.

        Waits until the service is there.
        """
        def response():
            text = self._call(service, request)
            return None if re.match(_MISSING, text) else [text]
        return yaml.safe_load(wait_for(response, 'the service ' + service)[0])

    def _call(self, service, request):
        """Return the response as text; that of an error begins with ERROR."""
        stdin = self._process.stdin
        stdin.write((json.dumps([service, request]) + '\n').encode())
        stdin.flush()
        self._answers += 1

        def answers():
            return [line for line in self._process.output.split('\n')[:-1]
                    if line.startswith('"')]
        wait_for(lambda: len(answers()) >= self._answers, lambda: self._process.output)
        return json.loads(answers()[self._answers - 1])

    def close(self):
        """End the process."""
        self._process.stdin.close()
        assert self._process.wait() == 0, self._process.output
