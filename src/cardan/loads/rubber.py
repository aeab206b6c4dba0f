r"""A line on its rubber: how it moves and what its bearings carry when it is shaken.

Statics (`cardan.loads.statics`) tells what a rigid support would feel. A centre bearing hangs
in rubber, so the line has modes of 8 to 25 Hz, and what comes twice a turn crosses them at a
few hundred revolutions a minute, in first gear.

Small motions about where the line runs. A hung shaft tilts by D_k across itself, so joint
k+1 moves by D_1 + ... + D_k; the axle holds the last joint, and the last shaft moves across
itself alone. Each tube bends in sines between its joints besides. With rubber that loses η
of its energy, the torque T and the speed Ω,

$$[K (1 + i η) + T K_T + i W G(Ω) - W^2 M]\, q = f$$

The crosses' moments follow the motion, and so f does: their mean part is K_T, and their part
at order 2 ties orders 0, 2 and 4 to each other (`Suspended.balanced`).

At W = 0 and small torque the bearings' forces are those of statics, to rounding; so they are
at any speed where bearings and shafts are rigid.

The torque is a stiffness too: the crosses' moments turn with the shafts. Its energy is
(T/2) ∫ d · (e × de), e the tilts along the line, which jump at the joints.

Source: derived from first principles; forced motion confirmed with independent multibody
engines.
"""

from collections.abc import Callable, Sequence
from dataclasses import fields, replace
from functools import cached_property
from math import pi
from typing import Any, Literal, TypeAlias

import numpy as np

from cardan.base.arrays import ArrayLike, ComplexArray, FloatArray, distinct, stacked
from cardan.base.frozen import dataclass
from cardan.base.small import leading, solve, stretch, stretches, trailing, wide
from cardan.kinematics.chain import Turn, cross
from cardan.loads.shaken import Shaken
from cardan.model.layout import Layout, unit
from cardan.model.parts import Line
from cardan.model.seat import Seat

LOSS = 0.1
"""Loss factor of rubber that nobody gives, assumed: mounts have 0.08 to 0.2."""

SINES = 1
"""Sines in which each tube bends between its joints: its second one is above any order 2."""

_Own: TypeAlias = Callable[[FloatArray], FloatArray]
"""What takes from arrays (..., N, N) those of the cases that are solved."""

RIGID = 1e17
"""N/m, of a bearing that is said to be rigid: no shaft moves it by what a force would show."""


def _gauss(count: int) -> tuple[FloatArray, FloatArray]:
    """Return places on [0, 1] and weights that integrate polynomials up to 2 `count` - 1.

    Golub and Welsch (1969): eigenvalues of the Legendre polynomials' recurrence.
    """
    k = np.arange(1, count)
    beside = np.diag(k / np.sqrt(4.0 * k**2 - 1), 1)
    places, vectors = np.linalg.eigh(beside + beside.T)
    return (1 + places) / 2, vectors[0] ** 2


_XI, _WEIGHT = _gauss(6)


@dataclass(frozen=True, kw_only=True)
class Motion:
    """How a line on rubber moves at one order: complex amplitudes a, the motion Re a e^{iWt}.

    Attributes
    ----------
    coordinates : (..., N) m
    bearing_forces : (..., n-2, 3) N
        Force of each hung shaft on its centre bearing, in the layout's frame.
    """

    coordinates: ComplexArray
    bearing_forces: ComplexArray


@dataclass(frozen=True, kw_only=True)
class Modes:
    """Modes of a line on its bearings, slowest first, without loss; cases on leading axes.

    Attributes
    ----------
    frequency : (..., m) rad/s
    damping : (..., m) 1
        Share of critical damping that the rubber's loss makes.
    bending : (..., m) 1
        Share of the energy that bends tubes; the rest is in the rubber.
    bracket : (..., m) 1
        Share of the energy that bends brackets.
    flanges : (..., m) 1
        Share of the energy in what holds the flanges.
    upright, axial : (..., m) 1
        Shares of the rubber's energy that are vertical, and along the shafts; the rest is level.
    travel : (..., m, n-2) 1
        How far the bearings go, the largest 1, with signs along its own direction.
    """

    frequency: FloatArray
    damping: FloatArray
    bending: FloatArray
    bracket: FloatArray
    flanges: FloatArray
    upright: FloatArray
    axial: FloatArray
    travel: FloatArray

    @property
    def unmoved(self) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
        """Whether no joint shakes a mode, (..., m): one on rubber along the shaft, which stays."""
        return (self.axial > 0.5) & (self.bending + self.bracket + self.flanges < 0.5)

    def names(self, *case: int) -> list[str]:
        """Return what each mode of a case is called.

        Bounce, lateral, pitch, yaw, axial on rubber; bending, bracket, flange by what gives most.

        Bounce and pitch are upright, lateral and yaw level: the bearings together, or against
        each other. In an axial one a bracket goes to and fro along the shaft that stays.
        """
        of = (self.bending, self.bracket, self.flanges, self.upright, self.axial, self.travel)
        return [_named(*values) for values in zip(*(v[case] for v in of), strict=True)]


def _named(
    bent: float, given: float, held: float, up: float, along: float, going: FloatArray
) -> Literal["bracket", "bending", "flange", "bounce", "lateral", "pitch", "yaw", "axial"]:
    """Return what a mode is called, by shares of its energy and how the bearings go."""
    rubber = 1 - bent - given - held
    if held > max(bent, given, rubber):
        return "flange"
    if given > max(bent, rubber):
        return "bracket"
    if bent > rubber:
        return "bending"
    level = 1 - up - along
    if along > max(up, level):
        return "axial"
    together = bool((going > -0.1).all() or (going < 0.1).all())
    if up > level:
        return "bounce" if together else "pitch"
    return "lateral" if together else "yaw"


@dataclass(frozen=True, kw_only=True)
class Suspended:
    """A line in N coordinates of small motion; cases on leading axes, n-1 shafts.

    Attributes
    ----------
    mass, bending, gyroscopic, torsion : (..., N, N)
        kg; N/m of the tubes; kg for each rad/s of speed; N/m for each N m of torque.
    bearing : (..., n-2, 3, N)
        Motion of each shaft in its bearing: up, sideways and along the shaft.
    frame : (..., n-2, 3, 3)
        Those three directions, in rows.
    stiffness : (..., n-2, 3) N/m
        Infinite where rigid, 0 where free.
    loss : (..., n-2) 1
    front, rear : (..., n-1, 3, N)
        Motion of the ends of each shaft.
    front_tilt, rear_tilt : (..., n-1, 3, N) 1/m
        Change of direction of the ends of each shaft.
    along : (..., n-1, 3)
        Directions of the shafts.
    brackets, brackets_lost : (..., N, N)
        N/m of the brackets that bearings hang in (`mounted`), and what they lose; None where
        they are rigid.
    flanges, flanges_lost : (..., N, N)
        The same of what holds the first and the last joint.
    seats
        How many of the coordinates, the last ones, are modes of brackets.
    """

    mass: FloatArray
    bending: FloatArray
    gyroscopic: FloatArray
    torsion: FloatArray
    bearing: FloatArray
    frame: FloatArray
    stiffness: FloatArray
    loss: FloatArray
    front: FloatArray
    rear: FloatArray
    front_tilt: FloatArray
    rear_tilt: FloatArray
    along: FloatArray
    brackets: FloatArray | None = None
    brackets_lost: FloatArray | None = None
    flanges: FloatArray | None = None
    flanges_lost: FloatArray | None = None
    seats: int = 0

    def pushed(self, moments: ComplexArray) -> ComplexArray:
        """Return what crosses' moments (..., n, 3) N m do on the coordinates, (..., N) N."""
        ahead = cross(moments[..., :-1, :], self.along)
        behind = cross(moments[..., 1:, :], self.along)
        both = np.concatenate([ahead, -behind], axis=-2)
        return (both.reshape(*both.shape[:-2], 1, -1) @ self._tilts)[..., 0, :].astype(complex)

    def moved(
        self,
        forces: ArrayLike,
        *,
        frequency: ArrayLike = 0.0,
        speed: ArrayLike = 0.0,
        torque: ArrayLike = 0.0,
    ) -> Motion:
        """Return how forces (..., N) on the coordinates move the line at a frequency.

        Parameters
        ----------
        frequency, speed : (...) rad/s
            Of the forces, W; of the line, Ω. At W = 0 rubber loses nothing.
        torque : (...) N m
            Signed, for the stiffness it makes.
        """
        each = self.moved_by_each(
            np.asarray(forces)[..., None, :], frequency=frequency, speed=speed, torque=torque
        )
        return Motion(
            coordinates=each.coordinates[..., 0, :],
            bearing_forces=each.bearing_forces[..., 0, :, :],
        )

    def moved_by_each(
        self,
        forces: ArrayLike,
        *,
        frequency: ArrayLike = 0.0,
        speed: ArrayLike = 0.0,
        torque: ArrayLike = 0.0,
    ) -> Motion:
        """Return the same for R forces by themselves, (..., R, N): motions (..., R, ...)."""
        W, omega, T = (np.asarray(v, dtype=float) for v in (frequency, speed, torque))
        right = leading(np.asarray(forces, dtype=complex).mT, of=2)
        lead = np.broadcast_shapes(right.shape[2:], W.shape, omega.shape, T.shape, self.first.cases)
        moved = np.empty((*right.shape[:2], *lead), dtype=complex)
        right = wide(right, len(lead), of=2)
        asked = [np.broadcast_to(v, lead) for v in (W, omega, T)]
        for some in stretches(lead):
            whole = self.first.some(some, len(lead)).at(*(stretch(v, some) for v in asked))
            stretch(moved, some)[...] = solve(whole, stretch(right, some))
        return self._motion(trailing(moved, of=2).mT, np.sign(W), each=True)

    def still(self, forces: ComplexArray | FloatArray) -> ComplexArray:
        """Return where forces (..., N) that do not move with the line hold it, (..., N) m."""
        return np.linalg.solve(self._held[0], forces[..., None])[..., 0].astype(complex)

    def borne(self, forces: ComplexArray) -> ComplexArray:
        """Return what bearings carry, (..., n-2, 3) N, where forces (..., N) only hold still."""
        local = (self._share @ forces[..., None])[..., 0]
        return (local.reshape(*local.shape[:-1], -1, 1, 3) @ self.frame)[..., 0, :]

    def given(
        self, forces: ArrayLike, *, lossy: ArrayLike = 0.0, each: bool = False
    ) -> ComplexArray:
        """Return how far rubber gives across the shafts, (..., n-2, 3) m, under forces on it in N.

        In the layout's frame, as the forces; `each` of several, (..., R, n-2, 3). `lossy` (...)
        is 1 where the rubber's loss counts, 0 where nothing shakes. What it gives along the shaft
        is left out, and so is a bracket that is told apart.
        """
        frame, gives = self.frame, self.gives.reshape(*self.gives.shape[:-1], -1, 3)
        gives = gives / (
            1 + 1j * np.asarray(lossy, dtype=float)[..., None, None] * self.loss[..., None]
        )
        if each:
            frame, gives = frame[..., None, :, :, :], gives[..., None, :, :]
        local = (frame @ np.asarray(forces)[..., None])[..., 0] * gives
        return (local[..., None, :] @ frame)[..., 0, :].astype(complex)

    def ends(self, motions: ComplexArray) -> ComplexArray:
        """Return how far motions (..., R, N) take the ends of shafts, (..., R, n-1, 2, 3) m."""
        moved = motions @ self._ends.mT
        return moved.reshape(*moved.shape[:-1], -1, 2, 3)

    def brought(self, weights: FloatArray) -> FloatArray:
        """Return how much coordinates move of the ends of shafts, (..., R, N), summed.

        By `weights` (..., R, n-1, 2, 3) of each end's motion.
        """
        return weights.reshape(*weights.shape[:-3], -1) @ self._ends

    @cached_property
    def _ends(self) -> FloatArray:
        """Motion of the front and rear end of one shaft after the other, (..., 6 (n-1), N)."""
        both = np.stack([self.front, self.rear], axis=-3)
        return both.reshape(*both.shape[:-4], -1, both.shape[-1])

    def on_bearings(self, forces: ArrayLike) -> FloatArray:
        """Return what forces (..., n-2, 3) N on the shafts at their bearings do, (..., N) N."""
        local = (self.frame @ np.asarray(forces, dtype=float)[..., None])[..., 0]
        return (local.reshape(*local.shape[:-2], 1, -1) @ self.rows)[..., 0, :]

    def swing(self, turned: Turn) -> ComplexArray:
        """Return how one N m's order 2 on the coordinates follows their motion, (..., N, N).

        The driving pin axis a = Re S F e^{iθ} of a joint takes a (a · Δe) from its moment, Δe
        the change of its angle: half of that is at order 2. Symmetric. A joint of constant
        velocity has no such part.
        """
        pushes, bends = self.swung(turned)
        return pushes.mT @ bends

    def swung(self, turned: Turn) -> tuple[ComplexArray, ComplexArray]:
        """Return the same joint by joint, (..., n, N) of what is pushed and of what is felt."""
        pin = (turned.settings * np.array(turned.crosses))[..., None] * turned.frames
        none = np.zeros_like(self.front_tilt[..., :1, :, :])
        ahead = np.concatenate([none, self.rear_tilt], axis=-3)
        behind = np.concatenate([self.front_tilt, none], axis=-3)
        d = np.concatenate([self.along[..., :1, :], self.along, self.along[..., -1:, :]], axis=-2)
        bends = (pin[..., None, :] @ (behind - ahead))[..., 0, :]
        front, rear = (cross(pin, d[..., k : d.shape[-2] - 1 + k, :]) for k in (1, 0))
        pushes = (front[..., None, :] @ behind - rear[..., None, :] @ ahead)[..., 0, :]
        return -pushes / 2, bends

    def balanced(
        self,
        pushes: Sequence[ComplexArray | FloatArray],
        swing: ComplexArray | tuple[ComplexArray, ComplexArray],
        *,
        speed: ArrayLike,
        torque: ArrayLike,
    ) -> tuple[Motion, Motion, Motion]:
        """Return how the line moves under forces of orders 0, 2 and 4 that follow its motion.

        The line sets down and shakes where it then is, and what shakes at order 2 sets it down
        further and shakes at order 4: a harmonic balance, in closed form.

        Parameters
        ----------
        pushes : three of (..., N)
            Forces on the coordinates where nothing has moved.
        swing : (..., N, N) or two of (..., n, N)
            Of one N m, for the torque; `swung` is the quicker.
        speed, torque : (...) rad/s, N m
        """
        speed, torque = np.asarray(speed, dtype=float), np.asarray(torque, dtype=float)
        forces = [leading(np.asarray(f), of=1) for f in pushes]
        forces[0] = forces[0].real
        tie = (swing[0].mT, swing[1]) if isinstance(swing, tuple) else (swing,)
        tie = [leading(part, of=2) for part in tie]
        lead = np.broadcast_shapes(
            speed.shape, torque.shape, *(f.shape[1:] for f in forces), *(t.shape[2:] for t in tie),
            self.first.cases,
        )  # fmt: skip
        forces = [wide(f, len(lead), of=1) for f in forces]
        left, *right = (wide(t, len(lead), of=2) for t in tie)
        under, pace = (np.broadcast_to(v, lead) for v in (torque, speed))
        moved = [np.empty((len(f), *lead), dtype=complex) for f in forces]
        for some in stretches(lead):
            T = stretch(under, some)
            f0, f2, f4 = (stretch(f, some) for f in forces)
            found = self.first.some(some, len(lead)).balanced(
                f0,
                f2,
                f4,
                (T * stretch(left, some), stretch(right[0], some) if right else None),
                speed=stretch(pace, some),
                torque=T,
            )
            for into, q in zip(moved, found, strict=True):
                stretch(into, some)[...] = q
        lossy = np.sign(speed)
        q0, q2, q4 = (trailing(q, of=1) for q in moved)
        return self._motion(q0, 0.0), self._motion(q2, lossy), self._motion(q4, lossy)

    def shaken(self, frequency: ArrayLike, speed: ArrayLike, torque: ArrayLike) -> ComplexArray:
        """Return the line's stiffness at a frequency, (..., N, N) N/m."""
        asked = np.broadcast_arrays(
            *(np.asarray(v, dtype=float) for v in (frequency, speed, torque))
        )
        axes = max(asked[0].ndim, len(self.first.cases))
        return trailing(self.first.some(slice(None), axes).at(*asked), of=2)

    def _motion(self, moved: ArrayLike, lossy: ArrayLike, *, each: bool = False) -> Motion:
        """Return a motion (..., N) with what the bearings carry; `each` of several, (..., R, N).

        `lossy` is 1 where the rubber's loss counts, 0 where nothing shakes.
        """
        moved = np.asarray(moved, dtype=complex)
        loss = np.asarray(lossy, dtype=float)[..., None] * np.repeat(self.loss, 3, axis=-1)
        firm, rows, frame = self.springs * (1 + 1j * loss), self.rows, self.frame
        if each:
            firm, rows, frame = firm[..., None, :], rows[..., None, :, :], frame[..., None, :, :, :]
        pull = (rows @ moved[..., None])[..., 0] * firm
        local = pull.reshape(*pull.shape[:-1], -1, 1, 3)
        turned = (local @ frame)[..., 0, :].astype(complex)
        return Motion(coordinates=moved, bearing_forces=turned)

    @cached_property
    def _tilts(self) -> FloatArray:
        """Tilts of the shafts' front ends, then of their rear ones, (..., 6 (n-1), N) 1/m."""
        both = np.concatenate([self.front_tilt, self.rear_tilt], axis=-3)
        return both.reshape(*both.shape[:-3], -1, both.shape[-1])

    @cached_property
    def springs(self) -> FloatArray:
        """Stiffness of the bearings' directions one by one, (..., 3 (n-2)) N/m."""
        return np.minimum(self.stiffness, RIGID).reshape(*self.stiffness.shape[:-2], -1)

    @cached_property
    def gives(self) -> FloatArray:
        """How far rubber gives across the shafts for 1 N, (..., 3 (n-2)) m/N; 0 along them."""
        across = np.minimum(self.stiffness[..., :2], RIGID)
        gives = np.concatenate([1 / across, np.zeros_like(across[..., :1])], axis=-1)
        return gives.reshape(*gives.shape[:-2], -1)

    @cached_property
    def _held(self) -> tuple[FloatArray, FloatArray]:
        """Stiffness of tubes and rubber, and what the rubber loses, (..., N, N) N/m."""
        rows, springs, loss = self.rows, self.springs, np.repeat(self.loss, 3, axis=-1)
        lost = (rows.mT * (springs * loss)[..., None, :]) @ rows
        still = self.bending + (rows.mT * springs[..., None, :]) @ rows
        for name in self._others:
            still = still + getattr(self, name)
            lost = lost + getattr(self, f"{name}_lost")
        return still, lost

    @property
    def _others(self) -> tuple[str, ...]:
        """What gives beside rubber and tubes."""
        return tuple(n for n in ("brackets", "flanges") if getattr(self, n) is not None)

    @cached_property
    def _share(self) -> FloatArray:
        """Forces of the bearings' directions for 1 N on each coordinate, (..., 3 (n-2), N)."""
        return self.springs[..., None] * np.linalg.solve(self._held[0], self.rows.mT).mT

    @cached_property
    def first(self) -> Shaken:
        """The same matrices with the cases last."""
        still, lost = self._held
        each = (still, lost, self.gyroscopic, self.mass, self.torsion)
        names = ("still", "lost", "gyroscopic", "mass", "torsion")
        return Shaken(
            **{n: np.ascontiguousarray(leading(v, of=2)) for n, v in zip(names, each, strict=True)}
        )

    @cached_property
    def rows(self) -> FloatArray:
        """The bearings' motions one by one, (..., 3 (n-2), N)."""
        return self.bearing.reshape(*self.bearing.shape[:-3], -1, self.bearing.shape[-1])

    def slowest(self, count: int) -> "Suspended":
        """Return the line as it moves in its slowest modes alone, N = `count`.

        Good for order 2 up to their frequencies, at a share of the cost.
        """
        _, shapes = self._shapes()
        shapes = shapes[..., :count]
        both = ("mass", "bending", "gyroscopic", "torsion")
        both += tuple(n + end for n in self._others for end in ("", "_lost"))
        right = ("bearing", "front", "rear", "front_tilt", "rear_tilt")
        return replace(
            self,
            **{name: shapes.mT @ getattr(self, name) @ shapes for name in both},
            **{name: getattr(self, name) @ shapes[..., None, :, :] for name in right},
        )

    def of_case(self, *case: int) -> "Suspended":
        """Return the line of one case of the leading axes."""
        each: dict[str, Any] = {f.name: getattr(self, f.name) for f in fields(self)}
        return replace(self, **{n: v[case] for n, v in each.items() if isinstance(v, np.ndarray)})

    def mounted(self, bearing: int, seat: Seat) -> "Suspended":
        """Return the line with a bearing, from 0, in a bracket that gives, N more by its modes.

        Rubber feels how far the bearing moves against its seat: bracket and rubber are in
        series. What the bearing hands to its bracket is still `Motion.bearing_forces`.
        """
        more = len(seat.frequencies)
        ω2 = np.diag(seat.frequencies**2)

        def beside(values: FloatArray, own: ArrayLike = 0.0) -> FloatArray:
            """Return a matrix (..., N, N) with the modes' own in its corner."""
            N = values.shape[-1]
            wide = np.zeros((*values.shape[:-2], N + more, N + more))
            wide[..., :N, :N], wide[..., N:, N:] = values, own
            return wide

        def unmoved(values: FloatArray) -> FloatArray:
            return np.concatenate([values, np.zeros((*values.shape[:-1], more))], axis=-1)

        none = np.zeros_like(self.bending)
        rows = unmoved(self.bearing)
        rows[..., bearing, :, -more:] -= self.frame[..., bearing, :, :] @ seat.motion.T
        given = (none if v is None else v for v in (self.brackets, self.brackets_lost))
        return replace(
            self,
            mass=beside(self.mass, np.eye(more)),
            bending=beside(self.bending),
            gyroscopic=beside(self.gyroscopic),
            torsion=beside(self.torsion),
            bearing=rows,
            brackets=beside(next(given), ω2),
            brackets_lost=beside(next(given), seat.loss * ω2),
            seats=self.seats + more,
            **{
                n: beside(v)
                for n in ("flanges", "flanges_lost")
                if (v := getattr(self, n)) is not None
            },
            **{n: unmoved(getattr(self, n)) for n in ("front", "rear", "front_tilt", "rear_tilt")},
        )

    def frequencies(self, *, torque: ArrayLike = 0.0) -> FloatArray:
        """Return the frequencies of the modes under a torque (...) N m, (..., N) rad/s."""

        def solved(T: FloatArray, own: _Own) -> tuple[FloatArray]:
            still, wound, _ = self._modal
            return (np.linalg.eigvalsh(own(still) + T * own(wound)).astype(float),)

        return np.sqrt(np.maximum(self._each(torque, solved)[0], 0.0))

    def _shapes(self, torque: ArrayLike = 0.0) -> tuple[FloatArray, FloatArray]:
        """Return ω² (..., N) and shapes (..., N, N) of mass 1 of the modes, slowest first."""
        squares, shapes, _ = self.decaying(torque)
        return squares, shapes

    def decaying(self, torque: ArrayLike) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return ω² (..., N), shapes (..., N, N) of mass 1 and decay (..., N) 1/s of the modes.

        The decay is half of what a damper would take that loses as much as the rubber does.
        """

        def solved(T: FloatArray, own: _Own) -> tuple[FloatArray, FloatArray, FloatArray]:
            still, wound, lost = map(own, self._modal)
            squares, shapes = np.linalg.eigh(still + T * wound)
            lost = (shapes * (lost @ shapes)).sum(-2)
            decay = lost / (2 * np.sqrt(np.maximum(squares, 1e-9)))
            return squares, own(self._per_mass).mT @ shapes, decay

        squares, shapes, decay = self._each(torque, solved)
        return squares, shapes, decay

    def _each(
        self, torque: ArrayLike, solved: Callable[[FloatArray, "_Own"], tuple[FloatArray, ...]]
    ) -> tuple[FloatArray, ...]:
        """Return what is `solved` under torques (P, ..., S): of a case, each torque once.

        Most points of a case have the torque that its tyres or its brakes hold.
        """
        T = np.asarray(torque, dtype=float)
        own_cases = np.broadcast_shapes(self.mass.shape[:-2], self._held[0].shape[:-2])
        if T.ndim <= len(own_cases):
            return solved(T[..., None, None], lambda values: values)
        cases = np.broadcast_shapes(T.shape, own_cases)
        where, which = distinct(np.broadcast_to(T, cases))

        def own(values: FloatArray) -> FloatArray:
            return np.broadcast_to(values, (*cases, *values.shape[-2:]))[where]

        found = solved(np.broadcast_to(T, cases)[where][:, None, None], own)
        return tuple(v[which] for v in found)

    @cached_property
    def _modal(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Stiffness, what a torque adds and what is lost, (..., N, N), of masses of 1."""
        still, lost = self._held
        per = self._per_mass
        still, wound, lost = (per @ k @ per.mT for k in (still, self.torsion, lost))
        return still, wound, lost

    @cached_property
    def _per_mass(self) -> FloatArray:
        """Inverse of the lower half of the masses, (..., N, N) kg^-1/2."""
        return np.linalg.inv(np.linalg.cholesky(self.mass)).astype(float)

    def modes(self, *, torque: ArrayLike = 0.0) -> Modes:
        """Return the modes on the bearings, with the stiffness of a torque (...) N m."""
        k, rows = self.springs, self.rows
        squares, shapes = self._shapes(torque)
        moves = (rows @ shapes).mT  # (..., m, count)
        energy = (moves**2 * k[..., None, :]).reshape(*moves.shape[:-1], -1, 3)
        rubber = energy.sum((-2, -1))
        bent = (shapes * (self.bending @ shapes)).sum(-2)
        lost = (energy.sum(-1) * self.loss[..., None, :]).sum(-1)
        others = {"brackets": np.zeros_like(bent), "flanges": np.zeros_like(bent)}
        for name in self._others:
            others[name] = (shapes * (getattr(self, name) @ shapes)).sum(-2)
            lost = lost + (shapes * (getattr(self, f"{name}_lost") @ shapes)).sum(-2)
        whole = rubber + bent + others["brackets"] + others["flanges"]
        whole = np.where(whole > 0, whole, 1.0)
        across = moves.reshape(*moves.shape[:-1], -1, 3)
        # Vertical, level and along: the way that has most of it tells how the bearings go.
        ways = energy.sum(-2) / np.where(rubber > 0, rubber, 1.0)[..., None]
        chief = ways.argmax(axis=-1)[..., None, None]
        travel = np.take_along_axis(across, chief, axis=-1)[..., 0]
        size = np.abs(travel).max(-1, keepdims=True)
        return Modes(
            frequency=np.sqrt(np.maximum(squares, 0.0)),
            damping=lost / (2 * whole),
            bending=bent / whole,
            bracket=others["brackets"] / whole,
            flanges=others["flanges"] / whole,
            upright=ways[..., 0],
            axial=ways[..., 2],
            travel=travel / np.where(size > 0, size, 1.0),
        )


def suspended(
    layout: Layout,
    line: Line,
    *,
    stiffness: ArrayLike,
    loss: ArrayLike = LOSS,
    sines: int = SINES,
    cut: bool = False,
) -> Suspended:
    """Return a line as it can move on its centre bearings, and its flanges.

    Parameters
    ----------
    layout : (..., n, 3) m
        Where it runs.
    line
        Its tubes (each shaft needs one), yokes, spline, the places of its bearings, and what
        holds its flanges.
    stiffness : (..., n-2, 3) N/m
        Of the rubber across the shaft, vertical and lateral, and along it.
    loss : (..., n-2) 1
        Share of energy η that it loses in a radian.
    sines
        In how many a tube bends; 0 takes the shafts as rigid.
    cut
        Add three coordinates for each joint, behind all others: what lies behind it moves
        along x, y and z while what is ahead stays, and the axle; at the last joint the last
        shaft moves against the axle. Nothing moves so; what it
        would take is the force that the joint carries (`cardan.loads.running.at_joints`).
    """
    d = layout.directions[..., 1:-1, :]
    lengths = layout.lengths
    frames = _frames(d)
    soft = [f.stiffness is not None for f in line.flanges]
    fields = _fields(d, frames, sines=sines)
    given = [_flange(layout.directions, fields.shape, end=k) for k in (0, -1) if soft[k]]
    fields = np.concatenate([fields, *given], axis=-1)
    flanges = _flanges(line, fields.shape[-1], behind=3 * line.joint_count if cut else 0)
    if cut:
        fields = np.concatenate([fields, _cuts(d, fields.shape)], axis=-1)
    turned = _skew(d) @ fields.reshape(*fields.shape[:-2], -1)
    turned = turned.reshape(fields.shape)
    at, mass, across, polar = _masses(line, lengths)
    w, e, _ = _shapes(at, lengths, sines)
    kinetic = (w * mass[..., None]).mT @ w + (e * across[..., None]).mT @ e
    spin = (e * polar[..., None]).mT @ e
    ends = _shapes(np.broadcast_to([0.0, 1.0], (*lengths.shape, 2)), lengths, sines)
    front, rear, front_tilt, rear_tilt = (
        _of(shape[..., k, :], fields) for shape in ends[:2] for k in (0, 1)
    )
    ahead = stacked(s.centre_bearing.from_rear_joint for s in line.shafts if s.centre_bearing)
    hung = _shapes((1 - ahead / lengths[..., :-1])[..., None], lengths[..., :-1], sines)
    bearing = np.concatenate([frames, d[..., None]], axis=-1)[..., :-1, :, :].mT
    stiff = np.asarray(stiffness, dtype=float)
    stiff = np.broadcast_to(stiff, np.broadcast_shapes(stiff.shape, bearing.shape[:-1]))
    eta = np.asarray(loss, dtype=float)
    between = _skew(unit(d[..., :-1, :] + d[..., 1:, :]))
    at_joints = (rear_tilt[..., :-1, :, :].mT @ between @ front_tilt[..., 1:, :, :]).sum(-3)
    half = -(at_joints + _summed(_wound(lengths, sines), fields, turned)) / 2
    return Suspended(
        mass=_summed(kinetic, fields, fields) + flanges[2],
        gyroscopic=-_summed(spin, fields, turned),
        bending=_summed(_bending(line, lengths, sines), fields, fields),
        torsion=half + half.mT,
        bearing=bearing @ _of(hung[0][..., 0, :], fields[..., :-1, :, :, :]),
        frame=bearing,
        stiffness=stiff,
        loss=np.broadcast_to(eta, np.broadcast_shapes(eta.shape, stiff.shape[:-1])),
        front=front,
        rear=rear,
        front_tilt=front_tilt,
        rear_tilt=rear_tilt,
        along=d,
        flanges=flanges[0] if any(soft) else None,
        flanges_lost=flanges[1] if any(soft) else None,
    )


def _flanges(line: Line, size: int, *, behind: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return stiffness N/m, what is lost of it, and mass kg at the flanges, (..., N, N) each.

    Their coordinates are the last ones of `size`, the gearbox's first: up and level; so many
    others come `behind`.
    """
    soft = [(f, *f.stiffness) for f in line.flanges if f.stiffness is not None]
    rows = [
        (np.minimum(k, RIGID), f.loss_factor * np.minimum(k, RIGID), f.mass)
        for f, *both in soft
        for k in both
    ]
    held, lost, mass = (
        stacked([0.0] * (size - len(rows)) + [row[n] for row in rows] + [0.0] * behind)[
            ..., None, :
        ]
        * np.eye(size + behind)
        for n in range(3)
    )
    return held, lost, mass


def _skew(d: FloatArray) -> FloatArray:
    """Return the matrices (..., 3, 3) that cross vectors (..., 3) with what follows."""
    x, y, z = d[..., 0], d[..., 1], d[..., 2]
    o = np.zeros_like(x)
    return np.stack([o, -z, y, z, o, -x, -y, x, o], axis=-1).reshape(*d.shape, 3)


def _frames(d: FloatArray) -> FloatArray:
    """Directions across members (..., 3) in columns, (..., 3, 2): up, and level."""
    level = unit(np.cross(np.array([0.0, 0.0, 1.0]), d))
    return np.stack([np.cross(d, level), level], axis=-1)


def _fields(d: FloatArray, frames: FloatArray, *, sines: int) -> FloatArray:
    """Return what the coordinates move of each shaft, (..., n-1, 3, 2 + sines, N).

    Its front joint, its rear joint against the front one, and the sines it bends in.
    """
    shafts = d.shape[-2]
    hung = 2 * (shafts - 1)
    found = np.zeros((*d.shape[:-2], shafts, 3, 2 + sines, hung + 2 * sines * shafts))
    for k in range(shafts - 1):
        here = slice(2 * k, 2 * k + 2)
        found[..., k, :, 1, here] = frames[..., k, :, :]
        found[..., k + 1 :, :, 0, here] = frames[..., None, k, :, :]
    # The last shaft takes what comes along it in its spline.
    last = d[..., -1, :]
    ahead = found[..., -1, :, 0, :]
    ahead = ahead - last[..., :, None] * (last[..., None, :] @ ahead)
    found[..., -1, :, 0, :], found[..., -1, :, 1, :] = ahead, -ahead
    for k in range(shafts):
        for j in range(sines):
            start = hung + 2 * (k * sines + j)
            found[..., k, :, 2 + j, start : start + 2] = frames[..., k, :, :]
    return found


def _flange(directions: FloatArray, shape: tuple[int, ...], *, end: int) -> FloatArray:
    """Return what moving a flange up and level moves of each shaft, (..., n-1, 3, 2 + sines, 2).

    The gearbox's takes all shafts along, the axle's the last one alone, whose tube is on the
    axle's side of the spline. A flange does not tilt.
    """
    across, last = _frames(directions[..., end, :]), directions[..., -2, :]
    along = last[..., :, None] * (last[..., None, :] @ across)
    moved = np.zeros((*shape[:-1], 2))
    if end == 0:
        moved[..., :-1, :, 0, :] = across[..., None, :, :]
        moved[..., -1, :, 0, :], moved[..., -1, :, 1, :] = across - along, along - across
    else:
        moved[..., -1, :, 0, :], moved[..., -1, :, 1, :] = along, across - along
    return moved


def _cuts(d: FloatArray, shape: tuple[int, ...]) -> FloatArray:
    """Return what breaks at the joints would move of each shaft, (..., n-1, 3, 2 + sines, 3 n)."""
    count = d.shape[-2]
    moved = np.zeros((*shape[:-1], 3 * (count + 1)))
    last = d[..., -1, :]
    along = last[..., :, None] * last[..., None, :]
    across = np.eye(3) - along
    for k in range(count):
        here = slice(3 * k, 3 * k + 3)
        moved[..., k:-1, :, 0, here] = np.eye(3)
        moved[..., -1, :, 0, here], moved[..., -1, :, 1, here] = across, -across
    moved[..., -1, :, 0, -3:], moved[..., -1, :, 1, -3:] = along, across
    return moved


def _shapes(
    at: FloatArray, lengths: FloatArray, sines: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return motion, tilt and curvature (..., P, 2 + sines) at places (..., P) of shafts."""
    L = lengths[..., None]
    one, none = np.ones_like(at), np.zeros_like(at)
    w, e, bent = [one, at], [none, one / L], [none, none]
    for j in range(1, sines + 1):
        wave = j * pi * at
        w.append(np.sin(wave))
        e.append(j * pi / L * np.cos(wave))
        bent.append(-((j * pi / L) ** 2) * np.sin(wave))
    first, second, third = (np.stack(np.broadcast_arrays(*rows), axis=-1) for rows in (w, e, bent))
    return first, second, third


def _masses(
    line: Line, lengths: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return where the masses of the shafts sit, and how much there, (..., n-1, P) each.

    Places as shares of the length, kg, and kg m² about a diameter and about the axis: the
    tube at Gauss's points, the yokes at the ends, the spline where it is.
    """
    tubes = [s.tube for s in line.shafts]
    splines = [s.spline for s in line.shafts]
    tube = stacked(t.mass_per_length if t else np.nan for t in tubes) * lengths
    turning = stacked(t.polar_inertia_per_length if t else np.nan for t in tubes) * lengths
    yoke = stacked(s.yoke_inertia / 2 for s in line.shafts)
    polar = stacked(np.nan if s.polar_inertia is None else s.polar_inertia for s in line.shafts)
    share = polar / (turning + 2 * yoke)  # 1, unless a given inertia takes the place of both
    ends = np.moveaxis(stacked(stacked(s.yoke_mass) for s in line.shafts), -1, -2)
    slide = stacked(s.mass if s else 0.0 for s in splines)
    where = stacked(s.from_front_joint if s else 0.0 for s in splines) / lengths

    def joined(*parts: FloatArray) -> FloatArray:
        lead = np.broadcast_shapes(lengths.shape, *(p.shape[:-1] for p in parts))
        return np.concatenate([np.broadcast_to(p, (*lead, p.shape[-1])) for p in parts], axis=-1)

    both, none = np.stack([yoke, yoke], axis=-1), np.zeros_like(where)[..., None]
    return (
        joined(_XI, where[..., None], np.array([0.0, 1.0])),
        joined(tube[..., None] * _WEIGHT, slide[..., None], ends),
        joined(turning[..., None] / 2 * _WEIGHT, none, both),
        joined((share * turning)[..., None] * _WEIGHT, none, share[..., None] * both),
    )


def _of(shape: FloatArray, fields: FloatArray) -> FloatArray:
    """Return what the coordinates move where a shaft has a shape, (..., n-1, 3, N)."""
    return (shape[..., None, None, :] @ fields)[..., 0, :]


def _summed(form: FloatArray, one: FloatArray, other: FloatArray) -> FloatArray:
    """Sum shafts' forms (..., n-1, B, B) in their fields (..., n-1, 3, B, N) to (..., N, N)."""
    right = form[..., None, :, :] @ other
    left = one.reshape(*one.shape[:-4], -1, one.shape[-1])
    return left.mT @ right.reshape(*right.shape[:-4], -1, right.shape[-1])


def _bending(line: Line, lengths: FloatArray, sines: int) -> FloatArray:
    """Return the tubes' stiffness, (..., n-1, B, B) N/m: of sines it is exact, with shear."""
    tubes = [s.tube for s in line.shafts]
    EI = stacked(t.bending_stiffness if t else np.nan for t in tubes)
    shear = stacked(t.shear_stiffness if t else np.nan for t in tubes)
    wave = pi * np.arange(1, sines + 1) / lengths[..., None]
    stiff = EI[..., None] * wave**4 * lengths[..., None] / 2
    stiff = stiff / (1 + wave**2 * (EI / shear)[..., None])
    diagonal = np.concatenate([np.zeros((*stiff.shape[:-1], 2)), stiff], axis=-1)
    return diagonal[..., None] * np.eye(2 + sines)


def _wound(lengths: FloatArray, sines: int) -> FloatArray:
    """Return ∫ e e' of the shafts' shapes, (..., n-1, B, B): how a torque works on their bend."""
    at = np.broadcast_to(_XI, (*lengths.shape, len(_XI)))
    _, e, bent = _shapes(at, lengths, sines)
    return (e * (_WEIGHT * lengths[..., None])[..., None]).mT @ bent
