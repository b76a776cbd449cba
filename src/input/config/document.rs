//! A strict JSON file in memory: its values, and the line and column of each for error messages.

use super::locate::{self, LineCol, MemberPart};
use super::{shipped, wanted};
use crate::error::{Error, Result};
use crate::scene::Problem;
use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde::de::DeserializeOwned;
use serde_json::Value;
use serde_path_to_error::Segment;
use std::collections::BTreeMap;
use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Largest file read, bytes: a configuration is kilobytes, so a larger one is the wrong file.
pub const MAX_FILE_BYTES: u64 = 16 << 20;

const SCHEMA_HINT: &str = "`occlab schema` prints what is allowed.";

/// A strict JSON file (UTF-8, no duplicate keys, finite numbers) that can tell the line and column of each value.
#[derive(Clone, Debug)]
pub struct Document {
    path: PathBuf,
    /// Whether the text is compiled into the program; there is then no such file on the disk.
    built_in: bool,
    text: Arc<str>,
    value: Value,
    /// JSON pointer of `value` in the file; empty for a whole file.
    base: String,
    /// Pointers of values that are written elsewhere in the file, each with the pointer to where it is written.
    origins: Arc<BTreeMap<String, String>>,
}

/// A problem inside a JSON value, not yet bound to a file.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Fault {
    /// JSON pointer.
    pub pointer: String,
    /// Whether the key or the value is at fault.
    pub part: MemberPart,
    /// What is wrong, without a full stop.
    pub problem: String,
    /// What to do, a full sentence.
    pub remedy: String,
    /// Whether a list belongs there.
    pub wants_list: bool,
}

impl Fault {
    pub fn new(
        part: MemberPart,
        pointer: impl Into<String>,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self {
            pointer: pointer.into(),
            part,
            problem: problem.into(),
            remedy: remedy.into(),
            wants_list: false,
        }
    }
}

impl From<Problem> for Fault {
    fn from(problem: Problem) -> Self {
        let remedy = format!("Correct the value; {SCHEMA_HINT}");
        Self::new(MemberPart::Value, problem.pointer, problem.message, remedy)
    }
}

impl Document {
    /// Reads at most [`MAX_FILE_BYTES`] of strict JSON; where no file has that path, the built-in one.
    pub fn read(path: &Path) -> Result<Self> {
        let file = match std::fs::File::open(path) {
            Ok(file) => file,
            Err(error) => return Self::built_in(path, error),
        };
        let mut bytes = Vec::new();
        file.take(MAX_FILE_BYTES + 1)
            .read_to_end(&mut bytes)
            .map_err(Error::reading(path))?;
        if bytes.len() as u64 > MAX_FILE_BYTES {
            let remedy = "A scene or an experiment has a few kilobytes: check that this is the file you mean.";
            return Err(Error::input(
                path.display().to_string(),
                format!("larger than {} MiB", MAX_FILE_BYTES >> 20),
                remedy,
            ));
        }
        let text = String::from_utf8(bytes).map_err(|e| {
            let valid =
                String::from_utf8_lossy(&e.as_bytes()[..e.utf8_error().valid_up_to()]).into_owned();
            let problem = "a byte that is not UTF-8".to_owned();
            error_at(
                path,
                locate::line_col(&valid, valid.len()),
                None,
                problem,
                "Save the file as UTF-8 text.".to_owned(),
            )
        })?;
        Self::parse(path, text)
    }

    /// The built-in file of a path that cannot be opened, if the reason is that there is no such file.
    fn built_in(path: &Path, error: std::io::Error) -> Result<Self> {
        let absent = matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory);
        match shipped::text(path) {
            Some(text) if absent => Ok(Self {
                built_in: true,
                ..Self::parse(path, text.to_owned())?
            }),
            _ => Err(Error::reading(path)(error)),
        }
    }

    /// Parses `text`; `path` is for messages and for what is relative to it, and need not exist.
    pub fn parse(path: &Path, mut text: String) -> Result<Self> {
        if text.starts_with('\u{feff}') {
            text.remove(0);
        }
        let syntax = |(place, problem)| {
            error_at(
                path,
                place,
                None,
                problem,
                "Correct the JSON; comments and trailing commas are not part of it.".to_owned(),
            )
        };
        locate::check(&text).map_err(syntax)?;
        let value = serde_json::from_str(&text).map_err(|e| {
            let message = e.to_string();
            let problem = message
                .split(" at line ")
                .next()
                .unwrap_or(&message)
                .to_owned();
            syntax(((e.line().max(1), e.column().max(1)), problem))
        })?;
        Ok(Self {
            path: path.to_owned(),
            built_in: false,
            text: text.into(),
            value,
            base: String::new(),
            origins: Arc::default(),
        })
    }

    /// The value at `pointer` as a document of its own, whose errors name its place in this file.
    pub(super) fn inside(&self, pointer: &str) -> Self {
        let value = self.value.pointer(pointer).cloned().unwrap_or_default();
        self.part(value, pointer)
    }

    /// `value` as a document of its own, placed at pointer `base` of this file: errors name places below `base`.
    pub(super) fn part(&self, value: Value, base: &str) -> Self {
        Self {
            path: self.path.clone(),
            built_in: self.built_in,
            text: self.text.clone(),
            value,
            base: format!("{}{base}", self.base),
            origins: self.origins.clone(),
        }
    }

    /// The file with other values at some places, each with the pointer to where the new value stands in the file.
    pub(super) fn filled(&self, value: Value, origins: BTreeMap<String, String>) -> Self {
        Self {
            origins: origins.into(),
            ..self.part(value, "")
        }
    }

    /// Where the value at `pointer` was written, if elsewhere.
    fn origin(&self, pointer: &str) -> Option<String> {
        self.origins.iter().find_map(|(place, origin)| {
            let rest = pointer.strip_prefix(place.as_str())?;
            (rest.is_empty() || rest.starts_with('/')).then(|| format!("{origin}{rest}"))
        })
    }

    /// The whole file as it was read, or the part of it that this document is.
    pub fn value(&self) -> &Value {
        &self.value
    }

    /// Length of the file's text, bytes.
    pub(super) fn text_bytes(&self) -> u64 {
        self.text.len() as u64
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The file as messages name it.
    pub fn name(&self) -> String {
        let mark = if self.built_in { " (built in)" } else { "" };
        format!("{}{mark}", self.path.display())
    }

    /// The folder that relative paths in the file start from.
    pub fn folder(&self) -> &Path {
        self.path.parent().unwrap_or(Path::new(""))
    }

    /// An error about the value at `pointer`.
    pub fn error(
        &self,
        pointer: &str,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Error {
        self.fault(Fault::new(MemberPart::Value, pointer, problem, remedy))
    }

    /// An error about the key that `pointer` ends with.
    pub fn error_at_key(
        &self,
        pointer: &str,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Error {
        self.fault(Fault::new(MemberPart::Key, pointer, problem, remedy))
    }

    pub(super) fn fault(&self, fault: Fault) -> Error {
        let pointer = format!("{}{}", self.base, fault.pointer);
        let (written, shown) = match self.origin(&pointer) {
            Some(origin) => (origin.clone(), format!("{origin}, used at {pointer}")),
            None => (pointer.clone(), pointer),
        };
        let place = locate::position(&self.text, &written, fault.part);
        error_at(
            Path::new(&self.name()),
            place,
            Some(&shown),
            fault.problem,
            fault.remedy,
        )
    }

    /// An error about a `value` at `pointer` that is not what `schema` allows.
    pub(super) fn misfit(&self, pointer: &str, value: &Value, schema: &Value) -> Error {
        let fault = wanted::fault(schema, value, "", "");
        self.fault(Fault {
            pointer: format!("{pointer}{}", fault.pointer),
            remedy: format!("{}{SCHEMA_HINT}", fault.remedy),
            ..fault
        })
    }

    /// The value at `pointer` as a `T`.
    pub(super) fn get<T: DeserializeOwned + JsonSchema>(&self, pointer: &str) -> Result<T> {
        let value = self.value.pointer(pointer).unwrap_or(&Value::Null);
        deserialize(value).map_err(|fault| {
            self.fault(Fault {
                pointer: format!("{pointer}{}", fault.pointer),
                ..fault
            })
        })
    }

    /// The elements of the list at `pointer`, or the single value there; each with its own pointer. Never empty.
    pub(super) fn one_or_many(&self, pointer: &str) -> Result<Vec<(String, Value)>> {
        match self.value.pointer(pointer) {
            Some(Value::Array(list)) if list.is_empty() => Err(self.error(
                pointer,
                "the list is empty",
                "Give at least one value, or leave the key out.",
            )),
            Some(Value::Array(list)) => Ok(list
                .iter()
                .enumerate()
                .map(|(i, v)| (format!("{pointer}/{i}"), v.clone()))
                .collect()),
            Some(single) => Ok(vec![(pointer.to_owned(), single.clone())]),
            None => Err(self.error(pointer, "the value is missing", SCHEMA_HINT)),
        }
    }
}

/// `value` as a `T`, with a JSON pointer to what does not fit.
pub(super) fn deserialize<T: DeserializeOwned + JsonSchema>(value: &Value) -> Result<T, Fault> {
    serde_path_to_error::deserialize(value).map_err(|e| {
        let mut pointer: String = e.path().iter().map(pointer_step).collect();
        while value.pointer(&pointer).is_none() {
            pointer.truncate(pointer.rfind('/').unwrap_or(0));
        }
        let settings = SchemaSettings::draft2020_12();
        let schema = settings.into_generator().into_root_schema_for::<T>();
        let message = e.inner().to_string();
        let fault = wanted::fault(schema.as_value(), value, &pointer, &message);
        Fault {
            remedy: format!("{}{SCHEMA_HINT}", fault.remedy),
            ..fault
        }
    })
}

fn pointer_step(segment: &Segment) -> String {
    match segment {
        Segment::Seq { index } => format!("/{index}"),
        Segment::Map { key } => locate::step(key),
        Segment::Enum { variant } => locate::step(variant),
        Segment::Unknown => String::new(),
    }
}

fn error_at(
    path: &Path,
    (line, column): LineCol,
    pointer: Option<&str>,
    problem: String,
    remedy: String,
) -> Error {
    let suffix = match pointer {
        None => String::new(),
        Some("") => " (at the top level)".to_owned(),
        Some(pointer) => format!(" (at {pointer})"),
    };
    Error::input(
        format!("{}:{line}:{column}{suffix}", path.display()),
        problem,
        remedy,
    )
}
