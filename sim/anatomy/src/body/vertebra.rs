//! A vertebra: body, pedicles, articular pillars, laminae, spinous and transverse processes.

use super::form::{Form, Place, Pose, Solid};

/// The dimensions of one vertebra, in mm.
#[derive(Clone, Copy, Debug)]
pub(super) struct VertebraValues {
    pub(super) width: f64,
    pub(super) depth: f64,
    pub(super) height: f64,
    /// Excess of the anterior over the posterior height of the body.
    pub(super) wedge: f64,
    pub(super) canal_width: f64,
    pub(super) canal_depth: f64,
    pub(super) pedicle_width: f64,
    pub(super) pedicle_height: f64,
    pub(super) spinous_reach: f64,
    pub(super) spinous_height: f64,
    pub(super) spinous_half_width: f64,
    pub(super) transverse_span: f64,
    /// Distance from the midline to the superior articular process.
    pub(super) superior_x: f64,
    /// Distance from the midline to the inferior articular process.
    pub(super) inferior_x: f64,
}

impl VertebraValues {
    /// Distance of the canal's middle behind the body's middle.
    pub(super) fn canal_middle(&self) -> f64 {
        0.5 * (self.depth + self.canal_depth)
    }

    /// Distance of the canal's posterior end behind the body's middle.
    pub(super) fn canal_back(&self) -> f64 {
        0.5 * self.depth + self.canal_depth
    }

    /// The middle of the spinous process, in its own frame.
    pub(super) fn spinous_middle(&self) -> Place {
        Place::new(0.0, -0.42 * self.height, 0.5 * (self.canal_back() + self.spinous_reach))
    }

    /// The middle of the spinous tip.
    pub(super) fn spinous_tip(&self) -> Place {
        Place::new(0.0, -0.5 * self.height, self.spinous_reach - 3.0)
    }
}

/// The bone, in a pose whose middle is that of the vertebral body.
pub(super) fn build_vertebra(values: &VertebraValues, pose: &Pose) -> Solid {
    let mut bone = Solid::default();
    let half = Place::new(0.5 * values.width, 0.5 * values.height, 0.5 * values.depth);
    bone.add(Form::Drum { half, waist: 0.09, wedge: values.wedge }, pose, 0.0);
    for side in [-1.0, 1.0] {
        add_pedicle(&mut bone, values, pose, side);
        add_pillar(&mut bone, values, pose, side);
        add_lamina(&mut bone, values, pose, side);
        add_transverse(&mut bone, values, pose, side);
    }
    add_spinous(&mut bone, values, pose);
    let canal = Pose::leaning(pose.to_outer(Place::new(0.0, 0.0, values.canal_middle())), lean_of(pose));
    bone.cut(canal_of(values), &canal, 1.5);
    bone
}

/// Inclination of a pose, in rad.
pub(super) fn lean_of(pose: &Pose) -> f64 {
    libm::atan2(pose.up().z, pose.up().y)
}

fn canal_of(values: &VertebraValues) -> Form {
    Form::Tube { half_x: 0.5 * values.canal_width, half_z: 0.5 * values.canal_depth }
}

fn add_pedicle(bone: &mut Solid, values: &VertebraValues, pose: &Pose, side: f64) {
    let x = 0.5 * (values.canal_width + values.pedicle_width) * 0.99;
    let up = 0.5 * (values.height - values.pedicle_height) - 0.5;
    let length = 0.5 * values.depth + 10.0 - (0.5 * values.depth - 7.0);
    let middle = Pose::leaning(pose.to_outer(Place::new(side * x, up, 0.5 * values.depth + 2.0)), lean_of(pose));
    let radius = 0.5 * values.pedicle_width;
    let tall = values.pedicle_height / values.pedicle_width;
    let end = Place::new(0.0, 0.0, 0.5 * length - 1.0);
    let form = Form::Cone { from: -end, to: end, from_radius: radius, to_radius: radius };
    bone.add_squeezed(form, &middle, 4.0, Place::new(1.0, tall, 1.0));
}

fn add_pillar(bone: &mut Solid, values: &VertebraValues, pose: &Pose, side: f64) {
    let back = 0.5 * values.depth;
    let superior = Place::new(side * values.superior_x, 0.5 * values.height + 5.0, back + 9.0);
    let neck = Place::new(side * 0.5 * (values.superior_x + values.inferior_x + 4.0), 0.0, back + 12.5);
    let inferior = Place::new(side * values.inferior_x, -0.5 * values.height - 6.0, back + 17.5);
    bone.add(Form::Cone { from: superior, to: neck, from_radius: 5.4, to_radius: 4.6 }, pose, 3.0);
    bone.add(Form::Cone { from: neck, to: inferior, from_radius: 4.6, to_radius: 5.2 }, pose, 3.0);
    // The mammillary process, on the back of the superior one.
    let mammillary = superior + Place::new(side * 2.5, -4.0, 4.0);
    bone.add(Form::Cone { from: mammillary, to: mammillary, from_radius: 3.4, to_radius: 3.4 }, pose, 3.0);
}

fn add_lamina(bone: &mut Solid, values: &VertebraValues, pose: &Pose, side: f64) {
    let outer = Place::new(side * (0.5 * values.canal_width + 1.0), -0.1 * values.height, 0.5 * values.depth + 11.0);
    let inner = Place::new(0.0, -0.28 * values.height, values.canal_back() + 3.0);
    let middle = pose.to_outer((outer + inner) * 0.5);
    let along = pose.to_outer(outer) - pose.to_outer(inner);
    // The lower edge lies farther back than the upper one.
    let up = pose.up() - pose.dorsal() * 0.3;
    let plate = Pose::along(middle, along, up);
    let half = Place::new(0.5 * along.norm() + 2.0, 0.38 * values.height, 3.1);
    bone.add(Form::Slab { half, rounding: 3.0 }, &plate, 4.5);
}

fn add_transverse(bone: &mut Solid, values: &VertebraValues, pose: &Pose, side: f64) {
    let root = 0.5 * values.canal_width + 0.8 * values.pedicle_width;
    let from = Place::new(side * root, 2.0, 0.5 * values.depth + 7.0);
    let to = Place::new(side * (0.5 * values.transverse_span - 3.2), 4.0, 0.5 * values.depth + 11.5);
    let middle = pose.to_outer((from + to) * 0.5);
    let blade = Pose::along(middle, pose.to_outer(to) - pose.to_outer(from), pose.up());
    let half = Place::new(0.5 * (to - from).norm(), 0.0, 0.0);
    let form = Form::Cone { from: -half, to: half, from_radius: 3.6, to_radius: 2.9 };
    bone.add_squeezed(form, &blade, 3.5, Place::new(1.0, 1.55, 0.9));
}

fn add_spinous(bone: &mut Solid, values: &VertebraValues, pose: &Pose) {
    let (root, tip) = (values.canal_back() + 1.0, values.spinous_reach);
    let slope = Pose::along(
        pose.to_outer(Place::new(0.0, -0.42 * values.height, 0.5 * (root + tip) - 1.5)),
        pose.to_outer(Place::x()) - pose.to_outer(Place::zeros()),
        pose.up() + pose.dorsal() * 0.1,
    );
    let half_width = 0.85 * values.spinous_half_width;
    let half = Place::new(half_width, 0.46 * values.spinous_height, 0.5 * (tip - root) - 1.5);
    bone.add(Form::Slab { half, rounding: (0.9 * half_width).min(2.6) }, &slope, 4.0);
    // The tip is thicker than the plate, and lower.
    let bulb = 1.25 * values.spinous_half_width;
    let reach = (0.5 * values.spinous_height - bulb).max(0.5);
    let end = values.spinous_tip() + Place::new(0.0, 0.0, 3.0 - bulb);
    let form = Form::Cone {
        from: end + Place::new(0.0, reach, -1.5),
        to: end - Place::new(0.0, reach, 0.0),
        from_radius: 0.8 * bulb,
        to_radius: bulb,
    };
    bone.add(form, pose, 2.5);
}
