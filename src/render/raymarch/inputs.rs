//! Uniforms of group 0, from the scene.

use crate::gpu::{Inputs, UniformValue};
use crate::scene::ImageSize;
use crate::scene::{Ambient, Camera, Container, Lobe, Scene, Sky, SkyModel};
use glam::DVec3;

/// Frame, container, sky and ambient.
pub(super) fn scene_inputs(scene: &Scene, image: ImageSize, skip: bool) -> Inputs {
    let sky = scene.sky.as_ref().map(
        |Sky::Preetham {
             turbidity,
             ground_albedo,
         }| { SkyModel::new(*turbidity, scene.sun.direction(), *ground_albedo) },
    );
    let mut inputs = Inputs::default();
    inputs.uniform("frame", frame(scene, image, skip, sky.as_ref()));
    container(&mut inputs, &scene.container);
    if let Some(sky) = &sky {
        inputs.uniform("sky", sky_members(sky));
    }
    if let Some(ambient) = &scene.ambient {
        let mean = sky.as_ref().map_or([0.0; 3], SkyModel::mean_radiance);
        let (base, top) = match ambient {
            Ambient::Uniform { radiance } => (*radiance, *radiance),
            Ambient::Sky { base, top } => (mean.map(|v| v * base), mean.map(|v| v * top)),
        };
        inputs.uniform("ambient", [("base", vector(base)), ("top", vector(top))]);
    }
    inputs
}

fn vector(v: [f64; 3]) -> UniformValue {
    UniformValue::Vec3(v.map(|x| x as f32))
}

fn number(v: f64) -> UniformValue {
    UniformValue::F32(v as f32)
}

fn frame(
    scene: &Scene,
    image: ImageSize,
    skip: bool,
    sky: Option<&SkyModel>,
) -> Vec<(&'static str, UniformValue)> {
    let Camera {
        position_m, far_m, ..
    } = &scene.camera;
    let (right, up, forward) = scene.camera.basis();
    let (half_x, half_y) = scene
        .camera
        .half_extent(f64::from(image.width) / f64::from(image.height));
    // Validation admits a missing irradiance only together with a sky.
    let derived = || sky.map_or([0.0; 3], SkyModel::sun_irradiance_klx);
    let irradiance = scene
        .sun
        .irradiance
        .unwrap_or_else(derived)
        .map(|v| v * scene.medium.sun_gain);
    let lobe = |i: usize| {
        scene.medium.phase.get(i).copied().unwrap_or(Lobe {
            g: 0.0,
            weight: 0.0,
        })
    };
    let (first, second) = (lobe(0), lobe(1));
    vec![
        ("camera_position_m", vector(*position_m)),
        ("far_m", number(far_m.unwrap_or(1e30))),
        ("camera_right", vector((right * half_x).into())),
        ("camera_up", vector((up * half_y).into())),
        ("camera_forward", vector(forward.into())),
        ("steps", UniformValue::U32(scene.march.steps)),
        ("step_m", number(scene.march.step_m.unwrap_or(0.0))),
        ("jitter", UniformValue::U32(scene.march.jitter.into())),
        ("sun_direction", vector(DVec3::into(scene.sun.direction()))),
        ("skip", UniformValue::U32(skip.into())),
        ("sun_irradiance", vector(irradiance)),
        ("extinction_per_m", number(scene.medium.extinction_per_m)),
        (
            "phase",
            UniformValue::Vec4([first.g, first.weight, second.g, second.weight].map(|v| v as f32)),
        ),
        (
            "image_size",
            UniformValue::UVec2([image.width, image.height]),
        ),
        ("albedo", number(scene.medium.albedo)),
    ]
}

fn container(inputs: &mut Inputs, container: &Container) {
    match container {
        Container::Shell {
            planet_radius_m,
            base_m,
            top_m,
        } => {
            let values = [
                ("planet_radius_m", number(*planet_radius_m)),
                ("base_m", number(*base_m)),
                ("top_m", number(*top_m)),
            ];
            inputs.uniform("container", values);
        }
        Container::Box { min_m, max_m } => inputs.uniform(
            "container",
            [("low_m", vector(*min_m)), ("high_m", vector(*max_m))],
        ),
    }
}

fn sky_members(sky: &SkyModel) -> Vec<(String, UniformValue)> {
    let mut members: Vec<_> = (0..)
        .zip(sky.perez().perez)
        .map(|(i, row)| {
            (
                format!("perez[{i}]"),
                UniformValue::Vec4(row.map(|v| v as f32)),
            )
        })
        .collect();
    members.push(("zenith".to_owned(), vector(sky.perez().zenith)));
    members.push(("ground".to_owned(), vector(sky.ground_radiance())));
    members
}
