"""Nodes end when they are stopped, whatever happened just before."""
from img_recog_testing.stops import stop_after_the_images


def test_recognitions_end_whose_images_have_just_stopped(shared_ros):
    stop_after_the_images(shared_ros, count=3, seed=1, deadline_s=30.0)
