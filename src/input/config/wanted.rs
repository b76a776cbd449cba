//! Plain-English description of what a place of a file may hold, from the JSON Schema of its type.
//!
//! serde's messages say where a value does not fit, but in Rust's terms (`expected struct variant`, `expected f64`):
//! only their place and kind are used.

use super::document::Fault;
use super::locate::{self, MemberPart};
use super::suggest;
use serde_json::{Map, Value};

/// Longest text quoted from a file, characters.
const MAX_QUOTED_CHARS: usize = 60;

/// The schema of a type, and the part of it that stands for one place.
#[derive(Clone, Copy)]
struct Wanted<'a> {
    root: &'a Value,
    here: &'a Value,
}

/// The fault of `value` at `pointer`, from serde's `message`; `schema` is that of the whole value's type.
pub(super) fn fault(schema: &Value, value: &Value, pointer: &str, message: &str) -> Fault {
    let root = Wanted {
        root: schema,
        here: schema,
    };
    let quoted = |start: &str| {
        let rest = message.strip_prefix(start)?;
        rest.split('`').nth(1).map(str::to_owned)
    };
    if let Some(name) = quoted("missing field ") {
        let wanted = root.at(&format!("{pointer}{}", locate::step(&name)));
        return missing(pointer, &name, wanted);
    }
    if let Some(name) = quoted("unknown field ") {
        let parent = pointer
            .strip_suffix(&locate::step(&name))
            .unwrap_or(pointer);
        return unknown(pointer, &name, root.at(parent));
    }
    // Given a list in place of an object, serde reads its elements as members: report the list itself.
    let mut place = pointer;
    while root.at(place).is_none() {
        place = place.rsplit_once('/').map_or("", |(parent, _)| parent);
    }
    misfit(place, value.pointer(place).unwrap_or(value), root.at(place))
}

fn missing(pointer: &str, name: &str, wanted: Option<Wanted<'_>>) -> Fault {
    let words = wanted.and_then(Wanted::words);
    let problem = match words {
        Some(words) => format!("missing field `{name}`: {words}"),
        None => format!("missing field `{name}`"),
    };
    Fault::new(MemberPart::Value, pointer, problem, "Add it; ")
}

fn unknown(pointer: &str, name: &str, object: Option<Wanted<'_>>) -> Fault {
    let known = object.map(Wanted::fields).unwrap_or_default();
    let hint = suggest::sentence(name, known.iter().map(String::as_str));
    let remedy = match known.len() {
        0 => hint,
        _ => format!("{hint}Allowed are {}; ", list(&known)),
    };
    Fault::new(
        MemberPart::Key,
        pointer,
        format!("unknown field `{name}`"),
        remedy,
    )
}

fn misfit(pointer: &str, value: &Value, wanted: Option<Wanted<'_>>) -> Fault {
    let found = shown(value);
    let Some((wanted, words)) = wanted.and_then(|w| Some((w, w.words()?))) else {
        let problem = format!("the value is {found}, which does not belong here");
        return Fault::new(MemberPart::Value, pointer, problem, "");
    };
    let problem = format!("the value is {found}, allowed is {words}");
    let names = wanted.names();
    let written = match value {
        Value::String(word) => Some(word.as_str()),
        Value::Object(members) => members.keys().next().map(String::as_str),
        _ => None,
    };
    let hint = written.map(|word| suggest::sentence(word, names.iter().map(String::as_str)));
    let remedy = match wanted.wrapped(value) {
        Some(example) => format!("Write {example}; "),
        None => hint.unwrap_or_default(),
    };
    Fault {
        wants_list: wanted.is_list(),
        ..Fault::new(MemberPart::Value, pointer, problem, remedy)
    }
}

impl<'a> Wanted<'a> {
    /// The schema that `here` refers to, where it is a reference.
    fn resolved(self) -> Self {
        let target = self.here["$ref"]
            .as_str()
            .and_then(|reference| self.root.pointer(reference.strip_prefix('#')?));
        match target {
            Some(here) => Self { here, ..self }.resolved(),
            None => self,
        }
    }

    fn with(self, here: &'a Value) -> Self {
        Self { here, ..self }.resolved()
    }

    /// Alternative schemas (`anyOf`, `oneOf`) of which one must match; only this one where there are none.
    fn alternatives(self) -> Vec<Self> {
        let this = self.resolved();
        let lists = ["anyOf", "oneOf"].map(|key| this.here[key].as_array());
        match lists.into_iter().flatten().next() {
            Some(list) => list
                .iter()
                .flat_map(|here| self.with(here).alternatives())
                .collect(),
            None => vec![this],
        }
    }

    /// The schema of the value at `pointer` below this one.
    fn at(self, pointer: &str) -> Option<Self> {
        locate::steps(pointer).try_fold(self, |wanted, name| {
            wanted
                .alternatives()
                .into_iter()
                .find_map(|one| one.member(&name))
        })
    }

    fn member(self, name: &str) -> Option<Self> {
        let here = self.here;
        let index = name.parse::<usize>().ok();
        let member = here["properties"].get(name);
        let member = member.or_else(|| here["prefixItems"].get(index?));
        let member = member.or_else(|| index.and(here.get("items")));
        let member = member.or_else(|| here.get("additionalProperties").filter(|v| v.is_object()));
        member.map(|here| self.with(here))
    }

    fn properties(self) -> Option<&'a Map<String, Value>> {
        self.here["properties"].as_object()
    }

    /// Member names that an object may have here.
    fn fields(self) -> Vec<String> {
        let alternatives = self.alternatives().into_iter();
        let names = alternatives
            .filter_map(Self::properties)
            .flat_map(Map::keys);
        names.cloned().collect()
    }

    /// Strings and member names of which one may be written here.
    fn names(self) -> Vec<String> {
        let mut names = self.fields();
        names.extend(self.alternatives().iter().flat_map(|one| one.constants()));
        names
    }

    /// The strings that this schema allows by `const` or `enum`.
    fn constants(self) -> Vec<String> {
        let one = self.here["const"].as_str().into_iter();
        let many = self.here["enum"].as_array().into_iter().flatten();
        one.chain(many.filter_map(Value::as_str))
            .map(str::to_owned)
            .collect()
    }

    fn is(self, kind: &str) -> bool {
        match &self.here["type"] {
            Value::String(only) => only == kind,
            Value::Array(several) => several.iter().any(|one| one == kind),
            _ => false,
        }
    }

    fn is_list(self) -> bool {
        self.alternatives().iter().any(|one| one.is("array"))
    }

    /// The only member that its objects must and may have: it tells one variant from the others.
    fn tag(self) -> Option<&'a str> {
        let properties = self.properties()?;
        let required = self.here["required"].as_array()?;
        let closed = self.here["additionalProperties"] == false;
        match (properties.keys().next(), properties.len(), required.len()) {
            (Some(name), 1, 1) if closed => Some(name),
            _ => None,
        }
    }

    /// `value` as the only member of such an object, where the schema wants one and the member may be `value`.
    fn wrapped(self, value: &Value) -> Option<String> {
        let alternatives = self.alternatives();
        let [one] = alternatives.as_slice() else {
            return None;
        };
        let name = one.tag()?;
        let simple = matches!(value, Value::Number(_) | Value::String(_) | Value::Bool(_));
        (simple && one.member(name)?.takes(value))
            .then(|| format!("{{\"{name}\": {}}}", shown(value)))
    }

    fn takes(self, value: &Value) -> bool {
        self.alternatives().iter().any(|one| match value {
            Value::Number(n) => one.is("number") || one.is("integer") && n.is_i64(),
            Value::String(_) => one.is("string") && one.constants().is_empty(),
            Value::Bool(_) => one.is("boolean"),
            _ => false,
        })
    }

    /// Description of what is allowed here; `None` where anything is.
    fn words(self) -> Option<String> {
        let all = self.alternatives();
        let constants: Vec<String> = all.iter().flat_map(|one| one.constants()).collect();
        let mut words = Vec::new();
        if !constants.is_empty() {
            words.push(one_of("", &constants));
        }
        let plain = all.iter().filter(|one| one.constants().is_empty());
        let (objects, others): (Vec<Self>, Vec<Self>) = plain.partition(|one| one.tag().is_some());
        match objects.as_slice() {
            [] => {}
            [one] => words.push(one.object()),
            several => {
                let tags: Vec<String> = several
                    .iter()
                    .filter_map(|o| o.tag())
                    .map(str::to_owned)
                    .collect();
                words.push(one_of("an object with ", &tags));
            }
        }
        for one in others {
            words.extend(one.kinds()?);
        }
        words.sort_by_key(|word| word == "null");
        words.dedup();
        let listed = words.iter().any(|word| word.contains(','));
        let or = if listed { ", or " } else { " or " };
        (!words.is_empty()).then(|| words.join(or))
    }

    /// The JSON types that the schema allows; `None` where it names none.
    fn kinds(self) -> Option<Vec<String>> {
        let types = match &self.here["type"] {
            Value::String(only) => vec![only.as_str()],
            Value::Array(several) => several.iter().filter_map(Value::as_str).collect(),
            _ => return None,
        };
        let words = |kind: &&str| match *kind {
            "number" => format!("a number{}", self.range()),
            "integer" => format!("a whole number{}", self.range()),
            "string" => "a text in quotes".to_owned(),
            "boolean" => "`true` or `false`".to_owned(),
            "array" => self.list(),
            "object" => self.object(),
            _ => "null".to_owned(),
        };
        Some(types.iter().map(words).collect())
    }

    /// Limits of a number: `, 1…4096`.
    fn range(self) -> String {
        let limit = |key: &str| self.here[key].as_f64();
        match (limit("minimum"), limit("maximum")) {
            (Some(min), Some(max)) => format!(", {min}…{max}"),
            (Some(min), None) => format!(", {min} or more"),
            (None, Some(max)) => format!(", at most {max}"),
            (None, None) => String::new(),
        }
    }

    fn list(self) -> String {
        let length = (self.here["minItems"].as_u64()).filter(|n| self.here["maxItems"] == *n);
        if let Some(parts) = self.here["prefixItems"].as_array() {
            let words = parts.iter().map(|here| self.with(here).words());
            let words: Vec<String> = words.map(|w| w.unwrap_or("any value".to_owned())).collect();
            return format!("a list of {}: {}", parts.len(), words.join(", then "));
        }
        let items = self
            .here
            .get("items")
            .and_then(|here| self.with(here).words());
        let each = match items.as_deref() {
            None => String::new(),
            Some("a number") => " numbers".to_owned(),
            Some("a text in quotes") => " texts in quotes".to_owned(),
            Some(words) => format!(", each {words}"),
        };
        match (length, each.strip_prefix(' ')) {
            (Some(n), _) => format!("a list of {n}{each}"),
            (None, Some(plural)) => format!("a list of {plural}"),
            (None, None) => format!("a list{each}"),
        }
    }

    fn object(self) -> String {
        let Some(properties) = self.properties() else {
            return "an object".to_owned();
        };
        let required = self.here["required"].as_array();
        let is_required = |name: &&String| required.is_some_and(|r| r.iter().any(|n| n == *name));
        let (must, may): (Vec<&String>, Vec<&String>) = properties.keys().partition(is_required);
        match (must.is_empty(), may.is_empty()) {
            (false, true) => format!("an object with {}", list(&must)),
            (true, false) => format!("an object that may have {}", list(&may)),
            (false, false) => {
                format!(
                    "an object with {}, and if wanted {}",
                    list(&must),
                    list(&may)
                )
            }
            (true, true) => "an object".to_owned(),
        }
    }
}

/// `one of` several names, or the only one.
fn one_of(what: &str, names: &[String]) -> String {
    match names {
        [only] => format!("{what}`{only}`"),
        several => format!("{what}one of {}", list(several)),
    }
}

fn list(names: &[impl std::fmt::Display]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    quoted.join(", ")
}

/// A value as messages quote it: whole where it is short.
fn shown(value: &Value) -> String {
    match value {
        Value::Object(members) if members.len() == 1 => {
            let name = members.keys().next().map_or("", String::as_str);
            format!("an object with `{}`", cut(name))
        }
        Value::Object(members) if members.is_empty() => "an empty object".to_owned(),
        Value::Object(members) => format!("an object with {} names", members.len()),
        Value::Array(list) if list.is_empty() => "an empty list".to_owned(),
        Value::Array(list) => format!("a list of {}", list.len()),
        other => cut(&other.to_string()),
    }
}

fn cut(text: &str) -> String {
    if text.chars().count() <= MAX_QUOTED_CHARS {
        return text.to_owned();
    }
    let start: String = text.chars().take(MAX_QUOTED_CHARS).collect();
    format!("{start}…")
}
