//! The folder of truths and the commit in a record, from the command line.

#[path = "common/program.rs"]
mod program;

use program::{occlab, refused, report, stderr, without_adapter, workplace};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::Output;

/// Runs the program without a device, with a cache folder and a limit.
fn run(folder: &Path, cache: &Path, limit: &str, arguments: &[&str]) -> Output {
    without_adapter(&mut occlab(folder))
        .env("OCCLAB_CACHE", cache)
        .env("OCCLAB_CACHE_LIMIT", limit)
        .args(arguments)
        .output()
        .unwrap()
}

/// A batch of three views into a fresh folder.
fn batch(folder: &Path, cache: &Path, limit: &str) -> Output {
    let _ = std::fs::remove_dir_all(folder.join("out"));
    let arguments = ["batch", "small.json", "--out", "out", "--backend", "cpu"];
    run(folder, cache, limit, &arguments)
}

fn shown(output: &Output) -> Value {
    assert!(output.status.success(), "{}", stderr(output));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Truths that the last batch took from the cache.
fn taken(folder: &Path) -> usize {
    let references = report(folder)["references"].clone();
    let all = references.as_array().unwrap().iter();
    all.filter(|truth| truth["cached"] == json!(true)).count()
}

fn small() -> (tempfile::TempDir, PathBuf) {
    let folder = workplace(|_, e| e["methods"] = json!("none"));
    let cache = folder.path().join("cache");
    (folder, cache)
}

#[test]
fn the_cache_is_shown_kept_within_its_limit_and_emptied() {
    let (folder, cache) = small();
    let folder = folder.path();
    let cached = |limit: &str, options: &[&str]| {
        let arguments = [&["cache", "--json"], options].concat();
        shown(&run(folder, &cache, limit, &arguments))
    };
    let empty = cached("", &[]);
    assert_eq!(empty["folder"], json!(cache));
    assert_eq!((&empty["entries"], &empty["bytes"]), (&json!(0), &json!(0)));
    assert_eq!(empty["last_use_unix_s"], Value::Null);
    assert_eq!(empty["limit_bytes"], json!(4_u64 << 30));

    assert!(batch(folder, &cache, "").status.success());
    let full = cached("none", &[]);
    assert_eq!(
        (&full["entries"], &full["limit_bytes"]),
        (&json!(3), &Value::Null)
    );
    let seconds = |key: &str| full[key].as_u64().unwrap();
    assert!(seconds("oldest_use_unix_s") <= seconds("last_use_unix_s"));
    assert!(batch(folder, &cache, "none").status.success());
    assert_eq!(taken(folder), 3);

    let text = run(folder, &cache, "64 MiB", &["cache"]);
    let text = String::from_utf8(text.stdout).unwrap();
    for words in [
        "truths   3",
        "limit 64.00 MiB",
        "ago",
        cache.to_str().unwrap(),
    ] {
        assert!(text.contains(words), "`{words}` is not in: {text}");
    }

    std::fs::write(cache.join("notes.txt"), "mine").unwrap();
    let cleared = cached("", &["--clear"]);
    assert_eq!(cleared["removed"]["entries"], json!(3));
    assert_eq!(cleared["removed"]["bytes"], full["bytes"]);
    assert_eq!(
        (&cleared["entries"], &cleared["bytes"]),
        (&json!(0), &json!(0))
    );
    assert!(cache.join("notes.txt").is_file());

    // Each truth alone is over the limit: the last one stays.
    let output = batch(folder, &cache, "1");
    assert!(
        output.status.success() && !stderr(&output).contains("note:"),
        "{}",
        stderr(&output)
    );
    assert_eq!(
        (taken(folder), &cached("1", &[])["entries"]),
        (0, &json!(1))
    );
}

#[test]
fn a_limit_that_is_no_size_is_an_error_before_anything_is_measured() {
    let (folder, cache) = small();
    let words = ["OCCLAB_CACHE_LIMIT: `4 parsecs` is no size", "4GiB"];
    refused(&batch(folder.path(), &cache, "4 parsecs"), &words);
    refused(&run(folder.path(), &cache, "4 parsecs", &["cache"]), &words);
    assert!(!folder.path().join("out/cells").exists());
}

/// A file stands where the folder should be; on Linux also a file system in which nothing can be made, even by root.
#[test]
fn a_cache_that_cannot_be_written_costs_notes_and_no_cell() {
    let (folder, _) = small();
    let folder = folder.path();
    std::fs::write(folder.join("file"), "in place of a folder").unwrap();
    let mut unusable = vec![folder.join("file")];
    if cfg!(target_os = "linux") {
        unusable.push("/proc/occlab-truths".into());
    }
    for cache in unusable {
        let output = batch(folder, &cache, "");
        let text = stderr(&output);
        assert_eq!(output.status.code(), Some(0), "{text}");
        let note = format!(
            "note: a truth is not kept for the next run: {}",
            cache.display()
        );
        assert_eq!(text.matches(&note).count(), 3, "{text}");
        let report = report(folder);
        let cells = report["cells"].as_array().unwrap();
        assert!(cells.len() == 3 && cells.iter().all(|cell| cell["failed"].is_null()));
    }
}

#[test]
fn two_batches_over_one_limit_measure_the_same_without_a_word() {
    let (folder, cache) = small();
    let folder = folder.path();
    let limit = "1";
    std::thread::scope(|scope| {
        let runs = ["a", "b"].map(|out| {
            let cache = &cache;
            scope.spawn(move || {
                let arguments = ["batch", "small.json", "--out", out, "--backend", "cpu"];
                run(folder, cache, limit, &arguments)
            })
        });
        for output in runs.map(|run| run.join().unwrap()) {
            let text = stderr(&output);
            assert!(output.status.success() && !text.contains("note:"), "{text}");
        }
    });
    let errors = |out: &str| -> Vec<Value> {
        let bytes = std::fs::read(folder.join(out).join("report.json")).unwrap();
        let report: Value = serde_json::from_slice(&bytes).unwrap();
        let cells = report["cells"].as_array().unwrap().iter();
        cells.map(|cell| cell["result"]["error"].clone()).collect()
    };
    assert_eq!(errors("a"), errors("b"));
    assert!(errors("a").len() == 3 && errors("a").iter().all(Value::is_object));
}

/// 12 hexadecimal digits in brackets, perhaps with `-dirty`; `unknown` where the sources came without history.
fn names_a_commit(version: &str) -> bool {
    let label = version
        .split_once(" (")
        .and_then(|(_, rest)| rest.strip_suffix(')'));
    label.is_some_and(|label| {
        let hash = label.strip_suffix("-dirty").unwrap_or(label);
        label == "unknown" || hash.len() == 12 && hash.chars().all(|c| c.is_ascii_hexdigit())
    })
}

#[test]
fn a_report_and_the_program_name_the_commit_they_are_built_from() {
    let (folder, cache) = small();
    let folder = folder.path();
    let output = run(folder, &cache, "", &["--version"]);
    let version = String::from_utf8(output.stdout).unwrap();
    assert!(
        names_a_commit(version.trim()),
        "`{}` names no commit",
        version.trim()
    );
    assert!(batch(folder, &cache, "").status.success());
    assert_eq!(
        report(folder)["environment"]["commit"],
        json!(version.trim())
    );
    let page = std::fs::read_to_string(folder.join("out/index.html")).unwrap();
    assert!(page.contains(version.trim()));
}
