//! One JSON Schema (draft 2020-12) for every configuration file, for editors and for `occlab schema`.

mod study;

use super::experiment::{MAX_RUNS, default_discard, default_runs};
use super::methods::MethodCatalogue;
use super::reconstructions::{self, Catalogue};
use super::stability;
use crate::param::{ParamKind, ParamSpec};
use crate::scene::{CameraTrack, ImageSize, March, ReconstructionInfo, Scene, Track};
use schemars::generate::SchemaSettings;
use serde_json::{Map, Value, json};

/// The schema; scenes come from the Rust types, methods and reconstructions from what the catalogue declares.
pub fn schema(catalogue: &dyn Catalogue) -> Value {
    let mut generator = SchemaSettings::draft2020_12().into_generator();
    generator.subschema_for::<Scene>();
    generator.subschema_for::<ImageSize>();
    generator.subschema_for::<Track>();
    generator.subschema_for::<CameraTrack>();
    generator.subschema_for::<stability::StabilityFile>();
    let mut definitions = generator.take_definitions(true);
    let reconstructions = catalogue.reconstructions();
    let (experiment, methods) = (experiment(&reconstructions), methods(catalogue));
    definitions.extend(study::definitions(&experiment, &methods));
    definitions.insert("Experiment".to_owned(), experiment);
    definitions.insert(
        reconstructions::DEFINITION.to_owned(),
        reconstructions::definition(&reconstructions),
    );
    definitions.insert("SceneEntry".to_owned(), scene_entry());
    definitions.insert("Method".to_owned(), methods);
    let kinds = ["Experiment", "Scene", "Study", "Stability"];
    let kinds = kinds.map(|name| json!({"$ref": format!("#/$defs/{name}")}));
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "occlab experiment, scene, study or stability sweep",
        "oneOf": kinds,
        "$defs": definitions,
    })
}

/// `item`, or a list of at least one of it; lists multiply into the matrix.
fn one_or_many(item: Value) -> Value {
    json!({"anyOf": [item.clone(), {"type": "array", "items": item, "minItems": 1}]})
}

fn described(mut schema: Value, description: &str) -> Value {
    schema["description"] = description.into();
    schema
}

fn experiment(known: &[&ReconstructionInfo]) -> Value {
    let count = |default: u32| json!({"type": "integer", "minimum": 1, "maximum": MAX_RUNS, "default": default});
    let elevation = json!({"type": "number", "exclusiveMinimum": 0, "maximum": 90});
    let steps = json!({"type": "integer", "minimum": 1, "maximum": March::MAX_STEPS});
    json!({
        "type": "object",
        "description": "Which scenes, sizes, suns and method settings to measure; every list multiplies.",
        "properties": {
            "name": {"type": "string", "minLength": 1, "maxLength": 200, "description": "Shown in reports; no control characters."},
            "image": described(one_or_many(json!({"$ref": "#/$defs/ImageSize"})), "Image size, pixels."),
            "runs": described(count(default_runs()), "Timed rounds that count."),
            "discard": described(count(default_discard()), "Rounds run before them and thrown away."),
            "scenes": described(one_or_many(json!({"$ref": "#/$defs/SceneEntry"})), "Scenes, relative to this file."),
            "sun_elevation_deg": described(one_or_many(elevation), "Replaces /sun/elevation_deg of every scene, degrees."),
            "view_steps": described(one_or_many(steps), "Replaces /march/steps of every scene."),
            "flicker": described(one_or_many(json!({"$ref": "#/$defs/Track"})), "Measure flicker along these movements of 16 frames: `pan`, the camera turns by one pixel of the picture's centre a frame; `sun`, the sun rises by 1° in all; `dolly`, the camera moves ahead and to its right by one texel a frame, of the map of 256² texels in the `square` fit. Each frame has its own truth, so this costs 15 truths a movement and view. Absent: none."),
            "decompose": {"type": "boolean", "default": false, "description": "Split each cell's error into model, sampling and precision: the f64 oracle renders the truth, and each cell twice (at its own and at ample steps and texels), after the timed rounds."},
            "methods": described(one_or_many(json!({"$ref": "#/$defs/Method"})), "Methods and their parameters."),
            "reconstruct": described(one_or_many(json!({"$ref": format!("#/$defs/{}", reconstructions::DEFINITION)})), &reconstructions::description(known)),
            "ghosting": described(one_or_many(json!({"$ref": "#/$defs/CameraTrack"})), "Compare each cell whose reconstruction remembers earlier frames with its full render along these movements of 16 frames: `pan`, the camera turns by one pixel of the picture's centre a frame; `dolly`, it moves to its right by one pixel of the middle of the container a frame. Absent: none."),
        },
        "required": ["name", "image", "scenes", "methods"],
        "additionalProperties": false,
    })
}

fn scene_entry() -> Value {
    let path = json!({"type": "string", "description": "Scene file, relative to the experiment file, or a built-in one."});
    json!({"anyOf": [path, {
        "type": "object",
        "properties": {
            "scene": {"anyOf": [path, {"$ref": "#/$defs/Scene"}]},
            "set": {
                "type": "object",
                "description": "Scene members by JSON pointer; one value or a list. A member that is an array needs a list of arrays.",
                "propertyNames": {"pattern": "^/"},
            },
        },
        "required": ["scene"],
        "additionalProperties": false,
    }]})
}

fn methods(catalogue: &dyn MethodCatalogue) -> Value {
    let ids = catalogue.ids();
    let mut alternatives = vec![json!({"enum": ids, "description": "A method at its defaults."})];
    alternatives.extend(
        ids.iter()
            .map(|id| method(id, &catalogue.params(id).unwrap_or_default())),
    );
    json!({"anyOf": alternatives})
}

fn method(id: &str, specs: &[&'static ParamSpec]) -> Value {
    let mut properties = Map::new();
    properties.insert("method".to_owned(), json!({"const": id}));
    properties.extend(specs.iter().map(|spec| (spec.name.to_owned(), param(spec))));
    json!({"type": "object", "title": id, "properties": properties, "required": ["method"], "additionalProperties": false})
}

fn param(spec: &ParamSpec) -> Value {
    let (item, default) = match spec.kind {
        ParamKind::Int { min, max, default } => (
            json!({"type": "integer", "minimum": min, "maximum": max}),
            json!(default),
        ),
        ParamKind::Float { min, max, default } => (
            json!({"type": "number", "minimum": min, "maximum": max}),
            json!(default),
        ),
        ParamKind::Choice { options, default } => (json!({"enum": options}), json!(default)),
    };
    let unit = if spec.unit.is_empty() {
        String::new()
    } else {
        format!(" Unit: {}.", spec.unit)
    };
    let applies = match spec.applies.words() {
        Some(condition) => format!(" Applies where {condition}."),
        None => String::new(),
    };
    let mut schema = described(
        one_or_many(item),
        &format!("{}{unit}{applies}", spec.whole_doc()),
    );
    schema["default"] = default;
    schema
}
