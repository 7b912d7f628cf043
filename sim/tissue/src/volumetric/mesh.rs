//! Hexahedra of any order: a layered disc, graded towards its load, or a box.

use law::axial::{Domain, ParamError};
use nalgebra::Point3;
use serde::{Deserialize, Serialize};

use super::plan::{DiscPlan, Outline};
use super::{Problem3, Symmetry, basis, number_node};

/// Allowed orders of the elements. Linear elements lock in thin stiff layers and are not supported.
pub const ORDERS: std::ops::RangeInclusive<usize> = 2..=4;

/// Size of the elements: `near_m` at the load, plus `growth` for each metre of distance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Grading {
    /// Size at the load, in m.
    pub near_m: f64,
    /// Size gained per distance, in m/m.
    pub growth: f64,
}

/// Parameters of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MeshSpec3 {
    /// The meshed part: at least as much as the problem's symmetry requires.
    pub symmetry: Symmetry,
    /// Order of the elements, 2 to 4.
    pub order: usize,
    /// Number of elements in 45° around the needle.
    pub around: usize,
    /// Sizes across the needle.
    pub across: Grading,
    /// Sizes along the depth.
    pub along: Grading,
    /// The patch ends at this distance from the load, in m, unless the tissue ends before.
    pub reach_m: f64,
}

/// Isoparametric hexahedra with Gauss–Lobatto nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct HexMesh {
    /// Order of the elements.
    pub order: usize,
    /// Positions of the nodes at rest, in m.
    pub nodes_m: Vec<Point3<f64>>,
    /// Nodes of each element, (order + 1)³, the first direction fastest.
    pub elements: Vec<u32>,
}

/// A mesh of tissue with its relation to the problem's geometry.
pub(super) struct PatchMesh {
    pub mesh: HexMesh,
    /// The same nodes before the skin was bent, in m.
    pub flat_m: Vec<Point3<f64>>,
    /// Planes between the elements, in m, downwards. The elements of the first interval come first.
    pub planes_m: Vec<f64>,
    /// Radius of the patch, in m.
    pub radius_m: f64,
}

impl Grading {
    /// Planes from one coordinate to another, both included, for a load between two coordinates.
    fn divide(&self, [from, to]: [f64; 2], load: [f64; 2]) -> Vec<f64> {
        let size = |at: f64| self.near_m + self.growth * (load[0] - at).max(at - load[1]).max(0.0);
        // Cumulative number of elements up to each of many positions.
        const STEPS: usize = 512;
        let step = (to - from) / STEPS as f64;
        let mut fit = vec![0.0];
        for at in 0..STEPS {
            fit.push(fit[at] + step / size(from + (at as f64 + 0.5) * step));
        }
        let count = (fit[STEPS].round() as usize).clamp(1, 256);
        let mut planes = vec![from];
        for plane in 1..count {
            let wanted = fit[STEPS] * plane as f64 / count as f64;
            let after = fit.partition_point(|&f| f < wanted).clamp(1, STEPS);
            let part = (wanted - fit[after - 1]) / (fit[after] - fit[after - 1]);
            planes.push(from + step * (after as f64 - 1.0 + part));
        }
        planes.push(to);
        planes
    }

    fn check(&self, field: &str) -> Result<(), ParamError> {
        Domain::Positive.check(format!("mesh.{field}.near_m"), self.near_m, "m")?;
        Domain::NotNegative.check(format!("mesh.{field}.growth"), self.growth, "m/m")
    }
}

impl MeshSpec3 {
    /// The same mesh with lengths along the skin so many times as long.
    #[must_use]
    pub(crate) fn squeezed(self, scale: f64) -> Self {
        let across = Grading { near_m: self.across.near_m * scale, ..self.across };
        Self { across, reach_m: self.reach_m * scale, ..self }
    }

    /// Checks the specification for a problem.
    pub(super) fn check(&self, problem: &Problem3) -> Result<(), ParamError> {
        let refuse = |field: &str, value: f64, allowed| {
            Err(ParamError { field: format!("mesh.{field}"), value, unit: "", allowed })
        };
        if !ORDERS.contains(&self.order) {
            return refuse("order", self.order as f64, "must be 2, 3 or 4");
        }
        if !(1..=16).contains(&self.around) {
            return refuse("around", self.around as f64, "must be from 1 to 16");
        }
        if self.symmetry < problem.symmetry() {
            let allowed = "must not be less than what the problem's own symmetry leaves";
            return refuse("symmetry", self.symmetry.share(), allowed);
        }
        self.across.check("across")?;
        self.along.check("along")?;
        Domain::Positive.check("mesh.reach_m", self.reach_m, "m")
    }

    /// Number of unknowns of the mesh of a problem, including held ones.
    pub(crate) fn unknowns(&self, problem: &Problem3) -> Result<usize, ParamError> {
        Ok(3 * self.mesh(problem)?.mesh.nodes_m.len())
    }

    /// Half the block's width and the radii of the rings, in m.
    fn radii_m(&self, radius_m: f64) -> Vec<f64> {
        let radii = self.across.divide([0.0, radius_m], [0.0, 0.0]);
        match radii.len() {
            // At least a block and a ring.
            2 => vec![0.5 * radius_m, radius_m],
            _ => radii[1..].to_vec(),
        }
    }

    /// Planes between the elements, in m: every boundary, both ends of the load, and graded ones
    /// between.
    fn planes_m(&self, problem: &Problem3) -> Vec<f64> {
        let load = problem.flat.load.ends_m();
        let boundaries = problem.flat.slab.boundaries_m();
        let base = boundaries[boundaries.len() - 1].min(load[1] + self.reach_m);
        let mut fixed: Vec<f64> = boundaries.into_iter().chain([load[0], load[1], base]).collect();
        fixed.retain(|&plane| plane <= base);
        fixed.sort_by(f64::total_cmp);
        // Depths within 1 nm of each other are equal.
        fixed.dedup_by(|later, earlier| *later - *earlier < 1e-9);
        let mut planes = vec![0.0];
        for interval in fixed.windows(2) {
            planes.extend_from_slice(&self.along.divide([interval[0], interval[1]], load)[1..]);
        }
        planes
    }

    /// Meshes the tissue around the needle.
    pub(super) fn mesh(&self, problem: &Problem3) -> Result<PatchMesh, ParamError> {
        self.check(problem)?;
        let radius_m = problem.flat.slab.radius_m.min(self.reach_m);
        let radii_m = self.radii_m(radius_m);
        // Nodes nearer than this follow the needle's inclination fully: the first ring, unless it
        // is the last, or the block.
        let centred_m = if radii_m.len() > 2 { radii_m[1] } else { radii_m[0] };
        let load = problem.flat.load.ends_m();
        let most = 0.9 * (radius_m - centred_m);
        let deepest = problem.on_flat_needle(load[1]);
        if libm::hypot(deepest.x, deepest.y) > most {
            let allowed = "the tilted needle must meet its load well inside the tissue's radius and the mesh's reach";
            return Err(ParamError { field: "tilt_rad".into(), value: problem.tilt_rad, unit: "rad", allowed });
        }
        let outline = Outline { radii_m: &radii_m, symmetry: self.symmetry, around: self.around };
        let parameters: Vec<f64> = basis::lobatto_rule(self.order).iter().map(|(x, _)| 0.5 * (1.0 + x)).collect();
        let plan = DiscPlan::new(&outline, &parameters);
        let planes_m = self.planes_m(problem);
        // The rings follow the needle's inclination, each less than the one inside it, and the side
        // stays fixed, although rounding puts some of its nodes beyond the radius.
        let place = |[x, y]: [f64; 2], depth_m: f64| {
            let share = ((radius_m - libm::hypot(x, y)) / (radius_m - centred_m)).clamp(0.0, 1.0);
            let needle = problem.on_flat_needle(depth_m.clamp(load[0], load[1]));
            Point3::new(x + share * needle.x, y + share * needle.y, -depth_m)
        };
        let (flat_m, elements) = extrude(&plan, &planes_m, &parameters, place);
        let nodes_m = flat_m.iter().map(|node| problem.skin.bend(node)).collect();
        let mesh = HexMesh { order: self.order, nodes_m, elements };
        Ok(PatchMesh { mesh, flat_m, planes_m, radius_m })
    }
}

/// Extrudes a plan. Elements of the first interval of planes come first; their third direction
/// points upwards.
fn extrude(
    plan: &DiscPlan,
    planes_m: &[f64],
    parameters: &[f64],
    place: impl Fn([f64; 2], f64) -> Point3<f64>,
) -> (Vec<Point3<f64>>, Vec<u32>) {
    let order = parameters.len() - 1;
    let mut nodes = Vec::new();
    let mut elements = Vec::new();
    for (at, interval) in planes_m.windows(2).enumerate() {
        let first = usize::from(at > 0);
        for parameter in &parameters[first..] {
            let depth = interval[0] + (interval[1] - interval[0]) * parameter;
            nodes.extend(plan.nodes_m.iter().map(|&node| place(node, depth)));
        }
        for cell in &plan.cells {
            for level in (0..=order).rev().map(|k| at * order + k) {
                let below = number_node(level * plan.nodes_m.len());
                elements.extend(cell.iter().map(|node| node + below));
            }
        }
    }
    (nodes, elements)
}

impl HexMesh {
    /// A box from the origin with `counts` elements along each side.
    #[must_use]
    pub fn cuboid(order: usize, size_m: [f64; 3], counts: [usize; 3]) -> Self {
        let parameters: Vec<f64> = basis::lobatto_rule(order).iter().map(|(x, _)| 0.5 * (1.0 + x)).collect();
        let along = |axis: usize, at: usize| {
            let (element, node) =
                if at == counts[axis] * order { (at / order - 1, order) } else { (at / order, at % order) };
            size_m[axis] * (element as f64 + parameters[node]) / counts[axis] as f64
        };
        let rows = counts.map(|count| count * order + 1);
        let all =
            |n: [usize; 3]| (0..n[2]).flat_map(move |k| (0..n[1]).flat_map(move |j| (0..n[0]).map(move |i| [i, j, k])));
        let nodes_m = all(rows).map(|[i, j, k]| Point3::new(along(0, i), along(1, j), along(2, k))).collect();
        let mut elements = Vec::new();
        for element in all(counts) {
            elements.extend(all([order + 1; 3]).map(|node| {
                let [i, j, k]: [usize; 3] = std::array::from_fn(|axis| element[axis] * order + node[axis]);
                number_node((k * rows[1] + j) * rows[0] + i)
            }));
        }
        Self { order, nodes_m, elements }
    }

    /// Number of nodes of an element.
    #[must_use]
    pub fn nodes_each(&self) -> usize {
        (self.order + 1).pow(3)
    }

    /// The elements, each as its nodes.
    pub fn iter(&self) -> impl Iterator<Item = &[u32]> {
        self.elements.chunks_exact(self.nodes_each())
    }
}
