//! Tripling coefficients against exact values and counts computed with sympy.

use ylm::Bands;
use ylm::product::gaunt::{Gaunt, sorted_triples, tripling, wigner_3j};

#[path = "../../../testdata/data.rs"]
mod data;

fn reference() -> Option<serde_json::Value> {
    let path = data::data("reference/gaunt_wigner.json")?;
    Some(serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap())
}

#[test]
fn tripling_coefficients_equal_exact_values() {
    let Some(reference) = reference() else { return };
    let list = reference["real_gaunt_bands_0_to_3_sorted"].as_array().unwrap();
    assert_eq!(list.len(), sorted_triples(4).len());
    for entry in list {
        let [i, j, k] = ["i", "j", "k"].map(|name| entry[name].as_u64().unwrap() as usize);
        let (value, exact) = (tripling(i, j, k), entry["value"].as_f64().unwrap());
        assert!((value / exact - 1.0).abs() <= 1e-14, "{i} {j} {k}: {value} against {exact}");
    }
}

#[test]
fn wigner_3j_symbols_equal_exact_values() {
    let Some(reference) = reference() else { return };
    for entry in reference["wigner_3j"].as_array().unwrap() {
        let args: Vec<isize> =
            entry["args"].as_array().unwrap().iter().map(|x| x.as_i64().unwrap() as isize).collect();
        if args[..3].iter().any(|&l| l > 31) {
            continue;
        }
        let degrees = [args[0], args[1], args[2]].map(|l| l as usize);
        let (value, exact) =
            (wigner_3j(degrees, [args[3], args[4], args[5]]), entry["value"].as_f64().unwrap());
        assert!((value - exact).abs() <= 1e-14 * exact.abs(), "{args:?}: {value} against {exact}");
    }
}

#[test]
fn no_residue_is_stored() {
    let Some(reference) = reference() else { return };
    for (order, counts) in reference["counts_by_order"].as_object().unwrap() {
        let n: usize = order.parse().unwrap();
        let gaunt = Gaunt::<f32>::new(Bands::new(n).unwrap()).unwrap();
        assert_eq!(gaunt.term_count() as u64, counts["nonzero"].as_u64().unwrap(), "{n} bands");
        let sorted = sorted_triples(n).len() as u64;
        assert_eq!(sorted, counts["nonzero_unique_sorted"].as_u64().unwrap(), "{n} bands");
    }
}
