"""The branched line against openTorsion, on two vehicles, to 1e-6: every part at its own speed.

openTorsion assembles rotors and shafts by its own elements, none of them referred; gearbox,
axle and inter-axle differential are kinematic constraints between its nodes, written down
here. Its modes are asked of what remains.
"""

from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import eigh

from cardan.application import reader
from cardan.application.typical_values import typical_value
from cardan.physics.dynamics.torsional_network import torsional_modes
from cardan.topics.torsion.powertrain_model import vehicle_torsion_model

EXAMPLES = Path(__file__).parents[2] / "examples"

pytestmark = pytest.mark.oracle


class Package:
    """A torsional system in openTorsion, its nodes by name."""

    def __init__(self):
        self.names, self.shafts, self.disks = [], [], []

    def node(self, name):
        if name not in self.names:
            self.names.append(name)
        return self.names.index(name)

    def disk(self, name, inertia):
        self.disks.append((self.node(name), inertia))

    def shaft(self, a, b, stiffness):
        self.shafts.append((self.node(a), self.node(b), stiffness))

    def modes(self, constraints):
        """Frequencies, Hz, with each constraint a sum of rotations that stays 0."""
        import opentorsion as ot

        # Without its transform of connected shafts: pieces between gears stand apart here.
        assembly = ot.Assembly.__new__(ot.Assembly)
        assembly.shaft_elements = [ot.Shaft(a, b, k=k, I=0) for a, b, k in self.shafts]
        assembly.disk_elements = [ot.Disk(n, inertia) for n, inertia in self.disks]
        assembly.gear_elements = assembly.elastic_gear_elements = None
        assembly.dofs = assembly.check_dof()
        M, K = assembly.assemble_M(), assembly.assemble_K()
        rows = np.zeros((len(constraints), len(self.names)))
        for row, turns in zip(rows, constraints, strict=True):
            for name, ratio in turns.items():
                row[self.names.index(name)] = ratio
        _, _, vh = np.linalg.svd(rows)
        free = vh[len(constraints) :].T
        values = eigh(free.T @ K @ free, free.T @ M @ free, eigvals_only=True)
        return np.sqrt(np.abs(values)) / (2 * np.pi)


def built(app, ratio, mass, vehicle_class):
    """A vehicle with its own numbers, and typical ones for the rest."""

    def T(q):  # noqa: N802
        return typical_value(q, vehicle_class).value

    p, ties = Package(), []
    litres = max(app.engine.torque) / T("engine.torque_per_litre")
    p.disk("engine", T("engine.inertia_base") + T("engine.inertia_per_litre") * litres)
    p.disk("disc", T("clutch.disc_inertia"))
    p.shaft("engine", "disc", 50 * T("clutch.stiffness"))
    p.shaft("disc", "input", T("clutch.stiffness"))
    p.disk("input", T("gearbox.input_inertia"))
    # The gears, then the gearbox's spring at its output's speed.
    ties.append({"input": 1.0, "geared": -ratio})
    p.disk("geared", 1e-12)
    p.shaft("geared", "main 0", T("gearbox.stiffness"))
    p.disk("main 0", T("gearbox.output_inertia"))
    per = round(T("wheels.per_axle"))
    r = app.tyre.dynamic_radius
    for number, installed in enumerate(app.lines):
        name = ("main", "rear")[number]
        for k, shaft in enumerate(installed.line.shafts):
            t = shaft.tube
            J = np.pi / 32 * (t.outer**4 - (t.outer - 2 * t.wall) ** 4)
            G = t.material.youngs_modulus / (2 * (1 + t.material.poisson))
            half = t.material.density * J * shaft.length / 2 + T("shaft.yoke_inertia")
            p.shaft(f"{name} {k}", f"{name} {k + 1}", G * J / shaft.length)
            p.disk(f"{name} {k}", half)
            p.disk(f"{name} {k + 1}", half)
        last = f"{name} {len(installed.line.shafts)}"
        p.disk(last, T("axle.flange_inertia"))
        p.disk(f"{name} pinion", T("axle.pinion_inertia"))
        cage = f"{name} pinion"
        if number == 0 and len(app.lines) > 1:
            cage = "cage"
            p.disk("cage", T("inter_axle.cage_inertia"))
            p.shaft("cage", "main pinion", 1e-6)  # openTorsion counts the ends of shafts
            p.disk("rear 0", T("inter_axle.through_inertia"))
            ties.append({"cage": 1.0, "main pinion": -0.5, "rear 0": -0.5})
        p.shaft(last, cage, T("axle.pinion_stiffness"))
        p.disk(f"{name} ring", T("axle.ring_inertia"))
        p.disk(f"{name} housing", T("axle.housing_inertia"))
        ties.append(
            {
                f"{name} ring": 1.0,
                f"{name} pinion": -1 / installed.axle.ratio,
                f"{name} housing": -1.0,
            }
        )
        p.shaft(f"{name} housing", "ground", app.suspension.windup_stiffness)
        half = 2 * T("axle.half_shafts")
        p.shaft(f"{name} ring", f"{name} wheels", half)
        p.disk(f"{name} wheels", per * T("wheels.inertia") + 2 * T("wheels.hub_inertia"))
        tread = per * T("tyre.longitudinal_stiffness") * r**2
        p.shaft(f"{name} wheels", "vehicle", tread)
    p.disk("vehicle", mass * r**2 + 2 * T("wheels.inertia"))
    p.disk("ground", 1.0)
    ties.append({"ground": 1.0})
    return p.modes(ties)


@pytest.mark.parametrize("name", ["medium-truck-4x2", "tandem-6x4"])
def test_modes_match_opentorsion(name):
    pytest.importorskip("opentorsion")
    app = reader.read(EXAMPLES / f"{name}.yaml")
    parts = vehicle_torsion_model(app)
    s = parts.states.index("gvw")
    for g, ratio in enumerate(parts.ratios.tolist()):
        theirs = built(app, ratio, float(parts.mass[s]), parts.vehicle_class)
        mine = torsional_modes(parts.closed.line.select_case([g], [s])).frequency[0] / (2 * np.pi)
        assert mine[1:9] == pytest.approx(theirs[1:9], rel=1e-6)
