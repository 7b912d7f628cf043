//! Checks behind `stylet check`: reports scenes whose ruptures are unsound and structures that lie
//! outside the body.

use std::path::{Path, PathBuf};

use law::Incidence;
use law::axial::{AxialSpec, Contactor};
use law::soundness::{self, Unsound};
use phrase::{Phrase, phrase};
use tissue::follow::FollowError;

use crate::describe::{EXERCISE, SCENE};
use crate::error::{DocumentError, Issue, Remark};
use crate::load::{Document, ExerciseBundle, path_beside, read_document, read_file};
use crate::model::Scene;
use crate::patient::Patient;
use crate::placing::list_misplaced;
use crate::planned::PlannedNeedle;
use crate::source::Source;
use crate::walk::Walked;

/// A rupture that would create force or energy, and where.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// The patient: nominal, thinnest or thickest.
    pub patient: Phrase,
    /// Angle of the path to the surface normal, in degrees.
    pub angle_deg: f64,
    /// The rupture.
    pub unsound: Unsound,
}

impl Scene {
    /// Returns every unsound rupture once, at the first place that has it. Checks the nominal
    /// patient, the thinnest and the thickest of the spread, each perpendicularly and along the
    /// planned path.
    ///
    /// # Errors
    /// If no model of a coupled tissue can be built.
    pub fn soundness(&self, planned: impl Into<PlannedNeedle>) -> Result<Vec<Finding>, FollowError> {
        let [thinnest, thickest] = Patient::extremes(self);
        let patients = [
            (phrase!("nominal"), Patient::nominal(self)),
            (phrase!("thinnest"), thinnest),
            (phrase!("thickest"), thickest),
        ];
        let planned = planned.into();
        let upright = PlannedNeedle { angle_deg: 0.0, ..planned };
        let ways = if planned.angle_deg == 0.0 { vec![upright] } else { vec![upright, planned] };
        let mut findings: Vec<Finding> = Vec::new();
        for (patient, drawn) in patients {
            for way in &ways {
                let (axial, incidence) = (self.coupled_spec(&drawn, *way)?, way.incidence(&self.skin_shape));
                for unsound in soundness::find_unsound_ruptures(&spec_along_path(axial, &incidence)) {
                    let is_same = |f: &Finding| {
                        (f.unsound.boundary, f.unsound.contactor) == (unsound.boundary, unsound.contactor)
                    };
                    if !findings.iter().any(is_same) {
                        findings.push(Finding { patient: patient.clone(), angle_deg: way.angle_deg, unsound });
                    }
                }
            }
        }
        Ok(findings)
    }
}

/// Converts an axial law to a needle's path: sets the thickness of each layer to its length along
/// the path.
#[must_use]
pub fn spec_along_path(mut spec: AxialSpec, incidence: &Incidence) -> AxialSpec {
    let mut boundaries_m = Vec::new();
    incidence.lay_layers(spec.layers.iter().map(|layer| layer.thickness_m), &mut boundaries_m);
    for (layer, ends_m) in spec.layers.iter_mut().zip(boundaries_m.windows(2)) {
        layer.thickness_m = ends_m[1] - ends_m[0];
    }
    spec
}

/// Reads a document and the files that it names; refuses unsound scenes and scenes with structures
/// outside the body.
///
/// # Errors
/// Every issue found.
pub fn check_documents(path: &Path) -> Result<Document, DocumentError> {
    let document = read_document(path)?;
    let mut issues = list_unsound_layers(path, &document)?;
    issues.extend(list_blocked_ways(path, &document)?);
    if issues.is_empty() { Ok(document) } else { Err(DocumentError { issues }) }
}

/// Returns an issue for each unsound rupture in the scenes of a document read from `path`.
fn list_unsound_layers(path: &Path, document: &Document) -> Result<Vec<Issue>, DocumentError> {
    let mut issues: Vec<Issue> = Vec::new();
    for (path, scene, planned) in list_scenes(path, document) {
        let source = || Source::new(&path.display().to_string(), &read_file(&path)?);
        for issue in unsound_issues(scene, planned, source)? {
            let is_same = |i: &Issue| (&i.file, i.line, &i.field) == (&issue.file, issue.line, &issue.field);
            if !issues.iter().any(is_same) {
                issues.push(issue);
            }
        }
    }
    Ok(issues)
}

/// An issue for each planned way of a document, read from `path`, that meets bone. A scene alone plans one where it names an anatomy.
fn list_blocked_ways(path: &Path, document: &Document) -> Result<Vec<Issue>, DocumentError> {
    let of_exercise =
        |path: &Path, bundle: &ExerciseBundle| bundle.place(&path.display().to_string(), &bundle.blocked_ways());
    match document {
        Document::Scene(scene) => {
            let doc = Walked::new(Source::new(&path.display().to_string(), &read_file(path)?)?, &SCENE)?;
            let number = |key: &str| doc.value["anatomy"][key].as_f64();
            let planned = number("angle_deg").map(|angle_deg| PlannedNeedle {
                angle_deg,
                azimuth_deg: number("azimuth_deg").unwrap_or_default(),
                ..PlannedNeedle::default()
            });
            let remark =
                planned.and_then(|planned| scene.remark_blocked_way(&planned, doc.value["anatomy"]["goal"].as_str()));
            let issue = |Remark { field, found, allowed }| doc.issue(&field, found, allowed);
            Ok(remark.into_iter().map(issue).collect())
        }
        Document::Exercise(bundle) => of_exercise(path, bundle),
        Document::Curriculum(curriculum, bundles) => {
            let entries = curriculum.entries.iter().zip(bundles);
            let issues = entries.map(|(entry, bundle)| of_exercise(&path_beside(path, &entry.file), bundle));
            Ok(issues.collect::<Result<Vec<_>, _>>()?.concat())
        }
        Document::Instrument(_) => Ok(Vec::new()),
    }
}

/// Every scene of a document with its path, and how it is met.
fn list_scenes<'d>(path: &Path, document: &'d Document) -> Vec<(PathBuf, &'d Scene, PlannedNeedle)> {
    let of_exercise = |path: &Path, bundle: &'d ExerciseBundle| {
        (path_beside(path, &bundle.exercise.scene), &bundle.scene, bundle.exercise.planned_needle())
    };
    match document {
        Document::Scene(scene) => vec![(path.to_owned(), scene.as_ref(), PlannedNeedle::default())],
        Document::Exercise(bundle) => vec![of_exercise(path, bundle)],
        Document::Curriculum(curriculum, bundles) => {
            let entries = curriculum.entries.iter().zip(bundles);
            entries.map(|(entry, bundle)| of_exercise(&path_beside(path, &entry.file), bundle)).collect()
        }
        Document::Instrument(_) => Vec::new(),
    }
}

impl ExerciseBundle {
    /// Places remarks in the exercise's document, named `file`, sorted by position.
    ///
    /// # Errors
    /// If the document, which was read before, is refused.
    pub fn place(&self, file: &str, remarks: &[Remark]) -> Result<Vec<Issue>, DocumentError> {
        if remarks.is_empty() {
            return Ok(Vec::new());
        }
        let doc = Walked::new(Source::new(file, &self.exercise_bytes)?, &EXERCISE)?;
        let issue = |Remark { field, found, allowed }: &Remark| doc.issue(field, found.clone(), allowed.clone());
        let mut issues: Vec<Issue> = remarks.iter().map(issue).collect();
        issues.sort_by_key(|issue| (issue.line, issue.column));
        Ok(issues)
    }

    /// Every unsound rupture in its scene and every structure outside the body, placed in the scene's document, and a planned way that
    /// meets bone, placed in its own.
    ///
    /// # Errors
    /// When a document, read once already, is refused.
    pub fn unsound(&self) -> Result<Vec<Issue>, DocumentError> {
        let source = || Source::new("attached scene", &self.scene_bytes);
        let mut issues = unsound_issues(&self.scene, self.exercise.planned_needle(), source)?;
        issues.extend(self.place("document", &self.blocked_ways())?);
        Ok(issues)
    }

    /// The remark on a planned way that meets bone, if it does.
    fn blocked_ways(&self) -> Vec<Remark> {
        self.remark_blocked_way().into_iter().collect()
    }
}

fn unsound_issues(
    scene: &Scene,
    planned: PlannedNeedle,
    source: impl FnOnce() -> Result<Source, DocumentError>,
) -> Result<Vec<Issue>, DocumentError> {
    let findings = scene.soundness(planned);
    let misplaced = list_misplaced(scene);
    if misplaced.is_empty() && findings.as_ref().is_ok_and(Vec::is_empty) {
        return Ok(Vec::new());
    }
    // The scene stores no positions in its document; parse it again only if there is an issue to
    // place.
    let doc = Walked::new(source()?, &SCENE)?;
    let mut issues = match findings {
        Ok(findings) => findings.iter().map(|finding| document_issue(&doc, scene, finding)).collect(),
        Err(why) => {
            let allowed = phrase!(
                "allowed: a tissue for which a model meets the tolerance; with coupling = \"none\" the hand feels only \
                 the layers"
            );
            vec![doc.issue("tissue.coupling", why.in_words(), allowed)]
        }
    };
    issues.extend(misplaced.into_iter().map(|Remark { field, found, allowed }| doc.issue(&field, found, allowed)));
    Ok(issues)
}

fn document_issue(doc: &Walked, scene: &Scene, finding: &Finding) -> Issue {
    let Finding { patient, angle_deg, unsound } = finding;
    let Unsound { boundary, layer, threshold_n, force_rise_n, energy_rise_mj, largest_sound_n, .. } = unsound;
    let as_written = scene.layers.get(*boundary);
    let (key, contactor, written_n) = match unsound.contactor {
        Contactor::Tip => ("tip_rupture_n", phrase!("tip"), as_written.map(|l| l.tip_rupture_n)),
        Contactor::Rim => ("rim_rupture_n", phrase!("rim"), as_written.map(|l| l.rim_rupture_n)),
    };
    let written_n = written_n.filter(|written_n| *written_n > 0.0).unwrap_or(*threshold_n);
    let is_derived = as_written.is_some_and(|l| l.options.fracture_energy_j_per_m2.is_some());
    let key = if is_derived && unsound.contactor == Contactor::Tip { "fracture_energy_j_per_m2" } else { key };
    // The document gives reference values (needle and toughness). Round down, so that the limit
    // itself is sound.
    let limit_n = (largest_sound_n * written_n / threshold_n * 1e4).floor() / 1e4;
    let what = match scene.is_coupled() {
        true => phrase!("{written} N is unsound with the field's stiffnesses", written = written_n),
        false => phrase!("{written} N is unsound", written = written_n),
    };
    let found = phrase!(
        "{what}: when the {contactor} opens boundary {boundary} ({layer}) of the {patient} patient at \
         {angle}°, the force rises by {force_rise} N and the elastic energy by {energy_rise} mJ",
        what = what,
        contactor = contactor,
        boundary = *boundary,
        layer = layer.as_str(),
        patient = patient.clone(),
        angle = *angle_deg,
        force_rise = Phrase::number(*force_rise_n, 4),
        energy_rise = Phrase::number(*energy_rise_mj, 4)
    );
    let allowed = phrase!(
        "the largest sound threshold is {limit} N; alternatives: a stiffer boundary or a softer next layer",
        limit = limit_n
    );
    doc.issue(&format!("layer[{boundary}].{key}"), found, allowed)
}
