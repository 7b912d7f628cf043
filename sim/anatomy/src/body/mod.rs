//! A parametric lower back: bones, discs, ligaments, canal, muscles, organs, vessels and skin of
//! one patient.
//!
//! Each part is an implicit shape, a signed distance in mm composed of a few forms with rounded
//! seams. Of all ways to model a body this is the simplest that gives closed clean surfaces: a
//! union needs no mesh boolean, two bones are separated by one subtraction, one shape yields
//! triangles of any size, and the layers along a needle are evaluated on the shapes themselves,
//! without a mesh. The surfaces are made by surface nets, repaired to be manifold. Inside this
//! module lengths are in mm, as in morphometry; its public functions use m.
//!
//! The frame is that of a patient who is punctured: x to the patient's right, y towards the head, z
//! out of the back; the origin is on the skin, in the midline between the spinous processes of L3
//! and L4.

mod collecting;
mod entry;
mod form;
mod layers;
mod loft;
mod measure;
mod part;
mod patient;
mod published;
mod soft;
mod spine;
mod surface;
mod vertebra;
mod volumes;

use nalgebra::Point3;
use phrase::Phrase;

use collecting::{CollectingSystem, build_collecting_system};
pub use entry::BodyEntry;
use form::{Bounds, Form, Place, Pose, Solid};
pub use layers::{LayerOnPath, Tissue};
use loft::Loft;
pub use measure::{BodyMeasure, MidlinePath};
pub use part::{AnatomyPart, BodySide, Level};
pub use patient::{AGES_YEARS, BodyOrder, BodyValues, Posture, WEIGHTS_KG};
pub use published::{Dimension, PublishedDimension, Standing, list_published};
use soft::{SUPRASPINOUS, SkinShape};
use spine::{COLUMN, ColumnBone, SACRUM};
pub use surface::BodyMesh;
pub use volumes::{BodyVolume, Contrast, Substance};

/// Gap between two bones, in mm: at least cartilage.
const BONE_GAP: f64 = 1.6;

/// Distance outside a shape, in mm, beyond which no subtraction is needed.
const CLEAR: f64 = 5.0;

/// Resolution of the surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum BodyQuality {
    /// About a sixth of the triangles of the best, for software rendering and browsers.
    Low,
    /// About two fifths of the triangles of the best.
    Medium,
    /// At most 200 000 triangles in total.
    #[default]
    Best,
}

impl BodyQuality {
    /// All qualities.
    pub const ALL: [Self; 3] = [Self::Low, Self::Medium, Self::Best];

    fn cell_factor(self) -> f64 {
        match self {
            Self::Low => 2.4,
            Self::Medium => 1.6,
            Self::Best => 1.0,
        }
    }
}

/// A body.
#[derive(Clone, Debug)]
pub struct Body {
    order: BodyOrder,
    values: BodyValues,
    column: [ColumnBone; COLUMN],
    ilia: [Solid; 2],
    ribs: [[Solid; 2]; 2],
    canal: Loft,
    sac: Loft,
    skin: SkinShape,
    erectors: [Loft; 2],
    quadrati: [Loft; 2],
    kidneys: [Solid; 2],
    systems: [CollectingSystem; 2],
    vessels: [Solid; 3],
    supraspinous: Solid,
    discs: [Solid; 5],
    interspinous: [Solid; 5],
    origin: Place,
}

impl Body {
    /// Makes the body for some parameters. Equal parameters give identical bits.
    ///
    /// # Errors
    /// If a parameter is out of range.
    pub fn new(order: &BodyOrder) -> Result<Self, Phrase> {
        order.check()?;
        let values = BodyValues::draw(order);
        let column = spine::build_column(&values);
        let skin = SkinShape::new(&column, &values);
        let sides = BodySide::BOTH;
        let mut body = Self {
            order: *order,
            ilia: sides.map(|side| spine::build_ilium(&column[SACRUM], side, values.size)),
            ribs: [true, false].map(|eleventh| sides.map(|side| spine::build_rib(&column[0], side, eleventh))),
            canal: soft::build_canal(&column, &values, false),
            sac: soft::build_canal(&column, &values, true),
            erectors: sides.map(|side| soft::build_erector(&column, &skin, &values, side)),
            quadrati: sides.map(|side| soft::build_quadratus(&column, &values, side)),
            kidneys: sides.map(|side| soft::build_kidney(&column, &values, side)),
            systems: sides.map(|side| build_collecting_system(&column, &values, order.seed, side)),
            vessels: [
                soft::build_great_vessel(&column, -9.0, values.aorta_radius, 4),
                soft::build_great_vessel(&column, 14.0, 9.0, 5),
                soft::build_lumbar_vessels(&column),
            ],
            supraspinous: build_supraspinous(&column),
            discs: Level::ALL.map(|level| build_disc(&column, level)),
            interspinous: Level::ALL.map(|level| build_interspinous(&column, level)),
            skin,
            values,
            column,
            origin: Place::zeros(),
        };
        let between = (body.column[3].tip() + body.column[4].tip()) * 0.5;
        body.origin = Place::new(0.0, between.y, body.skin_depth(&between));
        Ok(body)
    }

    /// The parameters of the body.
    #[must_use]
    pub fn order(&self) -> &BodyOrder {
        &self.order
    }

    /// The dimensions of the body.
    #[must_use]
    pub fn values(&self) -> &BodyValues {
        &self.values
    }

    /// The closed surface of a part, in m.
    #[must_use]
    pub fn mesh(&self, part: AnatomyPart, quality: BodyQuality) -> BodyMesh {
        let cell = Self::cell_of(part, quality);
        let mut mesh = surface::mesh_surface(&|p| self.part_distance(part, p), &self.part_bounds(part), cell);
        for vertex in &mut mesh.vertices_m {
            *vertex -= self.origin * 1e-3;
        }
        mesh
    }

    /// Edge of a grid cell, in mm.
    fn cell_of(part: AnatomyPart, quality: BodyQuality) -> f64 {
        cell_mm(part) * quality.cell_factor()
    }

    /// Signed distance from a part's surface, in m; negative inside. Exceeds the true distance only
    /// slightly.
    #[must_use]
    pub fn distance_m(&self, part: AnatomyPart, place_m: &Point3<f64>) -> f64 {
        self.part_distance(part, &self.inner(place_m)) * 1e-3
    }

    fn inner(&self, place_m: &Point3<f64>) -> Place {
        place_m.coords * 1e3 + self.origin
    }

    /// Depth of the skin behind a point, in mm.
    fn skin_depth(&self, p: &Place) -> f64 {
        let (mut inside, mut outside) = (p.z, p.z + 400.0);
        for _ in 0..50 {
            let middle = 0.5 * (inside + outside);
            let within = self.skin.distance(&Place::new(p.x, p.y, middle)) < 0.0;
            *(if within { &mut inside } else { &mut outside }) = middle;
        }
        0.5 * (inside + outside)
    }

    fn part_distance(&self, part: AnatomyPart, p: &Place) -> f64 {
        match part {
            AnatomyPart::Skin => self.skin.distance(p),
            AnatomyPart::LastThoracic => self.bone_distance(0, p),
            AnatomyPart::Vertebra(level) => self.bone_distance(level as usize + 1, p),
            AnatomyPart::Sacrum => self.bone_distance(SACRUM, p),
            AnatomyPart::Ilium(side) => self.apart(self.ilia[side as usize].distance(p), &[5, SACRUM], p),
            AnatomyPart::EleventhRib(side) => self.apart(self.ribs[0][side as usize].distance(p), &[0, 1], p),
            AnatomyPart::TwelfthRib(side) => self.apart(self.ribs[1][side as usize].distance(p), &[0, 1], p),
            AnatomyPart::Disc(level) => self.beside_bones(self.discs[level as usize].distance(p), level, p),
            AnatomyPart::Supraspinous => {
                (0..COLUMN).fold(self.supraspinous.distance(p), |all, at| all.max(0.2 - self.column[at].distance(p)))
            }
            AnatomyPart::Interspinous(level) => {
                let own = self.interspinous[level as usize].distance(p);
                self.beside_bones(own.max(self.flavum_thickness(level) + 0.2 - self.canal.side(p)), level, p)
            }
            AnatomyPart::Flavum(level) => self.beside_bones(self.flavum_distance(level, p), level, p),
            AnatomyPart::EpiduralSpace => self.off_column(self.canal.distance(p).max(-self.sac.distance(p)), p),
            AnatomyPart::DuralSac => self.sac.distance(p),
            AnatomyPart::ErectorSpinae(side) => self.muscle_distance(&self.erectors[side as usize], p),
            AnatomyPart::Quadratus(side) => {
                let erector = self.erectors[side as usize].distance(p);
                self.muscle_distance(&self.quadrati[side as usize], p).max(0.5 - erector)
            }
            AnatomyPart::Kidney(side) => self.kidneys[side as usize].distance(p),
            AnatomyPart::Aorta => self.vessels[0].distance(p),
            AnatomyPart::VenaCava => self.vessels[1].distance(p).max(0.6 - self.vessels[0].distance(p)),
            AnatomyPart::LumbarVessels => self.vessels[2].distance(p),
        }
    }

    /// A bone of the column, with the one above subtracted.
    fn bone_distance(&self, at: usize, p: &Place) -> f64 {
        let own = self.column[at].distance(p);
        match at {
            0 => own,
            _ => self.apart(own, &[at - 1], p),
        }
    }

    /// A bone, with other bones of the column subtracted.
    fn apart(&self, own: f64, others: &[usize], p: &Place) -> f64 {
        if own > CLEAR {
            return own;
        }
        others.iter().fold(own, |own, other| own.max(BONE_GAP - self.column[*other].distance(p)))
    }

    /// Soft tissue, with the bones of the column subtracted.
    fn off_column(&self, own: f64, p: &Place) -> f64 {
        if own > CLEAR {
            return own;
        }
        self.column.iter().fold(own, |own, bone| own.max(0.2 - bone.distance(p)))
    }

    /// Soft tissue of an interspace, with the two adjacent bones subtracted.
    fn beside_bones(&self, own: f64, level: Level, p: &Place) -> f64 {
        if own > CLEAR {
            return own;
        }
        let above = level as usize + 1;
        [above, above + 1].into_iter().fold(own, |own, at| own.max(0.2 - self.column[at].distance(p)))
    }

    fn flavum_thickness(&self, level: Level) -> f64 {
        self.values.get(Dimension::FlavumThickness, level)
    }

    /// The flavum lines the back of the canal from lamina to lamina.
    fn flavum_distance(&self, level: Level, p: &Place) -> f64 {
        let wall = self.canal.side(p);
        let above = &self.column[level as usize + 1];
        let below = &self.column[level as usize + 2];
        let at = |bone: &ColumnBone, up: f64| bone.pose.to_outer(Place::new(0.0, up, bone.values.canal_back()));
        let (high, low) = (at(above, -0.45 * above.values.height), at(below, -0.05 * below.values.height));
        let section = self.canal.at(p.y);
        let behind = section.middle.z + 0.15 * section.half_z - p.z;
        let ends = (low.y - p.y).max(p.y - high.y);
        (wall - self.flavum_thickness(level)).max(-wall).max(behind).max(ends)
    }

    fn muscle_distance(&self, muscle: &Loft, p: &Place) -> f64 {
        let own = muscle.distance(p);
        if own > CLEAR {
            return own;
        }
        let bones = (0..COLUMN).map(|at| self.column[at].distance(p));
        let others = self.ilia.iter().chain(self.ribs.iter().flatten()).map(|bone| bone.distance(p));
        // Covered by fat and skin everywhere.
        let own = own.max(self.skin.distance(p) + 4.0);
        let midline = self.supraspinous.distance(p).min(p.x.abs() - 3.5);
        bones.chain(others).chain([midline]).fold(own, |own, other| own.max(0.4 - other))
    }

    fn part_bounds(&self, part: AnatomyPart) -> Bounds {
        match part {
            AnatomyPart::Skin => loft_bounds(self.skin.trunk()),
            AnatomyPart::LastThoracic => self.column[0].bounds(),
            AnatomyPart::Vertebra(level) => self.column[level as usize + 1].bounds(),
            AnatomyPart::Sacrum => self.column[SACRUM].bounds(),
            AnatomyPart::Ilium(side) => self.ilia[side as usize].bounds(),
            AnatomyPart::EleventhRib(side) => self.ribs[0][side as usize].bounds(),
            AnatomyPart::TwelfthRib(side) => self.ribs[1][side as usize].bounds(),
            AnatomyPart::Disc(level) => self.discs[level as usize].bounds(),
            AnatomyPart::Supraspinous => self.supraspinous.bounds(),
            AnatomyPart::Interspinous(level) => self.interspinous[level as usize].bounds(),
            AnatomyPart::Flavum(level) => {
                let middle =
                    self.column[level as usize + 1].middle().lerp(&self.column[level as usize + 2].middle(), 0.5);
                Bounds::NOTHING.grown_by_ball(&(middle + Place::new(0.0, 0.0, 26.0)), 32.0)
            }
            AnatomyPart::EpiduralSpace => loft_bounds(&self.canal),
            AnatomyPart::DuralSac => loft_bounds(&self.sac),
            AnatomyPart::ErectorSpinae(side) => loft_bounds(&self.erectors[side as usize]),
            AnatomyPart::Quadratus(side) => loft_bounds(&self.quadrati[side as usize]),
            AnatomyPart::Kidney(side) => self.kidneys[side as usize].bounds(),
            AnatomyPart::Aorta => self.vessels[0].bounds(),
            AnatomyPart::VenaCava => self.vessels[1].bounds(),
            AnatomyPart::LumbarVessels => self.vessels[2].bounds(),
        }
    }
}

fn loft_bounds(loft: &Loft) -> Bounds {
    let [low, high] = loft.ends();
    (0..=40).fold(Bounds::NOTHING, |bounds, step| {
        let section = loft.at(low + (high - low) * f64::from(step) / 40.0);
        let reach = Place::new(section.half_x, 0.0, section.half_z);
        bounds.grown_by_ball(&(section.middle - reach), 4.0).grown_by_ball(&(section.middle + reach), 4.0)
    })
}

/// Edge of a grid cell at the best quality, in mm.
fn cell_mm(part: AnatomyPart) -> f64 {
    match part {
        AnatomyPart::Skin => 9.0,
        AnatomyPart::ErectorSpinae(_) | AnatomyPart::Kidney(_) => 5.0,
        AnatomyPart::Quadratus(_) | AnatomyPart::Aorta | AnatomyPart::VenaCava => 3.0,
        AnatomyPart::Ilium(_) => 3.6,
        AnatomyPart::EleventhRib(_) | AnatomyPart::TwelfthRib(_) | AnatomyPart::Sacrum => 2.6,
        AnatomyPart::Disc(_) | AnatomyPart::EpiduralSpace | AnatomyPart::DuralSac => 2.7,
        AnatomyPart::Vertebra(_) | AnatomyPart::LastThoracic => 2.1,
        AnatomyPart::Supraspinous => 1.5,
        AnatomyPart::Flavum(_) | AnatomyPart::Interspinous(_) => 1.1,
        AnatomyPart::LumbarVessels => 1.1,
    }
}

/// From T12 to L5: the ligament seldom extends farther.
fn build_supraspinous(column: &[ColumnBone; COLUMN]) -> Solid {
    let mut ligament = Solid::default();
    let frame = Pose::leaning(Place::zeros(), 0.0);
    let behind = Place::new(0.0, 0.0, 0.5 * SUPRASPINOUS);
    for pair in column[..SACRUM].windows(2) {
        let [from, to] = [&pair[0], &pair[1]].map(|bone| bone.tip() + behind);
        let radius = 0.5 * SUPRASPINOUS;
        ligament.add(Form::Cone { from, to, from_radius: radius, to_radius: radius }, &frame, 1.0);
    }
    ligament
}

fn build_disc(column: &[ColumnBone; COLUMN], level: Level) -> Solid {
    let (above, below) = (&column[level as usize + 1], &column[level as usize + 2]);
    let at = |bone: &ColumnBone, share: f64| bone.pose.to_outer(Place::new(0.0, share * bone.values.height, 0.0));
    let (high, low) = (at(above, -0.5), at(below, 0.5));
    let lean = 0.5 * (vertebra::lean_of(&above.pose) + vertebra::lean_of(&below.pose));
    let half = Place::new(
        0.25 * (above.values.width + below.values.width) + 0.4,
        0.5 * (high - low).norm() + 5.0,
        0.25 * (above.values.depth + below.values.depth) + 0.2,
    );
    let mut disc = Solid::default();
    disc.add(Form::Drum { half, waist: 0.0, wedge: 0.0 }, &Pose::leaning((high + low) * 0.5, lean), 0.0);
    disc
}

fn build_interspinous(column: &[ColumnBone; COLUMN], level: Level) -> Solid {
    let (above, below) = (&column[level as usize + 1], &column[level as usize + 2]);
    let [high, low] = [above, below].map(|bone| bone.pose.to_outer(bone.values.spinous_middle()));
    let length = |bone: &ColumnBone| bone.values.spinous_reach - bone.values.canal_back();
    let pose = Pose::along((high + low) * 0.5, Place::x(), high - low);
    let half = Place::new(2.2, 0.5 * (high - low).norm(), 0.25 * (length(above) + length(below)) + 1.0);
    let mut ligament = Solid::default();
    ligament.add(Form::Slab { half, rounding: 1.5 }, &pose, 0.0);
    ligament
}
