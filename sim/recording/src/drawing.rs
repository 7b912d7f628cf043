//! Messages for viewers: frames, poses, the scene and log lines, in Foxglove's schemas.

use law::puncture::PunctureSpec;
use law::structures::{Shape, StructureKind, StructureSpec};
use nalgebra::{Point3 as Point, UnitQuaternion, Vector3 as Vector};
use prost_types::Timestamp;

use crate::event::{Event, EventKind};
use crate::generated::foxglove::{
    Color, CubePrimitive, CylinderPrimitive, FrameTransform, FrameTransforms, Log, Point3, Pose, PoseInFrame,
    Quaternion, SceneEntity, SceneUpdate, SpherePrimitive, TriangleListPrimitive, Vector3, log,
};
use crate::rate::NS_PER_S;
use crate::sample::Sample;

/// Root frame of the viewer; the patient lies in it.
const WORLD: &str = "world";
const PATIENT: &str = "patient";
const NEEDLE: &str = "needle";
/// Width and length of the slab that represents a layer, in m.
const SLAB_M: f64 = 0.12;
/// Thickness at which a fascia of zero thickness is drawn, in m.
const THINNEST_SLAB_M: f64 = 2e-4;
/// Colours of the layers from the surface down, repeated cyclically: neighbours always differ.
const LAYER_COLOURS: [[f64; 3]; 4] = [[0.9, 0.65, 0.55], [0.95, 0.82, 0.3], [0.75, 0.85, 0.95], [0.75, 0.2, 0.2]];
/// Opacity of a layer: the needle must be visible through all of them.
const LAYER_ALPHA: f64 = 0.3;
/// A mesh with more triangles is drawn as its bounding box: the scene is repeated every second, and
/// the full mesh is attached.
const MOST_TRIANGLES: usize = 2_000;

/// Contents of `/scene`, plain data in SI.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SceneDrawing {
    /// Name and thickness in m of each layer, from the surface down.
    pub layers: Vec<(String, f64)>,
    /// Structures.
    pub structures: Vec<StructureSpec>,
    /// Needle length, in m.
    pub needle_length_m: f64,
    /// Needle radius, in m.
    pub needle_radius_m: f64,
}

impl SceneDrawing {
    /// Extracts the drawing from a puncture, for a needle of a radius in m.
    #[must_use]
    pub fn from_spec(spec: &PunctureSpec, needle_radius_m: f64) -> Self {
        let layers = spec.axial.layers.iter();
        Self {
            layers: layers.map(|layer| (layer.name.clone(), layer.thickness_m)).collect(),
            structures: spec.structures.clone(),
            needle_length_m: spec.needle_length_m,
            needle_radius_m,
        }
    }
}

/// The last time that viewers can represent.
const LAST_TIME: Timestamp = Timestamp { seconds: u32::MAX as i64, nanos: 999_999_999 };

/// Converts a Unix time in ns to a viewer's timestamp, clamped to [`LAST_TIME`].
pub(crate) fn stamp_time(unix_ns: u64) -> Timestamp {
    match u32::try_from(unix_ns / NS_PER_S) {
        Ok(seconds) => Timestamp { seconds: seconds.into(), nanos: (unix_ns % NS_PER_S) as i32 },
        Err(_) => LAST_TIME,
    }
}

fn viewer_vector([x, y, z]: [f64; 3]) -> Option<Vector3> {
    Some(Vector3 { x, y, z })
}

fn viewer_quaternion([x, y, z, w]: [f64; 4]) -> Option<Quaternion> {
    Some(Quaternion { x, y, z, w })
}

/// Returns a pose without rotation.
fn unrotated_pose(position: [f64; 3]) -> Option<Pose> {
    Some(Pose { position: viewer_vector(position), orientation: viewer_quaternion([0.0, 0.0, 0.0, 1.0]) })
}

fn viewer_colour(r: f64, g: f64, b: f64, a: f64) -> Option<Color> {
    Some(Color { r, g, b, a })
}

/// Returns the needle's pose.
pub(crate) fn draw_pose(sample: &Sample, unix_ns: u64) -> PoseInFrame {
    PoseInFrame {
        timestamp: Some(stamp_time(unix_ns)),
        frame_id: PATIENT.to_owned(),
        pose: Some(Pose {
            position: viewer_vector(sample.position_m),
            orientation: viewer_quaternion(sample.orientation),
        }),
    }
}

fn frame_transform(parent: &str, child: &str, pose: Option<Pose>, unix_ns: u64) -> FrameTransform {
    let Pose { position, orientation } = pose.unwrap_or_default();
    FrameTransform {
        timestamp: Some(stamp_time(unix_ns)),
        parent_frame_id: parent.to_owned(),
        child_frame_id: child.to_owned(),
        translation: position,
        rotation: orientation,
    }
}

/// Returns every frame: the patient at the world's origin, the needle in the patient.
///
/// A viewer that seeks discards the frames and reads the last message of a topic, so each message
/// contains all frames.
pub(crate) fn draw_transforms(sample: &Sample, unix_ns: u64) -> FrameTransforms {
    let pose = Pose { position: viewer_vector(sample.position_m), orientation: viewer_quaternion(sample.orientation) };
    let patient = frame_transform(WORLD, PATIENT, unrotated_pose([0.0; 3]), unix_ns);
    FrameTransforms { transforms: vec![patient, frame_transform(PATIENT, NEEDLE, Some(pose), unix_ns)] }
}

/// Returns a line for the viewer's log.
pub(crate) fn log_line(event: &Event, unix_ns: u64) -> Log {
    let level = match event.kind {
        EventKind::Fault | EventKind::Interrupted => log::Level::Error,
        EventKind::StructureHit | EventKind::HubContact => log::Level::Warning,
        _ => log::Level::Info,
    };
    let (x_mm, force_n) = (event.x_m * 1e3, event.force_n);
    let mut message = format!("{} at {x_mm:.3} mm, {force_n:.3} N", event.kind.name());
    if let Some(boundary) = event.boundary {
        message += &format!(", boundary {boundary}");
    }
    if !event.text.is_empty() {
        message += &format!(": {}", event.text);
    }
    Log {
        timestamp: Some(stamp_time(unix_ns)),
        level: level.into(),
        message,
        name: "stylet".to_owned(),
        ..Log::default()
    }
}

/// Returns the scene at a time: layers as translucent slabs, structures, and the needle in its own
/// frame.
pub(crate) fn draw_scene(drawing: &SceneDrawing, unix_ns: u64) -> SceneUpdate {
    let mut entities = vec![needle_entity(drawing)];
    entities.extend(layer_entities(drawing));
    entities.extend(drawing.structures.iter().enumerate().map(|(i, s)| structure_entity(i, s)));
    for entity in &mut entities {
        entity.timestamp = Some(stamp_time(unix_ns));
        entity.frame_locked = true;
    }
    SceneUpdate { deletions: Vec::new(), entities }
}

fn scene_entity(frame: &str, id: String) -> SceneEntity {
    SceneEntity { frame_id: frame.to_owned(), id, ..SceneEntity::default() }
}

fn needle_entity(drawing: &SceneDrawing) -> SceneEntity {
    let (length, width) = (drawing.needle_length_m, 2.0 * drawing.needle_radius_m);
    let mut entity = scene_entity(NEEDLE, "needle".to_owned());
    // The tip is the frame's origin and the hub lies towards -z.
    entity.cylinders.push(CylinderPrimitive {
        pose: unrotated_pose([0.0, 0.0, -0.5 * length]),
        size: viewer_vector([width, width, length]),
        bottom_scale: 1.0,
        top_scale: 1.0,
        color: viewer_colour(0.75, 0.77, 0.8, 1.0),
    });
    entity
}

fn layer_entities(drawing: &SceneDrawing) -> Vec<SceneEntity> {
    let mut top_m = 0.0;
    let mut entities = Vec::new();
    for (i, (name, thickness_m)) in drawing.layers.iter().enumerate() {
        let [r, g, b] = LAYER_COLOURS[i % LAYER_COLOURS.len()];
        let drawn_m = thickness_m.max(THINNEST_SLAB_M);
        let mut entity = scene_entity(PATIENT, format!("layer {i}: {name}"));
        entity.cubes.push(CubePrimitive {
            pose: unrotated_pose([0.0, 0.0, top_m - 0.5 * drawn_m]),
            size: viewer_vector([SLAB_M, SLAB_M, drawn_m]),
            color: viewer_colour(r, g, b, LAYER_ALPHA),
        });
        entities.push(entity);
        top_m -= thickness_m;
    }
    entities
}

fn structure_colour(kind: StructureKind) -> Option<Color> {
    match kind {
        StructureKind::Target => viewer_colour(0.1, 0.7, 0.3, 0.6),
        StructureKind::Vessel => viewer_colour(0.8, 0.1, 0.1, 0.8),
        StructureKind::Nerve => viewer_colour(0.95, 0.8, 0.1, 0.8),
        StructureKind::Bone => viewer_colour(0.95, 0.93, 0.85, 1.0),
        StructureKind::Organ => viewer_colour(0.6, 0.25, 0.4, 0.6),
    }
}

fn structure_entity(index: usize, spec: &StructureSpec) -> SceneEntity {
    let color = structure_colour(spec.kind);
    let centre = spec.position_m;
    let mut entity = scene_entity(PATIENT, format!("structure {index}: {}", spec.name));
    match &spec.shape {
        Shape::Sphere { radius_m } => entity.spheres.push(sphere_primitive(&centre, *radius_m, color)),
        Shape::Capsule { half_axis_m, radius_m } => {
            entity.spheres.push(sphere_primitive(&(centre + half_axis_m), *radius_m, color));
            entity.spheres.push(sphere_primitive(&(centre - half_axis_m), *radius_m, color));
            entity.cylinders.push(cylinder_primitive(&centre, half_axis_m, *radius_m, color));
        }
        Shape::Box { half_extents_m } => entity.cubes.push(cube_primitive(&centre, half_extents_m, color)),
        Shape::Mesh { vertices_m, triangles } if triangles.len() <= MOST_TRIANGLES => {
            entity.triangles.push(TriangleListPrimitive {
                pose: unrotated_pose(centre.into()),
                points: vertices_m.iter().map(|p| Point3 { x: p.x, y: p.y, z: p.z }).collect(),
                color,
                colors: Vec::new(),
                indices: triangles.iter().flatten().copied().collect(),
            });
        }
        Shape::Mesh { vertices_m, .. } => {
            let low = vertices_m.iter().fold(Vector::repeat(f64::INFINITY), |low, v| low.inf(&v.coords));
            let high = vertices_m.iter().fold(Vector::repeat(f64::NEG_INFINITY), |high, v| high.sup(&v.coords));
            entity.cubes.push(cube_primitive(&(centre + (low + high) * 0.5), &((high - low) * 0.5), color));
        }
    }
    entity
}

fn sphere_primitive(centre: &Point<f64>, radius_m: f64, color: Option<Color>) -> SpherePrimitive {
    SpherePrimitive { pose: unrotated_pose((*centre).into()), size: viewer_vector([2.0 * radius_m; 3]), color }
}

fn cube_primitive(centre: &Point<f64>, half_extents_m: &Vector<f64>, color: Option<Color>) -> CubePrimitive {
    CubePrimitive { pose: unrotated_pose((*centre).into()), size: viewer_vector((half_extents_m * 2.0).into()), color }
}

fn cylinder_primitive(
    centre: &Point<f64>,
    half_axis_m: &Vector<f64>,
    radius_m: f64,
    color: Option<Color>,
) -> CylinderPrimitive {
    // The rotation from +z to an axis along -z is not unique; use half a turn about x.
    let turn = UnitQuaternion::rotation_between(&Vector::z(), half_axis_m)
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector::x_axis(), std::f64::consts::PI));
    let [x, y, z, w] = turn.coords.into();
    CylinderPrimitive {
        pose: Some(Pose { position: viewer_vector((*centre).into()), orientation: viewer_quaternion([x, y, z, w]) }),
        size: viewer_vector([2.0 * radius_m, 2.0 * radius_m, 2.0 * half_axis_m.norm()]),
        bottom_scale: 1.0,
        top_scale: 1.0,
        color,
    }
}
