//! Adapter, device and queue, and the errors they report outside of calls.

use super::instance::{self, BACKENDS};
use super::shader::Sources;
use super::timing::Timer;
use crate::error::{Error, Result};
use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::sync::{Arc, Mutex};
use std::thread::ThreadId;

const NO_ADAPTER_REMEDY: &str = "Install a Vulkan driver for your GPU, or a software one: on Debian and Ubuntu \
    `apt-get install mesa-vulkan-drivers`, on Fedora `dnf install mesa-vulkan-drivers`.";

/// One open device.
pub struct Gpu {
    /// The instance that the adapter came from: a window on the same device needs both.
    pub instance: wgpu::Instance,
    /// The adapter.
    pub adapter: wgpu::Adapter,
    /// The device.
    pub device: wgpu::Device,
    /// The only queue of the device.
    pub queue: wgpu::Queue,
    /// Adapter and driver as wgpu describes them.
    pub info: wgpu::AdapterInfo,
    /// Text of the shaders that its kernels are composed of.
    pub sources: Sources,
    timer: Option<Timer>,
    failures: Arc<Mutex<Failures>>,
    lost: Arc<AtomicBool>,
    compile_us: AtomicU64,
}

/// One adapter, as `occlab adapters` lists it.
#[derive(Clone, Debug, serde::Serialize)]
pub struct AdapterSummary {
    /// Name; `--adapter` matches any part of it, ignoring case.
    pub name: String,
    /// Driver and version.
    pub driver: String,
    /// `Vulkan`, `Metal`, `Dx12`.
    pub backend: String,
    /// `DiscreteGpu`, `IntegratedGpu`, `Cpu`…
    pub device_type: String,
    /// Pass times can be measured.
    pub timestamps: bool,
    /// f32 maps can be interpolated by hardware.
    pub float32_filterable: bool,
    /// Largest map edge, texels.
    pub max_texture_2d: u32,
}

fn adapters(instance: &wgpu::Instance) -> Vec<wgpu::Adapter> {
    pollster::block_on(instance.enumerate_adapters(BACKENDS))
}

/// Every adapter of this machine; empty when there is no driver.
pub fn list_adapters() -> Vec<AdapterSummary> {
    adapters(&instance::without_windows())
        .iter()
        .map(|adapter| {
            let (info, features) = (adapter.get_info(), adapter.features());
            AdapterSummary {
                driver: format!("{} {}", info.driver, info.driver_info),
                backend: format!("{:?}", info.backend),
                device_type: format!("{:?}", info.device_type),
                timestamps: features.contains(wgpu::Features::TIMESTAMP_QUERY),
                float32_filterable: features.contains(wgpu::Features::FLOAT32_FILTERABLE),
                max_texture_2d: adapter.limits().max_texture_dimension_2d,
                name: info.name,
            }
        })
        .collect()
}

/// The adapter whose name holds `wanted`; without a name, the fastest kind.
fn choose(instance: &wgpu::Instance, wanted: Option<&str>) -> Result<wgpu::Adapter> {
    let rank = |a: &wgpu::Adapter| match a.get_info().device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    };
    let mut all = adapters(instance);
    if all.is_empty() {
        return Err(Error::gpu(
            "this machine has no Vulkan, Metal or Direct3D 12 adapter",
            NO_ADAPTER_REMEDY,
        ));
    }
    all.sort_by_key(rank);
    let Some(wanted) = wanted else {
        return Ok(all.swap_remove(0));
    };
    let names: Vec<_> = all.iter().map(|a| a.get_info().name).collect();
    match names
        .iter()
        .position(|n| n.to_lowercase().contains(&wanted.to_lowercase()))
    {
        Some(i) => Ok(all.swap_remove(i)),
        None => Err(Error::gpu(
            format!("no adapter's name contains `{wanted}`"),
            format!("Choose one of: {}.", names.join("; ")),
        )),
    }
}

impl Gpu {
    /// Opens the adapter whose name holds `wanted`, or the fastest kind. Optional features are taken when offered.
    pub fn new(wanted: Option<&str>) -> Result<Self> {
        Self::open(instance::without_windows(), wanted)
    }

    /// The same for a device that also draws a window.
    pub fn for_window(wanted: Option<&str>) -> Result<Self> {
        Self::open(instance::with_windows(), wanted)
    }

    fn open(instance: wgpu::Instance, wanted: Option<&str>) -> Result<Self> {
        let adapter = choose(&instance, wanted)?;
        let optional = wgpu::Features::TIMESTAMP_QUERY
            | wgpu::Features::FLOAT32_FILTERABLE
            | wgpu::Features::TEXTURE_ADAPTER_SPECIFIC_FORMAT_FEATURES
            | wgpu::Features::TEXTURE_FORMAT_16BIT_NORM;
        let request = adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("occlab"),
            required_features: adapter.features() & optional,
            required_limits: adapter.limits(),
            ..Default::default()
        });
        let (device, queue) = pollster::block_on(request).map_err(|e| {
            Error::gpu(
                e.to_string(),
                "Update the driver, or choose another adapter with --adapter.",
            )
        })?;
        let failures = Arc::new(Mutex::new(Failures::default()));
        let (on_error, on_lost) = (failures.clone(), failures.clone());
        device.on_uncaptured_error(Arc::new(move |e: wgpu::Error| {
            note(&on_error, |failures| {
                let own = failures.by_thread.entry(std::thread::current().id());
                own.or_insert(e.to_string());
            });
        }));
        let lost = Arc::new(AtomicBool::new(false));
        let on_loss = lost.clone();
        device.set_device_lost_callback(move |reason, message| {
            on_loss.store(true, Relaxed);
            if reason != wgpu::DeviceLostReason::Destroyed {
                note(&on_lost, |f| {
                    f.lost = Some(format!("device lost: {message}"))
                });
            }
        });
        Ok(Self {
            info: adapter.get_info(),
            instance,
            adapter,
            sources: Sources::embedded(),
            timer: device
                .features()
                .contains(wgpu::Features::TIMESTAMP_QUERY)
                .then(Timer::new),
            device,
            queue,
            failures,
            lost,
            compile_us: AtomicU64::new(0),
        })
    }

    /// The first error that the driver reported for calls of this thread since the last check; a lost device is
    /// reported every time.
    pub fn check(&self) -> Result<()> {
        let mut noted = None;
        note(&self.failures, |failures| {
            let own = failures.by_thread.remove(&std::thread::current().id());
            noted = failures.lost.clone().or(own);
        });
        match noted {
            None => Ok(()),
            Some(problem) => Err(Error::gpu(
                problem,
                "Use smaller maps or images, or another adapter.",
            )),
        }
    }

    /// Does the adapter compute on the processor?
    pub fn is_software(&self) -> bool {
        self.info.device_type == wgpu::DeviceType::Cpu
    }

    /// Whether the device is lost: no work on it will ever finish again.
    pub fn is_lost(&self) -> bool {
        // Some losses are reported only during a poll; the result of this poll itself does not matter.
        let _ = self.device.poll(wgpu::PollType::Poll);
        self.lost.load(Relaxed)
    }

    /// Seconds spent composing and compiling shaders since the start.
    pub fn compile_s(&self) -> f64 {
        self.compile_us.load(Relaxed) as f64 * 1e-6
    }

    pub(super) fn add_compile_time(&self, time: std::time::Duration) {
        self.compile_us.fetch_add(time.as_micros() as u64, Relaxed);
    }

    /// Blocks until the queue is empty.
    pub fn wait(&self) -> Result<()> {
        self.device
            .poll(wgpu::PollType::wait_indefinitely())
            .map_err(|e| Error::gpu(e.to_string(), "Run the command again."))?;
        self.check()
    }

    /// Are pass times measured on this adapter?
    pub fn has_timestamps(&self) -> bool {
        self.timer.is_some()
    }

    /// Queries for the times of passes; `None` where the adapter has no timestamps: times are then "n/a".
    pub(super) fn timer(&self) -> Option<&Timer> {
        self.timer.as_ref()
    }

    /// Bytes that wgpu's allocator has handed out, where the backend reports them.
    pub fn allocated_bytes(&self) -> Option<u64> {
        self.device
            .generate_allocator_report()
            .map(|r| r.total_allocated_bytes)
    }

    /// A buffer holding `bytes`.
    pub fn buffer(&self, label: &str, bytes: &[u8], usage: wgpu::BufferUsages) -> wgpu::Buffer {
        let size = (bytes.len() as u64).next_multiple_of(16).max(16);
        let buffer = self.empty_buffer(label, size, usage | wgpu::BufferUsages::COPY_DST);
        self.queue.write_buffer(&buffer, 0, bytes);
        buffer
    }

    /// A sampled 3-D texture of `size` texels, x fastest.
    pub fn texture_3d(
        &self,
        label: &str,
        format: wgpu::TextureFormat,
        [width, height, depth_or_array_layers]: [u32; 3],
        texels: &[u8],
    ) -> wgpu::TextureView {
        let size = wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers,
        };
        let texture = self.device.create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D3,
            format,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: format.block_copy_size(None).map(|bytes| bytes * width),
            rows_per_image: Some(height),
        };
        self.queue
            .write_texture(texture.as_image_copy(), texels, layout, size);
        texture.create_view(&Default::default())
    }

    /// An uninitialised (zero) buffer.
    pub fn empty_buffer(&self, label: &str, size: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size,
            usage,
            mapped_at_creation: false,
        })
    }
}

/// Errors that the driver reported outside of calls, by thread: a window may use the device on a thread of its own.
#[derive(Default)]
struct Failures {
    /// The first error of each thread's calls.
    by_thread: HashMap<ThreadId, String>,
    lost: Option<String>,
}

fn note(failures: &Mutex<Failures>, act: impl FnOnce(&mut Failures)) {
    // A poisoned lock only means that another report panicked half-way: the map is still consistent.
    act(&mut failures
        .lock()
        .unwrap_or_else(std::sync::PoisonError::into_inner));
}
