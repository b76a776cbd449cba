//! A compute pipeline whose resources are bound by the name of the WGSL variable.

use super::context::Gpu;
use super::lavapipe::uniforms_as_private_copies;
use super::shader::{Program, Sources, compose};
use super::uniform::{Leaf, UniformValue, pack, struct_leaves};
use crate::error::{Error, Result};
use naga::{
    AddressSpace, GlobalVariable, Handle, ImageClass, ImageDimension, Module, StorageAccess,
    TypeInner,
};
use std::collections::{BTreeMap, HashMap};
use std::time::Instant;

/// Something to bind.
#[derive(Clone)]
pub enum Resource {
    /// Uniform or storage buffer.
    Buffer(wgpu::Buffer),
    /// Sampled or storage texture.
    View(wgpu::TextureView),
    /// Sampler.
    Sampler(wgpu::Sampler),
}

/// What kernels may bind, by WGSL variable name; a kernel takes what it declares.
#[derive(Clone, Default)]
pub struct Inputs {
    resources: HashMap<&'static str, Resource>,
    uniforms: HashMap<&'static str, Vec<(String, UniformValue)>>,
}

impl Inputs {
    /// Offers a buffer, texture or sampler as `name`.
    pub fn resource(&mut self, name: &'static str, resource: Resource) {
        self.resources.insert(name, resource);
    }

    /// Offers values for the members of the uniform `name`; more than the shader declares are ignored.
    pub fn uniform<N: Into<String>>(
        &mut self,
        name: &'static str,
        values: impl IntoIterator<Item = (N, UniformValue)>,
    ) {
        self.uniforms.insert(
            name,
            values.into_iter().map(|(n, v)| (n.into(), v)).collect(),
        );
    }

    /// Replaces uniforms by those of `other` that have the same name.
    pub fn take_uniforms(&mut self, other: Self) {
        self.uniforms.extend(other.uniforms);
    }
}

/// One `var` with a `@group` and `@binding`.
struct Binding {
    name: String,
    group: u32,
    entry: wgpu::BindGroupLayoutEntry,
    leaves: Vec<Leaf>,
    size: u32,
}

/// A compiled compute entry point.
pub struct Kernel {
    pipeline: wgpu::ComputePipeline,
    layouts: Vec<wgpu::BindGroupLayout>,
    bindings: Vec<Binding>,
    /// Threads of a workgroup.
    pub workgroup: [u32; 3],
    label: String,
}

impl Kernel {
    /// Composes and compiles `program`; its only entry point becomes the kernel.
    pub fn new(gpu: &Gpu, program: &Program) -> Result<Self> {
        Self::with_sources(gpu, &gpu.sources, program)
    }

    /// The same from other shader texts than the device's own.
    pub fn with_sources(gpu: &Gpu, sources: &Sources, program: &Program) -> Result<Self> {
        Self::compile(gpu, sources, program).map_err(|e| sources.blame(e))
    }

    fn compile(gpu: &Gpu, sources: &Sources, program: &Program) -> Result<Self> {
        let start = Instant::now();
        let mut module = compose(sources, program)?;
        if gpu.info.driver == "llvmpipe" {
            uniforms_as_private_copies(&mut module);
        }
        let bindings = reflect(&module, program.entry)?;
        let entry = module
            .entry_points
            .first()
            .ok_or_else(|| unusable(program.entry, "has no entry point"))?;
        let (workgroup, entry_name) = (entry.workgroup_size, entry.name.clone());
        let layouts = group_layouts(gpu, &bindings);
        let optional: Vec<_> = layouts.iter().map(Some).collect();
        let layout = gpu
            .device
            .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some(program.entry),
                bind_group_layouts: &optional,
                immediate_size: 0,
            });
        let shader = gpu
            .device
            .create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(program.entry),
                source: wgpu::ShaderSource::Naga(std::borrow::Cow::Owned(module)),
            });
        let pipeline = gpu
            .device
            .create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(program.entry),
                layout: Some(&layout),
                module: &shader,
                entry_point: Some(&entry_name),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            });
        gpu.check()?;
        gpu.add_compile_time(start.elapsed());
        Ok(Self {
            pipeline,
            layouts,
            bindings,
            workgroup,
            label: program.entry.to_owned(),
        })
    }

    /// Does the kernel declare a variable of this name?
    pub fn uses(&self, name: &str) -> bool {
        self.bindings.iter().any(|b| b.name == name)
    }

    /// Member names of the uniform variable `name`.
    pub fn members(&self, name: &str) -> Vec<&str> {
        self.bindings
            .iter()
            .filter(|b| b.name == name)
            .flat_map(|b| &b.leaves)
            .map(|l| l.path.as_str())
            .collect()
    }

    /// Bind groups from inputs by name, the first that offers a name wins; one that no input offers is an error.
    pub fn bind(&self, gpu: &Gpu, inputs: &[&Inputs]) -> Result<Vec<wgpu::BindGroup>> {
        let resources = self
            .bindings
            .iter()
            .map(|b| self.resource_for(gpu, b, inputs))
            .collect::<Result<Vec<_>>>()
            .map_err(|e| gpu.sources.blame(e))?;
        let group = |(group, layout): (usize, &wgpu::BindGroupLayout)| {
            let own = self
                .bindings
                .iter()
                .zip(&resources)
                .filter(|(b, _)| b.group as usize == group);
            let entries: Vec<_> = own
                .map(|(b, r)| wgpu::BindGroupEntry {
                    binding: b.entry.binding,
                    resource: binding_resource(r),
                })
                .collect();
            gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some(&self.label),
                layout,
                entries: &entries,
            })
        };
        let groups = self.layouts.iter().enumerate().map(group).collect();
        gpu.check()?;
        Ok(groups)
    }

    fn resource_for(&self, gpu: &Gpu, binding: &Binding, inputs: &[&Inputs]) -> Result<Resource> {
        let name = binding.name.as_str();
        if let Some(resource) = inputs.iter().find_map(|i| i.resources.get(name)) {
            return Ok(resource.clone());
        }
        let values = inputs.iter().find_map(|i| i.uniforms.get(name));
        let values =
            values.ok_or_else(|| unusable(&self.label, format!("nothing is bound to `{name}`")))?;
        let bytes = pack(name, &binding.leaves, binding.size, values)?;
        Ok(Resource::Buffer(gpu.buffer(
            name,
            &bytes,
            wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::STORAGE,
        )))
    }

    /// Records a dispatch that covers `threads`.
    pub fn dispatch(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        groups: &[wgpu::BindGroup],
        threads: [u32; 3],
    ) {
        pass.set_pipeline(&self.pipeline);
        for (i, group) in (0_u32..).zip(groups) {
            pass.set_bind_group(i, group, &[]);
        }
        let count = |i: usize| threads[i].div_ceil(self.workgroup[i]);
        pass.dispatch_workgroups(count(0), count(1), count(2));
    }
}

fn binding_resource(resource: &Resource) -> wgpu::BindingResource<'_> {
    match resource {
        Resource::Buffer(b) => b.as_entire_binding(),
        Resource::View(v) => wgpu::BindingResource::TextureView(v),
        Resource::Sampler(s) => wgpu::BindingResource::Sampler(s),
    }
}

fn unusable(file: &str, message: impl Into<String>) -> Error {
    Error::Shader {
        file: format!("shaders/{file}"),
        message: message.into(),
    }
}

fn group_layouts(gpu: &Gpu, bindings: &[Binding]) -> Vec<wgpu::BindGroupLayout> {
    let mut groups: BTreeMap<u32, Vec<wgpu::BindGroupLayoutEntry>> = BTreeMap::new();
    for binding in bindings {
        groups.entry(binding.group).or_default().push(binding.entry);
    }
    let count = groups.keys().max().map_or(0, |m| m + 1);
    (0..count)
        .map(|g| {
            let entries = groups.get(&g).map_or(&[][..], Vec::as_slice);
            gpu.device
                .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                    label: None,
                    entries,
                })
        })
        .collect()
}

/// naga_oil decorates the names of imported items with their module.
fn plain_name(name: &str) -> String {
    name.split("X_naga_oil_mod_X")
        .next()
        .unwrap_or(name)
        .to_owned()
}

fn reflect(module: &Module, file: &str) -> Result<Vec<Binding>> {
    let mut validator = naga::valid::Validator::new(
        naga::valid::ValidationFlags::all(),
        naga::valid::Capabilities::all(),
    );
    let info = validator
        .validate(module)
        .map_err(|e| unusable(file, format!("{e:?}")))?;
    let filtered: Vec<Handle<GlobalVariable>> = info
        .get_entry_point(0)
        .sampling_set
        .iter()
        .map(|k| k.image)
        .collect();
    let mut bindings = Vec::new();
    for (handle, variable) in module.global_variables.iter() {
        let Some(at) = &variable.binding else {
            continue;
        };
        let name = plain_name(variable.name.as_deref().unwrap_or_default());
        let ty = binding_type(module, variable, filtered.contains(&handle)).ok_or_else(|| {
            unusable(
                file,
                format!("`{name}` has a kind of binding that the lab does not use"),
            )
        })?;
        let size = match variable.space {
            AddressSpace::Uniform | AddressSpace::Storage { .. } => {
                module.types[variable.ty].inner.size(module.to_ctx())
            }
            _ => 0,
        };
        let entry = wgpu::BindGroupLayoutEntry {
            binding: at.binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty,
            count: None,
        };
        bindings.push(Binding {
            name,
            group: at.group,
            entry,
            leaves: struct_leaves(module, variable.ty),
            size,
        });
    }
    Ok(bindings)
}

fn binding_type(
    module: &Module,
    variable: &GlobalVariable,
    filtered: bool,
) -> Option<wgpu::BindingType> {
    let buffer = |ty| wgpu::BindingType::Buffer {
        ty,
        has_dynamic_offset: false,
        min_binding_size: None,
    };
    Some(match (variable.space, &module.types[variable.ty].inner) {
        (AddressSpace::Uniform, _) => buffer(wgpu::BufferBindingType::Uniform),
        (AddressSpace::Storage { access }, _) => buffer(wgpu::BufferBindingType::Storage {
            read_only: !access.contains(StorageAccess::STORE),
        }),
        (_, TypeInner::Sampler { .. }) => {
            wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering)
        }
        (
            _,
            TypeInner::Image {
                dim,
                arrayed,
                class,
            },
        ) => {
            let view_dimension = match (dim, arrayed) {
                (ImageDimension::D2, false) => wgpu::TextureViewDimension::D2,
                (ImageDimension::D2, true) => wgpu::TextureViewDimension::D2Array,
                (ImageDimension::D3, _) => wgpu::TextureViewDimension::D3,
                _ => return None,
            };
            match class {
                ImageClass::Sampled { multi: false, .. } => wgpu::BindingType::Texture {
                    sample_type: wgpu::TextureSampleType::Float {
                        filterable: filtered,
                    },
                    view_dimension,
                    multisampled: false,
                },
                ImageClass::Storage { format, .. } => wgpu::BindingType::StorageTexture {
                    access: wgpu::StorageTextureAccess::WriteOnly,
                    format: storage_format(*format)?,
                    view_dimension,
                },
                _ => return None,
            }
        }
        _ => return None,
    })
}

fn storage_format(format: naga::StorageFormat) -> Option<wgpu::TextureFormat> {
    Some(match format {
        naga::StorageFormat::R16Float => wgpu::TextureFormat::R16Float,
        naga::StorageFormat::R32Float => wgpu::TextureFormat::R32Float,
        naga::StorageFormat::Rgba16Float => wgpu::TextureFormat::Rgba16Float,
        naga::StorageFormat::Rgba32Float => wgpu::TextureFormat::Rgba32Float,
        naga::StorageFormat::Rgba8Unorm => wgpu::TextureFormat::Rgba8Unorm,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::plain_name;

    #[test]
    fn decoration_of_imported_names_is_removed() {
        assert_eq!(plain_name("frameX_naga_oil_mod_XMZZGC3LFX"), "frame");
        assert_eq!(plain_name("counts"), "counts");
    }
}
