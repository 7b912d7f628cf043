//! The displacement of every boundary at any moment of an attempt, for pictures: all of them take
//! it from here.
//!
//! A recording contains the field 120 times a second, and the needle's pose 1000 times a second. A
//! picture is drawn at neither rate, so it takes the last of both and settles the boundaries to its
//! needle. The same corrects older recordings, whose field followed the force law's forces.

use law::Skin;
use law::stance::{Follows, Intrusion, settle_dents};
use nalgebra::Point3;
use recording::sample::{Sample, flags};
use recording::{Event, EventKind, Tent};

use crate::insertion::needle_axis;

/// The boundaries of an attempt's tissue, by the events and field steps added so far.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Dents {
    skin: Skin,
    /// Thickness of each layer from the skin down, along the skin's normal, in m.
    thicknesses_m: Vec<f64>,
    tip_to_rim_m: f64,
    tracks: Vec<Opened>,
    /// The track that the needle is in.
    track: Option<usize>,
    /// Last displacement of each boundary in the field, in m.
    field_m: Vec<f32>,
}

/// Numbers of boundaries that are open along a track.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Opened {
    tip: usize,
    rim: usize,
}

impl Dents {
    /// Untouched tissue with a skin and layers of given thickness from there down, in m, under a
    /// needle whose rim is `tip_to_rim_m` behind its tip.
    #[must_use]
    pub fn new(skin: Skin, thicknesses_m: impl IntoIterator<Item = f64>, tip_to_rim_m: f64) -> Self {
        Self { skin, thicknesses_m: thicknesses_m.into_iter().collect(), tip_to_rim_m, ..Self::default() }
    }

    /// Adds an event.
    pub fn event(&mut self, event: &Event) {
        match event.kind {
            EventKind::Contact => {
                let track = event.track.map_or(self.tracks.len(), |track| track as usize);
                if track >= self.tracks.len() {
                    self.tracks.resize(track + 1, Opened::default());
                }
                self.track = Some(track);
            }
            EventKind::TipRupture | EventKind::RimRupture => self.rupture(event),
            EventKind::SkinExit => self.track = None,
            EventKind::StructureHit
            | EventKind::HubContact
            | EventKind::Confirm
            | EventKind::Coaching
            | EventKind::Fault
            | EventKind::Interrupted => {}
        }
    }

    fn rupture(&mut self, event: &Event) {
        let Some(opened) = self.track.and_then(|track| self.tracks.get_mut(track)) else { return };
        let count = event.boundary.map_or(0, |boundary| boundary as usize + 1);
        let open = if event.kind == EventKind::TipRupture { &mut opened.tip } else { &mut opened.rim };
        *open = count.max(*open);
    }

    /// Updates the field.
    pub fn tent(&mut self, tent: &Tent) {
        self.field_m.clone_from(&tent.tent_m);
    }

    /// Returns the last displacement of every boundary in the field, in m, not settled to the
    /// needle.
    #[must_use]
    pub fn field_m(&self) -> &[f32] {
        &self.field_m
    }

    /// Returns the displacement of every boundary along the needle, where its line meets it, in m,
    /// positive into the body, with the needle at the pose of `sample`. Events and field steps up
    /// to the sample must be added before.
    #[must_use]
    pub fn at(&self, sample: &Sample) -> Vec<f32> {
        let rest_m = self.rest_m(sample);
        let field = self.field_m.iter().map(|&dent_m| f64::from(dent_m)).chain(std::iter::repeat(0.0));
        let mut dents_m: Vec<f64> = field.take(self.thicknesses_m.len()).collect();
        settle_dents(Follows::Secant, self.needle(sample).as_ref(), &rest_m, &mut dents_m);
        dents_m.into_iter().map(|dent_m| dent_m as f32).collect()
    }

    /// Returns the difference between a picture with these dents and the law, in m, with the needle
    /// at the pose of `sample`: the largest distance of a pressed boundary from the contactor that
    /// presses it, of an opened one beyond the tip, of a closed one behind it, and of two that have
    /// passed each other. 0 means that they agree.
    #[must_use]
    pub fn disagreement_m(&self, sample: &Sample, dents_m: &[f32]) -> f64 {
        let mut rest_m = self.rest_m(sample);
        rest_m.truncate(self.thicknesses_m.len());
        let stand_m: Vec<f64> =
            rest_m.iter().zip(dents_m).map(|(rest_m, &dent_m)| rest_m + f64::from(dent_m)).collect();
        let passed_m = stand_m.windows(2).map(|pair| pair[0] - pair[1]);
        let beside = self.needle(sample).into_iter().flat_map(|needle| {
            let pressed = needle.pressed(&rest_m).into_iter().flatten();
            let pressed_m: Vec<f64> = pressed
                .map(|pressed| {
                    stand_m
                        .get(pressed.boundary)
                        .map_or(f64::INFINITY, |at_m| (at_m - rest_m[pressed.boundary] - pressed.dent_m).abs())
                })
                .collect();
            let wrong_m = stand_m.iter().zip(&rest_m).enumerate().map(|(boundary, (at_m, rest_m))| {
                let is_behind = boundary < needle.tip_open && *rest_m <= needle.tip_m;
                if is_behind { at_m - needle.tip_m } else { needle.tip_m - at_m }
            });
            pressed_m.into_iter().chain(wrong_m.collect::<Vec<_>>())
        });
        passed_m.chain(beside).fold(0.0, f64::max)
    }

    /// Returns the layer that the tip is in, from the skin down, with the needle at the pose of
    /// `sample`; `None` at or above the skin. Tissue that only deforms is not entered.
    #[must_use]
    pub fn layer(&self, sample: &Sample) -> Option<usize> {
        /// More than the rounding error of a depth in single precision, and far less than is
        /// visible, in m.
        const ROUNDING_M: f64 = 1e-7;
        let depth_m = f64::from(sample.depth_m) - ROUNDING_M;
        let tops_m = self.rest_m(sample);
        tops_m[..self.thicknesses_m.len()].iter().take_while(|&&top_m| top_m < depth_m).count().checked_sub(1)
    }

    /// Returns the distance along the needle from the point where its line meets the skin to each
    /// resting boundary and to the base, in m.
    fn rest_m(&self, sample: &Sample) -> Vec<f64> {
        let axis = needle_axis(sample);
        let entry_m = Point3::from(sample.tip_m()) - axis * self.way_m(sample);
        let mut rest_m = Vec::new();
        self.skin.incidence(&entry_m, &axis).lay_layers(self.thicknesses_m.iter().copied(), &mut rest_m);
        rest_m
    }

    /// Returns the distance along the needle from that point to the tip, in m.
    fn way_m(&self, sample: &Sample) -> f64 {
        self.skin.displacement_m(&Point3::from(sample.tip_m()), &needle_axis(sample))
    }

    /// Returns the intrusion of the needle; `None` in the air.
    fn needle(&self, sample: &Sample) -> Option<Intrusion> {
        let inside = self.track.filter(|_| sample.flags & flags::INSIDE != 0);
        inside.and_then(|track| self.tracks.get(track)).map(|opened| Intrusion {
            tip_m: self.way_m(sample),
            tip_to_rim_m: self.tip_to_rim_m,
            tip_open: opened.tip,
            rim_open: opened.rim,
        })
    }
}

#[cfg(test)]
mod tests {
    //! Fails if the skin of a picture is not where the tip presses it, even if the field differs.

    use super::*;

    fn sample(depth_mm: f64, lean_rad: f64) -> Sample {
        let half = 0.5 * (std::f64::consts::PI - lean_rad);
        let orientation = [libm::sin(half), 0.0, 0.0, libm::cos(half)];
        Sample { position_m: [0.0, 0.0, -depth_mm * 1e-3], orientation, flags: flags::INSIDE, ..Sample::default() }
    }

    fn event(kind: EventKind, boundary: u32) -> Event {
        Event {
            t_s: 0.0,
            kind,
            boundary: Some(boundary),
            x_m: 0.0,
            position_m: [0.0; 3],
            force_n: 0.0,
            dissipated_j: 0.0,
            track: Some(0),
            structure: None,
            text: String::new(),
        }
    }

    #[test]
    fn the_skin_is_where_the_tip_is_and_the_rim_follows() {
        let mut dents = Dents::new(Skin::Flat, [0.8e-3, 8.4e-3, 39e-3], 2e-3);
        dents.tent(&Tent { tent_m: vec![11.1e-3, 9e-3, 1e-3], ..Tent::default() });
        dents.event(&event(EventKind::Contact, 0));
        let close = |found: f32, wanted_m: f64| (f64::from(found) - wanted_m).abs() < 1e-8;
        let here = sample(5.0, 0.0);
        assert!(close(dents.at(&here)[0], 5e-3), "{:?}", dents.at(&here));
        assert!(dents.disagreement_m(&here, &dents.at(&here)) < 1e-8);
        assert!(
            (dents.disagreement_m(&here, &[11.1e-3, 9e-3, 1e-3]) - 6.1e-3).abs() < 1e-6,
            "the picture of the field alone"
        );
        let leaning = dents.at(&sample(5.0, 0.5))[0];
        assert!(close(leaning, 5e-3 / libm::cos(0.5)), "along a leaning needle: {leaning}");
        dents.event(&event(EventKind::TipRupture, 0));
        let stand = dents.at(&sample(5.0, 0.0));
        assert!(close(stand[0], 3e-3) && close(stand[1], 4.2e-3), "skin at the rim, fat at the tip: {stand:?}");
        dents.event(&event(EventKind::RimRupture, 0));
        let stand = dents.at(&sample(5.0, 0.0));
        assert!(stand[0] <= 3e-3 && close(stand[1], 4.2e-3), "{stand:?}");
        dents.event(&event(EventKind::SkinExit, 0));
        assert!(close(dents.at(&sample(-1.0, 0.0))[0], 11.1e-3), "in the air the field alone");
    }
}
