//! What a curve cannot determine, in words.

use std::collections::BTreeSet;

use super::model::{Guess, Model, Quantity, VARIABLES};
use super::uncertainty::{Estimate, Standing, undetermined};
use crate::axial::AxialSpec;

/// A line for each reason, naming the parameters that it holds for.
pub(super) fn in_words(model: &Model<'_>, guess: &Guess, estimates: &[Estimate]) -> Vec<String> {
    let quantities = VARIABLES.into_iter().chain([Quantity::TipThreshold, Quantity::RimThreshold]);
    let mut words: Vec<String> = quantities.filter_map(|quantity| kept(&guess.spec, estimates, quantity)).collect();
    let (alone, together): (Vec<_>, Vec<_>) =
        joined(undetermined(model, guess)).into_iter().partition(|set| set.len() == 1);
    let alone: BTreeSet<usize> = alone.into_iter().flatten().collect();
    if !alone.is_empty() {
        words.push(format!("{}: lost in the residual{}", names(&guess.spec, &alone), no_withdrawal(model, &alone)));
    }
    words.extend(together.iter().map(|set| {
        let (names, why) = (names(&guess.spec, set), no_withdrawal(model, set));
        format!("{names} cannot be told apart: a joint change of them is lost in the residual{why}")
    }));
    words.push("damping of every layer: a curve without times shows no rate".to_owned());
    words
}

/// The layers of which a quantity has no effect on the curve, and why.
fn kept(spec: &AxialSpec, estimates: &[Estimate], quantity: Quantity) -> Option<String> {
    let kept = estimates.iter().filter(|e| e.quantity == quantity && e.standing == Standing::Kept);
    let layers: Vec<&str> = kept.map(|estimate| layer(spec, estimate.layer)).collect();
    (!layers.is_empty()).then(|| format!("{} of {}: {}", quantity.words(), layers.join(", "), unseen(quantity)))
}

/// Sets of variables, those with a variable in common made one.
fn joined(sets: Vec<Vec<usize>>) -> Vec<BTreeSet<usize>> {
    let mut joined: Vec<BTreeSet<usize>> = Vec::new();
    for set in sets {
        let mut set = BTreeSet::from_iter(set);
        joined.retain(|other| {
            let apart = other.is_disjoint(&set);
            if !apart {
                set.extend(other);
            }
            apart
        });
        joined.push(set);
    }
    joined
}

fn quantity(variable: usize) -> Quantity {
    VARIABLES[variable % VARIABLES.len()]
}

fn layer(spec: &AxialSpec, layer: usize) -> &str {
    spec.layers.get(layer).map_or("", |layer| layer.name.as_str())
}

fn names(spec: &AxialSpec, variables: &BTreeSet<usize>) -> String {
    let name =
        |&variable: &usize| format!("{} of {}", quantity(variable).words(), layer(spec, variable / VARIABLES.len()));
    variables.iter().map(name).collect::<Vec<_>>().join(", ")
}

/// Friction and cutting both resist on the way in: said where nothing else is confused.
fn no_withdrawal(model: &Model<'_>, variables: &BTreeSet<usize>) -> &'static str {
    let is_resistance = |&at: &usize| matches!(quantity(at), Quantity::Friction | Quantity::Cutting);
    match variables.iter().all(is_resistance) && !model.curve.withdraws() {
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
        Quantity::Cutting => "the tip never cuts there without tenting what lies below",
        Quantity::TipThreshold | Quantity::RimThreshold => {
            "the boundary opens together with the one above, or beyond the curve"
        }
    }
}
