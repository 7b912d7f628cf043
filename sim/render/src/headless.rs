//! Renders images without a window, on a graphics adapter opened here; a software adapter is
//! sufficient.

use image::RgbaImage;
use wgpu::{
    Adapter, Buffer, BufferDescriptor, BufferUsages, Device, MapMode, PollType, Queue, TexelCopyBufferInfo,
    TexelCopyBufferLayout, Texture, TextureUsages,
};

use crate::adapters::{self, AdapterError, AdapterName, OpenAdapter};
use crate::frame::{Frame, Stage};
use crate::gpu::textures::{TexturePlan, view};
use crate::quality::Quality;
use crate::renderer::{Renderer, StageError};

/// Why an image cannot be rendered.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// No graphics adapter can be opened.
    #[error(transparent)]
    Adapter(#[from] AdapterError),
    /// The stage cannot be drawn.
    #[error(transparent)]
    Stage(#[from] StageError),
    /// The adapter cannot render an image of this size.
    #[error("{width} × {height} pixels; allowed on this adapter: 1 to {most}")]
    Size {
        /// Requested width, in pixels.
        width: u32,
        /// Requested height, in pixels.
        height: u32,
        /// Maximum width and height, in pixels.
        most: u32,
    },
    /// The image could not be read back from the adapter.
    #[error("the graphics adapter did not return the picture: {0}")]
    Lost(String),
}

/// A graphics adapter with its renderer.
pub struct Headless {
    adapter: Adapter,
    device: Device,
    queue: Queue,
    renderer: Renderer,
    picture: Option<CardPicture>,
}

/// An image on the adapter, and the buffer from which it is read.
struct CardPicture {
    texture: Texture,
    bytes: Buffer,
    size: [u32; 2],
}

impl Headless {
    /// Opens the best adapter that can be opened: hardware before software, Vulkan before GL.
    /// `WGPU_BACKEND` selects a graphics API.
    ///
    /// # Errors
    /// If there is no adapter, or none can be opened.
    pub fn new(quality: Quality) -> Result<Self, PictureError> {
        let OpenAdapter { adapter, device, queue } = adapters::open_best()?;
        let renderer = Renderer::new(&device, &queue, [1, 1], quality);
        Ok(Self { adapter, device, queue, renderer, picture: None })
    }

    /// Identity of the adapter.
    #[must_use]
    pub fn adapter(&self) -> AdapterName {
        adapters::named(&self.adapter)
    }

    /// Sets the quality of subsequent images.
    pub fn set_quality(&mut self, quality: Quality) {
        self.renderer.resize(self.renderer.size(), quality);
    }

    /// The renderer, for its camera and its number of triangles.
    #[must_use]
    pub fn renderer(&self) -> &Renderer {
        &self.renderer
    }

    /// Renders one image of a stage, of a size in pixels.
    ///
    /// # Errors
    /// If the stage or the size cannot be rendered, or the adapter fails.
    pub fn picture(&mut self, stage: &Stage, frame: &Frame, size: [u32; 2]) -> Result<RgbaImage, PictureError> {
        self.set_stage(stage)?;
        self.next(frame, size)
    }

    /// Sets the stage for subsequent images.
    ///
    /// # Errors
    /// If it cannot be rendered.
    pub fn set_stage(&mut self, stage: &Stage) -> Result<(), PictureError> {
        Ok(self.renderer.set_stage(stage)?)
    }

    /// Renders the next image of the stage, of a size in pixels.
    ///
    /// # Errors
    /// If the size cannot be rendered, or the adapter fails.
    pub fn next(&mut self, frame: &Frame, size: [u32; 2]) -> Result<RgbaImage, PictureError> {
        self.draw(frame, size)?;
        self.read()
    }

    /// Renders without reading the image, and waits for completion, as a window would.
    ///
    /// # Errors
    /// If the size cannot be rendered, or the adapter fails.
    pub fn draw(&mut self, frame: &Frame, size: [u32; 2]) -> Result<(), PictureError> {
        self.sized(size)?;
        if let Some(canvas) = &self.picture {
            self.renderer.draw(frame, &view(&canvas.texture));
        }
        self.wait()
    }

    fn wait(&self) -> Result<(), PictureError> {
        self.device.poll(PollType::wait_indefinitely()).map(drop).map_err(|error| PictureError::Lost(error.to_string()))
    }

    fn sized(&mut self, size: [u32; 2]) -> Result<(), PictureError> {
        let most = self.device.limits().max_texture_dimension_2d;
        if size.iter().any(|side| *side < 1 || *side > most) {
            return Err(PictureError::Size { width: size[0], height: size[1], most });
        }
        if self.picture.as_ref().is_none_or(|canvas| canvas.size != size) {
            self.renderer.resize(size, self.renderer.quality());
            self.picture = Some(CardPicture::new(&self.device, size));
        }
        Ok(())
    }

    fn read(&self) -> Result<RgbaImage, PictureError> {
        let lost = |why: &dyn ToString| PictureError::Lost(why.to_string());
        let Some(canvas) = &self.picture else { return Err(lost(&"nothing was drawn")) };
        let mut encoder = self.device.create_command_encoder(&Default::default());
        encoder.copy_texture_to_buffer(canvas.texture.as_image_copy(), canvas.destination(), canvas.texture.size());
        self.queue.submit([encoder.finish()]);
        let slice = canvas.bytes.slice(..);
        slice.map_async(MapMode::Read, drop);
        self.wait()?;
        let row = 4 * canvas.size[0] as usize;
        let pixels = {
            let mapped = slice.get_mapped_range().map_err(|error| lost(&error))?;
            mapped.chunks_exact(canvas.row_bytes() as usize).flat_map(|padded| padded[..row].to_vec()).collect()
        };
        canvas.bytes.unmap();
        RgbaImage::from_raw(canvas.size[0], canvas.size[1], pixels).ok_or_else(|| lost(&"it is too short"))
    }
}

impl CardPicture {
    fn new(device: &Device, size: [u32; 2]) -> Self {
        let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC;
        let texture = TexturePlan::flat(size, crate::FORMAT).empty(device, usage);
        let bytes = device.create_buffer(&BufferDescriptor {
            label: Some("picture"),
            size: u64::from(row_bytes(size[0])) * u64::from(size[1]),
            usage: BufferUsages::COPY_DST | BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        Self { texture, bytes, size }
    }

    fn row_bytes(&self) -> u32 {
        row_bytes(self.size[0])
    }

    fn destination(&self) -> TexelCopyBufferInfo<'_> {
        let layout = TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(self.row_bytes()), rows_per_image: None };
        TexelCopyBufferInfo { buffer: &self.bytes, layout }
    }
}

/// Rows are padded to a multiple of 256 bytes.
fn row_bytes(width: u32) -> u32 {
    (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT)
}
