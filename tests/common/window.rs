//! The window's content without a window: drawn by a harness on the device that also renders its pictures.
#![allow(dead_code, reason = "each test binary uses its own part")]

use eframe::egui::{self, Rect, Shape, TextureId, accesskit::Role};
use eframe::egui_wgpu::WgpuSetupExisting;
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use occlab::gpu::Gpu;
use occlab::live::{Live, State};
use occlab::occlusion::{MethodSetup, REGISTRY};
use occlab::scene::{ImageSize, March};
use occlab::ui::App;
use std::path::Path;
use std::time::{Duration, Instant};

pub type Window = Harness<'static, App>;

/// A small uniform box: every picture takes milliseconds on a software adapter, too.
pub fn tiny_state() -> State {
    let mut scene = super::common::box_scene([0.0; 3], [1000.0; 3], 0.003);
    scene.march = March {
        steps: 16,
        ..March::default()
    };
    (scene.sun.elevation_deg, scene.sun.azimuth_deg) = (50.0, 120.0);
    scene.camera.position_m = [500.0, 800.0, -1800.0];
    State {
        scene,
        image: ImageSize {
            width: 48,
            height: 27,
        },
        methods: ["srm", "bsm"].map(|id| super::common::with_map(id, "resolution=32 steps=16", "")),
    }
}

pub fn live() -> Live {
    Live::start(Gpu::new(None).unwrap(), None, || {})
}

/// A window of `size` points over a new worker. `make` gets the worker and an adapter's name.
pub fn window_of(
    size: [f32; 2],
    theme: egui::Theme,
    shaders: Option<&Path>,
    make: impl FnOnce(Live, String) -> App,
) -> Window {
    let gpu = Gpu::new(None).unwrap();
    let setup = WgpuSetupExisting {
        instance: gpu.instance.clone(),
        adapter: gpu.adapter.clone(),
        device: gpu.device.clone(),
        queue: gpu.queue.clone(),
    };
    let adapter = gpu.info.name.clone();
    let live = Live::start(gpu, shaders.map(Into::into), || {});
    let app = make(live, adapter);
    Harness::builder()
        .with_size(size)
        .with_theme(theme)
        .with_accessibility_check(false)
        .with_render_cursor(false)
        .wgpu_setup(setup.into())
        .build_eframe(|_| app)
}

/// A window of 960 × 540 points that shows `state`.
pub fn window(state: State) -> Window {
    window_of([960.0, 540.0], egui::Theme::Dark, None, |live, adapter| {
        App::new(live, adapter, Some(state), Instant::now()).unwrap()
    })
}

/// Draws until `test` holds.
pub fn until(window: &mut Window, what: &str, test: impl Fn(&Window) -> bool) {
    let start = Instant::now();
    loop {
        window.step();
        if test(window) {
            return;
        }
        assert!(
            start.elapsed() < Duration::from_secs(90),
            "it never came: {what}"
        );
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Draws until everything that is asked for is there.
pub fn settle(window: &mut Window) {
    // The first step sends what changed.
    window.run_steps(2);
    until(window, "all pictures", |w| w.state().is_done());
    window.run_steps(2);
}

/// Where a texture is on the screen, points.
pub fn rect_of(window: &Window, texture: TextureId) -> Option<Rect> {
    fn find(shape: &Shape, texture: TextureId) -> Option<Rect> {
        match shape {
            Shape::Rect(rect) => {
                let brush = rect.brush.as_ref()?;
                (brush.fill_texture_id == texture).then_some(rect.rect)
            }
            Shape::Mesh(mesh) => (mesh.texture_id == texture).then(|| mesh.calc_bounds()),
            Shape::Vec(shapes) => shapes.iter().find_map(|s| find(s, texture)),
            _ => None,
        }
    }
    let shapes = &window.output().shapes;
    shapes
        .iter()
        .find_map(|s| find(&s.shape, texture).map(|r| r.intersect(s.clip_rect)))
}

/// Where the picture of A is.
pub fn picture_rect(window: &Window) -> Rect {
    let (_, texture) = window.state().picture(0).expect("a picture of A");
    rect_of(window, texture).expect("the picture of A is on the screen")
}

/// Rectangle of the drop-down of a method: "Method A" or "Method B".
pub fn drop_down(window: &Window, label: &str) -> Rect {
    window.get_by_role_and_label(Role::ComboBox, label).rect()
}

/// The entries of the drop-down that is open, by method id.
pub fn entries(window: &Window) -> Vec<(&'static str, Rect)> {
    let mut found = Vec::new();
    for method in REGISTRY {
        let info = method.info();
        let text = format!("{} – {}", info.id, info.title);
        let nodes = window.query_all_by_label(&text);
        let entry = nodes
            .into_iter()
            .find(|n| n.accesskit_node().role() != Role::ComboBox);
        found.extend(entry.map(|n| (info.id, n.rect())));
    }
    found
}

/// Chooses a method as a user does.
pub fn choose(window: &mut Window, label: &str, id: &str) {
    window.get_by_role_and_label(Role::ComboBox, label).click();
    window.run_steps(3);
    let entries = entries(window);
    let (_, rect) = entries
        .iter()
        .find(|(known, _)| *known == id)
        .unwrap_or_else(|| panic!("{id} is not in the drop-down: {entries:?}"));
    click(window, rect.center());
}

pub fn click(window: &mut Window, at: egui::Pos2) {
    window.event(egui::Event::PointerMoved(at));
    for pressed in [true, false] {
        window.event(egui::Event::PointerButton {
            pos: at,
            button: egui::PointerButton::Primary,
            pressed,
            modifiers: egui::Modifiers::NONE,
        });
    }
    window.step();
    window.remove_cursor();
    window.step();
}

/// Is a text on the screen that contains this?
pub fn says(window: &Window, part: &str) -> bool {
    window.query_all_by_label_contains(part).next().is_some()
}

/// Method A of a window.
pub fn method_a(window: &Window) -> &MethodSetup {
    &window.state().state().methods[0]
}
