//! What a curve cannot determine, in words.

use law::axial::AxialSpec;

use super::model::{CurveModel, Guess, QUANTITIES, Quantity};
use super::uncertainty::{ParameterEstimate, ParameterStanding};

/// A line for each reason, naming the parameters that it holds for.
pub(super) fn in_words(
    model: &CurveModel<'_>,
    guess: &Guess,
    estimates: &[ParameterEstimate],
    readings: usize,
    unseen: &[usize],
) -> Vec<String> {
    let mut words: Vec<String> =
        QUANTITIES.into_iter().filter_map(|quantity| kept(&guess.spec, estimates, quantity)).collect();
    let is_open = |e: &&ParameterEstimate| e.interval.is_none() && e.standing != ParameterStanding::Kept;
    let open: Vec<&ParameterEstimate> = estimates.iter().filter(is_open).collect();
    if !unseen.is_empty() {
        let names: Vec<&str> = unseen.iter().map(|&boundary| layer(&guess.spec, boundary)).collect();
        words.push(format!(
            "no drop shows where {} gave way: which boundary opened with which drop the curve does not tell, and no number has an interval",
            names.join(", ")
        ));
    } else if !open.is_empty() {
        let names: Vec<String> =
            open.iter().map(|e| format!("{} of {}", e.quantity.words(), layer(&guess.spec, e.layer))).collect();
        let why = no_withdrawal(model, &open);
        words.push(format!("{}: not held to within their own size, alone or together{why}", names.join(", ")));
    }
    if readings > 0 {
        words.push(format!(
            "which rupture is which drop: other readings that fit nearly as well: {readings}; intervals that are given cover them"
        ));
    }
    words.push("damping of every layer: a curve without times shows no rate".to_owned());
    words
}

/// The layers of which a quantity has no effect on the curve, and why.
fn kept(spec: &AxialSpec, estimates: &[ParameterEstimate], quantity: Quantity) -> Option<String> {
    let kept = estimates.iter().filter(|e| e.quantity == quantity && e.standing == ParameterStanding::Kept);
    let layers: Vec<&str> = kept.map(|estimate| layer(spec, estimate.layer)).collect();
    (!layers.is_empty()).then(|| format!("{} of {}: {}", quantity.words(), layers.join(", "), unseen(quantity)))
}

fn layer(spec: &AxialSpec, layer: usize) -> &str {
    spec.layers.get(layer).map_or("", |layer| layer.name.as_str())
}

/// Friction and cutting both resist on the way in: said where friction is among what is open.
fn no_withdrawal(model: &CurveModel<'_>, open: &[&ParameterEstimate]) -> &'static str {
    match open.iter().any(|e| e.quantity == Quantity::Friction) && !model.curve.withdraws() {
        true => "; the curve has no withdrawal, which would show friction alone",
        false => "",
    }
}

impl Quantity {
    /// What it is, in words.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::Thickness => "thickness",
            Self::Stiffness => "stiffness",
            Self::Friction => "friction",
            Self::Cutting => "cutting",
            Self::TipThreshold => "tip threshold",
            Self::RimThreshold => "rim threshold",
        }
    }
}

/// Why a curve may not depend on a parameter.
fn unseen(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Thickness => "the curve does not feel the far side",
        Quantity::Stiffness => "the boundary never carries the tip within the curve, or only between two samples",
        Quantity::Friction => "the needle never gets there within the curve",
        Quantity::Cutting => "the tip never cuts there within the curve",
        Quantity::TipThreshold | Quantity::RimThreshold => {
            "the boundary opens together with the one above, or beyond the curve"
        }
    }
}
