"""A model prepared for PyBullet's window, which paints all shapes of a link in one color."""
import dataclasses
from typing import Dict, List, Optional

from img_recog.model import FIXED, Joint, Link, Look, Material, Model


def split_links_by_color(model: Model) -> Model:
    """Return the model with each color of a link moved to a massless link fixed to it.

    Inertias stay where they are; solids are removed, since they are not drawn.
    """
    added, joints = [], []
    for link in model.links:
        colors: Dict[Optional[Material], List[Look]] = {}
        for look in link.looks:
            colors.setdefault(look.material, []).append(look)
        for number, looks in enumerate(colors.values()):
            name = '{}_color_{}'.format(link.name, number)
            added.append(Link(name, looks=tuple(looks)))
            joints.append(Joint(name + '_joint', FIXED, link.name, name))
    bare = [link._replace(solids=(), looks=()) for link in model.links]
    return dataclasses.replace(model, links=(*bare, *added), joints=(*model.joints, *joints))
