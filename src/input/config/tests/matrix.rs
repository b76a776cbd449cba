use super::*;
use crate::param::ParamValue;
use crate::scene::ImageSize;
use serde_json::json;

#[test]
fn reconstruct_is_the_fastest_axis_and_full_where_nothing_is_said() {
    let folder = Folder::new();
    let image = json!([{"width": 16, "height": 9}, {"width": 32, "height": 18}]);
    let expand = |mut members: serde_json::Value| {
        members["image"] = image.clone();
        members["methods"] = json!(["none", {"method": "srm", "steps": [6, 10]}]);
        folder.expand(&with(members)).expect("matrix")
    };
    let plain = expand(json!({}));
    let mut cells = plain.views.iter().flat_map(|v| &v.cells);
    assert!(cells.all(|c| c.reconstruct.is_full()));
    let both = expand(json!({"reconstruct": ["temporal_2x2", "full"]}));
    assert_eq!(both.cell_count(), 2 * plain.cell_count());
    let cells = both.views.iter().flat_map(|v| &v.cells);
    for (i, (cell, twin)) in cells
        .zip(
            plain
                .views
                .iter()
                .flat_map(|v| v.cells.iter().flat_map(|c| [c, c])),
        )
        .enumerate()
    {
        let kind = ["temporal_2x2", "full"][i % 2];
        assert_eq!((cell.index, cell.reconstruct.id), (i, kind));
        assert_eq!((&cell.method, &cell.params), (&twin.method, &twin.params));
    }
    let text = describe(&both);
    assert_eq!(
        text.matches("reconstruct=temporal_2x2").count(),
        6,
        "{text}"
    );
    assert!(!describe(&plain).contains("reconstruct"));
}

#[test]
fn lists_multiply_in_the_documented_order() {
    let folder = Folder::new();
    let matrix = folder
        .expand(&with(json!({
            "image": [{"width": 16, "height": 9}, {"width": 32, "height": 18}],
            "scenes": [{"scene": "slab.json", "set": {"/density/uniform/value": [1, 2], "/camera/position_m": [[0, 10, -300], [0, 10, -500]]}}],
            "sun_elevation_deg": [60, 12],
            "view_steps": 32,
            "methods": ["none", {"method": "srm", "steps": [6, 10], "spacing": [1, 1.5, 2]}],
        })))
        .expect("matrix");
    assert_eq!(
        (matrix.views.len(), matrix.cell_count()),
        (2 * 2 * 2 * 2, 16 * 7)
    );
    assert!(matrix.notes.is_empty());
    let view = |i: usize| {
        let v = &matrix.views[i];
        (
            v.scene_set["/density/uniform/value"].as_f64(),
            v.scene.camera.position_m[2],
            v.scene.sun.elevation_deg,
            v.image.width,
        )
    };
    assert_eq!(view(0), (Some(1.0), -300.0, 60.0, 16));
    assert_eq!(view(1), (Some(1.0), -300.0, 60.0, 32));
    assert_eq!(view(2), (Some(1.0), -300.0, 12.0, 16));
    assert_eq!(view(4), (Some(1.0), -500.0, 60.0, 16));
    assert_eq!(view(8), (Some(2.0), -300.0, 60.0, 16));
    assert!(matrix.views.iter().all(|v| v.scene.march.steps == 32));
    let cells: Vec<_> = matrix.views[1]
        .cells
        .iter()
        .map(|c| {
            (
                c.index,
                c.method.as_str(),
                c.params.get("steps"),
                c.params.get("spacing"),
            )
        })
        .collect();
    let srm = |i, steps, spacing| {
        (
            i,
            "srm",
            Some(ParamValue::Int(steps)),
            Some(ParamValue::Float(spacing)),
        )
    };
    assert_eq!(
        cells[..4],
        [
            (7, "none", None, None),
            srm(8, 6, 1.0),
            srm(9, 6, 1.5),
            srm(10, 6, 2.0)
        ]
    );
    assert_eq!(cells[6], srm(13, 10, 2.0));
}

#[test]
fn defaults_are_filled_and_absent_optional_members_created() {
    let folder = Folder::new();
    let scenes = json!([{"scene": "slab.json", "set": {"/march": {"steps": 7}, "/camera/far_m": 900, "/sky": null}}]);
    let experiment = with(json!({"scenes": scenes, "methods": {"method": "bsm"}}));
    let experiment =
        load_experiment(&folder.write("e.json", experiment.to_string())).expect("experiment");
    assert_eq!((experiment.runs, experiment.discard), (5, 1));
    let matrix = expand(&experiment, &Mock).expect("matrix");
    let view = &matrix.views[0];
    assert_eq!(
        (
            view.scene.march.steps,
            view.scene.camera.far_m,
            &view.scene.sky
        ),
        (7, Some(900.0), &None)
    );
    assert_eq!(
        view.image,
        ImageSize {
            width: 16,
            height: 9
        }
    );
    assert_eq!(
        view.cells[0].params.get("lookup"),
        Some(ParamValue::Choice("nearest"))
    );
}

#[test]
fn duplicates_are_dropped_with_a_note() {
    let folder = Folder::new();
    let methods = json!([{"method": "srm"}, {"method": "srm", "steps": [6, 7], "spacing": 2}, "none", "none"]);
    let matrix = folder
        .expand(&with(
            json!({"methods": methods, "sun_elevation_deg": [30, 30.0]}),
        ))
        .expect("matrix");
    assert_eq!(
        (matrix.views.len(), matrix.cell_count(), matrix.notes.len()),
        (1, 3, 3)
    );
    assert!(matrix.views[0].cells.iter().map(|c| c.index).eq(0..3));
}

#[test]
fn a_dry_run_lists_cells_count_and_notes() {
    let folder = Folder::new();
    let text = describe(
        &folder.expand(&with(json!({"methods": [{"method": "srm", "steps": [5, 5, 9]}], "sun_elevation_deg": 30}))).expect("matrix"),
    );
    has(
        &text,
        &[
            "cell  scene",
            "slab",
            "30°",
            "16×9",
            "spacing=2 steps=9",
            "/sun/elevation_deg=30",
            "2 cells in 1 views",
            "note: srm",
        ],
    );
    assert_eq!(text.lines().count(), 1 + 2 + 1 + 1);
}

#[test]
fn the_schema_names_every_method_and_every_reference_resolves() {
    let schema = schema(&Mock);
    fn references<'a>(value: &'a Value, found: &mut Vec<&'a str>) {
        match value {
            Value::Object(members) => {
                found.extend(members.get("$ref").and_then(Value::as_str));
                members.values().for_each(|v| references(v, found));
            }
            Value::Array(list) => list.iter().for_each(|v| references(v, found)),
            _ => {}
        }
    }
    let mut found = Vec::new();
    references(&schema, &mut found);
    assert!(found.len() > 10);
    for reference in found {
        let pointer = reference.strip_prefix('#').expect("local reference");
        assert!(
            schema.pointer(pointer).is_some(),
            "{reference} does not resolve"
        );
    }
    let members = &schema["$defs"]["Experiment"]["properties"];
    assert_eq!(
        (&members["runs"]["minimum"], &members["discard"]["minimum"]),
        (&json!(1), &json!(1))
    );
    assert_eq!(
        members["flicker"]["anyOf"][0],
        json!({"$ref": "#/$defs/Track"})
    );
    assert_eq!(
        members["ghosting"]["anyOf"][0],
        json!({"$ref": "#/$defs/CameraTrack"})
    );
    assert_eq!(
        members["reconstruct"]["anyOf"][0],
        json!({"$ref": "#/$defs/Reconstruct"})
    );
    let srm = &schema["$defs"]["Method"]["anyOf"][2];
    assert_eq!(
        (&srm["title"], &srm["additionalProperties"]),
        (&json!("srm"), &json!(false))
    );
    assert_eq!(
        srm["properties"]["steps"]["anyOf"][0],
        json!({"type": "integer", "minimum": 1, "maximum": 50})
    );
    assert_eq!(srm["properties"]["steps"]["default"], json!(6));
    has(
        srm["properties"]["spacing"]["description"]
            .as_str()
            .unwrap_or_default(),
        &["First step.", "Unit: m."],
    );
    assert_eq!(
        schema["$defs"]["Method"]["anyOf"][3]["properties"]["lookup"]["anyOf"][0],
        json!({"enum": ["nearest", "hardware"]})
    );
    assert_eq!(
        schema["$defs"]["Scene"]["additionalProperties"],
        json!(false)
    );
}

#[test]
fn a_cell_has_the_parameters_that_apply_and_values_of_others_make_no_cells() {
    let folder = Folder::new();
    let methods = json!({"method": "bsm", "lookup": ["nearest", "hardware"], "reach": [20, 30]});
    let matrix = folder
        .expand(&with(json!({ "methods": methods })))
        .expect("matrix");
    let cells: Vec<Value> = (matrix.views[0].cells.iter())
        .map(|cell| json!(cell.params))
        .collect();
    assert_eq!(
        cells,
        [
            json!({"lookup": "nearest"}),
            json!({"lookup": "hardware", "reach": 20}),
            json!({"lookup": "hardware", "reach": 30}),
        ]
    );
    assert_eq!(
        matrix.notes,
        ["bsm: `reach` applies where lookup = hardware; elsewhere its values are one setting"]
    );
    let cells = |methods| {
        let matrix = folder.expand(&with(json!({ "methods": methods })));
        matrix.expect("matrix").views[0].cells.len()
    };
    assert_eq!(cells(json!("bsm")), 1);
    assert_eq!(
        cells(json!({"method": "bsm", "lookup": "hardware", "reach": 20})),
        1
    );
}

#[test]
fn values_that_apply_at_no_setting_are_refused_and_a_single_one_is_noted() {
    let folder = Folder::new();
    let one = json!({"method": "bsm", "reach": 20});
    let matrix = folder.expand(&with(json!({ "methods": one })));
    let matrix = matrix.expect("matrix");
    assert_eq!(
        json!(matrix.views[0].cells[0].params),
        json!({"lookup": "nearest"})
    );
    assert_eq!(
        matrix.notes,
        ["bsm: `reach` has no effect: it applies where lookup = hardware"]
    );
    has(
        &folder.error("methods", r#"{"method": "bsm", "reach": [20, 30]}"#),
        &[
            "(at /methods/reach)",
            "`reach` has no effect: it applies where lookup = hardware, and `lookup` is nearest",
            "Leave it out, or set lookup = hardware too.",
        ],
    );
}
