//! Layouts of uniforms: reflected, packed, refused.

use super::{Composition, common, composed, method_defs};
use occlab::gpu::{Leaf, Scalar, UniformValue, pack, struct_leaves};
use occlab::shader_defs::Defs;

fn uniform_leaves(module: &naga::Module, name: &str) -> (Vec<Leaf>, u32) {
    let plain = |v: &naga::GlobalVariable| {
        v.name.as_deref().unwrap_or("").split("X_naga_oil").next() == Some(name)
    };
    let (_, variable) = module
        .global_variables
        .iter()
        .find(|(_, v)| plain(v))
        .unwrap();
    (
        struct_leaves(module, variable.ty),
        module.types[variable.ty].inner.size(module.to_ctx()),
    )
}

fn two_decks() -> naga::Module {
    let around = Composition {
        container: "container/shell.wgsl",
        density: "density/procedural.wgsl".to_owned(),
        defs: Defs::from([
            ("DECKS".into(), Some(2)),
            ("DETAIL".into(), None),
            ("PRECIPITATION".into(), None),
        ]),
    };
    composed(
        "raymarch.wgsl",
        &common::setup("truth", ""),
        &around,
        method_defs(&common::setup("truth", ""), false),
    )
}

/// Offsets by the layout rules of the WGSL specification (§ 14.4), worked out by hand.
#[test]
fn reflected_offsets_follow_the_specification() {
    let module = two_decks();
    let offsets = |name: &str| -> Vec<(String, u32)> {
        uniform_leaves(&module, name)
            .0
            .into_iter()
            .map(|l| (l.path, l.offset))
            .collect()
    };
    let listed = |pairs: &[(&str, u32)]| -> Vec<(String, u32)> {
        pairs.iter().map(|(n, o)| ((*n).to_owned(), *o)).collect()
    };
    let frame = [
        ("camera_position_m", 0),
        ("far_m", 12),
        ("camera_right", 16),
        ("steps", 28),
        ("camera_up", 32),
        ("step_m", 44),
        ("camera_forward", 48),
        ("jitter", 60),
        ("sun_direction", 64),
        ("skip", 76),
        ("sun_irradiance", 80),
        ("extinction_per_m", 92),
        ("phase", 96),
        ("image_size", 112),
        ("albedo", 120),
    ];
    assert_eq!(offsets("frame"), listed(&frame));
    assert_eq!(uniform_leaves(&module, "frame").1, 128);
    let field = [
        ("weather_frequency_per_m", 0),
        ("shape_frequency_per_m", 4),
        ("detail_frequency_per_m", 8),
        ("detail_strength", 12),
        ("precipitation_gain", 16),
        ("decks[0].profile", 32),
        ("decks[0].cover", 48),
        ("decks[1].profile", 64),
        ("decks[1].cover", 80),
    ];
    assert_eq!(offsets("field"), listed(&field));
    assert_eq!(uniform_leaves(&module, "field").1, 96);
}

#[test]
fn packing_puts_every_value_at_its_offset_and_refuses_mistakes() {
    let (leaves, size) = uniform_leaves(&two_decks(), "frame");
    let value = |i: usize, leaf: &Leaf| {
        let v = i as f32 + 1.0;
        match (leaf.kind, leaf.components) {
            (Scalar::Float, 1) => UniformValue::F32(v),
            (Scalar::Float, 3) => UniformValue::Vec3([v, v + 0.25, v + 0.5]),
            (Scalar::Float, 4) => UniformValue::Vec4([v, v + 0.25, v + 0.5, v + 0.75]),
            (Scalar::Uint, 1) => UniformValue::U32(1000 + i as u32),
            (Scalar::Uint, 2) => UniformValue::UVec2([1000 + i as u32, 2000]),
            other => panic!("{other:?}"),
        }
    };
    let values: Vec<_> = leaves
        .iter()
        .enumerate()
        .map(|(i, l)| (l.path.clone(), value(i, l)))
        .collect();
    let bytes = pack("frame", &leaves, size, &values).unwrap();
    assert_eq!(bytes.len(), 128);
    let word = |offset: usize| u32::from_le_bytes(bytes[offset..offset + 4].try_into().unwrap());
    assert_eq!(f32::from_bits(word(0)), 1.0);
    assert_eq!(
        f32::from_bits(word(12)),
        2.0,
        "far_m shares the last word of the position"
    );
    assert_eq!(word(28), 1003);
    assert_eq!(f32::from_bits(word(108)), 13.75, "w of the phase");
    assert_eq!((word(112), word(116)), (1013, 2000));
    assert_eq!(word(124), 0, "padding");

    let without = &values[1..];
    assert!(
        pack("frame", &leaves, size, without)
            .unwrap_err()
            .to_string()
            .contains("camera_position_m")
    );
    let mut wrong = values.clone();
    wrong[1].1 = UniformValue::U32(1);
    assert!(
        pack("frame", &leaves, size, &wrong)
            .unwrap_err()
            .to_string()
            .contains("far_m")
    );
    wrong[1].1 = UniformValue::Vec2([1.0; 2]);
    assert!(
        pack("frame", &leaves, size, &wrong).is_err(),
        "two components where one is declared"
    );
}
