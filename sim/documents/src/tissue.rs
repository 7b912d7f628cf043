//! Derives the tissue of the field from a scene.

use law::Skin;
use law::axial::AxialSpec;
use law::structures::Shape;
use nalgebra::Point3;
use tissue::follow::{Field, FollowError, TissueSpec, recoil_time_s};
use tissue::volumetric::{Inclusion, InclusionShape};
use tissue::{ElasticLayer, Judging, Model, Slab};

use crate::model::{Scene, SceneLayer, SceneStructure};
use crate::patient::Patient;
use crate::planned::PlannedNeedle;

/// Distance from the needle at which the body is fixed, in m. The field covers only tissue that the
/// needle moves.
const BODY_RADIUS_M: f64 = 0.25;

impl Scene {
    /// Returns a patient's tissue under a planned needle, in SI; `None` if the scene uses no model
    /// or no layer of the patient has a thickness.
    ///
    /// Young's modulus is that of a flat punch with the needle's footprint, E = k(1 − ν²)/(2a) with
    /// the needle's own k and a = D/2, unless the scene states it (physics section 4). Since k is
    /// proportional to D, E does not depend on the needle.
    #[must_use]
    pub fn tissue_spec(&self, patient: &Patient, planned: impl Into<PlannedNeedle>) -> Option<TissueSpec> {
        self.tissue_under(&self.axial_spec(patient), &planned.into())
    }

    /// Returns the tissue of layers that are already scaled for the needle.
    pub(crate) fn tissue_under(&self, axial: &AxialSpec, planned: &PlannedNeedle) -> Option<TissueSpec> {
        if self.tissue.model == "none" || axial.layers.iter().all(|layer| layer.thickness_m <= 0.0) {
            return None;
        }
        let load_radius_m = 0.5e-3 * self.needle.diameter_mm;
        let elastic = |(written, met): (&SceneLayer, &law::axial::Layer)| ElasticLayer {
            thickness_m: met.thickness_m,
            youngs_modulus_pa: written.youngs_modulus_pa.unwrap_or_else(|| {
                let nu = written.poisson_ratio;
                met.stiffness_n_per_m * (1.0 - nu * nu) / (2.0 * load_radius_m)
            }),
            poisson_ratio: written.poisson_ratio,
            density_kg_per_m3: written.density_kg_per_m3,
        };
        let layers: Vec<ElasticLayer> = self.layers.iter().zip(&axial.layers).map(elastic).collect();
        let recoil = |(written, layer): (&SceneLayer, &ElasticLayer)| {
            written.recoil_time_s.unwrap_or_else(|| recoil_time_s(layer, load_radius_m))
        };
        let recoil_time_s = self.layers.iter().zip(&layers).map(recoil).collect();
        let slab = Slab { layers, radius_m: BODY_RADIUS_M };
        Some(TissueSpec {
            boundaries_m: slab.boundaries_m(),
            slab: slab.solid(),
            load_radius_m,
            tilt_rad: planned.angle_deg.to_radians(),
            skin: self.skin_under(planned),
            inclusions: self.list_inclusions(planned),
            model: model(&self.tissue.model),
            tolerance: self.tissue.tolerance,
            judging: Judging::default(),
            coupled: self.is_coupled(),
            recoil_time_s,
        })
    }

    /// Returns a patient's axial law with the stiffnesses in use: the scene's, or those of the
    /// field if it is coupled, under a planned needle.
    ///
    /// # Errors
    /// If no model of a coupled tissue can be built.
    pub fn coupled_spec(&self, patient: &Patient, planned: impl Into<PlannedNeedle>) -> Result<AxialSpec, FollowError> {
        let mut axial = self.axial_spec(patient);
        if let Some(tissue) = self.tissue_under(&axial, &planned.into()).filter(|tissue| tissue.coupled) {
            Field::new(&tissue)?.couple(&mut axial);
        }
        Ok(axial)
    }

    /// Returns the skin in the frame of a planned entry, with x in the direction of the lean.
    fn skin_under(&self, planned: &PlannedNeedle) -> Skin {
        match (self.skin_shape, self.skin_shape.line()) {
            (Skin::Cylinder { radius_m, .. }, Some(line)) => {
                let frame = planned.frame(&self.skin_shape);
                Skin::Cylinder { radius_m, along_rad: libm::atan2(line.dot(&frame.side), line.dot(&frame.lean)) }
            }
            (skin, _) => skin,
        }
    }

    /// Returns the structures with a material of their own as inclusions, in the frame of a planned
    /// entry.
    fn list_inclusions(&self, planned: &PlannedNeedle) -> Vec<Inclusion> {
        let within = |place: Point3<f64>| planned.seen_from_entry_m(&self.skin_shape, &place);
        let inclusion = |structure: &SceneStructure| {
            let at_m = structure.spec.position_m;
            let shape = match structure.spec.shape {
                Shape::Sphere { radius_m } => InclusionShape::Sphere { centre_m: within(at_m), radius_m },
                Shape::Capsule { half_axis_m, radius_m } => InclusionShape::Capsule {
                    from_m: within(at_m - half_axis_m),
                    to_m: within(at_m + half_axis_m),
                    radius_m,
                },
                Shape::Box { .. } | Shape::Mesh { .. } => return None,
            };
            Some(Inclusion { shape, material: structure.elastic? })
        };
        self.structures.iter().filter_map(inclusion).collect()
    }

    /// Returns whether the field sets the stiffness of the boundaries.
    #[must_use]
    pub fn is_coupled(&self) -> bool {
        self.tissue.coupling == "field"
    }
}

/// Returns the model that a scene names; `None` if the planner chooses.
fn model(name: &str) -> Option<Model> {
    [Model::Axisymmetric, Model::MassSpring, Model::Volumetric].into_iter().find(|model| model.name() == name)
}
