//! Shaders that change on disk while the worker runs.

use super::{common, exact, live, request, scene, served, until};
use occlab::live::{Update, What};
use std::path::Path;

/// The folder `shaders` in a copy that a test may damage.
fn copied_shaders(to: &Path) {
    fn copy(from: &Path, to: &Path) {
        std::fs::create_dir_all(to).unwrap();
        for entry in std::fs::read_dir(from).unwrap() {
            let path = entry.unwrap().path();
            let target = to.join(path.file_name().unwrap());
            if path.is_dir() {
                copy(&path, &target);
            } else {
                std::fs::copy(&path, &target).unwrap();
            }
        }
    }
    copy(&Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders"), to);
}

#[test]
fn a_broken_shader_is_named_and_the_old_one_stays_until_it_is_mended() {
    needs_adapter!();
    let folder = tempfile::tempdir().unwrap();
    copied_shaders(folder.path());
    let live = live(Some(folder.path()));
    let whole = served(&live, &request(1, scene(), &["srm"]));

    let file = folder.path().join("occlusion/srm.wgsl");
    let text = std::fs::read_to_string(&file).unwrap();
    std::fs::write(
        &file,
        text.replace("fn light_transmittance", "fn light_transmittance oops"),
    )
    .unwrap();
    let updates = until(&live, |u| matches!(u, Update::Shaders(_)));
    let Some(Update::Shaders(Err(problem))) = updates.last() else {
        panic!("{updates:?}");
    };
    assert!(problem.contains("occlusion/srm.wgsl:"), "{problem}");
    let mut other = request(2, scene(), &["srm"]);
    other.scene.sun.azimuth_deg += 10.0;
    served(&live, &other);

    // A shader that compiles but computes something else is taken over.
    let none = "return exp(-";
    assert!(text.contains(none), "srm.wgsl no longer holds `{none}`");
    std::fs::write(&file, text.replace(none, "return exp(-2.0 * ")).unwrap();
    until(&live, |u| matches!(u, Update::Shaders(Ok(()))));
    let changed = served(&live, &request(3, scene(), &["srm"]));
    assert_ne!(
        exact(&whole, What::Method(0)),
        exact(&changed, What::Method(0))
    );

    std::fs::write(&file, &text).unwrap();
    until(&live, |u| matches!(u, Update::Shaders(Ok(()))));
    let mended = served(&live, &request(4, scene(), &["srm"]));
    assert_eq!(
        exact(&whole, What::Method(0)),
        exact(&mended, What::Method(0))
    );
}
