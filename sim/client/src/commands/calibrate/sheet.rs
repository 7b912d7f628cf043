//! The text of a fitted scene.

use std::fmt::Write as _;
use std::path::Path;

use law::axial::AxialSpec;

use super::CalibrateArgs;
use super::data::MeasuredCurve;
use crate::output;

/// Derives a scene's id from its file name; invalid characters become dashes.
pub fn id_of(out: &Path) -> String {
    let stem = out.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let plain: String = stem.chars().map(|c| if c.is_ascii_alphanumeric() || c == '_' { c } else { '-' }).collect();
    let id: String = plain.trim_start_matches(['-', '_']).chars().take(64).collect();
    if id.is_empty() { "fitted".to_owned() } else { id }
}

/// The source statement of a fitted layer.
pub fn source(args: &CalibrateArgs, rms_n: f64, curve: &MeasuredCurve) -> String {
    let (peak_n, is_timed) = (curve.peak_n(), matches!(curve, MeasuredCurve::Timed(_)));
    let percent = 100.0 * rms_n / peak_n;
    let options = if is_timed { ", and the options of law 3" } else { "" };
    let mut source = format!(
        "Thickness, stiffness, thresholds, friction and cutting{options}: fitted by stylet calibrate to {}, rms residual \
         {rms_n:.3} N, {percent:.1} % of the peak.",
        name_of(&args.data)
    );
    if let Some(kg) = args.weight_kg {
        // Writing to a string cannot fail.
        let _ = write!(source, " Depths scaled to {kg} kg.");
    }
    source
}

/// A scene with placeholder values: the reference needle and the layers of a specification.
pub fn blank(data: &Path, spec: &AxialSpec) -> String {
    let name = name_of(data);
    let has_rim = spec.tip_to_rim_m > 0.0;
    let mut text = format!(
        "id = \"fitted\"\nlaw = 5\ntitle = \"Fitted to {name}\"\ndescription = \"Layers fitted by stylet calibrate to {name}. Simulated tissue \
         for practice, not a patient.\"\n"
    );
    for layer in &spec.layers {
        // Writing to a string cannot fail.
        let _ = write!(
            text,
            "\n[[layer]]\nname = \"{}\"\nthickness_mm = 0\nstiffness_n_per_m = 1\ntip_rupture_n = 0\n{}friction_n_per_m = 0\n\
             cutting_n = 0\nsource = \"\"\n",
            layer.name,
            if has_rim { "rim_rupture_n = 0\n" } else { "" }
        );
    }
    let (kind, lag_mm) = if has_rim { ("trocar", spec.tip_to_rim_m * 1e3) } else { ("needle", 0.0) };
    let presliding = spec.presliding_stiffness_n_per_m;
    let _ = write!(
        text,
        "\n# Layers are written for the reference needle: 2 mm, diamond tip, lubrication 1.\n[needle]\nkind = \"{kind}\"\n\
         diameter_mm = 2.0\ntip = \"diamond\"\ntip_to_rim_mm = {lag_mm}\npresliding_stiffness_n_per_m = {presliding}\nspeed_window_ms = 12\n\
         damping_time_ms = 10\n"
    );
    text
}

/// A file's name, escaped for the text of a document.
fn name_of(path: &Path) -> String {
    let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    output::one_line(&name).replace(['"', '\\'], "'").chars().take(100).collect()
}
