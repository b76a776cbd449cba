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
        &["bad.json:6:10 (at /sun)", "missing field `elevation_deg`"],
    );
    has(
        &error("45", "\"high\""),
        &[
            "bad.json:6:28 (at /sun/elevation_deg)",
            "invalid type: string",
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
        &["bad.json:4:", "unknown variant", "Did you mean `uniform`?"],
    );
    has(
        &error("[100, 50, 100]", "[100, 50]"),
        &["bad.json:3:", "/container/box/max_m", "length 2"],
    );
    has(
        &error("\"name\": \"slab\",", ""),
        &["bad.json:1:1 (at the top level)", "missing field `name`"],
    );
    has(&error("45,", "45,,"), &["bad.json:6:31"]);
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
