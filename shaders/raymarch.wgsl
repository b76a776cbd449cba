// The view march: one invocation a pixel, the same for every occlusion method and for the truth.
//
//   L = Σₖ Tₖ·(1 − e^(−σₖΔ))·albedo·(p(θ)·E·V(pₖ) + ambient(pₖ)) + T·background,   Tₖ₊₁ = Tₖ e^(−σₖΔ)
//
// (σ constant over a step; Hillaire 2016 eq. 14.) INTEGRATION_THESIS replaces (1 − e^(−σΔ)) by e^(−σΔ)·σΔ: transmittance
// first, as in thesis M, Algorithm 1. V = 0 where the ray toward the sun meets the ground.
// A dispatch marches steps tile.steps.x … tile.steps.y − 1 of its pixels; between dispatches the outputs hold the sums.
// SUBSET: the tile counts blocks of pixels, and one pixel of each block is marched; reconstruction passes fill in the
// others. INVERSE_DEPTH: also stores, for those passes, the reciprocal of the weighted mean depth, weights as of V.
// Cost: `steps` density samples and, where there is medium, one light_transmittance.
#import frame::{frame, tile, camera_ray}
#import layer::{layer_length, point_at}
#import container::{layer_ray, ground_blocks}
#import medium
#import medium::{extinction, empty_steps}
#import numerics::{one_minus_exp_neg, gradient_noise, OPAQUE_TRANSMITTANCE}
#import phase::phase_function
#ifdef HAS_MAP
#import map_lookup::light_transmittance
#else
#import occlusion::light_transmittance
#endif
#ifdef SKY
#import sky::sky_radiance
#endif
#ifdef AMBIENT
#import ambient::ambient_radiance
#endif
#ifdef SUBSET
#import subset::{Subset, marched_pixel}
#endif

const MAX_STEPS: u32 = 4096u;

@group(3) @binding(0) var<storage, read_write> radiance_out: array<vec4f>; // RGB, opacity
@group(3) @binding(1) var<storage, read_write> sun_out: array<vec4f>;      // sun-lit RGB, mean V
#ifdef COUNT
@group(3) @binding(2) var<storage, read_write> counts: array<vec4u>;       // view, light samples, look-ups, fallbacks
#endif

#ifdef SUBSET
@group(3) @binding(3) var<uniform> subset: Subset;
#endif
#ifdef INVERSE_DEPTH
@group(3) @binding(4) var<storage, read_write> inverse_depth_out: array<f32>;   // along the optical axis, m⁻¹
#endif

@compute @workgroup_size(8, 8)
fn march(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= tile.size) {
        return;
    }
#ifdef SUBSET
    let pixel = marched_pixel(subset, tile.origin + id.xy);
#else
    let pixel = tile.origin + id.xy;
#endif
    if any(pixel >= frame.image_size) {
        return;
    }
    let index = pixel.y * frame.image_size.x + pixel.x;
    let direction = camera_ray(pixel);
    let ray = layer_ray(frame.camera_position_m, direction, 0.0, frame.far_m);
    let length_m = layer_length(ray);
    var steps = frame.steps;
    if frame.step_m > 0.0 {
        steps = u32(clamp(ceil(length_m / frame.step_m), 1.0, f32(MAX_STEPS)));
    }
    let delta = length_m / f32(steps);
    let noise = gradient_noise(vec2f(pixel));
    let offset = select(0.5, noise, frame.jitter == 1u);

    if tile.steps.x >= steps {
        return; // an earlier dispatch finished this ray
    }

    var transmittance = 1.0;
    var lit = 0.0;       // Σ weight·V
    var weights = 0.0;   // Σ weight
    var ambient_sum = vec3f(0.0);
    if tile.steps.x > 0u {
        ambient_sum = radiance_out[index].xyz;
        transmittance = radiance_out[index].w;
        lit = sun_out[index].x;
        weights = sun_out[index].y;
    }
#ifdef INVERSE_DEPTH
    var depth_sum_m = select(0.0, sun_out[index].z, tile.steps.x > 0u);   // Σ weight·depth
#endif
    var light_samples = 0u;
    let end = min(steps, tile.steps.y);
    var k = select(tile.steps.x, end, length_m <= 0.0);
    while k < end && transmittance >= OPAQUE_TRANSMITTANCE {
        let s = (f32(k) + offset) * delta;
        let p = point_at(ray, s);
        let empty = empty_steps(ray, s, delta, p);
        if empty > 0u {
            k += empty;
            continue;
        }
        k += 1u;
        let sigma = extinction(p);
        if sigma <= 0.0 {
            continue;
        }
        let absorbed = one_minus_exp_neg(sigma * delta);
#ifdef INTEGRATION_THESIS
        let weight = transmittance * (1.0 - absorbed) * sigma * delta;
#else
        let weight = transmittance * absorbed;
#endif
#ifdef COUNT
        let before = medium::density_samples;
#endif
        var visibility = 0.0;
        if !ground_blocks(p, frame.sun_direction) {
            visibility = light_transmittance(p, fract(noise + 0.618034 * f32(k)));
        }
#ifdef COUNT
        light_samples += medium::density_samples - before;
#endif
        lit += weight * visibility;
        weights += weight;
#ifdef INVERSE_DEPTH
        depth_sum_m += weight * dot(p - frame.camera_position_m, frame.camera_forward);
#endif
#ifdef AMBIENT
        ambient_sum += weight * ambient_radiance(p);
#endif
        transmittance *= 1.0 - absorbed;
    }

#ifdef COUNT
    let counted = vec4u(medium::density_samples - light_samples, light_samples, medium::look_ups, medium::fallbacks);
    counts[index] = select(counts[index], vec4u(0u), tile.steps.x == 0u) + counted;
#endif
    if end < steps {
        radiance_out[index] = vec4f(ambient_sum, transmittance);
        sun_out[index] = vec4f(lit, weights, 0.0, 0.0);
#ifdef INVERSE_DEPTH
        sun_out[index].z = depth_sum_m;
#endif
        return;
    }

    let cosine = dot(direction, frame.sun_direction);
    let sun = frame.sun_irradiance * (frame.albedo * phase_function(frame.phase, cosine) * lit);
    var radiance = sun + frame.albedo * ambient_sum;
#ifdef SKY
    radiance += transmittance * sky_radiance(direction);
#endif
    radiance_out[index] = vec4f(radiance, 1.0 - transmittance);
    sun_out[index] = vec4f(sun, select(0.0, lit / weights, weights > 0.0));
#ifdef INVERSE_DEPTH
    inverse_depth_out[index] = select(0.0, weights / depth_sum_m, depth_sum_m > 0.0);
#endif
}
