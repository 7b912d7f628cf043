//! Computes a scene's value for each figure and compares the two.

use documents::Scene;
use law::puncture::{PunctureParams, PunctureSpec};
use phrase::sentence;

use crate::figures::{FIGURES, MeasuredQuantity, PublishedFigure, PublishedRange};
use crate::insertion::{ProbeInsertion, ProbeMoment, greatest_n, hold_at, insert_at, layers_alone};

/// Insertion speed, in m/s.
const SPEED_M_PER_S: f64 = 5e-3;
/// Duration of a hold, in s.
const HELD_S: f64 = 8.0;
/// Distance behind a boundary within which a loss of force is searched, in m.
const BEHIND_M: f64 = 5e-3;

/// Smallest relative increase that a test can detect (choice): two standard errors of 40 specimens
/// whose forces have a relative standard deviation of one sixth.
pub(crate) const TOLD_APART: f64 = 0.05;

/// The reason why a scene cannot be compared with a figure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Incomparable {
    /// The scene has no such layer.
    NoLayer(&'static str),
    /// The needle did not get far enough: a boundary of this layer did not open.
    NotReached(&'static str),
    /// The publication contains no values.
    NoValues,
    /// The figure measures something else; the reason, as a sentence.
    Stated(&'static str),
}

/// The result of comparing a scene with a figure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Agreement {
    /// Within the published range.
    Inside,
    /// Below or above the published range.
    Outside,
    /// A single value was published, without a spread: only the ratio is given.
    Beside {
        /// The scene's value divided by the published value.
        ratio: f64,
    },
    /// Not comparable.
    Incomparable(Incomparable),
}

/// A scene compared with a figure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DossierLine {
    /// The figure.
    pub figure: &'static PublishedFigure,
    /// The scene's value, in the figure's unit.
    pub value: Option<f64>,
    /// The result of the comparison.
    pub agreement: Agreement,
    /// Whether the scene was fitted to this figure.
    pub fitted: bool,
}

/// A scene compared with every figure.
#[derive(Clone, Debug)]
pub struct SceneDossier {
    /// The scene's id.
    pub scene: String,
    /// A line for each figure, in the order of [`FIGURES`](crate::FIGURES).
    pub lines: Vec<DossierLine>,
}

/// Compares each scene with every figure.
#[must_use]
pub fn make_dossiers(scenes: &[Scene]) -> Vec<SceneDossier> {
    scenes.iter().map(|scene| SceneDossier { scene: scene.id.clone(), lines: compare_scene(scene) }).collect()
}

/// Compares a scene with every figure, in the figures' order. Forces are those of the layers on a
/// needle inserted perpendicularly.
///
/// # Panics
/// Never for a scene that was read: reading checks the law's requirements.
#[must_use]
#[expect(clippy::expect_used, reason = "reading a scene checks what the law asks")]
pub fn compare_scene(scene: &Scene) -> Vec<DossierLine> {
    let params = layers_alone(scene).expect("a scene that was read makes a law");
    let probed = ProbedScene { scene, insertion: insert_at(&params, SPEED_M_PER_S), params };
    let line = |figure: &'static PublishedFigure| {
        let measured = probed.measure(&figure.quantity);
        DossierLine {
            figure,
            value: measured.ok(),
            agreement: measured.map_or_else(Agreement::Incomparable, |value| judge(value, &figure.range)),
            fitted: figure.fitted.contains(&scene.id.as_str()),
        }
    };
    FIGURES.iter().map(line).collect()
}

fn judge(value: f64, range: &PublishedRange) -> Agreement {
    let inside = match *range {
        PublishedRange::Between { low, high } => (low..=high).contains(&value),
        PublishedRange::Above(low) => value > low,
        PublishedRange::ToldApart(low) => value > low * (1.0 + TOLD_APART),
        PublishedRange::Single(published) => return Agreement::Beside { ratio: value / published },
        PublishedRange::Unstated => return Agreement::Incomparable(Incomparable::NoValues),
    };
    if inside { Agreement::Inside } else { Agreement::Outside }
}

/// A scene and the insertion simulated in it.
struct ProbedScene<'a> {
    scene: &'a Scene,
    params: PunctureParams,
    insertion: ProbeInsertion,
}

impl ProbedScene<'_> {
    fn measure(&self, quantity: &MeasuredQuantity) -> Result<f64, Incomparable> {
        let insertion = &self.insertion;
        match *quantity {
            MeasuredQuantity::OpeningForce { layer } => self.opening_force_n(insertion, layer),
            MeasuredQuantity::OpeningDepth { layer } => {
                let opened = self.opening(insertion, layer)?;
                Ok(insertion.moments[opened].x_m)
            }
            MeasuredQuantity::PeakUntil { layer } => {
                let opened = self.opening(insertion, layer)?;
                Ok(greatest_n(&insertion.moments[..opened]))
            }
            MeasuredQuantity::LossBehind { layer } => {
                let opened = self.opening(insertion, layer)?;
                let (before, after) = insertion.moments.split_at(opened);
                let Some(last) = before.last() else { return Err(Incomparable::NotReached(layer)) };
                let near = after.iter().take_while(|moment| moment.x_m < last.x_m + BEHIND_M);
                Ok(last.force_n - near.map(|moment| moment.force_n).fold(last.force_n, f64::min))
            }
            MeasuredQuantity::OverallSlope => Ok(slope_n_per_m(&insertion.moments)),
            MeasuredQuantity::SpeedRatio { layer, slow_m_per_s, fast_m_per_s } => {
                let [slow_n, fast_n] = [slow_m_per_s, fast_m_per_s]
                    .map(|speed| self.opening_force_n(&insert_at(&self.params, speed), layer));
                Ok(fast_n? / slow_n?)
            }
            MeasuredQuantity::TearingShare => Ok(self.shares().tearing),
            MeasuredQuantity::SpreadingShare => Ok(self.shares().spreading),
            MeasuredQuantity::FrictionShare => Ok(self.shares().friction),
            MeasuredQuantity::HeldFall { layer, speed_m_per_s, depth_m } => {
                self.boundary(layer)?;
                Ok(hold_at(&self.params, speed_m_per_s, depth_m, HELD_S))
            }
            MeasuredQuantity::EdgeRatio { layer } => self.edge_ratio(layer),
            MeasuredQuantity::OfNoScene { why, .. } => Err(Incomparable::Stated(why)),
        }
    }

    fn boundary(&self, layer: &'static str) -> Result<usize, Incomparable> {
        self.scene.layers.iter().position(|own| own.name == layer).ok_or(Incomparable::NoLayer(layer))
    }

    fn opening(&self, insertion: &ProbeInsertion, layer: &'static str) -> Result<usize, Incomparable> {
        insertion.opened[self.boundary(layer)?].ok_or(Incomparable::NotReached(layer))
    }

    fn opening_force_n(&self, insertion: &ProbeInsertion, layer: &'static str) -> Result<f64, Incomparable> {
        let stretch = insertion.stretch(self.boundary(layer)?).ok_or(Incomparable::NotReached(layer))?;
        Ok(greatest_n(stretch))
    }

    #[expect(clippy::expect_used, reason = "a sheet under an edge is a layer whose numbers were checked")]
    fn edge_ratio(&self, layer: &'static str) -> Result<f64, Incomparable> {
        let spec = self.params.spec();
        let Some(sheet) = spec.axial.layers[self.boundary(layer)?].options.sheet else {
            return Err(Incomparable::Stated(sentence!("the scene gives this layer no fibres")));
        };
        let [along_x, along_y] = sheet.fibres;
        let [along_n, across_n] = [[along_x, along_y], [-along_y, along_x]].map(|edge| {
            let turned = PunctureSpec { axial: spec.axial.under_edge(edge), ..spec.clone() };
            let params = PunctureParams::new(turned).expect("a sheet under an edge is a layer");
            self.opening_force_n(&insert_at(&params, SPEED_M_PER_S), layer)
        });
        Ok(across_n? / along_n?)
    }

    fn shares(&self) -> WorkShares {
        let ledger = &self.insertion.ledger;
        let sum = |part: fn(&law::ledger::LayerEnergy) -> f64| ledger.layers.iter().map(part).sum::<f64>();
        let tearing = sum(|layer| layer.rupture_j + layer.cutting_j);
        let spreading = sum(|layer| layer.viscous_j + layer.elastic_j);
        let friction = sum(|layer| layer.friction_j) + ledger.presliding_j;
        let whole = tearing + spreading + friction;
        WorkShares { tearing: tearing / whole, spreading: spreading / whole, friction: friction / whole }
    }
}

/// Shares of the work of an insertion; their sum is 1.
struct WorkShares {
    tearing: f64,
    spreading: f64,
    friction: f64,
}

/// Returns the slope of the least-squares line through force against displacement, in N/m.
fn slope_n_per_m(moments: &[ProbeMoment]) -> f64 {
    let count = moments.len() as f64;
    let mean = |of: fn(&ProbeMoment) -> f64| moments.iter().map(of).sum::<f64>() / count;
    let (mean_m, mean_n) = (mean(|moment| moment.x_m), mean(|moment| moment.force_n));
    let (across, along) = moments.iter().fold((0.0, 0.0), |(across, along), moment| {
        let from_m = moment.x_m - mean_m;
        (across + from_m * (moment.force_n - mean_n), along + from_m * from_m)
    });
    across / along
}
