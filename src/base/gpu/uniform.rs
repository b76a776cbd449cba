//! Uniform buffers filled by member name from naga's reflection: no struct is kept in sync by hand.

use crate::error::{Error, Result};
use naga::{Handle, Module, ScalarKind, Type, TypeInner};

/// A value for one member of a uniform struct.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum UniformValue {
    /// `f32`
    F32(f32),
    /// `u32`
    U32(u32),
    /// `vec2f`
    Vec2([f32; 2]),
    /// `vec3f`
    Vec3([f32; 3]),
    /// `vec4f`
    Vec4([f32; 4]),
    /// `vec2u`
    UVec2([u32; 2]),
}

/// Scalar kind of a leaf.
pub type Scalar = ScalarKind;

/// One scalar or vector inside a uniform struct.
#[derive(Clone, Debug, PartialEq)]
pub struct Leaf {
    /// `decks[0].base_m`
    pub path: String,
    /// Byte offset in the buffer.
    pub offset: u32,
    /// Kind of its components.
    pub kind: ScalarKind,
    /// Components, 1…4.
    pub components: u32,
}

impl UniformValue {
    fn bytes(&self) -> (ScalarKind, Vec<u8>) {
        match self {
            Self::F32(v) => (ScalarKind::Float, bytemuck::bytes_of(v).to_vec()),
            Self::U32(v) => (ScalarKind::Uint, bytemuck::bytes_of(v).to_vec()),
            Self::Vec2(v) => (ScalarKind::Float, bytemuck::bytes_of(v).to_vec()),
            Self::Vec3(v) => (ScalarKind::Float, bytemuck::bytes_of(v).to_vec()),
            Self::Vec4(v) => (ScalarKind::Float, bytemuck::bytes_of(v).to_vec()),
            Self::UVec2(v) => (ScalarKind::Uint, bytemuck::bytes_of(v).to_vec()),
        }
    }
}

/// The leaves of a struct type, in memory order.
pub fn struct_leaves(module: &Module, ty: Handle<Type>) -> Vec<Leaf> {
    let mut leaves = Vec::new();
    collect(module, ty, String::new(), 0, &mut leaves);
    leaves
}

fn collect(module: &Module, ty: Handle<Type>, path: String, offset: u32, out: &mut Vec<Leaf>) {
    match &module.types[ty].inner {
        TypeInner::Scalar(s) => out.push(Leaf {
            path,
            offset,
            kind: s.kind,
            components: 1,
        }),
        TypeInner::Vector { size, scalar } => out.push(Leaf {
            path,
            offset,
            kind: scalar.kind,
            components: *size as u32,
        }),
        TypeInner::Struct { members, .. } => {
            for member in members {
                let name = member.name.as_deref().unwrap_or("?");
                let path = if path.is_empty() {
                    name.to_owned()
                } else {
                    format!("{path}.{name}")
                };
                collect(module, member.ty, path, offset + member.offset, out);
            }
        }
        TypeInner::Array {
            base,
            size: naga::ArraySize::Constant(n),
            stride,
        } => {
            for i in 0..n.get() {
                collect(
                    module,
                    *base,
                    format!("{path}[{i}]"),
                    offset + i * stride,
                    out,
                );
            }
        }
        // Matrices and runtime arrays do not occur in our uniforms; a value for them would be reported as unknown.
        _ => {}
    }
}

/// Bytes of a uniform struct of `size` bytes; every leaf needs a value of its own type.
pub fn pack(
    name: &str,
    leaves: &[Leaf],
    size: u32,
    values: &[(String, UniformValue)],
) -> Result<Vec<u8>> {
    let unusable = |message: String| Error::Shader {
        file: format!("uniform `{name}`"),
        message,
    };
    let mut bytes = vec![0_u8; size as usize];
    for leaf in leaves {
        let value = values
            .iter()
            .find(|(path, _)| *path == leaf.path)
            .map(|(_, v)| v);
        let value =
            value.ok_or_else(|| unusable(format!("member `{}` has no value", leaf.path)))?;
        let (kind, data) = value.bytes();
        if kind != leaf.kind || data.len() != 4 * leaf.components as usize {
            return Err(unusable(format!(
                "member `{}` is {:?}×{}, the value is {value:?}",
                leaf.path, leaf.kind, leaf.components
            )));
        }
        let start = leaf.offset as usize;
        bytes[start..start + data.len()].copy_from_slice(&data);
    }
    Ok(bytes)
}
