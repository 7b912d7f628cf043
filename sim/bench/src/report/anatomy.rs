//! Generated bodies compared with published data: dimensions, the path between the spinous
//! processes, and the depth of the ligamentum flavum.

use std::path::{Path, PathBuf};

use ::anatomy::{
    Body, BodyMeasure, BodyOrder, BodyValues, Dimension, Level, Posture, PublishedDimension, Standing, list_published,
};
use assessment::statistics::wilson;

use super::sheet::{self, ReportSheet};
use super::threads::each_seed;
use super::{Subject, measured_on};
use crate::error::BenchError;
use crate::progress::MeasurementProgress;

/// Number of bodies whose dimensions are drawn, whose midline paths are evaluated, and whose
/// surface is measured.
const WHOLE: Counts = Counts { drawn: 1000, tried: 1000, measured: 40 };
/// The same for a shortened report.
const SHORTENED: Counts = Counts { drawn: 1000, tried: 10, measured: 2 };
/// Weights at which the depth of the flavum is reported, in kg.
const WEIGHTS_KG: [f64; 4] = [50.0, 70.0, 90.0, 110.0];
const AGES_YEARS: [f64; 2] = [20.0, 80.0];

struct Counts {
    drawn: u64,
    tried: u64,
    measured: u64,
}

/// Mean and standard deviation over bodies.
#[derive(Clone, Copy)]
struct Moments {
    mean: f64,
    sd: f64,
    count: usize,
}

impl Moments {
    fn of(values: impl Iterator<Item = f64>) -> Self {
        let values: Vec<f64> = values.collect();
        let count = values.len();
        let mean = values.iter().sum::<f64>() / count as f64;
        let squares: f64 = values.iter().map(|value| (value - mean) * (value - mean)).sum();
        Self { mean, sd: libm::sqrt(squares / (count as f64 - 1.0)), count }
    }

    fn in_words(&self) -> String {
        format!("{:.1} ± {:.1}", self.mean, self.sd)
    }
}

/// A dimension at a level: published, and in generated bodies.
struct DimensionRow {
    published: PublishedDimension,
    /// Source of the bodies' values: `drawn`, or `surface` if measured on the shape.
    from: &'static str,
    bodies: Moments,
}

/// Number of bodies in which a straight midline path reaches the flavum of an interspace.
struct PathRow {
    posture: Posture,
    level: Level,
    free: usize,
    tried: usize,
    /// Distance from skin to flavum, perpendicular to the line between the two spinous tips, in mm,
    /// if that path is free.
    to_flavum: Moments,
}

/// Depth of the flavum of L3/4 at a weight.
struct DepthRow {
    weight_kg: f64,
    to_flavum: Moments,
}

/// Measures bodies and writes `anatomy.{csv,md}`; returns the files written.
///
/// # Errors
/// On an I/O error.
pub fn measure(out: &Path, quick: bool) -> Result<Vec<PathBuf>, BenchError> {
    let counts = if quick { SHORTENED } else { WHOLE };
    let postures = Posture::ALL.len() as u64;
    let weights = WEIGHTS_KG.len() as u64;
    let progress = MeasurementProgress::new(counts.measured + counts.tried * (postures + weights), "bodies");
    let mut dimensions = drawn_dimensions(counts.drawn)?;
    dimensions.extend(surface_dimensions(counts.measured, &progress)?);
    let paths = midline_paths(counts.tried, &progress)?;
    let depths = flavum_depths(counts.tried, &progress)?;
    drop(progress);
    let table = out.join("anatomy.csv");
    csv(&dimensions, &paths, &depths).write_csv(&table)?;
    let text = sheet::write_text(out.join("anatomy.md"), &markdown(&dimensions, &paths, &depths, quick))?;
    Ok(vec![table, text])
}

/// Returns the parameters of the body for a seed: adults of 70 kg with ages evenly spread around 50
/// years, for which the published dimensions hold.
fn order(seed: u64, posture: Posture) -> BodyOrder {
    let [least, most] = AGES_YEARS;
    let age_years = least + (most - least) * (seed * 7 % 61) as f64 / 60.0;
    BodyOrder { posture, seed, weight_kg: 70.0, age_years }
}

fn make_body(order: &BodyOrder) -> Result<Body, BenchError> {
    Body::new(order).map_err(BenchError::work)
}

fn drawn_dimensions(bodies: u64) -> Result<Vec<DimensionRow>, BenchError> {
    let values = each_seed(0..bodies, |seed| BodyValues::draw(&order(seed, Posture::Sitting)))?;
    let row = |published: PublishedDimension| {
        let bodies = Moments::of(values.iter().map(|body| body.get(published.dimension, published.level)));
        DimensionRow { published, from: "drawn", bodies }
    };
    Ok(Dimension::ALL.into_iter().flat_map(list_published).map(row).collect())
}

/// A published dimension and its measurement on the shape.
type SurfaceDimension = (Dimension, fn(&BodyMeasure) -> f64);
const SURFACE: [SurfaceDimension; 3] = [
    (Dimension::EndplateWidth, |measure| measure.body_width_mm),
    (Dimension::CanalDepth, |measure| measure.canal_depth_mm),
    (Dimension::TransverseSpan, |measure| measure.transverse_span_mm),
];

fn surface_dimensions(bodies: u64, progress: &MeasurementProgress) -> Result<Vec<DimensionRow>, BenchError> {
    let measure = |seed| -> Result<[BodyMeasure; 5], BenchError> {
        let body = make_body(&order(seed, Posture::Sitting))?;
        progress.advance(1);
        Ok(Level::ALL.map(|level| body.measure(level)))
    };
    let measured = each_seed(0..bodies, measure)?.into_iter().collect::<Result<Vec<_>, _>>()?;
    let row = |(dimension, of): SurfaceDimension| {
        let measured = &measured;
        list_published(dimension).map(|published| {
            let values = measured.iter().map(move |levels| of(&levels[published.level as usize]));
            DimensionRow { published, from: "surface", bodies: Moments::of(values) }
        })
    };
    Ok(SURFACE.into_iter().flat_map(row).collect())
}

fn midline_paths(bodies: u64, progress: &MeasurementProgress) -> Result<Vec<PathRow>, BenchError> {
    let mut rows = Vec::new();
    for posture in Posture::ALL {
        let tried = |seed| -> Result<[(bool, Option<f64>); 5], BenchError> {
            let body = make_body(&order(seed, posture))?;
            progress.advance(1);
            Ok(Level::ALL.map(|level| (body.has_midline_path(level), body.midline_path(level, 0.0).to_flavum_m)))
        };
        let found = each_seed(0..bodies, tried)?.into_iter().collect::<Result<Vec<_>, _>>()?;
        rows.extend(Level::ALL.map(|level| {
            let of_level = || found.iter().map(|levels| levels[level as usize]);
            PathRow {
                posture,
                level,
                free: of_level().filter(|(is_free, _)| *is_free).count(),
                tried: found.len(),
                to_flavum: Moments::of(of_level().filter_map(|(_, to_flavum_m)| to_flavum_m).map(|m| m * 1e3)),
            }
        }));
    }
    Ok(rows)
}

fn flavum_depths(bodies: u64, progress: &MeasurementProgress) -> Result<Vec<DepthRow>, BenchError> {
    let row = |weight_kg: f64| -> Result<DepthRow, BenchError> {
        let depth = |seed| -> Result<Option<f64>, BenchError> {
            let body = make_body(&BodyOrder { weight_kg, ..order(seed, Posture::Sitting) })?;
            progress.advance(1);
            Ok(body.midline_path(Level::L3, 0.0).to_flavum_m)
        };
        let found = each_seed(0..bodies, depth)?.into_iter().collect::<Result<Vec<_>, _>>()?;
        Ok(DepthRow { weight_kg, to_flavum: Moments::of(found.into_iter().flatten().map(|m| m * 1e3)) })
    };
    WEIGHTS_KG.into_iter().map(row).collect()
}

fn csv(dimensions: &[DimensionRow], paths: &[PathRow], depths: &[DepthRow]) -> ReportSheet {
    let mut sheet = ReportSheet::new([
        "what",
        "from",
        "place",
        "published_mean",
        "published_sd",
        "standing",
        "source",
        "bodies_mean",
        "bodies_sd",
        "bodies",
    ]);
    let moments = |of: &Moments| [of.mean.to_string(), of.sd.to_string(), of.count.to_string()];
    for DimensionRow { published, from, bodies } in dimensions {
        let of = [published.dimension.name(), from, published.level.name()].map(str::to_owned);
        let numbers = [published.mean, published.sd].map(|number| number.to_string());
        let source = [standing_in_words(published.standing), published.source].map(str::to_owned);
        sheet.row(of.into_iter().chain(numbers).chain(source).chain(moments(bodies)));
    }
    let unpublished = || std::iter::repeat_n(String::new(), 4);
    for PathRow { posture, level, free, tried, to_flavum } in paths {
        let place = level.interspace();
        let share = [*free as f64 / *tried as f64].map(|share| share.to_string());
        let of = ["free_midline_path_share", posture.name(), place].map(str::to_owned);
        let none = [String::new(), tried.to_string()];
        sheet.row(of.into_iter().chain(unpublished()).chain(share).chain(none));
        let of = ["skin_to_flavum_mm", posture.name(), place].map(str::to_owned);
        sheet.row(of.into_iter().chain(unpublished()).chain(moments(to_flavum)));
    }
    for DepthRow { weight_kg, to_flavum } in depths {
        let of = ["skin_to_flavum_mm".to_owned(), format!("sitting, {weight_kg} kg"), "L3/4".to_owned()];
        sheet.row(of.into_iter().chain(unpublished()).chain(moments(to_flavum)));
    }
    sheet
}

fn standing_in_words(standing: Standing) -> &'static str {
    match standing {
        Standing::Read => "read",
        Standing::Recalled => "recalled",
    }
}

/// Returns a table with a row for each dimension and a column for each level: published values,
/// then those of the bodies.
fn dimension_sheet(rows: &[&DimensionRow]) -> ReportSheet {
    let mut sheet = ReportSheet::new(["dimension"].into_iter().chain(Level::ALL.map(Level::name)));
    for levels in rows.chunks(Level::ALL.len()) {
        let cells = levels.iter().map(|row| {
            let PublishedDimension { mean, sd, standing, .. } = row.published;
            let mark = if standing == Standing::Read { "*" } else { "" };
            format!("{mean:.1} ± {sd:.1}{mark}; {}", row.bodies.in_words())
        });
        let name = levels.first().map_or("", |row| row.published.dimension.name());
        sheet.row([name.replace('_', " ")].into_iter().chain(cells));
    }
    sheet
}

fn path_sheet(paths: &[PathRow], free: fn(&PathRow) -> usize) -> ReportSheet {
    let mut sheet = ReportSheet::new(["posture"].into_iter().chain(Level::ALL.map(Level::interspace)));
    for levels in paths.chunks(Level::ALL.len()) {
        let cells = levels.iter().map(|row| match wilson(free(row), row.tried) {
            Ok(share) => {
                let [value, low, high] = [share.value, share.low, share.high].map(|share| share * 1e2);
                format!("{value:.0} % ({low:.0} to {high:.0})")
            }
            Err(_) => "–".to_owned(),
        });
        let posture = levels.first().map_or("", |row| row.posture.name());
        sheet.row([posture.to_owned()].into_iter().chain(cells));
    }
    sheet
}

/// Returns the increase of the flavum's depth per kg, in mm, from the least-squares line through
/// the weights.
fn slope_mm_per_kg(depths: &[DepthRow]) -> f64 {
    let count = depths.len() as f64;
    let weight = depths.iter().map(|row| row.weight_kg).sum::<f64>() / count;
    let rise: f64 = depths.iter().map(|row| (row.weight_kg - weight) * row.to_flavum.mean).sum();
    rise / depths.iter().map(|row| (row.weight_kg - weight) * (row.weight_kg - weight)).sum::<f64>()
}

fn markdown(dimensions: &[DimensionRow], paths: &[PathRow], depths: &[DepthRow], quick: bool) -> String {
    let [drawn, surface] =
        ["drawn", "surface"].map(|from| dimensions.iter().filter(|row| row.from == from).collect::<Vec<_>>());
    let count = |rows: &[&DimensionRow]| rows.first().map_or(0, |row| row.bodies.count);
    let tried = paths.first().map_or(0, |row| row.tried);
    let mut by_weight = ReportSheet::new(["weight", "bodies whose path is free", "skin to flavum, mm"]);
    for DepthRow { weight_kg, to_flavum } in depths {
        by_weight.row([format!("{weight_kg} kg"), to_flavum.count.to_string(), to_flavum.in_words()]);
    }
    format!(
        "# Bodies from numbers\n\n{}\n\nLengths in mm, angles in degrees; mean ± standard deviation. Adults of 70 kg, 20 to 80 years old. \
         Sources, and what was read of them and what is only recalled, stand in `anatomy.csv`.\n\n\
         ## Dimensions that are drawn\n\nPublished; {} bodies. An asterisk marks what was read in its source. Draws end 2.2 standard \
         deviations out, which takes a little off their spread; dimensions that grow with age spread more than among people of one age.\n\n{}\n\
         ## Dimensions of the surface\n\nPublished; the bony surface of {} bodies, found from outside. What was drawn is what is met.\n\n{}\n\
         ## The way between the spinous processes\n\nThe share of {tried} bodies in which some straight path in the midline, from the middle of \
         the interspace as it is felt and up to 30° to the head, reaches the ligamentum flavum before bone; with 95 % intervals.\n\n{}\n\
         The same of the one path that goes straight across the line from tip to tip.\n\n{}\n\
         Beside them: of 211 patients who sat, the first needle reached the sac in 55.7 % with their legs over the edge and in 62.9 % with \
         legs crossed (Anesth Pain Med, article 17595, read); of 100 elderly ones in 64 and in 78 % (Afolayan et al., Pan African Med J 2017, \
         28:223, abstract read). Hands choose an angle that is likely, and miss paths that there are, so that such a share lies between the two \
         tables, as it does at L3/4 and below. Prone fewer are free, as it should be: flexed hips widen the spaces by 7 to 21 % from L2/3 down to L4/5 (radiographs of \
         volunteers, abstract read). That the window of L5/S1 is the largest of the lowest three (Bae et al. 2019, paramedian ultrasound, abstract read) is \
         not so in the midline of these bodies.\n\n\
         ## How deep the flavum lies\n\nAt L3/4, sitting. It grows by {:.2} mm/kg; 0.18 in women and 0.37 in men are published (So, Kim and Ahn \
         1997, read).\n\n{}",
        measured_on(Subject::Anatomy, quick),
        count(&drawn),
        dimension_sheet(&drawn).markdown(),
        count(&surface),
        dimension_sheet(&surface).markdown(),
        path_sheet(paths, |row| row.free).markdown(),
        path_sheet(paths, |row| row.to_flavum.count).markdown(),
        slope_mm_per_kg(depths),
        by_weight.markdown()
    )
}
