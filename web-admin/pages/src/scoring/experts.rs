//! Comparison of an attempt with experts: force over depth as a drawing, a table by layer, and a
//! description of each departure.

use attempt::AttemptCurve;
use model::scoring::corridor::Corridor;
use model::scoring::expert_comparison::{BesideBand, Compared, Departure, LayerBeside, Overreach};

use crate::{anatomy, charts, format};

/// Comparison of an attempt with experts.
#[derive(Clone, Debug, PartialEq)]
pub struct BesideExperts {
    /// Force over depth, at both widths.
    pub drawing: String,
    /// Number of experts.
    pub experts: usize,
    /// The drawing is deep enough for the target.
    pub has_target: bool,
    /// Layer by layer.
    pub rows: Vec<LayerBesideRow>,
    /// Descriptions of departures, with their times.
    pub departures: Vec<SaidDeparture>,
}

/// Comparison within a layer; cells are empty if a value could not be compared.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LayerBesideRow {
    /// Name of the layer.
    pub layer: String,
    /// Speed through the layer.
    pub speed: BesideCell,
    /// Advance after the pop into the layer.
    pub after_pop: BesideCell,
    /// Peak force in the layer.
    pub peak: BesideCell,
}

/// A value compared with the experts' range.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct BesideCell {
    /// Value of this attempt, with unit.
    pub own: String,
    /// Range of eight in ten experts.
    pub theirs: String,
    /// Whether the value is outside the range.
    pub departs: bool,
}

/// A departure from the experts' range.
#[derive(Clone, Debug, PartialEq)]
pub struct SaidDeparture {
    /// Description.
    pub words: String,
    /// Time in the attempt, in s.
    pub at_s: f64,
}

impl BesideExperts {
    /// Builds the comparison of an attempt with the experts.
    #[must_use]
    pub fn new(
        curve: &AttemptCurve,
        corridor: &Corridor,
        layers: &[LayerBeside],
        overreach: Option<&Overreach>,
    ) -> Self {
        let curve = &anatomy::name_layers_of_curve(curve);
        let said = layers.iter().flat_map(say_departures);
        Self {
            drawing: charts::draw_both_widths(|size| charts::draw_corridor(curve, corridor, size)),
            experts: corridor.experts,
            has_target: charts::find_deepest(curve, corridor) >= curve.target_depth_mm,
            rows: layers.iter().map(make_layer_row).collect(),
            departures: overreach.map(say_overreach).into_iter().chain(said).collect(),
        }
    }
}

const fn unit_of(what: Compared) -> &'static str {
    match what {
        Compared::Speed => "mm/s",
        Compared::AfterPop => "mm",
        Compared::Peak => "N",
    }
}

fn say_band(value: &BesideBand) -> String {
    tr!(
        "{low} to {high}",
        low = format::format_number(value.low),
        high = format::format_quantity(value.high, unit_of(value.what))
    )
}

fn make_layer_row(beside: &LayerBeside) -> LayerBesideRow {
    let cell = |what| {
        let found = beside.values.iter().find(|value| value.what == what);
        found.map_or_else(BesideCell::default, |value| BesideCell {
            own: format::format_quantity(value.own, unit_of(what)),
            theirs: say_band(value),
            departs: value.departs().is_some(),
        })
    };
    LayerBesideRow {
        layer: format::as_sentence(&anatomy::say_structure(&beside.layer)),
        speed: cell(Compared::Speed),
        after_pop: cell(Compared::AfterPop),
        peak: cell(Compared::Peak),
    }
}

fn say_overreach(overreach: &Overreach) -> SaidDeparture {
    let Overreach { layer, deeper, from_s, own_mm, low_mm, high_mm } = overreach;
    let (layer, own) = (anatomy::say_structure(layer), format::format_quantity(own_mm, "mm"));
    let theirs =
        tr!("{low} to {high}", low = format::format_number(low_mm), high = format::format_quantity(high_mm, "mm"));
    let words = match deeper {
        Some(deeper) => tr!(
            "After the pop into {layer} the needle advanced {own}, as far as {deeper}; the experts withdrew after {theirs}.",
            layer = layer,
            own = own,
            deeper = anatomy::say_structure(deeper),
            theirs = theirs
        ),
        None => tr!(
            "After the pop into {layer} the needle advanced {own}; the experts withdrew after {theirs}.",
            layer = layer,
            own = own,
            theirs = theirs
        ),
    };
    SaidDeparture { words, at_s: *from_s }
}

fn say_departures(beside: &LayerBeside) -> Vec<SaidDeparture> {
    let layer = anatomy::say_structure(&beside.layer);
    let said = |value: &BesideBand| {
        let departure = value.departs()?;
        let (own, theirs) = (format::format_quantity(value.own, unit_of(value.what)), say_band(value));
        let words = match (value.what, departure) {
            (Compared::Speed, Departure::Above) => {
                tr!(
                    "In {layer}: faster than the experts, {own} (experts: {theirs}).",
                    layer = layer,
                    own = own,
                    theirs = theirs
                )
            }
            (Compared::Speed, Departure::Below) => {
                tr!(
                    "In {layer}: slower than the experts, {own} (experts: {theirs}).",
                    layer = layer,
                    own = own,
                    theirs = theirs
                )
            }
            (Compared::AfterPop, Departure::Above) => tr!(
                "After the pop into {layer}: advanced further than the experts, {own} (experts: {theirs}).",
                layer = layer,
                own = own,
                theirs = theirs
            ),
            (Compared::AfterPop, Departure::Below) => tr!(
                "After the pop into {layer}: advanced less than the experts, {own} (experts: {theirs}).",
                layer = layer,
                own = own,
                theirs = theirs
            ),
            (Compared::Peak, Departure::Above) => {
                tr!(
                    "In {layer}: pushed harder than the experts, {own} (experts: {theirs}).",
                    layer = layer,
                    own = own,
                    theirs = theirs
                )
            }
            (Compared::Peak, Departure::Below) => {
                tr!(
                    "In {layer}: pushed less than the experts, {own} (experts: {theirs}).",
                    layer = layer,
                    own = own,
                    theirs = theirs
                )
            }
        };
        Some(SaidDeparture { words: format::as_sentence(&words), at_s: beside.from_s })
    };
    beside.values.iter().filter_map(said).collect()
}

#[cfg(test)]
mod tests {
    //! Every departure must be described, and no value within the range.

    use super::*;

    #[test]
    fn a_departure_is_said_and_what_lies_in_the_band_is_not() {
        let value = |what, own| BesideBand { what, own, low: 3.0, median: 4.0, high: 5.0 };
        let layer = LayerBeside {
            layer: "fat".to_owned(),
            from_s: 6.2,
            values: vec![value(Compared::Speed, 12.0), value(Compared::AfterPop, 4.5), value(Compared::Peak, 1.0)],
        };
        let said: Vec<String> = say_departures(&layer).into_iter().map(|said| said.words).collect();
        assert_eq!(
            said,
            [
                "In fat: faster than the experts, 12.0\u{a0}mm/s (experts: 3.00 to 5.00\u{a0}mm/s).",
                "In fat: pushed less than the experts, 1.00\u{a0}N (experts: 3.00 to 5.00\u{a0}N)."
            ]
        );
        let overreach = Overreach {
            layer: "fat".to_owned(),
            deeper: Some("muscle".to_owned()),
            from_s: 7.0,
            own_mm: 13.0,
            low_mm: 6.0,
            high_mm: 7.5,
        };
        let said = say_overreach(&overreach).words;
        assert_eq!(
            said,
            "After the pop into fat the needle advanced 13.0\u{a0}mm, as far as muscle; the experts withdrew after 6.00 to 7.50\u{a0}mm."
        );
        let row = make_layer_row(&layer);
        assert!(row.layer == "Fat" && row.speed.departs && !row.after_pop.departs);
    }
}
