"""A driveline as a multibody engine sees it: rigid bodies, universal joints, a spline.

The engine (Drake) is told where members and pins are and nothing of how a universal joint
turns. Only its poses, Jacobians and bias accelerations are used, so what follows from them
is independent of the program's equations.
"""

from typing import Any

import numpy as np


class Mechanism:
    """A line of n joints in the engine.

    Every body has its z axis along its member. A universal joint of the engine turns about
    x of a frame on the body before it, then about y of the body behind it: the pin axes.
    The last shaft slides in itself, so that its two ends are two bodies.

    Parameters
    ----------
    points : (n, 3) m
        Joint centres.
    directions : (n+1, 3) 1
        Members, pointing rearward.
    phases : (n-1,) rad
        Yoke phases of the shafts.
    """

    def __init__(self, points: Any, directions: Any, phases: Any) -> None:
        from pydrake.math import RigidTransform, RotationMatrix
        from pydrake.multibody.plant import MultibodyPlant
        from pydrake.multibody.tree import (
            FixedOffsetFrame,
            PrismaticJoint,
            RevoluteJoint,
            SpatialInertia,
            UniversalJoint,
        )

        self.points, self.directions = np.asarray(points), np.asarray(directions)
        n, along = len(self.points), [0.0, 0.0, 1.0]
        plant = MultibodyPlant(time_step=0.0)
        inertia = SpatialInertia.SolidSphereWithMass(1.0, 0.1)
        bodies = [plant.AddRigidBody(f"member {k}", inertia) for k in range(n + 1)]
        lengths = np.linalg.norm(np.diff(self.points, axis=0), axis=-1)

        def placed(body: Any, name: str, turn: Any, at: Any) -> Any:
            pose = RigidTransform(turn, at)
            return plant.AddFrame(FixedOffsetFrame(name, body.body_frame(), pose))

        right = np.cross(along, self.directions[0])
        right /= np.linalg.norm(right)
        up = np.cross(self.directions[0], right)
        flange = RotationMatrix(np.stack([right, up, self.directions[0]], axis=-1))
        world = placed(plant.world_body(), "flange", flange, self.points[0])
        plant.AddJoint(RevoluteJoint("gearbox", world, bodies[0].body_frame(), along))
        yoke = bodies[0].body_frame()
        for k in range(1, n + 1):
            plant.AddJoint(UniversalJoint(f"joint {k}", yoke, bodies[k].body_frame()))
            if k < n:
                rear = bodies[k]
                if k == n - 1:
                    rear = plant.AddRigidBody("spline", inertia)
                    plant.AddJoint(
                        PrismaticJoint("slide", bodies[k].body_frame(), rear.body_frame(), along)
                    )
                # A quarter turn on from the driven pin, which is y, to x; and the phase.
                turn = RotationMatrix.MakeZRotation(phases[k - 1] + np.pi / 2)
                yoke = placed(rear, f"yoke {k}", turn, [0.0, 0.0, lengths[k - 1]])
        plant.Finalize()
        self.plant, self.bodies = plant, bodies
        self.context = plant.CreateDefaultContext()
        held = (plant.GetJointByName(name) for name in ("gearbox", "slide"))
        self._locked = [joint.velocity_start() for joint in held]

    def pose(self, member: int) -> np.ndarray:
        """Return the axes of a member as columns, (3, 3)."""
        return self.bodies[member].EvalPoseInWorld(self.context).rotation().matrix()

    def jacobian(self, body: Any, point: Any = (0.0, 0.0, 0.0)) -> np.ndarray:
        """Return spatial velocity of a body over the speeds of the joints, (6, 2n+2).

        Angular first, then that of a point fixed to it, given in its own axes.
        """
        from pydrake.multibody.tree import JacobianWrtVariable

        world = self.plant.world_frame()
        return self.plant.CalcJacobianSpatialVelocity(
            self.context, JacobianWrtVariable.kV, body.body_frame(), point, world, world
        )

    def _bias(self, body: Any) -> np.ndarray:
        """Return the angular acceleration of a body that its speeds alone ask for, (3,)."""
        from pydrake.multibody.tree import JacobianWrtVariable

        world = self.plant.world_frame()
        return self.plant.CalcBiasSpatialAcceleration(
            self.context, JacobianWrtVariable.kV, body.body_frame(), np.zeros(3), world, world
        ).rotational()

    def _solve(self, wanted: np.ndarray, gearbox: float) -> tuple[np.ndarray, np.ndarray]:
        """Find joint rates (2n+2,) and member rates (n,) about their axes.

        Member k then turns with its rate about its own direction plus wanted (n, 3), and
        the gearbox with its own rate.
        """
        n = len(self.points)
        count = self.plant.num_velocities()
        system = np.zeros((3 * n, count + n))
        for k in range(n):
            rows = slice(3 * k, 3 * k + 3)
            system[rows, :count] = self.jacobian(self.bodies[k + 1])[:3]
            system[rows, count + k] = -self.directions[k + 1]
        rest = np.setdiff1d(np.arange(count + n), self._locked)
        first = self._locked[0]
        found = np.zeros(count + n)
        found[first] = gearbox
        found[rest] = np.linalg.solve(system[:, rest], wanted.ravel() - system[:, first] * gearbox)
        return found[:count], found[count:]

    def place(self, theta: float) -> None:
        """Turn the gearbox to an angle and find where that puts everything else."""
        q = self.plant.GetPositions(self.context)
        q[self._locked[0]] = theta
        for _ in range(50):
            self.plant.SetPositions(self.context, q)
            axes = np.array([self.pose(k)[:, 2] for k in range(1, len(self.directions))])
            error = np.cross(axes, self.directions[1:])
            if np.abs(error).max() < 1e-14:
                return
            q = q + self._solve(error, 0.0)[0]
        msg = f"the engine found no pose at {theta:g} rad"
        raise AssertionError(msg)

    def motion(self, theta: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return x axes (n, 3), speeds (n,), accelerations (n,) of members 1 to n.

        The gearbox turns uniformly at 1 rad/s; x is square to the driven pin, which is y.
        """
        self.place(theta)
        rates, speeds = self._solve(np.zeros((len(self.points), 3)), 1.0)
        self.plant.SetVelocities(self.context, rates)
        bias = np.array([self._bias(body) for body in self.bodies[1:]])
        _, accelerations = self._solve(-bias, 0.0)
        x = np.array([self.pose(k)[:, 0] for k in range(1, len(self.directions))])
        return x, speeds, accelerations
