# The targets of the tests: one for each file of system tests and of rostests, two for the unit tests.
find_package(rostest REQUIRED)
set(test ${CMAKE_CURRENT_SOURCE_DIR}/test)
set(video ${test}/data/bikes.mp4)
add_custom_command(OUTPUT ${video} COMMAND ${PYTHON_EXECUTABLE} ${test}/fetch_video.py ${video})
add_custom_target(${PROJECT_NAME}_video DEPENDS ${video})
add_dependencies(tests ${PROJECT_NAME}_video)

# the system tests of each file separately: several run at a time; a test that waits for ever ends after 1200 s
set(pytest "${PYTHON_EXECUTABLE} -m pytest -p no:cacheprovider --timeout 1200")
file(GLOB tests CONFIGURE_DEPENDS RELATIVE ${test} ${test}/system/test_*.py)
# make starts them in this order: what takes longest first, so that no core is without work at the end
list(INSERT tests 0 system/test_lessons.py unit unit/formats system/test_run.py system/test_page.py system/test_sweep.py system/test_simulator_node.py system/test_sources.py system/test_robots.py system/test_demo.py system/test_run_demo.py system/test_replay.py system/test_testing.py system/test_lockstep.py system/test_follow.py system/test_hosts.py system/test_robot_sensors.py system/test_faults.py)
list(REMOVE_DUPLICATES tests)
# the unit tests in two processes, since one would end last; doctest: the examples in docstrings
set(with_formats "${test}/unit/rendering ${test}/unit/simulation")
set(with_unit "--ignore=${test}/unit/formats --ignore=${test}/unit/rendering --ignore=${test}/unit/simulation --doctest-modules ${CMAKE_CURRENT_SOURCE_DIR}/src/img_recog")
foreach(path ${tests})
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
