//! Soft tissue: canal and sac, muscles, vessels, kidneys, and the surrounding skin.

use super::form::{Form, Place, Pose, Solid, join_inside};
use super::loft::{Loft, Section, interpolate};
use super::part::{BodySide, Level};
use super::patient::BodyValues;
use super::spine::{COLUMN, ColumnBone, SACRUM};

/// Distance between the sac and the vertebral bodies, in mm. Estimated.
const VENTRAL_EPIDURAL: f64 = 1.2;
/// Thickness of the supraspinous ligament behind the tips, in mm. Estimated.
pub(super) const SUPRASPINOUS: f64 = 4.0;

/// The canal, or the sac in it.
pub(super) fn build_canal(column: &[ColumnBone; COLUMN], values: &BodyValues, sac: bool) -> Loft {
    let section = |bone: &ColumnBone| {
        let own = &bone.values;
        let (canal, epidural) = (own.canal_depth, values.epidural_depth.min(0.35 * own.canal_depth));
        let half_z = if sac { 0.5 * (canal - VENTRAL_EPIDURAL - epidural) } else { 0.5 * canal };
        let front = 0.5 * own.depth + if sac { VENTRAL_EPIDURAL } else { 0.0 };
        let half_x = if sac { (0.33 * own.canal_width).max(half_z) } else { 0.5 * own.canal_width };
        let middle = bone.pose.to_outer(Place::new(0.0, 0.0, front + half_z));
        Section { middle, half_x, half_z }
    };
    let mut sections: Vec<Section> = column.iter().map(section).collect();
    // It narrows down to S2, where the sac ends.
    let last = column[SACRUM].pose.to_outer(Place::new(0.0, -26.0, column[SACRUM].values.canal_middle()));
    let end = if sac { [4.0, 3.0] } else { [9.0, 5.0] };
    sections.push(Section { middle: last, half_x: end[0], half_z: end[1] });
    Loft::new(sections, 2.0)
}

/// Depth of the spinous tips, in mm, as a function of height.
#[derive(Clone, Debug)]
pub(super) struct TipLine(Vec<Place>);

impl TipLine {
    pub(super) fn new(column: &[ColumnBone; COLUMN]) -> Self {
        let mut tips: Vec<Place> = column.iter().map(ColumnBone::tip).collect();
        tips.push(column[SACRUM].pose.to_outer(Place::new(0.0, -45.0, column[SACRUM].values.spinous_reach - 8.0)));
        tips.reverse();
        Self(tips)
    }

    /// Depth of the tips at a height.
    pub(super) fn depth(&self, y: f64) -> f64 {
        interpolate(&self.0, |tip| tip.y, |tip| tip.z, y)
    }

    /// 1 over the middle of a tip, 0 between two.
    fn prominence(&self, y: f64) -> f64 {
        self.0.iter().map(|tip| libm::exp(-((y - tip.y) / 8.0).powi(2))).sum::<f64>().min(1.0)
    }
}

/// The outer surface of the body.
#[derive(Clone, Debug)]
pub(super) struct SkinShape {
    tips: TipLine,
    trunk: Loft,
    midline_fat: f64,
    lateral_fat: f64,
    bulge: f64,
}

/// Protrusion of the erector spinae behind the spinous tips, in mm. Estimated.
const ERECTOR_OVER_TIPS: f64 = 7.0;

impl SkinShape {
    pub(super) fn new(column: &[ColumnBone; COLUMN], values: &BodyValues) -> Self {
        let tips = TipLine::new(column);
        let (top, low) = (column[0].middle(), column[SACRUM].middle());
        let section = |y: f64, half_x: f64, belly: f64| {
            let spine =
                column.iter().map(ColumnBone::middle).min_by(|a, b| (a.y - y).abs().total_cmp(&(b.y - y).abs()));
            let spine = spine.map_or(0.0, |middle| middle.z);
            let (back, front) = (tips.depth(y) + values.midline_fat + 16.0, spine - belly);
            Section { middle: Place::new(0.0, y, 0.5 * (back + front)), half_x, half_z: 0.5 * (back - front) }
        };
        // A thin patient's belly sinks in between the ribs and the pelvis, not over them.
        let (waist, belly, pelvis) =
            (values.half_waist, values.belly.max(112.0), values.belly.max(142.0 * values.size));
        let hips = (waist + 22.0).max(values.size * 128.0 + 34.0 + values.lateral_fat);
        let sections = vec![
            section(low.y - 95.0, hips + 4.0, pelvis),
            section(low.y - 20.0, hips, pelvis),
            section(0.5 * (low.y + top.y) - 20.0, (waist).max(132.0 + values.lateral_fat), 1.04 * belly),
            section(top.y, waist.max(138.0 + values.lateral_fat), belly),
            section(top.y + 60.0, waist.max(140.0 + values.lateral_fat) + 2.0, belly),
        ];
        let bulge = (ERECTOR_OVER_TIPS + values.lateral_fat - SUPRASPINOUS - values.midline_fat).max(2.5);
        Self {
            tips,
            trunk: Loft::new(sections, 14.0),
            midline_fat: values.midline_fat,
            lateral_fat: values.lateral_fat,
            bulge,
        }
    }

    /// Depth of the skin on the back, in mm.
    fn back(&self, p: &Place) -> f64 {
        let beside = share_beside(p);
        // The tips protrude in a thin patient.
        let shown = 2.2 * libm::exp(-self.midline_fat / 7.0) * self.tips.prominence(p.y) * (1.0 - beside);
        let level = self.tips.depth(p.y) + SUPRASPINOUS + self.midline_fat + shown;
        level + self.bulge * beside - 7e-4 * p.x * p.x
    }

    /// Signed distance from the fascia below the fat, in mm; negative inside.
    pub(super) fn fascia_distance(&self, p: &Place) -> f64 {
        let beside = share_beside(p);
        let fat = self.midline_fat * (1.0 - beside) + self.lateral_fat * beside;
        self.distance_below(p, fat, self.lateral_fat)
    }

    /// Signed distance, in mm; negative inside the body.
    pub(super) fn distance(&self, p: &Place) -> f64 {
        self.distance_below(p, 0.0, 0.0)
    }

    /// Signed distance from a surface below the skin: so many mm below the back, and below the sides and the ends.
    fn distance_below(&self, p: &Place, below_back: f64, below_side: f64) -> f64 {
        let [low, high] = self.trunk.ends();
        let Section { middle, half_x, half_z } = self.trunk.at(p.y);
        let (x, z) = ((p.x / half_x).powi(2), ((p.z - middle.z) / half_z).powi(2));
        let side = (0.5 * ((x + z).sqrt() + (x * x + z * z).sqrt().sqrt()) - 1.0) * half_x.min(half_z);
        // The back is as steep as the column's inclination: the factor keeps the value below the
        // true distance there.
        let back = 0.8 * (p.z - self.back(p) + below_back);
        let ends = (low - p.y).max(p.y - high) + below_side.min(1.0);
        join_inside(join_inside(side + below_side, back, 10.0), ends, 14.0)
    }

    pub(super) fn trunk(&self) -> &Loft {
        &self.trunk
    }

    pub(super) fn tips(&self) -> &TipLine {
        &self.tips
    }
}

/// Weight of lateral tissue: 0 in the midline, 1 far from it.
fn share_beside(p: &Place) -> f64 {
    1.0 - libm::exp(-(p.x / 19.0).powi(2))
}

/// Erector spinae with multifidus: 2105 ± 377 mm² at L3/4 (erector alone, MRI of healthy adults,
/// Med Sci Monit 2026, read).
pub(super) fn build_erector(
    column: &[ColumnBone; COLUMN],
    skin: &SkinShape,
    values: &BodyValues,
    side: BodySide,
) -> Loft {
    let section = |y: f64, x: f64, half: [f64; 2]| {
        let [half_x, half_z] = half.map(|half| half * values.muscle.sqrt());
        let back = skin.tips().depth(y) + ERECTOR_OVER_TIPS * half_z / half[1];
        Section { middle: Place::new(side.sign() * x, y, back - half_z), half_x, half_z }
    };
    let y = |at: usize| column[at].middle().y;
    let sections = vec![
        section(y(0) + 48.0, 31.0, [27.0, 19.0]),
        section(y(1), 34.0, [31.0, 22.0]),
        section(y(3), 36.0, [33.0, 24.0]),
        section(y(5), 34.0, [31.0, 22.0]),
        section(y(SACRUM), 29.0, [25.0, 16.0]),
        section(y(SACRUM) - 45.0, 22.0, [14.0, 8.0]),
    ];
    Loft::new(sections, 5.0)
}

/// Quadratus lumborum: 684 ± 282 mm² at L3/4 (same source, read), from rib 12 to the crest.
pub(super) fn build_quadratus(column: &[ColumnBone; COLUMN], values: &BodyValues, side: BodySide) -> Loft {
    let section = |bone: &ColumnBone, off: f64, x: f64, half: [f64; 2]| {
        let [half_x, half_z] = half.map(|half| half * values.muscle.sqrt());
        let depth = bone.pose.to_outer(Place::new(0.0, off, 0.5 * bone.values.depth + 7.0)).z;
        Section { middle: Place::new(side.sign() * x, bone.middle().y + off, depth), half_x, half_z }
    };
    let sections = vec![
        section(&column[0], -14.0, 50.0, [16.0, 5.0]),
        section(&column[2], 0.0, 60.0, [22.0, 8.0]),
        section(&column[3], 0.0, 66.0, [25.0, 9.0]),
        section(&column[4], 0.0, 72.0, [27.0, 8.0]),
        section(&column[5], 10.0, 76.0, [26.0, 6.0]),
    ];
    Loft::new(sections, 4.0)
}

/// Pose of a kidney at L1 and L2: the second axis towards its upper pole, the third out of the back. The left one is higher.
pub(super) fn kidney_pose(column: &[ColumnBone; COLUMN], side: BodySide) -> Pose {
    let raised = if side == BodySide::Left { 12.0 } else { -2.0 };
    let middle = column[1].middle().lerp(&column[2].middle(), 0.4) + Place::new(side.sign() * 66.0, raised, -2.0);
    // The upper pole is nearer to the column and farther back.
    Pose::along(middle, Place::new(1.0, 0.22 * side.sign(), 0.0), Place::new(-0.22 * side.sign(), 1.0, 0.12))
}

/// Half axes of a kidney, in mm: 55 mm wide and 40 mm thick.
pub(super) fn kidney_half(values: &BodyValues) -> Place {
    Place::new(27.0, values.kidney_half_length, 19.0)
}

/// A kidney.
pub(super) fn build_kidney(column: &[ColumnBone; COLUMN], values: &BodyValues, side: BodySide) -> Solid {
    let mut kidney = Solid::default();
    let pose = kidney_pose(column, side);
    kidney.add(Form::Egg { half: kidney_half(values) }, &pose, 0.0);
    let hilum = Pose::along(pose.to_outer(Place::new(-side.sign() * 31.0, 0.0, -4.0)), Place::x(), Place::y());
    kidney.cut(Form::Egg { half: Place::new(13.0, 15.0, 11.0) }, &hilum, 6.0);
    kidney
}

/// A tube through points, with radii interpolated from one end to the other.
fn build_tube(tube: &mut Solid, places: &[Place], radii: [f64; 2]) {
    let frame = Pose::leaning(Place::zeros(), 0.0);
    let last = (places.len() - 1) as f64;
    for (at, pair) in places.windows(2).enumerate() {
        let radius = |at: usize| radii[0] + (radii[1] - radii[0]) * at as f64 / last;
        let form = Form::Cone { from: pair[0], to: pair[1], from_radius: radius(at), to_radius: radius(at + 1) };
        tube.add(form, &frame, 1.5);
    }
}

/// A great vessel in front of the vertebral bodies down to its bifurcation, and one branch on each
/// side.
pub(super) fn build_great_vessel(column: &[ColumnBone; COLUMN], x: f64, radius: f64, divides: usize) -> Solid {
    let before = |bone: &ColumnBone, x: f64, y: f64, radius: f64| {
        bone.pose.to_outer(Place::new(x, y, -0.5 * bone.values.depth - radius - 2.0))
    };
    let trunk: Vec<Place> =
        (0..=divides).map(|at| before(&column[at], x * (1.0 - 0.08 * at as f64), 0.0, radius)).collect();
    let mut vessel = Solid::default();
    build_tube(&mut vessel, &trunk, [1.1 * radius, 0.95 * radius]);
    for side in [-1.0, 1.0] {
        let sacrum = &column[SACRUM];
        let branch = [
            trunk[divides],
            before(&column[5], 0.5 * x + side * 17.0, -6.0, radius),
            sacrum.pose.to_outer(Place::new(side * 40.0, 8.0, -0.5 * sacrum.values.depth - 10.0)),
        ];
        build_tube(&mut vessel, &branch, [0.8 * radius, 0.62 * radius]);
    }
    vessel
}

/// The lumbar arteries, around the waists of L1 to L4.
pub(super) fn build_lumbar_vessels(column: &[ColumnBone; COLUMN]) -> Solid {
    let mut vessels = Solid::default();
    for level in &Level::ALL[..4] {
        let bone = &column[*level as usize + 1];
        for side in [-1.0, 1.0] {
            let around = |step: usize| {
                let (sin, cos) = libm::sincos((-75.0 + 15.0 * step as f64).to_radians());
                let (half_x, half_z) = (0.5 * bone.values.width + 2.5, 0.5 * bone.values.depth + 2.5);
                bone.pose.to_outer(Place::new(side * half_x * cos, 0.0, half_z * sin))
            };
            let places: Vec<Place> = (0..=6).map(around).collect();
            build_tube(&mut vessels, &places, [1.5, 1.3]);
        }
    }
    vessels
}
