//! Graphics adapters: which ones the drivers report, and which of them can be opened.

use wgpu::{Adapter, Backends, Device, DeviceDescriptor, DeviceType, Instance, InstanceDescriptor, Limits, Queue};

/// Why no graphics adapter can be opened.
#[derive(Debug, thiserror::Error)]
pub enum AdapterError {
    /// The machine has no graphics adapter.
    #[error(
        "no graphics adapter: install a driver for this machine's graphics card, or the software one \
         (Debian: apt-get install mesa-vulkan-drivers libvulkan1)"
    )]
    NoAdapter,
    /// The adapter cannot be used.
    #[error("the graphics adapter {name} cannot be used: {why}")]
    Unusable {
        /// Name of the adapter.
        name: String,
        /// The adapter's message.
        why: String,
    },
}

/// Identity of a graphics adapter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AdapterName {
    /// Its name.
    pub name: String,
    /// Its graphics API: Vulkan, GL, …
    pub backend: String,
    /// Its driver, with version.
    pub driver: String,
    /// Whether it is a software renderer.
    pub software: bool,
}

impl std::fmt::Display for AdapterName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let kind = if self.software { "software" } else { "hardware" };
        write!(f, "{} ({}, {}, {kind})", self.name, self.backend, self.driver)
    }
}

/// An adapter and the device opened on it.
pub(crate) struct OpenAdapter {
    pub(crate) adapter: Adapter,
    pub(crate) device: Device,
    pub(crate) queue: Queue,
}

/// Tries to open each adapter of this machine, best first.
#[must_use]
pub fn adapters() -> Vec<Result<AdapterName, AdapterError>> {
    let opened = found().into_iter().map(|adapter| open(adapter, &for_pictures));
    opened.map(|opened| opened.map(|opened| named(&opened.adapter))).collect()
}

/// Returns the best of several adapters that opens with a descriptor: hardware before software,
/// Vulkan before GL.
///
/// # Errors
/// If there is no adapter, or the best one's error if none opens.
pub fn usable_adapter(
    adapters: Vec<Adapter>,
    descriptor: &dyn Fn(&Adapter) -> DeviceDescriptor<'static>,
) -> Result<Adapter, AdapterError> {
    first_usable(sorted(adapters), |adapter| open(adapter, descriptor)).map(|opened| opened.adapter)
}

/// Opens this machine's best adapter for pictures.
pub(crate) fn open_best() -> Result<OpenAdapter, AdapterError> {
    first_usable(found(), |adapter| open(adapter, &for_pictures))
}

/// Returns the first adapter that opens. A driver can report an adapter that it cannot open, as
/// Direct3D 12 does under Wine.
fn first_usable<A, O>(adapters: Vec<A>, open: impl Fn(A) -> Result<O, AdapterError>) -> Result<O, AdapterError> {
    let mut error_of_best = None;
    for adapter in adapters {
        match open(adapter) {
            Ok(opened) => return Ok(opened),
            Err(error) => _ = error_of_best.get_or_insert(error),
        }
    }
    Err(error_of_best.unwrap_or(AdapterError::NoAdapter))
}

fn open(
    adapter: Adapter,
    descriptor: &dyn Fn(&Adapter) -> DeviceDescriptor<'static>,
) -> Result<OpenAdapter, AdapterError> {
    let (device, queue) = pollster::block_on(adapter.request_device(&descriptor(&adapter)))
        .map_err(|error| AdapterError::Unusable { name: adapter.get_info().name, why: error.to_string() })?;
    Ok(OpenAdapter { adapter, device, queue })
}

fn for_pictures(adapter: &Adapter) -> DeviceDescriptor<'static> {
    let required_limits = Limits::downlevel_webgl2_defaults().using_resolution(adapter.limits());
    DeviceDescriptor { label: Some("stylet"), required_limits, ..Default::default() }
}

fn found() -> Vec<Adapter> {
    let backends = Backends::from_env().unwrap_or(Backends::PRIMARY | Backends::GL);
    let descriptor = InstanceDescriptor { backends, ..InstanceDescriptor::new_without_display_handle() };
    let instance = Instance::new(descriptor);
    sorted(pollster::block_on(instance.enumerate_adapters(backends)))
}

fn sorted(mut adapters: Vec<Adapter>) -> Vec<Adapter> {
    let rank = |kind| match kind {
        DeviceType::DiscreteGpu => 0,
        DeviceType::IntegratedGpu => 1,
        DeviceType::VirtualGpu => 2,
        DeviceType::Other => 3,
        DeviceType::Cpu => 4,
    };
    adapters.sort_by_key(|adapter| {
        let info = adapter.get_info();
        (rank(info.device_type), info.backend == wgpu::Backend::Gl)
    });
    adapters
}

pub(crate) fn named(adapter: &Adapter) -> AdapterName {
    let info = adapter.get_info();
    AdapterName {
        software: info.device_type == DeviceType::Cpu || info.name.contains("llvmpipe"),
        name: info.name,
        backend: format!("{:?}", info.backend),
        driver: format!("{} {}", info.driver, info.driver_info).trim().to_owned(),
    }
}
