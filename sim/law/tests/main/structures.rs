//! Structures: how far, inside or not, hit once per entry, and bone's push.
//!
//! It would fail if a shape were placed or measured in another frame, if only the tip and not the shaft could hit, if
//! a structure were reported at every tick, or if a broken mesh were believed.

use law::puncture::{PunctureEvent, PunctureParams, PunctureScratch, PunctureSpec, measure_clearance_m};
use law::structures::{Shape, StructureKind, StructureSpec, Wall};
use nalgebra::{Point3, Vector3};
use trials::needle::DrivenNeedle;
use trials::scenes::paper_axial_spec;

const MM: f64 = 1e-3;

fn structure(kind: StructureKind, shape: Shape, (x, y, z): (f64, f64, f64)) -> StructureSpec {
    StructureSpec {
        name: format!("{kind:?}"),
        kind,
        shape,
        position_m: Point3::new(x * MM, y * MM, z * MM),
        wall: None,
    }
}

fn ball(radius_mm: f64) -> Shape {
    Shape::Sphere { radius_m: radius_mm * MM }
}

/// A cube as a mesh, every triangle with vertices of its own, as STL files have them.
fn cube(half_mm: f64) -> Shape {
    let corner = |bits: u32| {
        let side = |bit: u32| if bits >> bit & 1 == 1 { half_mm * MM } else { -half_mm * MM };
        Point3::new(side(0), side(1), side(2))
    };
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let corners: Vec<u32> = faces.iter().flat_map(|&[a, b, c, d]| [a, b, c, a, c, d]).collect();
    Shape::Mesh {
        vertices_m: corners.iter().map(|&bits| corner(bits)).collect(),
        triangles: (0..12).map(|triangle| [3 * triangle, 3 * triangle + 1, 3 * triangle + 2]).collect(),
    }
}

/// One structure of each shape, all within a needle's reach.
pub fn one_of_each() -> Vec<StructureSpec> {
    let capsule = Shape::Capsule { half_axis_m: Vector3::new(0.0, 30.0 * MM, 0.0), radius_m: 3.0 * MM };
    let cuboid = Shape::Box { half_extents_m: Vector3::new(5.0 * MM, 5.0 * MM, 5.0 * MM) };
    vec![
        structure(StructureKind::Target, ball(5.0), (0.0, 0.0, -25.0)),
        structure(StructureKind::Vessel, capsule, (12.0, 0.0, -15.0)),
        structure(StructureKind::Bone, cuboid, (-15.0, 0.0, -20.0)),
        structure(StructureKind::Organ, cube(5.0), (0.0, 20.0, -20.0)),
    ]
}

fn hits(needle: &DrivenNeedle) -> Vec<(usize, bool)> {
    let hit = |event: &PunctureEvent| match event {
        PunctureEvent::StructureHit { structure, by_tip } => Some((*structure, *by_tip)),
        _ => None,
    };
    needle.scratch.events.iter().filter_map(hit).collect()
}

/// Clearance of a needle straight down at (x, y) mm with its tip at a depth in mm, in mm.
fn clearance_mm(spec: StructureSpec, (x, y): (f64, f64), depth: f64) -> f64 {
    let mut needle = DrivenNeedle::new(paper_axial_spec(), vec![spec]).expect("a valid scene");
    needle.down(x * MM, y * MM, MM);
    needle.down(x * MM, y * MM, -depth * MM);
    measure_clearance_m(&needle.params, &needle.state) / MM
}

#[test]
fn clearance_is_the_geometric_distance_for_every_shape() {
    let capsule = Shape::Capsule { half_axis_m: Vector3::new(0.0, 20.0 * MM, 0.0), radius_m: 3.0 * MM };
    let cuboid = Shape::Box { half_extents_m: Vector3::new(5.0 * MM, 5.0 * MM, 5.0 * MM) };
    let at = (10.0, 0.0, -20.0);
    let organ = |shape: &Shape| structure(StructureKind::Organ, shape.clone(), at);
    // The tip above each (5, 12, 5 and 5 mm up from the centre's depth), then the shaft passing beside.
    let ball = ball(4.0);
    let cases = [
        (&ball, (10.0, 0.0), 8.0, 8.0),
        (&ball, (0.0, 0.0), 30.0, 6.0),
        (&ball, (7.0, 4.0), 30.0, 1.0),
        (&ball, (0.0, 0.0), 20.0 - 24.0_f64.sqrt() * 2.0, (100.0_f64 + 96.0).sqrt() - 4.0),
        (&capsule, (10.0, 15.0), 5.0, 12.0),
        (&capsule, (0.0, 20.0), 30.0, 7.0),
        (&capsule, (10.0, 26.0), 30.0, 3.0),
        (&cuboid, (10.0, 0.0), 12.0, 3.0),
        (&cuboid, (1.0, 0.0), 30.0, 4.0),
        (&cuboid, (2.0, 9.0), 30.0, 5.0),
    ];
    for (shape, place, depth, wanted) in cases {
        let found = clearance_mm(organ(shape), place, depth);
        assert!((found - wanted).abs() < 1e-6, "{shape:?} from {place:?} at {depth}: {found} mm, not {wanted}");
    }
    for (place, depth, wanted) in [((10.0, 0.0), 12.0, 3.0), ((1.0, 0.0), 30.0, 4.0), ((2.0, 9.0), 30.0, 5.0)] {
        let found = clearance_mm(organ(&cube(5.0)), place, depth);
        assert!((found - wanted).abs() < 1e-6, "mesh from {place:?}: {found} mm, not {wanted}");
    }
}

#[test]
fn a_structure_is_hit_once_per_entry_and_again_after_leaving() {
    for shape in [ball(5.0), cube(5.0)] {
        let mut needle =
            DrivenNeedle::new(paper_axial_spec(), vec![structure(StructureKind::Vessel, shape, (0.0, 0.0, -20.0))])
                .expect("a valid scene");
        let mut seen = Vec::new();
        for depth_mm in [-1.0, 10.0, 14.9, 15.1, 20.0, 24.0, 30.0, 20.0, 10.0, 20.0] {
            needle.down(0.0, 0.0, -depth_mm * MM);
            seen.push(hits(&needle).len());
        }
        assert_eq!(seen, [0, 0, 0, 1, 0, 0, 0, 0, 0, 1]);
    }
}

#[test]
fn the_shaft_hits_what_it_is_swept_into() {
    let mut needle =
        DrivenNeedle::new(paper_axial_spec(), vec![structure(StructureKind::Nerve, ball(2.0), (5.0, 0.0, -10.0))])
            .expect("a valid scene");
    needle.down(0.0, 0.0, MM);
    needle.down(0.0, 0.0, -30.0 * MM);
    assert_eq!(hits(&needle), []);
    // The shaft turns about the entry: at 10 mm of depth it moves a third of what the tip does.
    needle.down(12.0 * MM, 0.0, -30.0 * MM);
    assert_eq!(hits(&needle), [(0, false)]);
    needle.down(0.0, 0.0, -30.0 * MM);
    assert_eq!(hits(&needle), []);
    needle.down(5.0 * MM, 0.0, -10.0 * MM);
    assert_eq!(measure_clearance_m(&needle.params, &needle.state).to_bits(), 0.0_f64.to_bits());
    assert_eq!(hits(&needle), [(0, true)]);
}

#[test]
fn targets_are_hit_but_do_not_count_for_clearance() {
    let mut needle =
        DrivenNeedle::new(paper_axial_spec(), vec![structure(StructureKind::Target, ball(5.0), (0.0, 0.0, -20.0))])
            .expect("a valid scene");
    needle.down(0.0, 0.0, MM);
    needle.down(0.0, 0.0, -20.0 * MM);
    assert_eq!(hits(&needle), [(0, true)]);
    assert!(measure_clearance_m(&needle.params, &needle.state).is_infinite());
}

#[test]
fn bone_pushes_the_tip_along_its_normal_at_2500_n_per_m() {
    let cuboid = Shape::Box { half_extents_m: Vector3::new(10.0 * MM, 10.0 * MM, 10.0 * MM) };
    for shape in [ball(10.0), cuboid, cube(10.0)] {
        let mut needle =
            DrivenNeedle::new(paper_axial_spec(), vec![structure(StructureKind::Bone, shape, (0.0, 0.0, -20.0))])
                .expect("a valid scene");
        let outside = needle.down(0.0, 0.0, -9.0 * MM);
        let inside = needle.down(0.0, 0.0, -12.0 * MM);
        assert!(outside.structures_n.norm() <= 0.0);
        assert!((inside.structures_n - Vector3::new(0.0, 0.0, 5.0)).norm() < 1e-9, "{}", inside.structures_n);
        let whole_n = Vector3::z() * inside.axial.total_n() + inside.lateral_n + inside.structures_n;
        assert!((inside.force_n - whole_n).norm() < 1e-12);
    }
    let vessel = structure(StructureKind::Vessel, ball(10.0), (0.0, 0.0, -20.0));
    assert!(
        DrivenNeedle::new(paper_axial_spec(), vec![vessel])
            .expect("a valid scene")
            .down(0.0, 0.0, -12.0 * MM)
            .structures_n
            .norm()
            <= 0.0,
        "only bone is stiff"
    );
}

#[test]
fn centre_of_a_bone_gives_a_finite_force() {
    let mut needle =
        DrivenNeedle::new(paper_axial_spec(), vec![structure(StructureKind::Bone, ball(10.0), (0.0, 0.0, -20.0))])
            .expect("a valid scene");
    let output = needle.down(0.0, 0.0, -20.0 * MM);
    assert!(output.force_n.iter().all(|force| force.is_finite()));
}

#[test]
fn invalid_shape_is_rejected_with_its_place_and_the_rule() {
    let Shape::Mesh { vertices_m, triangles } = cube(5.0) else { panic!("a mesh") };
    let mesh = |triangles: Vec<[u32; 3]>| Shape::Mesh { vertices_m: vertices_m.clone(), triangles };
    let inverted = triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
    let mut nan = vertices_m.clone();
    nan[3].x = f64::NAN;
    let cases = [
        (ball(0.0), "structures[0] (Organ).radius_m = 0 m: must be a number above 0, to 1e9"),
        (ball(f64::NAN), "structures[0] (Organ).radius_m = NaN m"),
        (Shape::Box { half_extents_m: Vector3::new(1.0, -1.0, 1.0) }, "structures[0] (Organ).half_extents_m = -1 m"),
        (Shape::Capsule { half_axis_m: Vector3::new(f64::INFINITY, 0.0, 0.0), radius_m: 1.0 }, "half_axis_m = inf m"),
        (mesh(vec![]), "mesh = 0 triangles: must have at least 4"),
        (mesh(vec![[0, 1, 99]]), "mesh = 99 (vertex index): must be the index of a vertex"),
        (mesh(triangles[1..].to_vec()), "mesh = 3 open edges: must be closed"),
        (mesh(inverted), "must have triangles counter-clockwise seen from outside"),
        (Shape::Mesh { vertices_m: nan, triangles: triangles.clone() }, "vertices_m = NaN m"),
    ];
    for (shape, wanted) in cases {
        let spec = PunctureSpec {
            axial: paper_axial_spec(),
            lateral_stiffness_n_per_m2: 10_000.0,
            needle_length_m: 0.15,
            hub_stiffness_n_per_m: None,
            needle_bending_n_m2: None,
            skin: law::Skin::Flat,
            structures: vec![structure(StructureKind::Organ, shape, (0.0, 0.0, -20.0))],
        };
        let error = PunctureParams::new(spec).expect_err("must be refused").to_string();
        assert!(error.contains(wanted), "{error}");
    }
}

/// A vessel of 2 mm radius across the way, its middle 12 mm deep, with a wall that gives way at 0.6 N after 1 mm.
fn walled() -> StructureSpec {
    let shape = Shape::Capsule { half_axis_m: Vector3::new(0.0, 0.02, 0.0), radius_m: 2.0 * MM };
    let wall = Some(Wall { stiffness_n_per_m: 600.0, rupture_n: 0.6 });
    StructureSpec { wall, ..structure(StructureKind::Vessel, shape, (0.0, 0.0, -12.0)) }
}

#[test]
fn vessel_wall_resists_until_it_ruptures_and_stays_open() {
    let mut needle = DrivenNeedle::new(paper_axial_spec(), vec![walled()]).expect("a valid scene");
    let mut wall_n = |depth_mm: f64| needle.down(0.0, 0.0, -depth_mm * MM).structures_n.z;
    assert!(wall_n(-1.0).abs() <= 0.0);
    assert!(wall_n(9.9).abs() <= 0.0, "nothing outside");
    assert!((wall_n(10.5) - 0.3).abs() < 1e-9, "half a millimetre of 600 N/m");
    assert!((wall_n(10.99) - 0.594).abs() < 1e-9, "just before it gives way");
    assert!(wall_n(11.01).abs() <= 0.0, "it has given way");
    assert!(wall_n(10.5).abs() <= 0.0 && wall_n(9.0).abs() <= 0.0 && wall_n(10.5).abs() <= 0.0, "and stays open");
}

#[test]
fn a_new_track_meets_the_wall_again_and_an_old_one_does_not() {
    let mut needle = DrivenNeedle::new(paper_axial_spec(), vec![walled()]).expect("a valid scene");
    let mut wall_n = |y_mm: f64, depth_mm: f64| needle.down(0.0, y_mm * MM, -depth_mm * MM).structures_n.norm();
    let mut puncture = |y_mm: f64| {
        let path = [-1.0, 9.0, 10.5, 11.5, -1.0];
        path.map(|depth_mm| wall_n(y_mm, depth_mm)).into_iter().fold(0.0, f64::max)
    };
    let felt = [puncture(0.0), puncture(1.0), puncture(6.0)];
    assert!(felt[0] > 0.2 && felt[1] <= 0.0 && felt[2] > 0.2, "first, the same track, 6 mm beside: {felt:?} N");
}

/// A structure far away is not searched for at every tick. The answer is the same as from a scratch that has seen nothing before.
#[test]
fn what_was_seen_before_changes_no_bit_of_an_answer() {
    let mut structures = one_of_each();
    structures.push(structure(StructureKind::Vessel, ball(2.0), (3.0, -4.0, -40.0)));
    let needle = || DrivenNeedle::new(paper_axial_spec(), structures.clone()).expect("a valid scene");
    let (mut seen, mut fresh, mut hits) = (needle(), needle(), 0);
    // In and out, wandering by 3 mm, with leaps; a golden angle keeps the places apart.
    for tick in 0..4000_u32 {
        let turn = f64::from(tick) * 2.399_963_229_728_653;
        let aside_mm = if tick % 97 == 0 { 9.0 } else { 3.0 };
        let depth_mm = 25.0 * (1.0 - libm::cos(f64::from(tick) * 0.006));
        let [x_m, y_m] = [libm::cos(turn), libm::sin(turn)].map(|part| aside_mm * part * MM);
        fresh.scratch = PunctureScratch::new(&fresh.params);
        let z_m = (2.0 - depth_mm) * MM;
        assert_eq!(seen.down(x_m, y_m, z_m), fresh.down(x_m, y_m, z_m), "tick {tick}");
        assert_eq!(seen.scratch.events, fresh.scratch.events, "tick {tick}");
        let is_hit = |event: &&PunctureEvent| matches!(event, PunctureEvent::StructureHit { .. });
        hits += seen.scratch.events.iter().filter(is_hit).count();
    }
    assert!(hits > 10, "{hits} hits");
}
