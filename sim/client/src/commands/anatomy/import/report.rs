//! The report of an import, as text and as JSON.

use std::io::{self, Write};

use anatomy::segmentation::{LabelMap, LabelMesh};
use serde::Serialize;

use super::scene::{EXERCISE_FILE, WrittenImport};
use super::{ImportArgs, Imported};

/// The report of an import.
#[derive(Serialize)]
pub struct ImportReport {
    /// Path of the label map.
    segmentation: String,
    /// Number of voxels along each axis.
    size: [usize; 3],
    /// Edges of a voxel, in mm.
    voxel_mm: [f64; 3],
    /// Source of the orientation in the header.
    orientation: &'static str,
    /// Whether the header names no unit, so that mm are assumed.
    unit_is_assumed: bool,
    /// Origin of the patient frame in the image's world, in mm.
    entry_mm: [f64; 3],
    /// Angle between +z and the skin's own direction there, in degrees.
    tilt_deg: f64,
    /// Meshes: the skin first.
    meshes: Vec<MeshReport>,
    /// Layers from the skin down.
    layers: Vec<LayerReport>,
    /// Thresholds that had to be lower than the table's for these layers.
    lowered: Vec<LoweredReport>,
    /// The exercise's path: angle and azimuth in degrees, depth in mm, and its target.
    way: WayReport,
    /// Path of the scene.
    scene: String,
    /// Path of the exercise.
    exercise: String,
}

/// A mesh.
#[derive(Serialize)]
struct MeshReport {
    name: String,
    kind: String,
    /// Volume of the voxels, in ml.
    voxels_ml: f64,
    /// Difference of the mesh's volume, in %.
    volume_error_percent: f64,
    /// Maximum displacement of a vertex by smoothing, in mm.
    moved_mm: f64,
    triangles: usize,
    pieces: usize,
    /// Number of voxels merged along each axis.
    voxels_together: usize,
}

/// A layer.
#[derive(Serialize)]
struct LayerReport {
    name: String,
    tissue: String,
    thickness_mm: f64,
}

/// A threshold that was lowered.
#[derive(Serialize)]
struct LoweredReport {
    layer: String,
    contactor: &'static str,
    from_n: f64,
    to_n: f64,
}

/// The exercise's path.
#[derive(Serialize)]
struct WayReport {
    angle_deg: f64,
    azimuth_deg: f64,
    depth_mm: f64,
    to: String,
}

impl MeshReport {
    fn new(name: &str, kind: &str, mesh: &LabelMesh) -> Self {
        Self {
            name: name.to_owned(),
            kind: kind.to_owned(),
            voxels_ml: mesh.voxels_m3 * 1e6,
            volume_error_percent: 1e2 * (mesh.mesh_m3 / mesh.voxels_m3 - 1.0),
            moved_mm: mesh.moved_m * 1e3,
            triangles: mesh.surface.1.len(),
            pieces: mesh.pieces,
            voxels_together: mesh.voxels_together,
        }
    }
}

impl ImportReport {
    /// The report of an import and the files written.
    pub fn new(args: &ImportArgs, map: &LabelMap, imported: &Imported, written: &WrittenImport) -> Self {
        let structures = imported.structures.iter().map(|s| MeshReport::new(&s.label.name, s.label.kind(), &s.mesh));
        let lowered = written.lowered.iter().map(|one| LoweredReport {
            layer: one.layer.clone(),
            contactor: one.contactor,
            from_n: one.from_n,
            to_n: one.to_n,
        });
        let way = &written.way;
        Self {
            segmentation: args.segmentation.display().to_string(),
            size: map.size(),
            voxel_mm: map.edges_m().map(|edge| edge * 1e3),
            orientation: map.orientation().words(),
            unit_is_assumed: map.unit_is_assumed(),
            entry_mm: [0, 1, 2].map(|axis| imported.frame.origin_m[axis] * 1e3),
            tilt_deg: imported.frame.tilt_rad.to_degrees(),
            meshes: std::iter::once(MeshReport::new("skin", "skin", &imported.skin)).chain(structures).collect(),
            layers: imported
                .layers
                .iter()
                .map(|layer| LayerReport {
                    name: layer.name.clone(),
                    tissue: layer.label.tissue().unwrap_or_default().to_owned(),
                    thickness_mm: layer.measured.thickness_m * 1e3,
                })
                .collect(),
            lowered: lowered.collect(),
            way: WayReport {
                angle_deg: way.angle_deg,
                azimuth_deg: way.azimuth_deg,
                depth_mm: way.depth_mm,
                to: way.to.clone(),
            },
            scene: super::scene::scene_path(&args.out),
            exercise: args.out.join(EXERCISE_FILE).display().to_string(),
        }
    }

    /// Writes the human-readable form.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let [along, across, deep] = self.size;
        let [x, y, z] = self.voxel_mm;
        writeln!(out, "{}: {along} × {across} × {deep} voxels of {x:.3} × {y:.3} × {z:.3} mm", self.segmentation)?;
        let unit = if self.unit_is_assumed { "; no unit in the header: taken as mm" } else { "" };
        writeln!(out, "  orientation by {}{unit}", self.orientation)?;
        let [right, anterior, superior] = self.entry_mm;
        writeln!(
            out,
            "  entry at {right:.1} mm right, {anterior:.1} mm anterior, {superior:.1} mm superior; +z leans {:.1}° from the skin's normal",
            self.tilt_deg
        )?;
        self.write_meshes(out)?;
        writeln!(out, "\n  {:32} {:>10} {:>16}", "layer at the entry", "tissue", "thickness mm")?;
        for layer in &self.layers {
            writeln!(out, "  {:32} {:>10} {:>16.2}", layer.name, layer.tissue, layer.thickness_mm)?;
        }
        for LoweredReport { layer, contactor, from_n, to_n } in &self.lowered {
            writeln!(
                out,
                "  {layer}: {contactor} threshold lowered from {from_n} N to {to_n} N, to be sound in these layers"
            )?;
        }
        let WayReport { angle_deg, azimuth_deg, depth_mm, to } = &self.way;
        writeln!(out, "\n  {}", self.scene)?;
        writeln!(out, "  {}: {depth_mm:.1} mm at {angle_deg:.1}°, azimuth {azimuth_deg:.1}°, to {to}", self.exercise)
    }

    fn write_meshes(&self, out: &mut dyn Write) -> io::Result<()> {
        writeln!(
            out,
            "\n  {:32} {:>8} {:>10} {:>14} {:>9} {:>10} {:>7} {:>9}",
            "mesh", "kind", "volume ml", "volume error %", "moved mm", "triangles", "pieces", "together"
        )?;
        for mesh in &self.meshes {
            writeln!(
                out,
                "  {:32} {:>8} {:>10.3} {:>14.2} {:>9.2} {:>10} {:>7} {:>9}",
                mesh.name,
                mesh.kind,
                mesh.voxels_ml,
                mesh.volume_error_percent,
                mesh.moved_mm,
                mesh.triangles,
                mesh.pieces,
                mesh.voxels_together
            )?;
        }
        Ok(())
    }
}
