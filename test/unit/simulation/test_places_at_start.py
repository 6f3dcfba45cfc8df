"""What a robot is told that starts below a terrain, or where nothing is below it."""
import numpy as np
import pytest
from PIL import Image

from img_recog_helpers.robots import assemble
from img_recog_helpers.sdf import BUILT_IN, body, sdf

HILLS = body('hills', '', '<heightmap><uri>hills.png</uri><size>20 20 2</size></heightmap>', True)
SHEET = body('hills', '', '<mesh><uri>sheet.obj</uri></mesh>', True)
FALLS = ('turtlebot3_burger: it falls, as nothing is below it: the world has no ground_plane or '
         'other floor there')


@pytest.mark.parametrize('models, z, lines', [
    ([], 0.0, [FALLS]), ([BUILT_IN], 0.0, []), ([BUILT_IN], 3.0, []),
    ([HILLS], 0.5, ['turtlebot3_burger: it starts below hills::l::c, which is at 2.000 m there; '
                    'set z_pos']),
    ([BUILT_IN, HILLS], 0.5, ['turtlebot3_burger: it starts below hills::l::c, which is at 2.000 m'
                              ' there; set z_pos']),
    ([HILLS], 2.5, []), ([SHEET], 0.5, []), ([BUILT_IN, SHEET], 0.0, []),
    ([SHEET], 0.0, ['turtlebot3_burger: it starts below hills, which is at 0.400 m there; set '
                    'z_pos'])])
def test_a_robot_without_a_floor_below_it(tmp_path, models, z, lines):
    Image.fromarray(np.full((5, 5), 200, np.uint8)).save(str(tmp_path / 'hills.png'))
    (tmp_path / 'sheet.obj').write_text('v -5 -5 0.4\nv 5 -5 0.4\nv 5 5 0.4\nv -5 5 0.4\n'
                                        'f 1 2 3 4\n')
    path = tmp_path / 'hall.world'
    path.write_text(sdf(*models))
    found = assemble(str(path), z=z).world.report.lines()
    assert [line for line in found if 'burger: it' in line] == lines
