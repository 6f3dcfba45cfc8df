"""Python packages of img_recog, for catkin_python_setup(); build with catkin, not by hand."""
from setuptools import setup
from catkin_pkg.python_setup import generate_distutils_setup

setup(**generate_distutils_setup(
    packages=[
        'img_recog',
        'img_recog.camera',
        'img_recog.nodes',
        'img_recog.recognition',
        'img_recog.simulation',
        'img_recog.teleoperation',
    ],
    package_dir={'': 'src'},
))
