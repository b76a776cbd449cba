//! The window's content, used as a user does: by drop-downs, keys and menus found through the accessibility tree.
#![cfg(feature = "ui")]

#[macro_use]
mod common;
#[path = "ui/files.rs"]
mod files;
#[path = "common/program.rs"]
mod program;
#[path = "ui/snapshots.rs"]
mod snapshots;
#[path = "common/window.rs"]
mod window;

use eframe::egui::{Key, Modifiers, Theme, accesskit::Role};
use egui_kittest::kittest::{NodeT, Queryable};
use occlab::occlusion::REGISTRY;
use occlab::param::ParamValue;
use occlab::ui::{App, Mode};
use std::path::Path;
use std::time::Instant;
use window::{
    Window, choose, entries, method_a, picture_rect, rect_of, says, settle, tiny_state, until,
    window, window_of,
};

#[test]
fn the_drop_down_lists_the_registry() {
    needs_adapter!();
    let mut window = window(tiny_state());
    for label in ["Method A", "Method B"] {
        window.get_by_role_and_label(Role::ComboBox, label).click();
        window.run_steps(3);
        let found: Vec<_> = entries(&window).iter().map(|(id, _)| *id).collect();
        let all: Vec<_> = REGISTRY.iter().map(|m| m.info().id).collect();
        assert_eq!(found, all, "{label}");
        window.key_press(Key::Escape);
        window.run_steps(3);
    }
}

#[test]
fn choosing_a_method_changes_the_picture() {
    needs_adapter!();
    let mut window = window(tiny_state());
    settle(&mut window);
    let before = window.state().picture(0).unwrap().0.clone();
    assert!(before.is_exact());
    let drawn_before = window.render().unwrap();

    choose(&mut window, "Method A", "none");
    assert_eq!(method_a(&window).method.info().id, "none");
    settle(&mut window);
    let after = window.state().picture(0).unwrap().0.clone();
    assert!(after.is_exact());
    assert_ne!(before.frame.sun, after.frame.sun);
    assert_ne!(before.rgb, after.rgb);

    let drawn_after = window.render().unwrap();
    let rect = picture_rect(&window);
    let inside = |image: &image::RgbaImage| {
        let (x, y) = (rect.min.x as u32, rect.min.y as u32);
        let view =
            image::imageops::crop_imm(image, x, y, rect.width() as u32, rect.height() as u32);
        view.to_image()
    };
    assert_ne!(inside(&drawn_before), inside(&drawn_after));
}

#[test]
fn every_way_of_comparing_is_drawn() {
    needs_adapter!();
    let mut window = window(tiny_state());
    for mode in Mode::ALL {
        window.state_mut().set_mode(mode);
        settle(&mut window);
        let app = window.state();
        let truth = app.truth().unwrap().1;
        let sides = [0, 1].map(|side| app.picture(side).map(|p| p.1));
        let on_screen = |texture: Option<_>| texture.is_some_and(|t| rect_of(&window, t).is_some());
        match mode {
            Mode::Single => assert!(on_screen(sides[0])),
            Mode::Truth => assert!(on_screen(Some(truth))),
            _ => {}
        }
        window.render().unwrap();
    }
}

/// The first number control of this name: that of the method A.
fn set_number(window: &mut Window, name: &str, value: f64) {
    let nodes = window.query_all_by_label(name);
    let control = nodes
        .into_iter()
        .find(|n| [Role::SpinButton, Role::Slider].contains(&n.accesskit_node().role()))
        .unwrap_or_else(|| panic!("no control for {name}"));
    control.set_value_accesskit(value);
    window.run_steps(2);
}

#[test]
fn a_parameter_can_be_changed_undone_and_done_again() {
    needs_adapter!();
    let mut window = window(tiny_state());
    settle(&mut window);
    let steps = |window: &Window| method_a(window).params.get("steps");
    let before = steps(&window).unwrap();
    // Undo takes a state that has lasted a second of the harness's clock.
    window.run_steps(8);
    set_number(&mut window, "steps", 3.0);
    assert_eq!(steps(&window), Some(ParamValue::Int(3)));
    window.run_steps(8);
    settle(&mut window);

    window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    window.run_steps(2);
    assert_eq!(steps(&window), Some(before));
    for (modifiers, key) in [
        (Modifiers::COMMAND | Modifiers::SHIFT, Key::Z),
        (Modifiers::COMMAND, Key::Y),
    ] {
        window.key_press_modifiers(modifiers, key);
        window.run_steps(2);
        assert_eq!(steps(&window), Some(ParamValue::Int(3)));
        window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
        window.run_steps(2);
        assert_eq!(steps(&window), Some(before));
    }
}

#[test]
fn a_parameter_has_a_control_where_it_applies() {
    needs_adapter!();
    for (spacing, applies) in [("uniform", false), ("uniform_reach", true)] {
        let mut state = tiny_state();
        let [srm, _] = state.methods.clone();
        state.methods[0] = srm.with("spacing", spacing).unwrap();
        let mut window = window(state);
        window.run_steps(3);
        let shown = |name: &str| window.query_all_by_label(name).count() > 0;
        assert!(shown("spacing"));
        assert_eq!(shown("reach_m"), applies, "{spacing}");
    }
}

fn copy_folder(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let target = to.join(entry.file_name());
        if entry.file_type().unwrap().is_dir() {
            copy_folder(&entry.path(), &target);
        } else {
            std::fs::copy(entry.path(), target).unwrap();
        }
    }
}

#[test]
fn a_broken_shader_is_a_banner_until_it_is_mended() {
    needs_adapter!();
    let folder = tempfile::tempdir().unwrap();
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders");
    copy_folder(&own, folder.path());
    let mut window = window_of(
        [960.0, 540.0],
        Theme::Dark,
        Some(folder.path()),
        |live, adapter| App::new(live, adapter, Some(tiny_state()), Instant::now()).unwrap(),
    );
    settle(&mut window);
    let file = folder.path().join("occlusion/srm.wgsl");
    let text = std::fs::read_to_string(&file).unwrap();
    std::fs::write(&file, format!("{text}\nfn broken( {{\n")).unwrap();
    until(&mut window, "the banner", |w| says(w, "srm.wgsl"));
    assert!(says(&window, "do not compile"));
    assert!(window.state().picture(0).is_some());
    std::fs::write(&file, text).unwrap();
    until(&mut window, "no banner", |w| !says(w, "do not compile"));
}

#[test]
fn every_control_has_a_name() {
    needs_adapter!();
    let mut window = window(tiny_state());
    let check = |window: &Window, what: &str| {
        let unnamed = window.unnamed_widgets();
        assert!(unnamed.is_empty(), "{what}: {unnamed:#?}");
    };
    for mode in Mode::ALL {
        window.state_mut().set_mode(mode);
        settle(&mut window);
        check(&window, mode.name());
    }
    for menu in ["File", "Edit", "View", "Help"] {
        window.get_by_role_and_label(Role::Button, menu).click();
        window.run_steps(3);
        check(&window, menu);
        window.key_press(Key::Escape);
        window.run_steps(3);
    }
    for method in REGISTRY {
        let mut state = tiny_state();
        state.methods[0] = common::with_map(method.info().id, "resolution=32 steps=16", "");
        window.state_mut().show_state(state);
        window.run_steps(3);
        check(&window, method.info().id);
    }
}

#[test]
fn no_size_is_too_small_or_too_large() {
    needs_adapter!();
    let mut window = window(tiny_state());
    settle(&mut window);
    for points in [1.0, 2.0] {
        window.set_pixels_per_point(points);
        for size in [[1.0, 1.0], [40.0, 3.0], [320.0, 180.0], [1920.0, 1080.0]] {
            window.set_size(size.into());
            window.run_steps(3);
        }
        window.render().unwrap();
    }
}

#[test]
fn the_keys_are_listed_and_the_list_closes() {
    needs_adapter!();
    let mut window = window(tiny_state());
    for key in [Key::Questionmark, Key::F1] {
        assert!(!says(&window, "Ctrl+Shift+Z"));
        window.key_press(key);
        window.run_steps(3);
        assert!(says(&window, "Ctrl+Shift+Z") && says(&window, "Copy the picture of A"));
        window.key_press(Key::Escape);
        window.run_steps(3);
    }
    assert!(!says(&window, "Ctrl+Shift+Z"));
}
