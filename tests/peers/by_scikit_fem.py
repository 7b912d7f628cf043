"""scikit-fem: axisymmetric elasticity in (r, z) on a graded grid of quadrilaterals, factorised once by SuperLU."""

import numpy as np
import scipy.sparse.linalg
import skfem
from skfem.helpers import ddot, sym_grad, trace

import cases

PACKAGE = "scikit-fem"
MODELS = {"axisymmetric Q1": skfem.ElementQuad1, "axisymmetric Q2": skfem.ElementQuad2}
FINENESS = {"axisymmetric Q1": [1, 2, 4, 8], "axisymmetric Q2": [0.5, 1, 2, 4]}
DIMENSIONS = {"axisymmetric Q1": 2, "axisymmetric Q2": 2}


def assemble(case, element, fineness):
    """Basis, stiffness and load; the second coordinate is the depth."""
    r, depth = cases.grid(case, fineness)
    mesh = skfem.MeshQuad.init_tensor(r, depth)
    basis = skfem.Basis(mesh, skfem.ElementVector(element()), intorder=5)
    middle = mesh.p[1, mesh.t].mean(axis=0)
    layers = [next(layer for layer in case.layers if at < layer.bottom_m) for at in middle]
    lame = np.array([layer.lame() for layer in layers])

    @skfem.BilinearForm
    def stiffness(u, v, w):
        strain, virtual = sym_grad(u), sym_grad(v)
        hoop, hoop_virtual = u.value[0] / w.x[0], v.value[0] / w.x[0]
        bulk = w.first * (trace(strain) + hoop) * (trace(virtual) + hoop_virtual)
        return (bulk + 2 * w.second * (ddot(strain, virtual) + hoop * hoop_virtual)) * 2 * np.pi * w.x[0]

    @skfem.LinearForm
    def load(v, w):
        return case.traction_pa(w.x[0]) * v.value[1] * 2 * np.pi * w.x[0]

    constants = {name: basis.with_element(skfem.ElementQuad0()).interpolate(of) for name, of in zip(("first", "second"), lame.T)}
    plane = mesh.facets_satisfying(lambda x: np.isclose(x[1], case.load_depth_m))
    loaded = skfem.FacetBasis(mesh, basis.elem, facets=plane, intorder=12)
    return basis, stiffness.assemble(basis, **constants), load.assemble(loaded)


def prepare(case, element, fineness):
    basis, matrix, load = assemble(case, element, fineness)
    fixed = lambda at: np.isclose(at[0], case.radius_m) | np.isclose(at[1], case.depth_m)
    clamped = basis.get_dofs(basis.mesh.facets_satisfying(fixed)).flatten()
    axis = basis.get_dofs(basis.mesh.facets_satisfying(lambda at: at[0] == 0)).all(["u^1"])
    held = np.union1d(clamped, axis)
    free = basis.complement_dofs(held)
    inner = matrix[free][:, free].tocsc()
    factor = scipy.sparse.linalg.splu(
        inner, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
    )
    return basis, free, factor, load[free]


def measure(case, model, fineness):
    (basis, free, factor, load), setup_s = cases.once_s(lambda: prepare(case, MODELS[model], fineness))
    moved = np.zeros(basis.N)
    moved[free] = factor.solve(load)
    r, depth = case.samples()
    inward_m = (basis.probes(np.array([r, depth])) @ moved).reshape(2, -1)[1]
    return cases.Answer(case.name, len(free), case.error(inward_m), setup_s, cases.median_s(lambda: factor.solve(load)))
