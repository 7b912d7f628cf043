//! Textures made from plain numbers.

use wgpu::util::{DeviceExt, TextureDataOrder};
use wgpu::{
    Device, Extent3d, Queue, Texture, TextureDescriptor, TextureDimension, TextureFormat, TextureUsages, TextureView,
    TextureViewDescriptor,
};

/// Parameters of a texture, except its usage.
#[derive(Clone, Copy)]
pub struct TexturePlan {
    /// Width and height, in texels.
    pub size: [u32; 2],
    /// Number of mip levels.
    pub levels: u32,
    /// Number of array layers.
    pub layers: u32,
    /// Number of samples per texel.
    pub samples: u32,
    /// Format.
    pub format: TextureFormat,
}

impl TexturePlan {
    /// One layer with one level.
    #[must_use]
    pub fn flat(size: [u32; 2], format: TextureFormat) -> Self {
        Self { size, levels: 1, layers: 1, samples: 1, format }
    }

    fn descriptor(&self, usage: TextureUsages) -> TextureDescriptor<'static> {
        let [width, height] = self.size;
        TextureDescriptor {
            label: None,
            size: Extent3d { width, height, depth_or_array_layers: self.layers },
            mip_level_count: self.levels,
            sample_count: self.samples,
            dimension: TextureDimension::D2,
            format: self.format,
            usage,
            view_formats: &[],
        }
    }

    /// Creates the texture with undefined content.
    #[must_use]
    pub fn empty(&self, device: &Device, usage: TextureUsages) -> Texture {
        device.create_texture(&self.descriptor(usage))
    }
}

/// Creates a texture of numbers for shaders, row by row, with one or four numbers per texel.
#[must_use]
pub fn numbers<T: bytemuck::Pod>(device: &Device, queue: &Queue, size: [u32; 2], values: &[T]) -> TextureView {
    let four = size_of::<T>() > size_of::<f32>();
    let plan = TexturePlan::flat(size, if four { TextureFormat::Rgba32Float } else { TextureFormat::R32Float });
    let descriptor = plan.descriptor(TextureUsages::TEXTURE_BINDING);
    let bytes = bytemuck::cast_slice(values);
    let texture = device.create_texture_with_data(queue, &descriptor, TextureDataOrder::LayerMajor, bytes);
    view(&texture)
}

/// A view of a whole texture.
#[must_use]
pub fn view(texture: &Texture) -> TextureView {
    texture.create_view(&TextureViewDescriptor::default())
}
