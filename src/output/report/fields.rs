//! Dotted names of the values in a cell's record, derived from the JSON schema of its type so that none is missing.

use crate::batch::record::Measured;
use schemars::generate::SchemaSettings;
use serde_json::Value;
use std::sync::LazyLock;

/// A member of [`Measured`], at any depth.
pub struct RecordField {
    /// Dotted name, such as `error.rel_rmse`.
    pub name: String,
    /// True where the value may be `null` or absent.
    pub optional: bool,
    /// True for a single number or text; false for a list, a map or a group of members.
    pub scalar: bool,
}

/// Every member of [`Measured`], in the order of the record.
pub fn measured() -> &'static [RecordField] {
    static FIELDS: LazyLock<Vec<RecordField>> = LazyLock::new(|| {
        let settings = SchemaSettings::draft2020_12().with(|s| s.inline_subschemas = true);
        let schema = settings.into_generator().into_root_schema_for::<Measured>();
        let mut fields = Vec::new();
        walk(schema.as_value(), "", &mut fields);
        fields
    });
    &FIELDS
}

fn walk(schema: &Value, prefix: &str, fields: &mut Vec<RecordField>) {
    for (key, member) in schema["properties"].as_object().into_iter().flatten() {
        let name = format!("{prefix}{key}");
        let optional = allows(member, "null");
        let inner = something(member);
        fields.push(RecordField {
            name: name.clone(),
            optional,
            scalar: !allows(inner, "object") && !allows(inner, "array"),
        });
        walk(inner, &format!("{name}."), fields);
    }
}

/// Schema of an optional value without its `null` alternative.
fn something(schema: &Value) -> &Value {
    let choices = schema["anyOf"].as_array().into_iter().flatten();
    let mut choices = choices.filter(|choice| choice["type"] != "null");
    choices.next().unwrap_or(schema)
}

fn allows(schema: &Value, kind: &str) -> bool {
    let own = match &schema["type"] {
        Value::Array(kinds) => kinds.iter().any(|k| k == kind),
        one => one == kind,
    };
    let mut choices = schema["anyOf"].as_array().into_iter().flatten();
    own || choices.any(|choice| allows(choice, kind))
}
