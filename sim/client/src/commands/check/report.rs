//! The report of `check` on a file, as text and as JSON.

use std::io::{self, Write};

use documents::ClassCounts;
use serde::Serialize;

use super::plan::ScenePlan;

/// The findings in one file.
#[derive(Serialize)]
pub struct FileReport {
    /// The file as given on the command line.
    pub file: String,
    /// Whether there are no findings.
    pub ok: bool,
    /// `scene`, `exercise`, `curriculum` or `instrument`; absent if rejected.
    pub kind: Option<&'static str>,
    /// The document's id; absent if rejected.
    pub id: Option<String>,
    /// All issues of the document, with line and column: reasons for the rejection, or changes that
    /// the author should make.
    pub issues: Vec<String>,
    /// Plans of the simulation: one per exercise, or one for a scene.
    pub plans: Vec<ScenePlan>,
}

impl FileReport {
    /// The report on a file that is not a valid document, or is unsound.
    pub fn refused(file: String, issues: Vec<String>) -> Self {
        Self { file, ok: false, kind: None, id: None, issues, plans: Vec::new() }
    }

    /// The report on a valid document, with changes that its author should make.
    pub fn read(file: String, kind: &'static str, id: &str, plans: Vec<ScenePlan>, issues: Vec<String>) -> Self {
        Self { file, ok: issues.is_empty(), kind: Some(kind), id: Some(id.to_owned()), issues, plans }
    }

    /// Writes the human-readable form.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let (Some(kind), Some(id)) = (self.kind, &self.id) else {
            return writeln!(out, "{}: invalid, {} to correct", self.file, self.issues.len());
        };
        match self.issues.len() {
            0 => writeln!(out, "{}: {kind} {id}: sound", self.file)?,
            found => writeln!(out, "{}: {kind} {id}: sound, {found} to change", self.file)?,
        }
        self.plans.iter().try_for_each(|plan| write_plan(plan, out))
    }
}

fn write_plan(plan: &ScenePlan, out: &mut dyn Write) -> io::Result<()> {
    match &plan.exercise {
        Some(exercise) => writeln!(out, "\n  exercise {exercise} in scene {}, at {}°", plan.scene, plan.angle_deg)?,
        None => writeln!(out, "\n  scene {}, at {}°", plan.scene, plan.angle_deg)?,
    }
    writeln!(
        out,
        "  {:36} {:>16} {:>10} {:>12} {:>10}",
        "layer", "thickness mm", "k N/m", "friction N/m", "cutting N"
    )?;
    for layer in &plan.layers {
        let thickness = match layer.thickness_spread_mm {
            0.0 => format!("{}", layer.thickness_mm),
            spread => format!("{} ± {spread}", layer.thickness_mm),
        };
        let (name, k) = (&layer.name, layer.stiffness_n_per_m);
        let (friction, cutting) = (layer.friction_n_per_m, layer.cutting_n);
        writeln!(out, "  {name:36} {thickness:>16} {k:>10.1} {friction:>12.2} {cutting:>10.3}")?;
    }
    let ClassCounts { measured, derived, choices } = plan.classes;
    writeln!(out, "  numbers of the layers: {measured} measured, {derived} derived, {choices} choices")?;
    writeln!(out, "  {:36} {:>16} {:>10} {:>12}", "rupture (nominal patient)", "tip at mm", "before N", "after N")?;
    for rupture in &plan.ruptures {
        let name = rupture.contactor.into_layer(&rupture.layer).to_string();
        let (x, before, after) = (rupture.x_mm, rupture.force_before_n, rupture.force_after_n);
        writeln!(out, "  {name:36} {x:>16.3} {before:>10.3} {after:>12.3}")?;
    }
    for needle in &plan.ruptures_hold_for {
        writeln!(out, "  ruptures of a needle: {needle}")?;
    }
    plan.tissue.write(out)
}
