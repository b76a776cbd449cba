// Sky radiance behind the clouds, kcd/m², linear sRGB: Preetham, Shirley & Smits 1999.
//
//   F(θ, γ) = (1 + A e^(B/cosθ)) (1 + C e^(Dγ) + E cos²γ),  {Y, x, y} = zenith · F(θ, γ)   (zenith already over F(0, θs))
//
// Where the ray meets the ground: the ground's radiance; from there up to the horizontal: the horizon's. Coefficients come
// from scene/preetham.rs.
// Cost: six exponentials a pixel.
#import frame::frame
#import container::ground_blocks

struct Sky {
    perez: array<vec4f, 5>,   // A…E of (Y, x, y)
    zenith: vec3f,            // (Y, x, y)
    ground: vec3f,            // radiance of the ground, RGB
}

@group(0) @binding(3) var<uniform> sky: Sky;

fn sky_radiance(direction: vec3f) -> vec3f {
    if ground_blocks(frame.camera_position_m, direction) {
        return sky.ground;
    }
    let cosine = max(direction.y, 0.01);
    let sun_cosine = clamp(dot(direction, frame.sun_direction), -1.0, 1.0);
    let gamma = acos(sun_cosine);
    let height = 1.0 + sky.perez[0].xyz * exp(sky.perez[1].xyz / cosine);
    let glow = 1.0 + sky.perez[2].xyz * exp(sky.perez[3].xyz * gamma) + sky.perez[4].xyz * sun_cosine * sun_cosine;
    let lum = sky.zenith * height * glow;
    let scale = lum.x / max(lum.z, 1e-4);
    let xyz = vec3f(lum.y * scale, lum.x, (1.0 - lum.y - lum.z) * scale);
    return max(vec3f(0.0), vec3f(
        dot(xyz, vec3f(3.2404542, -1.5371385, -0.4985314)),
        dot(xyz, vec3f(-0.9692660, 1.8760108, 0.0415560)),
        dot(xyz, vec3f(0.0556434, -0.2040259, 1.0572252))));
}
