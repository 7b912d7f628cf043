//! The body as nested volumes of one substance each, for imaging.
//!
//! Volumes with the same parent are disjoint: a later one is cut by those that it could touch. Left out because they change
//! a grey level by less than one: skin (counted as fat), the lumbar arteries and the wall of the collecting system. There is no
//! bowel and no gas: the wall of the abdomen and its content are one volume of muscle.

use std::rc::Rc;

use super::form::{Bounds, Place};
use super::part::{AnatomyPart, BodySide, Level};
use super::surface::{BodyMesh, mesh_surface};
use super::{Body, BodyQuality, CLEAR, cell_mm, loft_bounds};

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
    /// Urine with contrast medium, 90 mg of iodine per ml, 1.09 g/cm³.
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
    /// What is inside, except in its children.
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

/// Thickness of compact bone, in mm. Recalled: 0.4 mm in the body of a vertebra, 1 to 1.5 mm in its arch, 0.7 to 1 mm in a rib.
fn cortex(part: AnatomyPart) -> f64 {
    match part {
        AnatomyPart::Ilium(_) => 1.2,
        AnatomyPart::EleventhRib(_) | AnatomyPart::TwelfthRib(_) => 0.9,
        _ => 0.7,
    }
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

impl Body {
    /// The body as nested volumes, with contrast medium in a collecting system.
    #[must_use]
    pub fn list_volumes(&self, quality: BodyQuality, contrast: Option<Contrast>) -> Vec<BodyVolume> {
        let mut shapes: Vec<Shape<'_>> = Vec::new();
        let trunk = self.part_shape(AnatomyPart::Skin, Substance::Adipose, None);
        let trunk_bounds = trunk.bounds;
        shapes.push(trunk);
        let muscles = Rc::new(Wall::new(self));
        let wall = shapes.len();
        let around = Rc::clone(&muscles);
        shapes.push(Shape {
            name: "abdomen".to_owned(),
            substance: Substance::Muscle,
            parent: Some(0),
            distance: Box::new(move |p| around.distance(p)),
            bounds: trunk_bounds,
            cell: 5.0,
        });
        self.push_bones(&mut shapes);
        for (part, substance) in list_soft() {
            shapes.push(self.part_shape(part, substance, Some(0)));
        }
        for vessel in [AnatomyPart::Aorta, AnatomyPart::VenaCava] {
            let own = self.part_shape(vessel, Substance::Blood, Some(wall));
            let around = Rc::clone(&muscles);
            let distance = Box::new(move |p: &Place| around.clip((own.distance)(p), p));
            shapes.push(Shape { distance, ..self.part_shape(vessel, Substance::Blood, Some(wall)) });
        }
        for side in BodySide::BOTH {
            let filled = contrast.filter(|contrast| contrast.side == side).map(|contrast| contrast.volume_ml);
            let kidney = KidneyInWall { body: self, side, wall: Rc::clone(&muscles) };
            self.push_kidney(&mut shapes, &kidney, wall, filled);
        }
        shapes.into_iter().map(|shape| self.volume(shape, quality)).collect()
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
            shapes.push(self.part_shape(part, Substance::CorticalBone, Some(0)));
            let shell = cortex(part);
            shapes.push(Shape {
                name: format!("{}-inside", part.name()),
                distance: Box::new(move |p| self.part_distance(part, p) + shell),
                ..self.part_shape(part, Substance::Spongiosa, Some(outside))
            });
        }
    }

    /// Fat, kidney and collecting system of a side, within a wall of an index.
    fn push_kidney<'b>(
        &'b self,
        shapes: &mut Vec<Shape<'b>>,
        kidney: &KidneyInWall<'b>,
        wall: usize,
        contrast_ml: Option<f64>,
    ) {
        let part = AnatomyPart::Kidney(kidney.side);
        let (side, bounds) = (kidney.side.name(), self.part_bounds(part));
        let grown = Bounds::NOTHING.grown_by_ball(&bounds.least, PERIRENAL).grown_by_ball(&bounds.greatest, PERIRENAL);
        let fat = shapes.len();
        let own = kidney.clone();
        shapes.push(Shape {
            name: format!("perirenal-fat-{side}"),
            distance: Box::new(move |p| own.fat_distance(p)),
            bounds: grown,
            cell: 3.0,
            ..self.part_shape(part, Substance::Adipose, Some(wall))
        });
        let own = kidney.clone();
        shapes.push(Shape {
            distance: Box::new(move |p| own.distance(p)),
            cell: 2.4,
            ..self.part_shape(part, Substance::Kidney, Some(fat))
        });
        let system = &self.systems[kidney.side as usize];
        let fluid = shapes.len();
        let own = kidney.clone();
        shapes.push(Shape {
            name: format!("collecting-system-{side}"),
            distance: Box::new(move |p| own.wall.clip(system.distance(p), p)),
            bounds: system.bounds(),
            cell: 1.2,
            ..self.part_shape(part, Substance::Water, Some(wall))
        });
        if let Some(volume_ml) = contrast_ml {
            let (level, own) = (system.fluid_level(volume_ml), kidney.clone());
            shapes.push(Shape {
                name: format!("contrast-{side}"),
                distance: Box::new(move |p| own.wall.clip((system.calyces_distance(p) + 0.1).max(p.z - level), p)),
                bounds: system.bounds(),
                cell: 1.0,
                ..self.part_shape(part, Substance::ContrastMedium, Some(fluid))
            });
        }
    }
}

/// A kidney between the muscles.
#[derive(Clone)]
struct KidneyInWall<'b> {
    body: &'b Body,
    side: BodySide,
    wall: Rc<Wall<'b>>,
}

impl KidneyInWall<'_> {
    /// Signed distance from the fat around it, in mm: beside vessels and collecting system.
    fn fat_distance(&self, p: &Place) -> f64 {
        let own = self.body.kidneys[self.side as usize].distance(p) - PERIRENAL;
        if own > CLEAR {
            return own;
        }
        let vessels = self.body.vessels[..2].iter().map(|vessel| vessel.distance(p)).fold(f64::INFINITY, f64::min);
        let beside = own.max(GAP - vessels).max(0.5 * GAP - self.body.systems[self.side as usize].distance(p));
        self.wall.clip(beside, p)
    }

    /// Signed distance from the kidney's tissue, in mm.
    fn distance(&self, p: &Place) -> f64 {
        let own = self.body.kidneys[self.side as usize].distance(p);
        if own > CLEAR { own } else { own.max(self.fat_distance(p) + GAP) }
    }
}

/// The muscles around the abdomen and its content: inside the fat under the skin, outside the column, the ribs, the pelvis and
/// the muscles of the back.
struct Wall<'b> {
    body: &'b Body,
    /// What it does not enter, each with a bounding box.
    others: Vec<(Bounds, Box<dyn Fn(&Place) -> f64 + 'b>)>,
}

impl<'b> Wall<'b> {
    fn new(body: &'b Body) -> Self {
        let mut wall = Self { body, others: Vec::new() };
        for bone in &body.column {
            wall.others.push((bone.bounds(), Box::new(|p| bone.distance(p))));
        }
        let solids = body.ilia.iter().chain(body.ribs.iter().flatten()).chain(&body.discs).chain(&body.interspinous);
        for solid in solids.chain([&body.supraspinous]) {
            wall.others.push((solid.bounds(), Box::new(|p| solid.distance(p))));
        }
        for muscle in body.erectors.iter().chain(&body.quadrati) {
            wall.others.push((loft_bounds(muscle), Box::new(|p| muscle.distance(p))));
        }
        let flavum = body.flavum_thickness(Level::L3) + 1.0;
        let canal = loft_bounds(&body.canal);
        let canal = Bounds::NOTHING.grown_by_ball(&canal.least, flavum).grown_by_ball(&canal.greatest, flavum);
        wall.others.push((canal, Box::new(move |p| body.canal.distance(p) - flavum)));
        wall
    }

    /// Limits a shape to the inside of the wall.
    fn clip(&self, own: f64, p: &Place) -> f64 {
        if own > CLEAR { own } else { own.max(self.distance(p) + GAP) }
    }

    /// Signed distance, in mm.
    fn distance(&self, p: &Place) -> f64 {
        let own = self.body.skin.distance(p) + self.body.values.lateral_fat;
        self.others.iter().fold(own, |own, (bounds, other)| {
            // A neighbour that is farther away than the surface itself changes nothing.
            let least = bounds.distance(p);
            if GAP - least <= own.max(-2.0 * CLEAR) { own } else { own.max(GAP - other(p)) }
        })
    }
}

/// The soft parts of the back with their substances.
fn list_soft() -> Vec<(AnatomyPart, Substance)> {
    let at_levels = [AnatomyPart::Disc, AnatomyPart::Interspinous, AnatomyPart::Flavum];
    let ligaments = at_levels.into_iter().flat_map(|part: fn(Level) -> AnatomyPart| Level::ALL.map(part));
    let at_sides = [AnatomyPart::ErectorSpinae, AnatomyPart::Quadratus];
    let muscles = at_sides.into_iter().flat_map(|part: fn(BodySide) -> AnatomyPart| BodySide::BOTH.map(part));
    let mut soft: Vec<_> = ligaments.map(|part| (part, Substance::SoftTissue)).collect();
    soft.push((AnatomyPart::Supraspinous, Substance::SoftTissue));
    soft.push((AnatomyPart::DuralSac, Substance::Water));
    soft.extend(muscles.map(|part| (part, Substance::Muscle)));
    soft
}
