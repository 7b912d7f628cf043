//! Import of a map whose bodies are known: an ellipsoid, a tube, a slab of layers, a bone with a hole, in voxels that are longer one way than
//! the other and lie askew.
//!
//! Would fail if a mesh were shifted by half a voxel, mirrored, shrunk by smoothing or left with a hole; or if thicknesses were taken along an
//! axis of the image.

use anatomy::segmentation::{
    BODY, EntryFrame, LabelMap, LabelMesh, LabelRole, MeshRequest, SegmentationError, measure_layers, mesh_label,
};
use anatomy::{check_manifold, volume_m3};
use nalgebra::{Matrix3, Point3, Vector3};

use crate::nifti::{PLAIN, Written, oblique_steps, read};

const EDGES_MM: [f64; 3] = [0.8, 0.8, 1.25];
const SIZE: [usize; 3] = [100, 100, 80];
const SKIN: u16 = 1;
const FAT: u16 = 2;
const MUSCLE: u16 = 3;
const ELLIPSOID: u16 = 11;
const TUBE: u16 = 12;
const BONE: u16 = 13;

/// The phantom, whose own frame has its origin in the image's middle, z out of the body, in mm.
struct Phantom {
    steps_mm: Matrix3<f64>,
    /// From the phantom's frame to the world.
    turn: Matrix3<f64>,
}

const MIDDLE_MM: Vector3<f64> = Vector3::new(13.0, -42.0, 905.0);
/// Height of the skin, and depths of boundaries below.
const SKIN_MM: f64 = 28.0;
const FAT_AT_MM: f64 = 3.0;
const MUSCLE_AT_MM: f64 = 13.5;

/// Radii and place of the ellipsoid.
const RADII_MM: [f64; 3] = [9.0, 7.0, 8.0];
const ELLIPSOID_AT_MM: Vector3<f64> = Vector3::new(-14.0, 10.0, -8.0);
/// The tube runs along its axis between two ends.
const TUBE_RADIUS_MM: f64 = 5.0;
const TUBE_HALF_MM: f64 = 12.0;
const TUBE_AT_MM: Vector3<f64> = Vector3::new(12.0, 8.0, -7.0);
/// A ring of bone about z: radius of its middle line, and of its section.
const BONE_RING_MM: f64 = 7.5;
const BONE_RADIUS_MM: f64 = 4.0;
const BONE_AT_MM: Vector3<f64> = Vector3::new(2.0, -16.0, -9.0);

impl Phantom {
    fn new(image_rad: f64, phantom_rad: f64) -> Self {
        Self { steps_mm: oblique_steps(EDGES_MM, image_rad), turn: oblique_steps([1.0; 3], phantom_rad) }
    }

    fn map(&self) -> LabelMap {
        let half = Vector3::from(SIZE.map(|along| (along as f64 - 1.0) / 2.0));
        let origin_mm = MIDDLE_MM - self.steps_mm * half;
        let index = |at: usize| {
            Vector3::new((at % SIZE[0]) as f64, (at / SIZE[0] % SIZE[1]) as f64, (at / (SIZE[0] * SIZE[1])) as f64)
        };
        let place = |at: usize| self.turn.transpose() * (self.steps_mm * (index(at) - half));
        let labels = (0..SIZE.iter().product()).map(|at| label_of(&place(at))).collect();
        read(&Written { size: SIZE, steps_mm: self.steps_mm, origin_mm, labels }.bytes(PLAIN)).unwrap()
    }

    /// A place of the world, in m, in the phantom's own frame, in mm.
    fn own_mm(&self, world_m: &Point3<f64>) -> Vector3<f64> {
        self.turn.transpose() * (world_m.coords * 1e3 - MIDDLE_MM)
    }

    fn world_m(&self, own_mm: &Vector3<f64>) -> Point3<f64> {
        Point3::from((self.turn * own_mm + MIDDLE_MM) / 1e3)
    }
}

fn label_of(place: &Vector3<f64>) -> u16 {
    if place.z > SKIN_MM || place.xy().norm() > 30.0 || place.z < -24.0 {
        return 0;
    }
    for (label, distance) in
        [(ELLIPSOID, from_ellipsoid_mm as fn(&Vector3<f64>) -> f64), (TUBE, from_tube_mm), (BONE, from_bone_mm)]
    {
        if distance(place) < 0.0 {
            return label;
        }
    }
    match SKIN_MM - place.z {
        depth if depth < FAT_AT_MM => SKIN,
        depth if depth < MUSCLE_AT_MM => FAT,
        _ => MUSCLE,
    }
}

/// Distance from the ellipsoid's surface, negative inside, to first order: exact enough within a voxel of it.
fn from_ellipsoid_mm(place: &Vector3<f64>) -> f64 {
    let p = place - ELLIPSOID_AT_MM;
    let scaled = Vector3::from_fn(|axis, _| p[axis] / RADII_MM[axis]);
    let slope = Vector3::from_fn(|axis, _| p[axis] / (RADII_MM[axis] * RADII_MM[axis]));
    let k = scaled.norm();
    if slope.norm() == 0.0 { -7.0 } else { k * (k - 1.0) / slope.norm() }
}

fn from_tube_mm(place: &Vector3<f64>) -> f64 {
    let axis = Vector3::new(0.2, 0.9, 0.1).normalize();
    let p = place - TUBE_AT_MM;
    let along = p.dot(&axis);
    let across = (p - axis * along).norm() - TUBE_RADIUS_MM;
    outside(across, along.abs() - TUBE_HALF_MM)
}

/// Distance from a body's surface, in mm.
type Distance = fn(&Vector3<f64>) -> f64;

fn from_bone_mm(place: &Vector3<f64>) -> f64 {
    let p = place - BONE_AT_MM;
    libm::hypot(p.xy().norm() - BONE_RING_MM, p.z) - BONE_RADIUS_MM
}

/// Distance from what lies within two bounds at a right angle.
fn outside(one: f64, other: f64) -> f64 {
    let over = libm::hypot(one.max(0.0), other.max(0.0));
    over + one.max(other).min(0.0)
}

const REQUEST: MeshRequest = MeshRequest { smoothing_voxels: 0.5, most_triangles: 100_000 };

fn mesh(map: &LabelMap, label: u16) -> LabelMesh {
    mesh_label(map, label, &map.survey()[&label], REQUEST).unwrap()
}

/// Relative error of the volume, and the farthest vertex from the true surface in voxels of the longest edge.
fn errors(phantom: &Phantom, mesh: &LabelMesh, volume_mm3: f64, distance: impl Fn(&Vector3<f64>) -> f64) -> (f64, f64) {
    let (vertices, triangles) = &mesh.surface;
    assert_eq!(check_manifold(triangles), Ok(0), "closed and manifold");
    let found_mm3 = volume_m3(vertices, triangles) * 1e9;
    assert!((found_mm3 - mesh.mesh_m3 * 1e9).abs() < 1e-6 * found_mm3, "the volume that is told");
    let farthest = vertices.iter().map(|v| distance(&phantom.own_mm(v)).abs()).fold(0.0, f64::max);
    (found_mm3 / volume_mm3 - 1.0, farthest / EDGES_MM[2])
}

#[test]
fn known_solids_err_below_two_percent_and_half_a_voxel() {
    let pi = std::f64::consts::PI;
    let ellipsoid_mm3 = 4.0 / 3.0 * pi * RADII_MM.iter().product::<f64>();
    let tube_mm3 = pi * TUBE_RADIUS_MM * TUBE_RADIUS_MM * 2.0 * TUBE_HALF_MM;
    let bone_mm3 = 2.0 * pi * pi * BONE_RING_MM * BONE_RADIUS_MM * BONE_RADIUS_MM;
    for (image_rad, phantom_rad) in [(0.0, 0.0), (0.5, 0.0), (0.5, 0.8)] {
        let phantom = Phantom::new(image_rad, phantom_rad);
        let map = phantom.map();
        let bodies: [(&str, u16, f64, Distance); 3] = [
            ("ellipsoid", ELLIPSOID, ellipsoid_mm3, from_ellipsoid_mm),
            ("tube", TUBE, tube_mm3, from_tube_mm),
            ("bone with a hole", BONE, bone_mm3, from_bone_mm),
        ];
        for (name, label, volume_mm3, distance) in bodies {
            let found = mesh(&map, label);
            let (volume, surface) = errors(&phantom, &found, volume_mm3, distance);
            println!(
                "{name}: volume {:+.2} %, surface {surface:.3} voxels, moved {:.2} mm, {} triangles",
                volume * 1e2,
                found.moved_m * 1e3,
                found.surface.1.len()
            );
            assert!(volume.abs() < 0.02, "{name}: volume {volume}");
            assert!(surface < 0.5, "{name}: surface {surface} voxels");
            assert_eq!(found.pieces, 1);
            assert!((found.mesh_m3 / found.voxels_m3 - 1.0).abs() < 0.005, "smoothing keeps the volume");
            let vertices = found.surface.0.len() as i64;
            let genus = 1 - (vertices - found.surface.1.len() as i64 / 2) / 2;
            assert_eq!(genus, i64::from(label == BONE), "{name}: holes");
        }
    }
}

#[test]
fn layers_are_as_thick_along_the_skins_normal_as_they_were_made() {
    for (image_rad, phantom_rad) in [(0.0, 0.0), (0.5, 0.0), (0.5, 0.8)] {
        let phantom = Phantom::new(image_rad, phantom_rad);
        let map = phantom.map();
        let body = map.body();
        let skin = mesh(&body, BODY);
        let at_mm = Vector3::new(2.0, -1.0, SKIN_MM + 4.0);
        let frame = EntryFrame::new(&skin.surface, phantom.world_m(&at_mm), None).unwrap();
        let off_mm = phantom.own_mm(&frame.origin_m).z - SKIN_MM;
        let normal_deg = libm::acos(frame.normal.dot(&(phantom.turn * Vector3::z()))).to_degrees();
        println!("skin off by {off_mm:.3} mm, normal by {normal_deg:.2}°");
        assert!(off_mm.abs() < 0.5 * EDGES_MM[2] && normal_deg < 1.5);
        let layers = measure_layers(&map, &frame, &role).unwrap();
        let found: Vec<_> = layers.iter().map(|layer| (layer.label, layer.thickness_m * 1e3)).collect();
        println!("{found:?}");
        let wanted = [(SKIN, FAT_AT_MM), (FAT, MUSCLE_AT_MM - FAT_AT_MM), (MUSCLE, SKIN_MM + 24.0 - MUSCLE_AT_MM)];
        assert_eq!(found.len(), 3, "{found:?}");
        for ((label, mm), (wanted, wanted_mm)) in found.iter().zip(wanted) {
            assert_eq!(*label, wanted);
            // Either boundary may be off by half a voxel.
            assert!((mm - wanted_mm).abs() < EDGES_MM[2], "{label}: {mm} mm, not {wanted_mm}");
        }
    }
}

/// The layers of the phantom; all else in it is a structure.
fn role(label: u16) -> LabelRole {
    if label <= MUSCLE { LabelRole::Layer } else { LabelRole::Structure }
}

/// A slab of labels from the skin down, each so many voxels of 2 mm thick, with air around it.
fn slab(labels: &[(u16, usize)]) -> LabelMap {
    let (wide, deep) = (24, labels.iter().map(|(_, count)| count).sum::<usize>() + 4);
    let column: Vec<u16> = labels.iter().rev().flat_map(|(label, count)| std::iter::repeat_n(*label, *count)).collect();
    let at = |i: usize, j: usize, k: usize| {
        let is_inside = [i, j].iter().all(|at| (2..wide - 2).contains(at));
        if is_inside { k.checked_sub(2).and_then(|k| column.get(k)).copied().unwrap_or(0) } else { 0 }
    };
    let all = (0..deep).flat_map(|k| (0..wide).flat_map(move |j| (0..wide).map(move |i| (i, j, k))));
    let labels = all.map(|(i, j, k)| at(i, j, k)).collect();
    let written = Written {
        size: [wide, wide, deep],
        steps_mm: Matrix3::identity() * 2.0,
        origin_mm: Vector3::new(-23.0, -23.0, -2.0 * (deep as f64 - 3.0)),
        labels,
    };
    read(&written.bytes(PLAIN)).unwrap()
}

#[test]
fn layers_end_at_tissue_without_a_name() {
    const UNNAMED: u16 = 99;
    let measured = |labels: &[(u16, usize)]| {
        let map = slab(labels);
        let skin = mesh(&map.body(), BODY);
        let frame = EntryFrame::new(&skin.surface, Point3::new(0.0, 0.0, 0.0), None).unwrap();
        let role = |label| if label == UNNAMED { LabelRole::Unnamed } else { role(label) };
        let layers = measure_layers(&map, &frame, &role).unwrap();
        let told: Vec<_> = layers.iter().map(|layer| (layer.label, (layer.thickness_m * 1e3).round())).collect();
        (told, layers.last().unwrap().unnamed_below)
    };
    // Down to the belly, and out of it.
    let through = [(SKIN, 2), (FAT, 5), (MUSCLE, 15), (UNNAMED, 40), (FAT, 5), (SKIN, 2)];
    assert_eq!(measured(&through), (vec![(SKIN, 4.0), (FAT, 10.0), (MUSCLE, 30.0)], Some(UNNAMED)));
    // A seam and a structure belong to the layer above.
    let seam = [(SKIN, 2), (UNNAMED, 1), (FAT, 5), (MUSCLE, 5), (ELLIPSOID, 6), (MUSCLE, 5)];
    assert_eq!(measured(&seam), (vec![(SKIN, 6.0), (FAT, 10.0), (MUSCLE, 32.0)], None));
}

#[test]
fn entry_frame_lies_on_skin_with_right_superior_outward_axes() {
    let phantom = Phantom::new(0.0, 0.0);
    let skin = mesh(&phantom.map().body(), BODY);
    let at = phantom.world_m(&Vector3::new(0.0, 0.0, SKIN_MM));
    let frame = EntryFrame::new(&skin.surface, at, Some(Vector3::new(0.1, 0.0, 1.0))).unwrap();
    assert!((frame.tilt_rad.to_degrees() - 5.71).abs() < 1.0, "{}", frame.tilt_rad.to_degrees());
    let (vertices, _) = frame.place(&skin.surface);
    let highest = vertices.iter().filter(|v| v.xy().coords.norm() < 2e-3).map(|v| v.z).fold(-1.0, f64::max);
    assert!(highest.abs() < 5e-4, "{highest} m over the origin");
    assert!((frame.to_patient.determinant() - 1.0).abs() < 1e-12, "no mirror");
    let away = EntryFrame::new(&skin.surface, at + Vector3::new(0.0, 0.0, 0.05), None);
    assert!(matches!(away, Err(SegmentationError::EntryAway { .. })), "{away:?}");
    let inwards = EntryFrame::new(&skin.surface, at, Some(-Vector3::z()));
    assert!(matches!(inwards, Err(SegmentationError::UpInwards { .. })), "{inwards:?}");
}

#[test]
fn coarsening_merges_voxels_until_the_triangles_fit_the_limit() {
    let phantom = Phantom::new(0.5, 0.8);
    let map = phantom.map();
    let survey = map.survey();
    let request = MeshRequest { most_triangles: 1500, ..REQUEST };
    let coarse = mesh_label(&map, ELLIPSOID, &survey[&ELLIPSOID], request).unwrap();
    assert!(coarse.voxels_together > 1 && coarse.surface.1.len() <= 1500);
    assert!((coarse.mesh_m3 / coarse.voxels_m3 - 1.0).abs() < 0.01);
    assert_eq!(check_manifold(&coarse.surface.1), Ok(0));
}
