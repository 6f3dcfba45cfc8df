"""A package in place of gazebo_msgs, for machines where it is not installed."""
import importlib.util

from genpy import generator

INSTALLED = importlib.util.find_spec('gazebo_msgs') is not None

# Definitions from gazebo_msgs of ROS 1 and those that they use, without the comments: a
# line for each file, with semicolons between its fields.
_DEFINITIONS = """
std_msgs/msg/Header.msg: uint32 seq; time stamp; string frame_id
geometry_msgs/msg/Point.msg: float64 x; float64 y; float64 z
geometry_msgs/msg/Vector3.msg: float64 x; float64 y; float64 z
geometry_msgs/msg/Quaternion.msg: float64 x; float64 y; float64 z; float64 w
geometry_msgs/msg/Pose.msg: Point position; Quaternion orientation
geometry_msgs/msg/Twist.msg: Vector3 linear; Vector3 angular
geometry_msgs/msg/Wrench.msg: Vector3 force; Vector3 torque
gazebo_msgs/msg/ContactState.msg: string info; string collision1_name; string collision2_name;
  geometry_msgs/Wrench[] wrenches; geometry_msgs/Wrench total_wrench; geometry_msgs/Vector3[]
  contact_positions; geometry_msgs/Vector3[] contact_normals; float64[] depths
gazebo_msgs/msg/ContactsState.msg: Header header; gazebo_msgs/ContactState[] states
gazebo_msgs/msg/ModelState.msg: string model_name; geometry_msgs/Pose pose; geometry_msgs/Twist
  twist; string reference_frame
gazebo_msgs/msg/ModelStates.msg: string[] name; geometry_msgs/Pose[] pose; geometry_msgs/Twist[]
  twist
gazebo_msgs/msg/LinkState.msg: string link_name; geometry_msgs/Pose pose; geometry_msgs/Twist
  twist; string reference_frame
gazebo_msgs/srv/GetModelState.srv: string model_name; string relative_entity_name; ---; Header
  header; geometry_msgs/Pose pose; geometry_msgs/Twist twist; ANSWER
gazebo_msgs/srv/SetModelState.srv: gazebo_msgs/ModelState model_state; ---; ANSWER
gazebo_msgs/srv/SetLinkState.srv: gazebo_msgs/LinkState link_state; ---; ANSWER
gazebo_msgs/srv/SpawnModel.srv: string model_name; string model_xml; string robot_namespace;
  geometry_msgs/Pose initial_pose; string reference_frame; ---; ANSWER
gazebo_msgs/srv/DeleteModel.srv: string model_name; ---; ANSWER
gazebo_msgs/srv/GetWorldProperties.srv: ---; float64 sim_time; string[] model_names; bool
  rendering_enabled; ANSWER
gazebo_msgs/msg/ODEPhysics.msg: bool auto_disable_bodies; uint32 sor_pgs_precon_iters; uint32
  sor_pgs_iters; float64 sor_pgs_w; float64 sor_pgs_rms_error_tol; float64 contact_surface_layer;
  float64 contact_max_correcting_vel; float64 cfm; float64 erp; uint32 max_contacts
gazebo_msgs/srv/GetPhysicsProperties.srv: ---; float64 time_step; bool pause; float64
  max_update_rate; geometry_msgs/Vector3 gravity; gazebo_msgs/ODEPhysics ode_config; ANSWER
gazebo_msgs/srv/SetPhysicsProperties.srv: float64 time_step; float64 max_update_rate;
  geometry_msgs/Vector3 gravity; gazebo_msgs/ODEPhysics ode_config; ---; ANSWER
gazebo_msgs/msg/LinkStates.msg: string[] name; geometry_msgs/Pose[] pose; geometry_msgs/Twist[]
  twist
gazebo_msgs/srv/GetLinkState.srv: string link_name; string reference_frame; ---;
  gazebo_msgs/LinkState link_state; ANSWER
gazebo_msgs/srv/GetLinkProperties.srv: string link_name; ---; geometry_msgs/Pose com; bool
  gravity_mode; float64 mass; float64 ixx; float64 ixy; float64 ixz; float64 iyy; float64 iyz;
  float64 izz; ANSWER
gazebo_msgs/srv/GetJointProperties.srv: string joint_name; ---; uint8 type; uint8 REVOLUTE=0; uint8
  CONTINUOUS=1; uint8 PRISMATIC=2; uint8 FIXED=3; uint8 BALL=4; uint8 UNIVERSAL=5; float64[]
  damping; float64[] position; float64[] rate; ANSWER
gazebo_msgs/srv/GetModelProperties.srv: string model_name; ---; string parent_model_name; string
  canonical_body_name; string[] body_names; string[] geom_names; string[] joint_names; string[]
  child_model_names; bool is_static; ANSWER
gazebo_msgs/srv/SetModelConfiguration.srv: string model_name; string urdf_param_name; string[]
  joint_names; float64[] joint_positions; ---; ANSWER
gazebo_msgs/srv/ApplyBodyWrench.srv: string body_name; string reference_frame; geometry_msgs/Point
  reference_point; geometry_msgs/Wrench wrench; time start_time; duration duration; ---; ANSWER
gazebo_msgs/srv/ApplyJointEffort.srv: string joint_name; float64 effort; time start_time; duration
  duration; ---; ANSWER
gazebo_msgs/srv/BodyRequest.srv: string body_name; ---
gazebo_msgs/srv/JointRequest.srv: string joint_name; ---"""
DEFINITIONS = {
    name: fields.replace('ANSWER', 'bool success; string status_message').replace('; ', '\n')
    + '\n' for name, fields in (line.split(': ', 1) for line in _DEFINITIONS.replace(
        '\n  ', ' ').strip().splitlines())}
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
