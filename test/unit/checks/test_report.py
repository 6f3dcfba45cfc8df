"""The table: columns of equal width, unless a cell is long."""
from img_recog.checks.check_report import CheckReport, CheckRow

LONG = 'x' * 61


def test_columns_title_and_warnings():
    rows = [CheckRow('simulated', 'mass', '1 kg', 'here'), CheckRow('not drawn', LONG, 'no\nfile')]
    assert CheckReport('robot r2', rows, ['a', 'b']).text().splitlines() == [
        'robot r2', '',
        'state      what  value     from',
        'simulated  mass  1 kg      here',
        'not drawn  {}  no\\nfile'.format(LONG),
        'warning: a', 'warning: b']
