# Makes $(find xacro) find the package in this devel space.
case :$ROS_PACKAGE_PATH: in
  *:$CATKIN_ENV_HOOK_WORKSPACE/share:*) ;;
  *) export ROS_PACKAGE_PATH="$ROS_PACKAGE_PATH:$CATKIN_ENV_HOOK_WORKSPACE/share" ;;
esac
