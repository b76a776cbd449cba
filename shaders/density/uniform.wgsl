// Density: one value everywhere in the container. For analytic checks. Cost: a uniform load.

struct Field {
    value: f32,
}

@group(1) @binding(2) var<uniform> field: Field;

fn density(p: vec3f) -> f32 {
    return field.value;
}

fn empty_distance(p: vec3f) -> f32 {
    return -1.0;
}
