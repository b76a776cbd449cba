//! The program in an empty folder, with an environment without a desktop.

#[macro_use]
mod common;
#[path = "common/program.rs"]
mod program;

use program::{experiment, occlab, refused, stderr, workplace};
use serde_json::json;
use std::path::{Path, PathBuf};
use std::process::Output;

/// Runs the program in `folder` with arguments separated by blanks.
fn run(folder: &Path, arguments: &str) -> Output {
    let mut command = occlab(folder);
    for name in ["XDG_RUNTIME_DIR", "DISPLAY", "WAYLAND_DISPLAY"] {
        command.env_remove(name);
    }
    command.args(arguments.split_whitespace()).output().unwrap()
}

/// What it printed on stdout; it must have succeeded.
fn stdout(output: &Output) -> String {
    assert!(output.status.success(), "{}", stderr(output));
    String::from_utf8(output.stdout.clone()).unwrap()
}

fn empty() -> tempfile::TempDir {
    tempfile::tempdir().unwrap()
}

#[test]
fn a_command_without_a_window_does_not_ask_for_the_desktop() {
    needs_adapter!();
    let folder = workplace(|_, e| e["sun_elevation_deg"] = json!(60));
    let adapters = run(folder.path(), "adapters");
    assert!(stdout(&adapters).contains("Vulkan"));
    assert_eq!(stderr(&adapters), "");
    let batch = run(folder.path(), "batch small.json --out out --quiet");
    assert!(stdout(&batch).contains("index.html"));
    assert_eq!(stderr(&batch), "");
}

/// The scene is read first, then the picture is refused for its ending.
const RENDER: &str = "render -s cumulus -o a.txt";
#[test]
fn what_ships_is_found_by_name_in_an_empty_folder() {
    let (bare, full) = (empty(), empty());
    stdout(&run(full.path(), "init"));
    let same = |arguments: &str| {
        let [bare, full] = [&bare, &full].map(|folder| stdout(&run(folder.path(), arguments)));
        assert!(!bare.is_empty());
        assert_eq!(bare, full, "{arguments}");
    };
    same("batch quick --dry-run");
    same("batch configs/quick.json --dry-run");
    same("batch sample --dry-run");
    same("study");
    refused(&run(bare.path(), RENDER), &["--out: `a.txt`"]);
    let study = run(bare.path(), "study m --profile none");
    let place = "configs/studies/m.json (built in):";
    refused(&study, &["--profile", place, "no profile `none`", "quick"]);
    // The sweep's file is read before the adapter is looked for.
    let sweep = run(bare.path(), "stability --adapter none-of-this-name");
    refused(&sweep, &["error: adapter:"]);
}

#[test]
fn a_file_beside_the_user_is_taken_before_the_built_in_one_in_the_order_of_the_help() {
    let folder = empty();
    std::fs::create_dir_all(folder.path().join("configs/scenes")).unwrap();
    let kinds = [
        ("batch quick --dry-run", "quick", "configs/quick.json"),
        (RENDER, "cumulus", "configs/scenes/cumulus.json"),
    ];
    for (arguments, name, in_folder) in kinds {
        let places = [name, &format!("{name}.json"), in_folder];
        for place in places {
            std::fs::write(folder.path().join(place), "broken").unwrap();
        }
        for place in places {
            refused(
                &run(folder.path(), arguments),
                &[&format!("error: {place}:1:1")],
            );
            std::fs::remove_file(folder.path().join(place)).unwrap();
        }
        let built_in = run(folder.path(), arguments);
        assert!(!stderr(&built_in).contains(name), "{}", stderr(&built_in));
    }
    let help = stdout(&run(folder.path(), "--help"));
    let words = help.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(
        words.contains("the file NAME, the file NAME.json, NAME.json in `configs`"),
        "{help}"
    );
}

#[test]
fn an_experiment_of_ones_own_uses_built_in_scenes() {
    let folder = empty();
    let mut own = experiment();
    own["scenes"] = json!(["scenes/cumulus.json"]);
    let path = folder.path().join("mine.json");
    std::fs::write(&path, own.to_string()).unwrap();
    assert!(stdout(&run(folder.path(), "batch mine --dry-run")).contains("cumulus"));

    std::fs::create_dir(folder.path().join("scenes")).unwrap();
    std::fs::write(folder.path().join("scenes/cumulus.json"), "broken").unwrap();
    let beside = run(folder.path(), "batch mine --dry-run");
    refused(&beside, &["error: scenes/cumulus.json:1:1"]);

    own["scenes"] = json!(["scenes/cumulis.json"]);
    std::fs::write(&path, own.to_string()).unwrap();
    let absent = run(folder.path(), "batch mine --dry-run");
    refused(
        &absent,
        &[
            "mine.json:1:",
            "relative to the experiment file",
            "scenes/cumulus.json",
        ],
    );
}

#[test]
fn a_name_found_nowhere_is_answered_with_what_is_built_in() {
    let folder = empty();
    let cases: [(&str, &[&str]); 4] = [
        (
            "batch quik",
            &[
                "error: quik: there is no experiment",
                "`quick`?",
                "convergence, decompose, flicker",
            ],
        ),
        (
            "batch configs/quik.json",
            &["error: configs/quik.json:", "`quick`?"],
        ),
        (
            "render -s cumulsu -o a.exr",
            &[
                "error: cumulsu: there is no scene",
                "`cumulus`?",
                "overcast, stratus",
            ],
        ),
        ("study n", &["error: n: there is no study", "Built in: m."]),
    ];
    for (arguments, words) in cases {
        refused(&run(folder.path(), arguments), words);
    }
}

/// Every file below `folder`, with its text.
fn texts(folder: &Path) -> Vec<(PathBuf, String)> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        match path.is_dir() {
            true => found.extend(texts(&path)),
            false => found.push((path.clone(), std::fs::read_to_string(path).unwrap())),
        }
    }
    found.sort();
    found
}

#[test]
fn init_writes_what_ships_and_overwrites_nothing() {
    let folder = empty();
    let work = folder.path().join("new/work");
    let said = stdout(&run(folder.path(), "init new/work"));
    let shipped = texts(&Path::new(env!("CARGO_MANIFEST_DIR")).join("configs"));
    let names = |files: &[(PathBuf, String)]| -> Vec<String> {
        files.iter().map(|(_, text)| text.clone()).collect()
    };
    assert_eq!(names(&texts(&work.join("configs"))), names(&shipped));
    assert_eq!(said.matches(": written").count(), shipped.len());

    let [mine, lost] =
        ["quick.json", "scenes/stratus.json"].map(|name| work.join("configs").join(name));
    std::fs::write(&mine, "mine").unwrap();
    std::fs::remove_file(&lost).unwrap();
    let again = run(folder.path(), "init new/work");
    let said = stdout(&again);
    assert_eq!(std::fs::read_to_string(&mine).unwrap(), "mine");
    assert!(lost.exists());
    assert!(said.contains("new/work/configs/quick.json: KEPT"), "{said}");
    assert!(
        said.contains("new/work/configs/scenes/stratus.json: written"),
        "{said}"
    );
    assert_eq!(said.matches("KEPT").count(), 1);
    assert!(
        stderr(&again).contains("1 of yours kept"),
        "{}",
        stderr(&again)
    );

    std::fs::write(folder.path().join("file"), "").unwrap();
    refused(
        &run(folder.path(), "init file"),
        &["file/configs: cannot write"],
    );
}
