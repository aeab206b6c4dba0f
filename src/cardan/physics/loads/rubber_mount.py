r"""A line on its rubber: how it moves and what its bearings carry when it is shaken.

Statics (`cardan.physics.loads.statics`) gives the forces on a rigid support. A centre bearing
hangs in rubber, so the line has modes of 8 to 25 Hz, and what comes twice a turn crosses them at a
few hundred revolutions a minute, in first gear.

Small motions about where the line runs. A hung shaft tilts by D_k across itself, so joint
k+1 moves by D_1 + ... + D_k; the axle holds the last joint, and the last shaft moves across
itself alone. Each tube bends in sines between its joints besides. With rubber that loses η
of its energy, the torque T and the speed Ω,

$$[K (1 + i η) + T K_T + i W G(Ω) - W^2 M]\, q = f$$

The crosses' moments follow the motion, and so f does: their mean part is K_T, and their part
at order 2 ties orders 0, 2 and 4 to each other (`MountedLine.harmonic_balance`).

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
from typing import Any, Literal, TypeAlias

import numpy as np

from cardan.core.arrays import (
    ArrayLike,
    ComplexArray,
    FloatArray,
    unique_along_first_axis,
)
from cardan.core.batched_linalg import (
    broadcast_cases,
    cache_blocks,
    case_table,
    matrix_axes_first,
    matrix_axes_last,
    slice_case_block,
    solve,
)
from cardan.core.compiled import is_compiled_batch
from cardan.core.lazy_dataclass import dataclass
from cardan.model.bracket_compliance import BracketCompliance
from cardan.physics.kinematics.joint_chain import ChainRotation, cross_product
from cardan.physics.loads.compiled_response import (
    balance_kernel,
    balanced_motions_by_loop,
    response_kernel,
    responses_by_loop,
)
from cardan.physics.loads.frequency_response import DynamicStiffness

DEFAULT_LOSS_FACTOR = 0.1
"""Loss factor of rubber that is not given, assumed: mounts have 0.08 to 0.2."""

DEFAULT_STOP_TRAVEL_M = 0.015
"""m across the shaft to the stop of rubber where no file gives it: usual, assumed."""

LOSS_FACTOR_RANGE = (DEFAULT_LOSS_FACTOR / 2, 2 * DEFAULT_LOSS_FACTOR)
"""Loss factors between which rubber mounts lie."""

RUBBER_STIFFNESS_RANGE = (0.7, 2.0)
"""Stiffness of rubber hot and cold over what it is at rest in a workshop: assumed, 80 to -30 °C."""

_Own: TypeAlias = Callable[[FloatArray], FloatArray]
"""What takes from arrays (..., N, N) those of the cases that are solved."""

RIGID_BEARING_STIFFNESS = 1e17
"""N/m, of a bearing that is said to be rigid: no shaft moves it by what a force would show."""


@dataclass(frozen=True)
class HarmonicMotion:
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
class MountModes:
    """Modes of a line on its bearings, slowest first, without loss; cases on leading axes.

    Attributes
    ----------
    frequency : (..., m) rad/s
    damping_ratio : (..., m) 1
        Share of critical damping that the rubber's loss makes.
    bending_share : (..., m) 1
        Share of the energy that bends tubes; the rest is in the rubber.
    bracket_share : (..., m) 1
        Share of the energy that bends brackets.
    flange_share : (..., m) 1
        Share of the energy in what holds the flanges.
    vertical_share, axial_share : (..., m) 1
        Shares of the rubber's energy that are vertical, and along the shafts; the rest is level.
    bearing_travel : (..., m, n-2) 1
        How far the bearings go, the largest 1, with signs along its own direction.
    """

    frequency: FloatArray
    damping_ratio: FloatArray
    bending_share: FloatArray
    bracket_share: FloatArray
    flange_share: FloatArray
    vertical_share: FloatArray
    axial_share: FloatArray
    bearing_travel: FloatArray

    @property
    def not_excited(self) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
        """Whether no joint shakes a mode, (..., m): one on rubber along the shaft, which stays."""
        return (self.axial_share > 0.5) & (
            self.bending_share + self.bracket_share + self.flange_share < 0.5
        )

    def mode_names(self, *case: int) -> list[str]:
        """Return what each mode of a case is called.

        Bounce, lateral, pitch, yaw, axial on rubber; bending, bracket, flange by what gives most.

        Bounce and pitch are upright, lateral and yaw level: the bearings together, or against
        each other. In an axial one a bracket goes to and fro along the shaft that stays.
        """
        of = (
            self.bending_share,
            self.bracket_share,
            self.flange_share,
            self.vertical_share,
            self.axial_share,
            self.bearing_travel,
        )
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
class MountedLine:
    """A line in N coordinates of small motion; cases on leading axes, n-1 shafts.

    Attributes
    ----------
    mass, bending, gyroscopic, torsion, geometric : (..., N, N)
        kg; N/m of the tubes; kg for each rad/s of speed; N/m for each N m of torque, and N/m
        that each N of compression takes off.
    bearing : (..., n-2, 3, N)
        Motion of each shaft in its bearing: up, sideways and along the shaft.
    bearing_frame : (..., n-2, 3, 3)
        Those three directions, in rows.
    stiffness : (..., n-2, 3) N/m
        Infinite where rigid, 0 where free.
    loss : (..., n-2) 1
    front, rear : (..., n-1, 3, N)
        Motion of the ends of each shaft.
    front_tilt, rear_tilt : (..., n-1, 3, N) 1/m
        Change of direction of the ends of each shaft.
    shaft_directions : (..., n-1, 3)
        Directions of the shafts.
    brackets, brackets_lost : (..., N, N)
        N/m of the brackets that bearings hang in (`with_bracket`), and what they lose; None where
        they are rigid.
    flanges, flanges_lost : (..., N, N)
        The same of what holds the first and the last joint.
    bracket_mode_count
        How many of the coordinates, the last ones, are modes of brackets.
    """

    mass: FloatArray
    bending: FloatArray
    gyroscopic: FloatArray
    torsion: FloatArray
    geometric: FloatArray
    bearing: FloatArray
    bearing_frame: FloatArray
    stiffness: FloatArray
    loss: FloatArray
    front: FloatArray
    rear: FloatArray
    front_tilt: FloatArray
    rear_tilt: FloatArray
    shaft_directions: FloatArray
    brackets: FloatArray | None = None
    brackets_lost: FloatArray | None = None
    flanges: FloatArray | None = None
    flanges_lost: FloatArray | None = None
    bracket_mode_count: int = 0

    def forces_from_joint_moments(self, moments: ComplexArray) -> ComplexArray:
        """Return what crosses' moments (..., n, 3) N m do on the coordinates, (..., N) N."""
        ahead = cross_product(moments[..., :-1, :], self.shaft_directions)
        behind = cross_product(moments[..., 1:, :], self.shaft_directions)
        both = np.concatenate([ahead, -behind], axis=-2)
        return (both.reshape(*both.shape[:-2], 1, -1) @ self.tilts)[..., 0, :].astype(complex)

    def response(
        self,
        forces: ArrayLike,
        *,
        frequency: ArrayLike = 0.0,
        speed: ArrayLike = 0.0,
        torque: ArrayLike = 0.0,
    ) -> HarmonicMotion:
        """Return how forces (..., N) on the coordinates move the line at a frequency.

        Parameters
        ----------
        frequency, speed : (...) rad/s
            Of the forces, W; of the line, Ω. At W = 0 rubber loses nothing.
        torque : (...) N m
            Signed, for the stiffness it makes.
        """
        each = self.response_to_each(
            np.asarray(forces)[..., None, :], frequency=frequency, speed=speed, torque=torque
        )
        return HarmonicMotion(
            coordinates=each.coordinates[..., 0, :],
            bearing_forces=each.bearing_forces[..., 0, :, :],
        )

    def response_to_each(
        self,
        forces: ArrayLike,
        *,
        frequency: ArrayLike = 0.0,
        speed: ArrayLike = 0.0,
        torque: ArrayLike = 0.0,
    ) -> HarmonicMotion:
        """Return the same for R forces by themselves, (..., R, N): motions (..., R, ...)."""
        W, omega, T = (np.asarray(v, dtype=float) for v in (frequency, speed, torque))
        forces = np.asarray(forces, dtype=complex)
        lead = np.broadcast_shapes(
            forces.shape[:-2], W.shape, omega.shape, T.shape, self.case_last_matrices.cases
        )
        points, cases = self._points_and_cases(lead)
        kernel = response_kernel() if is_compiled_batch(cases) else None
        if kernel:
            return HarmonicMotion(*responses_by_loop(
                kernel, self._case_tables(cases), lead, forces, (W, omega, T), points=points
            ))  # fmt: skip
        right = matrix_axes_first(forces.mT, of=2)
        moved = np.empty((*right.shape[:2], *lead), dtype=complex)
        right = broadcast_cases(right, len(lead), of=2)
        asked = [np.broadcast_to(v, lead) for v in (W, omega, T)]
        for some in cache_blocks(lead):
            whole = self.case_last_matrices.select_cases(some, len(lead)).dynamic_stiffness(
                *(slice_case_block(v, some) for v in asked)
            )
            slice_case_block(moved, some)[...] = solve(whole, slice_case_block(right, some))
        return self.motion(matrix_axes_last(moved, of=2).mT, np.sign(W), each=True)

    def static_deflection(self, forces: ComplexArray | FloatArray) -> ComplexArray:
        """Return where forces (..., N) that do not move with the line hold it, (..., N) m."""
        return np.linalg.solve(self._held[0], forces[..., None])[..., 0].astype(complex)

    def static_bearing_forces(self, forces: ComplexArray) -> ComplexArray:
        """Return what bearings carry, (..., n-2, 3) N, where forces (..., N) only hold still."""
        local = (self.static_bearing_share @ forces[..., None])[..., 0]
        return (local.reshape(*local.shape[:-1], -1, 1, 3) @ self.bearing_frame)[..., 0, :]

    def bearing_forces_of_shapes(self, shapes: FloatArray) -> FloatArray:
        """Return what bearings carry at rest by shapes (..., N, M), (..., n-2, 3, M) N."""
        local = self.bearing_stiffness[..., None] * (self.bearing_matrix @ shapes)
        local = local.reshape(*local.shape[:-2], -1, 3, local.shape[-1])
        return self.bearing_frame.mT @ local

    def rubber_deflection(
        self, forces: ArrayLike, *, lossy: ArrayLike = 0.0, each: bool = False
    ) -> ComplexArray:
        """Return how far rubber gives across the shafts, (..., n-2, 3) m, under forces on it in N.

        In the layout's frame, as the forces; `each` of several, (..., R, n-2, 3). `lossy` (...)
        is 1 where the rubber's loss counts, 0 where nothing shakes. What it gives along the shaft
        is left out, and so is a bracket that is given separately.
        """
        frame, gives = (
            self.bearing_frame,
            self.rubber_compliance.reshape(*self.rubber_compliance.shape[:-1], -1, 3),
        )
        gives = gives / (
            1 + 1j * np.asarray(lossy, dtype=float)[..., None, None] * self.loss[..., None]
        )
        if each:
            frame, gives = frame[..., None, :, :, :], gives[..., None, :, :]
        local = (frame @ np.asarray(forces)[..., None])[..., 0] * gives
        return (local[..., None, :] @ frame)[..., 0, :].astype(complex)

    def shaft_end_motion(self, motions: ComplexArray) -> ComplexArray:
        """Return how far motions (..., R, N) take the ends of shafts, (..., R, n-1, 2, 3) m."""
        moved = motions @ self._ends.mT
        return moved.reshape(*moved.shape[:-1], -1, 2, 3)

    def weighted_end_motion(self, weights: FloatArray) -> FloatArray:
        """Return how much coordinates move of the ends of shafts, (..., R, N), summed.

        By `weights` (..., R, n-1, 2, 3) of each end's motion.
        """
        return weights.reshape(*weights.shape[:-3], -1) @ self._ends

    @cached_property
    def _ends(self) -> FloatArray:
        """Motion of the front and rear end of one shaft after the other, (..., 6 (n-1), N)."""
        both = np.stack([self.front, self.rear], axis=-3)
        return both.reshape(*both.shape[:-4], -1, both.shape[-1])

    def spline_gradient(self, last_shaft: FloatArray) -> FloatArray:
        """Return how much the coordinates lengthen the spline, (..., N) 1, to first order.

        `last_shaft` (..., 3) is the direction of the last shaft.
        """
        return (last_shaft[..., None, :] @ self.spline_motion)[..., 0, :]

    @property
    def spline_motion(self) -> FloatArray:
        """How the rear end of the last shaft moves against that of the one before, (..., 3, N)."""
        return self.rear[..., -1, :, :] - self.rear[..., -2, :, :]

    def stiffness_under_torque(self, torque: ArrayLike) -> FloatArray:
        """Return the static stiffness that a torque (...) N m leaves, (..., N, N) N/m."""
        return self._held[0] + np.asarray(torque, dtype=float)[..., None, None] * self.torsion

    def order2_coupling(self, turned: ChainRotation) -> ComplexArray:
        """Return how one N m's order 2 on the coordinates follows their motion, (..., N, N).

        The driving pin axis a = Re S F e^{iθ} of a joint takes a (a · Δe) from its moment, Δe
        the change of its angle: half of that is at order 2. Symmetric. A joint of constant
        velocity has no such part.
        """
        pushes, bends = self.order2_coupling_factors(turned)
        return pushes.mT @ bends

    def order2_coupling_factors(self, turned: ChainRotation) -> tuple[ComplexArray, ComplexArray]:
        """Return the same joint by joint, (..., n, N) of what is pushed and of what is felt."""
        pin = (turned.initial_pins * np.array(turned.crosses))[..., None] * turned.frames
        none = np.zeros_like(self.front_tilt[..., :1, :, :])
        ahead = np.concatenate([none, self.rear_tilt], axis=-3)
        behind = np.concatenate([self.front_tilt, none], axis=-3)
        d = np.concatenate(
            [
                self.shaft_directions[..., :1, :],
                self.shaft_directions,
                self.shaft_directions[..., -1:, :],
            ],
            axis=-2,
        )
        bends = (pin[..., None, :] @ (behind - ahead))[..., 0, :]
        front, rear = (cross_product(pin, d[..., k : d.shape[-2] - 1 + k, :]) for k in (1, 0))
        pushes = (front[..., None, :] @ behind - rear[..., None, :] @ ahead)[..., 0, :]
        return -pushes / 2, bends

    def harmonic_balance(
        self,
        pushes: Sequence[ComplexArray | FloatArray],
        swing: ComplexArray | tuple[ComplexArray, ComplexArray],
        *,
        speed: ArrayLike,
        torque: ArrayLike,
    ) -> tuple[HarmonicMotion, HarmonicMotion, HarmonicMotion]:
        """Return how the line moves under forces of orders 0, 2 and 4 that follow its motion.

        The line sets down and shakes where it then is, and what shakes at order 2 sets it down
        further and shakes at order 4: a harmonic balance, in closed form.

        Parameters
        ----------
        pushes : three of (..., N)
            Forces on the coordinates where nothing has moved.
        swing : (..., N, N) or two of (..., n, N)
            Of one N m, for the torque; `order2_coupling_factors` is quicker.
        speed, torque : (...) rad/s, N m
        """
        speed, torque = np.asarray(speed, dtype=float), np.asarray(torque, dtype=float)
        lead = np.broadcast_shapes(
            speed.shape, torque.shape, *(np.shape(f)[:-1] for f in pushes),
            *(t.shape[:-2] for t in (swing if isinstance(swing, tuple) else (swing,))),
            self.case_last_matrices.cases,
        )  # fmt: skip
        points, cases = self._points_and_cases(lead)
        kernel = balance_kernel() if is_compiled_batch(cases) else None
        if kernel and isinstance(swing, tuple):
            moved, carried = balanced_motions_by_loop(
                kernel, self._case_tables(cases), lead, pushes, swing, (speed, torque),
                points=points,
            )  # fmt: skip
            still, twice, fourth = map(HarmonicMotion, moved, carried)
            return still, twice, fourth
        forces = [matrix_axes_first(np.asarray(f), of=1) for f in pushes]
        forces[0] = forces[0].real
        tie = (swing[0].mT, swing[1]) if isinstance(swing, tuple) else (swing,)
        tie = [matrix_axes_first(part, of=2) for part in tie]
        forces = [broadcast_cases(f, len(lead), of=1) for f in forces]
        left, *right = (broadcast_cases(t, len(lead), of=2) for t in tie)
        under, pace = (np.broadcast_to(v, lead) for v in (torque, speed))
        moved = [np.empty((len(f), *lead), dtype=complex) for f in forces]
        for some in cache_blocks(lead):
            T = slice_case_block(under, some)
            f0, f2, f4 = (slice_case_block(f, some) for f in forces)
            found = self.case_last_matrices.select_cases(some, len(lead)).harmonic_balance(
                f0,
                f2,
                f4,
                (
                    T * slice_case_block(left, some),
                    slice_case_block(right[0], some) if right else None,
                ),
                speed=slice_case_block(pace, some),
                torque=T,
            )
            for into, q in zip(moved, found, strict=True):
                slice_case_block(into, some)[...] = q
        lossy = np.sign(speed)
        q0, q2, q4 = (matrix_axes_last(q, of=1) for q in moved)
        return self.motion(q0, 0.0), self.motion(q2, lossy), self.motion(q4, lossy)

    def _points_and_cases(self, lead: tuple[int, ...]) -> tuple[int, tuple[int, ...]]:
        """Return how many points and which cases of the line are in cases (P, ..., S)."""
        if len(lead) > len(self.case_last_matrices.cases):
            return lead[0], lead[1:]
        return 1, lead

    def tilt_tables(self, cases: tuple[int, ...]) -> tuple[FloatArray, FloatArray]:
        """Return `tilts` and `shaft_directions` of each of C cases (`case_table`)."""
        tilts, along = (matrix_axes_first(v, of=2) for v in (self.tilts, self.shaft_directions))
        return (
            case_table([(tilts, 2)], cases).reshape(-1, *tilts.shape[:2]),
            case_table([(along, 2)], cases).reshape(-1, *along.shape[:2]),
        )

    def _case_tables(self, cases: tuple[int, ...]) -> tuple[FloatArray, ...]:
        """Return matrices, bearings, springs and directions of each of C cases (`case_table`)."""
        if cases not in self._tables_of_cases:
            rows, springs = self.bearing_matrix, self.bearing_stiffness
            loss, frame = np.repeat(self.loss, 3, axis=-1), self.bearing_frame
            frame = frame.reshape(*frame.shape[:-2], 9)
            B, N = rows.shape[-2:]
            last = [matrix_axes_first(v, of=1) for v in (springs, loss)]
            self._tables_of_cases[cases] = (
                self.case_last_matrices.case_table(cases),
                case_table([(matrix_axes_first(rows, of=2), 2)], cases).reshape(-1, B, N),
                case_table([(v, 1) for v in last], cases).reshape(-1, 2, B),
                case_table([(matrix_axes_first(frame, of=2), 2)], cases).reshape(-1, B // 3, 9),
            )
        return self._tables_of_cases[cases]

    @cached_property
    def _tables_of_cases(self) -> dict[tuple[int, ...], tuple[FloatArray, ...]]:
        """Those that were made."""
        return {}

    def dynamic_stiffness(
        self, frequency: ArrayLike, speed: ArrayLike, torque: ArrayLike
    ) -> ComplexArray:
        """Return the line's stiffness at a frequency, (..., N, N) N/m."""
        asked = np.broadcast_arrays(
            *(np.asarray(v, dtype=float) for v in (frequency, speed, torque))
        )
        axes = max(asked[0].ndim, len(self.case_last_matrices.cases))
        return matrix_axes_last(
            self.case_last_matrices.select_cases(slice(None), axes).dynamic_stiffness(*asked), of=2
        )

    def motion(
        self, moved: ArrayLike, lossy: ArrayLike = 0.0, *, each: bool = False
    ) -> HarmonicMotion:
        """Return a motion (..., N) with what the bearings carry; `each` of several, (..., R, N).

        `lossy` is 1 where the rubber's loss counts, 0 where nothing shakes.
        """
        moved = np.asarray(moved, dtype=complex)
        loss = np.asarray(lossy, dtype=float)[..., None] * np.repeat(self.loss, 3, axis=-1)
        firm, rows, frame = (
            self.bearing_stiffness * (1 + 1j * loss),
            self.bearing_matrix,
            self.bearing_frame,
        )
        if each:
            firm, rows, frame = firm[..., None, :], rows[..., None, :, :], frame[..., None, :, :, :]
        pull = (rows @ moved[..., None])[..., 0] * firm
        local = pull.reshape(*pull.shape[:-1], -1, 1, 3)
        turned = (local @ frame)[..., 0, :].astype(complex)
        return HarmonicMotion(coordinates=moved, bearing_forces=turned)

    @cached_property
    def tilts(self) -> FloatArray:
        """Tilts of the shafts' front ends, then of their rear ones, (..., 6 (n-1), N) 1/m."""
        both = np.concatenate([self.front_tilt, self.rear_tilt], axis=-3)
        return both.reshape(*both.shape[:-3], -1, both.shape[-1])

    @cached_property
    def bearing_stiffness(self) -> FloatArray:
        """Stiffness of the bearings' directions one by one, (..., 3 (n-2)) N/m."""
        return np.minimum(self.stiffness, RIGID_BEARING_STIFFNESS).reshape(
            *self.stiffness.shape[:-2], -1
        )

    @cached_property
    def rubber_compliance(self) -> FloatArray:
        """How far rubber gives across the shafts for 1 N, (..., 3 (n-2)) m/N; 0 along them."""
        across = np.minimum(self.stiffness[..., :2], RIGID_BEARING_STIFFNESS)
        gives = np.concatenate([1 / across, np.zeros_like(across[..., :1])], axis=-1)
        return gives.reshape(*gives.shape[:-2], -1)

    @cached_property
    def _held(self) -> tuple[FloatArray, FloatArray]:
        """Stiffness of tubes and rubber, and what the rubber loses, (..., N, N) N/m."""
        rows, springs, loss = (
            self.bearing_matrix,
            self.bearing_stiffness,
            np.repeat(self.loss, 3, axis=-1),
        )
        lost = (rows.mT * (springs * loss)[..., None, :]) @ rows
        still = self.bending + (rows.mT * springs[..., None, :]) @ rows
        for name in self._others:
            still = still + getattr(self, name)
            lost = lost + getattr(self, f"{name}_lost")
        return still, lost

    @property
    def _others(self) -> tuple[str, ...]:
        """What is flexible besides rubber and tubes."""
        return tuple(n for n in ("brackets", "flanges") if getattr(self, n) is not None)

    @cached_property
    def static_bearing_share(self) -> FloatArray:
        """Forces of the bearings' directions for 1 N on each coordinate, (..., 3 (n-2), N)."""
        return (
            self.bearing_stiffness[..., None]
            * np.linalg.solve(self._held[0], self.bearing_matrix.mT).mT
        )

    @cached_property
    def case_last_matrices(self) -> DynamicStiffness:
        """The same matrices with the cases last."""
        still, lost = self._held
        each = (still, lost, self.gyroscopic, self.mass, self.torsion)
        names = ("still", "lost", "gyroscopic", "mass", "torsion")
        return DynamicStiffness(
            **{
                n: np.ascontiguousarray(matrix_axes_first(v, of=2))
                for n, v in zip(names, each, strict=True)
            }
        )

    @cached_property
    def bearing_matrix(self) -> FloatArray:
        """The bearings' motions one by one, (..., 3 (n-2), N)."""
        return self.bearing.reshape(*self.bearing.shape[:-3], -1, self.bearing.shape[-1])

    def modal_reduction(self, count: int) -> "MountedLine":
        """Return the line as it moves in its slowest modes alone, N = `count`.

        Good for order 2 up to their frequencies, at a share of the cost.
        """
        _, shapes = self._shapes()
        shapes = shapes[..., :count]
        both = ("mass", "bending", "gyroscopic", "torsion", "geometric")
        both += tuple(n + end for n in self._others for end in ("", "_lost"))
        right = ("bearing", "front", "rear", "front_tilt", "rear_tilt")
        return replace(
            self,
            **{name: shapes.mT @ getattr(self, name) @ shapes for name in both},
            **{name: getattr(self, name) @ shapes[..., None, :, :] for name in right},
        )

    def select_case(self, *case: int) -> "MountedLine":
        """Return the line of one case of the leading axes."""
        each: dict[str, Any] = {f.name: getattr(self, f.name) for f in fields(self)}
        return replace(self, **{n: v[case] for n, v in each.items() if isinstance(v, np.ndarray)})

    def select_states(self, states: Sequence[int]) -> "MountedLine":
        """Return the line in some of its states, by their indices on the last leading axis."""
        own = {"loss": 1, "stiffness": 2, "shaft_directions": 2}
        own |= dict.fromkeys(
            ("bearing", "bearing_frame", "front", "rear", "front_tilt", "rear_tilt"), 3
        )
        each: dict[str, Any] = {f.name: getattr(self, f.name) for f in fields(self)}
        several = {
            name: v
            for name, v in each.items()
            if isinstance(v, np.ndarray)
            and v.ndim > own.get(name, 2)
            and v.shape[-1 - own.get(name, 2)] > 1
        }
        return replace(
            self, **{n: v.take(states, axis=-1 - own.get(n, 2)) for n, v in several.items()}
        )

    def with_bracket(self, bearing: int, seat: BracketCompliance) -> "MountedLine":
        """Return the line with a bearing, from 0, in a bracket that gives, N more by its modes.

        Rubber feels how far the bearing moves against its seat: bracket and rubber are in
        series. What the bearing hands to its bracket is still `HarmonicMotion.bearing_forces`.
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
        rows[..., bearing, :, -more:] -= (
            self.bearing_frame[..., bearing, :, :] @ seat.seat_mode_shapes.T
        )
        given = (none if v is None else v for v in (self.brackets, self.brackets_lost))
        return replace(
            self,
            mass=beside(self.mass, np.eye(more)),
            bending=beside(self.bending),
            gyroscopic=beside(self.gyroscopic),
            torsion=beside(self.torsion),
            geometric=beside(self.geometric),
            bearing=rows,
            brackets=beside(next(given), ω2),
            brackets_lost=beside(next(given), seat.loss_factor * ω2),
            bracket_mode_count=self.bracket_mode_count + more,
            **{
                n: beside(v)
                for n in ("flanges", "flanges_lost")
                if (v := getattr(self, n)) is not None
            },
            **{n: unmoved(getattr(self, n)) for n in ("front", "rear", "front_tilt", "rear_tilt")},
        )

    def natural_frequencies(self, *, torque: ArrayLike = 0.0) -> FloatArray:
        """Return the frequencies of the modes under a torque (...) N m, (..., N) rad/s."""

        def solved(T: FloatArray, own: _Own) -> tuple[FloatArray]:
            still, wound, _ = self._modal
            return (np.linalg.eigvalsh(own(still) + T * own(wound)).astype(float),)

        return np.sqrt(np.maximum(self._each(torque, solved)[0], 0.0))

    def _shapes(self, torque: ArrayLike = 0.0) -> tuple[FloatArray, FloatArray]:
        """Return ω² (..., N) and shapes (..., N, N) of mass 1 of the modes, slowest first."""
        squares, shapes, _ = self.modes_with_decay(torque)
        return squares, shapes

    def modes_with_decay(self, torque: ArrayLike) -> tuple[FloatArray, FloatArray, FloatArray]:
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
        where, which = unique_along_first_axis(np.broadcast_to(T, cases))

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

    def modes(self, *, torque: ArrayLike = 0.0) -> MountModes:
        """Return the modes on the bearings, with the stiffness of a torque (...) N m."""
        k, rows = self.bearing_stiffness, self.bearing_matrix
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
        # Vertical, level and along: the direction with the largest part shows how the bearings
        # move.
        ways = energy.sum(-2) / np.where(rubber > 0, rubber, 1.0)[..., None]
        chief = ways.argmax(axis=-1)[..., None, None]
        travel = np.take_along_axis(across, chief, axis=-1)[..., 0]
        size = np.abs(travel).max(-1, keepdims=True)
        return MountModes(
            frequency=np.sqrt(np.maximum(squares, 0.0)),
            damping_ratio=lost / (2 * whole),
            bending_share=bent / whole,
            bracket_share=others["brackets"] / whole,
            flange_share=others["flanges"] / whole,
            vertical_share=ways[..., 0],
            axial_share=ways[..., 2],
            bearing_travel=travel / np.where(size > 0, size, 1.0),
        )
