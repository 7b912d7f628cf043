//! `stylet anatomy import`: a scene from an external segmentation.

mod report;
mod scene;
mod stages;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anatomy::segmentation::{
    BODY, EntryFrame, LabelExtent, LabelMap, LabelMesh, LabelRole, MeasuredLayer, MeshRequest, SegmentationError,
    measure_layers, mesh_label,
};
use documents::{SegmentationLabel, SegmentationLabels};
use law::structures::Surface;
use report::ImportReport;
use scene::Way;
use stages::Stages;

use super::files::{self, Folder};
use crate::exit::{Failure, Outcome};
use crate::{output, sources};

/// Maximum number of triangles of a mesh: suitable for recordings and for rendering.
const MOST_TRIANGLES: usize = 40_000;
/// Smoothing of the skin, in voxels.
const SKIN_SMOOTHING: f64 = 0.5;

/// Make a scene from a segmentation: meshes, skin, layers, and an exercise
///
/// SEGMENTATION is a label map, NIfTI-1 or NIfTI-2, compressed (.nii.gz) or not (.nii); its
/// orientation is that of its sform, otherwise of its qform, otherwise along the axes: right,
/// anterior, superior. LABELS.toml defines the meaning of each number, and where the needle enters.
/// Each structure becomes a closed mesh, smoothed by no more than LABELS.toml allows; the report
/// lists the difference between its volume and that of the voxels. Thicknesses of layers are
/// measured along the skin's normal at the entry. The mechanical properties of the layers are our
/// choice for training, and the scene states so. The scene and the exercise are checked as by
/// `stylet check`.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  stylet anatomy import segmentation.nii.gz --labels labels.toml --out kidney")]
pub struct ImportArgs {
    /// The label map
    #[arg(value_name = "SEGMENTATION.nii.gz")]
    segmentation: PathBuf,
    /// Meaning of the labels, and the entry of the needle
    #[arg(long, value_name = "LABELS.toml")]
    labels: PathBuf,
    /// Folder for scene.toml, exercise.toml and the meshes; created if it does not exist
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Replace the files if they exist
    #[arg(long)]
    force: bool,
    /// Print the report as JSON
    #[arg(long)]
    json: bool,
}

/// A map, with statistics of each label.
struct Segmentation {
    map: LabelMap,
    survey: BTreeMap<u16, LabelExtent>,
}

/// A structure with its mesh.
pub struct ImportedStructure<'l> {
    /// Its entry in the document.
    pub label: &'l SegmentationLabel,
    /// Extent of its voxels.
    pub extent: LabelExtent,
    /// Its mesh, in the world.
    pub mesh: LabelMesh,
    /// The mesh in the patient frame, in m.
    pub placed: Surface,
    /// Name of its file.
    pub file: String,
}

/// A measured layer.
pub struct ImportedLayer<'l> {
    /// Its entry in the document.
    pub label: &'l SegmentationLabel,
    /// Its name in the scene: a repeated layer has a number appended.
    pub name: String,
    /// The measured values.
    pub measured: MeasuredLayer,
}

/// All results of an import.
pub struct Imported<'l> {
    /// Title of the scene.
    pub title: &'l str,
    /// The entry of the needle.
    pub frame: EntryFrame,
    /// The skin, in the world.
    pub skin: LabelMesh,
    /// The skin in the patient frame, in m.
    pub placed_skin: Surface,
    /// Structures, in the document's order.
    pub structures: Vec<ImportedStructure<'l>>,
    /// Layers from the skin down.
    pub layers: Vec<ImportedLayer<'l>>,
}

/// Runs the command.
pub fn run(args: &ImportArgs) -> Outcome {
    let document = sources::read_text(&args.labels)?;
    let labels = SegmentationLabels::from_bytes(&args.labels.display().to_string(), document.as_bytes())?;
    let mut stages = Stages::new(labels.labels.len() + 4);
    let map = LabelMap::read(sources::open(&args.segmentation)?).map_err(|why| refuse(args, &why))?;
    stages.done();
    let source = Segmentation { survey: map.survey(), map };
    stages.done();
    let imported = import(args, &labels, &source, &mut stages)?;
    let mut folder = Folder::create(&args.out, args.force)?;
    for structure in &imported.structures {
        folder.write(&structure.file, &documents::write_stl(&structure.placed))?;
    }
    folder.write(scene::SKIN_FILE, &documents::write_stl(&imported.placed_skin))?;
    folder.keep()?;
    let written = scene::write(args, &imported)?;
    drop(stages);
    let report = ImportReport::new(args, &source.map, &imported, &written);
    warn(&labels, &source.survey, &imported);
    warn_of_way(&imported, &written.way);
    if args.json {
        output::print_json(&report)?
    } else {
        output::print_buffered(|out| report.write(out))?
    }
    check(&args.out)
}

fn refuse(args: &ImportArgs, why: &SegmentationError) -> Failure {
    Failure::refused(&args.segmentation, why)
}

/// Reports a label by its number and name in the document.
fn refuse_label(args: &ImportArgs, label: &SegmentationLabel, why: &SegmentationError) -> Failure {
    Failure::refused(&args.labels, format_args!("label {} ({}): {why}", label.number, label.name))
}

fn import<'l>(
    args: &ImportArgs,
    labels: &'l SegmentationLabels,
    source: &Segmentation,
    stages: &mut Stages,
) -> Result<Imported<'l>, Failure> {
    let map = &source.map;
    let body = map.body();
    let extent = *body.survey().get(&BODY).ok_or_else(|| refuse(args, &SegmentationError::Empty))?;
    stages.done();
    let request = MeshRequest { smoothing_voxels: SKIN_SMOOTHING, most_triangles: MOST_TRIANGLES };
    let skin = mesh_label(&body, BODY, &extent, request).map_err(|why| refuse(args, &why))?;
    drop(body);
    stages.done();
    let frame = EntryFrame::new(&skin.surface, labels.entry.point_m(), labels.entry.up())
        .map_err(|why| Failure::refused(&args.labels, format_args!("entry: {why}")))?;
    let mut structures = Vec::new();
    for label in &labels.labels {
        structures.extend(mesh_structure(args, source, &frame, label)?);
        stages.done();
    }
    let layers = layers(args, labels, map, &frame)?;
    Ok(Imported { title: &labels.title, placed_skin: frame.place(&skin.surface), skin, frame, structures, layers })
}

/// Makes the mesh of a label that is a structure and has voxels.
fn mesh_structure<'l>(
    args: &ImportArgs,
    source: &Segmentation,
    frame: &EntryFrame,
    label: &'l SegmentationLabel,
) -> Result<Option<ImportedStructure<'l>>, Failure> {
    let Some((_, extent)) = label.structure().zip(source.survey.get(&label.number)) else { return Ok(None) };
    let request = MeshRequest { smoothing_voxels: label.smoothing_voxels, most_triangles: MOST_TRIANGLES };
    let mesh = mesh_label(&source.map, label.number, extent, request).map_err(|why| refuse_label(args, label, &why))?;
    let placed = frame.place(&mesh.surface);
    let file = format!("{}-{}.stl", label.number, files::plain(&label.name));
    Ok(Some(ImportedStructure { label, extent: *extent, mesh, placed, file }))
}

fn layers<'l>(
    args: &ImportArgs,
    labels: &'l SegmentationLabels,
    map: &LabelMap,
    frame: &EntryFrame,
) -> Result<Vec<ImportedLayer<'l>>, Failure> {
    let layers: BTreeMap<u16, &SegmentationLabel> =
        labels.labels.iter().filter(|label| label.tissue().is_some()).map(|label| (label.number, label)).collect();
    let role = |number: u16| match labels.labels.iter().find(|label| label.number == number) {
        Some(label) if label.tissue().is_some() => LabelRole::Layer,
        Some(_) => LabelRole::Structure,
        None => LabelRole::Unnamed,
    };
    let measured = measure_layers(map, frame, &role)
        .map_err(|why| Failure::refused(&args.labels, format_args!("entry: {why}")))?;
    let mut met: BTreeMap<u16, usize> = BTreeMap::new();
    let found = measured.into_iter().filter_map(|measured| {
        let label = *layers.get(&measured.label)?;
        let times = met.entry(measured.label).or_default();
        *times += 1;
        let name = if *times == 1 { label.name.clone() } else { format!("{} {times}", label.name) };
        Some(ImportedLayer { label, name, measured })
    });
    Ok(found.collect())
}

/// Warns about the labels.
fn warn(labels: &SegmentationLabels, survey: &BTreeMap<u16, LabelExtent>, imported: &Imported) {
    for label in labels.labels.iter().filter(|label| !survey.contains_key(&label.number)) {
        output::print_warning(format_args!(
            "label {} ({}): no voxel has this label; omitted",
            label.number, label.name
        ));
    }
    let is_named = |number: u16| labels.labels.iter().any(|label| label.number == number);
    for (number, extent) in survey.iter().filter(|(number, _)| **number != 0 && !is_named(**number)) {
        let voxels = extent.voxels;
        output::print_warning(format_args!(
            "label {number} ({voxels} voxels) has no name: treated as unclassified tissue"
        ));
    }
    for structure in imported.structures.iter().filter(|structure| structure.extent.is_cut) {
        let name = &structure.label.name;
        output::print_warning(format_args!("{name}: cut off at the edge of the image; its mesh is closed there"));
    }
}

/// Warns about the end of the layers and the path to the target.
fn warn_of_way(imported: &Imported, way: &Way) {
    let whole_mm: f64 = imported.layers.iter().map(|layer| layer.measured.thickness_m * 1e3).sum();
    if let Some(number) = imported.layers.last().and_then(|layer| layer.measured.unnamed_below) {
        output::print_warning(format_args!(
            "the layers end {whole_mm:.0} mm below the skin, where label {number} has no name; name this label as a \
             layer to go deeper"
        ));
    }
    if way.pieces > 1 {
        output::print_warning(format_args!(
            "{}: {} separate pieces; the exercise aims at the nearest",
            way.to, way.pieces
        ));
    }
    let deep_mm = way.depth_mm * libm::cos(way.angle_deg.to_radians());
    if deep_mm > whole_mm {
        output::print_warning(format_args!(
            "{}: {:.0} mm below the last layer; name the tissue above it",
            way.to,
            deep_mm - whole_mm
        ));
    }
}

/// Checks the written documents as `stylet check` does.
fn check(folder: &Path) -> Outcome {
    let mut found = Vec::new();
    for file in [scene::SCENE_FILE, scene::EXERCISE_FILE] {
        if let Err(refused) = documents::check_documents(&folder.join(file)) {
            found.extend(refused.issues.iter().map(ToString::to_string));
        }
    }
    found.sort();
    found.dedup();
    if found.is_empty() { Ok(()) } else { Err(Failure::Work(found)) }
}
