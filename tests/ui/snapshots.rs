//! The window's frame against stored pictures, without what it measures. `OCCLAB_BLESS=1 cargo test --test ui` stores
//! new ones (and fails: a run that blesses is never green); look at them before committing.

use super::common;
use super::window::{Window, picture_rect, settle, tiny_state, window_of};
use eframe::egui::{Rect, Theme, accesskit::Role, pos2};
use egui_kittest::kittest::Queryable;
use image::RgbaImage;
use occlab::ui::App;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Share of pixels that may differ by more than [`NOISE`]: adapters blend the edges of glyphs in their own way.
const TOLERANCE: f64 = 2e-3;
/// Largest difference of a channel, of 255, that counts as noise.
const NOISE: u8 = 24;
const HOW_TO_BLESS: &str =
    "run `OCCLAB_BLESS=1 cargo test --release --test ui` and look at the new file";

fn stored(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/snapshots/ui")
        .join(format!("{name}.png"))
}

/// Share of pixels that differ.
fn difference(a: &RgbaImage, b: &RgbaImage) -> f64 {
    if a.dimensions() != b.dimensions() {
        return 1.0;
    }
    let differs = |(a, b): (&image::Rgba<u8>, &image::Rgba<u8>)| {
        a.0.iter().zip(b.0).any(|(a, b)| a.abs_diff(b) > NOISE)
    };
    let count = a.pixels().zip(b.pixels()).filter(|p| differs(*p)).count();
    count as f64 / f64::from(a.width() * a.height())
}

/// The window, with the picture and the measurements covered.
fn frame(window: &mut Window) -> RgbaImage {
    let picture = picture_rect(window);
    let truth = window.get_by_role_and_label(Role::CheckBox, "Error against the truth");
    let measured = Rect::from_min_max(
        pos2(truth.rect().min.x - 6.0, 0.0),
        pos2(f32::MAX, f32::MAX),
    );
    window.mask(picture);
    window.mask(measured.intersect(window.ctx.content_rect()));
    window.render().unwrap()
}

#[test]
fn the_frame_around_the_picture() {
    needs_adapter!();
    let mut shown = Vec::new();
    for (theme, theme_name) in [(Theme::Dark, "dark"), (Theme::Light, "light")] {
        for size in [[960.0, 540.0], [640.0, 360.0]] {
            let mut window = window_of(size, theme, None, |live, _| {
                App::new(live, "adapter".into(), Some(tiny_state()), Instant::now()).unwrap()
            });
            settle(&mut window);
            let name = format!("{theme_name}-{}", size[0]);
            shown.push((name, frame(&mut window)));
        }
    }
    as_stored(&shown);
}

#[test]
fn a_warped_map_as_it_is_stored_and_in_the_plane() {
    needs_adapter!();
    let mut state = tiny_state();
    state.scene.sun.elevation_deg = 20.0;
    state.scene.camera.position_m = [500.0, 800.0, -60.0];
    state.scene.camera.target_m = [700.0, 700.0, 400.0];
    state.methods[0] = common::with_map("bsm", "resolution=64 steps=16 fit=warped", "");
    let mut window = window_of([960.0, 540.0], Theme::Dark, None, |live, _| {
        App::new(live, "adapter".into(), Some(state), Instant::now()).unwrap()
    });
    settle(&mut window);
    press(&mut window, "Light map");
    let mut shown = Vec::new();
    for shape in ["As stored", "In the plane"] {
        press(&mut window, shape);
        let name = format!("map-{}", shape.to_lowercase().replace(' ', "-"));
        shown.push((name, frame(&mut window)));
    }
    press(&mut window, "Texel grid");
    let without = frame(&mut window);
    assert!(difference(&without, &shown[1].1) > 2.0 * TOLERANCE);
    as_stored(&shown);
}

/// Presses the control of this name and waits for what it asks for.
fn press(window: &mut Window, label: &str) {
    window.get_by_label(label).click();
    settle(window);
}

/// Compares windows with the stored pictures, each of which must refuse the others; or stores them.
fn as_stored(shown: &[(String, RgbaImage)]) {
    if std::env::var_os("OCCLAB_BLESS").is_some_and(|v| v == "1") {
        for (name, image) in shown {
            image.save(stored(name)).unwrap();
        }
        panic!("snapshots were written; run the tests again without OCCLAB_BLESS");
    }
    for (name, image) in shown {
        let path = stored(name);
        let reference = image::open(&path)
            .unwrap_or_else(|e| panic!("{}: {e}; {HOW_TO_BLESS}", path.display()))
            .to_rgba8();
        let share = difference(image, &reference);
        println!("{name}: {share:.1e}");
        assert!(
            share <= TOLERANCE,
            "{name}: {:.2} % of the pixels differ; if this is wanted, {HOW_TO_BLESS}",
            share * 100.0
        );
        // Negative control: the other windows.
        for (other, image) in shown.iter().filter(|(other, _)| other != name) {
            assert!(difference(image, &reference) > TOLERANCE, "{other} passed");
        }
    }
}
