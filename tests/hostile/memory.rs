//! Readers with little memory: an allocation that a header asks for and its file cannot fill would end the process.
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

/// Address space with which the software adapter still starts, KiB.
const ADAPTER_KIB: u64 = 4 << 20;

fn render(folder: &Path, extra: &[&str]) -> Output {
    let scene = r#"{
        "name": "v", "container": {"box": {"min_m": [0, 0, 0], "max_m": [100, 100, 100]}},
        "density": {"volume": {"path": "v.npy", "up_axis": 1}}, "medium": {},
        "sun": {"elevation_deg": 45, "azimuth_deg": 0, "irradiance": [1, 1, 1]},
        "camera": {"position_m": [50, 50, -300], "target_m": [50, 50, 50], "fov_y_deg": 40}
    }"#;
    std::fs::write(folder.join("v.json"), scene).unwrap();
    let mut args = vec!["render", "-s", "v.json", "-m", "none", "-o", "o.png", "-q"];
    args.extend(extra);
    limited(ADAPTER_KIB, &program(), &args, folder)
}

fn volume(shape: &str) -> Vec<u8> {
    let header = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': {shape}, }}\n");
    let length = (header.len() as u16).to_le_bytes();
    [
        b"\x93NUMPY\x01\x00",
        &length[..],
        header.as_bytes(),
        &[0; 32],
    ]
    .concat()
}

#[test]
fn a_volume_that_claims_too_much_is_an_error_of_the_program_not_an_abort() {
    let folder = tempfile::tempdir().unwrap();
    let claims = [
        (
            "(9223372036854775808, 1, 1)",
            "axis 0 has 9223372036854775808 voxels",
        ),
        ("(2097152, 2097152, 2097152)", "axis 0 has 2097152 voxels"),
        ("(2048, 2048, 512)", "announces 8589934592 bytes"),
    ];
    for (shape, word) in claims {
        std::fs::write(folder.path().join("v.npy"), volume(shape)).unwrap();
        let size = ["--width", "8", "--height", "8"];
        refused(&render(folder.path(), &size), &["v.npy", word]);
    }
}

#[test]
fn a_picture_whose_bytes_do_not_fit_64_bits_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("v.npy"), volume("(2, 2, 2)")).unwrap();
    // The product of the second pair is 2^60 + 2^15: its bytes, modulo 2^64, are those of a small picture.
    for (width, height) in [("4294967295", "4294967295"), ("1073774592", "1073709057")] {
        let size = ["--width", width, "--height", height];
        refused(&render(folder.path(), &size), &[width, " allow"]);
    }
}
