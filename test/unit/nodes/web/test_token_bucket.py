"""How much may come in at once, and in the long run."""
from img_recog.nodes.web.token_bucket import TokenBucket


def test_a_burst_at_once_and_a_rate_in_the_long_run():
    bucket = TokenBucket(2.0, 2.0)
    # two at once, one after half a second, and no more than two later
    assert [bucket.take(1, waited_s) for waited_s in (0.0, 0.0, 0.5, 100.0, 0.0, 0.1)] == [
        True, True, True, True, True, False]


def test_several_at_once():
    bucket = TokenBucket(10.0, 1.0)
    assert [bucket.take(count, 0.0) for count in (4, 6, 1)] == [True, True, False]
