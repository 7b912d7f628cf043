//! The picture: time of a frame, for every view and quality, on this machine's graphics adapter.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use render::frame::{
    FieldTable, Frame, Layer, Material, Mesh, Needle, Puncture, Stage, Structure, StructureKind, Tip, View,
};
use render::{AdapterName, Headless, PictureError, Quality};

use super::chart::{Chart, Curve, SeriesLabelPosition};
use super::measured_on;
use super::sheet::{self, Sheet};
use crate::clock;
use crate::exit::Failure;
use crate::progress::Progress;

/// Size of the pictures, in pixels.
const SIZE: [u32; 2] = [1280, 720];
/// Frames timed of each kind, after one that is not.
const FRAMES: usize = 40;
const QUICK_FRAMES: usize = 2;
/// What a frame may take with everything on, in ms: software, hardware.
const BARS_MS: [f64; 2] = [100.0, 4.0];
/// Skin, fat, fascia, muscle: thickness in mm.
const LAYERS: [(Material, f32); 4] =
    [(Material::Skin, 0.8), (Material::Fat, 8.4), (Material::Fascia, 0.6), (Material::Muscle, 39.0)];

/// Times of one kind of picture.
struct Row {
    what: &'static str,
    quality: Quality,
    median_ms: f64,
    p99_ms: f64,
}

/// Measures, and writes `render.{csv,md,svg}`; returns the files written.
///
/// # Errors
/// When there is no graphics adapter, or the disk refuses.
pub fn measure(out: &Path, quick: bool) -> Result<Vec<PathBuf>, Failure> {
    let begun = clock::instant();
    let mut headless = Headless::new(Quality::Full).map_err(Failure::work)?;
    headless.set_stage(&stage()).map_err(Failure::work)?;
    headless.draw(&frames()[0].1, SIZE).map_err(Failure::work)?;
    let start_s = begun.elapsed().as_secs_f64();
    let rows = rows(&mut headless, if quick { QUICK_FRAMES } else { FRAMES })?;
    let (table, plot) = (out.join("render.csv"), out.join("render.svg"));
    csv(&rows).write_csv(&table)?;
    chart(&rows).draw(&plot)?;
    let text = sheet::write_text(out.join("render.md"), &markdown(&rows, &headless, (start_s, quick)))?;
    Ok(vec![table, plot, text])
}

/// Draws as fast as it can until told to stop, as a window would beside a servo; what drew and how often, or why nothing did.
pub fn draw_until(stop: &AtomicBool) -> String {
    let mut drawn = 0_u32;
    let mut draw = || -> Result<AdapterName, PictureError> {
        let mut headless = Headless::new(Quality::Full)?;
        headless.set_stage(&stage())?;
        let [(_, whole), ..] = frames();
        while !stop.load(Ordering::Relaxed) {
            headless.draw(&whole, SIZE)?;
            drawn += 1;
        }
        Ok(headless.adapter())
    };
    match draw() {
        Ok(adapter) => format!("{drawn} pictures of {} × {} pixels by {adapter}", SIZE[0], SIZE[1]),
        Err(error) => format!("no picture: {error}"),
    }
}

fn rows(headless: &mut Headless, count: usize) -> Result<Vec<Row>, Failure> {
    let frames = frames();
    let progress = Progress::new((Quality::ALL.len() * frames.len()) as u64, "render");
    let mut rows = Vec::new();
    for quality in Quality::ALL {
        headless.set_quality(quality);
        for (what, frame) in &frames {
            let mut times_ms = times(headless, frame, count)?;
            times_ms.sort_by(f64::total_cmp);
            let at = |share: f64| times_ms[((times_ms.len() - 1) as f64 * share).round() as usize];
            rows.push(Row { what, quality, median_ms: at(0.5), p99_ms: at(0.99) });
            progress.set(rows.len() as u64);
        }
    }
    Ok(rows)
}

/// Times of frames in ms, each waited for; the first, which may compile, is not counted.
fn times(headless: &mut Headless, frame: &Frame, count: usize) -> Result<Vec<f64>, Failure> {
    headless.draw(frame, SIZE).map_err(Failure::work)?;
    let mut times_ms = Vec::with_capacity(count);
    for _ in 0..count {
        let start = clock::instant();
        headless.draw(frame, SIZE).map_err(Failure::work)?;
        times_ms.push(start.elapsed().as_secs_f64() * 1e3);
    }
    Ok(times_ms)
}

/// A body with structures and a field, as large as the shipped scenes': what a frame takes does not depend on the numbers.
fn stage() -> Stage {
    let mut top_m = 0.0;
    let layers = LAYERS.map(|(material, thickness_mm)| {
        let layer = Layer { name: String::new(), material, top_m, thickness_m: 1e-3 * thickness_mm };
        top_m += layer.thickness_m;
        layer
    });
    let loads = 2 * layers.len();
    let radii_m: Vec<f32> = (0..48).map(|i| 2.5e-5 * (i * i) as f32).collect();
    let row = radii_m.iter().map(|r| 1.2e-5 / (0.004 + r));
    let axial_m_per_n = row.cycle().take(radii_m.len() * loads * layers.len()).collect();
    Stage {
        layers: layers.to_vec(),
        needle: Needle { length_m: 0.15, diameter_m: 0.002, tip_to_rim_m: 0.002, tip: Tip::Diamond },
        structures: vec![
            Structure { name: String::new(), kind: StructureKind::Target, mesh: ball([0.0, 0.0, -0.028], 0.0025) },
            Structure { name: String::new(), kind: StructureKind::Vessel, mesh: ball([0.012, 0.002, -0.018], 0.004) },
            Structure { name: String::new(), kind: StructureKind::Bone, mesh: ball([-0.02, 0.004, -0.03], 0.008) },
        ],
        field: FieldTable { radii_m, loads, axial_m_per_n },
        axis: [0.0, 0.0, -1.0],
        target_m: [0.0, 0.0, -0.028],
        ..Stage::default()
    }
}

fn ball(middle: [f32; 3], radius_m: f32) -> Mesh {
    const AROUND: u32 = 40;
    const ALONG: u32 = 24;
    let mut mesh = Mesh::default();
    for i in 0..=ALONG {
        let (ring, z) = (std::f32::consts::PI * i as f32 / ALONG as f32).sin_cos();
        for k in 0..AROUND {
            let (y, x) = (std::f32::consts::TAU * k as f32 / AROUND as f32).sin_cos();
            let on_sphere = [ring * x, ring * y, z];
            mesh.positions_m.push(std::array::from_fn(|axis| middle[axis] + radius_m * on_sphere[axis]));
        }
    }
    for i in 0..ALONG {
        for k in 0..AROUND {
            let (a, b) = (i * AROUND + k, i * AROUND + (k + 1) % AROUND);
            mesh.triangles.extend([[a, a + AROUND, b], [b, a + AROUND, b + AROUND]]);
        }
    }
    mesh
}

/// Every view with everything on: needle in the tissue, tents, blood, guide.
fn frames() -> [(&'static str, Frame); 4] {
    let puncture = Puncture { axis: [0.0, 0.0, -1.0], depth_m: 0.0125, opened: 3, blood: 0.7, ..Puncture::default() };
    let mut loads_n = vec![0.0; 2 * LAYERS.len()];
    loads_n[3] = 1.3;
    let whole = Frame {
        tip_m: [0.0, 0.0, -0.0125],
        orientation: [1.0, 0.0, 0.0, 0.0],
        entry_m: Some([0.0; 3]),
        punctures: vec![puncture],
        guide: true,
        loads_n,
        ..Frame::default()
    };
    [
        ("whole", whole.clone()),
        ("whole, body faded", Frame { fade: 0.7, ..whole.clone() }),
        ("tip", Frame { view: View::Tip, ..whole.clone() }),
        ("section", Frame { view: View::Section, ..whole }),
    ]
}

fn csv(rows: &[Row]) -> Sheet {
    let mut sheet = Sheet::new(["view", "quality", "median_ms", "p99_ms"]);
    for Row { what, quality, median_ms, p99_ms } in rows {
        sheet.row([what.to_string(), quality.name().to_owned(), format!("{median_ms:.3}"), format!("{p99_ms:.3}")]);
    }
    sheet
}

/// Time against the step of quality, best first.
fn chart(rows: &[Row]) -> Chart {
    let curve = |(what, _): &(&'static str, Frame)| {
        let own = rows.iter().filter(|row| row.what == *what).enumerate();
        Curve { name: (*what).to_owned(), points: own.map(|(at, row)| ((at + 1) as f64, row.median_ms)).collect() }
    };
    Chart {
        title: format!("A frame at {} × {}", SIZE[0], SIZE[1]),
        x: "step of quality, 1 full to 5 least".to_owned(),
        y: "median time, ms".to_owned(),
        curves: frames().iter().map(curve).collect(),
        legend: SeriesLabelPosition::LowerLeft,
        rings: Vec::new(),
    }
}

fn markdown(rows: &[Row], headless: &Headless, (start_s, quick): (f64, bool)) -> String {
    let mut sheet = Sheet::new(["view", "quality", "made of", "median", "p99"]);
    for Row { what, quality, median_ms, p99_ms } in rows {
        let times = [median_ms, p99_ms].map(|ms| format!("{ms:.1} ms"));
        sheet.row([
            what.to_string(),
            quality.name().to_owned(),
            quality.in_words(),
            times[0].clone(),
            times[1].clone(),
        ]);
    }
    let adapter = headless.adapter();
    let bar_ms = if adapter.software { BARS_MS[0] } else { BARS_MS[1] };
    format!(
        "# Picture\n\n{}\n\nDrawn by {adapter}: {} × {} pixels, {} triangles with the body faded, every frame waited for. From \
         nothing to the first frame: {start_s:.1} s. The bar on this kind of adapter is {bar_ms} ms at the median; the window \
         starts at the best quality that its adapter holds, and goes down a step rather than stutter.\n\n{}\n![time of a \
         frame](render.svg)\n",
        measured_on(quick),
        SIZE[0],
        SIZE[1],
        headless.renderer().triangles(),
        sheet.markdown()
    )
}
