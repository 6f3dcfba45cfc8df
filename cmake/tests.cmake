# The targets of the tests: one for each long file of system tests and each rostest, two for the unit tests, and
# some for the other system tests.
find_package(rostest REQUIRED)
set(test ${CMAKE_CURRENT_SOURCE_DIR}/test)
set(video ${test}/data/bikes.mp4)
add_custom_command(OUTPUT ${video} COMMAND ${PYTHON_EXECUTABLE} ${test}/fetch_video.py ${video})
add_custom_target(${PROJECT_NAME}_video DEPENDS ${video})
add_dependencies(tests ${PROJECT_NAME}_video)

# several targets run at a time; a test that waits for ever ends after 1200 s
set(pytest "${PYTHON_EXECUTABLE} -m pytest -p no:cacheprovider --timeout 1200")
# the unit tests in two targets, since one would end last; doctest: the examples in docstrings
set(with_formats "${test}/unit/rendering ${test}/unit/simulation")
set(with_unit "--ignore=${test}/unit/formats --ignore=${test}/unit/rendering --ignore=${test}/unit/simulation --doctest-modules ${CMAKE_CURRENT_SOURCE_DIR}/src/img_recog")
# make starts them in this order: what takes longest first, so that no core is without work at the end
set(targets system/test_lessons.py unit unit/formats system/test_run.py system/test_page.py system/test_sweep.py system/test_simulator_node.py system/test_sources.py system/test_robots.py system/test_demo.py system/test_run_demo.py system/test_replay.py system/test_testing.py system/test_lockstep.py system/test_follow.py system/test_hosts.py system/test_robot_sensors.py system/test_faults.py system/test_documentation.py system/test_driving.py system/test_reliability.py system/test_cluster.py system/test_page_navigation.py system/test_gazebo_msgs.py system/test_workspace.py system/test_page_layout.py system/test_several_robots.py)
file(GLOB others CONFIGURE_DEPENDS RELATIVE ${test} ${test}/system/test_*.py)
list(REMOVE_ITEM others ${targets})
# the first of six files gives the target its name: each start of pytest takes a second
foreach(path ${others})
  list(FIND others ${path} number)
  math(EXPR number "${number} % 6")
  if(number EQUAL 0)
    list(APPEND targets ${path})
    get_filename_component(first ${path} NAME_WE)
  else()
    set(with_${first} "${with_${first}} ${test}/${path}")
  endif()
endforeach()
foreach(path ${targets})
  get_filename_component(name ${path} NAME_WE)
  string(REGEX MATCH "^[a-z]+" kind ${path})
  set(results "${CATKIN_TEST_RESULTS_DIR}/${PROJECT_NAME}/pytest-${kind}-${name}.xml")
  catkin_run_tests_target(pytest ${kind}_${name} pytest-${kind}-${name}.xml
    COMMAND "${pytest} --junit-xml=${results} ${test}/${path} ${with_${name}}")
endforeach()

# only in the devel space: tests are not installed
file(WRITE ${CATKIN_DEVEL_PREFIX}/${CATKIN_GLOBAL_PYTHON_DESTINATION}/img_recog_helpers/__init__.py
  "__path__ = ['${test}/helpers']\n")
file(GLOB nodes CONFIGURE_DEPENDS ${test}/rostest/*.py)
foreach(PYTHON_SCRIPT ${nodes})
  get_filename_component(node ${PYTHON_SCRIPT} NAME_WE)
  configure_file(${catkin_EXTRAS_DIR}/templates/script.py.in
    ${CATKIN_DEVEL_PREFIX}/${CATKIN_PACKAGE_BIN_DESTINATION}/${node}.py @ONLY)
endforeach()
foreach(name colors compressed live recorded slow video)
  add_rostest(test/rostest/${name}.test)
endforeach()
