//! The lattice: nodes with masses, springs between them, and the longest stable step.

use law::axial::Domain;

use super::calibration::spring_constants;
use super::grid::{Grid, LatticePatch, LatticeSymmetry};
use super::kernel::{self, NodalField};
use super::links::{CLASSES, CORNERS, Link};
use super::motion::LatticeMotion;
use super::{LatticeError, laws};
use crate::Slab;

/// Damping of the motion: a force −α m v on every node and a dashpot β k along every spring.
///
/// A mode of angular frequency ω then has the damping ratio ζ = α/(2ω) + βω/2 (Rayleigh).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Damping {
    /// α, in 1/s.
    pub mass_per_s: f64,
    /// β, in s.
    pub stiffness_s: f64,
}

/// A lattice of springs, checked and ready to use. Only [`Lattice::open`] changes it.
#[derive(Clone, Debug, PartialEq)]
pub struct Lattice {
    pub(super) grid: Grid,
    pub(super) damping: Damping,
    /// Springs at rest, for each plane and direction.
    pub(super) links: Vec<[Link<f64>; CLASSES.len()]>,
    /// Stretches of every plane of nodes that contain springs.
    pub(super) runs: Vec<[usize; 2]>,
    /// Spring constants, in N/m, for each direction and place. Single precision: rounding one
    /// changes a solution by a smaller relative amount.
    pub(super) constants: [Vec<f32>; CLASSES.len()],
    /// Masses, in kg; 0 along an axis on which the node is held.
    pub(super) masses: NodalField,
    /// 1/mass, in 1/kg; 0 along an axis on which the node is held.
    pub(super) inverse_masses: NodalField,
    /// Stiffness of each node alone at rest, in N/m; 0 where it is held.
    pub(super) diagonal: NodalField,
    /// Bound of the highest angular frequency, in rad/s.
    highest_rad_per_s: f64,
}

/// Safety factor of the stable step, sufficient for rounding.
const SAFETY: f64 = 0.999;

impl Lattice {
    /// Calibrates a lattice on a patch of a slab. Poisson ratios are ignored: springs have 1/4.
    ///
    /// # Errors
    /// If a number is out of range, a layer cannot be split at the spacing, or there are more nodes
    /// than the limit.
    pub fn new(slab: &Slab, patch: &LatticePatch, damping: Damping) -> Result<Self, LatticeError> {
        let grid = Grid::new(slab, patch)?;
        Domain::NotNegative.check("damping.mass_per_s", damping.mass_per_s, "1/s")?;
        Domain::NotNegative.check("damping.stiffness_s", damping.stiffness_s, "s")?;
        let places = grid.places();
        let links =
            (0..grid.depths_m.len()).map(|k| CLASSES.map(|class| Link::new(class, sides_m(&grid, k)))).collect();
        let mut lattice = Self {
            runs: Vec::new(),
            constants: CLASSES.map(|_| vec![0.0; places]),
            masses: NodalField::zeros(places),
            inverse_masses: NodalField::zeros(places),
            diagonal: NodalField::zeros(places),
            highest_rad_per_s: 0.0,
            grid,
            damping,
            links,
        };
        lattice.fill_cells(slab);
        lattice.hold_nodes();
        let plane = lattice.grid.plane();
        let has_springs = |place| lattice.constants.iter().any(|constants| constants[place] > 0.0);
        lattice.runs = kernel::runs(&(0..plane).map(has_springs).collect::<Vec<_>>());
        lattice.highest_rad_per_s = lattice.bound_rad_per_s();
        Ok(lattice)
    }

    /// Degrees of freedom.
    #[must_use]
    pub fn unknowns(&self) -> usize {
        self.masses.axes.iter().flatten().filter(|&&mass| mass > 0.0).count()
    }

    /// Memory, in bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let constants: usize = self.constants.iter().map(|constants| size_of_val(&constants[..])).sum();
        let fields = self.masses.bytes() + self.inverse_masses.bytes() + self.diagonal.bytes();
        constants + fields + size_of_val(&self.links[..]) + size_of_val(&self.runs[..])
    }

    /// Volume of all cells in the computed part, in m³.
    #[must_use]
    pub fn volume_m3(&self) -> f64 {
        self.cells().map(|[.., k]| sides_m(&self.grid, k).iter().product::<f64>()).sum()
    }

    /// The longest step of the explicit integration that is stable in any deformed state of the
    /// lattice, in s.
    ///
    /// Along itself a spring has stiffness k, across itself k (1 − l₀/l) < k, so its stiffness is
    /// at most k in every direction. With Gershgorin's circles of M⁻¹K then ω² ≤ max 2 Σk/m over
    /// the nodes. Symplectic Euler is stable for h² ω² + 2 h (α + β ω²) ≤ 4, with damping evaluated
    /// at the old velocity (Jury's conditions of its two-step recursion). A linearised lattice
    /// would be stable for √3 times the step, but not once its springs are stretched.
    #[must_use]
    pub fn stable_step_s(&self) -> f64 {
        let square = self.highest_rad_per_s * self.highest_rad_per_s;
        let drag = self.damping.mass_per_s + self.damping.stiffness_s * square;
        SAFETY * 4.0 / (drag + (drag * drag + 4.0 * square).sqrt())
    }

    /// Energy stored in the springs of the whole tissue, in J.
    #[must_use]
    pub fn elastic_energy_j(&self, motion: &LatticeMotion) -> f64 {
        self.symmetric_parts() * self.spring_energy_j(&motion.displacement_m)
    }

    /// Kinetic energy of the whole tissue, in J.
    #[must_use]
    pub fn kinetic_energy_j(&self, motion: &LatticeMotion) -> f64 {
        self.symmetric_parts() * self.motion_energy_j(&motion.velocity_m_per_s)
    }

    /// Work that the applied force has done up to now, in J.
    #[must_use]
    pub fn load_work_j(&self, motion: &LatticeMotion) -> f64 {
        self.symmetric_parts() * motion.force_n * motion.load.work_m(&motion.displacement_m)
    }

    /// Ratio of the whole tissue to the computed part.
    pub(super) fn symmetric_parts(&self) -> f64 {
        if self.grid.symmetry == LatticeSymmetry::Quarter { 4.0 } else { 1.0 }
    }

    pub(super) fn motion_energy_j(&self, velocity_m_per_s: &NodalField) -> f64 {
        let axes = self.masses.axes.iter().zip(&velocity_m_per_s.axes);
        axes.map(|(masses, v)| v.iter().zip(masses).map(|(v, m)| 0.5 * m * v * v).sum::<f64>()).sum()
    }

    pub(super) fn spring_energy_j(&self, displacement_m: &NodalField) -> f64 {
        let mut sum_j = 0.0;
        self.for_each_spring(|link, constant, [a, b]| {
            let change_m = [0, 1, 2].map(|axis| displacement_m.axes[axis][b] - displacement_m.axes[axis][a]);
            sum_j += laws::energy_j(link, constant, change_m);
        });
        sum_j
    }

    fn cells(&self) -> impl Iterator<Item = [usize; 3]> {
        let last = [self.grid.side - 1, self.grid.side - 1, self.grid.storeys.len()];
        self.grid.nodes().filter(move |node| (0..3).all(|axis| node[axis] < last[axis]) && self.grid.has_cell(*node))
    }

    /// Sums the contributions of the cells to their springs and nodes.
    fn fill_cells(&mut self, slab: &Slab) {
        let cells: Vec<_> = self.cells().collect();
        for [i, j, k] in cells {
            let layer = &slab.layers[self.grid.storeys[k].layer];
            let sides_m = sides_m(&self.grid, k);
            let constants = spring_constants(layer.youngs_modulus_pa, sides_m);
            for (at, class) in CLASSES.iter().enumerate() {
                let others = class.axes().1;
                let share = constants[at] / f64::from(1 << others.len());
                for corner in corners().filter(|corner| (0..3).all(|axis| corner[axis] == 0 || others.contains(&axis)))
                {
                    let place = self.grid.place([i + corner[0], j + corner[1], k + corner[2]]);
                    self.constants[at][place] += share as f32;
                }
            }
            let share_kg = layer.density_kg_per_m3 * sides_m.iter().product::<f64>() / 8.0;
            for corner in corners() {
                let place = self.grid.place([i + corner[0], j + corner[1], k + corner[2]]);
                self.masses.axes.iter_mut().for_each(|axis| axis[place] += share_kg);
            }
        }
    }

    fn hold_nodes(&mut self) {
        for node in self.grid.nodes() {
            let place = self.grid.place(node);
            for axis in 0..3 {
                if !self.grid.is_free(node, axis) {
                    self.masses.axes[axis][place] = 0.0;
                }
            }
        }
        self.refresh();
    }

    /// Computes the values derived from the masses and the spring constants.
    pub(super) fn refresh(&mut self) {
        let mut diagonal = NodalField::zeros(self.grid.places());
        self.for_each_spring(|link, constant, ends| {
            for (axis, sums) in diagonal.axes.iter_mut().enumerate() {
                let share = link.rest_m[axis] / link.length_m;
                ends.iter().for_each(|&end| sums[end] += constant * share * share);
            }
        });
        self.diagonal = diagonal;
        for axis in 0..3 {
            let inverses = self.inverse_masses.axes[axis].iter_mut().zip(&mut self.diagonal.axes[axis]);
            for ((inverse, diagonal), &mass) in inverses.zip(&self.masses.axes[axis]) {
                *inverse = if mass > 0.0 { 1.0 / mass } else { 0.0 };
                *diagonal = if mass > 0.0 { *diagonal } else { 0.0 };
            }
        }
    }

    fn bound_rad_per_s(&self) -> f64 {
        let mut sums = vec![0.0; self.grid.places()];
        self.for_each_spring(|_, constant, ends| ends.iter().for_each(|&end| sums[end] += constant));
        let squares = |axis: &Vec<f64>| {
            axis.iter().zip(&sums).fold(0.0_f64, |most, (inverse, sum)| most.max(2.0 * inverse * sum))
        };
        self.inverse_masses.axes.iter().map(squares).fold(0.0_f64, f64::max).sqrt()
    }

    /// Calls `call` with every spring that pulls, and the places of its ends.
    fn for_each_spring(&self, mut call: impl FnMut(&Link<f64>, f64, [usize; 2])) {
        for [i, j, k] in self.grid.nodes() {
            for (at, class) in CLASSES.iter().enumerate() {
                let constant = f64::from(self.constants[at][self.grid.place([i, j, k])]);
                if constant > 0.0 {
                    let ends = class.ends.map(|end| self.grid.place([i, j, k]) + self.grid.place(CORNERS[end]));
                    call(&self.links[k][at], constant, ends);
                }
            }
        }
    }
}

/// The eight corners of a cell.
fn corners() -> impl Iterator<Item = [usize; 3]> {
    (0..8).map(|bits| [bits & 1, bits >> 1 & 1, bits >> 2])
}

/// Sides of the cells below a plane, in m; for the base, those of the cells above.
fn sides_m(grid: &Grid, k: usize) -> [f64; 3] {
    [grid.spacing_m, grid.spacing_m, grid.storeys[k.min(grid.storeys.len() - 1)].height_m]
}
