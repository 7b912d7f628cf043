//! The load as forces on the nodes, per radian: its share across the radius times its share along
//! the depth.

use std::f64::consts::PI;

use super::basis::{basis, fine_rule};
use super::mesh::{Span, Spans, same_depth};
use crate::quadrature::gauss_rule;
use crate::{Load, LoadKind};

/// Load radii beyond which the traction is negligible: exp(−7²) = 5e-22.
const REACH: f64 = 7.0;

/// ∫ g(x) φ(x) dx over each strip, summed at the nodes.
fn weigh(spans: &Spans, within_m: [f64; 2], density: impl Fn(f64) -> f64) -> Vec<f64> {
    let mut weights = vec![0.0; spans.nodes()];
    for span in spans.all() {
        let (from_m, to_m) = (span.from_m.max(within_m[0]), span.to_m.min(within_m[1]));
        for &(x, weight) in fine_rule().iter().filter(|_| to_m > from_m) {
            let at_m = 0.5 * (from_m + to_m) + 0.5 * (to_m - from_m) * x;
            let values = basis(span.order).values((at_m - span.middle_m()) / span.half_m());
            let scale = 0.5 * (to_m - from_m) * weight * density(at_m);
            for (node, value) in weights[span.first..=span.first + span.order].iter_mut().zip(values) {
                *node += scale * value;
            }
        }
    }
    weights
}

/// The force of 1 N on every node across the radius, in N per radian: ∫ φ p r dr with p =
/// exp(−(r/a)²)/(πa²).
pub(super) fn across(radius_m: f64, spans: &Spans) -> Vec<f64> {
    let scale = 1.0 / (PI * radius_m * radius_m);
    weigh(spans, [0.0, REACH * radius_m], |r| scale * r * libm::exp(-(r / radius_m) * (r / radius_m)))
}

/// The share of the load on every node along the depth: all on one of them, or uniform over a
/// stretch.
pub(super) fn along(load: &Load, spans: &Spans) -> Vec<f64> {
    let [from_m, to_m] = load.ends_m();
    if !same_depth(from_m, to_m) {
        return weigh(spans, [from_m, to_m], |_| 1.0 / (to_m - from_m));
    }
    let mut weights = vec![0.0; spans.nodes()];
    let begins = |span: &&Span| same_depth(span.from_m, from_m);
    let node = spans.all().iter().find(begins).map_or(weights.len() - 1, |span| span.first);
    weights[node] = 1.0;
    weights
}

/// A part of an oblique load, on a vertical of its own.
pub(super) struct AxisStation {
    /// Depth at which the needle meets the vertical, in m.
    pub depth_m: f64,
    /// Its share of the load on every node along the depth.
    pub along: Vec<f64>,
}

/// A contactor at a depth in m.
pub(super) fn push(depth_m: f64, spans: &Spans) -> AxisStation {
    let load = Load { kind: LoadKind::Contactor { depth_m }, radius_m: 0.0 };
    AxisStation { depth_m, along: along(&load, spans) }
}

/// A point of a load along the needle.
pub(super) struct StretchPoint {
    /// Its depth, in m.
    pub depth_m: f64,
    /// Its share of the load.
    pub share: f64,
}

/// The points of a load: a rule as accurate as the mesh.
pub(super) fn stretch(load: &Load, spans: &Spans) -> Vec<StretchPoint> {
    let [from_m, to_m] = load.ends_m();
    if same_depth(from_m, to_m) {
        return vec![StretchPoint { depth_m: from_m, share: 1.0 }];
    }
    let dragged = spans.all().iter().filter(|span| (from_m..=to_m).contains(&span.middle_m()));
    let of_span = |span: &Span| {
        let (middle_m, half_m) = (span.middle_m(), span.half_m());
        let point = move |(x, weight): (f64, f64)| StretchPoint {
            depth_m: middle_m + half_m * x,
            share: weight * half_m / (to_m - from_m),
        };
        gauss_rule(span.order + 2).into_iter().map(point)
    };
    dragged.flat_map(of_span).collect()
}

/// The stations of an oblique load, at any angle: a contactor has one where the needle meets it; a
/// drag has `each_strip` in each strip, at Gauss points, each with the density of its interpolation
/// polynomial.
pub(super) fn stations(load: &Load, spans: &Spans, each_strip: usize) -> Vec<AxisStation> {
    let [from_m, to_m] = load.ends_m();
    if same_depth(from_m, to_m) {
        return vec![AxisStation { depth_m: from_m, along: along(load, spans) }];
    }
    let points: Vec<f64> = gauss_rule(each_strip).into_iter().map(|(point, _)| point).collect();
    let dragged = spans.all().iter().filter(|span| (from_m..=to_m).contains(&span.middle_m()));
    let station = |span: &Span, own: usize| {
        let others = || points.iter().enumerate().filter(move |&(at, _)| at != own);
        let share = |depth_m: f64| -> f64 {
            let x = (depth_m - span.middle_m()) / span.half_m();
            others().map(|(_, point)| (x - point) / (points[own] - point)).product()
        };
        let depth_m = span.middle_m() + span.half_m() * points[own];
        let along = weigh(spans, [span.from_m, span.to_m], |depth_m| share(depth_m) / (to_m - from_m));
        AxisStation { depth_m, along }
    };
    dragged.flat_map(|span| (0..each_strip).map(move |own| (span, own))).map(|(span, own)| station(span, own)).collect()
}
