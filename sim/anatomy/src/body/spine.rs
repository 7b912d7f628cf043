//! The bones and their positions: L3 upright, the others stacked by discs and their angles.

use super::form::{Bounds, Form, Place, Pose, Solid};
use super::part::{BodySide, Level};
use super::patient::BodyValues;
use super::published::Dimension;
use super::vertebra::{VertebraValues, build_vertebra, lean_of};

/// Number of bones of the column, from the last thoracic vertebra to the sacrum.
pub(super) const COLUMN: usize = 7;
/// Index of the sacrum in the column.
pub(super) const SACRUM: usize = 6;

/// A bone of the column.
#[derive(Clone, Debug)]
pub(super) struct ColumnBone {
    pub(super) pose: Pose,
    pub(super) values: VertebraValues,
    bone: Solid,
    bounds: Bounds,
}

/// Distance from a bone's bounds, in mm, beyond which the distance from the bounds replaces that
/// from the bone.
const ASIDE: f64 = 5.0;

impl ColumnBone {
    /// Signed distance from the bone alone, in mm.
    pub(super) fn distance(&self, p: &Place) -> f64 {
        let aside = self.bounds.distance(p);
        if aside > ASIDE { aside } else { self.bone.distance(p) }
    }

    /// The signed distance from the bone's shape at any distance.
    pub(super) fn shape_distance(&self, p: &Place) -> f64 {
        self.bone.distance(p)
    }

    /// A bounding box of the bone.
    pub(super) fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// Tip of the spinous process, or of the crest of the sacrum.
    pub(super) fn tip(&self) -> Place {
        self.pose.to_outer(self.values.spinous_tip() + Place::new(0.0, 0.0, 3.0))
    }

    /// The middle of the vertebral body.
    pub(super) fn middle(&self) -> Place {
        self.pose.to_outer(Place::zeros())
    }
}

/// The column of a body.
pub(super) fn build_column(values: &BodyValues) -> [ColumnBone; COLUMN] {
    let vertebrae: [VertebraValues; COLUMN] = std::array::from_fn(|at| match at {
        0 => thoracic(&lumbar(values, Level::L1)),
        SACRUM => sacral(&lumbar(values, Level::L5)),
        _ => lumbar(values, Level::ALL[at - 1]),
    });
    let leans = lean_all(values, &vertebrae);
    let middles = place_all(values, &vertebrae, &leans);
    std::array::from_fn(|at| {
        let pose = Pose::leaning(middles[at], leans[at]);
        let bone =
            if at == SACRUM { build_sacrum(&vertebrae[at], &pose) } else { build_vertebra(&vertebrae[at], &pose) };
        ColumnBone { pose, values: vertebrae[at], bounds: bone.bounds(), bone }
    })
}

fn lumbar(values: &BodyValues, level: Level) -> VertebraValues {
    let get = |dimension| values.get(dimension, level);
    // The superior processes stand next to the canal; the inferior ones lie inside those of the
    // next vertebra.
    let beside = |level: Level| 0.5 * values.get(Dimension::CanalWidth, level) + 4.5;
    let next = Level::ALL.get(level as usize + 1).map_or(beside(level) + 2.0, |next| beside(*next));
    // 30.3 − 26.3 mm at L5 (read, see EndplateDepth); recalled for the levels above.
    let wedge = [-1.2, -0.6, 0.4, 1.4, 4.0][level as usize];
    VertebraValues {
        width: get(Dimension::EndplateWidth),
        depth: get(Dimension::EndplateDepth),
        height: get(Dimension::BodyHeight) + 0.5 * wedge,
        wedge,
        canal_width: get(Dimension::CanalWidth),
        canal_depth: get(Dimension::CanalDepth),
        pedicle_width: get(Dimension::PedicleWidth),
        pedicle_height: get(Dimension::PedicleHeight),
        spinous_reach: get(Dimension::SpinousReach),
        spinous_height: get(Dimension::SpinousHeight).max(8.0),
        spinous_half_width: values.spinous_half_width,
        transverse_span: get(Dimension::TransverseSpan),
        superior_x: beside(level),
        inferior_x: next - 6.5,
    }
}

/// The last thoracic vertebra, slightly smaller than L1 and with short transverse processes.
/// Estimated.
fn thoracic(first: &VertebraValues) -> VertebraValues {
    VertebraValues {
        width: 0.95 * first.width,
        height: 0.96 * first.height,
        transverse_span: 0.68 * first.transverse_span,
        spinous_reach: first.spinous_reach - 4.0,
        inferior_x: first.superior_x - 6.5,
        ..*first
    }
}

/// S1: the crest takes the place of a spinous process. Estimated.
fn sacral(last: &VertebraValues) -> VertebraValues {
    VertebraValues {
        height: 28.0,
        wedge: 0.0,
        depth: 0.92 * last.depth,
        canal_depth: 14.0,
        canal_width: 1.05 * last.canal_width,
        spinous_reach: 0.46 * last.depth + 14.0 + 15.0,
        spinous_height: 10.0,
        superior_x: last.inferior_x + 6.5,
        ..*last
    }
}

fn disc_angle(values: &BodyValues, above: usize) -> f64 {
    let standing = match above {
        0 => 2.0,
        _ => values.get(Dimension::DiscAngle, Level::ALL[above - 1]),
    };
    (standing - values.bend_deg).to_radians()
}

fn wedge_angle(vertebra: &VertebraValues) -> f64 {
    vertebra.wedge / vertebra.depth
}

/// Inclination of each bone; L3 is upright.
fn lean_all(values: &BodyValues, vertebrae: &[VertebraValues; COLUMN]) -> [f64; COLUMN] {
    let mut leans = [0.0; COLUMN];
    let between = |above: usize| {
        disc_angle(values, above) + 0.5 * (wedge_angle(&vertebrae[above]) + wedge_angle(&vertebrae[above + 1]))
    };
    for above in (0..3).rev() {
        leans[above] = leans[above + 1] + between(above);
    }
    for above in 3..SACRUM {
        leans[above + 1] = leans[above] - between(above);
    }
    leans
}

fn place_all(values: &BodyValues, vertebrae: &[VertebraValues; COLUMN], leans: &[f64; COLUMN]) -> [Place; COLUMN] {
    let up = |lean: f64| {
        let (sin, cos) = libm::sincos(lean);
        Place::new(0.0, cos, sin)
    };
    let step = |above: usize| {
        let disc = values.get(Dimension::DiscHeight, Level::ALL[above.saturating_sub(1)]).max(4.0);
        let disc = if above == 0 { 0.8 * disc } else { disc };
        up(leans[above]) * (0.5 * vertebrae[above].height)
            + up(leans[above + 1]) * (0.5 * vertebrae[above + 1].height)
            + up(0.5 * (leans[above] + leans[above + 1])) * disc
    };
    let mut middles = [Place::zeros(); COLUMN];
    for above in (0..3).rev() {
        middles[above] = middles[above + 1] + step(above);
    }
    for above in 3..SACRUM {
        middles[above + 1] = middles[above] - step(above);
    }
    middles
}

/// Heights of the five sacral bodies, half their widths and depths, and the inclination of each
/// against the one above, in degrees. Estimated from anatomical plates.
const SACRAL: [[f64; 4]; 5] = [
    [28.0, 25.0, 16.0, 0.0],
    [23.0, 20.0, 11.0, 8.0],
    [19.0, 17.0, 8.5, 12.0],
    [16.0, 14.0, 6.5, 16.0],
    [14.0, 10.0, 5.0, 18.0],
];

/// Poses of the five sacral bodies.
fn sacral_poses(first: &Pose) -> [Pose; 5] {
    let mut poses: [Pose; 5] = std::array::from_fn(|_| first.clone());
    let mut lean = lean_of(first);
    for at in 1..5 {
        lean += SACRAL[at][3].to_radians();
        let joint = poses[at - 1].to_outer(Place::new(0.0, -0.5 * SACRAL[at - 1][0], 0.0));
        let (sin, cos) = libm::sincos(lean);
        poses[at] = Pose::leaning(joint - Place::new(0.0, cos, sin) * (0.5 * SACRAL[at][0]), lean);
    }
    poses
}

fn build_sacrum(values: &VertebraValues, first: &Pose) -> Solid {
    let mut bone = Solid::default();
    let poses = sacral_poses(first);
    let half = Place::new(0.5 * values.width, 0.5 * values.height, 0.5 * values.depth);
    bone.add(Form::Drum { half, waist: 0.03, wedge: 0.0 }, first, 0.0);
    for (pose, [height, width, depth, _]) in poses.iter().zip(SACRAL).skip(1) {
        bone.add(Form::Slab { half: Place::new(width, 0.5 * height + 1.0, depth), rounding: 4.0 }, pose, 5.0);
    }
    for side in [-1.0, 1.0] {
        add_sacral_side(&mut bone, values, &poses, side);
    }
    add_sacral_back(&mut bone, values, &poses);
    bone
}

/// The ala, the lateral mass and the process that supports L5.
fn add_sacral_side(bone: &mut Solid, values: &VertebraValues, poses: &[Pose; 5], side: f64) {
    let at = |x: f64, y: f64, z: f64| Place::new(side * x, y, z);
    let wing = Form::Cone { from: at(22.0, 1.0, 4.0), to: at(42.0, -4.0, 8.0), from_radius: 13.0, to_radius: 13.5 };
    bone.add(wing, &poses[0], 7.0);
    let from = at(42.0, -6.0, 9.0);
    let to = poses[0].to_own(&poses[3].to_outer(at(17.0, 0.0, 3.0)));
    bone.add(Form::Cone { from, to, from_radius: 12.5, to_radius: 6.0 }, &poses[0], 7.0);
    let back = 0.5 * values.depth;
    let process = Form::Cone {
        from: at(values.superior_x, 0.5 * values.height + 4.0, back + 9.0),
        to: at(values.superior_x + 2.0, -8.0, back + 11.0),
        from_radius: 5.2,
        to_radius: 6.0,
    };
    bone.add(process, &poses[0], 4.0);
    // The foramina of the dorsal nerves.
    for (pose, [_, width, depth, _]) in poses.iter().zip(SACRAL).take(4) {
        let from = Place::new(side * 0.85 * width, -9.0, depth + 8.0);
        bone.cut(
            Form::Cone { from, to: from + Place::new(0.0, 0.0, 14.0), from_radius: 2.6, to_radius: 3.4 },
            pose,
            2.0,
        );
    }
}

/// The roof of the canal, the crest, and the canal.
fn add_sacral_back(bone: &mut Solid, values: &VertebraValues, poses: &[Pose; 5]) {
    let back = values.canal_back();
    for (at, [height, width, depth, _]) in SACRAL.into_iter().enumerate().take(4) {
        let roof = if at == 0 { back + 1.5 } else { depth + 9.0 - 2.0 * at as f64 };
        let lower = if at == 0 { -5.0 } else { 0.0 };
        let half = Place::new(0.85 * width, 0.5 * height + if at == 0 { -4.0 } else { 3.0 }, 4.5);
        let plate = Pose::leaning(poses[at].to_outer(Place::new(0.0, lower, roof)), lean_of(&poses[at]));
        bone.add(Form::Slab { half, rounding: 4.0 }, &plate, 7.0);
        let crest = Place::new(0.0, lower, roof);
        let tip = crest + Place::new(0.0, -3.0, if at == 0 { 10.0 } else { 7.5 });
        bone.add(Form::Cone { from: crest, to: tip, from_radius: 5.0, to_radius: 4.0 }, &poses[at], 5.0);
    }
    for side in [-1.0, 1.0] {
        let (from, to) = (Place::new(side * 30.0, -6.0, 12.0), Place::new(side * 15.0, -9.0, back + 1.0));
        bone.add(Form::Cone { from, to, from_radius: 9.0, to_radius: 6.0 }, &poses[0], 7.0);
    }
    let canal = Pose::leaning(poses[0].to_outer(Place::new(0.0, 0.0, values.canal_middle())), lean_of(&poses[0]));
    let entry = Form::Egg { half: Place::new(0.5 * values.canal_width, 52.0, 0.5 * values.canal_depth) };
    bone.cut(entry, &canal, 2.0);
}

/// Points on the crest of the ilium, and below each one on its wing, from posterior to anterior;
/// relative to S1, right side. Estimated.
const ILIUM: [[[f64; 3]; 2]; 7] = [
    [[47.0, -30.0, 38.0], [50.0, -52.0, 24.0]],
    [[59.0, 4.0, 37.0], [60.0, -46.0, 8.0]],
    [[76.0, 32.0, 20.0], [70.0, -46.0, -6.0]],
    [[95.0, 46.0, -6.0], [80.0, -48.0, -18.0]],
    [[110.0, 42.0, -36.0], [88.0, -50.0, -30.0]],
    [[118.0, 20.0, -64.0], [94.0, -48.0, -42.0]],
    [[116.0, -10.0, -82.0], [100.0, -44.0, -56.0]],
];
/// Inclination of the sacrum for which [`ILIUM`] is given, in rad: 38°.
const ILIUM_LEAN: f64 = -0.663;

/// An ilium.
pub(super) fn build_ilium(sacrum: &ColumnBone, side: BodySide, size: f64) -> Solid {
    let frame = Pose::leaning(sacrum.middle(), lean_of(&sacrum.pose) - ILIUM_LEAN);
    let place = |[x, y, z]: [f64; 3]| Place::new(side.sign() * x * size, y * size, z * size);
    let mut bone = Solid::default();
    for [one, next] in ILIUM.windows(2).map(|pair| [pair[0], pair[1]]) {
        let crest = Form::Cone { from: place(one[0]), to: place(next[0]), from_radius: 5.6, to_radius: 5.6 };
        bone.add(crest, &frame, 7.0);
        for share in [0.0, 0.33, 0.67] {
            let from = place(one[0]).lerp(&place(next[0]), share);
            let to = place(one[1]).lerp(&place(next[1]), share);
            bone.add(Form::Cone { from, to, from_radius: 4.5, to_radius: 5.5 }, &frame, 11.0);
        }
    }
    bone
}

/// One of the last two ribs, as points relative to T12, right side. Estimated.
pub(super) fn build_rib(thoracic: &ColumnBone, side: BodySide, eleventh: bool) -> Solid {
    const TWELFTH: [[f64; 3]; 4] = [[31.0, 0.0, 17.0], [50.0, -8.0, 24.0], [76.0, -26.0, 16.0], [98.0, -48.0, -4.0]];
    const ELEVENTH: [[f64; 3]; 5] =
        [[30.0, 30.0, 17.0], [52.0, 22.0, 25.0], [84.0, 2.0, 16.0], [106.0, -20.0, -12.0], [114.0, -36.0, -44.0]];
    let places: &[[f64; 3]] = if eleventh { &ELEVENTH } else { &TWELFTH };
    let frame = Pose::leaning(thoracic.middle(), 0.5 * lean_of(&thoracic.pose));
    let mut bone = Solid::default();
    for pair in places.windows(2) {
        let [from, to] = [pair[0], pair[1]].map(|[x, y, z]| Place::new(side.sign() * x, y, z));
        bone.add(Form::Cone { from, to, from_radius: 4.6, to_radius: 4.6 }, &frame, 4.0);
    }
    bone
}
