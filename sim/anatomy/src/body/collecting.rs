//! The collecting system of a kidney: minor calyces, infundibula, pelvis and ureter.
//!
//! Drawn by the body's seed, in a sequence of its own. Recalled, not read: 7 to 9 minor calyces are usual (5 to 14 occur),
//! those of a pole are joined, the others stand in an anterior and a posterior row (Brödel). Two groups are the most
//! common (196 kidneys, Indian J Urol 2017;33:36, read by its abstract); three occur in a third.

use law::operator::Draw;
use nalgebra::Vector3;

use super::form::{Bounds, Form, Place, Pose, Solid};
use super::part::BodySide;
use super::patient::BodyValues;
use super::soft::{kidney_half, kidney_pose};
use super::spine::{COLUMN, ColumnBone, SACRUM};

/// Radius of a minor calyx at its cup, in mm. Recalled: 8 to 10 mm wide.
const CUP: f64 = 4.4;
/// Radii of an infundibulum at the group and at the cup, in mm. Recalled: 4 to 6 mm wide.
const INFUNDIBULUM: [f64; 2] = [2.8, 2.1];
/// Radius of the ureter, in mm: 4 to 7 mm thick.
const URETER: f64 = 2.4;
/// Distance of a cup from the kidney's middle, relative to its surface. The papilla and the cortex behind it are then 12
/// to 22 mm thick.
const CUP_AT: f64 = 0.6;

/// Edge of the blocks of samples that are skipped together, in mm.
const BLOCK: f64 = 5.0;

/// A collecting system.
#[derive(Clone, Debug)]
pub(super) struct CollectingSystem {
    /// Pelvis, infundibula and calyces.
    calyces: Solid,
    ureter: Solid,
    /// Where the infundibula of each group meet, in the body's inner frame, in mm.
    groups: Vec<Place>,
}

/// The kidney in which a system lies.
struct Host {
    pose: Pose,
    /// Half axes of the kidney, in mm.
    half: Place,
    side: BodySide,
}

impl Host {
    /// Converts a direction from the kidney's frame to the outer one.
    fn turn(&self, own: Place) -> Place {
        self.pose.to_outer(own) - self.pose.to_outer(Place::zeros())
    }
}

/// The collecting system of a kidney of a body.
pub(super) fn build_collecting_system(
    column: &[ColumnBone; COLUMN],
    values: &BodyValues,
    seed: u64,
    side: BodySide,
) -> CollectingSystem {
    let host = Host { pose: kidney_pose(column, side), half: kidney_half(values), side };
    let sacrum = &column[SACRUM];
    let brim = Place::new(side.sign() * 34.0, 16.0, -0.5 * sacrum.values.depth - 16.0);
    CollectingSystem::draw(&host, seed, sacrum.pose.to_outer(brim))
}

impl CollectingSystem {
    /// Draws the system of a kidney; the ureter ends at a place above the pelvic brim.
    fn draw(host: &Host, seed: u64, ureter_end: Place) -> Self {
        // A sequence of its own: earlier bodies keep their dimensions.
        let mut draw = Draw::new(seed ^ 0x0C01_1EC7 ^ u64::from(host.side == BodySide::Right) << 40);
        let medial = -host.side.sign();
        let groups: &[f64] = if draw.uniform() < 0.35 { &[0.5, 0.0, -0.5] } else { &[0.36, -0.36] };
        let [pelvis, outlet] = [Place::new(medial * 11.0, 0.0, -1.0), Place::new(medial * 27.0, -12.0, -4.0)];
        let mut system = Self { calyces: Solid::default(), ureter: Solid::default(), groups: Vec::new() };
        system.tube(&host.pose, [pelvis, outlet], [6.5, 3.0]);
        for level in groups {
            let group = Place::new(medial * 2.0 + draw.normal(0.8), level * host.half.y + draw.normal(1.0), 0.0);
            system.tube(&host.pose, [pelvis, group], [5.0, 3.0]);
            system.groups.push(host.pose.to_outer(group));
            for direction in list_directions(*level, groups.len(), &mut draw) {
                system.add_calyx(host, group, Place::new(-medial * direction.x, direction.y, direction.z));
            }
        }
        let start = host.pose.to_outer(outlet);
        let below = start.lerp(&ureter_end, 0.3) + Place::new(medial * 5.0, 0.0, -4.0);
        for [from, to] in [[start, below], [below, ureter_end]] {
            let form = Form::Cone { from, to, from_radius: URETER, to_radius: URETER };
            system.ureter.add(form, &Pose::leaning(Place::zeros(), 0.0), 1.0);
        }
        system
    }

    /// Adds a tube between two places of a frame.
    fn tube(&mut self, frame: &Pose, [from, to]: [Place; 2], [from_radius, to_radius]: [f64; 2]) {
        self.calyces.add(Form::Cone { from, to, from_radius, to_radius }, frame, 2.0);
    }

    /// Adds a calyx of a group in a direction of the kidney's frame, relative to the kidney's half axes.
    fn add_calyx(&mut self, host: &Host, group: Place, direction: Place) {
        let cup = direction.normalize().component_mul(&host.half) * CUP_AT;
        let axis = (cup - group).normalize();
        self.tube(&host.pose, [group, cup - axis * 0.5 * CUP], INFUNDIBULUM);
        self.add_cup(host.pose.to_outer(cup), host.turn(axis), host.turn(choose_up(axis)));
    }

    /// Adds a calyx with its cup at a place of the body's inner frame and its papilla in a direction from there, and joins it to the
    /// nearest group.
    pub(super) fn connect_calyx(&mut self, cup: Place, axis: Place) {
        let distance = |group: &&Place| (*group - cup).norm();
        let Some(group) = self.groups.iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).copied() else {
            return;
        };
        self.tube(&Pose::leaning(Place::zeros(), 0.0), [group, cup - axis * 0.5 * CUP], INFUNDIBULUM);
        self.add_cup(cup, axis, choose_up(axis));
    }

    /// Adds the cup of a calyx around a place, open in the direction of an axis.
    fn add_cup(&mut self, middle: Place, axis: Place, up: Place) {
        let pose = |along: f64| Pose::along(middle + axis * along, axis, up);
        self.calyces.add(Form::Egg { half: Place::new(0.8 * CUP, CUP, CUP) }, &pose(0.0), 1.5);
        // The papilla makes it hollow; the rim around it is the fornix.
        self.calyces.cut(Form::Egg { half: Place::new(0.8 * CUP, 0.75 * CUP, 0.75 * CUP) }, &pose(0.85 * CUP), 0.4);
    }

    /// Signed distance from pelvis and calyces, in mm.
    pub(super) fn calyces_distance(&self, p: &Place) -> f64 {
        self.calyces.distance(p)
    }

    pub(super) fn calyces_bounds(&self) -> Bounds {
        self.calyces.bounds()
    }

    /// Signed distance from the ureter, in mm.
    pub(super) fn ureter_distance(&self, p: &Place) -> f64 {
        self.ureter.distance(p)
    }

    pub(super) fn ureter_bounds(&self) -> Bounds {
        self.ureter.bounds()
    }

    /// Height of the surface of a denser fluid, in mm along z, for a volume in ml: pelvis and calyces of a prone patient fill
    /// from the front to the back. A balloon closes the ureter.
    pub(super) fn fluid_level(&self, volume_ml: f64) -> f64 {
        let Bounds { least, greatest } = self.calyces.bounds();
        let blocks = (greatest - least).map(|span| libm::ceil(span / BLOCK) as usize + 1);
        let corners = |counts: Vector3<usize>| {
            let rows = (0..counts.x).flat_map(move |x| (0..counts.y).map(move |y| [x, y]));
            rows.flat_map(move |[x, y]| (0..counts.z).map(move |z| Place::new(x as f64, y as f64, z as f64)))
        };
        // Half of a block's diagonal, times 1.3 for joined shapes, which are steeper than a distance.
        let reach = 0.5 * BLOCK * 1.733 * 1.3;
        let may_be_inside =
            |corner: &Place| self.calyces.distance(&(least + (corner * BLOCK).add_scalar(0.5 * (BLOCK - 1.0)))) < reach;
        let steps = Vector3::repeat(BLOCK as usize);
        let samples = corners(blocks)
            .filter(may_be_inside)
            .flat_map(|block| corners(steps).map(move |step| least + block * BLOCK + step));
        // A sample stands for a mm³.
        let mut heights: Vec<f64> = samples.filter(|p| self.calyces.distance(p) < 0.0).map(|p| p.z).collect();
        heights.sort_by(f64::total_cmp);
        heights.get((volume_ml * 1e3) as usize).copied().unwrap_or(f64::INFINITY)
    }
}

/// A coordinate axis that is not parallel to a direction.
fn choose_up(direction: Place) -> Place {
    if direction.y.abs() < 0.9 { Place::y() } else { Place::z() }
}

/// Directions of a group's minor calyces relative to the kidney's half axes: lateral, towards the upper pole, out of the back.
fn list_directions(level: f64, groups: usize, draw: &mut Draw) -> Vec<Place> {
    let pole = if level == 0.0 { 0.0 } else { level.signum() };
    let mut directions = Vec::new();
    if pole != 0.0 {
        // The joined calyces of the pole, and in some kidneys one more.
        directions.push(Place::new(0.3, pole * 0.95, 0.25));
        if draw.uniform() < 0.5 {
            directions.push(Place::new(-0.2, pole * 0.95, -0.3));
        }
    }
    let rows: &[f64] = if pole == 0.0 {
        &[0.0]
    } else if groups == 2 {
        &[0.2, 0.62]
    } else {
        &[0.6]
    };
    for (at, up) in rows.iter().enumerate() {
        let mut beside =
            |back: f64| Place::new(0.75, (if pole == 0.0 { *up } else { pole * up }) + draw.normal(0.04), back);
        let [posterior, anterior] = [beside(0.6), beside(-0.6)];
        // A second row is often single.
        match (at, draw.uniform()) {
            (1, chance) if chance < 0.35 => directions.push(posterior),
            (1, chance) if chance < 0.7 => directions.push(anterior),
            _ => directions.extend([posterior, anterior]),
        }
    }
    directions
}
