//! `--window`: what it takes, what `auto` chooses, and the view of what is negative.

mod place;

use place::Place;
use serde_json::Value;

const LIGHT: &str = "disc?dir=1,1,1&angle=5&color=1,0.5,0.25";

fn coefficients(light: &Value) -> Vec<Vec<f64>> {
    serde_json::from_value(light["coefficients"].clone()).unwrap()
}

#[test]
fn windows_weigh_bands_by_their_formulas() {
    let place = Place::new();
    let plain = coefficients(&place.json(&format!("light {LIGHT} --bands 4")));
    type Weight = fn(f64) -> f64;
    let weights = [
        ("laplacian:0.01", (|l| 1.0 / (1.0 + 0.01 * (l * (l + 1.0)).powi(2))) as Weight),
        ("poisson:0.5", |l| 0.5f64.powf(l)),
        ("hann:4", |l| 0.5 * (1.0 + (std::f64::consts::PI * l / 4.0).cos())),
    ];
    for (window, weight) in weights {
        let damped = place.json(&format!("light {LIGHT} --bands 4 --window {window}"));
        assert_eq!(damped["window"]["asked"], "given");
        for (plain, damped) in plain.iter().zip(coefficients(&damped)) {
            for (i, (plain, damped)) in plain.iter().zip(damped).enumerate() {
                let expected = plain * weight((i as f64).sqrt().floor());
                assert!((damped - expected).abs() <= 1e-6 * plain.abs(), "{window} {i}");
            }
        }
    }
    assert_eq!(place.json(&format!("light {LIGHT}"))["window"], Value::Null);
}

#[test]
fn the_share_of_the_squared_laplacian_is_what_was_asked_for() {
    let place = Place::new();
    let squared = |light: &Value| -> f64 {
        let term =
            |i: usize, c: f64| ((i as f64).sqrt().floor() * ((i as f64).sqrt().floor() + 1.0) * c).powi(2);
        let of = |channel: &Vec<f64>| channel.iter().enumerate().map(|(i, &c)| term(i, c)).sum::<f64>();
        coefficients(light).iter().map(of).sum()
    };
    let plain = place.json(&format!("light {LIGHT} --bands 6"));
    let damped = place.json(&format!("light {LIGHT} --bands 6 --window laplacian:25%"));
    assert!((squared(&damped) / squared(&plain) - 0.25).abs() <= 1e-5);
    assert_eq!(damped["window"]["kind"], "laplacian");
}

#[test]
fn auto_leaves_the_light_nonnegative_and_says_how() {
    let place = Place::new();
    for bands in [3, 6, 12] {
        let light = place.json(&format!("light {LIGHT} --bands {bands} --window auto"));
        let radius = light["window"]["value"].as_f64().unwrap();
        assert_eq!(
            (&light["window"]["asked"], &light["window"]["kind"]),
            (&"auto".into(), &"poisson".into())
        );
        // Opposite to the light and all around, by the library's own evaluation of what the command printed.
        for channel in coefficients(&light) {
            let channel: Vec<f32> = channel.iter().map(|&c| c as f32).collect();
            assert!(ylm::window::minimum(&channel).unwrap().value >= 0.0, "{bands} bands");
        }
        let again = place.json(&format!("light {LIGHT} --bands {bands} --window poisson:{radius}"));
        assert_eq!(again["coefficients"], light["coefficients"]);
    }
    let white = place.json("light white --window auto");
    assert_eq!(white["window"], serde_json::json!({"asked": "auto", "kind": null, "value": null}));
}

#[test]
fn points_are_mended_by_less_than_the_light_is() {
    let place = Place::new();
    place.json("bake cube.obj -o cube.safetensors --bands 5 --rays 256");
    let render = |window: &str| {
        place
            .json(&format!("render cube.safetensors --light {LIGHT} -o a.png --size 32x24 --window {window}"))
    };
    let (plain, light, points) = (render("none"), render("auto"), render("auto:points"));
    let negative = |render: &Value| render["radiance"]["negative_points"].as_u64().unwrap();
    assert!(negative(&plain) > 0);
    let share = plain["radiance"]["negative_share"].as_f64().unwrap();
    assert!((share - negative(&plain) as f64 / 8.0).abs() <= 1e-12);
    assert!(plain["radiance"]["most_negative_over_mean"].as_f64().unwrap() < -1e-3, "{plain}");
    let over_mean = |render: &Value| render["radiance"]["most_negative_over_mean"].as_f64().unwrap();
    assert!(over_mean(&points) >= -1e-6 && over_mean(&light) >= -1e-6, "{points} {light}");
    let radius = |render: &Value| render["window"]["value"].as_f64().unwrap();
    assert!(radius(&points) > radius(&light), "{points} {light}");
    assert_eq!(points["window"]["asked"], "auto:points");
}

#[test]
fn points_under_a_lamp_are_mended_as_well() {
    let place = Place::new();
    place.json("bake cube.obj -o cube.safetensors --bands 5 --rays 256");
    let lamp = "sphere?pos=3,4,2&radius=0.3&intensity=50";
    let render = |window: &str| {
        place.json(&format!("render cube.safetensors --light {lamp} -o a.png --size 32x24 --window {window}"))
    };
    let (plain, points) = (render("none"), render("auto:points"));
    let over_mean = |render: &Value| render["radiance"]["most_negative_over_mean"].as_f64().unwrap();
    assert!(over_mean(&plain) < -1e-3 && over_mean(&points) >= -1e-6, "{plain} {points}");
    assert_eq!(points["window"]["kind"], "poisson");
}

#[test]
fn what_is_negative_is_shown_in_colour_on_grey() {
    let place = Place::new();
    place.json("bake cube.obj -o cube.safetensors --bands 5 --rays 256");
    let draw = |options: &str| {
        let words = format!(
            "render cube.safetensors --light {LIGHT} --shading negative -o a.png --size 320x240 {options}"
        );
        let render = place.json(&words);
        let bytes = std::fs::read(place.path("a.png")).unwrap();
        let pixels = ylm_prt::image::Image::decode_png(&bytes).unwrap().pixels;
        (render, pixels.into_iter().filter(|[r, g, b]| r - b > 0.1 && r - g > 0.05).count())
    };
    let (render, coloured) = draw("--camera 180,-20");
    assert!(coloured > 100, "{coloured}");
    assert!(render["scale"][0].as_f64().unwrap() < 0.0, "{render}");
    let (_, mended) = draw("--camera 180,-20 --window auto:points");
    assert_eq!(mended, 0);
}

#[test]
fn windows_that_are_none_are_wrong_usage() {
    let place = Place::new();
    for window in [
        "hann",
        "hann:0",
        "laplacian:-1",
        "laplacian:0%",
        "laplacian:x%",
        "poisson:1.5",
        "auto:light",
        "box:3",
    ] {
        assert!(place.failure(&format!("light white --window {window}"), 2).contains("--window"), "{window}");
    }
    assert!(place.failure("light white --window auto:points", 2).contains("ylm render"));
    place.failure("render a.safetensors --light white -o a.png --shading reference --window auto", 2);
}
