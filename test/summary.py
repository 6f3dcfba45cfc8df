#!/usr/bin/env python3
"""Print what failed and the totals of a folder of JUnit results; exit 1 if anything did."""
import pathlib
import sys
import xml.etree.ElementTree as ElementTree

_WITH_PROCESSES = ('pytest-system-', 'rostest-')


def main(folder, *options):
    """Read every result file below `folder`.

    --targets: print only the names of the targets of make, for each system test and rostest that
    has failed, after the name of the package.
    """
    passed = failed = skipped = 0
    for path in sorted(pathlib.Path(folder).rglob('*.xml')):
        cases = list(_cases(path))
        bad = [name for name, result in cases if result == 'failed']
        if '--targets' in options:
            if bad and path.name.startswith(_WITH_PROCESSES):
                kind, _, name = path.stem.partition('-')
                sys.stdout.write('{}_{}{}\n'.format(kind, name.replace('-', '_'),
                                                    '.test' if kind == 'rostest' else ''))
            continue
        for name in bad:
            sys.stdout.write('FAILED {}: {}\n'.format(path.name, name))
        failed += len(bad)
        skipped += sum(result == 'skipped' for _, result in cases)
        passed += sum(result == 'passed' for _, result in cases)
    if '--targets' in options:
        return 0
    sys.stdout.write('{} passed, {} failed, {} skipped\n'.format(passed, failed, skipped))
    return 1 if failed or not passed else 0


def _cases(path):
    """Yield the name and the result of each test."""
    try:
        root = ElementTree.parse(path).getroot()
    except ElementTree.ParseError:      # its process ended while it wrote the file
        yield 'no complete results', 'failed'
        return
    for case in root.iter('testcase'):
        if case.find('failure') is not None or case.find('error') is not None:
            yield case.get('name'), 'failed'
        elif case.find('skipped') is not None:
            yield case.get('name'), 'skipped'
        else:
            yield case.get('name'), 'passed'


if __name__ == '__main__':
    sys.exit(main(*sys.argv[1:]))
