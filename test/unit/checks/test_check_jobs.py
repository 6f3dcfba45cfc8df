"""What the command line of simulate.py takes."""
import pytest

from img_recog.checks.check_jobs import simulate_parser


def test_names_and_numbers():
    given = simulate_parser().parse_args([
        'empty', '--twist=-1,0.5', '--drive', 'a=b::j=1:2', '--velocity', 'm=1,2,3',
        '--velocity', 'n=1,2,3,4,5,6'])
    assert given.twist == [-1, 0.5] and given.drive == [('a=b::j', [1, 2])]
    assert given.velocity == [('m', [1, 2, 3]), ('n', [1, 2, 3, 4, 5, 6])]


@pytest.mark.parametrize('option, value', [
    ('--drive', 'door::hinge=1'), ('--drive', '1:2:3'), ('--velocity', 'm=1,2'),
    ('--velocity', 'm=1,2,nan'), ('--twist', '1'), ('--twist', 'a=1,2'), ('--until', '0')])
def test_values_that_are_refused(capsys, option, value):
    with pytest.raises(SystemExit):
        simulate_parser().parse_args(['empty', option, value])
    assert 'argument {}: got {!r}, expected '.format(option, value) in capsys.readouterr().err
