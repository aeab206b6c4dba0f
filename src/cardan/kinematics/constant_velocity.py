r"""Joints that keep the speed: the double cardan and how well it is centred, Persian, Rzeppa.

Two Hooke joints back to back cancel where the centre piece between them bisects the angle of
the shafts. A double cardan is held there by a centring ball, exactly where the ball sits as
far from one joint as from the other, and only nearly elsewhere. The Persian joint bisects by
its construction, up to large angles; a Rzeppa joint's balls lie in the bisecting plane.
Sources: Seherr-Thoss, Schmelz & Aucktor (2006), ch. 1; derived from the exact chain.
"""

from dataclasses import dataclass

import numpy as np

from cardan.base.arrays import ArrayLike, FloatArray
from cardan.base.errors import DesignError
from cardan.kinematics.chain import Turn, turn


@dataclass(frozen=True, slots=True, kw_only=True)
class Halves:
    """How a double joint shares its angle, and how long its centre piece must be.

    `front` and `rear` are the angles of the two Hooke joints, (...) rad; `distance` is
    between their centres, (...) m.
    """

    front: FloatArray
    rear: FloatArray
    distance: FloatArray


def halves(beta: ArrayLike, *, front: ArrayLike, rear: ArrayLike) -> Halves:
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
    return Halves(
        front=first, rear=beta - first, distance=np.sqrt(f**2 + r**2 + 2 * f * r * np.cos(beta))
    )


def double_cardan(
    beta: ArrayLike, *, front: ArrayLike, rear: ArrayLike, phase: ArrayLike = 0.0, samples: int = 64
) -> Turn:
    """Turn a double cardan once, exactly: members are shaft, centre piece, shaft.

    Parameters are those of `halves`; `phase` (...) rad is an assembly error of the centre
    piece, whose pin axes should be parallel.
    """
    shared = halves(beta, front=front, rear=rear)
    first, total, phase = np.broadcast_arrays(
        shared.front, shared.front + shared.rear, np.asarray(phase, float)
    )
    slopes = np.stack([np.zeros_like(first), first, total], axis=-1)
    d = np.stack([np.cos(slopes), np.sin(slopes), np.zeros_like(slopes)], axis=-1)
    return turn(d, phases=phase[..., None], samples=samples)


def centring_irregularity(beta: ArrayLike, *, front: ArrayLike, rear: ArrayLike) -> FloatArray:
    """Speed swing (...) 1 of a double cardan, (ω₂max - ω₂min) / ω₁, in closed form.

    In one plane the ratios of the halves, β₁ and β₂ with pins crossed, make the ratio of one
    joint with cos β = cos β₁ / cos β₂: the swing is sin β tan β of that joint.
    """
    shared = halves(beta, front=front, rear=rear)
    # The joint whose angle is larger wins; the other form of the ratio is its inverse.
    ratio = np.cos(shared.front) / np.cos(shared.rear)
    return np.abs(1 / ratio - ratio)


def persian(beta: ArrayLike, *, error: ArrayLike = 0.0, samples: int = 64) -> Turn:
    """Turn a Persian joint: two Hooke joints whose centre line bisects, up to β of 135 deg.

    `error` (...) rad is how far the centre line is off the bisector; 0 as designed.
    """
    beta, error = np.broadcast_arrays(np.asarray(beta, float), np.asarray(error, float))
    slopes = np.stack([np.zeros_like(beta), beta / 2 + error, beta], axis=-1)
    d = np.stack([np.cos(slopes), np.sin(slopes), np.zeros_like(slopes)], axis=-1)
    return turn(d, phases=np.zeros((*beta.shape, 1)), samples=samples)


def bisecting_ratio(theta: ArrayLike, *, beta: ArrayLike, error: ArrayLike = 0.0) -> FloatArray:
    r"""Speed ratio of a ball joint (Rzeppa) whose ball plane is `error` rad off the bisector.

    Balls in a plane whose normal makes angles β/2 ± ε with the shafts carry the rotation as
    two Hooke-like projections: with ε = 0 the ratio is exactly 1 at every θ, which is the
    ideal Rzeppa joint; friction and clearance of real ones are not modelled.

    Parameters
    ----------
    theta : (...) rad
        Rotation of the driving shaft, from the plane of the shafts.
    beta, error : (...) rad
        Shaft angle, and how far the ball plane is off the bisecting plane.
    """
    theta, b, e = np.broadcast_arrays(*(np.asarray(v, float) for v in (theta, beta, error)))
    c1, c2 = np.cos(b / 2 + e), np.cos(b / 2 - e)
    # A ball at θ on the driving side has tan ψ = tan θ · c1 in the plane, then / c2.
    c = c1 / c2
    return c / (np.cos(theta) ** 2 + c**2 * np.sin(theta) ** 2)
