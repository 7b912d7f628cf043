//! Lengths of rays in surfaces. Fails if an edge between triangles is counted twice or not at all, if a surface is turned
//! inside out, or if a length is measured along the central ray.

use anatomy::BodyMesh;
use guidance::{CArm, Detector, ImagedNeedle, project};
use nalgebra::{Point3, Vector3};
use parry3d_f64::math::Vector;
use parry3d_f64::query::{Ray, RayCast};
use parry3d_f64::shape::{Ball, Cuboid};

const PIXELS: usize = 128;

fn turned_arm(orbital_deg: f64, tilt_deg: f64) -> CArm {
    let arm = CArm::over(Point3::new(0.01, -0.02, 0.0));
    CArm { orbital_rad: orbital_deg.to_radians(), tilt_rad: tilt_deg.to_radians(), ..arm }
}

fn arms() -> [CArm; 4] {
    [turned_arm(0.0, 0.0), turned_arm(30.0, 0.0), turned_arm(-45.0, 45.0), turned_arm(90.0, -20.0)]
}

pub fn box_mesh(half: [f64; 3]) -> BodyMesh {
    let corner = |at: usize| {
        Point3::from(Vector3::from_fn(|axis, _| if at >> axis & 1 == 1 { half[axis] } else { -half[axis] }))
    };
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    BodyMesh { vertices_m: (0..8).map(corner).collect(), triangles }
}

/// A ball of latitudes and longitudes.
fn ball_mesh(radius: f64, rings: u32) -> BodyMesh {
    let segments = 2 * rings;
    let place = |ring: u32, segment: u32| {
        let latitude = std::f64::consts::PI * f64::from(ring) / f64::from(rings);
        let longitude = std::f64::consts::TAU * f64::from(segment % segments) / f64::from(segments);
        let (sin, cos) = libm::sincos(latitude);
        let (to_side, ahead) = libm::sincos(longitude);
        Point3::new(radius * sin * ahead, radius * sin * to_side, radius * cos)
    };
    let index = |ring: u32, segment: u32| match ring {
        0 => 0,
        ring if ring == rings => 1,
        ring => 2 + (ring - 1) * segments + segment % segments,
    };
    let mut vertices_m = vec![place(0, 0), place(rings, 0)];
    vertices_m.extend((1..rings).flat_map(|ring| (0..segments).map(move |segment| place(ring, segment))));
    let mut triangles = Vec::new();
    for (ring, segment) in (0..rings).flat_map(|ring| (0..segments).map(move |segment| (ring, segment))) {
        let [a, b] = [index(ring, segment), index(ring, segment + 1)];
        let [c, d] = [index(ring + 1, segment), index(ring + 1, segment + 1)];
        triangles.extend([[a, c, d], [a, d, b]].into_iter().filter(|[a, b, c]| a != b && b != c && c != a));
    }
    BodyMesh { vertices_m, triangles }
}

/// The length of a ray inside a convex shape of parry3d, from its two surfaces.
fn length_in(shape: &dyn RayCast, from: &Point3<f64>, over: &Vector3<f64>) -> f64 {
    let vector = |v: &Vector3<f64>| Vector::new(v.x, v.y, v.z);
    let there = Ray::new(vector(&from.coords), vector(over));
    let Some(enters) = shape.cast_local_ray(&there, 1.0, false) else { return 0.0 };
    let back = Ray::new(vector(&(from.coords + over)), vector(&-over));
    let leaves = shape.cast_local_ray(&back, 1.0, false).expect("a ray that enters leaves");
    (1.0 - enters - leaves).max(0.0) * over.norm()
}

fn greatest_difference(arm: &CArm, mesh: &BodyMesh, expected: &dyn Fn(&Point3<f64>, &Vector3<f64>) -> f64) -> f64 {
    let detector = Detector::new(arm, PIXELS);
    let image = project(&detector, mesh).unwrap();
    let off = |at: usize| {
        let ray = detector.ray((at % PIXELS) as f64 + 0.5, (at / PIXELS) as f64 + 0.5);
        (image.lengths_m[at] - expected(&detector.source_m(), &ray)).abs()
    };
    assert!(image.lengths_m.iter().any(|length_m| *length_m > 0.0));
    (0..PIXELS * PIXELS).map(off).fold(0.0, f64::max)
}

#[test]
fn a_box_has_the_lengths_of_its_closed_form() {
    let half = [0.03, 0.05, 0.02];
    let shape = Cuboid::new(Vector::new(half[0], half[1], half[2]));
    for arm in arms() {
        let off = greatest_difference(&arm, &box_mesh(half), &|from, over| length_in(&shape, from, over));
        assert!(off <= 1e-9, "{off} m at {arm:?}");
    }
}

#[test]
fn a_ball_of_facets_stays_within_its_chords() {
    let (radius, rings) = (0.04, 200);
    let shape = Ball::new(radius);
    let chord = radius * (1.0 - libm::cos(std::f64::consts::PI / f64::from(rings)));
    for arm in arms() {
        let detector = Detector::new(&arm, PIXELS);
        let image = project(&detector, &ball_mesh(radius, rings)).unwrap();
        for at in 0..PIXELS * PIXELS {
            let ray = detector.ray((at % PIXELS) as f64 + 0.5, (at / PIXELS) as f64 + 0.5);
            let expected = length_in(&shape, &detector.source_m(), &ray);
            // A facet lies up to a chord below the ball: the ray meets it later by that over the cosine.
            let cosine = (expected / (2.0 * radius)).max(1e-9);
            let allowed = (2.2 * chord / cosine).min(2.0 * (2.2 * 2.0 * radius * chord).sqrt());
            let off = (image.lengths_m[at] - expected).abs();
            assert!(off <= allowed, "{off} m, allowed {allowed} m at {at} of {arm:?}");
        }
    }
}

#[test]
fn nested_surfaces_add_up() {
    let (outer, inner) = ([0.05, 0.05, 0.05], [0.02, 0.03, 0.01]);
    let [outer_shape, inner_shape] = [outer, inner].map(|half| Cuboid::new(Vector::new(half[0], half[1], half[2])));
    let arm = turned_arm(20.0, 10.0);
    let detector = Detector::new(&arm, PIXELS);
    let [around, inside] = [outer, inner].map(|half| project(&detector, &box_mesh(half)).unwrap());
    for at in 0..PIXELS * PIXELS {
        let ray = detector.ray((at % PIXELS) as f64 + 0.5, (at / PIXELS) as f64 + 0.5);
        let [expected, less] = [&outer_shape, &inner_shape].map(|shape| length_in(shape, &detector.source_m(), &ray));
        let off = around.lengths_m[at] - inside.lengths_m[at] - (expected - less);
        assert!(off.abs() <= 1e-9, "{off} m");
    }
}

#[test]
fn an_edge_on_a_pixel_counts_once() {
    // The box's diagonals and edges pass through the middles of pixels at an odd number of them.
    let mesh = box_mesh([0.03, 0.03, 0.03]);
    let detector = Detector::new(&CArm::over(Point3::origin()), 101);
    let image = project(&detector, &mesh).unwrap();
    let middle = image.lengths_m[50 * 101 + 50];
    assert!((middle - 0.06).abs() <= 1e-12, "{middle} m");
    for at in 0..101 * 101 {
        let length_m = image.lengths_m[at];
        assert!((0.0..0.11).contains(&length_m), "{length_m} m at {at}");
    }
}

#[test]
fn a_needle_is_a_tube_with_its_stylet_or_without() {
    let needle = ImagedNeedle {
        tip_m: Point3::new(0.0, 0.0, -0.01),
        direction: -Vector3::z(),
        length_m: 0.15,
        outer_m: 1.27e-3,
        bore_m: 0.9e-3,
        has_stylet: true,
    };
    let hollow = ImagedNeedle { has_stylet: false, ..needle };
    let from = Point3::new(-1.0, 0.0, 0.03);
    let across = Vector3::new(2.0, 0.0, 0.0);
    assert!((needle.steel_m(&from, &across) - 1.27e-3).abs() <= 1e-12);
    assert!((hollow.steel_m(&from, &across) - 0.37e-3).abs() <= 1e-12);
    // 0.3 mm beside the axis.
    let beside = Point3::new(-1.0, 0.3e-3, 0.03);
    let expected = 2.0 * ((0.635e-3_f64.powi(2) - 9e-8).sqrt() - (0.45e-3_f64.powi(2) - 9e-8).sqrt());
    assert!((hollow.steel_m(&beside, &across) - expected).abs() <= 1e-12);
    // Beyond the tip, beside the shaft, and along it.
    assert_eq!(needle.steel_m(&Point3::new(-1.0, 0.0, -0.011), &across), 0.0);
    assert_eq!(needle.steel_m(&Point3::new(-1.0, 0.7e-3, 0.03), &across), 0.0);
    let down = Vector3::new(0.0, 0.0, -1.0);
    assert!((needle.steel_m(&Point3::new(1e-4, 0.0, 0.5), &down) - 0.15).abs() <= 1e-12);
    assert_eq!(hollow.steel_m(&Point3::new(1e-4, 0.0, 0.5), &down), 0.0);
}

#[test]
fn a_body_at_the_tube_is_refused() {
    let arm = CArm { isocentre_m: Point3::new(0.0, 0.0, 0.53), ..CArm::over(Point3::origin()) };
    let refused = project(&Detector::new(&arm, PIXELS), &box_mesh([0.05; 3])).unwrap_err();
    assert_eq!(refused.to_string(), "a part of the body 20 mm from the source; allowed: 50 to 1000 mm");
}

#[test]
fn a_point_is_found_again_from_two_views() {
    // Triangulation: the rays of two views through a point's pixels meet in it.
    let point = Point3::new(0.021, -0.034, -0.045);
    let rays = [turned_arm(0.0, 0.0), turned_arm(30.0, 0.0)].map(|arm| {
        let detector = Detector::new(&arm, guidance::PIXELS);
        let place = detector.project(&point);
        (detector.source_m(), detector.ray(place.x, place.y).normalize())
    });
    for (source_m, ray) in rays {
        let off = point - source_m;
        assert!((off - ray * off.dot(&ray)).norm() <= 1e-12);
    }
}
