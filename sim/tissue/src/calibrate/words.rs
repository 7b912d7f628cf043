//! Descriptions of the parameters that a curve cannot determine.

use law::axial::AxialSpec;

use super::model::{CurveModel, Guess, QUANTITIES, Quantity};
use super::timed::TimedCurve;
use super::uncertainty::{ParameterEstimate, ParameterStanding};

/// One line per reason, with the names of the parameters that it applies to.
pub(super) fn in_words(
    model: &CurveModel<'_>,
    guess: &Guess,
    estimates: &[ParameterEstimate],
    readings: usize,
    unseen: &[usize],
) -> Vec<String> {
    let mut words: Vec<String> =
        QUANTITIES.into_iter().filter_map(|quantity| kept(&guess.spec, estimates, quantity)).collect();
    let open: Vec<&ParameterEstimate> = estimates.iter().filter(is_open).collect();
    if !unseen.is_empty() {
        words.push(unseen_in_words(&guess.spec, unseen));
    } else if !open.is_empty() {
        let why = no_withdrawal(model, &open);
        words.push(format!(
            "{}: not determined to within their own size, individually or jointly{why}",
            names(&guess.spec, &open)
        ));
    }
    if readings > 0 {
        words.push(format!(
            "assignment of ruptures to drops: others fit nearly as well: {readings}; the intervals given cover them"
        ));
    }
    words.push("damping of every layer: a curve without times shows no rate".to_owned());
    words
}

/// Whether the curve depends on a parameter without determining it.
fn is_open(estimate: &&ParameterEstimate) -> bool {
    estimate.interval.is_none() && estimate.standing != ParameterStanding::Kept
}

fn unseen_in_words(spec: &AxialSpec, unseen: &[usize]) -> String {
    let names: Vec<&str> = unseen.iter().map(|&boundary| layer(spec, boundary)).collect();
    format!(
        "no drop shows where {} gave way: the curve does not determine which boundary opened with which drop, so no \
         value has an interval",
        names.join(", ")
    )
}

fn names(spec: &AxialSpec, open: &[&ParameterEstimate]) -> String {
    let name = |e: &&ParameterEstimate| format!("{} of {}", e.quantity.words(), layer(spec, e.layer));
    open.iter().map(name).collect::<Vec<_>>().join(", ")
}

/// The same for a timed curve.
pub(super) fn timed_in_words(
    curve: &TimedCurve,
    spec: &AxialSpec,
    estimates: &[ParameterEstimate],
    unseen: &[usize],
) -> Vec<String> {
    let mut quantities: Vec<Quantity> = Vec::new();
    for estimate in estimates {
        if !quantities.contains(&estimate.quantity) {
            quantities.push(estimate.quantity);
        }
    }
    let mut words: Vec<String> = quantities.iter().filter_map(|&quantity| kept(spec, estimates, quantity)).collect();
    let open: Vec<&ParameterEstimate> = estimates.iter().filter(is_open).collect();
    if !unseen.is_empty() {
        words.push(unseen_in_words(spec, unseen));
    } else if !open.is_empty() {
        words.push(format!("{}: not determined to within their own size, individually or jointly", names(spec, &open)));
    }
    let is_branch = |e: &&ParameterEstimate| matches!(e.quantity, Quantity::BranchShare(_) | Quantity::BranchTime(_));
    if estimates.iter().any(|e| is_branch(&e)) && !curve.holds() {
        words.push("the curve has no hold, which alone would reveal relaxation".to_owned());
    }
    if !curve.withdraws() {
        words.push("the curve has no withdrawal, which alone would reveal friction".to_owned());
    }
    words.extend(undamped(spec));
    words
}

/// The layers without damping in the start.
fn undamped(spec: &AxialSpec) -> Option<String> {
    let names: Vec<&str> =
        spec.layers.iter().filter(|layer| layer.damping_n_s_per_m2 <= 0.0).map(|layer| layer.name.as_str()).collect();
    (!names.is_empty()).then(|| format!("damping of {}: the starting scene has none", names.join(", ")))
}

/// The layers of which a quantity has no effect on the curve, and why.
fn kept(spec: &AxialSpec, estimates: &[ParameterEstimate], quantity: Quantity) -> Option<String> {
    let kept = estimates.iter().filter(|e| e.quantity == quantity && e.standing == ParameterStanding::Kept);
    let layers: Vec<&str> = kept.map(|estimate| layer(spec, estimate.layer)).collect();
    (!layers.is_empty()).then(|| format!("{} of {}: {}", quantity.words(), layers.join(", "), unseen(quantity)))
}

fn layer(spec: &AxialSpec, layer: usize) -> &str {
    spec.layers.get(layer).map_or("the needle", |layer| layer.name.as_str())
}

/// Friction and cutting both resist on the way in: a hint if friction is among the undetermined
/// parameters.
fn no_withdrawal(model: &CurveModel<'_>, open: &[&ParameterEstimate]) -> &'static str {
    match open.iter().any(|e| e.quantity == Quantity::Friction) && !model.curve.withdraws() {
        true => "; the curve has no withdrawal, which alone would reveal friction",
        false => "",
    }
}

impl Quantity {
    /// Its name for the user.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::Thickness => "thickness",
            Self::Stiffness => "stiffness",
            Self::Friction => "friction",
            Self::Cutting => "cutting",
            Self::TipThreshold => "tip threshold",
            Self::RimThreshold => "rim threshold",
            Self::Stiffening => "stiffening",
            Self::StaticFriction => "static friction",
            Self::BranchShare(at) => ["share of branch 1", "share of branch 2", "share of branch 3"][at.min(2)],
            Self::BranchTime(at) => ["time of branch 1", "time of branch 2", "time of branch 3"][at.min(2)],
            Self::Damping => "damping",
            Self::Presliding => "presliding stiffness",
            Self::Breakaway => "breakaway length",
        }
    }
}

/// Why a curve may not depend on a parameter.
fn unseen(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Thickness => "the curve does not depend on the far side",
        Quantity::Stiffness => "the boundary never carries the tip within the curve, or only between two samples",
        Quantity::Friction => "the needle does not get there within the curve",
        Quantity::Cutting => "the tip never cuts there within the curve",
        Quantity::TipThreshold | Quantity::RimThreshold => {
            "the boundary opens together with the one above, or beyond the curve"
        }
        Quantity::Stiffening | Quantity::BranchShare(_) | Quantity::BranchTime(_) => {
            "the curve never dents the boundary, or only at one speed without a hold"
        }
        Quantity::StaticFriction => "the shaft never breaks away within the curve",
        Quantity::Damping => "the needle never moves in it within the curve",
        Quantity::Presliding => "no friction acts within the curve",
        Quantity::Breakaway => "no static friction gives way within the curve",
    }
}
