"""Worlds seen from above."""
import math

import numpy as np
import pytest

from img_recog.simulation.pictures.footprints import footprints
from img_recog_helpers import robots

SHAPES = '''<robot name="shapes">
  <link name="world"><inertial><mass value="0"/>
    <inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial>
    <collision><origin xyz="1 2 0.5" rpy="{} 0 {}"/><geometry><box size="2 1 1"/></geometry>
    </collision>
    <collision><origin xyz="-1 0 0.5"/><geometry><cylinder radius="0.5" length="1"/></geometry>
    </collision>
    <collision><origin xyz="0 0 3" rpy="0 {} 0"/>
      <geometry><cylinder radius="0.1" length="4"/></geometry></collision>
    <collision><origin xyz="3 0 0"/><geometry><sphere radius="0.25"/></geometry></collision>
    <collision><origin xyz="3 2 0" rpy="{} 0 0"/><geometry><sphere radius="0.2"/></geometry>
    </collision>
  </link>
  <link name="arm"><inertial><mass value="1"/>
    <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
    <collision><origin xyz="0 1 0" rpy="0 {} 0"/><geometry><sphere radius="0.3"/></geometry>
    </collision>
  </link>
  <joint name="j" type="fixed"><parent link="world"/><child link="arm"/>
    <origin xyz="3 3 0"/></joint>
</robot>'''.format(math.pi / 2, math.pi / 6, *[math.pi / 2] * 3)


def area(outline):
    """Return the area of a polygon that goes anticlockwise."""
    x, y = outline.T
    return float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))) / 2


def test_shapes_have_their_places_turns_and_sizes():
    world = robots.assemble(SHAPES).world
    shapes = {round(area(outline), 2): outline for outline in footprints(world)}
    disc = 12 * math.sin(math.pi / 12)          # of a polygon with 24 corners and radius 1
    assert sorted(shapes) == sorted(
        [2.0, 0.8, *(round(disc * radius ** 2, 2) for radius in (0.5, 0.25, 0.2, 0.3))])
    assert shapes[round(disc / 4, 2)].mean(axis=0) == pytest.approx([-1, 0], abs=1e-5)
    assert shapes[round(disc / 16, 2)].mean(axis=0) == pytest.approx([3, 0], abs=1e-5)
    assert shapes[round(disc * 0.04, 2)].mean(axis=0) == pytest.approx([3, 2], abs=1e-5)
    assert shapes[round(disc * 0.09, 2)].mean(axis=0) == pytest.approx([3, 4], abs=1e-5)
    lying = shapes[0.8]
    assert lying.min(axis=0) == pytest.approx([-2, -0.1], abs=1e-5)
    assert lying.max(axis=0) == pytest.approx([2, 0.1], abs=1e-5)
    box = shapes[2.0]
    assert len(box) == 4 and box.mean(axis=0) == pytest.approx([1, 2], abs=1e-5)
    corner = [1 + math.cos(math.pi / 6) - 0.5 * math.sin(math.pi / 6),
              2 + math.sin(math.pi / 6) + 0.5 * math.cos(math.pi / 6)]
    assert np.abs(box - corner).sum(axis=1).min() < 1e-5


def test_the_demos_world_has_nine_posts_and_walls_around_the_robot():
    found = footprints(robots.assemble('turtlebot3_world').world)
    middles = [tuple(outline.mean(axis=0).round(3) + 0.0) for outline in found]
    for x in (-1.1, 0.0, 1.1):
        for y in (-1.1, 0.0, 1.1):
            assert (x, y) in middles
    everything = np.concatenate(found)
    assert everything.min() < -3 and everything.max() > 3


def test_the_empty_world_has_none():
    assert footprints(robots.assemble('empty').world) == []
