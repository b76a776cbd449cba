//! What the window opens, saves, remembers and runs.

use super::common;
use super::program::{occlab, stderr, workplace};
use super::window::{Window, live, says, settle, tiny_state, until, window, window_of};
use eframe::egui::{Event, Key, Modifiers, OutputCommand, Theme, accesskit::Role};
use egui_kittest::kittest::Queryable;
use occlab::frame::{read_frame, read_picture};
use occlab::live::State;
use occlab::scene::Density;
use occlab::ui::{App, Mode, Purpose};
use serde_json::{Value, json};
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

/// Types a path into the field that is open and accepts it.
fn type_path(window: &mut Window, path: &Path) {
    window.run_steps(3);
    let field = window.get_by_role_and_label(Role::TextInput, "File");
    field.focus();
    window.run_steps(2);
    window.key_press_modifiers(Modifiers::COMMAND, Key::A);
    window.event(Event::Text(path.display().to_string()));
    window.run_steps(2);
    window.get_by_role_and_label(Role::Button, "OK").click();
    window.run_steps(3);
}

#[test]
fn a_saved_state_comes_back_and_a_batch_reads_it() {
    needs_adapter!();
    let folder = tempfile::tempdir().unwrap();
    let mut state = tiny_state();
    state.methods[1] = common::setup("fom", "resolution=16 order=3");
    let mut window = window(state.clone());
    let path = folder.path().join("state.json");
    window.state_mut().ask_for_typed_path(Purpose::SaveState);
    type_path(&mut window, &path);
    assert_eq!(State::load(&path).unwrap(), state);

    let dry = occlab(folder.path())
        .args(["batch", "state.json", "--dry-run"])
        .output()
        .unwrap();
    assert!(dry.status.success(), "{}", stderr(&dry));
    let plan = String::from_utf8_lossy(&dry.stdout);
    assert!(plan.contains("srm") && plan.contains("fom"), "{plan}");

    // Two equal methods are one cell of an experiment, and two sides of the window again.
    state.methods[1] = state.methods[0].clone();
    state.save(&path).unwrap();
    window.state_mut().ask_for_typed_path(Purpose::Open);
    type_path(&mut window, &path);
    assert_eq!(window.state().state(), &state);

    // A file that cannot be read as a state changes nothing and gives a message.
    std::fs::write(&path, "{").unwrap();
    window.state_mut().ask_for_typed_path(Purpose::Open);
    type_path(&mut window, &path);
    assert!(says(&window, "state.json:1"));
    assert_eq!(window.state().state(), &state);

    let scene = folder.path().join("scene");
    window.state_mut().ask_for_typed_path(Purpose::SaveScene);
    type_path(&mut window, &scene);
    let read = State::load(&scene.with_extension("json")).unwrap();
    assert_eq!(read.scene, state.scene);
}

#[test]
fn a_picture_is_exported_and_copied_as_it_is() {
    needs_adapter!();
    let folder = tempfile::tempdir().unwrap();
    let mut window = window(tiny_state());
    settle(&mut window);
    let drawn = window.state().picture(0).unwrap().0.clone();
    for name in ["a.exr", "a.png"] {
        let path = folder.path().join(name);
        let purpose = Purpose::Export(drawn.frame.clone(), drawn.rgb.clone());
        window.state_mut().ask_for_typed_path(purpose);
        type_path(&mut window, &path);
        until(&mut window, name, |_| path.exists());
    }
    assert_eq!(
        read_frame(&folder.path().join("a.exr")).unwrap(),
        *Arc::clone(&drawn.frame)
    );
    let png = image::open(folder.path().join("a.png")).unwrap().to_rgb8();
    assert_eq!(png.into_raw(), drawn.rgb.pixels);
    assert!(read_picture(&folder.path().join("a.png")).is_ok());

    window.event(Event::Copy);
    window.step();
    let commands = &window.output().platform_output.commands;
    let copied = commands.iter().find_map(|c| match c {
        OutputCommand::CopyImage(image) => Some(image.size),
        _ => None,
    });
    assert_eq!(copied, Some([48, 27]));
}

fn remembering(file: &Path, state: Option<State>) -> App {
    let file = Some(file.to_owned());
    App::remembering(live(), "adapter".into(), state, file, Instant::now()).unwrap()
}

#[test]
fn the_window_opens_where_it_was_left() {
    needs_adapter!();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("deep/window.json");
    let mut app = remembering(&file, None);
    app.show_state(tiny_state());
    app.set_mode(Mode::Difference);
    app.remember_at_exit();
    let again = remembering(&file, None);
    assert_eq!(
        (again.state(), again.mode()),
        (&tiny_state(), Mode::Difference)
    );

    let mut other = tiny_state();
    other.scene.name = "another".into();
    let named = remembering(&file, Some(other.clone()));
    assert_eq!((named.state(), named.mode()), (&other, Mode::Difference));
    drop(named);

    // A state that was asked for and not changed is where the next window resumes.
    let shown = Some(other.clone());
    let mut window = window_of([640.0, 360.0], Theme::Dark, None, |live, name| {
        App::remembering(live, name, shown, Some(file.clone()), Instant::now()).unwrap()
    });
    settle(&mut window);
    window.state_mut().remember_at_exit();
    assert_eq!(remembering(&file, None).state(), &other);
}

#[test]
fn what_cannot_be_remembered_is_a_banner() {
    needs_adapter!();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("window.json");
    let left = |edit: fn(&mut Value)| {
        let mut value = json!({
            "mode": "split", "theme": "light", "want_truth": true,
            "experiment": tiny_state().experiment().unwrap(),
        });
        edit(&mut value);
        value.to_string()
    };
    let cases = [
        String::new(),
        "{".to_owned(),
        "[]".to_owned(),
        left(|v| v["mode"] = json!("sideways")),
        left(|v| v["experiment"]["methods"][0]["method"] = json!("bms")),
        left(|v| v["experiment"]["methods"][0]["steps"] = json!(-1)),
        left(|v| v["experiment"]["methods"][0]["stops"] = json!(1)),
        left(|v| v["experiment"]["image"]["width"] = json!(0)),
        left(|v| v["experiment"]["scenes"][0]["scene"]["medium"]["extinction_per_m"] = json!(-1)),
        left(|v| {
            v["experiment"]["scenes"][0]["scene"]["density"] =
                json!({"volume": {"path": "/nonexistent/a.npy", "up_axis": 1}});
        }),
    ];
    for case in cases {
        std::fs::write(&file, &case).unwrap();
        let app = remembering(&file, None);
        assert_eq!(app.mode(), Mode::default());
        let messages = app.messages();
        assert!(
            messages.contains("cannot be shown") && !messages.contains('\n'),
            "{case}: {messages}"
        );
        assert!(!file.exists(), "{case}");
        std::fs::remove_file(folder.path().join("window.json.unusable")).unwrap();
    }
    std::fs::write(&file, left(|_| {})).unwrap();
    let app = remembering(&file, None);
    assert_eq!((app.mode(), app.messages().as_str()), (Mode::Split, ""));
    assert!(!matches!(app.state().scene.density, Density::Volume(_)));
}

#[test]
fn a_batch_runs_in_the_window_and_pictures_come_back() {
    needs_adapter!();
    let folder = workplace(|_, e| e["sun_elevation_deg"] = json!(60));
    let mut window = window(tiny_state());
    let config = folder.path().join("small.json");
    let app = window.state_mut();
    app.start_batch(&config, folder.path()).unwrap();
    until(&mut window, "the report", |w| says(w, "Open report"));
    assert!(folder.path().join("small/index.html").exists());
    assert!(says(&window, "3 cells"));
    settle(&mut window);
    assert!(window.state().picture(0).unwrap().0.is_exact());

    window
        .get_by_role_and_label(Role::Button, "Open report")
        .click();
    window.step();
    let commands = &window.output().platform_output.commands;
    let opened = commands.iter().any(
        |c| matches!(c, OutputCommand::OpenUrl(url) if url.url.starts_with("file:///") && url.url.ends_with("/small/index.html")),
    );
    assert!(opened, "{commands:?}");
    window.key_press(Key::Escape);
    window.run_steps(3);
    assert!(!says(&window, "Open report"));
}

#[test]
fn a_cancelled_batch_says_where_its_cells_are() {
    needs_adapter!();
    let folder = workplace(|_, e| e["runs"] = json!(400));
    let mut window = window(tiny_state());
    let config = folder.path().join("small.json");
    let app = window.state_mut();
    app.start_batch(&config, folder.path()).unwrap();
    until(&mut window, "the plan", |w| {
        says(w, "Pictures in the window wait")
    });
    window.run_steps(3);
    window.get_by_role_and_label(Role::Button, "Cancel").click();
    until(&mut window, "the end", |w| says(w, "Cancelled after"));
    settle(&mut window);
}
