// Extinction along rays, with exact skipping of empty space.
//
//   σ(p) = density(p) · extinction_per_m        (m⁻¹)
//
// Cost: one density sample; counted when COUNT is defined (an untimed pipeline).
#import frame::frame
#import layer::LayerRay
#import density::{density, empty_distance}
#import container::layer_ray

#ifdef COUNT
var<private> density_samples: u32;
var<private> look_ups: u32;
var<private> fallbacks: u32;
#endif

fn extinction(p: vec3f) -> f32 {
#ifdef COUNT
    density_samples += 1u;
#endif
    return density(p) * frame.extinction_per_m;
}

// Light ray from p toward the sun; its length is d(p).
fn sun_ray(p: vec3f) -> LayerRay {
    return layer_ray(p, frame.sun_direction, 0.0, 1e30);
}

// How many equal steps, this one included, have provably zero extinction; 0 = evaluate. Never crosses a gap of the layer.
fn empty_steps(ray: LayerRay, s: f32, step_m: f32, p: vec3f) -> u32 {
    if frame.skip == 0u {
        return 0u;
    }
    var reach = empty_distance(p);
    if reach < 0.0 {
        return 0u;
    }
    if s <= ray.length_m.x {
        reach = min(reach, ray.length_m.x - s);
    }
    return 1u + u32(min(reach / step_m, 65536.0));
}
