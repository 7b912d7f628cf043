//! The load of 1 N as forces on the nodes.

use nalgebra::{Matrix3, Vector3};

use super::mesh::PatchMesh;
use super::{Body, Footprint, Problem3, basis};
use crate::multifrontal::FIXED;

/// Quadrature points across an element: enough for a footprint much smaller than the element.
const ACROSS: usize = 16;

/// Quadrature points along the depth.
const ALONG: usize = 4;

/// Forces on the unknowns of a load of 1 N into the body along the needle, in N; multiplied by
/// `share` if only a part of the tissue is meshed. Their sum is exact for any quadrature and
/// curvature of the skin.
pub(super) fn unit_load(problem: &Problem3, patch: &PatchMesh, body: &Body, share: f64) -> Vec<f64> {
    let [from, to] = problem.flat.load.ends_m();
    let direction = Vector3::new(libm::sin(problem.tilt_rad), 0.0, -libm::cos(problem.tilt_rad));
    let mut load = vec![0.0; body.unknowns()];
    let mut sum = 0.0;
    let intervals = patch.planes_m.len() - 1;
    let per_interval = body.elements() / intervals;
    let close = |a: f64, b: f64| (a - b).abs() < 2e-9;
    let mut add = |interval: usize, height: &[(f64, f64)]| {
        for element in interval * per_interval..(interval + 1) * per_interval {
            sum += Element { problem, patch, body, element }.add(height, &direction, &mut load);
        }
    };
    if close(from, to) {
        // The plane is the top of the elements below it, or the bottom of those above the base.
        let plane = patch.planes_m.iter().position(|&plane| close(plane, from)).unwrap_or(0);
        let (interval, zeta) = if plane < intervals { (plane, 1.0) } else { (intervals - 1, -1.0) };
        add(interval, &[(zeta, 1.0)]);
    } else {
        let height = basis::gauss_rule(ALONG);
        for (interval, planes) in patch.planes_m.windows(2).enumerate() {
            let middle = 0.5 * (planes[0] + planes[1]);
            let scale = planes[1] - planes[0];
            if middle > from && middle < to {
                add(interval, &height.iter().map(|&(zeta, weight)| (zeta, weight * scale)).collect::<Vec<_>>());
            }
        }
    }
    if sum > 0.0 {
        load.iter_mut().for_each(|force| *force *= share / sum);
    }
    load
}

/// A loaded element.
struct Element<'a> {
    problem: &'a Problem3,
    patch: &'a PatchMesh,
    body: &'a Body,
    element: usize,
}

impl Element<'_> {
    /// Adds the Gaussian traction at these heights ζ with these weights. Returns its sum over the
    /// element.
    fn add(&self, height: &[(f64, f64)], direction: &Vector3<f64>, load: &mut [f64]) -> f64 {
        let across = basis::gauss_rule(ACROSS);
        let mut sum = 0.0;
        for &(zeta, height) in height {
            for (eta, along) in &across {
                for (xi, weight) in &across {
                    sum += self.add_point([*xi, *eta, zeta], height * along * weight, direction, load);
                }
            }
        }
        sum
    }

    fn add_point(&self, at: [f64; 3], weight: f64, direction: &Vector3<f64>, load: &mut [f64]) -> f64 {
        let locator = self.body.locator();
        let each = self.body.mesh().nodes_each();
        let nodes = &self.body.mesh().elements[self.element * each..][..each];
        let (mut flat, mut place, mut jacobian) = (Vector3::zeros(), Vector3::zeros(), Matrix3::zeros());
        let is_bent = self.problem.footprint == Footprint::Bent;
        let bent_m = &self.body.mesh().nodes_m;
        locator.each(&at.into(), |node, value, slope| {
            let node = nodes[node] as usize;
            flat += self.patch.flat_m[node].coords * value;
            let measured = if is_bent { bent_m[node].coords } else { self.patch.flat_m[node].coords };
            place += measured * value;
            jacobian += measured * slope.transpose();
        });
        let [from, to] = self.problem.flat.load.ends_m();
        let depth_m = (-flat.z).clamp(from, to);
        let across = jacobian.column(0).cross(&jacobian.column(1));
        // The boundary is level before the skin is bent.
        let (area, off) = if is_bent {
            (across.norm(), place - self.problem.on_needle(depth_m).coords)
        } else {
            let off = place - self.problem.on_flat_needle(depth_m).coords;
            (across.z.abs(), Vector3::new(off.x, off.y, 0.0))
        };
        let distance = off / self.problem.flat.load.radius_m;
        let share = libm::exp(-distance.norm_squared()) * area * weight;
        let unknowns = self.body.unknowns_of(self.element);
        locator.each(&at.into(), |node, value, _| {
            for (axis, &unknown) in unknowns[3 * node..][..3].iter().enumerate().filter(|&(_, &u)| u != FIXED) {
                load[unknown as usize] += share * value * direction[axis];
            }
        });
        share
    }
}
