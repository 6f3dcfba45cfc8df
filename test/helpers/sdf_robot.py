"""A robot of an SDF with the plugins of gazebo_ros, and a model that only has a scanner."""
WALL = ('<model name="wall"><static>1</static><pose>3 0 0.5 0 0 0</pose><link name="l"><collision '
        'name="c"><geometry><box><size>0.2 9 1</size></box></geometry></collision></link></model>')
RAY = ('<update_rate>10</update_rate><ray><scan><horizontal><samples>1</samples></horizontal>'
       '</scan><range><min>0.12</min><max>8</max></range></ray><plugin name="l" '
       'filename="libgazebo_ros_laser.so"><topicName>{}</topicName></plugin>')
_INERTIA = '<inertial><mass>{0}</mass><inertia><ixx>{1}</ixx><iyy>{1}</iyy><izz>{1}</izz>' \
    '</inertia></inertial>'
_WHEEL = ('<link name="{0}"><pose>0.03 {1} 0.033 -1.5707963 0 0</pose>'
          + _INERTIA.format(0.1, 0.0001) + '<collision name="c"><geometry><cylinder><radius>0.033'
          '</radius><length>0.018</length></cylinder></geometry></collision></link><joint '
          'name="{0}_joint" type="revolute"><parent>base</parent><child>{0}</child><axis><xyz>'
          '0 0 1</xyz></axis></joint>')
# its root link is 5 cm above the ground
ROBOT = (
    '<model name="bot"><pose>-1 0 0 0 0 0</pose><link name="base"><pose>0 0 0.05 0 0 0</pose>'
    + _INERTIA.format(1, 0.01) + '<collision name="c"><geometry><box><size>0.2 0.1 0.05</size>'
    '</box></geometry></collision><collision name="caster"><pose>-0.08 0 -0.035 0 0 0</pose>'
    '<geometry><sphere><radius>0.015</radius></sphere></geometry><surface><friction><ode><mu>0'
    '</mu></ode></friction></surface></collision><sensor name="lidar" type="ray"><pose>0 0 0.1 0 '
    '0 0</pose>' + RAY.format('front') + '</sensor><sensor name="imu" type="imu"><update_rate>100'
    '</update_rate><plugin name="i" filename="libgazebo_ros_imu_sensor.so"><topicName>tilt'
    '</topicName></plugin></sensor></link>' + _WHEEL.format('left', 0.08)
    + _WHEEL.format('right', -0.08) + '<plugin name="d" filename="libgazebo_ros_diff_drive.so">'
    '<leftJoint>left_joint</leftJoint><rightJoint>right_joint</rightJoint><wheelSeparation>0.16'
    '</wheelSeparation><wheelDiameter>0.066</wheelDiameter><robotBaseFrame>base</robotBaseFrame>'
    '<odometryFrame>bot_odom</odometryFrame>{}</plugin><plugin name="j" '
    'filename="libgazebo_ros_joint_state_publisher.so"/></model>')
POST = ('<model name="post"><static>1</static><pose>0 3 0.5 0 0 0</pose><link name="l"><sensor '
        'name="watch" type="ray">' + RAY.format('watch') + '</sensor><sensor name="bare" '
        'type="ray"/></link></model>')
