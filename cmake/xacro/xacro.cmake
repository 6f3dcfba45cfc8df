# Debian has no xacro of ROS 1, which descriptions of robots want: find_package(xacro) and, in launch
# files, $(find xacro)/xacro; and the command xacro. So the devel space gets a package of that name,
# which runs pip's.
find_package(xacro QUIET)
string(FIND "${xacro_DIR}" "${CATKIN_DEVEL_PREFIX}/" is_ours)
if(NOT xacro_FOUND OR is_ours EQUAL 0)
  set(folder "${CMAKE_CURRENT_SOURCE_DIR}/cmake/xacro")
  set(space "${CATKIN_DEVEL_PREFIX}/share/xacro")
  configure_file(${folder}/package.xml ${space}/package.xml COPYONLY)
  configure_file(${folder}/xacroConfig.cmake ${space}/cmake/xacroConfig.cmake COPYONLY)
  configure_file(${folder}/xacro.in ${CMAKE_CURRENT_BINARY_DIR}/catkin_generated/xacro @ONLY)
  # bin/ is in the PATH before pip's own command, which does not find ROS 1's packages
  foreach(destination "${space}" "${CATKIN_DEVEL_PREFIX}/bin")
    file(COPY ${CMAKE_CURRENT_BINARY_DIR}/catkin_generated/xacro DESTINATION ${destination}
      FILE_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
  endforeach()
  catkin_add_env_hooks(img_recog_xacro SHELLS sh DIRECTORY ${folder} SKIP_INSTALL)
endif()
