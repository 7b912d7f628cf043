//! Reads an exercise with its scene: checks its fields against each other and against the scene,
//! then deserialises the typed document.

use law::Skin;
use phrase::{Phrase, phrase};
use serde::Deserialize;
use serde_json::Value;

use crate::describe::{EXERCISE, measure, one_of};
use crate::error::DocumentError;
use crate::exercise::{CoachingRule, Exercise, ExercisePicture, FluoroscopySettings, HardFail, Required, RubricLine};
use crate::feedback::Feedback;
use crate::metrics;
use crate::model::Scene;
use crate::picture::{self, PictureFile, PictureKind};
use crate::source::{Find, Source};
use crate::walk::{NamedError, Walked};
use crate::wording::{Wording, settle_wordings};

/// An exercise with the keys of its TOML document.
#[derive(Deserialize)]
struct RawExercise {
    id: String,
    title: Wording,
    briefing: Wording,
    scene: String,
    difficulty: u8,
    pass_mark: f64,
    time_limit_s: f64,
    feedback: Feedback,
    entry: RawEntry,
    target: RawTarget,
    #[serde(default)]
    fluoroscopy: Option<FluoroscopySettings>,
    #[serde(default)]
    required: Option<Required>,
    rubric: Vec<RubricLine>,
    hard_fail: Vec<HardFail>,
    coaching: Vec<CoachingRule>,
    picture: Vec<ExercisePicture>,
}

/// An exercise with its scene and pictures.
pub(crate) struct ExerciseParts<S> {
    /// The exercise.
    pub exercise: Exercise,
    /// Its scene, with the caller's data.
    pub scene: S,
    /// Its pictures, if requested.
    pub pictures: Vec<PictureFile>,
}

#[derive(Deserialize)]
struct RawEntry {
    #[serde(default)]
    point_mm: [f64; 2],
    angle_deg: f64,
    azimuth_deg: f64,
}

#[derive(Deserialize)]
struct RawTarget {
    depth_mm: f64,
}

/// Reads an exercise; `read_scene` loads the scene at a path. Pictures are read only if
/// `find_picture` is given: judging an attempt does not need them.
///
/// # Errors
/// Every issue found in the exercise, its pictures and its scene.
pub(crate) fn read_exercise<S>(
    source: Source,
    read_scene: impl FnOnce(&str) -> Result<S, NamedError>,
    scene_of: impl Fn(&S) -> &Scene,
    find_picture: Option<Find<'_>>,
) -> Result<ExerciseParts<S>, DocumentError> {
    let sha256 = source.sha256.clone();
    let mut doc = Walked::new(source, &EXERCISE)?;
    let named = doc.value["scene"].as_str().map(read_scene);
    let scene = named.and_then(|scene| doc.accept("scene", scene));
    settle_wordings(&mut doc);
    check(&mut doc, scene.as_ref().map(scene_of));
    let pictures = find_picture.map(|find| read_pictures(&mut doc, find)).unwrap_or_default();
    let raw = doc.finish()?;
    // Without a scene there was an issue, and `finish` has returned it.
    scene
        .map(|scene| ExerciseParts { exercise: exercise(raw, sha256), scene, pictures })
        .ok_or_else(|| DocumentError { issues: Vec::new() })
}

fn check(doc: &mut Walked, scene: Option<&Scene>) {
    for (at, line) in doc.tables("rubric").iter().enumerate() {
        let path = format!("rubric[{at}]");
        check_metric(doc, line, &path, scene);
        if line["full"].is_number() && line["full"] == line["zero"] {
            let allowed = phrase!("allowed: a number other than full");
            doc.refuse(&format!("{path}.zero"), Phrase::data(&line["zero"]), allowed);
        }
    }
    doc.refuse_duplicates("rubric", "metric");
    for (at, fail) in doc.tables("hard_fail").iter().enumerate() {
        check_metric(doc, fail, &format!("hard_fail[{at}]"), scene);
    }
    check_coaching(doc);
    check_picture_names(doc);
    check_reached(doc, scene);
    check_fluoroscopy(doc, scene);
    if let (Some(scene), Some(depth_mm)) = (scene, doc.value["target"]["depth_mm"].as_f64()) {
        let length_mm = scene.needle.length_mm;
        if depth_mm > length_mm {
            let allowed = phrase!("allowed: at most {length} mm, the needle's length", length = length_mm);
            doc.refuse("target.depth_mm", Phrase::Data(measure(depth_mm, "mm")), allowed);
        }
    }
}

/// Checks that the names of pictures have a supported extension and are unique.
fn check_picture_names(doc: &mut Walked) {
    for (at, row) in doc.tables("picture").iter().enumerate() {
        let Some(file) = row["file"].as_str() else { continue };
        if PictureKind::of_name(file).is_none() {
            doc.refuse(&format!("picture[{at}].file"), Phrase::quoted(file), picture::allowed_name());
        }
    }
    doc.refuse_duplicates("picture", "file");
}

/// Reads the pictures that an exercise names.
fn read_pictures(doc: &mut Walked, find: Find<'_>) -> Vec<PictureFile> {
    let mut read = Vec::new();
    for (at, row) in doc.tables("picture").iter().enumerate() {
        let Some(file) = row["file"].as_str().filter(|file| PictureKind::of_name(file).is_some()) else { continue };
        match find_and_read(find, file) {
            Ok(picture) => read.push(picture),
            Err(why) => doc.refuse(&format!("picture[{at}].file"), why, picture::allowed_picture()),
        }
    }
    read
}

/// Finds a picture and reads it.
///
/// # Errors
/// The reason for refusing the picture, with its name.
pub(crate) fn find_and_read(find: Find<'_>, file: &str) -> Result<PictureFile, Phrase> {
    let named = |why: Phrase| phrase!("{file}: {why}", file = Phrase::quoted(file), why = why);
    find(file).and_then(|bytes| picture::read_picture(file, bytes)).map_err(named)
}

fn check_metric(doc: &mut Walked, table: &Value, path: &str, scene: Option<&Scene>) {
    let (Some(metric), Some(scene)) = (table["metric"].as_str(), scene) else { return };
    if let Some(allowed) = metrics::refusal(metric, scene) {
        doc.refuse(&format!("{path}.metric"), Phrase::quoted(metric), allowed);
        return;
    }
    if metrics::METRICS.iter().any(|known| known.id == metric && known.needs_arm)
        && !doc.value["fluoroscopy"].is_object()
    {
        let allowed = phrase!("allowed: only in an exercise with the table [fluoroscopy]");
        doc.refuse(&format!("{path}.metric"), Phrase::quoted(metric), allowed);
        return;
    }
    let newest = metrics::newest_version(metric);
    if table["version"].as_u64().is_some_and(|version| version > u64::from(newest)) {
        let allowed = phrase!(
            "{metric} has no such version; allowed: 1 to {newest}",
            metric = metric,
            newest = u64::from(newest)
        );
        doc.refuse(&format!("{path}.version"), Phrase::data(&table["version"]), allowed);
    }
}

/// Checks that the layer to be reached exists in the scene.
fn check_reached(doc: &mut Walked, scene: Option<&Scene>) {
    let Some(scene) = scene else { return };
    let Some(layer) = doc.value["required"]["reached"].as_str().map(str::to_owned) else { return };
    let layers: Vec<&str> = scene.layers.iter().map(|l| l.name.as_str()).collect();
    if !layers.contains(&layer.as_str()) {
        doc.refuse("required.reached", Phrase::quoted(&layer), one_of(&layers));
    }
}

/// Checks that fluoroscopy has a body to show, and an exercise under fluoroscopy a C-arm.
fn check_fluoroscopy(doc: &mut Walked, scene: Option<&Scene>) {
    let has_arm = doc.value["fluoroscopy"].is_object();
    if has_arm && scene.is_some_and(|scene| scene.body.is_none()) {
        let allowed = phrase!("allowed: a scene with [anatomy], whose body the X-rays show");
        doc.refuse("fluoroscopy", Phrase::data(&doc.value["scene"]), allowed);
    }
    let Some(feedback) = doc.value["feedback"].as_str().map(str::to_owned) else { return };
    if feedback == "fluoroscopy" && !has_arm {
        let allowed = phrase!("allowed: an exercise with the table [fluoroscopy]");
        doc.refuse("feedback", Phrase::quoted(&feedback), allowed);
    }
}

/// Fills in the default of `rearm_below` and checks that it does not exceed `above`.
fn check_coaching(doc: &mut Walked) {
    for (at, rule) in doc.tables("coaching").iter().enumerate() {
        let Some(above) = rule["above"].as_f64() else { continue };
        let rearm_below = rule["rearm_below"].as_f64().unwrap_or(above);
        doc.value["coaching"][at]["rearm_below"] = rearm_below.into();
        if rearm_below > above {
            let allowed = phrase!("allowed: at most {above}, the rule's `above`", above = above);
            doc.refuse(&format!("coaching[{at}].rearm_below"), Phrase::data(rearm_below), allowed);
        }
    }
}

fn exercise(raw: RawExercise, sha256: String) -> Exercise {
    Exercise {
        id: raw.id,
        title: raw.title,
        briefing: raw.briefing.trimmed(),
        scene: raw.scene,
        entry_mm: raw.entry.point_mm,
        skin_shape: Skin::Flat,
        angle_deg: raw.entry.angle_deg,
        azimuth_deg: raw.entry.azimuth_deg,
        target_depth_mm: raw.target.depth_mm,
        time_limit_s: raw.time_limit_s,
        feedback: raw.feedback,
        fluoroscopy: raw.fluoroscopy,
        required: raw.required,
        rubric: raw.rubric,
        hard_fails: raw.hard_fail,
        pass_mark: raw.pass_mark,
        coaching: raw.coaching,
        pictures: raw.picture,
        difficulty: raw.difficulty,
        sha256,
    }
}
