//! The same readers with little memory: an allocation that a header asks for and its file cannot fill would end the
//! process.
#![cfg(target_os = "linux")]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Runs a command with its address space limited, KiB.
fn limited(kib: u64, program: &Path, args: &[&str], folder: &Path) -> Output {
    Command::new("sh")
        .args(["-c", &format!("ulimit -v {kib}; exec \"$@\""), "sh"])
        .arg(program)
        .args(args)
        .current_dir(folder)
        .env("OCCLAB_CACHE", folder.join("cache"))
        .env("RAYON_NUM_THREADS", "2")
        .output()
        .unwrap()
}

fn program() -> PathBuf {
    env!("CARGO_BIN_EXE_occlab").into()
}

#[test]
fn the_readers_need_little_memory_for_small_files() {
    let folder = tempfile::tempdir().unwrap();
    let itself = std::env::current_exe().unwrap();
    for module in ["pictures::", "volumes::"] {
        let args = ["--test-threads=1", module, "--skip", "one_colour"];
        let output = limited(1 << 20, &itself, &args, folder.path());
        let text = String::from_utf8_lossy(&output.stdout);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{module}\n{text}\n{errors}");
        assert!(!text.contains("running 0 tests"));
    }
}

/// One refusal: exit code 2 and a paragraph.
fn refused(output: &Output, words: &[&str]) {
    let text = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{text}");
    for word in words {
        assert!(text.contains(word), "`{word}` is not in: {text}");
    }
}

#[test]
fn a_picture_that_claims_too_much_is_an_error_of_the_program_not_an_abort() {
    let folder = tempfile::tempdir().unwrap();
    let header = |width: u32, height: u32| {
        let size = [width.to_be_bytes(), height.to_be_bytes()].concat();
        [
            &b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR"[..],
            &size,
            &[8, 6, 0, 0, 0, 0, 0, 0, 0],
        ]
        .concat()
    };
    for size in [0x7fff_ffff, 16384] {
        std::fs::write(folder.path().join("a.png"), header(size, size)).unwrap();
        refused(
            &limited(
                1 << 20,
                &program(),
                &["diff", "a.png", "a.png"],
                folder.path(),
            ),
            &["a.png"],
        );
    }
}

#[test]
fn lists_and_names_that_claim_too_much_are_errors_of_the_program() {
    let folder = tempfile::tempdir().unwrap();
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/scenes/cumulus.json");
    std::fs::copy(scene, folder.path().join("one.json")).unwrap();
    let suns = vec!["9"; 300_000].join(",");
    let scenes = vec!["\"one.json\""; 3000].join(",");
    let text = format!(
        "{{\"name\": \"e\", \"image\": {{\"width\": 8, \"height\": 8}}, \"scenes\": [{scenes}], \
         \"sun_elevation_deg\": [{suns}], \"methods\": \"none\"}}"
    );
    std::fs::write(folder.path().join("small.json"), text).unwrap();
    let output = limited(
        1 << 20,
        &program(),
        &["batch", "small.json", "--dry-run"],
        folder.path(),
    );
    refused(&output, &["small.json", "300000 sun_elevation_deg"]);
}
