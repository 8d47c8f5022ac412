// What every kernel is given, and how numbers of points lie in memory. Stands before each kernel.

struct Frame {
    eye: vec3<f32>,
    // How much of the light is reflected in all directions.
    diffuse: f32,
    point_count: u32,
    // Of the transfer; coefficients are bands · bands.
    bands: u32,
    // The light's first coefficients that are not 0.
    used_count: u32,
    // The same for bounced light: 0 leaves it out.
    bounced_count: u32,
}

// Where a point is and which way it faces.
struct Place {
    position: vec3<f32>,
    normal: vec3<f32>,
}

// How a point reflects and shines.
struct Surface {
    // ρ/π.
    reflectance: vec3<f32>,
    // Irradiance from what the scene sends out.
    emitted: vec3<f32>,
    // Radiance that the point sends out.
    emission: vec3<f32>,
}

@group(0) @binding(0) var<uniform> frame: Frame;

// Number i of the `width` that a point has: [point / 64, width, point % 64], so that neighbours read side by side.
fn at(point: u32, width: u32, i: u32) -> u32 {
    return ((point / 64u) * width + i) * 64u + point % 64u;
}
