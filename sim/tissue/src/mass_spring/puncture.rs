//! Removes springs along the needle's track.

use super::lattice::Lattice;
use super::laws;
use super::links::{CLASSES, CORNERS};
use super::motion::LatticeMotion;

/// A cylinder cut by a needle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LatticePuncture {
    /// Its axis, as x and y in the patient's frame, in m.
    pub at_m: [f64; 2],
    /// Depth of the boundary that was cut, in m.
    pub depth_m: f64,
    /// Radius, in m.
    pub radius_m: f64,
}

/// Result of a puncture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OpenedSprings {
    /// Number of springs that were removed.
    pub springs: usize,
    /// Energy that they had stored in the whole tissue, in J.
    pub energy_j: f64,
}

impl Lattice {
    /// Removes every spring that ends at a node of the boundary's plane within the needle: the node
    /// is cut out and no longer moves. The rest of the tissue is free to recoil.
    pub fn open(&mut self, motion: &LatticeMotion, puncture: &LatticePuncture) -> OpenedSprings {
        let (upper, part) = self.grid.storey_at(puncture.depth_m);
        let k = if part > 0.5 { upper + 1 } else { upper };
        let mut opened = OpenedSprings::default();
        for [i, j, k] in self.grid.nodes().filter(|node| node[2] == k) {
            let [x_m, y_m, _] = self.grid.position_m([i, j, k]);
            let [dx_m, dy_m] = [x_m - puncture.at_m[0], y_m - puncture.at_m[1]];
            if dx_m * dx_m + dy_m * dy_m <= puncture.radius_m * puncture.radius_m {
                self.cut_out([i, j, k], motion, &mut opened);
            }
        }
        self.refresh();
        opened.energy_j *= self.symmetric_parts();
        opened
    }

    fn cut_out(&mut self, [i, j, k]: [usize; 3], motion: &LatticeMotion, opened: &mut OpenedSprings) {
        let node = self.grid.place([i, j, k]);
        for (at, class) in CLASSES.iter().enumerate() {
            for end in class.ends.map(|end| CORNERS[end]) {
                let Some(anchor) = before([i, j, k], end) else { continue };
                let ends = class.ends.map(|end| self.grid.place(anchor) + self.grid.place(CORNERS[end]));
                let constant = f64::from(std::mem::take(&mut self.constants[at][self.grid.place(anchor)]));
                if constant > 0.0 {
                    let u = &motion.displacement_m.axes;
                    let change_m = [0, 1, 2].map(|axis| u[axis][ends[1]] - u[axis][ends[0]]);
                    let link = &self.links[anchor[2]][at];
                    opened.springs += 1;
                    opened.energy_j += laws::energy_j(link, constant, change_m);
                }
            }
        }
        for axis in 0..3 {
            self.masses.axes[axis][node] = 0.0;
        }
    }
}

/// The node, if there is one, from which `steps` lead to this one.
fn before(node: [usize; 3], steps: [usize; 3]) -> Option<[usize; 3]> {
    let back = [0, 1, 2].map(|axis| node[axis].checked_sub(steps[axis]));
    Some([back[0]?, back[1]?, back[2]?])
}
