//! Mechanical properties of tissues: one table for all scenes built from shapes, in each version of
//! the scaling, and lowering of thresholds until they are sound.

use law::axial::{Contactor, MaxwellBranch};
use tissue::follow::FollowError;

use crate::model::Scene;
use crate::planned::PlannedNeedle;
use crate::tip::NeedleScaling;

/// Mechanical properties of a tissue, for the reference needle like all numbers of a layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TissueFeel {
    /// The tissue's name in documents.
    pub tissue: &'static str,
    /// Stiffness of its upper boundary, in N/m.
    pub stiffness_n_per_m: f64,
    /// κ of an upper boundary that stiffens with its dent, in N/m².
    pub stiffening_n_per_m2: f64,
    /// Damping per inserted length, in N·s/m².
    pub damping_n_s_per_m2: f64,
    /// Force at which the tip opens the upper boundary, in N.
    pub tip_n: f64,
    /// Force at which a cannula's rim opens the upper boundary, in N.
    pub rim_n: f64,
    /// Friction per inserted length, in N/m.
    pub friction_n_per_m: f64,
    /// Cutting force, in N.
    pub cutting_n: f64,
    /// Density, in kg/m³.
    pub density_kg_per_m3: f64,
    /// A branch that relaxes, in parallel to the upper boundary, which then ruptures at a fixed
    /// indentation; absent without measurements.
    pub branch: Option<MaxwellBranch>,
    /// Texture in the picture.
    pub texture: &'static str,
    /// Source of the numbers.
    pub source: &'static str,
    /// Keys of the numbers that are derived from a measurement; the others are choices.
    pub derived: &'static [&'static str],
}

const TRAINING: &str = "As in lower-back-training: stiffness from the paper's Table I, all else our choice for training; density from the literature.";
const CHOICE: &str = "Our choice for training, between that scene's fascia and muscle in stiffness.";
const EPIDURAL: &str = "Thresholds, damping, friction and cutting as in epidural-71kg, which is fitted to a profile of the literature. Stiffness: our choice, higher \
                        than fitted there, for the layers of a body lie where they are and have no room for tents of a centimetre.";
const FLAVUM: &str = "Damping, friction and cutting as in epidural-71kg; threshold and stiffness (our choice, higher than fitted there) 1/1.19 of what they would be \
                      without the branch, which makes up for it at 1.5 mm/s. That its peak grows with speed: porcine spines, Naemura and Saito 2009, without figures; \
                      the branch is our choice.";
const SAC: &str = "Stiffness and threshold of the dura as in epidural-71kg, which are our choice; what lies in the sac gives next to nothing.";

const KIDNEY: &str = "The muscle of lower-back-training, for want of a measured kidney.";

const RENAL_SKIN: &str = "Thresholds: forces of percutaneous renal access into fresh cadavers, 2.75 to 2.80 N for an 18G trocar (10.1089/end.2016.0342), divided by its \
                          diameter; 6.04 N under a Tuohy needle of 16G follow by the tip's factor. Stiffness and the rest: our choice.";
const RENAL_WAY: &str = "Friction: from the slope of force over depth, 35 to 59 N/m for an 18G trocar (10.1089/end.2016.0342), divided by its diameter. The rest: our \
                         choice; no force of its own is published for it.";
const PROFILE: &str = "Cutting: from a model of a patient of 71.1 kg in a public epidural simulator (needle and number of people unknown), divided by a Tuohy needle's \
                       diameter and tip. Friction, thresholds and stiffness: our choice; resistance is cutting, so that it is held until the layer ends.";
const LOWER_FACE: &str = "The lower face of the ligamentum flavum, where resistance is lost. That its force grows with speed: porcine spines, Naemura and Saito 2009 \
                          (10.1007/978-3-642-03906-5_9), without figures; threshold, stiffness and branch: our choice.";
const DURA: &str = "Threshold: our choice, within the largest force drops of fine spinal needles through porcine dura, at most 2.1 N (10.1371/journal.pone.0247346). \
                    Stiffness: our choice, for a dent of 2 to 6 mm.";
const CAPSULE: &str = "Our choice, of the order of an 18G needle's ruptures of organs, 1.4 to 2.3 N; nobody has published a force at a human kidney.";
const UNMEASURED: &str = "Our choice; no force is published for it.";

/// The tissues of version 2 of the scaling: what an 18G trocar or a Tuohy needle meets in published
/// measurements, divided by the needle's diameter and tip.
const MEASURED_FEELS: [TissueFeel; 15] = [
    TissueFeel {
        stiffening_n_per_m2: 60_000.0,
        ..derived(
            feel("skin", "skin", RENAL_SKIN, [150.0, 300.0, 3.31, 3.65, 94.0, 0.31, 1090.0]),
            &["tip_rupture_n", "rim_rupture_n"],
        )
    },
    derived(feel("fat", "fat", RENAL_WAY, [120.0, 100.0, 0.16, 0.19, 39.0, 0.16, 950.0]), &["friction_n_per_m"]),
    feel("fascia", "fascia", UNMEASURED, [1102.0, 300.0, 2.36, 2.83, 94.0, 0.47, 1130.0]),
    derived(feel("muscle", "muscle", RENAL_WAY, [394.0, 300.0, 1.42, 1.73, 98.0, 0.55, 1050.0]), &["friction_n_per_m"]),
    feel("ligament", "fascia", UNMEASURED, [1100.0, 300.0, 1.8, 2.3, 60.0, 1.5, 1120.0]),
    derived(
        feel("supraspinous ligament", "fascia", PROFILE, [2362.0, 300.0, 0.86, 1.1, 24.0, 2.43, 1130.0]),
        &["cutting_n"],
    ),
    derived(
        feel("interspinous ligament", "fascia", PROFILE, [2362.0, 300.0, 0.43, 0.55, 24.0, 4.72, 1130.0]),
        &["cutting_n"],
    ),
    derived(
        feel("ligamentum flavum", "fascia", PROFILE, [2362.0, 300.0, 0.43, 0.55, 24.0, 5.4, 1130.0]),
        &["cutting_n"],
    ),
    relaxing(
        feel("epidural space", "fat", LOWER_FACE, [3150.0, 100.0, 1.3, 1.6, 3.0, 0.0, 950.0]),
        MaxwellBranch { share: 0.8, time_s: 0.8 },
    ),
    feel("dura", "fascia", DURA, [1100.0, 100.0, 2.2, 2.8, 1.0, 0.05, 1130.0]),
    feel("cerebrospinal fluid", "fluid", UNMEASURED, [100.0, 20.0, 0.1, 0.12, 1.0, 0.0, 1010.0]),
    feel("anterior epidural space", "fat", UNMEASURED, [120.0, 100.0, 0.16, 0.19, 3.0, 0.05, 950.0]),
    feel("kidney", "muscle", CAPSULE, [394.0, 300.0, 1.57, 2.05, 63.0, 0.47, 1050.0]),
    feel("calyx", "fluid", UNMEASURED, [630.0, 20.0, 0.47, 0.6, 10.0, 0.0, 1010.0]),
    feel("introducer", "tissue", INTRODUCER, [1.0, 0.0, 0.0, 0.0, 2.0, 0.0, 1050.0]),
];

const INTRODUCER: &str =
    "An introducer that is already in place: the needle slides in metal. Its friction: our choice.";

const fn derived(feel: TissueFeel, keys: &'static [&'static str]) -> TissueFeel {
    TissueFeel { derived: keys, ..feel }
}

/// The tissues of version 1 of the scaling: fat and muscle of the training scene as it was; then the
/// tissues on the path to the epidural space.
const FEELS: [TissueFeel; 11] = [
    feel("fat", "fat", TRAINING, [83.0, 100.0, 0.5, 0.6, 15.0, 0.1, 950.0]),
    feel("muscle", "muscle", TRAINING, [497.0, 300.0, 1.5, 1.9, 40.0, 0.3, 1050.0]),
    feel("ligament", "fascia", CHOICE, [650.0, 300.0, 1.8, 2.3, 60.0, 0.4, 1120.0]),
    feel("skin", "skin", EPIDURAL, [900.0, 300.0, 8.9, 11.1, 30.0, 0.1, 1090.0]),
    feel("supraspinous ligament", "fascia", EPIDURAL, [1700.0, 300.0, 6.15, 7.7, 25.0, 0.1, 1130.0]),
    feel("interspinous ligament", "fascia", EPIDURAL, [3000.0, 300.0, 10.9, 13.6, 25.0, 0.1, 1130.0]),
    relaxing(
        feel("ligamentum flavum", "fascia", FLAVUM, [3360.0, 300.0, 14.2, 17.7, 30.0, 0.1, 1130.0]),
        MaxwellBranch { share: 0.6, time_s: 0.8 },
    ),
    feel("epidural space", "fat", EPIDURAL, [4000.0, 100.0, 13.6, 17.0, 2.0, 0.0, 950.0]),
    feel("dura", "fascia", SAC, [4000.0, 100.0, 3.68, 4.6, 1.0, 0.05, 1130.0]),
    feel("cerebrospinal fluid", "fluid", SAC, [100.0, 20.0, 0.1, 0.12, 1.0, 0.0, 1010.0]),
    feel("kidney", "muscle", KIDNEY, [497.0, 300.0, 1.5, 1.9, 40.0, 0.3, 1050.0]),
];

const fn feel(tissue: &'static str, texture: &'static str, source: &'static str, numbers: [f64; 7]) -> TissueFeel {
    let [stiffness_n_per_m, damping_n_s_per_m2, tip_n, rim_n, friction_n_per_m, cutting_n, density_kg_per_m3] = numbers;
    TissueFeel {
        tissue,
        stiffness_n_per_m,
        stiffening_n_per_m2: 0.0,
        damping_n_s_per_m2,
        tip_n,
        rim_n,
        friction_n_per_m,
        cutting_n,
        density_kg_per_m3,
        branch: None,
        texture,
        source,
        derived: &[],
    }
}

const fn relaxing(feel: TissueFeel, branch: MaxwellBranch) -> TissueFeel {
    TissueFeel { branch: Some(branch), ..feel }
}

impl TissueFeel {
    /// Returns the properties of a tissue in a version of the scaling; those of muscle if the name
    /// is unknown.
    #[must_use]
    pub fn of(tissue: &str, scaling: NeedleScaling) -> &'static Self {
        let feels: &'static [Self] = match scaling {
            NeedleScaling::Version1 => &FEELS,
            NeedleScaling::Version2 => &MEASURED_FEELS,
        };
        let find = |name: &str| feels.iter().find(|feel| feel.tissue == name);
        find(tissue).or_else(|| find("muscle")).unwrap_or(&feels[0])
    }
}

/// Maximum number of thresholds lowered before giving up.
const MOST_ROUNDS: usize = 128;

impl Scene {
    /// Lowers each threshold whose rupture would release more than it takes to the largest sound
    /// value, for a needle inserted as planned. Returns whether all are sound in the end.
    ///
    /// # Errors
    /// If no model of a coupled tissue can be built.
    pub fn lower_to_sound(&mut self, planned: impl Into<PlannedNeedle>) -> Result<bool, FollowError> {
        let planned = planned.into();
        for _ in 0..MOST_ROUNDS {
            let findings = self.soundness(planned)?;
            let Some(finding) = findings.first() else { return Ok(true) };
            let unsound = &finding.unsound;
            let layer = &mut self.layers[unsound.boundary];
            let written = match unsound.contactor {
                Contactor::Tip => &mut layer.tip_rupture_n,
                Contactor::Rim => &mut layer.rim_rupture_n,
            };
            // The finding refers to the scene's needle, the document to the reference needle.
            let sound_n = (unsound.largest_sound_n * *written / unsound.threshold_n * 1e3).floor() / 1e3;
            *written = sound_n.min(*written - 1e-3).max(1e-3);
        }
        Ok(false)
    }
}
