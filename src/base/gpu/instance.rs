//! The wgpu instance, which finds drivers, with or without the extensions that a window needs.

use wgpu::{Backends, Instance, InstanceDescriptor};

/// Vulkan, Metal, Direct3D 12. The window's toolkit brings OpenGL too, whose adapters lack what the marcher needs.
pub(super) const BACKENDS: Backends = Backends::PRIMARY;

/// An instance for pictures that go to memory alone; it has no adapters where there is no driver.
pub(super) fn without_windows() -> Instance {
    headless::instance().unwrap_or_else(|| Instance::new(descriptor()))
}

/// An instance whose devices can draw a window too.
pub(super) fn with_windows() -> Instance {
    Instance::new(descriptor())
}

fn descriptor() -> InstanceDescriptor {
    InstanceDescriptor {
        backends: BACKENDS,
        ..InstanceDescriptor::new_without_display_handle()
    }
}

/// Vulkan without window systems.
///
/// wgpu enables the extensions of every window system that the driver offers. With them Mesa connects to the desktop to
/// find out which GPU draws it: a line on stderr for each try where there is none (a server, a container), and a wait for
/// a desktop that hangs. wgpu's safe interface has no choice of extensions, hence the two unsafe calls.
#[cfg(target_os = "linux")]
#[allow(unsafe_code)]
mod headless {
    use super::{Instance, descriptor};
    use wgpu::hal::{InstanceDescriptor, api::Vulkan, vulkan};

    const WINDOW_SYSTEMS: [&std::ffi::CStr; 3] = [
        c"VK_KHR_xlib_surface",
        c"VK_KHR_xcb_surface",
        c"VK_KHR_wayland_surface",
    ];

    /// `None` where there is no Vulkan.
    pub(super) fn instance() -> Option<Instance> {
        let options = descriptor();
        let descriptor = InstanceDescriptor {
            name: "wgpu",
            flags: options.flags,
            memory_budget_thresholds: options.memory_budget_thresholds,
            backend_options: options.backend_options,
            telemetry: None,
            display: None,
        };
        let without_windows = Box::new(
            |arguments: vulkan::CreateInstanceCallbackArgs<'_, '_, '_>| {
                let extensions = arguments.extensions;
                extensions.retain(|name| !WINDOW_SYSTEMS.contains(name));
            },
        );
        // SAFETY: Vulkan asks for no more than that the loader is sound, as it must be for wgpu's own call. The
        // callback only removes extension names. wgpu asks callers not to, because it assumes that what is available is
        // enabled; for these three it makes no such assumption: each is looked up among the enabled ones before a
        // surface is made, its only use, and is an error if it is missing. VK_KHR_surface, which devices' swapchain
        // extension requires, stays.
        let instance =
            unsafe { vulkan::Instance::init_with_callback(&descriptor, Some(without_windows)) };
        // SAFETY: the instance was just made, nothing else holds it, and wgpu may destroy it.
        Some(unsafe { Instance::from_hal::<Vulkan>(instance.ok()?) })
    }
}

/// Elsewhere opening a driver does not touch the window system.
#[cfg(not(target_os = "linux"))]
mod headless {
    pub(super) fn instance() -> Option<super::Instance> {
        None
    }
}
