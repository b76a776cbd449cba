//! The parts of the schema for study files: those of the Rust types, where any value may also be a placeholder
//! `"$NAME"`.

use super::super::study::StudyFile;
use schemars::generate::SchemaSettings;
use serde_json::{Map, Value, json};

/// Name of the definition of `"$NAME"`.
const PLACEHOLDER: &str = "FromProfile";
/// Definition that admits no placeholders: a profile holds the values that placeholders name.
const LITERAL: &str = "StudyProfile";

/// Definitions for a study: `Study` and what it refers to. `experiment` and `methods` are those of experiment files.
pub(super) fn definitions(experiment: &Value, methods: &Value) -> Map<String, Value> {
    let mut generator = SchemaSettings::draft2020_12().into_generator();
    generator.subschema_for::<StudyFile>();
    let mut definitions = generator.take_definitions(true);
    definitions["StudyExperiment"]["properties"]["matrix"] = matrix(experiment);
    definitions.insert("StudyMethod".to_owned(), methods.clone());
    for (name, definition) in &mut definitions {
        if name != LITERAL {
            admit(definition);
        }
    }
    definitions.insert(
        PLACEHOLDER.to_owned(),
        json!({"type": "string", "pattern": "^\\$", "description": "The value of that name in the profile."}),
    );
    definitions
}

/// An experiment without its name, which the study gives.
fn matrix(experiment: &Value) -> Value {
    let mut matrix = experiment.clone();
    if let Some(members) = matrix["properties"].as_object_mut() {
        members.remove("name");
        let methods = members["methods"].to_string();
        let own = methods.replace("#/$defs/Method", "#/$defs/StudyMethod");
        members["methods"] = own.parse().unwrap_or_default();
    }
    if let Some(required) = matrix["required"].as_array_mut() {
        required.retain(|name| name != "name");
    }
    matrix["description"] = "An experiment without its name.".into();
    matrix
}

/// Lets every member and every item below a schema be a placeholder `"$NAME"`.
fn admit(schema: &mut Value) {
    let Some(members) = schema.as_object_mut() else {
        return;
    };
    for (key, below) in members {
        match (key.as_str(), below) {
            ("properties", Value::Object(properties)) => {
                properties.values_mut().for_each(or_placeholder);
            }
            ("items" | "additionalProperties", below @ Value::Object(_)) => or_placeholder(below),
            ("anyOf" | "oneOf" | "allOf" | "prefixItems", Value::Array(parts)) => {
                parts.iter_mut().for_each(admit);
            }
            _ => {}
        }
    }
}

fn or_placeholder(schema: &mut Value) {
    admit(schema);
    let inner = schema.take();
    *schema = json!({"anyOf": [inner, {"$ref": format!("#/$defs/{PLACEHOLDER}")}]});
}
