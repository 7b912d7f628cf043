//! Scales a scene's numbers to its needle, tissue and patient.
//!
//! The tables hold for 2.0 mm diameter, diamond tip, lubrication 1 and toughness 1. For another
//! needle, stiffness, damping, stiffening and friction are proportional to the diameter, thresholds
//! and cutting to its power p; the tip is a factor on the thresholds and, from version 2 of the
//! scaling, on cutting, lubrication on friction, and toughness on thresholds, friction and cutting.

use law::axial::{AxialSpec, Breakaway, FibrousSheet, Layer, LayerOptions, RateDependence, tense_stiffness_n_per_m};
use law::beam::tube_n_m2;
use law::fracture::SharpPunch;
use law::puncture::PunctureSpec;
use tissue::SpecimenSpec;

use crate::model::{Needle, Scene, SceneFibres, SceneLayer, SceneLayerOptions};
use crate::patient::Patient;
use crate::planned::PlannedNeedle;
use crate::tip::{NeedleScaling, tip_factor};

/// Diameter for which the scenes' numbers hold, in mm.
const REFERENCE_DIAMETER_MM: f64 = 2.0;

/// Factors of a needle, each 1 at the reference needle.
struct Factors {
    /// On stiffness, damping and friction.
    diameter: f64,
    /// On thresholds and cutting.
    diameter_power: f64,
    /// On thresholds and, from version 2, on cutting.
    tip: f64,
    /// Version of the scaling.
    scaling: NeedleScaling,
    /// On friction.
    lubrication: f64,
    /// The needle's radius, in m; not a factor, but used by the mechanical formulas.
    radius_m: f64,
}

impl Factors {
    fn new(needle: &Needle, scaling: NeedleScaling) -> Self {
        let diameter = needle.diameter_mm / REFERENCE_DIAMETER_MM;
        Self {
            diameter,
            diameter_power: libm::pow(diameter, needle.diameter_exponent),
            // Reading a scene refuses a tip that its scaling does not have.
            tip: tip_factor(&needle.tip, scaling).unwrap_or(1.0),
            scaling,
            lubrication: needle.lubrication,
            radius_m: 0.5e-3 * needle.diameter_mm,
        }
    }

    fn layer(&self, layer: &SceneLayer, thickness_mm: f64) -> Layer {
        let threshold = self.diameter_power * self.tip * layer.toughness_factor;
        let friction = self.diameter * self.lubrication * layer.toughness_factor;
        let stiffness_n_per_m = layer.stiffness_n_per_m * self.diameter;
        let tense_n_per_m = self.pretension_n_per_m(layer);
        Layer {
            name: layer.name.clone(),
            thickness_m: thickness_mm / 1e3,
            stiffness_n_per_m: stiffness_n_per_m + tense_n_per_m,
            damping_n_s_per_m2: layer.damping_n_s_per_m2 * self.diameter,
            tip_rupture_n: self.torn_n(layer).unwrap_or(layer.tip_rupture_n * threshold),
            rim_rupture_n: layer.rim_rupture_n * threshold,
            friction_n_per_m: layer.friction_n_per_m * friction,
            cutting_n: self.cut_n(layer),
            options: LayerOptions {
                stiffening_n_per_m2: layer.options.stiffening_n_per_m2 * self.diameter,
                branches: layer.options.relaxation.clone(),
                gives_way_at: layer.options.gives_way_at,
                static_friction_n_per_m: layer.options.static_friction_n_per_m.map(|c| c * friction),
                sheet: layer.options.fibres.as_ref().map(|fibres| {
                    let angle_rad = fibres.angle_deg.to_radians();
                    // Pretension acts equally in all directions, so the edge does not change it.
                    let along_n_per_m = stiffness_n_per_m * fibres.along_stiffness + tense_n_per_m;
                    FibrousSheet {
                        fibres: [libm::cos(angle_rad), libm::sin(angle_rad)],
                        along_stiffness: along_n_per_m / (stiffness_n_per_m + tense_n_per_m),
                        along_threshold: fibres.along_threshold,
                    }
                }),
            },
        }
    }

    /// Returns the stiffness that a sheet's pretension adds to its boundary, in N/m; 0 for a layer
    /// without a sheet.
    fn pretension_n_per_m(&self, layer: &SceneLayer) -> f64 {
        let Some(SceneFibres { pretension_n_per_m, held_radius_mm, .. }) = layer.options.fibres else { return 0.0 };
        tense_stiffness_n_per_m(pretension_n_per_m, held_radius_mm / 1e3, self.radius_m)
    }

    /// Returns a sharp tip's threshold derived from the fracture energy, in N, if the layer gives
    /// one. The diameter enters through the mechanics, so neither its power nor the tip's factor
    /// applies.
    fn torn_n(&self, layer: &SceneLayer) -> Option<f64> {
        let (fracture, modulus_pa) = layer.options.fracture_energy_j_per_m2.zip(layer.youngs_modulus_pa)?;
        let shear_modulus_pa = modulus_pa / (2.0 * (1.0 + layer.poisson_ratio));
        let punch = SharpPunch { radius_m: self.radius_m, shear_modulus_pa, fracture_energy_j_per_m2: fracture };
        Some(punch.threshold_n() * layer.toughness_factor)
    }

    /// Returns the factor on a layer's cutting force.
    fn cutting(&self, layer: &SceneLayer) -> f64 {
        let tip = if self.scaling >= NeedleScaling::Version2 { self.tip } else { 1.0 };
        self.diameter_power * tip * layer.toughness_factor
    }

    /// Returns the cutting force, in N. From version 2 a layer with a fracture energy and no cutting
    /// force is cut with the force of the balance that gives its threshold: Shergold and Fleck derive
    /// it for a punch that advances steadily.
    fn cut_n(&self, layer: &SceneLayer) -> f64 {
        let is_derived = self.scaling >= NeedleScaling::Version2 && layer.cutting_n <= 0.0;
        let derived_n = if is_derived { self.torn_n(layer) } else { None };
        derived_n.unwrap_or_else(|| layer.cutting_n * self.cutting(layer))
    }

    /// Returns the layer for which [`Factors::layer`] yields `met`.
    fn undone(&self, written: &SceneLayer, met: &Layer) -> SceneLayer {
        let threshold = self.diameter_power * self.tip * written.toughness_factor;
        SceneLayer {
            thickness_mm: met.thickness_m * 1e3,
            stiffness_n_per_m: (met.stiffness_n_per_m - self.pretension_n_per_m(written)) / self.diameter,
            damping_n_s_per_m2: met.damping_n_s_per_m2 / self.diameter,
            tip_rupture_n: met.tip_rupture_n / threshold,
            rim_rupture_n: met.rim_rupture_n / threshold,
            friction_n_per_m: met.friction_n_per_m / (self.diameter * self.lubrication * written.toughness_factor),
            cutting_n: met.cutting_n / self.cutting(written),
            options: SceneLayerOptions {
                stiffening_n_per_m2: met.options.stiffening_n_per_m2 / self.diameter,
                relaxation: met.options.branches.clone(),
                static_friction_n_per_m: met
                    .options
                    .static_friction_n_per_m
                    .map(|c| c / (self.diameter * self.lubrication * written.toughness_factor)),
                ..written.options.clone()
            },
            ..written.clone()
        }
    }
}

impl Scene {
    /// Returns the scene's layers for which [`Scene::axial_spec`] yields `spec`: the inverse of the
    /// scaling. Properties that a specification does not contain (density, texture, spread, …) are
    /// unchanged.
    pub(crate) fn layers_of(&self, spec: &AxialSpec) -> Vec<SceneLayer> {
        let factors = Factors::new(&self.needle, self.scaling);
        self.layers.iter().zip(&spec.layers).map(|(written, met)| factors.undone(written, met)).collect()
    }
}

impl Needle {
    /// Returns when static friction ends; `None` if the needle gives no sliding distance.
    fn breakaway(&self) -> Option<Breakaway> {
        self.breakaway_mm.map(|slid_mm| Breakaway { slid_m: slid_mm / 1e3, rest_s: self.friction_rest_s })
    }

    /// Returns the bending stiffness EI of the shaft, in N·m²; `None` for a rigid shaft.
    fn bending_n_m2(&self) -> Option<f64> {
        let (outer_m, inner_m) = (self.diameter_mm / 1e3, self.inner_diameter_mm / 1e3);
        self.flexible.then(|| tube_n_m2(self.youngs_modulus_pa, outer_m, inner_m))
    }
}

impl Scene {
    /// Returns the specification for puncturing a patient, scaled for the needle and the tissue, in
    /// SI; its field is that of the planned needle.
    #[must_use]
    pub fn specimen_spec(&self, patient: &Patient, planned: impl Into<PlannedNeedle>) -> SpecimenSpec {
        let puncture = self.puncture_spec(patient);
        SpecimenSpec { tissue: self.tissue_under(&puncture.axial, &planned.into()), puncture }
    }

    /// Returns the law's part of the specification, with the scene's own stiffnesses.
    #[must_use]
    pub fn puncture_spec(&self, patient: &Patient) -> PunctureSpec {
        PunctureSpec {
            axial: self.axial_spec(patient),
            lateral_stiffness_n_per_m2: self.needle.lateral_stiffness_n_per_m2,
            needle_length_m: self.needle.length_mm / 1e3,
            hub_stiffness_n_per_m: self.needle.hub_stiffness_n_per_m,
            needle_bending_n_m2: self.needle.bending_n_m2(),
            skin: self.skin_shape,
            structures: self.structures.iter().map(|s| s.spec.clone()).collect(),
        }
    }

    /// Returns the axial law for a patient, with the scene's own stiffnesses.
    ///
    /// P∞ of a rate dependence is a threshold too: it is scaled for the needle, so that P/P∞ does
    /// not depend on it. A layer that is missing in `patient` has its nominal thickness.
    #[must_use]
    pub fn axial_spec(&self, patient: &Patient) -> AxialSpec {
        let factors = Factors::new(&self.needle, self.scaling);
        let thickness_mm =
            |at: usize, layer: &SceneLayer| patient.thickness_mm.get(at).copied().unwrap_or(layer.thickness_mm);
        let layers = self.layers.iter().enumerate().map(|(at, l)| factors.layer(l, thickness_mm(at, l))).collect();
        let rate = self.rate.map(|r| RateDependence {
            p_infinity_n: r.p_infinity_n * (factors.diameter_power * factors.tip),
            v0_m_per_s: r.v0_m_per_s,
        });
        AxialSpec {
            law: self.law,
            layers,
            tip_to_rim_m: self.needle.tip_to_rim_mm / 1e3,
            presliding_stiffness_n_per_m: self.needle.presliding_stiffness_n_per_m,
            speed_window_s: self.needle.speed_window_ms / 1e3,
            damping_time_s: self.needle.damping_time_ms / 1e3,
            rate,
            breakaway: self.needle.breakaway(),
        }
    }
}
