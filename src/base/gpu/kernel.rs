//! A compute pipeline whose resources are bound by the name of the WGSL variable.

use super::context::Gpu;
use super::lavapipe::uniforms_as_private_copies;
use super::reflect::{Binding, plain_name, reflect, unusable};
use super::shader::{Program, Sources, compose_point};
use super::uniform::{UniformValue, pack};
use crate::error::Result;
use naga::AddressSpace;
use std::collections::{BTreeMap, HashMap};
use std::time::Instant;

/// A resource to bind.
#[derive(Clone)]
pub enum Resource {
    /// Uniform or storage buffer.
    Buffer(wgpu::Buffer),
    /// Sampled or storage texture.
    View(wgpu::TextureView),
    /// Sampler.
    Sampler(wgpu::Sampler),
}

/// Resources and uniform values by WGSL variable name; a kernel binds those that it declares.
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

/// A compiled compute entry point.
pub struct Kernel {
    pipeline: wgpu::ComputePipeline,
    layouts: Vec<wgpu::BindGroupLayout>,
    bindings: Vec<Binding>,
    /// Names of private variables.
    private: Vec<String>,
    /// Threads of a workgroup.
    pub workgroup: [u32; 3],
    label: String,
}

impl Kernel {
    /// Composes and compiles `program`; its only entry point becomes the kernel.
    pub fn new(gpu: &Gpu, program: &Program) -> Result<Self> {
        Self::of(gpu, &gpu.sources, program, None)
    }

    /// [`Kernel::new`] with other shader texts; `point` names one of several entry points.
    pub fn of(
        gpu: &Gpu,
        sources: &Sources,
        program: &Program,
        point: Option<&str>,
    ) -> Result<Self> {
        Self::compile(gpu, sources, program, point).map_err(|e| sources.blame(e))
    }

    fn compile(
        gpu: &Gpu,
        sources: &Sources,
        program: &Program,
        point: Option<&str>,
    ) -> Result<Self> {
        let start = Instant::now();
        let mut module = compose_point(sources, program, point)?;
        if gpu.info.driver == "llvmpipe" {
            uniforms_as_private_copies(&mut module);
        }
        let bindings = reflect(&module, program.entry)?;
        let private = module.global_variables.iter();
        let private = private.filter(|(_, v)| v.space == AddressSpace::Private);
        let private = private.map(|(_, v)| plain_name(v.name.as_deref().unwrap_or_default()));
        let private = private.collect();
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
            private,
            workgroup,
            label: program.entry.to_owned(),
        })
    }

    /// Does the kernel declare a variable of this name?
    pub fn uses(&self, name: &str) -> bool {
        self.bindings.iter().any(|b| b.name == name)
    }

    /// Does the kernel keep a private variable of this name?
    pub fn keeps(&self, name: &str) -> bool {
        self.private.iter().any(|n| n == name)
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
