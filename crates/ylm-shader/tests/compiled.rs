//! Generated C, and HLSL by way of C++, compiled by the system's compilers and run: the values are ylm's.

mod cases;
mod native;

use std::process::Command;

use cases::cases;
use native::{Dialect, check_all};
use ylm_shader::{Language, Precision};

const C: Dialect = Dialect {
    compiler: "cc",
    flags: &["-std=c99", "-O0", "-Wall", "-Wextra", "-Werror"],
    extension: "c",
    prelude: "",
    colours: "NUMBER (*)[3]",
    has_vectors: false,
};

/// HLSL's vectors and its word for a result, as far as shaders use them; its literals become double.
const HLSL: Dialect = Dialect {
    compiler: "c++",
    flags: &["-std=c++17", "-O0", "-Wall", "-Wextra", "-Wno-unused-parameter", "-Werror"],
    extension: "cpp",
    prelude: "
#define out
struct float3 { float x, y, z; };
static inline float3 operator+(float3 a, float3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
static inline float3 operator-(float3 a, float3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
static inline float3 operator-(float3 a) { return {-a.x, -a.y, -a.z}; }
static inline float3 operator*(float a, float3 b) { return {a * b.x, a * b.y, a * b.z}; }
static inline void operator+=(float3 &a, float3 b) { a = a + b; }
static inline void operator-=(float3 &a, float3 b) { a = a - b; }
",
    colours: "float3 *",
    has_vectors: true,
};

const BANDS: &[usize] = &[1, 2, 3, 4, 6, 9, 16];

#[test]
fn compiled_c_gives_the_values_of_ylm_in_single_precision() {
    let largest = check_all(&cases(Language::C, Precision::Single, BANDS), &C);
    println!("the largest difference is {largest:e}");
}

#[test]
fn compiled_c_gives_the_values_of_ylm_in_double_precision() {
    let largest = check_all(&cases(Language::C, Precision::Double, BANDS), &C);
    println!("the largest difference is {largest:e}");
}

#[test]
fn hlsl_read_as_cpp_gives_the_values_of_ylm() {
    if Command::new(HLSL.compiler).arg("--version").output().is_err() {
        eprintln!("skipped: there is no {}", HLSL.compiler);
        return;
    }
    let largest = check_all(&cases(Language::Hlsl, Precision::Single, BANDS), &HLSL);
    println!("the largest difference is {largest:e}");
}
