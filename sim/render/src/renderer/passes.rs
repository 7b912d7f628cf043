//! The passes of a frame, in order: field, shadows, image.

use std::ops::Range;

use wgpu::{
    BindGroup, CommandEncoder, LoadOp, Operations, RenderPass, RenderPassColorAttachment,
    RenderPassDepthStencilAttachment, RenderPassDescriptor, RenderPipeline, StoreOp, TextureView,
};

use super::Renderer;
use crate::frame::{Frame, View};
use crate::gpu::buffers::Loaded;
use crate::gpu::pipelines::Faces;
use crate::scene_block::casts;

/// Fade below which the body is drawn opaque.
const OPAQUE: f32 = 0.004;

fn colour_attachment<'a>(
    view: &'a TextureView,
    resolve_target: Option<&'a TextureView>,
) -> RenderPassColorAttachment<'a> {
    // Multisampled attachments are resolved and then discarded.
    let store = if resolve_target.is_some() { StoreOp::Discard } else { StoreOp::Store };
    RenderPassColorAttachment {
        view,
        depth_slice: None,
        resolve_target,
        ops: Operations { load: LoadOp::Clear(wgpu::Color::BLACK), store },
    }
}

/// Draws the displacements of every boundary under the frame's loads.
pub fn draw_field(renderer: &Renderer, encoder: &mut CommandEncoder) {
    let attachments = [Some(colour_attachment(&renderer.set.field, None))];
    let mut pass =
        encoder.begin_render_pass(&RenderPassDescriptor { color_attachments: &attachments, ..Default::default() });
    pass.set_pipeline(&renderer.fixed.superpose);
    pass.set_bind_group(0, &renderer.groups.superpose, &[]);
    pass.set_bind_group(1, &renderer.groups.responses, &[]);
    pass.draw(0..3, 0..1);
}

/// Draws the shadow map: the skin and the cut. The thin needle is omitted; its shadow is computed
/// in the shader.
pub fn draw_shadows(renderer: &Renderer, frame: &Frame, encoder: &mut CommandEncoder) {
    let mut pass = encoder.begin_render_pass(&RenderPassDescriptor {
        depth_stencil_attachment: Some(RenderPassDepthStencilAttachment {
            view: &renderer.targets.shadow,
            depth_ops: Some(Operations { load: LoadOp::Clear(1.0), store: StoreOp::Store }),
            stencil_ops: None,
        }),
        ..Default::default()
    });
    pass.set_bind_group(0, &renderer.groups.scene, &[]);
    // A body that is seen through also lets the light through.
    if casts(frame.fade) {
        pass.set_pipeline(&renderer.fixed.tissue_shadow);
        draw_section(renderer, frame, None, &mut pass);
        draw_walls(renderer, frame, &mut pass);
        for half in draw_body_halves(frame, 0..renderer.layers().min(1)) {
            renderer.body.0.draw_part(&mut pass, renderer.body.1.grid.clone(), half);
        }
    }
    if casts(frame.fade) && renderer.shows_patient(frame) {
        pass.set_pipeline(&renderer.fixed.patient_shadow);
        renderer.set.patient.draw(&mut pass);
    }
}

/// Draws the image.
pub fn draw_picture(renderer: &Renderer, frame: &Frame, onto: &TextureView, encoder: &mut CommandEncoder) {
    let targets = &renderer.targets;
    let attachment = match &targets.samples {
        Some(samples) => colour_attachment(samples, Some(onto)),
        None => colour_attachment(onto, None),
    };
    let mut pass = encoder.begin_render_pass(&RenderPassDescriptor {
        color_attachments: &[Some(attachment)],
        depth_stencil_attachment: Some(RenderPassDepthStencilAttachment {
            view: &targets.depth,
            depth_ops: Some(Operations { load: LoadOp::Clear(1.0), store: StoreOp::Discard }),
            stencil_ops: Some(Operations { load: LoadOp::Clear(0), store: StoreOp::Discard }),
        }),
        ..Default::default()
    });
    pass.set_bind_group(0, &renderer.groups.scene, &[]);
    pass.set_bind_group(1, &renderer.groups.materials, &[]);
    pass.set_stencil_reference(0);
    match frame.view {
        View::Section => draw_section_face(renderer, frame, &mut pass),
        View::Whole | View::Patient | View::Tip => body_and_needle(renderer, frame, &mut pass),
    }
    if frame.ghost.is_some() {
        for part in [&renderer.set.needle, &renderer.set.on_hub[0]] {
            draw_with_pipeline(&mut pass, &renderer.drawn.ghost, part);
        }
    }
    if frame.guide {
        draw_with_pipeline(&mut pass, &renderer.drawn.guide_hidden, &renderer.set.guide);
        draw_with_pipeline(&mut pass, &renderer.drawn.guide, &renderer.set.guide);
    }
}

fn draw_with_pipeline(pass: &mut RenderPass<'_>, pipeline: &RenderPipeline, what: &Loaded) {
    if !what.is_empty() {
        pass.set_pipeline(pipeline);
        what.draw(pass);
    }
}

fn body_and_needle(renderer: &Renderer, frame: &Frame, pass: &mut RenderPass<'_>) {
    let drawn = &renderer.drawn;
    let front = renderer.sees_the_cut(frame);
    let opaque = frame.fade < OPAQUE;
    if front && !frame.closed {
        draw_with_pipeline(pass, &drawn.solid_inside, &renderer.set.solids);
    }
    // The parts that hide most are drawn first, so that hidden fragments are not lit.
    if opaque {
        draw_body(renderer, frame, pass);
    }
    draw_with_pipeline(pass, &drawn.solid, &renderer.set.solids);
    draw_needle(renderer, frame, pass);
    if frame.view == View::Whole {
        draw_with_pipeline(pass, &drawn.tray, &renderer.tray);
    }
    if !opaque {
        match renderer.shows_patient(frame) {
            true => draw_with_pipeline(pass, &drawn.patient_inside, &renderer.set.patient),
            false => draw_with_pipeline(pass, &drawn.floor, &renderer.behind[1]),
        }
    }
    draw_backdrop(renderer, frame, pass);
    if !opaque {
        draw_faded_body(renderer, frame, front, pass);
    }
    draw_clear_parts(renderer, frame, pass);
}

/// Draws the needle, and the part on its hub.
fn draw_needle(renderer: &Renderer, frame: &Frame, pass: &mut RenderPass<'_>) {
    draw_with_pipeline(pass, &renderer.drawn.needle, &renderer.set.needle);
    if !frame.hub.open {
        draw_with_pipeline(pass, &renderer.drawn.needle, &renderer.set.on_hub[0]);
    }
}

/// Draws the transparent parts of the needle: a syringe's barrel, and drops.
fn draw_clear_parts(renderer: &Renderer, frame: &Frame, pass: &mut RenderPass<'_>) {
    if !frame.hub.open {
        draw_with_pipeline(pass, &renderer.drawn.glass, &renderer.set.on_hub[1]);
    }
    if frame.hub.drop > 0.0 {
        pass.set_pipeline(&renderer.drawn.drops);
        renderer.drop.draw_part(pass, renderer.drop.indices(), 0..2);
    }
}

/// Draws the drape, with shadow lookups only where shadows are possible, and the room.
fn draw_backdrop(renderer: &Renderer, frame: &Frame, pass: &mut RenderPass<'_>) {
    let (grid, shaded) = (&renderer.behind[0], renderer.shaded(frame));
    let Range { start, end } = grid.indices();
    pass.set_pipeline(&renderer.drawn.bright);
    grid.draw_part(pass, start..shaded.start, 0..1);
    grid.draw_part(pass, shaded.end..end, 0..1);
    pass.set_pipeline(&renderer.drawn.backdrop);
    grid.draw_part(pass, shaded, 0..1);
}

/// Instance offset of the parts in front of the cut; a body that is cut open has none.
const BEFORE: u32 = 16;

/// Instance ranges of a layer: behind the cut, and in front of it if the body is not cut open.
fn draw_body_halves(frame: &Frame, layers: Range<u32>) -> impl Iterator<Item = Range<u32>> {
    let before = frame.closed.then_some(layers.start + BEFORE..layers.end + BEFORE);
    std::iter::once(layers).chain(before)
}

/// Draws the opaque body: only the parts visible from outside.
fn draw_body(renderer: &Renderer, frame: &Frame, pass: &mut RenderPass<'_>) {
    let faces = &renderer.drawn.tissue;
    draw_section(renderer, frame, Some([&faces.tracked, &faces.face]), pass);
    pass.set_pipeline(&faces.face);
    draw_walls(renderer, frame, pass);
    draw_skin(renderer, frame, faces, pass);
    draw_patient(renderer, frame, &renderer.drawn.patient, pass);
}

/// Draws the skin, with puncture lookups only where punctures are possible.
fn draw_skin(renderer: &Renderer, frame: &Frame, faces: &Faces, pass: &mut RenderPass<'_>) {
    let (buffers, body) = &renderer.body;
    let parts = body.grid_within(renderer.wounds(frame)[0]);
    for (pipeline, part) in [&faces.punctured, &faces.skin].into_iter().zip(parts) {
        pass.set_pipeline(pipeline);
        for half in draw_body_halves(frame, 0..renderer.layers().min(1)) {
            buffers.draw_part(pass, part.clone(), half);
        }
    }
}

/// Draws the cut face, if there is one, with and without track lookups; or all of it with the
/// pipeline that is set.
fn draw_section(
    renderer: &Renderer,
    frame: &Frame,
    pipelines: Option<[&RenderPipeline; 2]>,
    pass: &mut RenderPass<'_>,
) {
    let (buffers, body) = &renderer.body;
    let layers = 0..if frame.closed { 0 } else { renderer.layers() };
    let Some([tracked, plain]) = pipelines else {
        return buffers.draw_part(pass, body.cut.clone(), layers);
    };
    let parts = body.cut_within(renderer.wounds(frame)[1]);
    for (pipeline, part) in [tracked, plain, plain].into_iter().zip(parts) {
        pass.set_pipeline(pipeline);
        buffers.draw_part(pass, part, layers.clone());
    }
}

/// Draws the parts of a whole patient around the block.
fn draw_patient(renderer: &Renderer, frame: &Frame, pipeline: &RenderPipeline, pass: &mut RenderPass<'_>) {
    if renderer.shows_patient(frame) {
        draw_with_pipeline(pass, pipeline, &renderer.set.patient);
    }
}

/// Draws the outer walls, if the body ends at them.
fn draw_walls(renderer: &Renderer, frame: &Frame, pass: &mut RenderPass<'_>) {
    if renderer.shows_patient(frame) {
        return;
    }
    let (buffers, body) = &renderer.body;
    for half in draw_body_halves(frame, 0..renderer.layers()) {
        buffers.draw_part(pass, body.outer.clone(), half);
    }
}

/// Draws back to front: seen from above the lowest boundary comes first, and the cut face last if
/// the camera is in front of it.
fn draw_faded_body(renderer: &Renderer, frame: &Frame, front: bool, pass: &mut RenderPass<'_>) {
    let (buffers, body) = &renderer.body;
    let (faces, layers) = (&renderer.drawn.faded, renderer.layers());
    let above = renderer.camera(frame).forward.z < 0.0;
    if !front {
        draw_section(renderer, frame, Some([&faces.tracked, &faces.face]), pass);
    }
    pass.set_pipeline(&faces.face);
    draw_walls(renderer, frame, pass);
    // Only the skin of a whole patient hides the inside.
    let layers = if renderer.shows_patient(frame) { layers.min(1) } else { layers };
    for step in 0..layers {
        let layer = if above { layers - 1 - step } else { step };
        if layer == 0 {
            draw_skin(renderer, frame, faces, pass);
            continue;
        }
        pass.set_pipeline(&renderer.drawn.sheet);
        for half in draw_body_halves(frame, layer..layer + 1) {
            buffers.draw_part(pass, body.grid.clone(), half);
        }
    }
    draw_patient(renderer, frame, &renderer.drawn.faded_patient, pass);
    if front {
        draw_section(renderer, frame, Some([&faces.tracked, &faces.face]), pass);
    }
}

/// Draws a section, which shows the inside without fading.
fn draw_section_face(renderer: &Renderer, frame: &Frame, pass: &mut RenderPass<'_>) {
    let drawn = &renderer.drawn;
    draw_with_pipeline(pass, &drawn.solid_inside, &renderer.set.solids);
    draw_with_pipeline(pass, &drawn.solid, &renderer.set.solids);
    draw_needle(renderer, frame, pass);
    draw_section(
        renderer,
        &Frame { closed: false, ..frame.clone() },
        Some([&drawn.tracked_section, &drawn.section]),
        pass,
    );
    draw_with_pipeline(pass, &drawn.paper, &renderer.behind[1]);
    draw_with_pipeline(pass, &drawn.solid_behind, &renderer.set.solids);
    draw_needle(renderer, frame, pass);
    draw_clear_parts(renderer, frame, pass);
}

/// Scales a smaller image up to the full one.
pub fn enlarge_picture(renderer: &Renderer, small: &BindGroup, onto: &TextureView, encoder: &mut CommandEncoder) {
    let attachments = [Some(colour_attachment(onto, None))];
    let mut pass =
        encoder.begin_render_pass(&RenderPassDescriptor { color_attachments: &attachments, ..Default::default() });
    pass.set_pipeline(&renderer.fixed.enlarge);
    pass.set_bind_group(0, small, &[]);
    pass.draw(0..3, 0..1);
}
