//! Messages about files that people write use the words of JSON and of the files, not those of the program's language.

use super::damage::{cases, changed, changes};
use occlab::config::{expand, parse_experiment, parse_stability, parse_study};
use occlab::reconstruct::Registry;
use proptest::prelude::*;
use proptest::sample::select;
use serde_json::{Value, json};
use std::collections::HashSet;
use std::path::{Path, PathBuf};

/// Words of Rust and of its JSON library.
const FOREIGN: [&str; 34] = [
    "struct",
    "structs",
    "variant",
    "variants",
    "tuple",
    "enum",
    "newtype",
    "unit",
    "option",
    "map",
    "sequence",
    "seq",
    "identifier",
    "deserialize",
    "serde",
    "str",
    "bool",
    "boolean",
    "integer",
    "float",
    "floating",
    "char",
    "bytes",
    "f32",
    "f64",
    "u8",
    "u16",
    "u32",
    "u64",
    "i32",
    "i64",
    "usize",
    "isize",
    "expected",
];

/// The first word of a message that is not for people; what it quotes is not its own.
fn foreign(message: &str) -> Option<String> {
    let own = message.split_once("): ").map_or(message, |(_, own)| own);
    let without = |text: &str, mark: char| -> String {
        text.split(mark).step_by(2).collect::<Vec<_>>().join(" ")
    };
    let own = without(&without(own, '`'), '"');
    let words = own.split_whitespace().filter(|word| !word.contains('/'));
    let mut words = words.flat_map(|word| word.split(|c: char| !c.is_alphanumeric() && c != '_'));
    let is_type = |word: &str| {
        let letters: Vec<char> = word.chars().collect();
        let hump = |pair: &[char]| pair[0].is_lowercase() && pair[1].is_uppercase();
        letters.windows(2).any(hump) && !["NaN", "MiB", "GiB"].contains(&word)
    };
    let found = words.find(|word| FOREIGN.contains(&word.to_lowercase().as_str()) || is_type(word));
    found.map(str::to_owned)
}

/// A kind of file: its path, a valid one, and its reader.
struct Kind {
    file: PathBuf,
    good: Value,
    read: fn(&Path, String) -> occlab::Result<()>,
    /// Of the ways to damage a place, one in `every` is tried: large files have many similar places.
    every: usize,
}

impl Kind {
    fn new(file: &str, read: fn(&Path, String) -> occlab::Result<()>) -> Self {
        let file = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("configs")
            .join(file);
        let good = serde_json::from_slice(&std::fs::read(&file).unwrap()).unwrap();
        let every = if file.metadata().unwrap().len() > 8000 {
            4
        } else {
            1
        };
        Self {
            file,
            good,
            read,
            every,
        }
    }

    fn message(&self, value: &Value) -> Option<String> {
        let error = (self.read)(&self.file, value.to_string()).err()?;
        Some(error.to_string())
    }
}

fn scene(path: &Path, text: String) -> occlab::Result<()> {
    let image = r#"{"width": 4, "height": 3}"#;
    let inside = format!(
        r#"{{"name": "e", "image": {image}, "methods": "none", "scenes": {{"scene": {text}}}}}"#
    );
    experiment(path, inside)
}

fn experiment(path: &Path, text: String) -> occlab::Result<()> {
    expand(&parse_experiment(path, text)?, &Registry).map(drop)
}

fn study(path: &Path, text: String) -> occlab::Result<()> {
    parse_study(path, text, "quick").map(drop)
}

fn stability(path: &Path, text: String) -> occlab::Result<()> {
    parse_stability(path, text, Path::new("out"), &Registry).map(drop)
}

/// Every kind of file, and between them every kind of container, density, sky and ambient.
fn kinds() -> Vec<Kind> {
    let mut kinds = vec![
        Kind::new("scenes/two-decks.json", scene),
        Kind::new("scenes/volume.json", scene),
        Kind::new("witnesses/slab.json", scene),
        Kind::new("temporal.json", experiment),
        Kind::new("studies/m.json", study),
        Kind::new("stability.json", stability),
    ];
    kinds[0].good["sky"] = json!({"preetham": {"turbidity": 3, "ground_albedo": 0.2}});
    kinds[0].good["ambient"] = json!({"sky": {"base": 0.5, "top": 1}});
    kinds[0].good["march"] =
        json!({"steps": 8, "step_m": 20, "jitter": false, "integration": "thesis"});
    kinds[1].good["ambient"] = json!({"uniform": {"radiance": [1, 1, 1]}});
    kinds[2].good["density"] = json!({"uniform": {"value": 1}});
    kinds[3].good["scenes"] =
        json!([{"scene": "scenes/cumulus.json", "set": {"/camera/far_m": [9000]}}]);
    kinds[3].good["methods"] =
        json!(["none", {"method": "srm", "spacing": ["uniform_reach"], "reach_m": [10]}]);
    kinds[3].good["decompose"] = json!(false);
    kinds
}

/// One pointer for every place of the good file, of like elements of a list the first alone.
fn places(kind: &Kind) -> Vec<String> {
    fn below(
        value: &Value,
        at: &str,
        like: &str,
        seen: &mut HashSet<String>,
        out: &mut Vec<String>,
    ) {
        if seen.insert(like.to_owned()) {
            out.push(at.to_owned());
        }
        match value {
            Value::Object(members) => {
                for (key, inner) in members {
                    let step = key.replace('~', "~0").replace('/', "~1");
                    below(
                        inner,
                        &format!("{at}/{step}"),
                        &format!("{like}/{step}"),
                        seen,
                        out,
                    );
                }
            }
            Value::Array(items) => {
                for (i, inner) in items.iter().enumerate() {
                    below(inner, &format!("{at}/{i}"), &format!("{like}/#"), seen, out);
                }
            }
            _ => {}
        }
    }
    let mut out = Vec::new();
    below(&kind.good, "", "", &mut HashSet::new(), &mut out);
    out
}

fn wrong_values() -> Vec<Value> {
    vec![
        Value::Null,
        json!(true),
        json!(-1),
        json!(1.5),
        json!(1e300),
        json!("x"),
        json!([]),
        json!([1]),
        json!([[1, 2, 3, 4]]),
        json!({}),
        json!({"x": 1}),
        json!({"x": 1, "y": 2}),
    ]
}

/// The valid file with one place changed in every way: another value, an unknown name beside, the place left out.
fn spoilt(good: &Value, place: &str) -> Vec<Value> {
    let mut all = Vec::new();
    let mut add = |change: &dyn Fn(&mut Value)| {
        let mut value = good.clone();
        change(&mut value);
        all.push(value);
    };
    for wrong in wrong_values() {
        add(&|v| *v.pointer_mut(place).unwrap() = wrong.clone());
    }
    add(&|v| {
        if let Some(Value::Object(members)) = v.pointer_mut(place) {
            members.insert("nmae".to_owned(), json!(1));
        }
    });
    if let Some((parent, last)) = place.rsplit_once('/') {
        let last = last.replace("~1", "/").replace("~0", "~");
        add(&|v| {
            if let Some(Value::Object(members)) = v.pointer_mut(parent) {
                members.shift_remove(&last);
            }
        });
    }
    all
}

#[test]
fn a_wrong_value_at_any_place_of_any_file_is_answered_in_the_words_of_the_file() {
    for kind in kinds() {
        assert_eq!(kind.message(&kind.good), None);
        let mut refused = 0;
        for (nth, place) in places(&kind).iter().enumerate() {
            for value in spoilt(&kind.good, place)
                .into_iter()
                .skip(nth % kind.every)
                .step_by(kind.every)
            {
                let Some(message) = kind.message(&value) else {
                    continue;
                };
                refused += 1;
                println!("{message}");
                assert_eq!(foreign(&message), None, "{message}");
            }
        }
        assert!(refused > 100, "{}: {refused}", kind.file.display());
    }
}

#[test]
fn words_of_the_program_are_recognised_and_quoted_ones_are_not() {
    for foreign_text in [
        "a.json:1:1 (at /x): invalid type: map, expected f64. Correct it.",
        "a.json:1:1 (at /x): expected struct variant Density::Uniform. Correct it.",
        "a.json:1:1 (at /x): not a FileProfile. Correct it.",
    ] {
        assert!(foreign(foreign_text).is_some(), "{foreign_text}");
    }
    let good = "a.json:1:1 (at /map): there is no `map`, the value is \"unit\", allowed is a number at /map. Correct it.";
    assert_eq!(foreign(good), None);
}

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn any_changes_of_any_file(kind in select(vec![0_usize, 1, 2, 3, 5]), changes in changes()) {
        let kind = &kinds()[kind];
        let value = changed(kind.good.clone(), &changes);
        // A quotation mark inside a quotation would end it.
        let marked = value.to_string().contains(['`', '\\']);
        if let Some(message) = kind.message(&value).filter(|_| !marked) {
            prop_assert_eq!(foreign(&message), None, "{}", message);
        }
    }
}
