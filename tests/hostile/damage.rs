//! Damage to files of bytes and to JSON values. The library's own tests use it too.
#![allow(dead_code, reason = "each test binary uses its own part")]

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::{Index, select};
use proptest::test_runner::Config;
use serde_json::{Map, Number, Value};

/// Cases from `PROPTEST_CASES`, else 256. Failures print their input, from which a test of its own is then made.
pub fn cases() -> Config {
    Config {
        failure_persistence: None,
        ..Config::default()
    }
}

/// One change to a file.
#[derive(Clone, Debug)]
pub enum Edit {
    Byte(Index, u8),
    Bit(Index, u8),
    /// A 32-bit number where a size, an offset or a count may stand.
    Word(Index, u32),
    Cut(Index),
    Insert(Index, Vec<u8>),
    Remove(Index, usize),
    Repeat(Index, usize),
}

/// Numbers at which sizes and their products overflow.
pub const WORDS: [u32; 14] = [
    0,
    1,
    2,
    0xff,
    0x100,
    0x7fff,
    0xffff,
    0x1_0000,
    0x0100_0000,
    0x7fff_fffe,
    0x7fff_ffff,
    0x8000_0000,
    0xffff_fffe,
    0xffff_ffff,
];

pub fn edits() -> impl Strategy<Value = Vec<Edit>> {
    let at = any::<Index>;
    let edit = prop_oneof![
        4 => (at(), any::<u8>()).prop_map(|(i, b)| Edit::Byte(i, b)),
        3 => (at(), 0_u8..8).prop_map(|(i, b)| Edit::Bit(i, b)),
        4 => (at(), select(&WORDS[..])).prop_map(|(i, w)| Edit::Word(i, w)),
        1 => at().prop_map(Edit::Cut),
        1 => (at(), vec(any::<u8>(), 1..20)).prop_map(|(i, b)| Edit::Insert(i, b)),
        1 => (at(), 1_usize..40).prop_map(|(i, n)| Edit::Remove(i, n)),
        1 => (at(), 1_usize..40).prop_map(|(i, n)| Edit::Repeat(i, n)),
    ];
    vec(edit, 1..6)
}

/// `within` confines the edits to the first bytes of the file: headers are small, and damage there is what matters.
pub fn damaged(file: &[u8], edits: &[Edit], within: usize) -> Vec<u8> {
    let mut bytes = file.to_vec();
    for edit in edits {
        let reach = bytes.len().min(within);
        if reach == 0 {
            break;
        }
        match edit {
            Edit::Byte(i, b) => bytes[i.index(reach)] = *b,
            Edit::Bit(i, b) => bytes[i.index(reach)] ^= 1 << b,
            Edit::Word(i, word) => {
                let at = i.index(reach);
                let end = bytes.len().min(at + 4);
                bytes[at..end].copy_from_slice(&word.to_le_bytes()[..end - at]);
            }
            Edit::Cut(i) => bytes.truncate(i.index(reach)),
            Edit::Insert(i, extra) => {
                let at = i.index(reach);
                bytes.splice(at..at, extra.iter().copied());
            }
            Edit::Remove(i, n) => {
                let at = i.index(reach);
                bytes.drain(at..bytes.len().min(at + n));
            }
            Edit::Repeat(i, n) => {
                let at = i.index(reach);
                let part = bytes[at..bytes.len().min(at + n)].to_vec();
                bytes.splice(at..at, part);
            }
        }
    }
    bytes
}

/// Strings that mean something to a page, a path, a terminal, a pointer or a spreadsheet.
pub fn text() -> impl Strategy<Value = String> {
    prop_oneof![
        3 => select(vec![
            "", "<script>alert(1)</script>", "../../../etc/passwd", "..", "/", "C:\\x", "a b", "\u{0}", "\n",
            "\u{1b}[2J", "\u{202e}abc", "~0~1", "/a/b", "NaN", "'\"&<>", "=1+1", "名前", "🌥", "\u{feff}", "null",
        ]).prop_map(str::to_owned),
        2 => "\\PC{0,12}",
        1 => "[a-z_]{1,10}",
        1 => (1_usize..400).prop_map(|n| "x".repeat(n)),
    ]
}

fn number() -> impl Strategy<Value = Value> {
    prop_oneof![
        any::<i64>().prop_map(Value::from),
        any::<u64>().prop_map(Value::from),
        (-3_i64..300).prop_map(Value::from),
        any::<f64>().prop_map(|v| Number::from_f64(v).map_or(Value::Null, Value::Number)),
        select(vec![
            0.0, -0.0, 0.5, 1e-320, -1e-320, 1e-12, 1e9, 1e12, 1e30, 3.5e38, 1e308, -1e308, 90.0,
            360.0,
        ])
        .prop_map(Value::from),
    ]
}

/// Any JSON value, a few levels deep.
pub fn json() -> impl Strategy<Value = Value> {
    let leaf = prop_oneof![
        Just(Value::Null),
        any::<bool>().prop_map(Value::Bool),
        number(),
        text().prop_map(Value::String),
    ];
    leaf.prop_recursive(5, 40, 6, |inner| {
        prop_oneof![
            vec(inner.clone(), 0..6).prop_map(Value::Array),
            vec((text(), inner), 0..6)
                .prop_map(|m| Value::Object(m.into_iter().collect::<Map<_, _>>())),
        ]
    })
}

/// One change to a JSON value at a random place in it.
#[derive(Clone, Debug)]
pub enum Change {
    Replace(Index, Value),
    Scale(Index, f64),
    Delete(Index),
    AddKey(Index, String, Value),
    Wrap(Index),
    Swap(Index, Index),
}

pub fn changes() -> impl Strategy<Value = Vec<Change>> {
    let at = any::<Index>;
    let factor = select(vec![
        -1.0, 0.0, 1e-300, 1e-9, 0.1, 0.999, 1.001, 2.0, 1e3, 1e9, 1e300,
    ]);
    let change = prop_oneof![
        3 => (at(), json()).prop_map(|(i, v)| Change::Replace(i, v)),
        4 => (at(), number()).prop_map(|(i, v)| Change::Replace(i, v)),
        4 => (at(), factor).prop_map(|(i, f)| Change::Scale(i, f)),
        1 => (at(), text().prop_map(Value::String)).prop_map(|(i, v)| Change::Replace(i, v)),
        2 => at().prop_map(Change::Delete),
        2 => (at(), text(), json()).prop_map(|(i, k, v)| Change::AddKey(i, k, v)),
        1 => at().prop_map(Change::Wrap),
        1 => (at(), at()).prop_map(|(a, b)| Change::Swap(a, b)),
    ];
    vec(change, 1..4)
}

/// Pointers to every value inside `value`, itself included.
fn places(value: &Value, at: &str, out: &mut Vec<String>) {
    out.push(at.to_owned());
    match value {
        Value::Object(map) => {
            for (key, inner) in map {
                let step = key.replace('~', "~0").replace('/', "~1");
                places(inner, &format!("{at}/{step}"), out);
            }
        }
        Value::Array(list) => {
            for (i, inner) in list.iter().enumerate() {
                places(inner, &format!("{at}/{i}"), out);
            }
        }
        _ => {}
    }
}

pub fn changed(mut value: Value, changes: &[Change]) -> Value {
    for change in changes {
        let mut all = Vec::new();
        places(&value, "", &mut all);
        let pick = |i: &Index| all[i.index(all.len())].clone();
        match change {
            Change::Replace(i, new) => edit(&mut value, &pick(i), |v| *v = new.clone()),
            Change::Scale(i, factor) => edit(&mut value, &pick(i), |v| {
                if let Some(number) = v.as_f64().and_then(|n| Number::from_f64(n * factor)) {
                    *v = Value::Number(number);
                }
            }),
            Change::Delete(i) => {
                let place = pick(i);
                if let Some((parent, last)) = place.rsplit_once('/') {
                    edit(&mut value, parent, |v| match v {
                        Value::Object(map) => drop(map.shift_remove(last)),
                        Value::Array(list) => drop(list.pop()),
                        _ => {}
                    });
                }
            }
            Change::AddKey(i, key, new) => edit(&mut value, &pick(i), |v| match v {
                Value::Object(map) => drop(map.insert(key.clone(), new.clone())),
                Value::Array(list) => list.push(new.clone()),
                _ => {}
            }),
            Change::Wrap(i) => edit(&mut value, &pick(i), |v| *v = Value::Array(vec![v.take()])),
            Change::Swap(a, b) => {
                let (a, b) = (pick(a), pick(b));
                let other = value.pointer(&b).cloned().unwrap_or_default();
                let one = value.pointer(&a).cloned().unwrap_or_default();
                edit(&mut value, &a, |v| *v = other);
                edit(&mut value, &b, |v| *v = one);
            }
        }
    }
    value
}

fn edit(value: &mut Value, pointer: &str, change: impl FnOnce(&mut Value)) {
    if let Some(place) = value.pointer_mut(pointer) {
        change(place);
    }
}
