"""A package in place of gazebo_msgs, for machines where it is not installed."""
import importlib.util

from genpy import generator

INSTALLED = importlib.util.find_spec('gazebo_msgs') is not None

# Definitions from gazebo_msgs of ROS 1 and those that they use, without the comments.
DEFINITIONS = {
    'std_msgs/msg/Header.msg': 'uint32 seq\ntime stamp\nstring frame_id\n',
    'geometry_msgs/msg/Point.msg': 'float64 x\nfloat64 y\nfloat64 z\n',
    'geometry_msgs/msg/Vector3.msg': 'float64 x\nfloat64 y\nfloat64 z\n',
    'geometry_msgs/msg/Quaternion.msg': 'float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n',
    'geometry_msgs/msg/Pose.msg': 'Point position\nQuaternion orientation\n',
    'geometry_msgs/msg/Twist.msg': 'Vector3 linear\nVector3 angular\n',
    'geometry_msgs/msg/Wrench.msg': 'Vector3 force\nVector3 torque\n',
    'gazebo_msgs/msg/ContactState.msg': 'string info\nstring collision1_name\n'
                                        'string collision2_name\n'
                                        'geometry_msgs/Wrench[] wrenches\n'
                                        'geometry_msgs/Wrench total_wrench\n'
                                        'geometry_msgs/Vector3[] contact_positions\n'
                                        'geometry_msgs/Vector3[] contact_normals\n'
                                        'float64[] depths\n',
    'gazebo_msgs/msg/ContactsState.msg': 'Header header\ngazebo_msgs/ContactState[] states\n',
    'gazebo_msgs/msg/ModelState.msg': 'string model_name\ngeometry_msgs/Pose pose\n'
                                      'geometry_msgs/Twist twist\nstring reference_frame\n',
    'gazebo_msgs/msg/ModelStates.msg': 'string[] name\ngeometry_msgs/Pose[] pose\n'
                                       'geometry_msgs/Twist[] twist\n',
    'gazebo_msgs/msg/LinkState.msg': 'string link_name\ngeometry_msgs/Pose pose\n'
                                     'geometry_msgs/Twist twist\nstring reference_frame\n',
    'gazebo_msgs/srv/GetModelState.srv': 'string model_name\nstring relative_entity_name\n---\n'
                                         'Header header\ngeometry_msgs/Pose pose\n'
                                         'geometry_msgs/Twist twist\nbool success\n'
                                         'string status_message\n',
    'gazebo_msgs/srv/SetModelState.srv': 'gazebo_msgs/ModelState model_state\n---\n'
                                         'bool success\nstring status_message\n',
    'gazebo_msgs/srv/SetLinkState.srv': 'gazebo_msgs/LinkState link_state\n---\n'
                                        'bool success\nstring status_message\n',
    'gazebo_msgs/srv/SpawnModel.srv': 'string model_name\nstring model_xml\n'
                                      'string robot_namespace\n'
                                      'geometry_msgs/Pose initial_pose\n'
                                      'string reference_frame\n---\n'
                                      'bool success\nstring status_message\n',
    'gazebo_msgs/srv/DeleteModel.srv': 'string model_name\n---\n'
                                       'bool success\nstring status_message\n',
    'gazebo_msgs/srv/GetWorldProperties.srv': '---\nfloat64 sim_time\nstring[] model_names\n'
                                              'bool rendering_enabled\n'
                                              'bool success\nstring status_message\n',
    'gazebo_msgs/msg/ODEPhysics.msg': 'bool auto_disable_bodies\nuint32 sor_pgs_precon_iters\n'
                                      'uint32 sor_pgs_iters\nfloat64 sor_pgs_w\n'
                                      'float64 sor_pgs_rms_error_tol\n'
                                      'float64 contact_surface_layer\n'
                                      'float64 contact_max_correcting_vel\n'
                                      'float64 cfm\nfloat64 erp\nuint32 max_contacts\n',
    'gazebo_msgs/srv/GetPhysicsProperties.srv': '---\nfloat64 time_step\nbool pause\n'
                                                'float64 max_update_rate\n'
                                                'geometry_msgs/Vector3 gravity\n'
                                                'gazebo_msgs/ODEPhysics ode_config\n'
                                                'bool success\nstring status_message\n',
    'gazebo_msgs/srv/SetPhysicsProperties.srv': 'float64 time_step\nfloat64 max_update_rate\n'
                                                'geometry_msgs/Vector3 gravity\n'
                                                'gazebo_msgs/ODEPhysics ode_config\n---\n'
                                                'bool success\nstring status_message\n',
    'gazebo_msgs/msg/LinkStates.msg': 'string[] name\ngeometry_msgs/Pose[] pose\n'
                                      'geometry_msgs/Twist[] twist\n',
    'gazebo_msgs/srv/GetLinkState.srv': 'string link_name\nstring reference_frame\n---\n'
                                        'gazebo_msgs/LinkState link_state\n'
                                        'bool success\nstring status_message\n',
    'gazebo_msgs/srv/GetLinkProperties.srv': 'string link_name\n---\n'
                                             'geometry_msgs/Pose com\nbool gravity_mode\n'
                                             'float64 mass\nfloat64 ixx\nfloat64 ixy\n'
                                             'float64 ixz\nfloat64 iyy\nfloat64 iyz\n'
                                             'float64 izz\nbool success\n'
                                             'string status_message\n',
    'gazebo_msgs/srv/GetJointProperties.srv': 'string joint_name\n---\nuint8 type\n'
                                              'uint8 REVOLUTE=0\nuint8 CONTINUOUS=1\n'
                                              'uint8 PRISMATIC=2\nuint8 FIXED=3\n'
                                              'uint8 BALL=4\nuint8 UNIVERSAL=5\n'
                                              'float64[] damping\nfloat64[] position\n'
                                              'float64[] rate\nbool success\n'
                                              'string status_message\n',
    'gazebo_msgs/srv/GetModelProperties.srv': 'string model_name\n---\n'
                                              'string parent_model_name\n'
                                              'string canonical_body_name\n'
                                              'string[] body_names\nstring[] geom_names\n'
                                              'string[] joint_names\n'
                                              'string[] child_model_names\nbool is_static\n'
                                              'bool success\nstring status_message\n',
    'gazebo_msgs/srv/SetModelConfiguration.srv': 'string model_name\nstring urdf_param_name\n'
                                                 'string[] joint_names\n'
                                                 'float64[] joint_positions\n---\n'
                                                 'bool success\nstring status_message\n',
    'gazebo_msgs/srv/ApplyBodyWrench.srv': 'string body_name\nstring reference_frame\n'
                                           'geometry_msgs/Point reference_point\n'
                                           'geometry_msgs/Wrench wrench\ntime start_time\n'
                                           'duration duration\n---\n'
                                           'bool success\nstring status_message\n',
    'gazebo_msgs/srv/ApplyJointEffort.srv': 'string joint_name\nfloat64 effort\n'
                                            'time start_time\nduration duration\n---\n'
                                            'bool success\nstring status_message\n',
    'gazebo_msgs/srv/BodyRequest.srv': 'string body_name\n---\n',
    'gazebo_msgs/srv/JointRequest.srv': 'string joint_name\n---\n'}
MANIFEST = ('<package><name>gazebo_msgs</name><version>0.0.0</version><license>none</license>'
            '<description>stand-in</description><maintainer email="a@b.c">a</maintainer>'
            '</package>')


def write_package(folder):
    """Write the package; return the additions to the environment for it."""
    for name, text in DEFINITIONS.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    package = folder / 'gazebo_msgs'
    (package / 'package.xml').write_text(MANIFEST)
    modules = folder / 'python' / 'gazebo_msgs'
    search = {name: [str(folder / name / 'msg')]
              for name in ('std_msgs', 'geometry_msgs', 'gazebo_msgs')}
    for kind, make in (('msg', generator.MsgGenerator), ('srv', generator.SrvGenerator)):
        files = sorted((package / kind).iterdir())
        assert make().generate_messages('gazebo_msgs', [str(file) for file in files],
                                        str(modules / kind), search) == 0
        (modules / kind / '__init__.py').write_text(
            ''.join('from ._{} import *\n'.format(file.stem) for file in files))
    (modules / '__init__.py').write_text('')
    return {'PYTHONPATH': str(modules.parent), 'ROS_PACKAGE_PATH': str(package)}
