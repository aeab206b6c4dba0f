r"""Joints that keep the speed: double cardan and its centring, Persian, Rzeppa, tripod.

Two Hooke joints back to back cancel where the centre piece between them bisects the angle of
the shafts. A double cardan is held there by a centring ball, exactly where the ball sits as
far from one joint as from the other, and only nearly elsewhere. The Persian joint bisects by
its construction, up to large angles; a Rzeppa joint's balls lie in the bisecting plane.
Sources: Seherr-Thoss, Schmelz & Aucktor (2006), ch. 1; derived from the exact chain.
"""

import numpy as np

from cardan.core.arrays import ArrayLike, FloatArray
from cardan.core.errors import DesignError
from cardan.core.lazy_dataclass import dataclass
from cardan.physics.kinematics.joint_chain import ChainRotation, rotate_chain


@dataclass(frozen=True, slots=True, kw_only=True)
class DoubleJointSplit:
    """How a double joint shares its angle, and how long its centre piece must be.

    `front_angle` and `rear_angle` are those of the two Hooke joints, (...) rad; `joint_spacing` is
    between their centres, (...) m.
    """

    front_angle: FloatArray
    rear_angle: FloatArray
    joint_spacing: FloatArray


def split_joint_angle(beta: ArrayLike, *, front: ArrayLike, rear: ArrayLike) -> DoubleJointSplit:
    r"""Share of each half of a double cardan whose shafts meet in its centring ball.

    The centring point and the two joint centres are a triangle:
    $$\tan\beta_1 = \frac{r\sin\beta}{f + r\cos\beta},\qquad \beta_2 = \beta - \beta_1$$

    Parameters
    ----------
    beta : (...) rad
        Angle between the shafts.
    front, rear : (...) m
        f and r, from the centring point to the front and to the rear joint's centre. Equal
        where the joint is well centred; the difference is the centring error.

    Raises
    ------
    DesignError
        If a distance is not above 0.
    """
    beta, f, r = (np.asarray(v, dtype=float) for v in (beta, front, rear))
    if not (np.all(f > 0) and np.all(r > 0)):
        msg = "a centring point must lie between the joints of a double cardan"
        raise DesignError(msg)
    first = np.arctan2(r * np.sin(beta), f + r * np.cos(beta))
    return DoubleJointSplit(
        front_angle=first,
        rear_angle=beta - first,
        joint_spacing=np.sqrt(f**2 + r**2 + 2 * f * r * np.cos(beta)),
    )


def rotate_double_cardan(
    beta: ArrayLike, *, front: ArrayLike, rear: ArrayLike, phase: ArrayLike = 0.0, samples: int = 64
) -> ChainRotation:
    """Turn a double cardan once, exactly: members are shaft, centre piece, shaft.

    Parameters are those of `split_joint_angle`; `phase` (...) rad is an assembly error of the
    centre piece, whose pin axes should be parallel.
    """
    shared = split_joint_angle(beta, front=front, rear=rear)
    first, total, phase = np.broadcast_arrays(
        shared.front_angle, shared.front_angle + shared.rear_angle, np.asarray(phase, float)
    )
    slopes = np.stack([np.zeros_like(first), first, total], axis=-1)
    d = np.stack([np.cos(slopes), np.sin(slopes), np.zeros_like(slopes)], axis=-1)
    return rotate_chain(d, phases=phase[..., None], samples=samples)


def irregularity_by_centring_distances(
    beta: ArrayLike, *, front: ArrayLike, rear: ArrayLike
) -> FloatArray:
    """Speed swing (...) 1 of a double cardan, (ω₂max - ω₂min) / ω₁, in closed form.

    In one plane the ratios of the halves, β₁ and β₂ with pins crossed, make the ratio of one
    joint with cos β = cos β₁ / cos β₂: the swing is sin β tan β of that joint.
    """
    shared = split_joint_angle(beta, front=front, rear=rear)
    # The joint whose angle is larger wins; the other form of the ratio is its inverse.
    ratio = np.cos(shared.front_angle) / np.cos(shared.rear_angle)
    return np.abs(1 / ratio - ratio)


def rotate_persian_joint(
    beta: ArrayLike, *, error: ArrayLike = 0.0, samples: int = 64
) -> ChainRotation:
    """Turn a Persian joint: two Hooke joints whose centre line bisects, up to β of 135 deg.

    `error` (...) rad is how far the centre line is off the bisector; 0 as designed.
    """
    beta, error = np.broadcast_arrays(np.asarray(beta, float), np.asarray(error, float))
    slopes = np.stack([np.zeros_like(beta), beta / 2 + error, beta], axis=-1)
    d = np.stack([np.cos(slopes), np.sin(slopes), np.zeros_like(slopes)], axis=-1)
    return rotate_chain(d, phases=np.zeros((*beta.shape, 1)), samples=samples)


def rzeppa_angle_lead(
    theta: ArrayLike, *, beta: ArrayLike, error: ArrayLike = 0.0, balls: int = 6
) -> FloatArray:
    r"""Lead (...) rad of a Rzeppa joint whose ball plane is `error` rad off the bisector.

    One ball leads by $\sum_n (q^n/n) \sin 2n\theta$ with q = -tan(β/2) tan ε. The cage
    holds all of them to one rotation, their mean: of N balls equally spaced only orders that are
    multiples of N are left. Six balls off by a degree at 30 deg
    give 3.4e-8 rad six times a turn, where one would give 4.7e-3 twice.

    Parameters
    ----------
    theta, beta, error : (...) rad
        Input angle, joint angle, and angle of the ball plane off the bisector.
    balls
        N, even: 2 opposite ones do what one does.

    Notes
    -----
    Equal balls and tracks, without clearance or load. Source: derived; the mean is what
    equal contact stiffnesses give.
    """
    if balls < 2 or balls % 2:
        msg = f"balls of a Rzeppa joint stand opposite each other, so give 2, 4, 6, not {balls}"
        raise ValueError(msg)
    theta, b, e = np.broadcast_arrays(*(np.asarray(v, float) for v in (theta, beta, error)))
    q = -np.tan(b / 2) * np.tan(e)
    size, turned = q ** (balls // 2), balls * theta
    return 2 / balls * np.arctan2(size * np.sin(turned), 1 - size * np.cos(turned))


def front_cross_to_centring_point_distance(
    beta: ArrayLike, *, length: ArrayLike, ball: ArrayLike
) -> FloatArray:
    r"""Distance f (...) m of a double cardan's front cross from its centring point.

    The centre piece keeps its length L, the ball its distance r from the rear cross along the
    driven shaft: $f = -r \cos\beta + \sqrt{L^2 - r^2 \sin^2\beta}$, which is r where the shafts
    are straight and r = L/2, and less at any angle.
    """
    beta, L, r = (np.asarray(v, dtype=float) for v in (beta, length, ball))
    if not np.all((r > 0) & (r < L)):
        msg = "the centring ball of a double cardan must lie between its crosses"
        raise DesignError(msg)
    return -r * np.cos(beta) + np.sqrt(L**2 - (r * np.sin(beta)) ** 2)


def double_cardan_irregularity(
    beta: ArrayLike, *, length: ArrayLike, ball: ArrayLike
) -> FloatArray:
    """Speed swing (...) 1 of a real double cardan, whose centring moves with the angle.

    `irregularity_by_centring_distances` with the f of `front_cross_to_centring_point_distance`.
    With the ball in the middle, r = L/2, it is 0.19 % at 20 deg and 0.98 % at 30.

    Examples
    --------
    >>> at = np.radians([20.0, 30.0])
    >>> (100 * double_cardan_irregularity(at, length=0.08, ball=0.04)).round(4)
    array([0.1889, 0.9774])
    """
    front = front_cross_to_centring_point_distance(beta, length=length, ball=ball)
    return irregularity_by_centring_distances(beta, front=front, rear=ball)


def tripod_orbit_radius(beta: ArrayLike, *, radius: ArrayLike) -> FloatArray:
    """Radius (...) m of the circle in which a tripod's centre goes round three times a turn.

    e = r (1/cos β - 1)/2, with r from the axis to the middle of the rollers. The ratio stays 1
    as long as the driven shaft may follow. Source: Seherr-Thoss et al. (2006), ch. 1.

    Examples
    --------
    >>> float((1e3 * tripod_orbit_radius(np.radians(10), radius=20e-3)).round(5))
    0.15427
    """
    beta, r = np.asarray(beta, dtype=float), np.asarray(radius, dtype=float)
    return r * (1 / np.cos(beta) - 1) / 2
