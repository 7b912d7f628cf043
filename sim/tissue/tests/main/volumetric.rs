//! The elements of the volumetric model by law: what they must reproduce exactly, whatever their shape, and what a
//! turn must not cost. They could fail on a wrong map of a distorted element, a missing term of the stiffness, or a
//! rotation that is not the nearest.

use nalgebra::{Matrix3, Point3, Rotation3, Vector3};
use tissue::volumetric::{Body, Effort, HexMesh, Material, TissueMotion};

pub const SOFT: Material = Material { youngs_modulus_pa: 1e6, poisson_ratio: 0.3, density_kg_per_m3: 1000.0 };

/// A 2 × 2 × 2 block with no right angle inside it, with these material and held nodes.
pub fn distorted(order: usize, material: Material, held: impl Fn(&Point3<f64>) -> [bool; 3]) -> Body {
    let mut mesh = HexMesh::cuboid(order, [0.1, 0.08, 0.06], [2, 2, 2]);
    for node in &mut mesh.nodes_m {
        let bump = |x: f64, length: f64| x * (length - x) / (length * length);
        let size = 64.0 * bump(node.x, 0.1) * bump(node.y, 0.08) * bump(node.z, 0.06);
        *node += Vector3::new(0.006, -0.004, 0.005) * size;
    }
    let nodes = mesh.nodes_m.clone();
    Body::new(mesh, |_, _| material, |node| held(&nodes[node])).expect("a body")
}

fn on_surface(point: &Point3<f64>) -> bool {
    let ends = Vector3::new(0.1, 0.08, 0.06);
    (0..3).any(|axis| point[axis] < 1e-12 || point[axis] > ends[axis] - 1e-12)
}

/// Largest force at a node inside a distorted block under a uniform strain, over the largest at its surface.
pub fn patch_test(order: usize) -> f64 {
    let body = distorted(order, SOFT, |_| [false; 3]);
    let gradient = Matrix3::new(1e-3, 2e-3, -1e-3, 5e-4, -2e-3, 1e-3, 3e-3, -1e-3, 2e-3);
    let u = body.interpolate_m(|point| gradient * point.coords);
    let mut force = vec![0.0; body.unknowns()];
    body.linear_energy_j(&u, &mut force);
    let inside = body.interpolate_m(|point| Vector3::repeat(if on_surface(point) { 0.0 } else { 1.0 }));
    let largest = |wanted: f64| {
        let found = force.iter().zip(&inside).filter(|&(_, inside)| (inside - wanted).abs() < 0.5);
        found.map(|(force, _)| force.abs()).fold(0.0, f64::max)
    };
    largest(1.0) / largest(0.0)
}

#[test]
fn a_uniform_strain_is_in_equilibrium_in_a_distorted_mesh() {
    for order in 2..=4 {
        let found = patch_test(order);
        assert!(found < 1e-12, "order {order}: {found:e}");
    }
}

/// Largest force of a block turned by 90° and moved, over that of the same displacements taken for small.
pub fn rigid_turn(order: usize) -> f64 {
    let body = distorted(order, SOFT, |_| [false; 3]);
    let turn = Rotation3::from_scaled_axis(Vector3::new(1.0, 2.0, -1.0).normalize() * std::f64::consts::FRAC_PI_2);
    let u = body.interpolate_m(|point| turn * point.coords - point.coords + Vector3::new(0.3, 0.0, -0.2));
    let largest = |force: &[f64]| force.iter().fold(0.0, |most: f64, force| most.max(force.abs()));
    let (mut turned, mut small) = (vec![0.0; body.unknowns()], vec![0.0; body.unknowns()]);
    body.energy_j(&u, &mut turned);
    body.linear_energy_j(&u, &mut small);
    largest(&turned) / largest(&small)
}

#[test]
fn a_rigid_turn_by_90_degrees_costs_no_force() {
    for order in 2..=4 {
        let found = rigid_turn(order);
        assert!(found < 1e-12, "order {order}: {found:e}");
    }
}

#[test]
fn force_is_the_slope_of_the_energy_even_in_inverted_elements() {
    let body = distorted(2, SOFT, |_| [false; 3]);
    let fold = |point: &Point3<f64>| Vector3::new(-1.6 * point.x, 0.3 * point.z, 40.0 * point.x * point.y);
    let (u, way) = (body.interpolate_m(fold), body.interpolate_m(|point| Vector3::new(point.y, 0.02, -point.x)));
    let energy = |length: f64| {
        let moved: Vec<f64> = u.iter().zip(&way).map(|(u, way)| u + length * way).collect();
        body.energy_j(&moved, &mut vec![0.0; body.unknowns()])
    };
    let mut force = vec![0.0; body.unknowns()];
    body.energy_j(&u, &mut force);
    let slope: f64 = force.iter().zip(&way).map(|(force, way)| force * way).sum();
    let difference = (energy(1e-5) - energy(-1e-5)) / 2e-5;
    assert!((slope - difference).abs() < 1e-6 * slope.abs(), "{slope} against {difference}");
}

#[test]
fn the_factor_is_that_of_the_force() {
    let body = distorted(3, SOFT, |point| [point.z < 1e-12; 3]);
    let wanted = body.interpolate_m(|point| Vector3::new(point.z * point.y, point.z * point.z, point.x * point.z));
    let mut found = vec![0.0; body.unknowns()];
    body.linear_energy_j(&wanted, &mut found);
    let factor = body.factorise(0.0).expect("held");
    factor.solve(&mut found, &mut vec![0.0; factor.scratch_len()]);
    let wrong = found.iter().zip(&wanted).map(|(f, w)| (f - w).abs()).fold(0.0, f64::max);
    assert!(wrong < 1e-10 * wanted.iter().fold(0.0, |most: f64, w| most.max(w.abs())), "{wrong:e}");
}

/// Deflection in m of a cantilever of 10 × 10 × 100 mm, 1 MPa, ν 0 under 0.01 N at its end.
pub fn cantilever(order: usize) -> f64 {
    let mesh = HexMesh::cuboid(order, [0.1, 0.01, 0.01], [8, 1, 1]);
    let material = Material { poisson_ratio: 0.0, ..SOFT };
    let clamped: Vec<bool> = mesh.nodes_m.iter().map(|node| node.x < 1e-12).collect();
    let body = Body::new(mesh, |_, _| material, |node| [clamped[node]; 3]).expect("a body");
    // The end face moves as one under a load spread over it: by Simpson's rule or Lobatto's, the weights of its nodes.
    let end = body.interpolate_m(|point| Vector3::new(0.0, 0.0, f64::from(u8::from(point.x > 0.1 - 1e-12))));
    let mut load: Vec<f64> = body.mass_kg().iter().zip(&end).map(|(mass, end)| mass * end).collect();
    let sum: f64 = load.iter().sum();
    load.iter_mut().for_each(|load| *load *= -0.01 / sum);
    let mut motion = TissueMotion::new(&body, None, Effort { iterations: 40, tolerance: 1e-8 }).expect("held");
    assert!(motion.step(&body, &load).converged);
    -body.displacement_m(motion.u_m(), &Point3::new(0.1, 0.005, 0.005)).z
}

#[test]
fn a_cantilever_bends_as_timoshenkos_beam() {
    for order in 2..=3 {
        let found = cantilever(order);
        assert!((found - 4.024e-3).abs() < 0.005 * 4.024e-3, "order {order}: {found} m");
    }
}

/// Relative L2 error, in a sheet of 0.1 m between two smooth planes, of the answer to the body force that makes
/// u = sin(kx) sin(ky) (1, −1/2, 0).
fn manufactured_error(order: usize, elements: usize) -> f64 {
    let side = 0.1;
    let k = std::f64::consts::PI / side;
    let way = Vector3::new(1.0, -0.5, 0.0);
    let waves = |point: &Point3<f64>| {
        let [x, y] = [k * point.x, k * point.y];
        (libm::sin(x) * libm::sin(y), libm::cos(x) * libm::cos(y))
    };
    let wanted = |point: &Point3<f64>| way * waves(point).0;
    let (lambda, mu) = SOFT.lame_pa();
    // f = −(λ + μ) ∇(∇·u) − μ ∆u.
    let force = |point: &Point3<f64>| {
        let (sines, cosines) = waves(point);
        let gradient = Vector3::new(way.y * cosines - way.x * sines, way.x * cosines - way.y * sines, 0.0);
        (way * (2.0 * mu * sines) - gradient * (lambda + mu)) * (k * k)
    };
    let thickness = side / elements as f64;
    let mesh = HexMesh::cuboid(order, [side, side, thickness], [elements, elements, 1]);
    let at_end = |at: f64, end: f64| at < 1e-12 || at > end - 1e-12;
    let clamped = |node: &Point3<f64>| at_end(node.x, side) || at_end(node.y, side);
    let held: Vec<[bool; 3]> = mesh
        .nodes_m
        .iter()
        .map(|node| [clamped(node), clamped(node), clamped(node) || at_end(node.z, thickness)])
        .collect();
    let body = Body::new(mesh, |_, _| SOFT, |node| held[node]).expect("a body");
    let forces = body.interpolate_m(force);
    let volume = body.mass_kg().iter().map(|mass| mass / SOFT.density_kg_per_m3);
    let mut u: Vec<f64> = forces.iter().zip(volume).map(|(force, volume)| force * volume).collect();
    let factor = body.factorise(0.0).expect("held");
    factor.solve(&mut u, &mut vec![0.0; factor.scratch_len()]);
    let (mut wrong, mut whole) = (0.0, 0.0);
    for at in 0..300_u32 {
        // Places that no mesh has as its nodes.
        let share = |step: f64| libm::fmod(step * f64::from(at + 1), 1.0);
        let place = Point3::new(side * share(0.754_878), side * share(0.569_840), thickness * share(0.618_034));
        let truth = wanted(&place);
        wrong += (body.displacement_m(&u, &place) - truth).norm_squared();
        whole += truth.norm_squared();
    }
    (wrong / whole).sqrt()
}

#[test]
fn error_falls_one_power_faster_than_the_element_order() {
    for (order, coarse) in [(2, 6), (3, 4)] {
        let errors = [coarse, 2 * coarse].map(|elements| manufactured_error(order, elements));
        let slope = libm::log2(errors[0] / errors[1]);
        assert!((slope - (order as f64 + 1.0)).abs() < 0.3, "order {order}: {slope} from {errors:?}");
    }
}
