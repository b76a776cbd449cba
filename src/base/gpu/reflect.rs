//! Reflection: the bindings of a composed shader module.

use super::uniform::{Leaf, struct_leaves};
use crate::error::{Error, Result};
use naga::{
    AddressSpace, GlobalVariable, Handle, ImageClass, ImageDimension, Module, ScalarKind,
    StorageAccess, TypeInner,
};

/// One `var` with a `@group` and `@binding`.
pub(super) struct Binding {
    pub name: String,
    pub group: u32,
    pub entry: wgpu::BindGroupLayoutEntry,
    pub leaves: Vec<Leaf>,
    pub size: u32,
}

/// The error for a shader that the lab cannot run.
pub(super) fn unusable(file: &str, message: impl Into<String>) -> Error {
    Error::Shader {
        file: format!("shaders/{file}"),
        message: message.into(),
    }
}

/// naga_oil decorates the names of imported items with their module.
pub(super) fn plain_name(name: &str) -> String {
    name.split("X_naga_oil_mod_X")
        .next()
        .unwrap_or(name)
        .to_owned()
}

/// The bindings of a module's first entry point.
pub(super) fn reflect(module: &Module, file: &str) -> Result<Vec<Binding>> {
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
                ImageClass::Sampled { multi: false, kind } => wgpu::BindingType::Texture {
                    sample_type: match kind {
                        ScalarKind::Uint => wgpu::TextureSampleType::Uint,
                        _ => wgpu::TextureSampleType::Float {
                            filterable: filtered,
                        },
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
    use naga::StorageFormat as S;
    use wgpu::TextureFormat as T;
    Some(match format {
        S::R16Float => T::R16Float,
        S::Rg16Float => T::Rg16Float,
        S::Rgba16Float => T::Rgba16Float,
        S::R32Float => T::R32Float,
        S::Rg32Float => T::Rg32Float,
        S::Rgba32Float => T::Rgba32Float,
        S::R8Unorm => T::R8Unorm,
        S::Rg8Unorm => T::Rg8Unorm,
        S::Rgba8Unorm => T::Rgba8Unorm,
        S::R16Unorm => T::R16Unorm,
        S::Rg16Unorm => T::Rg16Unorm,
        S::Rgba16Unorm => T::Rgba16Unorm,
        S::R32Uint => T::R32Uint,
        S::Rg32Uint => T::Rg32Uint,
        S::Rgba32Uint => T::Rgba32Uint,
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
