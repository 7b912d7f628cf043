//! `stylet anatomy body`: a body from parameters.

use std::path::PathBuf;

use ::anatomy::{AnatomyPart, Body, BodyOrder, BodyQuality, Dimension, Level, Posture, Standing, list_published};
use clap::ValueEnum;
use serde::Serialize;

use super::files::Folder;
use crate::exit::{Failure, Outcome};
use crate::output;
use crate::progress::Progress;

/// Make a body from parameters: each part as a closed STL mesh, and its dimensions compared with
/// published ones
///
/// A lower back with its bones, discs, ligaments, canal, muscles, kidneys, vessels and skin, for a
/// patient of a given weight and age; patients vary by seed within the published distributions.
///
/// Lengths in the meshes are in mm; x points to the patient's right, y to the head, z out of the
/// back, and the origin is on the skin between the spinous processes of L3 and L4. body.csv lists
/// each dimension of this body with the published mean, standard deviation and source, and whether
/// the source was read or only recalled; body.json lists the parameters and the size of each mesh.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  stylet anatomy body --posture sitting --seed 3 --weight-kg 95 --out body")]
pub struct BodyArgs {
    /// Position of the patient
    #[arg(long)]
    posture: PostureArg,
    /// Seed that selects one of the patients of this weight and age
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Body weight, 40 to 160 kg
    #[arg(long, value_name = "KG", default_value_t = 70.0)]
    weight_kg: f64,
    /// Age, 18 to 95 years
    #[arg(long, value_name = "YEARS", default_value_t = 40.0)]
    age_years: f64,
    /// Resolution of the surfaces
    #[arg(long, default_value = "best")]
    quality: QualityArg,
    /// Folder for the files; created if it does not exist; existing files in it are replaced
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

/// Position of a patient.
#[derive(Clone, Copy, ValueEnum)]
enum PostureArg {
    /// Face down
    Prone,
    /// Sitting, with the back bent
    Sitting,
    /// On the side, with the knees to the chest
    Side,
}

/// Resolution of the surfaces.
#[derive(Clone, Copy, ValueEnum)]
enum QualityArg {
    /// About a sixth of the triangles of the best quality
    Low,
    /// About two fifths of the triangles of the best quality
    Medium,
    /// At most 200 000 triangles in total
    Best,
}

/// Content of body.json.
#[derive(Serialize)]
struct BodyReport {
    posture: &'static str,
    seed: u64,
    weight_kg: f64,
    age_years: f64,
    triangles: usize,
    parts: Vec<PartReport>,
}

/// A part in body.json.
#[derive(Serialize)]
struct PartReport {
    name: String,
    triangles: usize,
    volume_ml: f64,
}

/// Runs the command.
pub fn run(args: &BodyArgs) -> Outcome {
    let body = Body::new(&args.order()).map_err(Failure::input)?;
    let mut folder = Folder::create(&args.out, true)?;
    let parts = AnatomyPart::list();
    let progress = Progress::new(parts.len() as u64, "meshing");
    let mut reports = Vec::new();
    for (done, part) in parts.into_iter().enumerate() {
        progress.set(done as u64);
        let mesh = body.mesh(part, args.quality());
        let volume_ml = ::anatomy::volume_m3(&mesh.vertices_m, &mesh.triangles) * 1e6;
        reports.push(PartReport { name: part.name(), triangles: mesh.triangles.len(), volume_ml });
        folder.write(&format!("{}.stl", part.name()), &documents::write_stl(&(mesh.vertices_m, mesh.triangles)))?;
    }
    drop(progress);
    folder.write("body.csv", &dimensions(&body)?)?;
    let triangles = reports.iter().map(|part| part.triangles).sum();
    let BodyOrder { posture, seed, weight_kg, age_years } = args.order();
    let report = BodyReport { posture: posture.name(), seed, weight_kg, age_years, triangles, parts: reports };
    let json = serde_json::to_vec_pretty(&report).map_err(Failure::work)?;
    folder.write("body.json", &json)?;
    folder.keep()?;
    let (parts, out) = (report.parts.len(), args.out.display());
    output::print_line(format_args!("{out}: {parts} parts, {triangles} triangles"))
}

impl BodyArgs {
    fn order(&self) -> BodyOrder {
        let posture = match self.posture {
            PostureArg::Prone => Posture::Prone,
            PostureArg::Sitting => Posture::Sitting,
            PostureArg::Side => Posture::Side,
        };
        BodyOrder { posture, seed: self.seed, weight_kg: self.weight_kg, age_years: self.age_years }
    }

    fn quality(&self) -> BodyQuality {
        match self.quality {
            QualityArg::Low => BodyQuality::Low,
            QualityArg::Medium => BodyQuality::Medium,
            QualityArg::Best => BodyQuality::Best,
        }
    }
}

/// The table of a body's dimensions with the published values.
fn dimensions(body: &Body) -> Result<Vec<u8>, Failure> {
    let mut table = csv::Writer::from_writer(Vec::new());
    table
        .write_record(["dimension", "level", "body", "published_mean", "published_sd", "standing", "source"])
        .map_err(Failure::work)?;
    for published in Dimension::ALL.into_iter().flat_map(list_published) {
        let value = body.values().get(published.dimension, published.level);
        let standing = match published.standing {
            Standing::Read => "read",
            Standing::Recalled => "recalled",
        };
        let numbers = [value, published.mean, published.sd].map(|number| format!("{number:.2}"));
        let row = [published.dimension.name(), published.level.name()].map(str::to_owned);
        let last = [standing, published.source].map(str::to_owned);
        table.write_record(row.into_iter().chain(numbers).chain(last)).map_err(Failure::work)?;
    }
    for level in Level::ALL {
        let path = body.midline_path(level, 0.0).to_flavum_m.map_or("bone".to_owned(), |m| format!("{:.2}", m * 1e3));
        let row = ["skin_to_flavum_mm", level.interspace(), &path, "", "", "measured", "straight midline path"];
        table.write_record(row).map_err(Failure::work)?;
    }
    table.into_inner().map_err(Failure::work)
}
