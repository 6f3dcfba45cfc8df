# For find_package(xacro) and CATKIN_DEPENDS xacro. Packages of descriptions need no more.
set(xacro_FOUND_CATKIN_PROJECT TRUE)
set(xacro_VERSION 1.14.0)
