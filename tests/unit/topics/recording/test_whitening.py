"""What a model leaves out alike at alike speeds: its covariance, and what whitens it."""

import numpy as np
import pytest

from cardan.topics.recording.model_fit import WhiteningFilter, shared_error_patterns

RPM = np.pi / 30


def shared(speed, torque):
    """Covariance (W, W) of what is left out, in variances of one scale of speed."""
    parts = shared_error_patterns(np.array(speed) * RPM, np.array(torque))
    return parts.T @ parts


def test_repeated_speed_has_the_same_shared_error():
    first, again, *_ = shared([480, 480, 300], [3000, 1500, 3000])
    np.testing.assert_array_equal(first, again)
    assert first[0] > 1.5


def test_overrun_and_drive_errors_are_uncorrelated():
    driven, coasting, *_ = shared([480, 480, 300], [3000, -500, 3000])
    assert driven[1] == 0 == coasting[2]
    assert driven[0] == coasting[1] > 0


def test_error_correlation_decreases_with_speed_distance():
    """Neighbours share what goes by quarters of an octave; three octaves off, the common part."""
    own, *others = shared(100 * 2.0 ** np.array([0, 0.125, 0.5, 2.3, 3]), np.full(5, 1e3))[0]
    assert own >= others[0] > 1.2 * others[1]
    assert others[1] > 1.2 * others[2]
    assert others[2] == pytest.approx(others[3], rel=0.1)
    assert others[3] > 0.5


@pytest.mark.parametrize("size", [1e-3, 0.3, 2.0, 50.0])
def test_whitening_filter_decorrelates_errors(size):
    """W (1 + C Cᴴ) Wᴴ = 1, and what is faint is left as it is: to its square, 0.01."""
    rng = np.random.default_rng(5)
    columns = size * (rng.normal(size=(30, 4)) + 1j * rng.normal(size=(30, 4))) / np.sqrt(60)
    white = WhiteningFilter.by(columns)
    covariance = np.eye(30) + columns @ np.conj(columns).T
    W = np.stack([white.of(e) for e in np.eye(30, dtype=complex)], axis=-1)
    left = W @ covariance @ np.conj(W).T
    np.testing.assert_allclose(left, np.eye(30), atol=1e-9 if size > 0.1 else 0.01)
