//! Computes a scene's value for each figure and compares the two.

use documents::{NeedleFamily, Scene};
use law::puncture::{PunctureParams, PunctureSpec};
use phrase::sentence;

use crate::figures::{FIGURES, PublishedFigure, PublishedRange};
use crate::insertion::{
    ProbeInsertion, ProbeMoment, greatest_n, hold_at, insert_at, insert_to, insertion_speed_m_per_s, layers_alone,
};
use crate::quantity::MeasuredQuantity;

/// Duration of a hold, in s.
const HELD_S: f64 = 8.0;
/// Distance behind a boundary within which a loss of force is searched, in m.
const BEHIND_M: f64 = 5e-3;
/// Way over which a slope is taken in a scene without a calyx, in m.
pub(crate) const WAY_M: f64 = 90e-3;
/// Factors on friction of a dry and of a lubricated shaft.
const LUBRICATIONS: [f64; 2] = [1.5, 0.5];

/// The reason why a scene cannot be compared with a figure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Incomparable {
    /// The figure was measured with another family of needles.
    Family {
        /// The figure's family.
        measured: NeedleFamily,
        /// The scene's family; `None` if it states none.
        scene: Option<NeedleFamily>,
    },
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
    /// Within the accepted range.
    Inside,
    /// Below or above the accepted range.
    Outside,
    /// A single value was published, without a spread: only the ratio is given.
    SingleValue {
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
    /// Why the scene may be outside, if it may.
    pub excepted: Option<&'static str>,
}

/// A scene compared with every figure.
#[derive(Clone, Debug)]
pub struct SceneDossier {
    /// The scene's id.
    pub scene: String,
    /// The family of its needle.
    pub family: Option<NeedleFamily>,
    /// A line for each figure, in the order of [`FIGURES`](crate::FIGURES).
    pub lines: Vec<DossierLine>,
}

/// Compares each scene with every figure.
#[must_use]
pub fn make_dossiers(scenes: &[Scene]) -> Vec<SceneDossier> {
    let dossier = |scene: &Scene| SceneDossier {
        scene: scene.id.clone(),
        family: scene.needle.family,
        lines: compare_scene(scene),
    };
    scenes.iter().map(dossier).collect()
}

/// Returns how many comparisons with a published range are inside, and how many there are.
#[must_use]
pub fn count_inside(dossiers: &[SceneDossier]) -> [usize; 2] {
    let lines = || dossiers.iter().flat_map(|dossier| &dossier.lines);
    let inside = lines().filter(|line| line.agreement == Agreement::Inside).count();
    let outside = lines().filter(|line| line.agreement == Agreement::Outside).count();
    [inside, inside + outside]
}

/// Compares a scene with every figure, in the figures' order. Forces are those of the layers on a
/// needle inserted perpendicularly.
#[must_use]
pub fn compare_scene(scene: &Scene) -> Vec<DossierLine> {
    let probed = ProbedScene::new(scene);
    let line = |figure: &'static PublishedFigure| {
        let measured = probed.compare(figure);
        DossierLine {
            figure,
            value: measured.ok(),
            agreement: measured.map_or_else(Agreement::Incomparable, |value| judge(value, &figure.range)),
            fitted: figure.fitted.contains(&scene.id.as_str()),
            excepted: figure.excepted.iter().find(|(id, _)| *id == scene.id).map(|(_, why)| *why),
        }
    };
    FIGURES.iter().map(line).collect()
}

/// Returns a scene's value of each quantity, in the quantity's unit, or the reason why it has none.
#[must_use]
pub fn measure_scene(scene: &Scene, quantities: &[MeasuredQuantity]) -> Vec<Result<f64, Incomparable>> {
    let probed = ProbedScene::new(scene);
    quantities.iter().map(|quantity| probed.measure(quantity)).collect()
}

fn judge(value: f64, range: &PublishedRange) -> Agreement {
    let Some([low, high]) = range.accepted() else {
        return match *range {
            PublishedRange::Single(published) => Agreement::SingleValue { ratio: value / published },
            _ => Agreement::Incomparable(Incomparable::NoValues),
        };
    };
    if (low..=high).contains(&value) { Agreement::Inside } else { Agreement::Outside }
}

/// A scene and the insertion simulated in it.
struct ProbedScene<'a> {
    scene: &'a Scene,
    params: PunctureParams,
    speed_m_per_s: f64,
    insertion: ProbeInsertion,
}

impl<'a> ProbedScene<'a> {
    #[expect(clippy::expect_used, reason = "reading a scene checks what the law asks")]
    fn new(scene: &'a Scene) -> Self {
        let params = layers_alone(scene).expect("a scene that was read makes a law");
        let speed_m_per_s = insertion_speed_m_per_s(scene);
        Self { scene, insertion: insert_at(&params, speed_m_per_s), params, speed_m_per_s }
    }

    fn compare(&self, figure: &PublishedFigure) -> Result<f64, Incomparable> {
        let own = self.scene.needle.family;
        match figure.family {
            Some(measured) if own != Some(measured) => Err(Incomparable::Family { measured, scene: own }),
            _ => self.measure(&figure.quantity),
        }
    }

    fn measure(&self, quantity: &MeasuredQuantity) -> Result<f64, Incomparable> {
        let insertion = &self.insertion;
        match *quantity {
            MeasuredQuantity::PeakUntilThrough { layer } => {
                let through = insertion.through[self.boundary(layer)?].ok_or(Incomparable::NotReached(layer))?;
                Ok(greatest_n(&insertion.moments[..through]))
            }
            MeasuredQuantity::OpeningForce { layer } => self.opening_force_n(insertion, layer),
            MeasuredQuantity::PeakAround { layer } => self.peak_around_n(insertion, layer),
            MeasuredQuantity::HeldForce { layer } => self.held_n(layer),
            MeasuredQuantity::OpeningDepth { layer } => Ok(insertion.moments[self.opening(layer)?].x_m),
            MeasuredQuantity::Dent { layer } => {
                let top_m = self.top_m(self.boundary(layer)?);
                Ok(insertion.moments[self.opening(layer)?].x_m - top_m)
            }
            MeasuredQuantity::ForceAtOpening { layer } => Ok(self.loss(layer)?.before_n),
            MeasuredQuantity::LossBehind { layer } => self.loss(layer).map(|loss| loss.before_n - loss.left_n),
            MeasuredQuantity::RelativeLossBehind { layer } => {
                self.loss(layer).map(|loss| 1.0 - loss.left_n / loss.before_n)
            }
            MeasuredQuantity::WaySlope => Ok(slope_n_per_m(&self.whole_way(&self.params).moments)),
            MeasuredQuantity::LayerDepth { layer } => self.boundary(layer).map(|boundary| self.top_m(boundary)),
            MeasuredQuantity::Thickness { layer } => {
                self.boundary(layer).map(|boundary| self.scene.layers[boundary].thickness_mm / 1e3)
            }
            MeasuredQuantity::SpeedRatio { layer, slow_m_per_s, fast_m_per_s } => {
                let [slow_n, fast_n] = [slow_m_per_s, fast_m_per_s]
                    .map(|speed| self.peak_around_n(&insert_at(&self.params, speed), layer));
                Ok(fast_n? / slow_n?)
            }
            MeasuredQuantity::TipRatio { layer, tip } => self.tip_ratio(layer, tip),
            MeasuredQuantity::DryRatio => Ok(self.dry_ratio()),
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

    /// Returns the depth of a boundary in the undeformed tissue, in m.
    fn top_m(&self, boundary: usize) -> f64 {
        self.scene.layers[..boundary].iter().map(|layer| layer.thickness_mm / 1e3).sum()
    }

    fn opening(&self, layer: &'static str) -> Result<usize, Incomparable> {
        self.insertion.opened[self.boundary(layer)?].ok_or(Incomparable::NotReached(layer))
    }

    fn opening_force_n(&self, insertion: &ProbeInsertion, layer: &'static str) -> Result<f64, Incomparable> {
        let stretch = insertion.stretch(self.boundary(layer)?).ok_or(Incomparable::NotReached(layer))?;
        Ok(greatest_n(stretch))
    }

    fn peak_around_n(&self, insertion: &ProbeInsertion, layer: &'static str) -> Result<f64, Incomparable> {
        let boundary = self.boundary(layer)?;
        let below = Some(boundary + 1).filter(|below| *below < self.scene.layers.len());
        let stretch = insertion.between(boundary.checked_sub(1), below).ok_or(Incomparable::NotReached(layer))?;
        Ok(greatest_n(stretch))
    }

    fn held_n(&self, layer: &'static str) -> Result<f64, Incomparable> {
        let boundary = self.boundary(layer)?;
        let (top_m, thickness_m) = (self.top_m(boundary), self.scene.layers[boundary].thickness_mm / 1e3);
        let middle = (top_m + 0.25 * thickness_m)..(top_m + 0.75 * thickness_m);
        let within = self.insertion.moments.iter().filter(|moment| middle.contains(&moment.x_m));
        let mut forces_n: Vec<f64> = within.map(|moment| moment.force_n).collect();
        forces_n.sort_by(f64::total_cmp);
        forces_n.get(forces_n.len() / 2).copied().ok_or(Incomparable::NotReached(layer))
    }

    fn loss(&self, layer: &'static str) -> Result<ResistanceLoss, Incomparable> {
        let (before, after) = self.insertion.moments.split_at(self.opening(layer)?);
        let Some(last) = before.last() else { return Err(Incomparable::NotReached(layer)) };
        let near = after.iter().take_while(|moment| moment.x_m < last.x_m + BEHIND_M);
        let left_n = near.map(|moment| moment.force_n).fold(last.force_n, f64::min);
        Ok(ResistanceLoss { before_n: last.force_n, left_n })
    }

    /// Inserts over the whole way: to the calyx, or to 90 mm.
    fn whole_way(&self, params: &PunctureParams) -> ProbeInsertion {
        let end_m = self.boundary("calyx").map_or(WAY_M, |calyx| self.top_m(calyx));
        insert_to(params, self.speed_m_per_s, end_m)
    }

    fn dry_ratio(&self) -> f64 {
        let last_n = |lubrication: f64| {
            let mut scene = self.scene.clone();
            scene.needle.lubrication = lubrication;
            let way = self.whole_way(&params_of(&scene));
            way.moments.last().map_or(0.0, |moment| moment.force_n)
        };
        let [dry_n, lubricated_n] = LUBRICATIONS.map(last_n);
        dry_n / lubricated_n
    }

    fn tip_ratio(&self, layer: &'static str, tip: &'static str) -> Result<f64, Incomparable> {
        let peak_n = |tip: &str| {
            let mut scene = self.scene.clone();
            tip.clone_into(&mut scene.needle.tip);
            self.peak_around_n(&insert_at(&params_of(&scene), self.speed_m_per_s), layer)
        };
        Ok(peak_n(tip)? / peak_n("diamond")?)
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
            self.opening_force_n(&insert_at(&params, self.speed_m_per_s), layer)
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

#[expect(clippy::expect_used, reason = "reading a scene checks what the law asks; another tip or lubricant keeps it")]
fn params_of(scene: &Scene) -> PunctureParams {
    layers_alone(scene).expect("a scene that was read makes a law")
}

/// Force just before a boundary opens, and the least behind it, in N.
struct ResistanceLoss {
    before_n: f64,
    left_n: f64,
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
