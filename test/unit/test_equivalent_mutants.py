"""The list of mutants that change nothing: each is still possible and has a reason."""
import os

import yaml
from img_recog_testing.pages import ROOT, read

ENTRIES = yaml.safe_load(read('test/equivalent_mutants.yaml'))


def test_each_line_is_in_its_file_and_has_a_reason():
    for entry in ENTRIES:
        assert set(entry) == {'file', 'line', 'becomes', 'reason'}, entry
        source = read(os.path.join(ROOT, 'src', 'img_recog', entry['file']))
        lines = ' '.join(line.strip() for line in source.splitlines())
        assert entry['line'] in lines, entry
        assert entry['becomes'] and entry['line'] not in entry['becomes'], entry
        assert len(entry['reason'].split()) >= 4, entry


def test_no_entry_is_twice():
    keys = [(entry['file'], entry['line'], change) for entry in ENTRIES
            for change in entry['becomes']]
    assert len(keys) == len(set(keys))
