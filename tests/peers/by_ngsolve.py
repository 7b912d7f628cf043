"""NGSolve: elements of high order in (r, z), and quadratic tetrahedra on a quarter of the body; its own sparse Cholesky."""

import math

import netgen.geom2d
import netgen.meshing
import netgen.occ as occ
import ngsolve as ng
import numpy as np

import cases

PACKAGE = "ngsolve"
DIMENSIONS = {"axisymmetric, order 4": 2, "3-D P2 tetrahedra": 3}
FINENESS = {"axisymmetric, order 4": [0.5, 0.7, 1, 2], "3-D P2 tetrahedra": [0.6, 0.8, 1, 1.4]}


def flat_mesh(case, fineness):
    """The graded grid in x = r, y = depth; a layer is a domain."""
    r, depth = cases.grid(case, fineness)
    mesh = netgen.meshing.Mesh(dim=2)
    point = [[mesh.Add(netgen.meshing.MeshPoint(netgen.meshing.Pnt(x, y, 0))) for y in depth] for x in r]
    for number in range(len(case.layers)):
        mesh.Add(netgen.meshing.FaceDescriptor(surfnr=number + 1, domin=number + 1, bc=number + 1))
    for j, middle in enumerate((depth[1:] + depth[:-1]) / 2):
        number = next(at for at, layer in enumerate(case.layers) if middle < layer.bottom_m) + 1
        for i in range(len(r) - 1):
            corners = [point[i][j], point[i + 1][j], point[i + 1][j + 1], point[i][j + 1]]
            mesh.Add(netgen.meshing.Element2D(number, corners))
    sides = {1: [at[0] for at in point], 2: point[0], 3: point[-1], 4: [at[-1] for at in point]}
    for number, side in sides.items():
        for ends in zip(side, side[1:]):
            mesh.Add(netgen.meshing.Element1D(list(ends), index=number))
    for number, name in enumerate(["top", "axis", "clamped", "clamped"]):
        mesh.SetBCName(number, name)
    return ng.Mesh(mesh)


def solid_mesh(case, fineness):
    """A quarter of the cylinder: z is the depth, and x and y are symmetric; fine about the load, and coarser with distance."""
    parts = []
    for layer in case.layers:
        whole = occ.Cylinder(occ.Pnt(0, 0, layer.top_m), occ.Z, r=case.radius_m, h=layer.bottom_m - layer.top_m)
        box = occ.Box(occ.Pnt(0, 0, layer.top_m), occ.Pnt(case.radius_m, case.radius_m, layer.bottom_m))
        parts.append(whole * box)
    body = occ.Glue(parts)
    for face in body.faces:
        at = face.center
        flat = {"x": at.x < 1e-9, "y": at.y < 1e-9, "top": at.z < 1e-9}
        inner = any(abs(at.z - layer.bottom_m) < 1e-9 for layer in case.layers[:-1])
        face.name = next((name for name, true in flat.items() if true), "inner" if inner else "clamped")
    for number, solid in enumerate(body.solids):
        solid.name = str(number)
    geometry = occ.OCCGeometry(body)
    first = case.load_radius_m / fineness
    told = netgen.meshing.MeshingParameters(maxh=case.radius_m / 2 / fineness, grading=0.4 / fineness)
    for r_m in np.linspace(0, 2 * case.load_radius_m, 4 * math.ceil(fineness) + 1):
        told.RestrictH(r_m * math.cos(math.pi / 4), r_m * math.sin(math.pi / 4), 0, h=first)
    return ng.Mesh(geometry.GenerateMesh(told))


def prepare(case, is_solid, fineness):
    mesh = solid_mesh(case, fineness) if is_solid else flat_mesh(case, fineness)
    first, second = (ng.CoefficientFunction([layer.lame()[part] for layer in case.layers]) for part in (0, 1))
    names = {"dirichletx": "x|clamped", "dirichlety": "y|clamped", "dirichletz": "clamped"} if is_solid else {
        "dirichletx": "axis|clamped", "dirichlety": "clamped"}
    space = ng.VectorH1(mesh, order=2 if is_solid else 4, **names)
    u, v = space.TnT()
    strain = lambda w: ng.Sym(ng.Grad(w))
    r = ng.sqrt(ng.x * ng.x + ng.y * ng.y) if is_solid else ng.x
    weight = 1 if is_solid else 2 * math.pi * r
    hoop, virtual = (0, 0) if is_solid else (u[0] / r, v[0] / r)
    stiffness = ng.BilinearForm(space, symmetric=True)
    bulk = (ng.Trace(strain(u)) + hoop) * (ng.Trace(strain(v)) + virtual)
    shear = ng.InnerProduct(strain(u), strain(v)) + hoop * virtual
    stiffness += weight * (first * bulk + 2 * second * shear) * ng.dx(bonus_intorder=2)
    a = case.load_radius_m
    traction = case.force_n / (math.pi * a * a) * ng.exp(-r * r / (a * a))
    load = ng.LinearForm(space)
    load += weight * traction * v[mesh.dim - 1] * ng.ds("top", bonus_intorder=10)
    stiffness.Assemble()
    load.Assemble()
    return mesh, space, load.vec, stiffness.mat.Inverse(space.FreeDofs(), inverse="sparsecholesky")


def measure(case, model, fineness):
    is_solid = DIMENSIONS[model] == 3
    (mesh, space, load, factor), setup_s = cases.once_s(lambda: prepare(case, is_solid, fineness))
    moved = ng.GridFunction(space)

    def solve():
        moved.vec.data = factor * load

    solve()
    inward_m = []
    for r, depth in zip(*case.samples()):
        at = mesh(r, 0.0, depth) if is_solid else mesh(r, depth)
        inward_m.append(moved(at)[mesh.dim - 1])
    unknowns = sum(space.FreeDofs())
    return cases.Answer(case.name, unknowns, case.error(inward_m), setup_s, cases.median_s(solve))
