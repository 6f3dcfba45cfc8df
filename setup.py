"""Python packages of img_recog, for catkin_python_setup(). Use catkin, do not run this file."""
from setuptools import find_packages, setup
from catkin_pkg.python_setup import generate_distutils_setup

setup(**generate_distutils_setup(
    packages=find_packages('src'), package_dir={'': 'src'},
    package_data={'img_recog.command_line': ['messages_ja.txt'],
                  'img_recog.nodes.web': ['page_texts.txt', 'static/*']}))
