use super::*;

#[test]
fn a_scene_loads_and_its_volume_is_relative_to_the_file() {
    let folder = Folder::new();
    let scene = load_scene(&folder.0.path().join("slab.json")).expect("scene");
    assert_eq!((scene.name.as_str(), scene.march.steps), ("slab", 64));
    let volume = SCENE.replace(
        r#"{"uniform": {"value": 1}}"#,
        r#"{"volume": {"path": "v.npy", "up_axis": 1}}"#,
    );
    let scene = load_scene(&folder.write("volume.json", volume)).expect("volume scene");
    assert!(
        matches!(scene.density, crate::scene::Density::Volume(v) if v.path == folder.0.path().join("v.npy"))
    );
    assert!(load_scene(&folder.write("bom.json", format!("\u{feff}{SCENE}"))).is_ok());
}

#[test]
fn bad_scenes_are_located() {
    let folder = Folder::new();
    let error = |from, to| folder.scene_error(from, to);
    has(
        &error("elevation_deg\"", "elevaton_deg\""),
        &[
            "bad.json:6:11 (at /sun/elevaton_deg)",
            "unknown field",
            "Did you mean `elevation_deg`?",
        ],
    );
    has(
        &error("\"elevation_deg\": 45, ", ""),
        &[
            "bad.json:6:10 (at /sun)",
            "missing field `elevation_deg`: a number",
        ],
    );
    has(
        &error("45", "\"high\""),
        &[
            "bad.json:6:28 (at /sun/elevation_deg)",
            "the value is \"high\", allowed is a number",
        ],
    );
    has(
        &error("45", "-3"),
        &[
            "bad.json:6:28 (at /sun/elevation_deg)",
            "-3",
            "above the horizon",
        ],
    );
    has(&error("45", "NaN"), &["bad.json:6:28", "NaN"]);
    has(&error("45", "1e999"), &["bad.json:6:28", "1e999"]);
    has(
        &error("45", "45, \"elevation_deg\": 4"),
        &["bad.json:6:32", "appears twice"],
    );
    has(
        &error("\"uniform\"", "\"unifrom\""),
        &[
            "bad.json:4:",
            "the value is an object with `unifrom`",
            "an object with one of `uniform`, `procedural`, `volume`",
            "Did you mean `uniform`?",
        ],
    );
    has(
        &error("[100, 50, 100]", "[100, 50]"),
        &[
            "bad.json:3:",
            "/container/box/max_m",
            "the value is a list of 2, allowed is a list of 3 numbers",
        ],
    );
    has(
        &error("\"name\": \"slab\",", ""),
        &["bad.json:1:1 (at the top level)", "missing field `name`"],
    );
    has(&error("45,", "45,,"), &["bad.json:6:31"]);
    has(
        &error("{\"value\": 1}", "1.0"),
        &[
            "bad.json:4:26 (at /density/uniform)",
            "the value is 1.0, allowed is an object with `value`. Write {\"value\": 1.0};",
        ],
    );
    has(
        &error("{\"uniform\": {\"value\": 1}}", "\"uniform\""),
        &[
            "(at /density)",
            "the value is \"uniform\", allowed is an object with one of",
        ],
    );
    has(
        &error("\"medium\": {}", "\"medium\": {\"phase\": [[0.5]]}"),
        &[
            "(at /medium/phase/0)",
            "the value is a list of 1, allowed is an object with `g`, `weight`",
        ],
    );
    has(
        &error(
            "\"medium\": {}",
            "\"medium\": {}, \"march\": {\"integration\": \"exact\"}",
        ),
        &[
            "(at /march/integration)",
            "allowed is one of `analytic`, `thesis`",
        ],
    );
}

#[test]
fn bad_files_are_refused() {
    let folder = Folder::new();
    let error = |bytes: &[u8]| {
        load_scene(&folder.write("bad.json", bytes))
            .expect_err("refused")
            .to_string()
    };
    has(
        &error(b"{\n \"name\": \"\xff\"}"),
        &["bad.json:2:11", "not UTF-8"],
    );
    has(&error(b""), &["bad.json:1:1", "empty"]);
    has(&error(&b"[".repeat(100_000)), &["bad.json:1:", "nesting"]);
    has(
        &error(&vec![b' '; MAX_FILE_BYTES as usize + 1]),
        &["larger than 16 MiB"],
    );
    assert!(matches!(
        load_scene(&folder.0.path().join("none.json")),
        Err(crate::Error::Io { .. })
    ));
}

#[cfg(unix)]
#[test]
fn a_volume_in_a_folder_whose_name_is_not_utf_8_is_refused_as_input() {
    use std::os::unix::ffi::OsStrExt as _;
    let name = std::ffi::OsStr::from_bytes(b"clouds-\xff");
    let folder = tempfile::tempdir().unwrap().keep().join(name);
    std::fs::create_dir_all(&folder).unwrap();
    let file = folder.join("s.json");
    let scene = serde_json::json!({
        "name": "cube",
        "container": {"box": {"min_m": [0, 0, 0], "max_m": [1000, 1000, 1000]}},
        "density": {"volume": {"path": "a.npy", "up_axis": 1}},
        "medium": {"extinction_per_m": 0.005},
        "sun": {"elevation_deg": 60, "azimuth_deg": 30, "irradiance": [1, 1, 1]},
        "camera": {"position_m": [500, 500, -2500], "target_m": [500, 500, 500], "fov_y_deg": 30}
    });
    std::fs::write(&file, scene.to_string()).unwrap();
    let error = crate::config::load_scene(&file).unwrap_err().to_string();
    std::fs::remove_dir_all(folder.parent().unwrap()).unwrap();
    assert!(
        error.contains("is not UTF-8") && error.contains("/density/volume/path"),
        "{error}"
    );
}
