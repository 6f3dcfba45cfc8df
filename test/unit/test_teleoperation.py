"""Target velocities by keys, and sent velocities by targets."""
import pytest

from img_recog.teleoperation import TeleopSettings, VelocityProfile


def pressed(keys, profile=None):
    profile = profile or VelocityProfile()
    for key in keys:
        assert profile.press(key) is True
    return profile


def targets(profile):
    return profile.target_linear, profile.target_angular


@pytest.mark.parametrize('keys, linear, angular', [
    ('', 0.0, 0.0), ('w', 0.01, 0.0), ('x', -0.01, 0.0), ('a', 0.0, 0.1), ('d', 0.0, -0.1),
    ('wx', 0.0, 0.0), ('ad', 0.0, 0.0), ('wwa', 0.02, 0.1), ('xdd', -0.01, -0.2),
    # exactly ten steps
    ('w' * 10, 0.1, 0.0), ('x' * 10, -0.1, 0.0), ('a' * 10, 0.0, 1.0), ('d' * 10, 0.0, -1.0)])
def test_keys_move_the_target_by_a_step(keys, linear, angular):
    profile = pressed(keys)
    assert targets(profile) == (linear, angular)
    sent = [profile.tick() for _ in range(20)]
    assert sent[0] == pytest.approx((linear / abs(linear) * 0.005 if linear else 0.0,
                                     angular / abs(angular) * 0.05 if angular else 0.0))
    assert sent[-1] == (linear, angular)


@pytest.mark.parametrize('key, linear, angular', [
    ('w', 0.22, 0.0), ('x', -0.22, 0.0), ('a', 0.0, 2.84), ('d', 0.0, -2.84)])
def test_targets_end_at_the_limits_of_the_burger(key, linear, angular):
    profile = pressed(key * 100)
    assert targets(profile) == (linear, angular)
    for _ in range(200):
        sent = profile.tick()
        assert abs(sent[0]) <= 0.22 and abs(sent[1]) <= 2.84
    assert sent == (linear, angular)


def test_sent_value_approaches_the_target_by_half_a_step_per_tick():
    profile = pressed('wwaa')
    assert [profile.tick() for _ in range(5)] == [
        (0.005, 0.05), (0.01, 0.1), (0.015, 0.15), (0.02, 0.2), (0.02, 0.2)]


def test_sent_value_decreases_through_zero():
    profile = pressed('w')
    profile.tick(), profile.tick()
    pressed('xx', profile)
    assert [profile.tick()[0] for _ in range(5)] == [0.005, 0.0, -0.005, -0.01, -0.01]


def test_sent_value_does_not_overshoot_a_limit_that_is_not_a_multiple_of_the_step():
    profile = VelocityProfile(TeleopSettings(linear_step=0.04, max_linear_velocity=0.05))
    pressed('ww', profile)
    assert profile.target_linear == 0.05
    assert [profile.tick()[0] for _ in range(4)] == [0.02, 0.04, 0.05, 0.05]


@pytest.mark.parametrize('key', ['s', ' '])
def test_stop_keys_stop_at_once(key):
    profile = pressed('w' * 22 + 'a' * 28)
    for _ in range(20):
        profile.tick()
    assert profile.tick() == (0.105, 1.05)
    pressed(key, profile)
    assert targets(profile) == (0.0, 0.0)
    assert profile.tick() == (0.0, 0.0)


@pytest.mark.parametrize('key', ['q', 'W', 'S', '\n', '\x1b', '', '\ufffd', 'ww'])
def test_other_keys_are_ignored(key):
    profile = pressed('wa')
    profile.tick()
    assert profile.press(key) is False
    assert targets(profile) == (0.01, 0.1)
    assert profile.tick() == (0.01, 0.1)


def test_steps_are_those_of_the_settings():
    profile = VelocityProfile(TeleopSettings(linear_step=0.02, angular_step=0.5,
                                             max_linear_velocity=1.0, max_angular_velocity=1.0))
    assert targets(pressed('waaa', profile)) == (0.02, 1.0)
    assert profile.tick() == (0.01, 0.25)
