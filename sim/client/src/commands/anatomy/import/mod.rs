//! `stylet anatomy import`: a scene from somebody else's segmentation.

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

/// Most triangles of a mesh: what recordings carry and the picture draws with ease.
const MOST_TRIANGLES: usize = 40_000;
/// Smoothing of the skin, in voxels.
const SKIN_SMOOTHING: f64 = 0.5;

/// Make a scene of a segmentation: meshes, skin, layers, and an exercise beside it
///
/// SEGMENTATION is a map of labels, NIfTI-1 or NIfTI-2, packed (.nii.gz) or not (.nii); it lies in the world as its sform says, else as its
/// qform says, else along the axes: right, anterior, superior. LABELS.toml says what each number is, and where the needle enters. Each
/// structure becomes a closed mesh, smoothed by no more than LABELS.toml allows; the report says by how much its volume differs from the
/// voxels'. Thicknesses of layers are measured along the skin's normal at the entry. What the layers feel like is our choice for training,
/// and the scene says so. The scene and the exercise are checked as `stylet check` does.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  stylet anatomy import segmentation.nii.gz --labels labels.toml --out kidney")]
pub struct ImportArgs {
    /// The map of labels
    #[arg(value_name = "SEGMENTATION.nii.gz")]
    segmentation: PathBuf,
    /// What the labels mean, and where the needle enters
    #[arg(long, value_name = "LABELS.toml")]
    labels: PathBuf,
    /// Folder for scene.toml, exercise.toml and the meshes; created if need be
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Replace the files if they exist
    #[arg(long)]
    force: bool,
    /// Print the report as JSON
    #[arg(long)]
    json: bool,
}

/// A map, and what it holds of each label.
struct Segmentation {
    map: LabelMap,
    survey: BTreeMap<u16, LabelExtent>,
}

/// A structure, meshed.
pub struct ImportedStructure<'l> {
    /// What the document says of it.
    pub label: &'l SegmentationLabel,
    /// Where its voxels are.
    pub extent: LabelExtent,
    /// Its mesh, in the world.
    pub mesh: LabelMesh,
    /// The mesh in the patient frame, in m.
    pub placed: Surface,
    /// Name of its file.
    pub file: String,
}

/// A layer, measured.
pub struct ImportedLayer<'l> {
    /// What the document says of it.
    pub label: &'l SegmentationLabel,
    /// Its name in the scene: met again, a layer has a number behind its name.
    pub name: String,
    /// What was measured.
    pub measured: MeasuredLayer,
}

/// All that was made of a map.
pub struct Imported<'l> {
    /// Title of the scene.
    pub title: &'l str,
    /// Where the needle enters.
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

/// A label of the document is refused by its place there.
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

/// The mesh of a label that is a structure and has voxels.
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

/// What the user should know of the labels.
fn warn(labels: &SegmentationLabels, survey: &BTreeMap<u16, LabelExtent>, imported: &Imported) {
    for label in labels.labels.iter().filter(|label| !survey.contains_key(&label.number)) {
        output::print_warning(format_args!("label {} ({}): no voxel has it; left out", label.number, label.name));
    }
    let is_named = |number: u16| labels.labels.iter().any(|label| label.number == number);
    for (number, extent) in survey.iter().filter(|(number, _)| **number != 0 && !is_named(**number)) {
        let voxels = extent.voxels;
        output::print_warning(format_args!(
            "label {number} ({voxels} voxels) has no name: tissue that is not told apart"
        ));
    }
    for structure in imported.structures.iter().filter(|structure| structure.extent.is_cut) {
        let name = &structure.label.name;
        output::print_warning(format_args!("{name}: the image ends in it; its mesh is closed there"));
    }
}

/// What the user should know of the layers' end and of the way to the target.
fn warn_of_way(imported: &Imported, way: &Way) {
    let whole_mm: f64 = imported.layers.iter().map(|layer| layer.measured.thickness_m * 1e3).sum();
    if let Some(number) = imported.layers.last().and_then(|layer| layer.measured.unnamed_below) {
        output::print_warning(format_args!(
            "the layers end {whole_mm:.0} mm below the skin, where label {number} has no name; name it as a layer to go deeper"
        ));
    }
    if way.pieces > 1 {
        output::print_warning(format_args!("{}: {} pieces; the exercise aims at the nearest", way.to, way.pieces));
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

/// Checks what was written as `stylet check` does.
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
