"""The elements of SDF 1.4 to 1.9 and of URDF, and what becomes of each: the table.

A row has the children of an element. Its key is the end of the path to that element:
`friction/ode` counts more than `ode`. The words are names; after a name can stand a value that
changes nothing, such as `kinematic=0`, and `mu2=<mu>` is the value of another child; a question
mark after one that is simulated means that its text is true, false, 1 or 0. An element
without a row has no children; what is below one that is not simulated or of no effect is not
looked at.
doc/elements.md is made of this table.
"""
from typing import Dict, NamedTuple

SIMULATED, NO_EFFECT = 'simulated', 'of no effect here'


class Fates(NamedTuple):
    """The children of an element, each in the field that says what becomes of it.

    anything: whether children that are in none of the fields belong to others and are not looked
    at; why: why some have no effect here.
    """

    simulated: str = ''
    drawn: str = ''
    no_effect: str = ''
    not_simulated: str = ''
    anything: bool = False
    why: str = ''


_CONTACTS = 'contacts are those of PyBullet, which give way less'
_SHADOWS = 'no shadows are drawn, as in Gazebo without a graphics card'
_INERTIA = Fates('ixx ixy ixz iyy iyz izz')
_NOISE = Fates('type mean stddev bias_mean bias_stddev precision',
               not_simulated='dynamic_bias_stddev=0 dynamic_bias_correlation_time=0')
_CAMERA = Fates('horizontal_fov image clip noise distortion lens pose depth_camera',
                no_effect='save visibility_mask', why='images are published')
_STATE = Fates('pose link scale model', no_effect='joint', why='Gazebo sets links alone')
_STATE_LINK = Fates('pose', no_effect='acceleration wrench',
                    not_simulated='velocity=0,0,0,0,0,0', why='they follow')

# of sensors, which both formats have
SENSORS: Dict[str, Fates] = {
    'sensor': Fates('ray lidar camera imu contact update_rate pose topic plugin always_on? sonar',
                    no_effect='visualize',
                    not_simulated='gps navsat magnetometer altimeter air_pressure force_torque '
                                  'logical_camera rfid rfidtag transceiver'),
    'ray': Fates('scan range noise', no_effect='visualize'),
    'lidar': Fates('scan range noise', no_effect='visualize visibility_mask'),
    'ray/scan': Fates('horizontal vertical'), 'lidar/scan': Fates('horizontal vertical'),
    'horizontal': Fates('samples resolution min_angle max_angle'),
    'vertical': Fates('samples min_angle max_angle', not_simulated='resolution=1'),
    'ray/range': Fates('min max', no_effect='resolution', why='ranges are exact'),
    'lidar/range': Fates('min max', no_effect='resolution', why='ranges are exact'),
    'noise': _NOISE,
    'sensor/camera': _CAMERA,
    'camera/image': Fates('width height format', not_simulated='anti_aliasing'),
    'camera/clip': Fates('near far'),
    'camera/noise': Fates('type mean stddev', no_effect='bias_mean bias_stddev precision '
                          'dynamic_bias_stddev dynamic_bias_correlation_time',
                          why='images have none in Gazebo either'),
    'distortion': Fates('k1 k2 k3 p1 p2 center'),
    'lens': Fates('type scale_to_hfov? custom_function cutoff_angle env_texture_size',
                  not_simulated='intrinsics projection'),
    'custom_function': Fates('c1 c2 c3 f fun'),
    'depth_camera': Fates('output clip'), 'depth_camera/clip': Fates('near far'),
    # until SDF 1.5, <noise> is read as that of each axis, in sdf_versions.py
    'sensor/imu': Fates('angular_velocity linear_acceleration topic',
                        no_effect='orientation_reference_frame enable_orientation',
                        not_simulated='noise'),
    'angular_velocity': Fates('x y z'), 'linear_acceleration': Fates('x y z'),
    'x': Fates('noise'), 'y': Fates('noise'), 'z': Fates('noise'),
    'sensor/contact': Fates('collision topic'),
    'sonar': Fates('min max radius', no_effect='geometry'),
    'plugin': Fates(anything=True),
}

SDF: Dict[str, Fates] = {
    **SENSORS,
    'sdf': Fates('world model', 'light', not_simulated='actor'),
    'world': Fates('model include population road gravity physics state gui frame', 'scene light',
                   'audio spherical_coordinates magnetic_field atmosphere wind',
                   'actor joint plugin',
                   why='nothing here hears, measures or feels them'),
    'physics': Fates('gravity', no_effect='real_time_factor real_time_update_rate max_contacts '
                     'ode bullet simbody dart magnetic_field provide_feedback',
                     not_simulated='max_step_size=0.001', why='the physics is PyBullet'),
    'scene': Fates('', 'ambient background fog sky', 'grid origin_visual shadows', why=_SHADOWS),
    'fog': Fates('', 'color type start end density'),
    'sky': Fates(no_effect='clouds sunrise sunset', not_simulated='time=10 cubemap_uri',
                 why='the sky is that of the morning'),
    'light': Fates('', 'pose diffuse specular attenuation direction spot',
                   'cast_shadows visualize', 'intensity=1 light_on=1', why=_SHADOWS),
    'attenuation': Fates('', 'range constant linear quadratic'),
    'spot': Fates('', 'inner_angle outer_angle falloff'),
    'gui': Fates('camera', no_effect='plugin', why='only its camera is used, for the view'),
    'gui/camera': Fates('pose', no_effect='view_controller track_visual projection_type name'),
    'state': Fates('model', 'light', 'sim_time wall_time real_time iterations',
                   'insertions deletions joint', why='time begins at 0'),
    'state/light': Fates('', 'pose'),
    'state/model': _STATE, 'state/model/link': _STATE_LINK,
    'state/model/model': _STATE, 'state/model/model/link': _STATE_LINK,
    'model': Fates('static? pose link joint include model frame sensor self_collide? '
                   'allow_auto_disable?', no_effect='enable_wind light',
                   not_simulated='gripper plugin',
                   why='there is no wind, and Gazebo draws the lights of links alone'),
    'include': Fates('uri name pose static?', not_simulated='placement_frame plugin frame joint'),
    'model/frame': Fates('pose'), 'world/frame': Fates('pose'),
    'link': Fates('pose inertial collision visual sensor gravity? kinematic? self_collide? '
                  'velocity_decay', 'light', 'must_be_base_link enable_wind',
                  'projector audio_source audio_sink battery particle_emitter',
                  why='there is no wind'),
    'velocity_decay': Fates('linear angular'),
    'inertial': Fates('mass inertia pose', no_effect='density auto_inertia_params'),
    'inertia': _INERTIA,
    'collision': Fates('geometry pose surface', no_effect='max_contacts',
                       not_simulated='laser_retro=0', why=_CONTACTS),
    'surface': Fates('friction contact bounce', not_simulated='soft_contact'),
    'bounce': Fates('restitution_coefficient threshold'),
    'surface/contact': Fates('ode collide_bitmask collide_without_contact?',
                             no_effect='bullet poissons_ratio elastic_modulus '
                             'collide_without_contact_bitmask category_bitmask',
                             why='Gazebo does not use the other bitmasks either'),
    'contact/ode': Fates('kp kd max_vel min_depth', no_effect='soft_cfm soft_erp', why=_CONTACTS),
    'surface/friction': Fates('ode', no_effect='bullet', not_simulated='torsional=0',
                              why='those of ode count, as in Gazebo'),
    'friction/ode': Fates('mu mu2 fdir1', not_simulated='slip1=0 slip2=0'),
    'visual': Fates('', 'geometry pose material transparency',
                    'meta laser_retro cast_shadows',
                    'plugin visibility_flags', why='lasers see solids; ' + _SHADOWS),
    'material': Fates('', 'script ambient diffuse specular emissive lighting?', 'render_order '
                      'double_sided shininess', 'shader pbr', why='Gazebo 11 does not use them'),
    'script': Fates('', 'name uri'),
    'geometry': Fates('box cylinder sphere plane mesh polyline heightmap', no_effect='empty',
                      not_simulated='image capsule ellipsoid'),
    'geometry/box': Fates('size'), 'geometry/cylinder': Fates('radius length'),
    'geometry/sphere': Fates('radius'), 'geometry/plane': Fates('size normal'),
    'mesh': Fates('uri scale submesh filename'), 'submesh': Fates('name center?'),
    'polyline': Fates('point height'),
    'heightmap': Fates('uri size pos sampling', 'texture', 'use_terrain_paging', 'blend',
                       why='terrain is loaded as a whole'),
    'heightmap/texture': Fates('', 'diffuse size', '', 'normal'),
    'joint': Fates('parent child pose axis axis2 gearbox_ratio gearbox_reference_body '
                   'thread_pitch', no_effect='physics', not_simulated='sensor',
                   why='solved by PyBullet'),
    'axis': Fates('xyz limit use_parent_model_frame? dynamics', no_effect='initial_position',
                  not_simulated='mimic', why='Gazebo does not use it either'),
    'axis2': Fates('xyz limit use_parent_model_frame? dynamics', no_effect='initial_position',
                   not_simulated='mimic', why='Gazebo does not use it either'),
    'dynamics': Fates('damping friction spring_stiffness spring_reference'),
    'limit': Fates('lower upper', no_effect='stiffness dissipation effort velocity',
                   why='limits are hard; as in Gazebo, those of effort and velocity hold '
                   'apply_joint_effort, and neither a motor nor what gravity moves'),
    'population': Fates('model model_count distribution box cylinder pose'),
    'population/box': Fates('size'), 'population/cylinder': Fates('radius length'),
    'distribution': Fates('type step rows cols'),
    'road': Fates('width point', 'material'),
}

# in a <gazebo> tag with a reference, which Gazebo copies into the link or joint
_TAGS = Fates('sensor visual collision plugin mu1 mu2 fdir1 material turnGravityOff? selfCollide? '
              'self_collide? dampingFactor springReference springStiffness kp kd maxVel '
              'minDepth allow_auto_disable?', 'light',
              'maxContacts stopCfm stopErp fudgeFactor provideFeedback '
              'implicitSpringDamper cfmDamping disableFixedJointLumping preserveFixedJoint '
              'genTexCoord', 'static=0 gravity=1 laserRetro=0 velocity_decay=0 kinematic=0',
              why=_CONTACTS)

URDF: Dict[str, Fates] = {
    **SENSORS,
    'robot': Fates('link joint gazebo transmission', 'material',
                   not_simulated='ros2_control sensor group'),
    'transmission': Fates(anything=True),
    'robot/material': Fates('', 'color texture'),
    'robot/link': Fates('inertial visual collision contact', no_effect='type',
                        not_simulated='self_collision_checking'),
    'inertial': Fates('mass inertia origin'),
    'link/visual': Fates('', 'geometry origin material'),
    'link/collision': Fates('geometry origin', no_effect='verbose contact_coefficients'),
    'visual/material': Fates('', 'color texture'),
    'geometry': Fates('box cylinder sphere mesh', not_simulated='capsule'),
    'link/contact': Fates('lateral_friction', no_effect='stiffness damping rolling_friction '
                          'spinning_friction contact_cfm contact_erp inertia_scaling'),
    'robot/joint': Fates('parent child origin axis limit dynamics',
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
