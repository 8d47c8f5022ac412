// The light that points receive, R = L · O: the light's product matrix times every transfer vector.
// One invocation a point, for 8 rows of one channel: each number of transfer that is read serves 8 sums. After frame.wgsl.
// Workgroups: x blocks of 64 points, y blocks of 8 rows, z channels.

// [channel, row / 8, column, row % 8], rows beyond n² are 0.
@group(0) @binding(1) var<storage, read> matrix: array<vec4<f32>>;
// Blocks of n².
@group(0) @binding(2) var<storage, read> transfer: array<f32>;
// Blocks of [channel, n²].
@group(0) @binding(3) var<storage, read_write> received: array<f32>;

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let point = group.x * 64u + lane;
    let width = frame.bands * frame.bands;
    let row_blocks = (width + 7u) / 8u;
    let first = 2u * width * (group.z * row_blocks + group.y);
    var low = vec4<f32>(0.0);
    var high = vec4<f32>(0.0);
    for (var j = 0u; j < width; j++) {
        let number = transfer[at(point, width, j)];
        low += number * matrix[first + 2u * j];
        high += number * matrix[first + 2u * j + 1u];
    }
    for (var k = 0u; k < 8u; k++) {
        let row = 8u * group.y + k;
        if row < width {
            received[at(point, 3u * width, group.z * width + row)] = select(low[k % 4u], high[k % 4u], k >= 4u);
        }
    }
}
