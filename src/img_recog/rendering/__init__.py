"""Images of a scene, by OpenGL without a display. Knows neither PyBullet nor ROS."""
