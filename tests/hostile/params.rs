//! `NAME=VALUE` of the command line, parameters of a method, uniform buffers.

use super::damage::{cases, json, text};
use occlab::gpu::{Leaf, Scalar, UniformValue, pack};
use occlab::occlusion::{MethodSetup, REGISTRY};
use occlab::param::{ParamKind, ParamSpec, ParamValue};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::select;

fn specs() -> Vec<&'static ParamSpec> {
    REGISTRY.iter().flat_map(|m| m.info().specs()).collect()
}

/// Text of a value as a user may type it.
fn typed() -> impl Strategy<Value = String> {
    prop_oneof![
        3 => text(),
        3 => any::<f64>().prop_map(|v| v.to_string()),
        3 => any::<i64>().prop_map(|v| v.to_string()),
        2 => (0_i64..2000).prop_map(|v| v.to_string()),
        1 => json().prop_map(|v| v.to_string()),
        1 => select(vec!["1e999", "-0", "0x10", "1_000", " 5", "5 ", "+5", "5.0", "\"f16\"", "f16", "NaN", "inf"])
            .prop_map(str::to_owned),
    ]
}

fn is_allowed(spec: &ParamSpec, value: ParamValue) -> bool {
    match (spec.kind, value) {
        (ParamKind::Int { min, max, .. }, ParamValue::Int(v)) => (min..=max).contains(&v),
        (ParamKind::Float { min, max, .. }, ParamValue::Float(v)) => (min..=max).contains(&v),
        (ParamKind::Choice { options, .. }, ParamValue::Choice(v)) => options.contains(&v),
        _ => false,
    }
}

fn value() -> impl Strategy<Value = UniformValue> {
    prop_oneof![
        any::<f32>().prop_map(UniformValue::F32),
        any::<u32>().prop_map(UniformValue::U32),
        any::<[f32; 2]>().prop_map(UniformValue::Vec2),
        any::<[f32; 3]>().prop_map(UniformValue::Vec3),
        any::<[f32; 4]>().prop_map(UniformValue::Vec4),
        any::<[u32; 2]>().prop_map(UniformValue::UVec2),
    ]
}

fn shape(value: &UniformValue) -> (Scalar, u32) {
    match value {
        UniformValue::F32(_) => (Scalar::Float, 1),
        UniformValue::U32(_) => (Scalar::Uint, 1),
        UniformValue::Vec2(_) => (Scalar::Float, 2),
        UniformValue::Vec3(_) => (Scalar::Float, 3),
        UniformValue::Vec4(_) => (Scalar::Float, 4),
        UniformValue::UVec2(_) => (Scalar::Uint, 2),
    }
}

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn any_text_of_a_parameter(spec in select(specs()), text in typed()) {
        match spec.parse_text(&text) {
            Ok(value) => {
                prop_assert!(is_allowed(spec, value));
                prop_assert_eq!(spec.parse_text(&value.to_string()), Ok(value));
            }
            Err(problem) => prop_assert!(problem.contains(spec.name) && problem.contains(&spec.range_text())),
        }
    }

    #[test]
    fn any_name_and_text_of_a_method(id in prop_oneof![select(ids()), text()], name in prop_oneof![select(names()), text()], text in typed()) {
        match MethodSetup::defaults(&id).and_then(|setup| setup.with(&name, &text)) {
            Ok(setup) => {
                for spec in setup.method.info().specs() {
                    prop_assert!(is_allowed(spec, setup.params.get(spec.name).unwrap()));
                }
                prop_assert!(setup.method.plan(&setup.params).is_ok());
            }
            Err(error) => {
                let message = error.to_string();
                prop_assert!(!message.chars().any(char::is_control) && message.chars().count() < 5000, "{}", message);
            }
        }
    }

    /// Members get their own values and nothing else changes; a missing or wrong one is an error.
    #[test]
    fn any_uniform(members in vec((value(), 0_u32..3, 0_u8..12), 0..8)) {
        let mut offset = 0;
        let mut leaves = Vec::new();
        let mut values = Vec::new();
        let mut good = true;
        for (i, (value, gap, fate)) in members.iter().enumerate() {
            offset += 4 * gap;
            let (kind, components) = shape(value);
            let kind = match fate {
                0 => { good = false; Scalar::Sint }
                _ => kind,
            };
            let path = format!("m[{i}]");
            leaves.push(Leaf { path: path.clone(), offset, kind, components });
            offset += 4 * components;
            match fate {
                1 => good = false,
                _ => values.push((path, *value)),
            }
        }
        let packed = pack("test", &leaves, offset, &values);
        prop_assert_eq!(packed.is_ok(), good);
        if let Ok(bytes) = packed {
            prop_assert_eq!(bytes.len(), offset as usize);
            for (leaf, (value, ..)) in leaves.iter().zip(&members) {
                let words: Vec<u32> = match value {
                    UniformValue::F32(v) => vec![v.to_bits()],
                    UniformValue::U32(v) => vec![*v],
                    UniformValue::Vec2(v) => v.map(f32::to_bits).to_vec(),
                    UniformValue::Vec3(v) => v.map(f32::to_bits).to_vec(),
                    UniformValue::Vec4(v) => v.map(f32::to_bits).to_vec(),
                    UniformValue::UVec2(v) => v.to_vec(),
                };
                let expected: Vec<u8> = words.iter().flat_map(|w| w.to_ne_bytes()).collect();
                let at = leaf.offset as usize;
                prop_assert_eq!(&bytes[at..at + expected.len()], &expected[..]);
            }
        }
    }
}

fn ids() -> Vec<String> {
    REGISTRY.iter().map(|m| m.info().id.to_owned()).collect()
}

fn names() -> Vec<String> {
    specs().iter().map(|s| s.name.to_owned()).collect()
}
