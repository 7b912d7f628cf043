//! Hard cases of meshes: a needle along a plate, a tip on an edge, an entry at a seam, a plate as thin as paper, two bones that touch, a
//! canal narrower than the needle.
//!
//! Until version 4 of the law bone pushes the tip out the shortest way. So its force is continuous but where two ways out are equally short, in the middle of a plate
//! or behind an edge: there it turns, by no more than twice the way out, which is felt. It also means that bone holds no more than half its
//! thickness times its stiffness: 8.75 N for a lamina of 7 mm. From version 4 the tip slides on the surface, and neither is so. These tests
//! would fail if force jumped anywhere else, or by more, were no number, or gave work away.

use law::axial::{AxialSpec, ForceLaw};
use law::structures::{Shape, StructureKind, StructureSpec};
use nalgebra::{Point3, Vector3};
use trials::needle::DrivenNeedle;
use trials::scenes::paper_axial_spec;

const MM: f64 = 1e-3;
const BONE_N_PER_MM: f64 = 2.5;
/// Way of the tip in a tick, in mm: 5 mm/s. Bone may push by 0.0125 N more after it.
const STEP_MM: f64 = 0.005;
/// A jump that would be felt, in N.
const JUMP_N: f64 = 0.05;

/// A box as a mesh whose faces are cut into so many squares each way, each into two triangles: seams everywhere.
fn bone(half_mm: [f64; 3], middle_mm: [f64; 3]) -> StructureSpec {
    const CUTS: u32 = 4;
    let (mut vertices_m, mut triangles) = (Vec::new(), Vec::new());
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let (one, other) = ((axis + 1) % 3, (axis + 2) % 3);
            let first = vertices_m.len() as u32;
            for at in 0..=CUTS {
                for across in 0..=CUTS {
                    let mut place = Vector3::zeros();
                    let part = |n: u32| f64::from(n) / f64::from(CUTS) * 2.0 - 1.0;
                    (place[axis], place[one], place[other]) = (side, part(at), part(across));
                    vertices_m.push(Point3::from(place.component_mul(&Vector3::from(half_mm)) * MM));
                }
            }
            for at in 0..CUTS {
                for across in 0..CUTS {
                    let corner = first + at * (CUTS + 1) + across;
                    let [a, b, c, d] = [corner, corner + CUTS + 1, corner + CUTS + 2, corner + 1];
                    let both = if side > 0.0 { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] };
                    triangles.extend(both);
                }
            }
        }
    }
    let position_m = Point3::from(Vector3::from(middle_mm) * MM);
    let shape = Shape::Mesh { vertices_m, triangles };
    StructureSpec { name: "bone".to_owned(), kind: StructureKind::Bone, shape, position_m, wall: None }
}

/// What a way of the tip felt like.
struct Felt {
    /// Largest force of structures, in N.
    most_n: f64,
    /// Largest change of it in a tick without an event, in N.
    jump_n: f64,
    /// At the end, in N.
    last_n: Vector3<f64>,
    /// What it gave the hand in all, in J.
    work_j: f64,
}

/// Moves the tip from place to place, in mm.
fn feel(bones: Vec<StructureSpec>, way: &[[f64; 3]]) -> Felt {
    feel_under(ForceLaw::Version2, bones, way)
}

fn feel_under(law: ForceLaw, bones: Vec<StructureSpec>, way: &[[f64; 3]]) -> Felt {
    let mut needle = DrivenNeedle::new(AxialSpec { law, ..paper_axial_spec() }, bones).expect("meshes that are sound");
    let mut felt = Felt { most_n: 0.0, jump_n: 0.0, last_n: Vector3::zeros(), work_j: 0.0 };
    let mut last = Vector3::zeros();
    needle.down(way[0][0] * MM, way[0][1] * MM, way[0][2] * MM);
    for leg in way.windows(2) {
        let [from, to] = [leg[0], leg[1]].map(Vector3::from);
        let ticks = ((to - from).norm() / STEP_MM).ceil() as u32;
        for tick in 1..=ticks {
            let tip = from + (to - from) * (f64::from(tick) / f64::from(ticks));
            let output = needle.down(tip.x * MM, tip.y * MM, tip.z * MM);
            assert!(output.force_n.iter().all(|force| force.is_finite()), "at {tip:?}");
            felt.most_n = felt.most_n.max(output.structures_n.norm());
            if needle.scratch.events.is_empty() {
                felt.jump_n = felt.jump_n.max((output.structures_n - last).norm());
            }
            felt.work_j += 0.5 * (output.structures_n + last).dot(&((to - from) * (MM / f64::from(ticks))));
            last = output.structures_n;
        }
    }
    felt.last_n = last;
    felt
}

fn check(name: &str, felt: &Felt, most_n: f64, jump_n: f64) {
    assert!(felt.most_n <= most_n + 1e-6, "{name}: {} N", felt.most_n);
    assert!(felt.jump_n <= jump_n + 1e-6, "{name}: a jump of {} N", felt.jump_n);
}

/// A lamina: 8 mm deep, 30 mm long.
fn lamina() -> Vec<StructureSpec> {
    vec![bone([4.0, 15.0, 4.0], [0.0, 0.0, -20.0])]
}

#[test]
fn a_needle_along_a_plate_feels_it_evenly_and_beside_it_nothing() {
    let over = feel(lamina(), &[[0.0, -18.0, 1.0], [0.0, -18.0, -15.9], [0.0, 14.0, -15.9]]);
    check("0.1 mm over the plate", &over, 0.0, 0.0);
    let along = feel(lamina(), &[[0.1, -13.0, 1.0], [0.1, -13.0, -16.4], [0.7, 13.0, -16.4]]);
    check("0.4 mm into the plate", &along, 0.4 * BONE_N_PER_MM, JUMP_N);
    assert!(along.most_n > 0.9 * 0.4 * BONE_N_PER_MM);
}

#[test]
fn at_seams_corners_and_edges_nothing_jumps() {
    // Onto a corner of the grid, onto an edge of it, onto a diagonal: all inside a face.
    for (name, x, y) in [("vertex", 0.0, 0.0), ("edge", 0.0, 3.1), ("diagonal", 1.0, 3.75)] {
        let felt = feel(lamina(), &[[x, y, 1.0], [x, y, -17.5], [x + 0.02, y + 0.3, -17.5]]);
        check(name, &felt, 1.5 * BONE_N_PER_MM, JUMP_N);
        assert!(felt.most_n > 1.4 * BONE_N_PER_MM, "{name}");
    }
    // Straight down the outer edge and the outer corner: half in, half out, and never held.
    for (name, x, y) in [("outer edge", 4.0, 0.0), ("outer corner", 4.0, 15.0), ("within rounding", 4.0 - 1e-12, 15.0)]
    {
        check(name, &feel(lamina(), &[[x, y, 1.0], [x, y, -26.0]]), 1e-6, JUMP_N);
    }
}

#[test]
fn force_behind_an_edge_turns_no_further_than_its_two_exits() {
    // 1 mm below the top, sideways out of the edge: the short way turns from up to aside at 1 mm from the side.
    let felt = feel(lamina(), &[[2.0, 0.3, 1.0], [2.0, 0.3, -17.0], [5.0, 0.3, -17.0]]);
    check("behind an edge", &felt, BONE_N_PER_MM, 2.0_f64.sqrt() * BONE_N_PER_MM * (1.0 + STEP_MM));
}

#[test]
fn thin_plate_resists_up_to_half_its_thickness_then_releases() {
    for thick_mm in [0.01, 0.1, 0.5, 7.0] {
        let plate = vec![bone([15.0, 15.0, thick_mm / 2.0], [0.0, 0.0, -15.0])];
        let felt = feel(plate, &[[0.2, 0.3, 1.0], [0.2, 0.3, -20.0], [0.2, 0.3, -10.0]]);
        check(&format!("{thick_mm} mm of bone"), &felt, BONE_N_PER_MM * thick_mm / 2.0, BONE_N_PER_MM * thick_mm);
    }
}

#[test]
fn touching_bones_and_a_narrow_canal_throw_no_needle() {
    let pair =
        |gap_mm: f64| [-1.0, 1.0].map(|side| bone([5.0, 5.0, 5.0], [side * (5.0 + gap_mm / 2.0), 0.0, -15.0])).to_vec();
    check("where two bones touch", &feel(pair(0.0), &[[0.0, 0.4, 1.0], [0.0, 0.4, -22.0]]), 1e-6, JUMP_N);
    check("in a canal of 0.5 mm", &feel(pair(0.5), &[[0.0, 0.4, 1.0], [0.0, 0.4, -22.0]]), 0.0, 0.0);
    // 0.3 mm beside the crack: the top holds for 0.3 mm, then the crack is the shorter way out.
    let beside = feel(pair(0.0), &[[0.3, 0.4, 1.0], [0.3, 0.4, -22.0]]);
    check("beside the crack", &beside, 0.3 * BONE_N_PER_MM, 2.0_f64.sqrt() * 0.3 * BONE_N_PER_MM * (1.0 + 0.02));
}

/// The same ways under version 4.
fn hold(bones: Vec<StructureSpec>, way: &[[f64; 3]]) -> Felt {
    feel_under(ForceLaw::Version4, bones, way)
}

#[test]
fn a_bone_that_holds_is_never_pushed_through() {
    for thick_mm in [0.01, 0.1, 0.5, 7.0] {
        let plate = || vec![bone([15.0, 15.0, thick_mm / 2.0], [0.0, 0.0, -15.0 - thick_mm / 2.0])];
        let pushed = hold(plate(), &[[0.2, 0.3, 1.0], [0.2, 0.3, -27.0]]);
        assert!(
            (pushed.last_n - Vector3::z() * 12.0 * BONE_N_PER_MM).norm() < 1e-6,
            "{thick_mm} mm: {}",
            pushed.last_n
        );
        check(&format!("{thick_mm} mm of bone"), &pushed, 12.0 * BONE_N_PER_MM, JUMP_N);
        let back = hold(plate(), &[[0.2, 0.3, 1.0], [0.2, 0.3, -27.0], [0.2, 0.3, -14.9]]);
        assert!(back.last_n.norm() <= 0.0 && back.work_j.abs() < 1e-9, "{thick_mm} mm: {} J", back.work_j);
    }
}

#[test]
fn law_4_bone_acts_as_before_if_the_nearest_exit_is_the_entry() {
    let way = [[0.1, -13.0, 1.0], [0.1, -13.0, -16.4], [0.7, 13.0, -16.4]];
    let [old, new] = [feel(lamina(), &way), hold(lamina(), &way)];
    assert!((old.last_n - new.last_n).norm() < 1e-9 && (old.most_n - new.most_n).abs() < 1e-9);
    check("beside it", &hold(lamina(), &[[0.0, -18.0, 1.0], [0.0, -18.0, -15.9], [0.0, 14.0, -15.9]]), 0.0, 0.0);
}

#[test]
fn a_bone_that_holds_lets_go_behind_an_edge_and_nothing_jumps() {
    for (x, y) in [(2.0, 0.3), (3.9, 14.9), (3.0, 3.75)] {
        let felt = hold(lamina(), &[[x, y, 1.0], [x, y, -17.0], [x + 3.0, y, -17.0]]);
        check("behind an edge", &felt, 1.1 * BONE_N_PER_MM, JUMP_N);
        assert!(felt.last_n.norm() <= 0.0, "it is out at the side: {}", felt.last_n);
    }
    let pair =
        |gap_mm: f64| [-1.0, 1.0].map(|side| bone([5.0, 5.0, 5.0], [side * (5.0 + gap_mm / 2.0), 0.0, -15.0])).to_vec();
    check("in a canal of 0.5 mm", &hold(pair(0.5), &[[0.0, 0.4, 1.0], [0.0, 0.4, -22.0]]), 0.0, 0.0);
    let beside = hold(pair(0.0), &[[0.3, 0.4, 1.0], [0.3, 0.4, -22.0]]);
    check("beside a crack", &beside, 12.0 * BONE_N_PER_MM, JUMP_N);
    assert!(beside.last_n.z > 11.9 * BONE_N_PER_MM, "a crack lets no needle in: {}", beside.last_n);
}

#[test]
fn a_bone_that_holds_gives_no_work_away() {
    // In over the top and out at the side, and the other way; round a corner; deep under it and back.
    for way in [
        vec![[2.0, 0.3, 1.0], [2.0, 0.3, -17.0], [6.0, 0.3, -17.0], [6.0, 0.3, 1.0]],
        vec![[6.0, 0.3, 1.0], [6.0, 0.3, -17.0], [2.0, 0.3, -17.0], [2.0, 0.3, 1.0]],
        vec![
            [3.0, 14.0, 1.0],
            [3.0, 14.0, -17.0],
            [6.0, 17.0, -17.5],
            [3.0, 17.0, -16.5],
            [3.0, 14.0, -17.0],
            [3.0, 14.0, 1.0],
        ],
        vec![[0.0, 0.0, 1.0], [0.0, 0.0, -30.0], [1.0, 2.0, -28.0], [-1.0, 0.0, -19.0], [0.0, 0.0, 1.0]],
    ] {
        let felt = hold(lamina(), &way);
        assert!(felt.work_j < 1e-7 && felt.last_n.norm() <= 0.0, "{way:?}: {} J", felt.work_j);
    }
}
