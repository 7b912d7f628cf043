//! The plan of a scene's deforming tissue: the model, its size, its error and its cost.

use std::io::{self, Write};

use bench::timing::{self, TimingEffort};
use documents::{Patient, PlannedNeedle, Scene};
use serde::Serialize;
use tissue::Model;
use tissue::follow::{AttemptLoad, Field, FieldPlan, FollowError};

/// The plan of a scene's tissue. All zero without tissue.
#[derive(Serialize)]
pub struct TissuePlan {
    /// The tissue model.
    model: &'static str,
    /// Reason for the choice of the model.
    reason: String,
    /// Radius of the modelled tissue around the needle, in mm.
    radius_mm: f64,
    /// Unknowns of the largest model of all loads.
    unknowns: usize,
    /// Maximum memory held at a time, in bytes.
    bytes: usize,
    /// Expected relative error of the displacement along the needle at the boundaries, compared
    /// with the whole body, under the worst load of an attempt.
    expected_relative_error: f64,
    /// The worst load: `push on fat` or `drag along fat`. Empty without tissue.
    worst_load: String,
    /// The tolerance of the scene.
    tolerance: f64,
    /// Whether the expected error meets it.
    met: bool,
    /// Time to prepare an attempt, in s.
    setup_s: f64,
    /// Time of one step of the field, for all boundaries, in s.
    step_s: f64,
}

impl TissuePlan {
    /// Computes the field of the nominal patient under a planned needle.
    ///
    /// # Errors
    /// If no model of the tissue can be made.
    pub fn new(scene: &Scene, planned: PlannedNeedle) -> Result<Self, FollowError> {
        let Some(tissue) = scene.tissue_spec(&Patient::nominal(scene), planned) else { return Ok(Self::none(scene)) };
        let (field, setup_s) = timing::once(|| Field::new(&tissue));
        let field = field?;
        let radius_mm = field.reach_m()? * 1e3;
        let FieldPlan { model, reason, unknowns, bytes, expected_relative_error, worst } = field.plan().clone();
        Ok(Self {
            model: model.name(),
            reason: reason.to_string(),
            radius_mm,
            unknowns,
            bytes,
            expected_relative_error,
            worst_load: worst.map_or_else(String::new, |load| name(scene, load)),
            tolerance: tissue.tolerance,
            met: expected_relative_error <= tissue.tolerance,
            setup_s,
            step_s: step_s(&field),
        })
    }

    fn none(scene: &Scene) -> Self {
        Self {
            model: Model::None.name(),
            reason: "the force law alone; the scene names no model of the tissue".to_owned(),
            radius_mm: 0.0,
            unknowns: 0,
            bytes: 0,
            expected_relative_error: 0.0,
            worst_load: String::new(),
            met: true,
            tolerance: scene.tissue.tolerance,
            setup_s: 0.0,
            step_s: 0.0,
        }
    }

    /// Writes the human-readable form.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        writeln!(out, "  model {}: {}", self.model, self.reason)?;
        if self.unknowns == 0 {
            return Ok(());
        }
        let (megabytes, error) = (self.bytes as f64 / 1e6, 1e2 * self.expected_relative_error);
        let (setup_ms, step_ns) = (self.setup_s * 1e3, self.step_s * 1e9);
        writeln!(
            out,
            "  {} unknowns within {:.0} mm, {megabytes:.2} MB, expected error {error:.1} % of {} %, worst under the {}; set-up \
             {setup_ms:.0} ms, a step {step_ns:.0} ns",
            self.unknowns,
            self.radius_mm,
            1e2 * self.tolerance,
            self.worst_load
        )
    }

    /// A warning if the scene's tolerance is not met.
    pub fn warning(&self) -> Option<String> {
        let Self { tolerance, expected_relative_error, worst_load, .. } = self;
        (!self.met).then(|| {
            format!(
                "[tissue] tolerance = {tolerance} is not met: the expected error under the {worst_load} is {expected_relative_error:.2e}"
            )
        })
    }
}

/// Name of a load, with the scene's layer names.
fn name(scene: &Scene, load: AttemptLoad) -> String {
    let layer = |at: usize| scene.layers.get(at).map_or("", |layer| layer.name.as_str());
    match load {
        AttemptLoad::Push(boundary) => format!("push on {}", layer(boundary)),
        AttemptLoad::Drag(at) => format!("drag along {}", layer(at)),
    }
}

/// Median time of the tents of all boundaries under loads everywhere, in s.
fn step_s(field: &Field) -> f64 {
    let boundaries = field.planned().stiffnesses_n_per_m().len();
    let loads_n = vec![1.0; 2 * boundaries];
    timing::median_s(TimingEffort::SHORT, || {
        for boundary in 0..boundaries {
            std::hint::black_box(field.planned().axial_m(boundary, std::hint::black_box(&loads_n)));
        }
    })
}
