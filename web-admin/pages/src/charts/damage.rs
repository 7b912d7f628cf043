//! Tissue damage by layer and component, as stacked bars.

use super::scale::{AxisScale, Extent};
use super::svg::{Area, Caption, PaperPoint, Svg};
use super::{DrawingSize, scale};

/// Energy absorbed by a layer, by component, in mJ.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LayerDamage {
    /// The layer's name.
    pub name: String,
    /// Released by ruptures, in mJ.
    pub rupture_mj: f64,
    /// Spent on cutting, in mJ.
    pub cutting_mj: f64,
    /// Spent on friction, in mJ.
    pub friction_mj: f64,
    /// Lateral work, in mJ.
    pub lateral_mj: f64,
}

impl LayerDamage {
    /// Returns class and value of each component, in the order of the legend.
    #[must_use]
    pub fn parts(&self) -> [(&'static str, f64); 4] {
        [
            ("rupture", self.rupture_mj),
            ("cutting", self.cutting_mj),
            ("friction", self.friction_mj),
            ("lateral", self.lateral_mj),
        ]
    }

    /// Returns the sum of the components, in mJ: the length of the bar. It is not a damage index.
    #[must_use]
    pub fn total_mj(&self) -> f64 {
        self.parts().iter().map(|(_, value)| value.max(0.0)).sum()
    }
}

const ROW: f64 = 40.0;
const BAR: f64 = 16.0;

/// Draws one bar per layer that absorbed any energy.
#[must_use]
pub fn draw_damage(layers: &[LayerDamage], size: DrawingSize) -> String {
    let id = format!("damage-{}", size.name());
    let caption = Caption {
        id: &id,
        class: size.name(),
        title: tr!("Energy taken by each layer"),
        description: tr!(
            "One bar per layer, split into rupture, cutting, friction and lateral work in millijoules. The table below has the numbers."
        ),
    };
    let layers: Vec<&LayerDamage> = layers.iter().filter(|l| l.total_mj() > 0.0).collect();
    let rows = layers.len() as f64;
    let most = layers.iter().map(|l| l.total_mj()).fold(0.0, f64::max);
    let x = AxisScale::new(Extent::new(0.0, most * 1.02), Extent::new(4.0, size.width() - 60.0));
    let bottom = rows * ROW + 6.0;
    let mut svg = Svg::new(size.width(), bottom + 40.0, &caption);
    let ticks = x.ticks(size.ticks());
    for tick in &ticks {
        svg.line("grid", PaperPoint::new(x.at(*tick), 4.0), PaperPoint::new(x.at(*tick), bottom));
        svg.text("tick middle", PaperPoint::new(x.at(*tick), bottom + 15.0), &scale::tick_label(*tick, &ticks));
    }
    svg.text("axis-title end", PaperPoint::new(size.width() - 60.0, bottom + 31.0), tr!("energy (mJ)"));
    for (row, layer) in (0_u32..).zip(layers) {
        draw_damage_bar(&mut svg, &x, layer, f64::from(row) * ROW);
    }
    svg.finish()
}

fn draw_damage_bar(svg: &mut Svg, x: &AxisScale, layer: &LayerDamage, top: f64) {
    svg.text("layer-name", PaperPoint::new(4.0, top + 14.0), &layer.name);
    let mut from = 0.0;
    for (class, value) in layer.parts() {
        let to = from + value.max(0.0);
        let area = Area { x: x.at(from), y: top + 20.0, width: x.at(to) - x.at(from), height: BAR };
        svg.rect(&format!("part {class}"), area);
        if area.width > 14.0 {
            let initial = class.get(..1).unwrap_or_default().to_uppercase();
            svg.text("part-name middle", PaperPoint::new(area.x + area.width / 2.0, top + 32.0), &initial);
        }
        from = to;
    }
    svg.text("value", PaperPoint::new(x.at(from) + 6.0, top + 33.0), &format!("{from:.1}"));
}

#[cfg(test)]
mod tests {
    //! The components must add up to the length of the bar, and an attempt without damage must
    //! still be drawn.

    use super::*;

    #[test]
    fn parts_follow_each_other_without_gap() {
        let layer = LayerDamage { name: "skin".to_owned(), rupture_mj: 1.0, cutting_mj: 2.0, ..LayerDamage::default() };
        let markup = draw_damage(std::slice::from_ref(&layer), DrawingSize::Wide);
        assert_eq!(markup.matches("<rect").count(), 2, "parts of 0 are left out");
        assert!(markup.contains(">3.0<"));
    }

    #[test]
    fn no_damage_is_drawn_without_nonsense() {
        let markup = draw_damage(&[LayerDamage::default()], DrawingSize::Narrow);
        assert!(!markup.contains("NaN") && !markup.contains("<rect"));
        assert!(!draw_damage(&[], DrawingSize::Wide).contains("NaN"));
    }
}
