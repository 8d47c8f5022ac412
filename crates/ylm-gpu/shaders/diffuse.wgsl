// The radiance that leaves diffuse points: diffuse · ρ/π · Σ T_i L_i, with what bounced and what they send out.
// One invocation a point. After frame.wgsl.

// [n²], RGB and nothing.
@group(0) @binding(1) var<storage, read> light: array<vec4<f32>>;
// Blocks of n².
@group(0) @binding(2) var<storage, read> transfer: array<f32>;
// Blocks of [channel, n²].
@group(0) @binding(3) var<storage, read> bounced: array<f32>;
// [point].
@group(0) @binding(4) var<storage, read> surfaces: array<Surface>;
// [point, channel].
@group(0) @binding(5) var<storage, read_write> radiance: array<f32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let point = id.x;
    if point >= frame.point_count {
        return;
    }
    let width = frame.bands * frame.bands;
    var irradiance = vec3<f32>(0.0);
    for (var i = 0u; i < frame.used_count; i++) {
        irradiance += transfer[at(point, width, i)] * light[i].xyz;
    }
    let surface = surfaces[point];
    if frame.bounced_count > 0u {
        irradiance += surface.emitted;
    }
    for (var i = 0u; i < frame.bounced_count; i++) {
        let red = bounced[at(point, 3u * width, i)];
        let green = bounced[at(point, 3u * width, width + i)];
        let blue = bounced[at(point, 3u * width, 2u * width + i)];
        irradiance += vec3<f32>(red, green, blue) * light[i].xyz;
    }
    let leaving = frame.diffuse * surface.reflectance * irradiance + surface.emission;
    radiance[3u * point] = leaving.x;
    radiance[3u * point + 1u] = leaving.y;
    radiance[3u * point + 2u] = leaving.z;
}
