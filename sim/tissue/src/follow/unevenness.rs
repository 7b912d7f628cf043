//! The change of the responses by a curved skin and by inclusions in the layers.
//!
//! Flat layers are solved in (r, z) to any precision. Compared with that the change is small and
//! smooth: the solution with the curved skin and the inclusions, minus that without, both on the
//! same coarse mesh in three dimensions, whose own error mostly cancels. The change that a drag
//! causes at a boundary equals the change that a push at that boundary causes along the drag
//! (Betti).

use phrase::{Phrase, phrase};

use super::asked::AskedLoads;
use super::responses::Responses;
use super::spec::TissueSpec;
use crate::planner::{PlanError, cut_patch};
use crate::quadrature::gauss_rule;
use crate::volumetric::{Footprint, Grading, MeshSpec3, Problem3, Skin, VolumetricError, push_along_needle};
use crate::{Load, LoadKind, Problem, relative_distance};

/// A change and its assessment.
#[derive(Clone, Debug)]
pub(super) struct WeighedChange {
    /// Added to the responses of flat layers; `None` if it is too small.
    pub added: Option<Responses>,
    /// The largest change under a load of an attempt, relative to the load's displacement.
    largest: f64,
    /// Error of adding the change, or of omitting it, relative to the load's displacement.
    pub error: f64,
    /// Index in [`TissueSpec::loads`] of the load with the largest error.
    pub worst: Option<usize>,
    mesh: Phrase,
    /// Unknowns of the largest mesh.
    pub unknowns: usize,
    /// Maximum memory held at a time, in bytes.
    pub bytes: usize,
}

impl WeighedChange {
    /// The planner's reason for the choice of models.
    pub fn in_words(&self, why: &Phrase, level: &Phrase) -> Phrase {
        let (why, level, mesh) = (why.clone(), level.clone(), self.mesh.clone());
        let percent = Phrase::number(100.0 * self.largest, 1);
        match self.added {
            None => phrase!(
                "{why}; they show that no displacement changes by more than {percent} % ({mesh}), so flat layers \
                 suffice: {level}",
                why = why,
                percent = percent,
                mesh = mesh,
                level = level
            ),
            Some(_) => phrase!(
                "{why}; the change, up to {percent} %, is computed on {mesh} at the angle of the exercise and added to \
                 flat layers: {level}",
                why = why,
                percent = percent,
                mesh = mesh,
                level = level
            ),
        }
    }
}

/// Finds the change and decides whether to add it to the known responses of flat layers, for a
/// given tolerance.
///
/// # Errors
/// The first number for which no mesh can be made.
pub(super) fn weigh_change(
    asked: &AskedLoads,
    tissue: &TissueSpec,
    level: &Responses,
    tolerance: f64,
) -> Result<WeighedChange, PlanError> {
    let find = |rung: usize| {
        let change = find_change(&asked.question, &asked.loads, &RUNGS[rung])?;
        Ok::<_, PlanError>(FoundChange::new(change, asked, level))
    };
    let apart = |one: &Responses, other: &Responses| -> Vec<f64> {
        asked.places.iter().map(|place| relative_distance(&one.under(*place), &other.under(*place))).collect()
    };
    let within = |errors: &[f64]| errors.iter().all(|error| *error <= tolerance);
    let mut found = find(0)?;
    // As long as nothing else is known, the coarsest mesh may be wrong by all that it finds.
    let mut doubts = apart(level, &found.changed);
    let mut rungs = 1;
    let most = affordable(&asked.question)?;
    let off = match (is_pierced(&asked.question), asked.question.footprint, asked.question.skin) {
        (true, ..) => OFF_PIERCED,
        // Earlier recordings were judged alike under every skin.
        (false, Footprint::Bent, Skin::Sphere { .. } | Skin::Cylinder { .. }) => OFF_BENT,
        (false, ..) => OFF,
    };
    loop {
        let sizes = apart(level, &found.changed);
        let left_out: Vec<f64> = sizes.iter().zip(&doubts).map(|(size, doubt)| size + doubt).collect();
        if tissue.model.is_none() && within(&left_out) {
            return Ok(found.weigh(asked, &sizes, left_out, false));
        }
        if rungs == most || rungs > 1 && within(&doubts) {
            return Ok(found.weigh(asked, &sizes, doubts, true));
        }
        let finer = find(rungs)?;
        doubts = apart(&found.changed, &finer.changed).iter().map(|apart| off * apart).collect();
        (found, rungs) = (finer, rungs + 1);
    }
}

/// The number of affordable rungs: at least two, to have an error estimate.
fn affordable(question: &Problem3) -> Result<usize, PlanError> {
    let problem = around_pushes(question);
    let mut rungs = 2;
    while let Some(rung) = RUNGS.get(rungs) {
        if spec(&problem, rung).unknowns(&problem).map_err(VolumetricError::from)? > MOST_UNKNOWNS {
            break;
        }
        rungs += 1;
    }
    Ok(rungs)
}

/// Whether the needle passes through an inclusion on its way to the deepest push.
fn is_pierced(question: &Problem3) -> bool {
    const STEPS: u32 = 256;
    let deepest_m = question.flat.sample_depth_m.iter().copied().fold(0.0, f64::max);
    let mut places = (0..=STEPS).map(|step| question.on_needle(deepest_m * f64::from(step) / f64::from(STEPS)));
    places.any(|place| question.inclusions.iter().any(|inclusion| inclusion.shape.contains(&place)))
}

/// A change, and the responses of flat layers with it.
struct FoundChange {
    change: Change,
    responses: Responses,
    changed: Responses,
}

impl FoundChange {
    fn new(change: Change, asked: &AskedLoads, level: &Responses) -> Self {
        let responses = asked.responses(|load, sample| change.answers_m[load][sample]);
        let mut changed = level.clone();
        changed.add(1.0, &responses);
        Self { change, responses, changed }
    }

    fn weigh(self, asked: &AskedLoads, sizes: &[f64], errors: Vec<f64>, is_added: bool) -> WeighedChange {
        let worst = asked.worst(errors);
        WeighedChange {
            added: is_added.then_some(self.responses),
            largest: sizes.iter().copied().fold(0.0, f64::max),
            error: worst.map_or(0.0, |worst| worst.error),
            worst: worst.map(|worst| worst.place),
            mesh: self.change.mesh,
            unknowns: self.change.unknowns,
            bytes: self.change.bytes,
        }
    }
}

/// The change under each load of an attempt, on one mesh.
struct Change {
    /// Displacement along the needle at each sample under each load, in m/N.
    answers_m: Vec<Vec<f64>>,
    mesh: Phrase,
    unknowns: usize,
    bytes: usize,
}

/// A mesh for the change: order of its elements, their size at the needle in m, and its growth with
/// the distance, in m/m.
#[derive(Clone, Copy, Debug)]
struct Rung {
    order: usize,
    near_m: f64,
    growth: f64,
}

/// From coarse to fine. They grow slowly: the resolution of the inclusions counts, not that of the
/// needle.
const RUNGS: [Rung; 5] = [
    Rung { order: 2, near_m: 6e-3, growth: 0.5 },
    Rung { order: 2, near_m: 4e-3, growth: 0.4 },
    Rung { order: 2, near_m: 2.8e-3, growth: 0.3 },
    Rung { order: 3, near_m: 4.5e-3, growth: 0.4 },
    Rung { order: 3, near_m: 3e-3, growth: 0.35 },
];

/// Error of the finer of two meshes, in multiples of their difference: where an inclusion's face
/// lies within elements, the error falls little faster than with the first power of their size,
/// which decreases by a third from rung to rung.
const OFF: f64 = 2.0;
/// The same under a skin that bends, where the error of the flat layers that it is compared with counts, too.
const OFF_BENT: f64 = 3.0;
/// The same if the needle passes through an inclusion: the change there is neither small nor
/// smooth.
const OFF_PIERCED: f64 = 4.0;

/// A mesh with more unknowns takes seconds to factorise, and more than 64 MB.
const MOST_UNKNOWNS: usize = 10_500;

/// Radius of a patch, in m, and in multiples of the reach of an inclined needle; limited to a
/// multiple of the skin's radius.
const REACH_M: f64 = 0.08;
const BESIDE: f64 = 1.6;
const REACH: f64 = 1.2;
/// Maximum depth of a patch, in radii of the skin.
const DEEPEST: f64 = 0.9;

/// Points along a layer at which a drag's change is evaluated.
const POINTS: usize = 16;

/// The change under each load at each of the question's sample depths, on a mesh of the ladder. Of
/// the question's own load only the radius is used; every push is at a sample depth.
fn find_change(question: &Problem3, loads: &[Load], rung: &Rung) -> Result<Change, PlanError> {
    let samples_m = &question.flat.sample_depth_m;
    // The mesh is far coarser than the footprint, so that what it sees of a dent goes with the size of its elements. Elements and footprint
    // are squeezed alike where the skin bends, and so they are in the level tissue that each push is compared with.
    let uneven = Problem3 { footprint: Footprint::Flat, ..around_pushes(question) };
    let spec = spec(&uneven, rung);
    let stretches: Vec<Stretch> = loads.iter().map(Stretch::of).collect();
    let points_m: Vec<f64> = stretches.iter().flat_map(|stretch| stretch.points_m.iter().copied()).collect();
    let with = push_along_needle(&uneven, &spec, samples_m, &points_m)?;
    let without_m = match question.footprint {
        Footprint::Flat => push_along_needle(&level(&uneven, 1.0), &spec, samples_m, &points_m)?.answers_m,
        Footprint::Bent => {
            let push = |depth_m: &f64| {
                let scale = uneven.lateral_scale(*depth_m);
                let pushes = push_along_needle(&level(&uneven, scale), &spec.squeezed(scale), &[*depth_m], &points_m)?;
                Ok::<_, PlanError>(pushes.answers_m.concat())
            };
            samples_m.iter().map(push).collect::<Result<Vec<_>, _>>()?
        }
    };
    let changed_m = |sample: usize, point: usize| with.answers_m[sample][point] - without_m[sample][point];
    let mut first = 0;
    let mut of_load = |stretch: &Stretch| -> Vec<f64> {
        let from = first;
        first += stretch.points_m.len();
        let shares = || stretch.shares.iter().enumerate();
        let at = |sample: usize| shares().map(|(at, share)| share * changed_m(sample, from + at)).sum();
        (0..samples_m.len()).map(at).collect()
    };
    let answers_m = stretches.iter().map(&mut of_load).collect();
    let mesh = phrase!("{elements} hexahedra of order {order}", elements = with.elements, order = spec.order);
    Ok(Change { answers_m, mesh, unknowns: with.unknowns, bytes: with.bytes })
}

/// The same question about flat layers with nothing in them, whose lengths along the skin are so many times as long.
fn level(uneven: &Problem3, scale: f64) -> Problem3 {
    let mut level = Problem3 { skin: Skin::Flat, inclusions: Vec::new(), ..uneven.clone() };
    level.flat.load.radius_m *= scale;
    level.flat.slab.radius_m *= scale;
    level
}

/// Points of a needle over which a load is distributed, and its share at each.
struct Stretch {
    points_m: Vec<f64>,
    shares: Vec<f64>,
}

impl Stretch {
    fn of(load: &Load) -> Self {
        match load.kind {
            LoadKind::Contactor { depth_m } => Self { points_m: vec![depth_m], shares: vec![1.0] },
            LoadKind::Drag { from_m, to_m } => {
                let (points, weights): (Vec<f64>, Vec<f64>) = gauss_rule(POINTS).into_iter().unzip();
                let place = |x: &f64| 0.5 * ((from_m + to_m) + (to_m - from_m) * x);
                Self {
                    points_m: points.iter().map(place).collect(),
                    shares: weights.iter().map(|weight| 0.5 * weight).collect(),
                }
            }
        }
    }
}

/// The question for the tissue around the pushes.
fn around_pushes(question: &Problem3) -> Problem3 {
    let deepest_push_m = question.flat.sample_depth_m.iter().copied().fold(0.0, f64::max);
    let bend_m = question.skin.radius_m().unwrap_or(f64::INFINITY);
    let deepest = question.skin.flatten(&question.on_needle(deepest_push_m));
    let reach_m = REACH_M.max(BESIDE * libm::hypot(deepest.x, deepest.y)).min(REACH * bend_m);
    let deepest_m = deepest_push_m.min(DEEPEST * bend_m);
    let mut slab = cut_patch(&question.flat.slab.layers, deepest_m, reach_m.min(DEEPEST * bend_m - deepest_m));
    slab.radius_m = reach_m;
    let load = Load { kind: LoadKind::Drag { from_m: 0.0, to_m: deepest_push_m }, ..question.flat.load };
    let flat = Problem { slab, load, sample_r_m: Vec::new(), sample_depth_m: Vec::new() };
    Problem3 { flat, ..question.clone() }
}

fn spec(problem: &Problem3, rung: &Rung) -> MeshSpec3 {
    let grading = Grading { near_m: rung.near_m, growth: rung.growth };
    MeshSpec3 {
        symmetry: problem.symmetry(),
        order: rung.order,
        around: 1,
        across: grading,
        along: grading,
        reach_m: problem.flat.slab.radius_m,
    }
}
