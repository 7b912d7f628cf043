//! The loads of an attempt, as questions on the whole body.

use super::responses::{Responses, pose_question};
use super::spec::TissueSpec;
use crate::volumetric::Problem3;
use crate::{Load, LoadKind};

/// A load that an attempt puts on the tissue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AttemptLoad {
    /// A contactor at the boundary of this layer, from 0 at the skin.
    Push(usize),
    /// The shaft's drag along this layer.
    Drag(usize),
}

/// The loads of an attempt, as questions on the whole body.
pub(super) struct AskedLoads {
    /// The question common to all; its own load is a drag through the whole tissue.
    pub question: Problem3,
    /// The loads with a length.
    pub loads: Vec<Load>,
    /// Index of each load in [`TissueSpec::loads`].
    pub places: Vec<usize>,
    /// Layers of the force law.
    layers: usize,
    /// Index of the sample depth of each boundary.
    samples: Vec<usize>,
}

impl AskedLoads {
    pub fn of(tissue: &TissueSpec) -> Self {
        let every = tissue.loads().into_iter().enumerate();
        let (places, loads): (Vec<usize>, Vec<Load>) = every.filter_map(|(at, load)| Some((at, load?))).unzip();
        let through = LoadKind::Drag { from_m: 0.0, to_m: tissue.deepest_m() };
        let whole = Load { kind: through, radius_m: tissue.load_radius_m };
        let question = pose_question(tissue, whole, &tissue.points_m());
        let depths_m = &question.flat.sample_depth_m;
        let sample = |boundary_m: &f64| depths_m.iter().position(|depth_m| depth_m.total_cmp(boundary_m).is_eq());
        let samples = tissue.boundaries_m.iter().take(tissue.layers()).filter_map(sample).collect();
        Self { question, loads, places, layers: tissue.layers(), samples }
    }

    /// The load of an attempt at an index of [`TissueSpec::loads`].
    pub fn load_at(&self, place: usize) -> AttemptLoad {
        match place.checked_sub(self.layers) {
            None => AttemptLoad::Push(place),
            Some(layer) => AttemptLoad::Drag(layer),
        }
    }

    /// The load with the largest error and that error, given one error per load; `None` without
    /// loads.
    pub fn worst(&self, errors: impl IntoIterator<Item = f64>) -> Option<WorstLoad> {
        let each = self.places.iter().zip(errors).map(|(&place, error)| WorstLoad { place, error });
        each.reduce(|worst, next| if next.error > worst.error { next } else { worst })
    }

    /// The responses, from the displacement at each sample depth under each load, in m/N.
    pub fn responses(&self, answer_m: impl Fn(usize, usize) -> f64) -> Responses {
        let mut asked = vec![None; 2 * self.layers];
        for (load, &place) in self.places.iter().enumerate() {
            asked[place] = Some(load);
        }
        let answer_m = |point: usize, place: usize| Some(answer_m(asked[place]?, *self.samples.get(point)?));
        Responses::of_answers(self.layers, 2 * self.layers, |point, place| answer_m(point, place).unwrap_or(0.0))
    }
}

/// The load with the largest error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct WorstLoad {
    /// Index in [`TissueSpec::loads`].
    pub place: usize,
    /// The error.
    pub error: f64,
}
