//! The picture inside the window: rendered into a texture of its own, since a window's surface is
//! not sRGB, and shown as an image. A background thread creates the renderer, which no page needs
//! before the first picture.

use std::panic::resume_unwind;
use std::thread::{self, JoinHandle};

use eframe::egui::{self, Response, Sense, TextureId, Ui, Vec2};
use eframe::egui_wgpu::RenderState;
use eframe::wgpu;
use render::camera::Camera;
use render::frame::{Frame, Stage};
use render::{Governor, Quality, Renderer, StageError};

/// Time budget of a frame at 60 Hz, in s.
const BUDGET_S: f32 = 1.0 / 60.0;
/// Time budget of a frame with software rendering, in s: ten frames a second still look like
/// motion.
const SOFTWARE_BUDGET_S: f32 = 0.1;

/// The picture and its renderer.
pub struct Canvas {
    state: RenderState,
    renderer: LazyRenderer,
    governor: Governor,
    shown: Option<Shown>,
}

/// A renderer that is being created, and the one that was.
struct LazyRenderer {
    creating: Option<JoinHandle<Renderer>>,
    created: Option<Renderer>,
}

impl LazyRenderer {
    fn create(state: &RenderState, quality: Quality) -> Self {
        let (device, queue) = (state.device.clone(), state.queue.clone());
        let creating = thread::spawn(move || Renderer::new(&device, &queue, [1, 1], quality));
        Self { creating: Some(creating), created: None }
    }

    /// Returns the renderer, once it has been created.
    #[expect(clippy::expect_used, reason = "one of the two is always there")]
    fn get(&mut self) -> &mut Renderer {
        if let Some(creating) = self.creating.take() {
            self.created = Some(creating.join().unwrap_or_else(|panic| resume_unwind(panic)));
        }
        self.created.as_mut().expect("it was created above or before")
    }
}

impl Drop for LazyRenderer {
    /// Waits for the renderer: a graphics driver may crash if the program ends while it works.
    fn drop(&mut self) {
        drop(self.creating.take().map(JoinHandle::join));
    }
}

/// The texture shown; the size is in pixels.
struct Shown {
    view: wgpu::TextureView,
    id: TextureId,
    size: [u32; 2],
}

impl Canvas {
    /// Renders with the window's own adapter.
    pub fn new(state: &RenderState) -> Self {
        let software = state.adapter.get_info().device_type == wgpu::DeviceType::Cpu;
        let (best, budget_s) = if software { (Quality::Medium, SOFTWARE_BUDGET_S) } else { (Quality::Full, BUDGET_S) };
        let governor = Governor::new(best, 1.05 * budget_s);
        let renderer = LazyRenderer::create(state, best);
        Self { state: state.clone(), renderer, governor, shown: None }
    }

    /// Sets the constant part of the following pictures.
    ///
    /// # Errors
    /// If it cannot be drawn.
    pub fn set_stage(&mut self, stage: &Stage) -> Result<(), StageError> {
        self.renderer.get().set_stage(stage)
    }

    /// Returns the current level of quality.
    pub fn quality(&self) -> Quality {
        self.governor.quality()
    }

    /// Returns the camera of a frame.
    pub fn camera(&mut self, frame: &Frame) -> Camera {
        self.renderer.get().camera(frame)
    }

    /// Draws a frame over all available space. The quality is lowered if frames take too long.
    pub fn show(&mut self, ui: &mut Ui, frame: &Frame) -> Response {
        let room = ui.available_size().max(Vec2::splat(1.0));
        self.governor.took(ui.input(|input| input.unstable_dt));
        let id = self.texture(pixels(room, ui.ctx().pixels_per_point()));
        if let Some(shown) = &self.shown {
            self.renderer.get().draw(frame, &shown.view);
        }
        ui.add(egui::Image::new((id, room)).sense(Sense::click_and_drag()))
    }

    /// Returns the texture for a size in pixels.
    fn texture(&mut self, size: [u32; 2]) -> TextureId {
        self.renderer.get().resize(size, self.governor.quality());
        if let Some(shown) = self.shown.as_ref().filter(|shown| shown.size == size) {
            return shown.id;
        }
        let view = texture(&self.state.device, size);
        let mut textures = self.state.renderer.write();
        let id = match self.shown.take() {
            Some(old) => {
                let (device, filter) = (&self.state.device, wgpu::FilterMode::Linear);
                textures.update_egui_texture_from_wgpu_texture(device, &view, filter, old.id);
                old.id
            }
            None => textures.register_native_texture(&self.state.device, &view, wgpu::FilterMode::Linear),
        };
        drop(textures);
        self.shown = Some(Shown { view, id, size });
        id
    }
}

impl Drop for Canvas {
    fn drop(&mut self) {
        if let Some(shown) = &self.shown {
            self.state.renderer.write().free_texture(&shown.id);
        }
    }
}

fn pixels(room: Vec2, pixels_per_point: f32) -> [u32; 2] {
    [room.x, room.y].map(|side| (side * pixels_per_point).round().max(1.0) as u32)
}

fn texture(device: &wgpu::Device, [width, height]: [u32; 2]) -> wgpu::TextureView {
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("picture"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: render::FORMAT,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    });
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}
