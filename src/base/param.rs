//! Parameters of a method: declared once as [`ParamSpec`], from which configuration parsing, JSON schema,
//! command-line help, report columns and shader uniforms are all derived.

use crate::error::{Error, Result};
use serde_json::Value;
use std::collections::BTreeMap;

/// Type, range and default of one parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ParamKind {
    /// Whole number in `[min, max]`; a `u32` member of the shader's `Params`.
    Int {
        /// Smallest value allowed.
        min: i64,
        /// Largest value allowed.
        max: i64,
        /// Value when the configuration names none.
        default: i64,
    },
    /// Finite real number in `[min, max]`; an `f32` member of the shader's `Params`.
    Float {
        /// Smallest value allowed.
        min: f64,
        /// Largest value allowed.
        max: f64,
        /// Value when the configuration names none.
        default: f64,
    },
    /// One of a few words; a shader definition `NAME_OPTION`, so that pipelines specialise on structure only.
    Choice {
        /// The words.
        options: &'static [&'static str],
        /// Value when the configuration names none.
        default: &'static str,
    },
}

/// Condition under which a parameter has an effect. It may depend on one other parameter of the method, which always
/// applies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Applies {
    /// At every setting.
    Always,
    /// Where a choice is one of these words.
    Choice {
        /// Name of the choice.
        of: &'static str,
        /// The words.
        is: &'static [&'static str],
    },
    /// Where a whole number is at least this.
    AtLeast {
        /// Name of the number.
        of: &'static str,
        /// Smallest value.
        min: i64,
    },
}

impl Applies {
    /// Name of the parameter that decides; `None` for [`Applies::Always`].
    pub fn decided_by(self) -> Option<&'static str> {
        match self {
            Self::Always => None,
            Self::Choice { of, .. } | Self::AtLeast { of, .. } => Some(of),
        }
    }

    /// Whether the condition holds where the deciding parameter has this value.
    pub fn at(self, value: ParamValue) -> bool {
        match (self, value) {
            (Self::Always, _) => true,
            (Self::Choice { is, .. }, ParamValue::Choice(word)) => is.contains(&word),
            (Self::AtLeast { min, .. }, ParamValue::Int(number)) => number >= min,
            _ => false,
        }
    }

    /// The condition in words: `spacing = uniform_reach`; `None` where there is none.
    pub fn words(self) -> Option<String> {
        match self {
            Self::Always => None,
            Self::Choice { of, is } => Some(format!("{of} = {}", is.join(" or "))),
            Self::AtLeast { of, min } => Some(format!("{of} ≥ {min}")),
        }
    }
}

/// One parameter of a method.
#[derive(Clone, Copy, Debug)]
pub struct ParamSpec {
    /// Name in JSON, on the command line, in reports and in the shader.
    pub name: &'static str,
    /// Unit, `""` for a pure number.
    pub unit: &'static str,
    /// One or two sentences: what it does, where it comes from.
    pub doc: &'static str,
    /// Type, range and default.
    pub kind: ParamKind,
    /// Where it has an effect; elsewhere it is neither shown nor recorded.
    pub applies: Applies,
    /// Options that exist only to show what a source's text as printed does. They are parsed and recorded as the others
    /// are, but listed apart, and no menu offers them.
    pub as_printed: &'static [AsPrinted],
}

/// An option that reproduces a source's formula that fails, or a misprint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AsPrinted {
    /// One of the options of a choice, not its default.
    pub option: &'static str,
    /// What it does and which text prints it: a sentence without its full stop.
    pub doc: &'static str,
}

/// A value that satisfied its [`ParamSpec`].
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
#[serde(untagged)]
pub enum ParamValue {
    /// See [`ParamKind::Int`].
    Int(i64),
    /// See [`ParamKind::Float`].
    Float(f64),
    /// See [`ParamKind::Choice`].
    Choice(&'static str),
}

impl std::fmt::Display for ParamValue {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Int(v) => write!(f, "{v}"),
            Self::Float(v) => write!(f, "{v}"),
            Self::Choice(v) => f.write_str(v),
        }
    }
}

impl ParamSpec {
    /// The value used when none is given.
    pub fn default_value(&self) -> ParamValue {
        match self.kind {
            ParamKind::Int { default, .. } => ParamValue::Int(default),
            ParamKind::Float { default, .. } => ParamValue::Float(default),
            ParamKind::Choice { default, .. } => ParamValue::Choice(default),
        }
    }

    /// Whether the parameter has an effect at a complete set of values.
    pub fn applies_at(&self, params: &Params) -> bool {
        let deciding = self.applies.decided_by();
        deciding.is_none_or(|of| params.get(of).is_some_and(|value| self.applies.at(value)))
    }

    /// Options of a choice, except those that only reproduce a source; empty for a number.
    pub fn everyday_options(&self) -> impl Iterator<Item = &'static str> {
        let options = match self.kind {
            ParamKind::Choice { options, .. } => options,
            _ => &[],
        };
        options
            .iter()
            .copied()
            .filter(|o| self.printed(o).is_none())
    }

    /// Whether at least two options remain without those that only reproduce a source; true where there are none of
    /// those.
    pub fn is_everyday(&self) -> bool {
        self.as_printed.is_empty() || self.everyday_options().nth(1).is_some()
    }

    /// The note on an option that only reproduces a source; `None` for other options.
    pub fn printed(&self, option: &str) -> Option<&'static AsPrinted> {
        self.as_printed.iter().find(|p| p.option == option)
    }

    /// The parameter's doc with the notes on all its options, as one text.
    pub fn whole_doc(&self) -> String {
        let printed = self.as_printed.iter();
        let printed = printed.map(|p| format!(" {}: {}.", p.option, p.doc));
        printed.fold(self.doc.to_owned(), |doc, more| doc + &more)
    }

    /// Range or options in words: `1…50`, `nearest | hardware | blend`.
    pub fn range_text(&self) -> String {
        match self.kind {
            ParamKind::Int { min, max, .. } => format!("{min}…{max}"),
            ParamKind::Float { min, max, .. } => format!("{min}…{max}"),
            ParamKind::Choice { options, .. } => options.join(" | "),
        }
    }

    /// Checks a JSON value; the error is the problem in words, without place or full stop.
    pub fn parse(&self, value: &Value) -> Result<ParamValue, String> {
        let wrong = || {
            format!(
                "`{}` is {value}, allowed is {}",
                self.name,
                self.range_text()
            )
        };
        match self.kind {
            ParamKind::Int { min, max, .. } => {
                let v = value.as_i64().ok_or_else(wrong)?;
                (min..=max)
                    .contains(&v)
                    .then_some(ParamValue::Int(v))
                    .ok_or_else(wrong)
            }
            ParamKind::Float { min, max, .. } => {
                let v = value.as_f64().ok_or_else(wrong)?;
                (min..=max)
                    .contains(&v)
                    .then_some(ParamValue::Float(v))
                    .ok_or_else(wrong)
            }
            ParamKind::Choice { options, .. } => {
                let v = value.as_str().ok_or_else(wrong)?;
                options
                    .iter()
                    .find(|o| **o == v)
                    .map(|o| ParamValue::Choice(o))
                    .ok_or_else(wrong)
            }
        }
    }

    /// Checks text from the command line (`name=text`).
    pub fn parse_text(&self, text: &str) -> Result<ParamValue, String> {
        let value = serde_json::from_str(text).unwrap_or_else(|_| Value::String(text.to_owned()));
        self.parse(&value)
    }
}

/// Values of a method's parameters: one for each [`ParamSpec`], or for each that applies ([`Params::applying`]).
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
#[serde(transparent)]
pub struct Params(BTreeMap<&'static str, ParamValue>);

impl Params {
    /// Every parameter at its default.
    pub fn defaults<'a>(specs: impl Iterator<Item = &'a ParamSpec>) -> Self {
        Self(specs.map(|s| (s.name, s.default_value())).collect())
    }

    /// The values of the parameters that apply, of a complete set: what is shown, recorded and compared.
    pub fn applying<'a>(&self, specs: impl Iterator<Item = &'a ParamSpec>) -> Self {
        let applies = specs.filter(|spec| spec.applies_at(self));
        Self(
            applies
                .filter_map(|spec| Some((spec.name, self.get(spec.name)?)))
                .collect(),
        )
    }

    /// These values, replaced by those of `other` where it has them.
    pub fn with(mut self, other: &Self) -> Self {
        self.0.extend(&other.0);
        self
    }

    /// Replaces one value.
    pub fn set(&mut self, name: &'static str, value: ParamValue) {
        self.0.insert(name, value);
    }

    /// Name and value, in alphabetical order.
    pub fn iter(&self) -> impl Iterator<Item = (&'static str, ParamValue)> {
        self.0.iter().map(|(k, v)| (*k, *v))
    }

    /// The value of `name`, if the method has such a parameter.
    pub fn get(&self, name: &str) -> Option<ParamValue> {
        self.0.get(name).copied()
    }

    /// A whole number the method declared; an error (a defect of the method's file) if it did not.
    pub fn int(&self, name: &str) -> Result<u32> {
        match self.get(name) {
            Some(ParamValue::Int(v)) => u32::try_from(v).map_err(|_| undeclared(name)),
            _ => Err(undeclared(name)),
        }
    }

    /// A number the method declared, whole or not; an error (a defect of the method's file) if it did not.
    pub fn number(&self, name: &str) -> Result<f64> {
        match self.get(name) {
            Some(ParamValue::Int(v)) => Ok(v as f64),
            Some(ParamValue::Float(v)) => Ok(v),
            _ => Err(undeclared(name)),
        }
    }

    /// A word the method declared; an error (a defect of the method's file) if it did not.
    pub fn choice(&self, name: &str) -> Result<&'static str> {
        match self.get(name) {
            Some(ParamValue::Choice(v)) => Ok(v),
            _ => Err(undeclared(name)),
        }
    }
}

fn undeclared(name: &str) -> Error {
    Error::defect(
        "method",
        format!("it reads the parameter `{name}`, which it does not declare with that type"),
    )
}
