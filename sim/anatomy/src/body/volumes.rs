//! The body as nested volumes of one substance each, for imaging.
//!
//! Volumes with the same parent are disjoint, up to the height of their triangles. Everything below the fascia is muscle unless it is listed. Left
//! out because they change a grey level by less than one: skin (counted as fat), ligaments, the lumbar arteries and the wall of the collecting
//! system. There is no bowel and no gas.

use nalgebra::{Point3, Vector3};

use super::form::{Bounds, Place};
use super::part::{AnatomyPart, BodySide, Level};
use super::surface::{BodyMesh, mesh_surface};
use super::{Body, BodyQuality, CLEAR, cell_mm};

/// What a volume consists of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Substance {
    /// Fat, 0.95 g/cm³.
    Adipose,
    /// Muscle, 1.05 g/cm³.
    Muscle,
    /// Ligament and cartilage, 1.06 g/cm³.
    SoftTissue,
    /// Kidney, 1.05 g/cm³.
    Kidney,
    /// Blood, 1.06 g/cm³.
    Blood,
    /// Urine and cerebrospinal fluid, 1.00 g/cm³.
    Water,
    /// Compact bone, 1.92 g/cm³.
    CorticalBone,
    /// Spongy bone with its marrow, 1.18 g/cm³.
    Spongiosa,
    /// Urine with contrast medium, 89 mg of iodine per ml, 1.09 g/cm³.
    ContrastMedium,
}

impl Substance {
    /// All.
    pub const ALL: [Self; 9] = [
        Self::Adipose,
        Self::Muscle,
        Self::SoftTissue,
        Self::Kidney,
        Self::Blood,
        Self::Water,
        Self::CorticalBone,
        Self::Spongiosa,
        Self::ContrastMedium,
    ];
}

/// A closed volume of one substance.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyVolume {
    /// Its name.
    pub name: String,
    /// The substance inside the surface and outside the children's surfaces.
    pub substance: Substance,
    /// Index of the volume around it; `None` in air. Parents precede their children.
    pub parent: Option<usize>,
    /// Its surface, in m.
    pub mesh: BodyMesh,
}

/// Contrast medium that was injected into a kidney.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contrast {
    /// The kidney's side.
    pub side: BodySide,
    /// Volume in ml.
    pub volume_ml: f64,
}

/// Gap between volumes with the same parent, in mm: their surfaces are made of triangles.
const GAP: f64 = 0.4;
/// Thickness of fat around a kidney, in mm. Recalled: 5 to 20 mm.
const PERIRENAL: f64 = 9.0;

/// Thickness of the wall of the pelvis, in mm. Recalled.
const PELVIS_WALL: f64 = 1.0;

/// Thickness of compact bone, in mm. Recalled: 0.4 mm in the body of a vertebra, 1 to 1.5 mm in its arch, 0.7 to 1 mm in a rib.
fn cortex(part: AnatomyPart) -> f64 {
    match part {
        AnatomyPart::Ilium(_) => 1.2,
        AnatomyPart::EleventhRib(_) | AnatomyPart::TwelfthRib(_) => 0.9,
        _ => 0.7,
    }
}

/// Edge of the cells in which the surface of the calyces is made, in mm.
const CALYCES_CELL: f64 = 0.6;
/// The same for contrast medium, which is made while an attempt waits.
const CONTRAST_CELL: f64 = 0.8;

fn calyces_name(side: BodySide) -> String {
    format!("calyces-{}", side.name())
}

/// A volume before its surface is made.
struct Shape<'b> {
    name: String,
    substance: Substance,
    parent: Option<usize>,
    distance: Box<dyn Fn(&Place) -> f64 + 'b>,
    bounds: Bounds,
    cell: f64,
}

/// Index of the muscle below the fascia among the volumes.
const INSIDE: usize = 1;

impl Body {
    /// The body as nested volumes, with contrast medium in a collecting system.
    #[must_use]
    pub fn list_volumes(&self, quality: BodyQuality, contrast: Option<Contrast>) -> Vec<BodyVolume> {
        let mut shapes = vec![self.part_shape(AnatomyPart::Skin, Substance::Adipose, None)];
        shapes.push(Shape {
            name: "muscle".to_owned(),
            distance: Box::new(|p| self.skin.fascia_distance(p)),
            ..self.part_shape(AnatomyPart::Skin, Substance::Muscle, Some(0))
        });
        self.push_bones(&mut shapes);
        for level in Level::ALL {
            shapes.push(self.part_shape(AnatomyPart::Disc(level), Substance::SoftTissue, Some(INSIDE)));
        }
        let canal = shapes.len();
        shapes.push(Shape {
            name: "canal".to_owned(),
            distance: Box::new(|p| self.off_column(self.canal.distance(p), p)),
            ..self.part_shape(AnatomyPart::EpiduralSpace, Substance::Adipose, Some(INSIDE))
        });
        shapes.push(Shape {
            distance: Box::new(|p| self.off_column(self.sac.distance(p), p)),
            ..self.part_shape(AnatomyPart::DuralSac, Substance::Water, Some(canal))
        });
        for vessel in [AnatomyPart::Aorta, AnatomyPart::VenaCava] {
            shapes.push(self.part_shape(vessel, Substance::Blood, Some(INSIDE)));
        }
        for side in BodySide::BOTH {
            self.push_kidney(&mut shapes, side);
        }
        let mut volumes: Vec<BodyVolume> = shapes.into_iter().map(|shape| self.volume(shape, quality)).collect();
        if let Some(contrast) = contrast {
            self.add_contrast(&mut volumes, quality, contrast);
        }
        volumes
    }

    /// Adds the contrast medium in a collecting system to the other volumes of the body.
    pub fn add_contrast(&self, volumes: &mut Vec<BodyVolume>, quality: BodyQuality, contrast: Contrast) {
        let Contrast { side, volume_ml } = contrast;
        let system = &self.systems[side as usize];
        let level = system.fluid_level(volume_ml);
        let fluid = calyces_name(side);
        let shape = Shape {
            name: format!("contrast-{}", side.name()),
            substance: Substance::ContrastMedium,
            parent: volumes.iter().position(|volume| volume.name == fluid),
            // The fluid is bounded by the kidney, too, which takes most of the time and is outside its wall almost everywhere.
            distance: Box::new(move |p| system.calyces_distance(p).max(p.z - level)),
            bounds: system.calyces_bounds(),
            cell: CONTRAST_CELL,
        };
        volumes.push(self.volume(shape, quality));
    }

    /// Adds a minor calyx to a kidney: the middle of its cup, in m, and the direction from there to its papilla, a unit vector.
    pub fn connect_calyx(&mut self, side: BodySide, cup_m: &Point3<f64>, papilla: &Vector3<f64>) {
        let cup = self.inner(cup_m);
        self.systems[side as usize].connect_calyx(cup, *papilla);
    }

    fn volume(&self, shape: Shape<'_>, quality: BodyQuality) -> BodyVolume {
        let mut mesh = mesh_surface(&*shape.distance, &shape.bounds, shape.cell * quality.cell_factor());
        mesh.vertices_m.iter_mut().for_each(|vertex| *vertex -= self.origin * 1e-3);
        BodyVolume { name: shape.name, substance: shape.substance, parent: shape.parent, mesh }
    }

    fn part_shape(&self, part: AnatomyPart, substance: Substance, parent: Option<usize>) -> Shape<'_> {
        Shape {
            name: part.name(),
            substance,
            parent,
            distance: Box::new(move |p| self.part_distance(part, p)),
            bounds: self.part_bounds(part),
            cell: cell_mm(part),
        }
    }

    /// Each bone as compact bone with spongy bone inside.
    fn push_bones<'b>(&'b self, shapes: &mut Vec<Shape<'b>>) {
        let bones = AnatomyPart::list().into_iter();
        for part in bones.filter(|part| part.kind() == Some(law::structures::StructureKind::Bone)) {
            let outside = shapes.len();
            shapes.push(self.part_shape(part, Substance::CorticalBone, Some(INSIDE)));
            let shell = cortex(part);
            shapes.push(Shape {
                name: format!("{}-inside", part.name()),
                distance: Box::new(move |p| self.part_distance(part, p) + shell),
                ..self.part_shape(part, Substance::Spongiosa, Some(outside))
            });
        }
    }

    /// Fat, kidney and collecting system of a side.
    fn push_kidney<'b>(&'b self, shapes: &mut Vec<Shape<'b>>, side: BodySide) {
        let part = AnatomyPart::Kidney(side);
        let bounds = self.part_bounds(part);
        let grown = Bounds::NOTHING.grown_by_ball(&bounds.least, PERIRENAL).grown_by_ball(&bounds.greatest, PERIRENAL);
        let fat = shapes.len();
        shapes.push(Shape {
            name: format!("perirenal-fat-{}", side.name()),
            distance: Box::new(move |p| self.perirenal_distance(side, p)),
            bounds: grown,
            cell: 2.0,
            ..self.part_shape(part, Substance::Adipose, Some(INSIDE))
        });
        shapes.push(Shape {
            distance: Box::new(move |p| self.kidney_distance(side, p)),
            cell: 2.4,
            ..self.part_shape(part, Substance::Kidney, Some(fat))
        });
        let system = &self.systems[side as usize];
        shapes.push(Shape {
            name: calyces_name(side),
            distance: Box::new(move |p| self.fluid_distance(side, p)),
            bounds: system.calyces_bounds(),
            cell: CALYCES_CELL,
            ..self.part_shape(part, Substance::Water, Some(fat + 1))
        });
        shapes.push(Shape {
            name: format!("ureter-{}", side.name()),
            distance: Box::new(move |p| self.ureter_distance(side, p)),
            bounds: system.ureter_bounds(),
            cell: 1.2,
            ..self.part_shape(part, Substance::Water, Some(INSIDE))
        });
    }

    /// Signed distance from the ureter, in mm, without the perirenal fat and the vessels.
    fn ureter_distance(&self, side: BodySide, p: &Place) -> f64 {
        let own = self.systems[side as usize].ureter_distance(p);
        if own > CLEAR {
            return own;
        }
        let vessels = self.vessels[..2].iter().map(|vessel| vessel.distance(p));
        vessels.chain([self.perirenal_distance(side, p)]).fold(own, |own, other| own.max(GAP - other))
    }

    /// Signed distance from the perirenal fat, in mm, without bones, discs, quadratus lumborum and vessels.
    fn perirenal_distance(&self, side: BodySide, p: &Place) -> f64 {
        let kidney = self.kidneys[side as usize].distance(p) - PERIRENAL;
        let own = kidney.min(self.systems[side as usize].calyces_distance(p) - 3.0);
        if own > CLEAR {
            return own;
        }
        let column = self.column.iter().map(|bone| bone.distance(p));
        let ribs = self.ribs.iter().flatten().map(|rib| rib.distance(p));
        let vessels = self.vessels[..2].iter().map(|vessel| vessel.distance(p));
        let discs = self.discs.iter().map(|disc| disc.distance(p));
        let others = column.chain(ribs).chain(vessels).chain(discs).chain([self.quadrati[side as usize].distance(p)]);
        let own = own.max(self.skin.fascia_distance(p) + GAP);
        others.fold(own, |own, other| own.max(GAP - other))
    }

    /// Signed distance from a kidney and the wall of its pelvis, in mm.
    fn kidney_distance(&self, side: BodySide, p: &Place) -> f64 {
        let wall = self.systems[side as usize].calyces_distance(p) - PELVIS_WALL;
        let own = self.kidneys[side as usize].distance(p).min(wall);
        if own > CLEAR { own } else { own.max(self.perirenal_distance(side, p) + GAP) }
    }

    /// Signed distance from the fluid in pelvis and calyces, in mm.
    fn fluid_distance(&self, side: BodySide, p: &Place) -> f64 {
        let own = self.systems[side as usize].calyces_distance(p);
        if own > CLEAR { own } else { own.max(self.kidney_distance(side, p) + GAP) }
    }
}
