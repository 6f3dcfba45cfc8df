"""Images by PyBullet's TinyRenderer, which needs no OpenGL: slow, and without shadows."""
import math
import os
import tempfile
from typing import Any, List, Tuple

import numpy as np
import pybullet

from img_recog import mesh_file, rotations
from img_recog.errors import one_line
from img_recog.mesh_file import MeshError
from img_recog.model import (BODY_TO_OPENGL, BOX, CYLINDER, MESH, PLANE, SPHERE, Material, Shape,
                             Visual, VisualScene)
from img_recog.rotations import Transform
from img_recog.simulation.physics.client import connect

_PLANE_THICKNESS_M = 0.002
_BACKGROUND_DEPTH = 1 - 5e-7
_STRAIGHT_DOWN = -0.999         # the height of a unit vector


class TinyRenderer:
    """Draws images of a scene. The floor has the color of the background: there is no horizon."""

    def __init__(self) -> None:
        """Start a physics client for the shapes. `load` must come next."""
        self._client = connect()

    def load(self, scene: VisualScene, _: np.ndarray) -> List[str]:
        """Draw this scene from now on; return a line for each mesh or texture that is left out."""
        pybullet.resetSimulation(physicsClientId=self._client)
        self._light = scene.light
        self._bodies: List[Tuple[int, np.ndarray, int]] = []
        self._missing: List[str] = []
        with tempfile.TemporaryDirectory(prefix='img_recog_') as folder:
            for visual in scene.visuals:
                try:
                    body_id = self._load(visual, folder)
                except MeshError as error:
                    self._miss(one_line(error))
                else:
                    self._bodies.append((visual.part, visual.pose, body_id))
        return self._missing

    def _miss(self, line: str) -> None:
        if line not in self._missing:
            self._missing.append(line)

    def draw(self, camera: Any, camera_pose: np.ndarray, poses: np.ndarray,
             ceiling: float = math.inf) -> np.ndarray:
        """Return an image, uint8 RGB of shape (height, width, 3).

        camera: like rendering.camera.Pinhole; camera_pose (4, 4): of its body in the world, which
        looks along its x axis; poses (n, 7): of all parts; ceiling: the height in m from which on
        nothing is drawn by a camera that looks down.
        """
        if camera_pose[2, 0] < _STRAIGHT_DOWN:
            camera = camera._replace(near=max(camera.near, camera_pose[2, 3] - ceiling))
        pixels, depth = self._draw(camera, camera_pose, poses)
        pixels[depth > _BACKGROUND_DEPTH] = np.round(np.array(self._light.background) * 255)
        return pixels

    def depth(self, camera: Any, camera_pose: np.ndarray, poses: np.ndarray) -> np.ndarray:
        """Return the depths of that image, float32 of shape (height, width), +inf for nothing."""
        _, depth = self._draw(camera, camera_pose, poses)
        near, far = camera.near, camera.far
        distances = np.float32(far * near) / (np.float32(far) - np.float32(far - near) * depth)
        return np.where(depth > _BACKGROUND_DEPTH, np.float32(np.inf), distances)

    def _draw(self, camera: Any, camera_pose: np.ndarray,
              poses: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
        for part, offset, body_id in self._bodies:
            position, orientation = poses[part, :3].tolist(), poses[part, 3:].tolist()
            turned = pybullet.multiplyTransforms(position, orientation, offset[:3, 3].tolist(),
                                                 rotations.quaternion_of(offset))
            pybullet.resetBasePositionAndOrientation(body_id, *turned,
                                                     physicsClientId=self._client)
        pose = Transform(camera_pose[:3, :3], camera_pose[:3, 3])
        view = BODY_TO_OPENGL @ pose.inverse.matrix()
        left, right, bottom, top = camera.window
        near, far = camera.near, camera.far
        # TinyRenderer's pixel is at its lower left corner instead of its middle
        projection = np.array([
            [2 / (right - left), 0, (right + left) / (right - left) + 1 / camera.width, 0],
            [0, 2 / (top - bottom), (top + bottom) / (top - bottom) + 1 / camera.height, 0],
            [0, 0, -(far + near) / (far - near), -2 * far * near / (far - near)], [0, 0, -1, 0]])
        drawn = pybullet.getCameraImage(
            camera.width, camera.height, view.T.ravel().tolist(), projection.T.ravel().tolist(),
            shadow=0, lightDirection=self._light.sun, lightColor=(1, 1, 1),
            lightAmbientCoeff=0.75, lightDiffuseCoeff=0.25, lightSpecularCoeff=0.0,
            flags=pybullet.ER_NO_SEGMENTATION_MASK, renderer=pybullet.ER_TINY_RENDERER,
            physicsClientId=self._client)
        shape = camera.height, camera.width
        return (np.reshape(drawn[2], (*shape, 4)).astype(np.uint8)[:, :, :3].copy(),
                np.reshape(drawn[3], shape).astype(np.float32))

    def _load(self, visual: Visual, folder: str) -> int:
        """Return the id of a body that shows a visual; folder: for the files of meshes."""
        material, shape = visual.material or Material(), visual.shape
        if shape.path:
            # PyBullet would show nothing in place of what it cannot read
            shape = shape._replace(path=mesh_file.write(
                shape.path, tempfile.mkdtemp(dir=folder), materials=True, submesh=shape.submesh))
        shape_id = pybullet.createVisualShape(
            rgbaColor=material.color, specularColor=(0, 0, 0), physicsClientId=self._client,
            **_options(shape))
        body_id = pybullet.createMultiBody(0, -1, shape_id, physicsClientId=self._client)
        if material.texture and os.path.isfile(material.texture):
            texture_id = pybullet.loadTexture(material.texture, physicsClientId=self._client)
            pybullet.changeVisualShape(body_id, -1, textureUniqueId=texture_id,
                                       physicsClientId=self._client)
        elif material.texture:
            self._miss('there is no file ' + material.texture)
        return body_id


def _options(shape: Shape) -> dict:
    """Return the arguments of pybullet.createVisualShape for a shape."""
    size = shape.size
    return {
        BOX: lambda: {'shapeType': pybullet.GEOM_BOX, 'halfExtents': [side / 2 for side in size]},
        CYLINDER: lambda: {'shapeType': pybullet.GEOM_CYLINDER, 'radius': size[0],
                           'length': size[1]},
        SPHERE: lambda: {'shapeType': pybullet.GEOM_SPHERE, 'radius': size[0]},
        PLANE: lambda: {'shapeType': pybullet.GEOM_BOX,
                        'halfExtents': [size[0] / 2, size[1] / 2, _PLANE_THICKNESS_M / 2],
                        'visualFramePosition': [0, 0, -_PLANE_THICKNESS_M / 2]},
        MESH: lambda: {'shapeType': pybullet.GEOM_MESH, 'fileName': shape.path,
                       'meshScale': size}}[shape.kind]()
