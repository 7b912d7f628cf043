//! The render pipelines.

use wgpu::{
    BindGroupLayout, BlendState, ColorTargetState, ColorWrites, CompareFunction, DepthStencilState, Device, Face,
    FragmentState, MultisampleState, PipelineLayoutDescriptor, PrimitiveState, RenderPipeline,
    RenderPipelineDescriptor, ShaderModule, ShaderModuleDescriptor, ShaderSource, StencilFaceState, StencilOperation,
    StencilState, TextureFormat, VertexBufferLayout, VertexState, vertex_attr_array,
};

use super::FORMAT;
use super::layouts::Layouts;
use crate::meshes::Corner;

/// Depth and stencil format of an image.
pub const DEPTH: TextureFormat = TextureFormat::Depth24PlusStencil8;
/// Depth format of the shadow map.
pub const SHADOW: TextureFormat = TextureFormat::Depth32Float;
/// Format of the field's texture: the bits of floats, because not every adapter can render to
/// floats.
pub const FIELD: TextureFormat = TextureFormat::R32Uint;

const SCENE: &str = include_str!("../shaders/scene.wgsl");
const LIGHT: &str = include_str!("../shaders/light.wgsl");

/// Compiles a shader from concatenated parts.
#[must_use]
pub fn shader(device: &Device, label: &str, parts: &[&str]) -> ShaderModule {
    let source = ShaderSource::Wgsl(parts.concat().into());
    device.create_shader_module(ShaderModuleDescriptor { label: Some(label), source })
}

/// The compiled shaders.
pub struct Shaders {
    field: ShaderModule,
    tissue: ShaderModule,
    needle: ShaderModule,
    solid: ShaderModule,
    backdrop: ShaderModule,
    /// Scales an image up, or down to the next mip level.
    pub enlarge: ShaderModule,
    /// The materials' tiles.
    pub tiles: ShaderModule,
}

impl Shaders {
    /// Compiles the shaders.
    #[must_use]
    pub fn new(device: &Device) -> Self {
        let lit = |label: &str, own: &str| shader(device, label, &[SCENE, LIGHT, own]);
        Self {
            field: shader(device, "field", &[SCENE, include_str!("../shaders/field.wgsl")]),
            tissue: lit("tissue", include_str!("../shaders/tissue.wgsl")),
            needle: lit("needle", include_str!("../shaders/needle.wgsl")),
            solid: lit("solid", include_str!("../shaders/solid.wgsl")),
            backdrop: lit("backdrop", include_str!("../shaders/backdrop.wgsl")),
            enlarge: shader(device, "enlarge", &[include_str!("../shaders/enlarge.wgsl")]),
            tiles: shader(device, "tiles", &[SCENE, include_str!("../shaders/tiles.wgsl")]),
        }
    }
}

/// Pipelines that do not depend on the number of samples per pixel.
pub struct Fixed {
    /// Superposes the field.
    pub superpose: RenderPipeline,
    /// Draws the body into the shadow map.
    pub tissue_shadow: RenderPipeline,
    /// Draws a whole patient into the shadow map.
    pub patient_shadow: RenderPipeline,
    /// Scales an image up.
    pub enlarge: RenderPipeline,
}

/// Pipelines of the image itself.
pub struct Drawn {
    /// The body, opaque.
    pub tissue: Faces,
    /// The body, transparent.
    pub faded: Faces,
    /// Boundaries inside a transparent body.
    pub sheet: RenderPipeline,
    /// The cut face of a section.
    pub section: RenderPipeline,
    /// The cut face of a section, with tracks.
    pub tracked_section: RenderPipeline,
    /// The needle.
    pub needle: RenderPipeline,
    /// A syringe's barrel.
    pub glass: RenderPipeline,
    /// Drops at the hub and below it.
    pub drops: RenderPipeline,
    /// Another attempt's needle.
    pub ghost: RenderPipeline,
    /// Marks the intersection of the cut with a structure in the stencil.
    pub solid_inside: RenderPipeline,
    /// Structures.
    pub solid: RenderPipeline,
    /// Structures behind the cut face of a section.
    pub solid_behind: RenderPipeline,
    /// The skin of a whole patient, opaque.
    pub patient: RenderPipeline,
    /// The skin of a whole patient, transparent.
    pub faded_patient: RenderPipeline,
    /// The far side of a transparent patient.
    pub patient_inside: RenderPipeline,
    /// The tray next to the body.
    pub tray: RenderPipeline,
    /// The backdrop.
    pub backdrop: RenderPipeline,
    /// The backdrop where no shadow falls.
    pub bright: RenderPipeline,
    /// The floor under a transparent body.
    pub floor: RenderPipeline,
    /// The background of a section.
    pub paper: RenderPipeline,
    /// The guide where it is hidden.
    pub guide_hidden: RenderPipeline,
    /// The guide.
    pub guide: RenderPipeline,
}

/// Faces of the body.
pub struct Faces {
    /// Cut faces.
    pub face: RenderPipeline,
    /// Cut faces with tracks.
    pub tracked: RenderPipeline,
    /// Skin.
    pub skin: RenderPipeline,
    /// Skin with punctures.
    pub punctured: RenderPipeline,
}

impl Fixed {
    /// Creates the pipelines.
    #[must_use]
    pub fn new(device: &Device, layouts: &Layouts, shaders: &Shaders) -> Self {
        let make = |recipe: Recipe<'_>| recipe.make(device, 1);
        let field = Recipe::new(&shaders.field, ["whole", "superpose"], &[&layouts.scene, &layouts.responses]);
        let enlarge = Recipe::new(&shaders.enlarge, ["enlarge_vertex", "enlarge_fragment"], &[&layouts.copy]);
        let cast = |module, vertex, fragment| {
            let depth = Some(depth(SHADOW, true, CompareFunction::Less));
            let recipe = Recipe::new(module, [vertex, ""], &[&layouts.scene]);
            Recipe { corners: true, fragment, formats: &[], depth, ..recipe }
        };
        Self {
            superpose: make(Recipe { formats: &[FIELD], ..field }),
            tissue_shadow: make(cast(&shaders.tissue, "tissue_shadow", None)),
            patient_shadow: make(cast(&shaders.solid, "patient_shadow", Some("patient_shadow_beside"))),
            enlarge: make(enlarge),
        }
    }
}

impl Drawn {
    /// Creates the pipelines for a number of samples per pixel.
    #[must_use]
    pub fn new(device: &Device, layouts: &Layouts, shaders: &Shaders, samples: u32) -> Self {
        let groups = [&layouts.scene, &layouts.materials];
        let less = CompareFunction::LessEqual;
        // Soft shadow edges are used together with antialiasing.
        let soft = ("soft_shadows", f64::from(u8::from(samples > 1)));
        let recipe = |module, entries, depth| Recipe {
            corners: true,
            constants: vec![soft],
            depth: Some(depth),
            ..Recipe::new(module, entries, &groups)
        };
        let make = |recipe: Recipe<'_>| recipe.make(device, samples);
        let solid = |fragment, depth| recipe(&shaders.solid, ["solid_vertex", fragment], depth);
        let closed =
            |module, entries| Recipe { cull: Some(Face::Back), ..recipe(module, entries, depth(DEPTH, true, less)) };
        let through = Some(BlendState::ALPHA_BLENDING);
        let uncut = |write| with_stencil(depth(DEPTH, write, less), CompareFunction::Equal, StencilOperation::Keep);
        let body = |fragment, blend: Option<BlendState>| {
            let faded = blend.is_some();
            let recipe = recipe(&shaders.tissue, ["tissue_vertex", fragment], uncut(!faded));
            make(Recipe { blend, constants: vec![soft, ("faded", f64::from(u8::from(faded)))], ..recipe })
        };
        let faces = |blend| Faces {
            face: body("face_fragment", blend),
            tracked: body("tracked_fragment", blend),
            skin: body("skin_fragment", blend),
            punctured: body("punctured_fragment", blend),
        };
        let clear = |vertex| Recipe {
            blend: through,
            cull: Some(Face::Back),
            ..recipe(&shaders.needle, [vertex, "glass_fragment"], depth(DEPTH, false, less))
        };
        let above = || depth(DEPTH, false, CompareFunction::Always);
        let behind =
            |vertex, fragment, write| make(recipe(&shaders.backdrop, [vertex, fragment], depth(DEPTH, write, less)));
        Self {
            tissue: faces(None),
            faded: faces(through),
            sheet: body("sheet_fragment", through),
            section: body("section_fragment", None),
            tracked_section: body("tracked_section", None),
            needle: make(closed(&shaders.needle, ["needle_vertex", "needle_fragment"])),
            glass: make(clear("needle_vertex")),
            drops: make(clear("drop_vertex")),
            ghost: make(Recipe {
                blend: through,
                ..recipe(&shaders.needle, ["ghost_vertex", "ghost_fragment"], depth(DEPTH, false, less))
            }),
            solid_inside: make(Recipe { writes: ColorWrites::empty(), ..solid("solid_inside", counted()) }),
            solid: make(solid("solid_fragment", depth(DEPTH, true, less))),
            patient: make(closed(&shaders.solid, ["patient_vertex", "patient_fragment"])),
            faded_patient: make(Recipe {
                blend: through,
                cull: Some(Face::Back),
                ..recipe(&shaders.solid, ["patient_vertex", "patient_faded"], depth(DEPTH, false, less))
            }),
            patient_inside: make(Recipe {
                cull: Some(Face::Front),
                ..closed(&shaders.solid, ["patient_vertex", "patient_inside"])
            }),
            tray: make(closed(&shaders.solid, ["tray_vertex", "tray_fragment"])),
            solid_behind: make(Recipe { blend: through, ..solid("solid_behind", above()) }),
            backdrop: behind("backdrop_vertex", "backdrop_fragment", false),
            bright: behind("backdrop_vertex", "bright_fragment", false),
            floor: behind("floor_vertex", "backdrop_fragment", true),
            paper: behind("paper_vertex", "paper_fragment", false),
            guide_hidden: make(Recipe { blend: through, ..solid("guide_hidden", above()) }),
            guide: make(solid("guide_fragment", depth(DEPTH, true, less))),
        }
    }
}

/// Creates a pipeline that covers its targets with one triangle.
#[must_use]
pub fn covering(
    device: &Device,
    module: &ShaderModule,
    entries: [&str; 2],
    groups: &[&BindGroupLayout],
    formats: &[TextureFormat],
) -> RenderPipeline {
    Recipe { formats, ..Recipe::new(module, entries, groups) }.make(device, 1)
}

/// Parameters in which pipelines differ.
struct Recipe<'a> {
    module: &'a ShaderModule,
    vertex: &'a str,
    fragment: Option<&'a str>,
    groups: Vec<Option<&'a BindGroupLayout>>,
    corners: bool,
    formats: &'a [TextureFormat],
    /// Pipeline-overridable constants of the shader.
    constants: Vec<(&'static str, f64)>,
    writes: ColorWrites,
    blend: Option<BlendState>,
    depth: Option<DepthStencilState>,
    /// Culled faces.
    cull: Option<Face>,
}

impl<'a> Recipe<'a> {
    fn new(module: &'a ShaderModule, [vertex, fragment]: [&'a str; 2], groups: &[&'a BindGroupLayout]) -> Self {
        let groups = groups.iter().copied().map(Some).collect();
        let writes = ColorWrites::ALL;
        Self {
            module,
            vertex,
            fragment: Some(fragment),
            groups,
            corners: false,
            formats: &[FORMAT],
            constants: Vec::new(),
            writes,
            blend: None,
            depth: None,
            cull: None,
        }
    }

    fn make(self, device: &Device, samples: u32) -> RenderPipeline {
        let layout = device.create_pipeline_layout(&PipelineLayoutDescriptor {
            label: None,
            bind_group_layouts: &self.groups,
            immediate_size: 0,
        });
        let attributes = vertex_attr_array![0 => Float32x4, 1 => Float32x4];
        let corners = VertexBufferLayout {
            array_stride: size_of::<Corner>() as u64,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &attributes,
        };
        let buffers = [Some(corners)];
        let target = |format: &TextureFormat| {
            Some(ColorTargetState { format: *format, blend: self.blend, write_mask: self.writes })
        };
        let options = wgpu::PipelineCompilationOptions { constants: &self.constants, ..Default::default() };
        let targets: Vec<_> = self.formats.iter().map(target).collect();
        device.create_render_pipeline(&RenderPipelineDescriptor {
            label: Some(self.vertex),
            layout: Some(&layout),
            vertex: VertexState {
                module: self.module,
                entry_point: Some(self.vertex),
                compilation_options: options.clone(),
                buffers: if self.corners { &buffers } else { &[] },
            },
            primitive: PrimitiveState { cull_mode: self.cull, ..Default::default() },
            depth_stencil: self.depth,
            multisample: MultisampleState { count: samples, ..Default::default() },
            fragment: self.fragment.map(|entry| FragmentState {
                module: self.module,
                entry_point: Some(entry),
                compilation_options: options.clone(),
                targets: &targets,
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}

fn depth(format: TextureFormat, write: bool, compare: CompareFunction) -> DepthStencilState {
    DepthStencilState {
        format,
        depth_write_enabled: Some(write),
        depth_compare: Some(compare),
        stencil: StencilState::default(),
        bias: Default::default(),
    }
}

/// Counts the parity of the crossings of a solid's surface in the stencil.
fn counted() -> DepthStencilState {
    let always = CompareFunction::Always;
    with_stencil(depth(DEPTH, false, always), always, StencilOperation::Invert)
}

/// The stencil is 0 where the cut face shows the body, and its complement inside a structure.
fn with_stencil(state: DepthStencilState, compare: CompareFunction, pass_op: StencilOperation) -> DepthStencilState {
    let keep = StencilOperation::Keep;
    let face = StencilFaceState { compare, fail_op: keep, depth_fail_op: keep, pass_op };
    DepthStencilState { stencil: StencilState { front: face, back: face, read_mask: 0xff, write_mask: 0xff }, ..state }
}
