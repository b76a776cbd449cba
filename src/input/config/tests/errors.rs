use super::*;
use serde_json::json;
use std::path::Path;

#[test]
fn bad_experiment_members_are_located() {
    let folder = Folder::new();
    let error = |member, value| folder.error(member, value);
    has(
        &error("run", "3"),
        &["(at /run)", "unknown field", "Did you mean `runs`?"],
    );
    has(
        &error("name", "7"),
        &[
            "e.json:1:9 (at /name)",
            "the value is 7, allowed is a text in quotes",
        ],
    );
    has(&error("name", "\"\""), &["(at /name)", "1 to 200"]);
    has(&error("runs", "0"), &["(at /runs)", "1…10000"]);
    has(
        &error("runs", "-1"),
        &[
            "(at /runs)",
            "the value is -1, allowed is a whole number, 1…10000",
        ],
    );
    has(
        &error("discard", "1.5"),
        &[
            "(at /discard)",
            "the value is 1.5, allowed is a whole number",
        ],
    );
    has(
        &error("discard", "0"),
        &[
            "e.json:1:93 (at /discard)",
            "1…10000",
            "the first run of a pipeline",
        ],
    );
    has(&error("flicker", "[]"), &["(at /flicker)", "empty"]);
    has(
        &error("flicker", "[\"pan\", \"sum\"]"),
        &["(at /flicker/1)", "Did you mean `sun`?"],
    );
    has(
        &error("flicker", "[\"pan\", \"pan\"]"),
        &["(at /flicker/1)", "twice"],
    );
    has(&error("reconstruct", "[]"), &["(at /reconstruct)", "empty"]);
    has(
        &error("reconstruct", "\"temporal_2x\""),
        &["(at /reconstruct)", "Did you mean `temporal_2x2`?"],
    );
    has(
        &error("reconstruct", "[\"full\", \"full\"]"),
        &["(at /reconstruct/1)", "twice"],
    );
    has(&error("ghosting", "[]"), &["(at /ghosting)", "empty"]);
    has(
        &error("ghosting", "\"sun\""),
        &[
            "(at /ghosting)",
            "the value is \"sun\", allowed is one of `pan`, `dolly`",
        ],
    );
    has(
        &error("ghosting", "[\"pan\", \"pan\"]"),
        &["(at /ghosting/1)", "twice"],
    );
    has(
        &error("ghosting", "\"dolly\""),
        &["(at /ghosting)", "every cell is `full`", "temporal_2x2"],
    );
    has(
        &error("flicker", "\"roll\""),
        &["(at /flicker)", "`pan`", "`sun`", "`dolly`"],
    );
    has(&error("image", "[]"), &["(at /image)", "empty"]);
    has(
        &error("image", r#"{"width": 0, "height": 9}"#),
        &["(at /image/width)", "1…8192"],
    );
    has(
        &error("image", r#"[{"width": 4, "height": -9}]"#),
        &["(at /image/0/height)", "a whole number, 1 or more"],
    );
    has(
        &error("image", "[4]"),
        &[
            "(at /image/0)",
            "the value is 4, allowed is an object with `width`, `height`",
        ],
    );
    has(
        &error("image", r#"{"width": 4, "hight": 9}"#),
        &["(at /image/hight)", "Did you mean `height`?"],
    );
    has(
        &error("sun_elevation_deg", "[]"),
        &["(at /sun_elevation_deg)", "empty"],
    );
    has(
        &error("sun_elevation_deg", "[30, -5]"),
        &["(at /sun_elevation_deg/1)", "above the horizon"],
    );
    has(&error("sun_elevation_deg", "NaN"), &["NaN"]);
    has(&error("sun_elevation_deg", "1e999"), &["1e999"]);
    has(
        &error("view_steps", "[0]"),
        &["(at /view_steps/0)", "1…4096"],
    );
    has(&error("scenes", "[]"), &["(at /scenes)", "empty"]);
    has(&error("scenes", "[4]"), &["(at /scenes/0)", "not a scene"]);
    has(
        &error("scenes", "[\"none.json\"]"),
        &["(at /scenes/0)", "none.json", "relative to the experiment"],
    );
}

#[test]
fn bad_methods_are_located_and_say_what_is_allowed() {
    let folder = Folder::new();
    let error = |value| folder.error("methods", value);
    has(&error("[]"), &["(at /methods)", "empty"]);
    has(&error("[3]"), &["(at /methods/0)", "not a method"]);
    has(
        &error("[{\"steps\": 3}]"),
        &["(at /methods/0/method)", "id is missing"],
    );
    has(
        &error("[\"none\", \"smr\"]"),
        &[
            "(at /methods/1)",
            "no method `smr`",
            "Did you mean `srm`?",
            "`none`, `srm`, `bsm`",
        ],
    );
    has(
        &error("[{\"method\": \"fourier\"}]"),
        &["(at /methods/0/method)", "Methods are `none`"],
    );
    has(
        &error("[{\"method\": \"srm\", \"step\": 3}]"),
        &[
            "(at /methods/0/step)",
            "Did you mean `steps`?",
            "`steps`, `spacing`",
        ],
    );
    has(
        &error("{\"method\": \"none\", \"x\": 3}"),
        &["(at /methods/x)", "It has none."],
    );
    has(
        &error("{\"method\": \"srm\", \"steps\": []}"),
        &["(at /methods/steps)", "empty"],
    );
    has(
        &error("{\"method\": \"srm\", \"steps\": [5, 51]}"),
        &["(at /methods/steps/1)", "51", "1…50"],
    );
    has(
        &error("{\"method\": \"srm\", \"steps\": 1.5}"),
        &["(at /methods/steps)", "1…50"],
    );
    has(
        &error("{\"method\": \"bsm\", \"lookup\": \"linear\"}"),
        &["(at /methods/lookup)", "nearest | hardware"],
    );
}

#[test]
fn bad_sets_are_located_in_the_experiment() {
    let folder = Folder::new();
    let error = |set: &str| {
        folder.error(
            "scenes",
            &format!("[{{\"scene\": \"slab.json\", \"set\": {set}}}]"),
        )
    };
    has(
        &error(r#"{"/sky/preetham/turbidity": 3}"#),
        &[
            "(at /scenes/0/set/~1sky~1preetham~1turbidity)",
            "`/sky/preetham` does not exist",
            "slab.json",
        ],
    );
    has(&error(r#"{"sun": 3}"#), &["not a JSON pointer"]);
    has(
        &error(r#"{"/camera/up_m": [3]}"#),
        &["e.json:1:", "unknown field `up_m`", "Did you mean"],
    );
    has(
        &error(r#"{"/camera/position_m": [0, 1, 2]}"#),
        &["(at /scenes/0/set/~1camera~1position_m/0)", "list of lists"],
    );
    has(
        &error(r#"{"/camera/position_m/3": 1}"#),
        &["has 3 elements"],
    );
    has(
        &error(r#"{"/sun/elevation_deg": [3, 0]}"#),
        &[
            "(at /scenes/0/set/~1sun~1elevation_deg/1)",
            "above the horizon",
        ],
    );
    has(
        &error(r#"{"/container/box/min_m": [[0, 0, 0], [0, 60, 0]]}"#),
        &["(at /scenes/0)", "/container/box/max_m"],
    );
    has(&error(r#"{"/medium/albedo": []}"#), &["empty"]);
    let both = with(
        json!({"scenes": {"scene": "slab.json", "set": {"/sun/elevation_deg": 3}}, "sun_elevation_deg": 4}),
    );
    has(
        &folder.expand(&both).expect_err("both").to_string(),
        &["also given by `sun_elevation_deg`"],
    );
    let fixed = with(
        json!({"scenes": {"scene": "slab.json", "set": {"/march": {"step_m": 5}}}, "view_steps": 4}),
    );
    has(
        &folder.expand(&fixed).expect_err("no effect").to_string(),
        &["(at /view_steps)", "no effect"],
    );
}

#[test]
fn a_scene_that_is_broken_by_itself_is_reported_in_its_own_file() {
    let folder = Folder::new();
    folder.write(
        "slab.json",
        SCENE.replace("\"fov_y_deg\": 40", "\"fov_y_deg\": 400"),
    );
    has(
        &folder.expand_text(SMALL).expect_err("broken").to_string(),
        &["slab.json:7:", "(at /camera/fov_y_deg)"],
    );
    folder.write(
        "slab.json",
        SCENE.replace("\"fov_y_deg\": 40", "\"fov_y_deg\": NaN"),
    );
    has(
        &folder.expand_text(SMALL).expect_err("broken").to_string(),
        &["slab.json:7:", "NaN"],
    );
}

#[test]
fn the_cap_is_checked_before_anything_is_built() {
    let folder = Folder::new();
    let many: Vec<f64> = (1..=1000).map(|i| f64::from(i) * 0.01).collect();
    let set = json!({"/density/uniform/value": many, "/medium/albedo": many, "/medium/sun_gain": many, "/camera/fov_y_deg": many,
        "/medium/extinction_per_m": many, "/sun/azimuth_deg": many, "/camera/far_m": many});
    let message = folder
        .expand(&with(json!({"scenes": {"scene": "slab.json", "set": set}})))
        .expect_err("cap")
        .to_string();
    has(&message, &["exceed 100000 cells", "split"]);
}

#[test]
fn a_case_about_parameters_without_effect_is_refused() {
    let file = |params: &str| {
        let extremes =
            format!(r#"[{{"group": "g", "name": "n", "scene": "slab", "params": {params}}}]"#);
        let image = r#"{"width": 4, "height": 3}"#;
        format!(
            r#"{{"name": "s", "image": {image}, "scenes": {{"slab": {SCENE}}}, "extremes": {extremes}}}"#
        )
    };
    let read = |params| parse_stability(Path::new("s.json"), file(params), Path::new("out"), &Mock);
    for good in [
        r#"{"lookup": "hardware", "reach": 5}"#,
        r#"{"steps": 5}"#,
        "{}",
    ] {
        assert!(read(good).is_ok(), "{good}");
    }
    for idle in [r#"{"reach": 5}"#, r#"{"lookup": "hardware", "steps": 5}"#] {
        let message = read(idle).expect_err(idle).to_string();
        has(&message, &["(at /extremes/0/params)", "where they apply"]);
    }
}
