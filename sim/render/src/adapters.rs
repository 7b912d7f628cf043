//! Graphics adapters: which ones the drivers report, and which of them can be opened.

use wgpu::{Adapter, Backends, Device, DeviceDescriptor, DeviceType, Instance, InstanceDescriptor, Limits, Queue};

use crate::headless::PictureError;

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
pub fn adapters() -> Vec<Result<AdapterName, PictureError>> {
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
) -> Result<Adapter, PictureError> {
    first_usable(sorted(adapters), |adapter| open(adapter, descriptor)).map(|opened| opened.adapter)
}

/// Opens this machine's best adapter for pictures.
pub(crate) fn open_best() -> Result<OpenAdapter, PictureError> {
    first_usable(found(), |adapter| open(adapter, &for_pictures))
}

/// Returns the first adapter that opens. A driver can report an adapter that it cannot open, as
/// Direct3D 12 does under Wine.
fn first_usable<A, O>(adapters: Vec<A>, open: impl Fn(A) -> Result<O, PictureError>) -> Result<O, PictureError> {
    let mut error_of_best = None;
    for adapter in adapters {
        match open(adapter) {
            Ok(opened) => return Ok(opened),
            Err(error) => _ = error_of_best.get_or_insert(error),
        }
    }
    Err(error_of_best.unwrap_or(PictureError::NoAdapter))
}

fn open(
    adapter: Adapter,
    descriptor: &dyn Fn(&Adapter) -> DeviceDescriptor<'static>,
) -> Result<OpenAdapter, PictureError> {
    let (device, queue) = pollster::block_on(adapter.request_device(&descriptor(&adapter)))
        .map_err(|error| PictureError::Unusable { name: adapter.get_info().name, why: error.to_string() })?;
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

#[cfg(test)]
mod tests {
    use super::*;

    fn broken(name: &str) -> PictureError {
        PictureError::Unusable { name: name.to_owned(), why: "lost".to_owned() }
    }

    #[test]
    fn an_adapter_that_does_not_open_is_skipped() {
        let open = |name: &'static str| if name == "card" { Err(broken(name)) } else { Ok(name) };
        assert_eq!(first_usable(vec!["card", "software", "other"], open).expect("one opens"), "software");
    }

    #[test]
    fn the_error_is_that_of_the_best_adapter() {
        let none = first_usable(vec!["card", "software"], |name: &'static str| Err::<(), _>(broken(name)));
        assert_eq!(none.expect_err("none opens").to_string(), broken("card").to_string());
        let no_adapter = first_usable(Vec::new(), |(): ()| Ok(())).expect_err("there is none");
        assert!(matches!(no_adapter, PictureError::NoAdapter));
    }
}
