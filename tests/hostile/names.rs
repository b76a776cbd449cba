//! Names that could escape from the report folder, the page, a chart or a line.

use super::records::{files, is_inert, report};
use occlab::batch::record::Report;
use occlab::batch::report_folder;
use occlab::config::load_scene;
use serde_json::json;
use std::path::Path;

fn hostile() -> Vec<String> {
    let long = "long <b>name</b> ".repeat(20);
    assert!(long.chars().count() > 300);
    let names = [
        "<script>alert(1)</script>",
        "\"><img src=x onerror=\"alert(1)\">",
        "</title></svg><script>x</script>",
        "../../escape",
        "/etc/passwd",
        "a b  c",
        "C:\\windows\\x",
        "javascript:alert(1)",
        "]]>",
        "&lt;script&gt;",
        "\u{0}\u{1}\u{1b}[2J\r\n",
        "\u{fffe}\u{ffff}\u{85}",
        "名前 \u{202e}gnp.exe",
        "=cmd|' /C calc'!A0",
        ".",
        "..",
        "",
    ];
    names
        .iter()
        .map(|n| (*n).to_owned())
        .chain([long])
        .collect()
}

#[test]
fn a_report_with_hostile_names_stays_in_its_folder_and_its_html() {
    for name in hostile() {
        let outside = tempfile::tempdir().unwrap();
        let folder = outside.path().join("report");
        std::fs::create_dir(&folder).unwrap();
        std::fs::write(outside.path().join("secret.png"), "secret").unwrap();
        let before = files(outside.path());
        let mut value = report();
        value["experiment"]["name"] = json!(name);
        value["environment"]["adapter"] = json!(name);
        for cell in value["cells"].as_array_mut().unwrap() {
            cell["scene"] = json!(name);
            cell["method"] = json!(name);
            cell["id"] = json!(name);
            cell["params"] = json!({ name.as_str(): name });
            if cell["result"].is_object() {
                cell["result"]["files"]["png"] = json!("../secret.png");
            }
        }
        value["references"][0]["scene"] = json!(name);
        value["references"][0]["files"]["png"] = json!(name);
        let read: Report = serde_json::from_value(value).unwrap();
        occlab::report::write(&folder, &read).unwrap();

        let new: Vec<_> = files(outside.path()).difference(&before).cloned().collect();
        assert!(
            new.iter().all(|f| f.starts_with("report")),
            "{name:?}: {new:?}"
        );
        assert!(new.len() > 3);
        let html = std::fs::read_to_string(folder.join("index.html")).unwrap();
        is_inert(&html);
        assert!(!html.contains("c2VjcmV0"), "a file outside is embedded");
        for file in new
            .iter()
            .filter(|f| f.extension().is_some_and(|e| e == "svg"))
        {
            let svg = std::fs::read_to_string(outside.path().join(file)).unwrap();
            is_xml(&svg, &name);
            let bytes = file.file_name().unwrap().len();
            assert!(bytes < 100, "{} has {bytes} bytes", file.display());
        }
        let mut csv = csv::Reader::from_path(folder.join("cells.csv")).unwrap();
        let at = csv
            .headers()
            .unwrap()
            .iter()
            .position(|h| h == "scene")
            .unwrap();
        for row in csv.records() {
            assert_eq!(&row.unwrap()[at], name);
        }
    }
}

/// Tags nest, text holds no bare `<` or `&`, and every character is one that XML 1.0 has (section 2.2).
fn is_xml(svg: &str, name: &str) {
    let mut open = Vec::new();
    let mut rest = svg;
    while let Some(at) = rest.find('<') {
        let end = at
            + rest[at..]
                .find('>')
                .unwrap_or_else(|| panic!("{name:?}: a tag has no end"));
        let tag = &rest[at + 1..end];
        let word = tag.split([' ', '\n', '/']).next().unwrap();
        if let Some(word) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(word), "{name:?}");
        } else if !tag.starts_with('?') && !tag.ends_with('/') {
            open.push(word);
        }
        let known = [
            "svg", "g", "rect", "line", "polyline", "polygon", "circle", "text", "path", "title",
            "desc", "?xml", "",
        ];
        assert!(known.contains(&word), "{name:?}: <{tag}>");
        rest = &rest[end + 1..];
    }
    assert!(open.is_empty(), "{name:?}: {open:?}");
    for (at, _) in svg.match_indices('&') {
        assert!(
            ["&lt;", "&gt;", "&amp;", "&quot;", "&apos;", "&#"]
                .iter()
                .any(|e| svg[at..].starts_with(e)),
            "{name:?}: a bare &"
        );
    }
    assert!(
        svg.chars().all(|c| matches!(c, '\n' | '\t' | '\r' | ' '..='\u{d7ff}' | '\u{e000}'..='\u{fffd}' | '\u{10000}'..)),
        "{name:?}"
    );
}

#[test]
fn the_folder_of_a_report_is_one_step_below_its_parent() {
    for name in hostile() {
        let folder = report_folder(Path::new("reports"), &name);
        assert_eq!(folder.parent(), Some(Path::new("reports")), "{name:?}");
        let last = folder.file_name().unwrap().to_str().unwrap();
        assert!(
            last.len() <= 80
                && last
                    .chars()
                    .all(|c| c.is_ascii_alphanumeric() || "-_".contains(c)),
            "{last}"
        );
    }
}

/// File names on disk may be any bytes.
#[cfg(unix)]
#[test]
fn a_scene_file_whose_name_is_not_utf8_is_read_and_named_in_errors() {
    use std::os::unix::ffi::OsStrExt;
    let folder = tempfile::tempdir().unwrap();
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/scenes");
    let path = folder
        .path()
        .join(std::ffi::OsStr::from_bytes(b"sc\xff\xfe\n.json"));
    std::fs::copy(scenes.join("cumulus.json"), &path).unwrap();
    assert_eq!(load_scene(&path).unwrap().name, "cumulus");
    std::fs::write(&path, "{").unwrap();
    let message = load_scene(&path).unwrap_err().to_string();
    assert!(
        message.contains("sc\u{fffd}\u{fffd}\\n.json:1:"),
        "{message}"
    );
    assert!(!message.chars().any(char::is_control));
}
