"""Confidence intervals."""
import pytest

from img_recog.batch.statistics import wilson


@pytest.mark.parametrize('successes, runs, interval', [
    # from R: prop.test(correct = FALSE)
    (0, 10, (0.0, 0.2775)), (5, 10, (0.2366, 0.7634)), (50, 50, (0.9287, 1.0)),
    (81, 263, (0.2553, 0.3662))])
def test_wilson(successes, runs, interval):
    assert wilson(successes, runs) == pytest.approx(interval, abs=1e-4)
