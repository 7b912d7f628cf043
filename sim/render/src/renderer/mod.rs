//! Renders frames of a stage.

mod passes;

use std::ops::Range;

use wgpu::{
    BindGroup, BindingResource, Buffer, BufferDescriptor, BufferUsages, CommandEncoder, Device, Queue, TextureView,
};

use crate::camera::Camera;
use crate::field::{self, DrawnResponses};
use crate::frame::{Frame, MOST_LAYERS, Stage, View};
use crate::gpu::buffers::Loaded;
use crate::gpu::layouts::{Layouts, group};
use crate::gpu::pipelines::{Drawn, FIELD, Fixed, Shaders};
use crate::gpu::targets::Targets;
use crate::gpu::textures::{TexturePlan, numbers, view};
use crate::gpu::tiles::{Tiles, smooth};
use crate::meshes::body::BodyMesh;
use crate::meshes::{self, MeshShape};
use crate::placement::Placement;
use crate::quality::Quality;
use crate::scene_block::{SceneBlock, ShaderMoment, latest};
use crate::{drape, skin, wounds};

/// Columns and rows of the grid with which the drape and the room are drawn over the image.
const BACKDROP: [u32; 2] = [64, 36];

/// Why a stage cannot be rendered.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum StageError {
    /// More layers than supported.
    #[error("{0} layers; allowed in a picture: at most {MOST_LAYERS}")]
    Layers(usize),
    /// More loads than supported.
    #[error("{0} loads of the field; allowed in a picture: at most {most}", most = field::MOST_LOADS)]
    Loads(usize),
    /// The size of the table does not match its radii, its loads and the layers.
    #[error("the field has {found} displacements; allowed: {wanted}, one for every boundary, load and radius")]
    Field {
        /// Number of values found.
        found: usize,
        /// Number of values expected.
        wanted: usize,
    },
}

/// Renders frames. GPU resources are created once per stage or size; a frame creates none.
pub struct Renderer {
    device: Device,
    queue: Queue,
    size: [u32; 2],
    quality: Quality,
    layouts: Layouts,
    shaders: Shaders,
    tiles: Tiles,
    samplers: [wgpu::Sampler; 3],
    pub(crate) fixed: Fixed,
    pub(crate) drawn: Drawn,
    pub(crate) targets: Targets,
    pub(crate) body: (Loaded, BodyMesh),
    pub(crate) tray: Loaded,
    pub(crate) drop: Loaded,
    /// The grid over the whole image, and the floor under the body.
    pub(crate) behind: [Loaded; 2],
    block: Buffer,
    pub(crate) groups: Groups,
    pub(crate) set: Set,
}

/// Resources of a stage.
pub(crate) struct Set {
    stage: Stage,
    responses: DrawnResponses,
    skin: TextureView,
    pub(crate) field: TextureView,
    /// Bound in place of the field while the field is written.
    no_field: TextureView,
    table: TextureView,
    pub(crate) needle: Loaded,
    /// The part on its hub: opaque and transparent.
    pub(crate) on_hub: [Loaded; 2],
    pub(crate) solids: Loaded,
    pub(crate) patient: Loaded,
    pub(crate) guide: Loaded,
}

/// Bind groups of the shaders.
pub(crate) struct Groups {
    /// The scene, for all passes that read the field.
    pub(crate) scene: BindGroup,
    /// The scene, for the pass that writes the field.
    pub(crate) superpose: BindGroup,
    pub(crate) responses: BindGroup,
    pub(crate) materials: BindGroup,
    pub(crate) enlarge: Option<BindGroup>,
}

impl Renderer {
    /// Creates a renderer for images of a size in pixels, with an empty stage.
    #[must_use]
    pub fn new(device: &Device, queue: &Queue, size: [u32; 2], quality: Quality) -> Self {
        let layouts = Layouts::new(device);
        let shaders = Shaders::new(device);
        let tiles = Tiles::new(device, queue, &layouts, &shaders);
        let fixed = Fixed::new(device, &layouts, &shaders);
        let drawn = Drawn::new(device, &layouts, &shaders, quality.samples());
        let size = size.map(|side| side.max(1));
        let targets = Targets::new(device, size, quality);
        let body = meshes::body::build_body();
        let block = device.create_buffer(&BufferDescriptor {
            label: Some("scene"),
            size: size_of::<SceneBlock>() as u64,
            usage: BufferUsages::UNIFORM | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let samplers = samplers(device, quality);
        let set = Set::new(device, queue, &Stage::default());
        let bound =
            Bound { device, layouts: &layouts, tiles: &tiles, samplers: &samplers, targets: &targets, block: &block };
        let groups = bound.groups(&set);
        let body = (Loaded::new(device, &body.shape), body);
        let tray = Loaded::new(device, &meshes::tray::build_tray());
        let drop = Loaded::new(device, &meshes::hub::build_drop());
        let behind = [BACKDROP, [16, 12]].map(|cells| Loaded::new(device, &meshes::sheet::build_sheet(cells)));
        let (device, queue) = (device.clone(), queue.clone());
        Self {
            device,
            queue,
            size,
            quality,
            layouts,
            shaders,
            tiles,
            samplers,
            fixed,
            drawn,
            targets,
            body,
            tray,
            drop,
            behind,
            block,
            groups,
            set,
        }
    }

    /// Uploads a stage to the GPU.
    ///
    /// # Errors
    /// If it has more layers or loads than supported, or a field of the wrong size; the previous
    /// stage stays.
    pub fn set_stage(&mut self, stage: &Stage) -> Result<(), StageError> {
        check(stage)?;
        self.set = Set::new(&self.device, &self.queue, stage);
        self.bind();
        Ok(())
    }

    /// Sets the size, in pixels, and the quality of subsequent images.
    pub fn resize(&mut self, size: [u32; 2], quality: Quality) {
        let size = size.map(|side| side.max(1));
        if (size, quality) == (self.size, self.quality) {
            return;
        }
        if quality.samples() != self.quality.samples() {
            self.drawn = Drawn::new(&self.device, &self.layouts, &self.shaders, quality.samples());
            self.samplers = samplers(&self.device, quality);
        }
        self.targets = Targets::new(&self.device, size, quality);
        (self.size, self.quality) = (size, quality);
        self.bind();
    }

    /// Size of the images, in pixels.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Quality of the images.
    #[must_use]
    pub fn quality(&self) -> Quality {
        self.quality
    }

    /// Number of triangles of a frame with everything visible.
    #[must_use]
    pub fn triangles(&self) -> u32 {
        let layers = self.set.stage.layers.len() as u32;
        let set = &self.set;
        self.body.0.triangles() * layers
            + set.needle.triangles()
            + set.on_hub.iter().map(Loaded::triangles).sum::<u32>()
            + 2 * self.drop.triangles()
            + set.solids.triangles()
            + set.patient.triangles()
            + set.guide.triangles()
            + self.tray.triangles()
    }

    /// The camera of a frame, for placing labels and marks.
    #[must_use]
    pub fn camera(&self, frame: &Frame) -> Camera {
        let place = Placement::for_frame(&self.set.stage, frame);
        Camera::for_frame(&self.set.stage, frame, &place, self.aspect())
    }

    /// Renders a frame to a view of [`crate::FORMAT`] and the renderer's size.
    pub fn draw(&self, frame: &Frame, onto: &TextureView) {
        self.write(frame);
        let mut encoder = self.device.create_command_encoder(&Default::default());
        self.encode(frame, onto, &mut encoder);
        self.queue.submit([encoder.finish()]);
    }

    fn encode(&self, frame: &Frame, onto: &TextureView, encoder: &mut CommandEncoder) {
        passes::draw_field(self, encoder);
        if self.quality.shadow_texels() > 0 && frame.view != View::Section {
            passes::draw_shadows(self, frame, encoder);
        }
        passes::draw_picture(self, frame, self.targets.small.as_ref().unwrap_or(onto), encoder);
        if let Some(small) = &self.groups.enlarge {
            passes::enlarge_picture(self, small, onto, encoder);
        }
    }

    /// Writes the frame's uniforms.
    fn write(&self, frame: &Frame) {
        let Set { stage, responses, .. } = &self.set;
        let place = Placement::for_frame(stage, frame);
        let camera = Camera::for_frame(stage, frame, &place, self.aspect());
        let moment = ShaderMoment { stage, frame, place: &place, camera: &camera, responses, quality: self.quality };
        self.queue.write_buffer(&self.block, 0, bytemuck::bytes_of(&SceneBlock::at_moment(&moment)));
    }

    /// Whether a frame shows the whole patient.
    pub(crate) fn shows_patient(&self, frame: &Frame) -> bool {
        self.set.stage.patient(frame.view).is_some()
    }

    fn aspect(&self) -> f32 {
        self.size[0] as f32 / self.size[1] as f32
    }

    /// Distance from the middle of the cut within which punctures are visible, in m: on the skin,
    /// and in the cut.
    pub(crate) fn wounds(&self, frame: &Frame) -> [f32; 2] {
        let stage = &self.set.stage;
        let (place, punctures) = (Placement::for_frame(stage, frame), latest(&frame.punctures));
        [wounds::on_skin(stage, &place, punctures), wounds::on_cut(stage, &place, punctures)]
    }

    /// Indices of the grid over the image where shadows can fall on the drape.
    pub(crate) fn shaded(&self, frame: &Frame) -> Range<u32> {
        if self.quality.shadow_texels() == 0 {
            return 0..0;
        }
        let place = Placement::for_frame(&self.set.stage, frame);
        let camera = Camera::for_frame(&self.set.stage, frame, &place, self.aspect());
        let [columns, rows] = BACKDROP;
        let shaded = drape::shaded_rows(&self.set.stage, frame, &place, &camera, rows);
        6 * columns * shaded.start..6 * columns * shaded.end
    }

    pub(crate) fn layers(&self) -> u32 {
        self.set.stage.layers.len() as u32
    }

    pub(crate) fn sees_the_cut(&self, frame: &Frame) -> bool {
        let place = Placement::for_frame(&self.set.stage, frame);
        let camera = Camera::for_frame(&self.set.stage, frame, &place, self.aspect());
        !camera.perspective || (camera.eye - place.focus).dot(place.cut) > 0.0
    }

    fn bind(&mut self) {
        let Self { device, layouts, tiles, samplers, targets, block, .. } = self;
        self.groups = Bound { device, layouts, tiles, samplers, targets, block }.groups(&self.set);
    }
}

/// Resources for the bind groups.
struct Bound<'a> {
    device: &'a Device,
    layouts: &'a Layouts,
    tiles: &'a Tiles,
    samplers: &'a [wgpu::Sampler; 3],
    targets: &'a Targets,
    block: &'a Buffer,
}

impl Bound<'_> {
    fn groups(&self, set: &Set) -> Groups {
        let Self { device, layouts, tiles, samplers: [tiled, compare, smooth], targets, block } = *self;
        let view = BindingResource::TextureView;
        let block = || BindingResource::Buffer(block.as_entire_buffer_binding());
        let sampler = BindingResource::Sampler;
        let materials =
            [view(&tiles.albedos), view(&tiles.reliefs), sampler(tiled), view(&targets.shadow), sampler(compare)];
        Groups {
            scene: group(device, &layouts.scene, &[block(), view(&set.skin), view(&set.field)]),
            superpose: group(device, &layouts.scene, &[block(), view(&set.skin), view(&set.no_field)]),
            responses: group(device, &layouts.responses, &[view(&set.table)]),
            materials: group(device, &layouts.materials, &materials),
            enlarge: targets.small.as_ref().map(|small| group(device, &layouts.copy, &[view(small), sampler(smooth)])),
        }
    }
}

impl Set {
    fn new(device: &Device, queue: &Queue, stage: &Stage) -> Self {
        let boundaries = stage.layers.len();
        let responses = DrawnResponses::resampled(&stage.field, boundaries);
        let rows = (boundaries * responses.loads).max(1);
        let mut samples = responses.samples.clone();
        samples.resize(rows * field::SAMPLES, 0.0);
        let (columns, skin) = (field::SAMPLES as u32, skin::SAMPLES as u32);
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING;
        let load = |shape: &MeshShape| Loaded::new(device, shape);
        Self {
            skin: numbers(device, queue, [skin; 2], &skin::shape(stage)),
            field: view(&TexturePlan::flat([columns, boundaries.max(1) as u32], FIELD).empty(device, usage)),
            no_field: view(&TexturePlan::flat([1, 1], FIELD).empty(device, wgpu::TextureUsages::TEXTURE_BINDING)),
            table: numbers(device, queue, [columns, rows as u32], &samples),
            needle: load(&meshes::needle::build_needle(&stage.needle)),
            on_hub: meshes::hub::build_on_hub(&stage.needle).map(|shape| load(&shape)),
            solids: load(&meshes::solids::build_solids(&stage.structures)),
            patient: load(&meshes::solids::build_patient(stage.skin.as_ref())),
            guide: load(&meshes::guide::build_guide(stage)),
            stage: stage.clone(),
            responses,
        }
    }
}

fn check(stage: &Stage) -> Result<(), StageError> {
    let (layers, table) = (stage.layers.len(), &stage.field);
    if layers > MOST_LAYERS {
        return Err(StageError::Layers(layers));
    }
    if table.loads > field::MOST_LOADS {
        return Err(StageError::Loads(table.loads));
    }
    let (found, wanted) = (table.axial_m_per_n.len(), layers * table.loads * table.radii_m.len());
    if found == wanted { Ok(()) } else { Err(StageError::Field { found, wanted }) }
}

/// Samplers: repeating tiles, shadow comparison, and linear for scaling up. Without multisampling
/// the tiles use one mip level.
fn samplers(device: &Device, quality: Quality) -> [wgpu::Sampler; 3] {
    let linear = wgpu::SamplerDescriptor {
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        ..Default::default()
    };
    let tiled = wgpu::SamplerDescriptor {
        address_mode_u: wgpu::AddressMode::Repeat,
        address_mode_v: wgpu::AddressMode::Repeat,
        mipmap_filter: if quality.samples() > 1 {
            wgpu::MipmapFilterMode::Linear
        } else {
            wgpu::MipmapFilterMode::Nearest
        },
        ..linear.clone()
    };
    let compare = wgpu::SamplerDescriptor { compare: Some(wgpu::CompareFunction::LessEqual), ..linear };
    [device.create_sampler(&tiled), device.create_sampler(&compare), smooth(device)]
}
