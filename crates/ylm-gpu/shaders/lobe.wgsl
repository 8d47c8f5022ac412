// Adds the specular radiance towards the eye: the received light convolved with the lobe, Σ α_l R_lm Y_lm(r), r the view
// direction mirrored in the normal. One invocation a point. After frame.wgsl and zonal.wgsl; `zonal` is the material's lobe.

// [point].
@group(0) @binding(3) var<storage, read> places: array<Place>;
// Blocks of [channel, n²]: what received.wgsl writes.
@group(0) @binding(4) var<storage, read> received: array<f32>;
// [point, channel].
@group(0) @binding(5) var<storage, read_write> radiance: array<f32>;

fn coeff(point: u32, i: u32) -> vec3<f32> {
    let width = frame.bands * frame.bands;
    let red = received[at(point, 3u * width, i)];
    let green = received[at(point, 3u * width, width + i)];
    let blue = received[at(point, 3u * width, 2u * width + i)];
    return vec3<f32>(red, green, blue);
}

// The direction to the eye, mirrored in the normal; at the eye itself the normal.
fn mirrored(place: Place) -> vec3<f32> {
    let offset = frame.eye - place.position;
    let squared = dot(offset, offset);
    var to_eye = place.normal;
    if squared > 0.0 {
        to_eye = offset * inverseSqrt(squared);
    }
    return 2.0 * dot(place.normal, to_eye) * place.normal - to_eye;
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let point = id.x;
    if point >= frame.point_count {
        return;
    }
    let specular = around(point, mirrored(places[point]));
    radiance[3u * point] += specular.x;
    radiance[3u * point + 1u] += specular.y;
    radiance[3u * point + 2u] += specular.z;
}
