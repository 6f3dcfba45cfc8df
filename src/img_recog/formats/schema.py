"""The schema of SDF 1.4 to 1.9 and of URDF: a row for each element.

The key of a row is the end of the path to its element: `friction/ode` takes precedence over
`ode`. A row lists the children of the element by how they are handled. Each word of a list is
`name`, `name:type`, `name:type=default` or `name=default`:

- The type says how the text of the child is read; TYPES in reader.py has the types.
- The default is the value of a child that is missing. Numbers are divided by commas, and
  `mu2=<mu>` is the value of another child. A child that is not simulated is a finding only if
  its value differs from the default.

An element without a row has no children. The audit does not check what is inside an element that
is not simulated or of no effect. reader.py reads values by this schema, audit.py compares files
with it, and doc/elements.md is made of it.
"""
import functools
from typing import Dict, Mapping, NamedTuple, Optional, Tuple

from img_recog.report import NOT_SIMULATED

SIMULATED, NO_EFFECT = 'simulated', 'of no effect here'


class Row(NamedTuple):
    """The children of an element.

    Attributes:
        simulated: Words of the children that the simulation uses.
        drawn: Words of the children that are only drawn.
        no_effect: Names of the children that change nothing here.
        not_simulated: Names of the children that are findings, with the defaults that are not.
        anything: Whether other children belong to other programs and are not checked.
        why: Reason why some children have no effect.
    """

    simulated: str = ''
    drawn: str = ''
    no_effect: str = ''
    not_simulated: str = ''
    anything: bool = False
    why: str = ''


class Child(NamedTuple):
    """A child of an element.

    Attributes:
        state: How it is handled: SIMULATED, NO_EFFECT or NOT_SIMULATED.
        type: Name of the type of its value, '' without.
        default: Text of its default, None without.
    """

    state: str
    type: str = ''
    default: Optional[str] = None


_CONTACTS = 'contacts are those of PyBullet, which give way less'
_SHADOWS = 'no shadows are drawn, as in Gazebo without a graphics card'
_INERTIA = Row('ixx:number=1 ixy:number=0 ixz:number=0 iyy:number=1 iyz:number=0 izz:number=1')
_NOISE = Row('type mean:number=0 stddev:number=0 bias_mean:number=0 bias_stddev:number=0 '
             'precision:number=0',
             not_simulated='dynamic_bias_stddev=0 dynamic_bias_correlation_time=0')
_CAMERA = Row('horizontal_fov:number=1.047 image clip noise distortion lens pose depth_camera',
              no_effect='save visibility_mask', why='images are published')
_STATE = Row('pose link scale:3lengths=1,1,1 model', no_effect='joint',
             why='Gazebo sets links alone')
_AXIS = Row('xyz:axis=0,0,1 limit use_parent_model_frame:bool dynamics',
            no_effect='initial_position', not_simulated='mimic',
            why='Gazebo does not use it either')
_STATE_LINK = Row('pose', no_effect='acceleration wrench', not_simulated='velocity=0,0,0,0,0,0',
                  why='they follow')

# of sensors, which both formats have
SENSORS: Dict[str, Row] = {
    'sensor': Row('ray lidar camera imu contact update_rate pose topic plugin always_on:bool '
                  'sonar', no_effect='visualize',
                  not_simulated='gps navsat magnetometer altimeter air_pressure force_torque '
                                'logical_camera rfid rfidtag transceiver'),
    'ray': Row('scan range noise', no_effect='visualize'),
    'lidar': Row('scan range noise', no_effect='visualize visibility_mask'),
    'scan': Row('horizontal vertical'),
    'horizontal': Row('samples:whole resolution:number min_angle:number max_angle:number'),
    'vertical': Row('samples:whole min_angle:number max_angle:number',
                    not_simulated='resolution=1'),
    'range': Row('min:number max:number', no_effect='resolution', why='ranges are exact'),
    'noise': _NOISE,
    'camera': _CAMERA,
    'camera/image': Row('width:whole=320 height:whole=240 format:text=R8G8B8',
                        not_simulated='anti_aliasing'),
    'camera/clip': Row('near:number=0.1 far:number=100'),
    'camera/noise': Row('type mean:number=0 stddev:number=0',
                        no_effect='bias_mean bias_stddev precision dynamic_bias_stddev '
                                  'dynamic_bias_correlation_time',
                        why='images have none in Gazebo either'),
    'distortion': Row('k1:number k2:number k3:number p1:number p2:number center'),
    'lens': Row('type:text=stereographic scale_to_hfov:bool custom_function cutoff_angle:number '
                'env_texture_size:whole', not_simulated='intrinsics projection'),
    'custom_function': Row('c1:number c2:number c3:number f:number fun:text'),
    'depth_camera': Row('output clip'), 'depth_camera/clip': Row('near far'),
    # until SDF 1.5, <noise> is read as that of each axis, in sdf_versions.py
    'sensor/imu': Row('angular_velocity linear_acceleration topic',
                      no_effect='orientation_reference_frame enable_orientation',
                      not_simulated='noise'),
    'angular_velocity': Row('x y z'), 'linear_acceleration': Row('x y z'),
    'x': Row('noise'), 'y': Row('noise'), 'z': Row('noise'),
    'sensor/contact': Row('collision topic'),
    'sonar': Row('min:number max:number radius:number', no_effect='geometry'),
    'plugin': Row(anything=True),
}

SDF: Dict[str, Row] = {
    **SENSORS,
    'sdf': Row('world model', 'light', not_simulated='actor'),
    'world': Row('model include population road gravity:3numbers physics state gui frame',
                 'scene light', 'audio spherical_coordinates magnetic_field atmosphere wind',
                 'actor joint plugin', why='nothing here hears, measures or feels them'),
    'physics': Row('gravity:3numbers',
                   no_effect='real_time_factor real_time_update_rate max_contacts ode bullet '
                             'simbody dart magnetic_field provide_feedback',
                   not_simulated='max_step_size=0.001', why='the physics is PyBullet'),
    'scene': Row('', 'ambient:color=0.4,0.4,0.4,1 background:color=0.7,0.7,0.7,1 fog sky',
                 'grid origin_visual shadows', why=_SHADOWS),
    'fog': Row('', 'color:color=1,1,1,1 type:text start:limit=1 end:limit=100 density:limit=1'),
    'sky': Row(no_effect='clouds sunrise sunset', not_simulated='time=10 cubemap_uri',
               why='the sky is that of the morning'),
    'light': Row('',
                 'pose diffuse:color=1,1,1,1 specular:color=0.1,0.1,0.1,1 attenuation '
                 'direction:direction=0,0,-1 spot', 'cast_shadows visualize',
                 'intensity=1 light_on=1', why=_SHADOWS),
    'attenuation': Row('', 'range:limit=10 constant:limit=1 linear:limit=1 quadratic:limit=0'),
    'spot': Row('', 'inner_angle:limit=0 outer_angle:limit=0 falloff:limit=0'),
    'gui': Row('camera', no_effect='plugin', why='only its camera is used, for the view'),
    'gui/camera': Row('pose', no_effect='view_controller track_visual projection_type name'),
    'state': Row('model', 'light', 'sim_time wall_time real_time iterations',
                 'insertions deletions joint', why='time begins at 0'),
    'state/light': Row('', 'pose'),
    'state/model': _STATE, 'state/model/link': _STATE_LINK,
    'state/model/model': _STATE, 'state/model/model/link': _STATE_LINK,
    'model': Row('static:bool=false pose link joint include model frame sensor '
                 'self_collide:bool=false allow_auto_disable:bool=true',
                 no_effect='enable_wind light', not_simulated='gripper plugin',
                 why='there is no wind, and Gazebo draws the lights of links alone'),
    'include': Row('uri:text name:text pose static:bool',
                   not_simulated='placement_frame plugin frame joint'),
    'model/frame': Row('pose'), 'world/frame': Row('pose'),
    'link': Row('pose inertial collision visual sensor gravity:bool=true kinematic:bool=false '
                'self_collide:bool velocity_decay', 'light', 'must_be_base_link enable_wind',
                'projector audio_source audio_sink battery particle_emitter',
                why='there is no wind'),
    'velocity_decay': Row('linear:share=0 angular:share=0'),
    'inertial': Row('mass:mass=1 inertia pose', no_effect='density auto_inertia_params'),
    'inertia': _INERTIA,
    'collision': Row('geometry pose surface', no_effect='max_contacts',
                     not_simulated='laser_retro=0', why=_CONTACTS),
    'surface': Row('friction contact bounce', not_simulated='soft_contact'),
    'bounce': Row('restitution_coefficient:positive threshold:number'),
    'surface/contact': Row('ode collide_bitmask:bits=65535 collide_without_contact:bool=false',
                           no_effect='bullet poissons_ratio elastic_modulus '
                                     'collide_without_contact_bitmask category_bitmask',
                           why='Gazebo does not use the other bitmasks either'),
    'contact/ode': Row('kp:positive kd:positive max_vel:positive min_depth:positive',
                       no_effect='soft_cfm soft_erp', why=_CONTACTS),
    'surface/friction': Row('ode', no_effect='bullet', not_simulated='torsional=0',
                            why='those of ode count, as in Gazebo'),
    'friction/ode': Row('mu:friction=1 mu2:friction=1 fdir1:3lengths=0,0,0',
                        not_simulated='slip1=0 slip2=0'),
    'visual': Row('', 'geometry pose material transparency:number=0',
                  'meta laser_retro cast_shadows', 'plugin visibility_flags',
                  why='lasers see solids; ' + _SHADOWS),
    'material': Row('',
                    'script ambient:color diffuse:color specular:color emissive:color '
                    'lighting:bool=true', 'render_order double_sided shininess', 'shader pbr',
                    why='Gazebo 11 does not use them'),
    'script': Row('', 'name:text uri:text'),
    'geometry': Row('box cylinder sphere plane mesh polyline heightmap', no_effect='empty',
                    not_simulated='image capsule ellipsoid'),
    'box': Row('size:3sizes'), 'cylinder': Row('radius:size length:size'),
    'sphere': Row('radius:size'),
    'plane': Row('size:2sizes=1,1 normal:direction=0,0,1'),
    'mesh': Row('uri:text scale:3lengths=1,1,1 submesh filename:text'),
    'submesh': Row('name:text center:bool=false'),
    'polyline': Row('point:2lengths height:size'),
    'heightmap': Row('uri:text size:3lengths=1,1,1 pos:3lengths=0,0,0 sampling:whole=2',
                     'texture', 'use_terrain_paging', 'blend', why='terrain is loaded as a whole'),
    'heightmap/texture': Row('', 'diffuse:text size:number=10', '', 'normal'),
    'joint': Row('parent child pose axis axis2 gearbox_ratio:number=1 '
                 'gearbox_reference_body:text thread_pitch:number=1', no_effect='physics',
                 not_simulated='sensor', why='solved by PyBullet'),
    'axis': _AXIS, 'axis2': _AXIS,
    'dynamics': Row('damping:number=0 friction:number=0 spring_stiffness:number=0 '
                    'spring_reference:number=0'),
    'limit': Row('lower:limit=-inf upper:limit=inf effort:limit=-1 velocity:limit=-1',
                 no_effect='stiffness dissipation',
                 why='limits are hard; as in Gazebo, those of effort and velocity hold '
                     'apply_joint_effort, and neither a motor nor what gravity moves'),
    'population': Row('model model_count:count=1 distribution box cylinder pose'),
    'population/box': Row('size:3lengths=1,1,1'),
    'population/cylinder': Row('radius:length=1 length:length=1'),
    'distribution': Row('type:text=random step:3lengths=0.5,0.5,0 rows:count=1 cols:count=1'),
    'road': Row('width:length=1 point:3lengths', 'material'),
}

# in a <gazebo> tag with a reference, which Gazebo copies into the link or joint
_TAGS = Row('sensor visual collision plugin mu1 mu2 fdir1 material turnGravityOff:bool '
            'selfCollide:bool self_collide:bool dampingFactor springReference springStiffness '
            'kp kd maxVel minDepth allow_auto_disable:bool', 'light',
            'maxContacts stopCfm stopErp fudgeFactor provideFeedback implicitSpringDamper '
            'cfmDamping disableFixedJointLumping preserveFixedJoint genTexCoord',
            'static=0 gravity=1 laserRetro=0 velocity_decay=0 kinematic=0', why=_CONTACTS)

URDF: Dict[str, Row] = {
    **SENSORS,
    'robot': Row('link joint gazebo transmission', 'material',
                 not_simulated='ros2_control sensor group'),
    'transmission': Row(anything=True),
    'robot/material': Row('', 'color texture'),
    'robot/link': Row('inertial visual collision contact', no_effect='type',
                      not_simulated='self_collision_checking'),
    'inertial': Row('mass inertia origin'),
    'link/visual': Row('', 'geometry origin material'),
    'link/collision': Row('geometry origin', no_effect='verbose contact_coefficients'),
    'visual/material': Row('', 'color texture'),
    'geometry': Row('box cylinder sphere mesh', not_simulated='capsule'),
    'link/contact': Row('lateral_friction',
                        no_effect='stiffness damping rolling_friction spinning_friction '
                                  'contact_cfm contact_erp inertia_scaling'),
    'robot/joint': Row('parent child origin axis limit dynamics',
                       no_effect='calibration safety_controller', not_simulated='mimic',
                       why='those of the real robot'),
    'robot/gazebo': _TAGS,
    'gazebo/visual': SDF['visual'], 'gazebo/collision': SDF['collision'],
    **{key: row for key, row in SDF.items() if key.split('/')[0] in (
        'surface', 'bounce', 'friction', 'script', 'light', 'attenuation', 'spot')},
    'gazebo/visual/material': SDF['material'],
}

# of the plugins of gazebo_ros whose names contain these: all that they read, one list for all,
# with what ROS 2 calls it
KNOWN_PLUGINS = ('gazebo_ros_diff_drive', 'gazebo_ros_skid_steer', 'gazebo_ros_planar_move',
                 'gazebo_ros_laser', 'gazebo_ros_gpu_laser', 'gazebo_ros_camera',
                 'gazebo_ros_openni', 'gazebo_ros_depth', 'gazebo_ros_multicamera',
                 'gazebo_ros_bumper', 'gazebo_ros_imu')
PLUGIN_NAMES = frozenset("""
    Cx CxPrime Cy accelDrift accelGaussianNoise alwaysOn autoDistortion baseline bodyName
    borderCrop broadcastTF bumperTopicName cameraInfoTopicName cameraName cmdTimeout
    commandTopic covariance_x covariance_y covariance_yaw depthImageCameraInfoTopicName
    depthImageInfoTopicName depthImageTopicName distortionK1 distortionK2 distortionK3
    distortionT1 distortionT2 distortion_k1 distortion_k2 distortion_k3 distortion_t1
    distortion_t2 focalLength fov frameName gaussianNoise hackBaseline headingDrift
    headingGaussianNoise hokuyoMinIntensity imageTopicName imu initialOrientationAsReference
    jointName leftFrontJoint leftJoint leftRearJoint legacyMode normalsTopicName odometryFrame
    odometryRate odometrySource odometryTopic pointCloudCutoff pointCloudCutoffMax
    pointCloudTopicName publishOdomTF publishTf publishWheelJointState publishWheelTF
    publishWheelTf radiation rangeMax rateDrift rateGaussianNoise reduceNormals
    reflectanceTopicName rightFrontJoint rightJoint rightRearJoint robotBaseFrame
    robotNamespace ros rosDebugLevel rpyOffset rpyOffsets serviceName tfPrefix topicName torque
    triggerTopicName updateRate updateRateHZ wheelAcceleration wheelDiameter wheelSeparation
    wheelTorque xyzOffset xyzOffsets always_on camera_name command_topic frame_name
    hack_baseline initial_orientation_as_reference left_joint max_depth max_wheel_acceleration
    max_wheel_torque min_depth num_wheel_pairs odometry_frame odometry_rate odometry_source
    odometry_topic output_type publish_odom publish_odom_tf publish_rate publish_wheel_tf
    right_joint robot_base_frame update_rate wheel_diameter wheel_separation""".split())
# in the file names of the plugins of a <model> that are simulated
MODEL_PLUGINS = ('gazebo_ros_diff_drive', 'gazebo_ros_skid_steer_drive', 'gazebo_ros_planar_move',
                 'force_based_move', 'gazebo_ros_kobuki', 'gazebo_ros_joint_state_publisher',
                 'gazebo_ros_imu')
# plugins of Gazebo itself, which publish no topics of ROS, and those of gazebo_ros that do
WITHOUT_ROS = {'RayPlugin': 'laser', 'GpuRayPlugin': 'gpu_laser', 'CameraPlugin': 'camera',
               'DepthCameraPlugin': 'depth_camera', 'ImuSensorPlugin': 'imu_sensor',
               'ContactPlugin': 'bumper', 'DiffDrivePlugin': 'diff_drive',
               'SkidSteerDrivePlugin': 'skid_steer_drive', 'SonarPlugin': 'range'}
# attributes; degrees and rotation_format of a <pose> are read since 1.9, and are gone then
_OF_SDF = frozenset(('name', 'type', 'filename', 'version', 'world_name', 'frame', 'relative_to',
                     'attached_to', 'expressed_in', 'placement_frame', 'canonical_link',
                     'default', 'id', 'fullscreen'))
ATTRIBUTES = {'sdf': _OF_SDF, 'robot': _OF_SDF.union((
    'xyz', 'rpy', 'link', 'value', 'ixx', 'ixy', 'ixz', 'iyy', 'iyz', 'izz', 'reference', 'rgba',
    'size', 'radius', 'length', 'scale', 'effort', 'velocity', 'damping', 'friction', 'lower',
    'upper'))}
_FORMATS: Mapping[str, Mapping[str, Row]] = {'sdf': SDF, 'robot': URDF}


@functools.lru_cache(maxsize=None)
def row_of(path: Tuple[str, ...]) -> Row:
    """Return the row with the longest key that ends a path, an empty row without.

    Args:
        path: Names of the elements from the root, `sdf` or `robot`, on.
    """
    ends = ('/'.join(path[start:]) for start in range(len(path)))
    return next((_FORMATS[path[0]][end] for end in ends if end in _FORMATS[path[0]]), Row())


@functools.lru_cache(maxsize=None)
def children_of(row: Row) -> Dict[str, Child]:
    """Return the children in a row by their names; drawn ones are simulated, too."""
    found: Dict[str, Child] = {}
    for state, words in ((SIMULATED, row.simulated), (SIMULATED, row.drawn),
                         (NO_EFFECT, row.no_effect), (NOT_SIMULATED, row.not_simulated)):
        for word in words.split():
            text, has_default, default = word.partition('=')
            name, _, kind = text.partition(':')
            found[name] = Child(state, kind, default if has_default else None)
    return found
