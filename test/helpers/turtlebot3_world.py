"""The geometry of turtlebot3_world as circles and hexagons in the plane."""
import math

import numpy as np

POSTS = [(x, y) for x in (-1.1, 0, 1.1) for y in (-1.1, 0, 1.1)]
POST_RADIUS = 0.15
WALL_APOTHEM = 2.540        # of the inner side of the wall
# the prisms whose corners reach through the wall: center and corner radius
PRISMS = [((3.5, 0), 1.173), *(((x, y), 0.807) for x in (-1.8, 1.8) for y in (-2.7, 2.7))]
_NORMALS = [np.array((math.cos(angle), math.sin(angle)))
            for angle in np.radians(range(30, 390, 60))]


def clearance(point):
    """Return a lower bound of the distance in m from a point inside the wall to any obstacle.

    It is the distance itself, except near the corners of the prisms.
    """
    distances = [math.dist(point, post) - POST_RADIUS for post in POSTS]
    distances.append(min(WALL_APOTHEM - normal @ point for normal in _NORMALS))
    distances += [max(normal @ np.subtract(point, center) for normal in _NORMALS)
                  - corner * math.sqrt(3) / 2 for center, corner in PRISMS]
    return min(distances)


def ranges(origin, angles, range_max):
    """Return the ranges in m from a point inside the wall, +inf beyond range_max."""
    found = []
    for angle in angles:
        direction = np.array([math.cos(angle), math.sin(angle)])
        hits = [_ray_to_circle(origin, direction, post, POST_RADIUS) for post in POSTS]
        hits.append(min((WALL_APOTHEM - normal @ origin) / (normal @ direction)
                        for normal in _NORMALS if normal @ direction > 1e-9))
        hits += [_ray_to_hexagon(origin, direction, *prism) for prism in PRISMS]
        found.append(min(hits) if min(hits) <= range_max else math.inf)
    return np.array(found)


def _ray_to_circle(origin, direction, center, radius):
    offset = np.subtract(center, origin)
    along = offset @ direction
    square = radius ** 2 - (offset @ offset - along ** 2)
    return along - math.sqrt(square) if square >= 0 and along > 0 else math.inf


def _ray_to_hexagon(origin, direction, center, corner):
    """Return the distance to a hexagon from outside, by the slab method."""
    enter, leave, apothem = -math.inf, math.inf, corner * math.sqrt(3) / 2
    for normal in _NORMALS[:3]:
        speed, offset = normal @ direction, normal @ np.subtract(center, origin)
        if abs(speed) < 1e-12:
            if abs(offset) > apothem:
                return math.inf
            continue
        near, far = sorted(((offset - apothem) / speed, (offset + apothem) / speed))
        enter, leave = max(enter, near), min(leave, far)
    return enter if 0 < enter <= leave else math.inf
