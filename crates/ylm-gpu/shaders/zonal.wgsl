// The convolution of a function with a zonal one, at one direction: Σ α_l f_lm Y_lm(axis), for any number of bands.
// Stands after frame.wgsl and before kernels that have `fn coeff(point: u32, i: u32) -> vec3<f32>`, the f of a point.

// How P̄_l of order m comes of the two before it, [m, l ≥ m]: a and b of a (z P̄_{l−1} − b P̄_{l−2}).
@group(0) @binding(1) var<storage, read> recurrence: array<vec2<f32>>;
// α_l, [n].
@group(0) @binding(2) var<storage, read> zonal: array<f32>;

fn around(point: u32, axis: vec3<f32>) -> vec3<f32> {
    var sum = vec3<f32>(0.0);
    // (x + iy)^m: the sine's power is in it, and not in P̄.
    var power = vec2<f32>(1.0, 0.0);
    var entry = 0u;
    for (var m = 0u; m < frame.bands; m++) {
        var before = -1.0;
        var value = 0.0;
        var cosines = vec3<f32>(0.0);
        var sines = vec3<f32>(0.0);
        for (var l = m; l < frame.bands; l++) {
            let next = recurrence[entry].x * (axis.z * value - recurrence[entry].y * before);
            before = value;
            value = next;
            entry += 1u;
            let middle = l * (l + 1u);
            cosines += zonal[l] * value * coeff(point, middle + m);
            sines += zonal[l] * value * coeff(point, middle - m);
        }
        sum += power.x * cosines + power.y * sines;
        power = vec2<f32>(power.x * axis.x - power.y * axis.y, power.x * axis.y + power.y * axis.x);
    }
    return sum;
}
