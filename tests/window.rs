//! The real window under a real X server: a method is chosen with the mouse, and what the screen then shows is compared
//! with the picture that the library renders without a window.
//!
//! Where to click comes from the same content laid out at the same size without a window.
#![cfg(all(feature = "ui", target_os = "linux"))]

#[macro_use]
mod common;
#[path = "common/display.rs"]
mod display;
#[path = "common/program.rs"]
mod program;
#[path = "common/window.rs"]
mod window;

use display::{Child, Display};
use eframe::egui::{Pos2, Rect, Theme, accesskit::Role};
use egui_kittest::kittest::Queryable;
use image::RgbImage;
use occlab::frame::{Exposure, tone_map};
use occlab::live::State;
use occlab::occlusion::MethodSetup;
use occlab::ui::App;
use std::io::Write;
use std::time::{Duration, Instant};
use window::{drop_down, entries, picture_rect, settle, tiny_state, window_of};

/// Largest mean absolute difference over the picture, of 255.
const MEAN: f64 = 2.0;
/// Least share of pixels that are within [`NEAR`] of 255 in every channel.
const SHARE: f64 = 0.99;
const NEAR: u8 = 8;
const SIZE: [u16; 2] = [1280, 720];

/// Says by name that the test is skipped where there is no X server; with OCCLAB_REQUIRE_DISPLAY=1 it fails instead.
fn no_display() -> bool {
    let missing = !["Xvfb", "xdotool"].into_iter().all(display::is_installed);
    if missing {
        let required = std::env::var_os("OCCLAB_REQUIRE_DISPLAY").is_some_and(|v| v == "1");
        assert!(
            !required,
            "OCCLAB_REQUIRE_DISPLAY is set and Xvfb or xdotool is missing"
        );
        let thread = std::thread::current();
        let name = thread.name().unwrap_or("a test");
        let _ = writeln!(std::io::stderr(), "skipped: no Xvfb or xdotool: {name}");
    }
    missing
}

/// Where things are in a window of [`SIZE`].
struct Layout {
    picture: Rect,
    drop_down: Pos2,
    entry: Rect,
}

fn layout(state: &State, method: &str) -> Layout {
    let size = SIZE.map(f32::from);
    let mut window = window_of(size, Theme::Dark, None, |live, adapter| {
        App::new(live, adapter, Some(state.clone()), Instant::now()).unwrap()
    });
    settle(&mut window);
    let picture = picture_rect(&window);
    let drop_down = drop_down(&window, "Method A").center();
    window
        .get_by_role_and_label(Role::ComboBox, "Method A")
        .click();
    window.run_steps(3);
    let entries = entries(&window);
    let (_, entry) = entries.into_iter().find(|(id, _)| *id == method).unwrap();
    Layout {
        picture,
        drop_down,
        entry,
    }
}

/// The picture of a method as the window should show it.
fn expected(state: &State, setup: &MethodSetup) -> RgbImage {
    let truth = MethodSetup::truth(&state.scene).unwrap();
    let truth = common::render(&state.scene, state.image, &truth);
    let frame = common::render(&state.scene, state.image, setup);
    let pixels = tone_map(&frame, Exposure::from_reference(&truth));
    RgbImage::from_raw(frame.width, frame.height, pixels).unwrap()
}

/// Mean absolute difference of 255 and share of near pixels, of `picture` enlarged into `rect` of the screen.
fn compare(screen: &RgbImage, rect: Rect, picture: &RgbImage) -> (f64, f64) {
    let (mut sum, mut near, mut count) = (0.0, 0.0, 0.0);
    // Without the outermost pixels, which a rectangle between two of them covers in part.
    let columns = rect.min.x.ceil() as u32 + 1..rect.max.x.floor() as u32 - 1;
    let rows = rect.min.y.ceil() as u32 + 1..rect.max.y.floor() as u32 - 1;
    for y in rows {
        for x in columns.clone() {
            let place = |at: u32, min: f32, length: f32, texels: u32| {
                let share = (f64::from(at) + 0.5 - f64::from(min)) / f64::from(length);
                ((share * f64::from(texels)) as u32).min(texels - 1)
            };
            let u = place(x, rect.min.x, rect.width(), picture.width());
            let v = place(y, rect.min.y, rect.height(), picture.height());
            let (seen, wanted) = (screen.get_pixel(x, y).0, picture.get_pixel(u, v).0);
            let apart = [0, 1, 2].map(|i| seen[i].abs_diff(wanted[i]));
            sum += apart.iter().map(|d| f64::from(*d)).sum::<f64>() / 3.0;
            near += f64::from(u8::from(apart.iter().all(|d| *d <= NEAR)));
            count += 1.0;
        }
    }
    (sum / count, near / count)
}

fn agrees((mean, share): (f64, f64)) -> bool {
    mean <= MEAN && share >= SHARE
}

/// Waits until the screen fulfils `test`.
fn wait(display: &Display, what: &str, test: impl Fn(&RgbImage) -> bool) -> RgbImage {
    let start = Instant::now();
    loop {
        let screen = display.screenshot();
        if test(&screen) {
            return screen;
        }
        if start.elapsed() > Duration::from_secs(90) {
            let kept = std::env::temp_dir().join("occlab-window-test.png");
            screen.save(&kept).unwrap();
            panic!("it never came: {what}; the screen is in {}", kept.display());
        }
        std::thread::sleep(Duration::from_millis(100));
    }
}

#[test]
fn a_method_chosen_with_the_mouse_is_what_the_screen_shows() {
    needs_adapter!();
    if no_display() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let state = tiny_state();
    state.save(&folder.path().join("scene.json")).unwrap();
    let layout = layout(&state, "none");
    let before = expected(&state, &state.methods[0]);
    let after = expected(&state, &MethodSetup::defaults("none").unwrap());

    let display = Display::start(SIZE);
    let mut command = program::occlab(folder.path());
    command
        .args(["view", "scene.json"])
        .env("DISPLAY", display.name())
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("WAYLAND_SOCKET")
        .env("WINIT_X11_SCALE_FACTOR", "1")
        .env("OCCLAB_STATE", folder.path().join("window.json"));
    let _program = Child::start(&mut command);
    let seen = |screen: &RgbImage, picture: &RgbImage| compare(screen, layout.picture, picture);

    let screen = wait(&display, "the first picture", |s| agrees(seen(s, &before)));
    println!("before: {:?}", seen(&screen, &before));
    assert!(
        !agrees(seen(&screen, &after)),
        "the two methods look the same"
    );
    let closed = part(&screen, layout.entry);
    display.click(layout.drop_down);
    wait(&display, "the drop-down", |s| {
        part(s, layout.entry) != closed
    });
    display.click(layout.entry.center());
    let screen = wait(&display, "the other method", |s| agrees(seen(s, &after)));
    println!("after: {:?}", seen(&screen, &after));
    // Negative control: the picture of the method before must not pass for the other.
    assert!(!agrees(seen(&screen, &before)));
}

fn part(screen: &RgbImage, rect: Rect) -> RgbImage {
    let (x, y) = (rect.min.x as u32, rect.min.y as u32);
    let (width, height) = (rect.width() as u32, rect.height() as u32);
    image::imageops::crop_imm(screen, x, y, width, height).to_image()
}
