// The radiance that leaves diffuse points which nothing shadows: diffuse · ρ/π · Σ A_l L_lm Y_lm(n), and what they send out.
// One invocation a point. After frame.wgsl and zonal.wgsl; `zonal` is the clamped cosine's.

// [n²], RGB and nothing.
@group(0) @binding(3) var<storage, read> light: array<vec4<f32>>;
// [point].
@group(0) @binding(4) var<storage, read> places: array<Place>;
// [point].
@group(0) @binding(5) var<storage, read> surfaces: array<Surface>;
// [point, channel].
@group(0) @binding(6) var<storage, read_write> radiance: array<f32>;

// The same light at every point.
fn coeff(point: u32, i: u32) -> vec3<f32> {
    return light[i].xyz;
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let point = id.x;
    if point >= frame.point_count {
        return;
    }
    let irradiance = around(point, places[point].normal);
    let surface = surfaces[point];
    let leaving = frame.diffuse * surface.reflectance * irradiance + surface.emission;
    radiance[3u * point] = leaving.x;
    radiance[3u * point + 1u] = leaving.y;
    radiance[3u * point + 2u] = leaving.z;
}
