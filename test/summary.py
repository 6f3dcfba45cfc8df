#!/usr/bin/env python3
"""Print what failed and the totals of a folder of JUnit results; exit 1 if anything did."""
import pathlib
import sys
import xml.etree.ElementTree as ElementTree


def main(folder):
    """Read every result file below `folder`."""
    passed = failed = skipped = 0
    for path in sorted(pathlib.Path(folder).rglob('*.xml')):
        try:
            root = ElementTree.parse(path).getroot()
        except ElementTree.ParseError:      # its process ended while it wrote the file
            failed += 1
            sys.stdout.write('FAILED {}: no complete results\n'.format(path.name))
            continue
        for case in root.iter('testcase'):
            if case.find('failure') is not None or case.find('error') is not None:
                failed += 1
                sys.stdout.write('FAILED {}: {}\n'.format(path.name, case.get('name')))
            elif case.find('skipped') is not None:
                skipped += 1
            else:
                passed += 1
    sys.stdout.write('{} passed, {} failed, {} skipped\n'.format(passed, failed, skipped))
    return 1 if failed or not passed else 0


if __name__ == '__main__':
    sys.exit(main(sys.argv[1]))
