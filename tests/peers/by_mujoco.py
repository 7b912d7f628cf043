"""MuJoCo: flexes of linear tetrahedra on a quarter of the body, stepped until they rest.

A flex knows neither axial symmetry nor a traction: the quarter is meshed in 3-D, each layer a flex of its own that shares the points of
its boundaries with the next, and the load is a force on each point of the skin, equivalent to the traction. E and nu are the case's. The
material is Saint Venant-Kirchhoff's, so the load is a ten-thousandth of the case's, where that is linear, and the answer is scaled
back. There is no static solve. The implicit integrator does not converge on a mesh graded like this one ("Flex stiffness is too
ill-conditioned"), so steps are explicit, with the best that they can have: each point's mass is as its stiffness, so that one step suits
all elements, and damping as its mass. The time of an answer is that of all steps from the undeformed body until no point moves in a
step by more than `REST` of the largest displacement.
"""

import mujoco
import numpy as np

import cases

PACKAGE = "mujoco"
FINENESS = {"flex, linear tetrahedra": [1, 1.5, 2]}
DIMENSIONS = {"flex, linear tetrahedra": 3}
SCALE, REST, MOST_STEPS = 1e-4, 1e-5, 20000
# Mass is stiffness, so a step of 1 is about what the stiffest element bears; damping dies out in so many of them.
STEP_S, DAMPING_S = 0.7, 50.0
# A cell's eight corners, numbered by bits, as six tetrahedra about its diagonal: neighbours agree.
TETRAHEDRA = [(0, 1, 3, 7), (0, 1, 5, 7), (0, 2, 3, 7), (0, 2, 6, 7), (0, 4, 5, 7), (0, 4, 6, 7)]


class Mesh:
    """Points on rings, (r, turn, depth); those on the axis are one for all turns."""

    def __init__(self, case, fineness):
        self.turns = max(2, round(3 * fineness))
        self.r, self.depth = cases.grid(case, fineness)
        angle = np.linspace(0, np.pi / 2, self.turns + 1)
        shape = (len(self.r), self.turns + 1, len(self.depth))
        self.number = np.zeros(shape, int)
        self.points = []
        for k in range(shape[2]):
            for i in range(shape[0]):
                for j in range(shape[1]):
                    if i == 0 and j > 0:
                        self.number[i, j, k] = self.number[0, 0, k]
                        continue
                    self.number[i, j, k] = len(self.points)
                    self.points.append((self.r[i] * np.cos(angle[j]), self.r[i] * np.sin(angle[j]), -self.depth[k]))
        self.points = np.array(self.points)

    def elements(self, top_m, bottom_m):
        """The tetrahedra between two depths; the flat ones at the axis are none."""
        found = []
        for k in range(len(self.depth) - 1):
            if not top_m <= (self.depth[k] + self.depth[k + 1]) / 2 < bottom_m:
                continue
            for i in range(len(self.r) - 1):
                for j in range(self.turns):
                    corner = [self.number[i + (c & 1), j + (c >> 1 & 1), k + (c >> 2)] for c in range(8)]
                    found.extend([corner[c] for c in four] for four in TETRAHEDRA)
        return [four for four in found if len(set(four)) == 4]

    def loads_n(self, case):
        """Forces on the points of the surface, equivalent to the traction with linear elements."""
        forces = np.zeros(len(self.points))
        weights = np.array([(1 / 6, 1 / 6, 2 / 3), (1 / 6, 2 / 3, 1 / 6), (2 / 3, 1 / 6, 1 / 6)])
        for i in range(len(self.r) - 1):
            for j in range(self.turns):
                corner = [self.number[i + (c & 1), j + (c >> 1), 0] for c in range(4)]
                for three in ((corner[0], corner[1], corner[3]), (corner[0], corner[2], corner[3])):
                    at = self.points[list(three), :2]
                    (x, y), (u, v) = at[1] - at[0], at[2] - at[0]
                    where = np.linalg.norm(weights @ at, axis=1)
                    np.add.at(forces, list(three), weights.T @ case.traction_pa(where) * abs(x * v - y * u) / 6)
        return forces * case.force_n / 4 / forces.sum()


    def masses_kg(self, case):
        """A mass for each point that is its stiffness in N/m times a second squared."""
        stiffness = np.zeros(len(self.points))
        for layer in case.layers:
            elements = np.array(self.elements(layer.top_m, layer.bottom_m))
            corners = self.points[elements]
            volumes = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) / 6
            slopes = np.linalg.inv(np.concatenate([np.ones((len(elements), 4, 1)), corners], axis=2))[:, 1:]
            first, second = layer.lame()
            np.add.at(stiffness, elements, (first + 2 * second) * volumes[:, None] * (slopes**2).sum(axis=1))
        return stiffness


def description(case, mesh):
    """The model as MJCF: a body for each point, sliding along what symmetry and the clamps leave free."""
    bodies, flexes, masses = [], [], mesh.masses_kg(case)
    for number, (x, y, z) in enumerate(mesh.points):
        is_held = np.hypot(x, y) > case.radius_m * (1 - 1e-9) or z < -case.depth_m * (1 - 1e-9)
        free = "" if is_held else ("x" if x > 1e-9 else "") + ("y" if y > 1e-9 else "") + "z"
        axes = {"x": "1 0 0", "y": "0 1 0", "z": "0 0 1"}
        joints = "".join(f'<joint type="slide" axis="{axes[axis]}"/>' for axis in free)
        inertia = f'<inertial pos="0 0 0" mass="{masses[number]}" diaginertia="1 1 1"/>' if free else ""
        bodies.append(f'<body name="p{number}" pos="{x} {y} {z}">{inertia}{joints}</body>')
    for number, layer in enumerate(case.layers):
        elements = np.array(mesh.elements(layer.top_m, layer.bottom_m))
        used, local = np.unique(elements, return_inverse=True)
        names, told = " ".join(f"p{point}" for point in used), " ".join(map(str, local.ravel()))
        flexes.append(
            f'<flex name="layer{number}" dim="3" radius="0" body="{names}" element="{told}"><contact selfcollide="none" '
            f'contype="0" conaffinity="0"/><elasticity young="{layer.youngs_modulus_pa}" poisson="{layer.poisson_ratio}"/></flex>'
        )
    return (
        f'<mujoco><option gravity="0 0 0" integrator="Euler" timestep="{STEP_S}"/><worldbody>{"".join(bodies)}</worldbody>'
        f'<deformable>{"".join(flexes)}</deformable></mujoco>'
    )


def settle(model, data, force_n, shown):
    """Steps from the undeformed body until it rests; returns their number."""
    mujoco.mj_resetData(model, data)
    data.qfrc_applied[:] = force_n
    before = data.qpos[shown].copy()
    for step in range(1, MOST_STEPS + 1):
        mujoco.mj_step(model, data)
        now = data.qpos[shown].copy()
        if np.abs(now - before).max() <= REST * np.abs(now).max():
            return step
        before = now
    raise RuntimeError(f"not at rest after {MOST_STEPS} steps")


def measure(case, _, fineness):
    def prepare():
        mesh = Mesh(case, fineness)
        model = mujoco.MjModel.from_xml_string(description(case, mesh))
        model.dof_damping[:] = model.body_mass[model.dof_bodyid] / DAMPING_S
        return mesh, model, mujoco.MjData(model)

    (mesh, model, data), setup_s = cases.once_s(prepare)
    address = np.full(len(mesh.points), -1)
    for joint in np.flatnonzero(model.jnt_axis[:, 2] > 0.5):
        address[int(model.body(model.jnt_bodyid[joint]).name[1:])] = model.jnt_qposadr[joint]
    loads, force = mesh.loads_n(case) * SCALE, np.zeros(model.nv)
    force[address[address >= 0]] = -loads[address >= 0]
    _, solve_s = cases.once_s(lambda: settle(model, data, force, address[address >= 0]))
    moved = np.where(address >= 0, -data.qpos[address], 0.0) / SCALE
    inward_m = []
    for depth in case.sample_depth_m:
        line = mesh.number[:, 0, int(np.argmin(np.abs(mesh.depth - depth)))]
        inward_m.append(np.interp(case.sample_r_m, mesh.r, moved[line]))
    return cases.Answer(case.name, model.nv, case.error(inward_m), setup_s, solve_s)
