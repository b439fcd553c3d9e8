//! Tests the value of each number that `compare` and `judge` write or print, by a textbook formula
//! or in closed form; their densities and verdicts are tested elsewhere.

use std::f64::consts::{FRAC_2_PI, PI};
use std::fmt::Write as _;
use std::path::Path;

use serde_json::{Value, json};
use whitefurnace::harness::outcome::ALPHA;
use whitefurnace::harness::tails::{student_two_sided, student_upper};

use crate::{folder, run, text};

const WIDTH: usize = 8;
const HEIGHT: usize = 4;
const IMAGES: usize = 5;
/// Relative differences below this are rounding of single precision.
const ROUNDING: f64 = 1e-5;

/// Returns a pseudo-random number from 0 to 1.
fn random(seed: usize) -> f64 {
    let mixed = (seed as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let mixed = (mixed ^ (mixed >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    ((mixed ^ (mixed >> 32)) >> 11) as f64 / (1_u64 << 53) as f64
}

/// Writes the images of a side, each with its pixels from the lowest row up; the right half is
/// brighter by `right`.
fn write_side(folder: &Path, name: &str, first: usize, right: f64) -> Vec<Vec<f64>> {
    let image = |k: usize| -> Vec<f64> {
        let pixel = |i: usize| {
            let brightness = if i % WIDTH >= WIDTH / 2 {
                1.0 + right
            } else {
                1.0
            };
            f64::from((brightness + 0.1 * random(first + k * WIDTH * HEIGHT + i)) as f32)
        };
        (0..WIDTH * HEIGHT).map(pixel).collect()
    };
    let images: Vec<Vec<f64>> = (0..IMAGES).map(image).collect();
    for (k, image) in images.iter().enumerate() {
        let mut bytes = format!("Pf\n{WIDTH} {HEIGHT}\n-1.0\n").into_bytes();
        image
            .iter()
            .for_each(|value| bytes.extend((*value as f32).to_le_bytes()));
        std::fs::write(folder.join(format!("{name}-{k}.pfm")), bytes).expect("written");
    }
    images
}

/// Returns the mean of some numbers and its squared standard error.
fn mean_of(values: &[f64]) -> [f64; 2] {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    [
        mean,
        values
            .iter()
            .map(|value| (value - mean).powi(2))
            .sum::<f64>()
            / (n - 1.0)
            / n,
    ]
}

/// Welch's test of a set of pixels: means, relative difference and standard error, degrees of
/// freedom, difference in standard errors, p-value.
fn welch(sides: &[Vec<Vec<f64>>; 2], pixels: &[usize]) -> [f64; 7] {
    let of = |image: &Vec<f64>| pixels.iter().map(|&i| image[i]).sum::<f64>() / pixels.len() as f64;
    let [[a, va], [b, vb]] = sides
        .each_ref()
        .map(|side| mean_of(&side.iter().map(of).collect::<Vec<_>>()));
    // At least as many as either side has, whatever their shares of the noise.
    let dof = IMAGES as f64 - 1.0;
    let (error, scale) = ((va + vb).sqrt(), b.abs());
    let beyond = ((a - b).abs() - ROUNDING * a.max(b))
        .max(0.0)
        .copysign(a - b)
        / error;
    [
        a,
        b,
        (a - b) / scale,
        error / scale,
        dof,
        beyond,
        student_two_sided(beyond, dof),
    ]
}

/// Asserts that the number at a JSON pointer has this value, to this relative error.
fn assert_close(of: &Value, pointer: &str, expected: f64, relative: f64) {
    let found = of.pointer(pointer).and_then(Value::as_f64);
    let found = found.unwrap_or_else(|| panic!("no number {pointer}: {of}"));
    assert!(
        (found - expected).abs() <= relative * expected.abs(),
        "{pointer}: {found}, should be {expected}: {of}"
    );
}

#[test]
fn numbers_of_compare_are_those_of_the_textbook() {
    let folder = folder("numbers-compare");
    let sides = [
        write_side(&folder, "a", 0, 0.1),
        write_side(&folder, "b", 5000, 0.0),
    ];
    let output = run(
        env!("CARGO_BIN_EXE_compare"),
        &folder,
        "--a a-*.pfm --b b-*.pfm --tile 4 --level 0.002 --margin 2 --region 0,0,8,4",
    );
    let printed = text(&output.stdout);
    let numbers = std::fs::read(folder.join("out/compare/compare.json")).expect("a report");
    let numbers: Value = serde_json::from_slice(&numbers).expect("JSON");
    for (key, expected) in [
        ("level", json!(0.002)),
        ("margin", json!(0.02)),
        ("tile", json!(4)),
        ("size", json!([WIDTH, HEIGHT])),
        ("b_is_exact", json!(false)),
    ] {
        assert_eq!(numbers[key], expected, "{key}");
    }
    let all: Vec<usize> = (0..WIDTH * HEIGHT).collect();
    let half = |right: bool| -> Vec<usize> {
        all.iter()
            .copied()
            .filter(|i| (i % WIDTH >= WIDTH / 2) == right)
            .collect()
    };
    let each: Vec<f64> = all.iter().map(|&i| welch(&sides, &[i])[6]).collect();
    for (kind, places, pixels) in [
        (0, 1, vec![all.clone()]),
        (2, 2, vec![half(false), half(true)]),
        (3, 32, vec![]),
    ] {
        let found = &numbers["kinds"][kind];
        let level = 0.002 / 4.0 / f64::from(places);
        assert_close(found, "/level", level, 1e-12);
        assert_eq!(
            (&found["places"], &found["varying"]),
            (&json!(places), &json!(places))
        );
        for (i, pixels) in pixels.iter().enumerate() {
            let place = &found["found"][i];
            let [a, b, difference, error, dof, sigmas, p] = welch(&sides, pixels);
            let reach = student_upper(level / 2.0, dof) * error + ROUNDING * (a / b).max(1.0);
            for (pointer, expected, relative) in [
                ("/means/0", a, 1e-6),
                ("/means/1", b, 1e-6),
                ("/difference", difference, 1e-4),
                ("/standard_error", error, 1e-4),
                ("/dof", dof, 1e-4),
                ("/sigmas", sigmas, 1e-3),
                ("/p", p, 1e-2),
                ("/interval/0", difference - reach, 1e-6),
                ("/interval/1", difference + reach, 1e-6),
            ] {
                assert_close(place, pointer, expected, relative);
            }
        }
        let differ = found["found"].as_array().expect("places").iter();
        let enough = differ
            .filter(|place| place["judged"] == true && place["p"].as_f64().expect("p") < level);
        assert_eq!(
            found["differ"].as_u64(),
            Some(enough.count() as u64),
            "{found}"
        );
        assert_eq!(
            found["judged"].as_u64().map(|count| count > 0),
            Some(true),
            "{found}"
        );
    }
    // The right half differs; the left does not.
    assert_eq!(
        (&numbers["verdict"], &numbers["kinds"][2]["differ"]),
        (&json!("differ"), &json!(1))
    );
    let mut bins = vec![0; 20];
    each.iter()
        .for_each(|p| bins[((p * 20.0) as usize).min(19)] += 1);
    assert_eq!(numbers["pixel_p_values"], json!(bins));
    // The detectable effect is above the critical value, and less than three times it.
    let [_, _, difference, error, dof, _, p] = welch(&sides, &all);
    let critical = student_upper(0.002 / 8.0, dof) * error;
    let seen = numbers["smallest_bias"][0]["relative"]
        .as_f64()
        .expect("a bias");
    assert!(
        (critical..3.0 * critical).contains(&seen),
        "{seen} and {critical}"
    );
    // The printed numbers are the same.
    let line = printed
        .lines()
        .find(|line| line.starts_with("image mean, "))
        .expect("a line");
    assert!(
        line.contains(&format!(": {:+.2}", 100.0 * difference)),
        "{difference}: {line}"
    );
    assert!(
        line.contains(&format!("p {p:.1e}")) && line.contains("smallest detectable "),
        "{p:e}: {line}"
    );
    assert!(
        printed.contains("chance of a false alarm at most 0.002"),
        "{printed}"
    );
}

/// Directions in a corner of the quantiles: for the cosine law the squared sine of the polar angle
/// is uniform, here below one half, and the azimuth within the first quarter.
#[test]
fn numbers_of_judge_are_those_of_closed_forms() {
    const N: usize = 160_000;
    let folder = folder("numbers-judge");
    let mut rows = "x,y,z,weight,pdf\n".to_owned();
    let mut weights = Vec::new();
    for i in 0..N {
        let [u, phi] = [0.5 * random(3 * i), 0.5 * PI * random(3 * i + 1)];
        let (r, z) = (f64::sqrt(u), (1.0 - u).sqrt());
        weights.push(0.5 + 0.5 * random(3 * i + 2));
        writeln!(
            rows,
            "{},{},{z},{},{}",
            r * phi.cos(),
            r * phi.sin(),
            weights[i],
            1.02 * z / PI
        )
        .expect("text");
    }
    std::fs::write(folder.join("corner.csv"), rows).expect("written");
    let options = "--samples corner.csv --density cosine --mean-weight 0.7 --margin 10";
    let output = run(env!("CARGO_BIN_EXE_judge"), &folder, options);
    let printed = text(&output.stdout);
    assert_eq!(output.status.code(), Some(1), "{printed}");
    let numbers = std::fs::read(folder.join("out/judge/judge.json")).expect("a report");
    let numbers: Value = serde_json::from_slice(&numbers).expect("JSON");
    assert_eq!(
        (&numbers["n"], &numbers["verdict"]),
        (&json!(N), &json!("differ"))
    );
    assert_eq!(numbers["precision"]["direction"], "double precision");
    let [mean, squared] = mean_of(&weights);
    assert_close(&numbers, "/mean_weight/0", mean, 1e-12);
    assert_close(&numbers, "/mean_weight/1", squared.sqrt(), 1e-9);
    let outcomes = numbers["outcomes"].as_array().expect("outcomes");
    let random_ones = outcomes
        .iter()
        .filter(|outcome| outcome["statistic"] != "exact")
        .count();
    assert_close(&numbers, "/false_alarm", ALPHA * random_ones as f64, 1e-9);
    let outcome = |name: &str| {
        outcomes
            .iter()
            .find(|o| o["name"] == name)
            .unwrap_or_else(|| panic!("{name}"))
    };
    // Mean and variance of each function, and the expected mean.
    let of_turn = 0.5 - FRAC_2_PI * FRAC_2_PI;
    for (name, mean, variance, right) in [
        ("mean of u", 0.25, 1.0 / 48.0, 0.5),
        (
            "mean of u²",
            1.0 / 12.0,
            1.0 / 80.0 - 1.0 / 144.0,
            1.0 / 3.0,
        ),
        ("mean of cos 2πv", FRAC_2_PI, of_turn, 0.0),
        ("mean of sin 2πv", FRAC_2_PI, of_turn, 0.0),
        ("mean of cos 4πv", 0.0, 0.5, 0.0),
        ("mean of sin 4πv", FRAC_2_PI, of_turn, 0.0),
        (
            "mean of (2u − 1) cos 2πv",
            -0.5 * FRAC_2_PI,
            1.0 / 6.0 - 0.25 * FRAC_2_PI * FRAC_2_PI,
            0.0,
        ),
        (
            "mean of (2u − 1) sin 2πv",
            -0.5 * FRAC_2_PI,
            1.0 / 6.0 - 0.25 * FRAC_2_PI * FRAC_2_PI,
            0.0,
        ),
    ] {
        let found = outcome(name);
        let number = |key: &str| {
            found[key]
                .as_f64()
                .unwrap_or_else(|| panic!("{name}: {key}"))
        };
        let error = (variance / N as f64).sqrt();
        // The functions are evaluated at the centres of 32 × 64 fields.
        assert!(
            (number("estimate") - mean).abs() < 4.0 * error + 1e-3,
            "{name}: {found}, should be {mean}"
        );
        assert!(
            (number("reference") - right).abs() < 1e-3,
            "{name}: {found}"
        );
        let [low, high] = [0, 1].map(|end| found["interval"][end].as_f64().expect("a number"));
        let half = student_upper(0.5 * ALPHA, N as f64 - 1.0) * error;
        assert!(
            ((high - low) / (2.0 * half) - 1.0).abs() < 0.05,
            "{name}: {found}, half is {half}"
        );
        assert!(
            (low + high - 2.0 * number("estimate")).abs() < 1e-9,
            "{name}: {found}"
        );
        assert_close(found, "/dof", N as f64 - 1.0, 1e-9);
        let sigmas = (number("estimate") - number("reference")) / error;
        assert_close(found, "/value", sigmas, 0.1);
        assert_eq!(
            found["verdict"],
            if (mean - right).abs() > 0.05 {
                "fails"
            } else {
                "holds"
            },
            "{found}"
        );
        let estimate = format!("{:.6}", number("estimate")).replace("-0.000000", "0.000000");
        assert!(
            printed.contains(&format!("{estimate}, should be ")),
            "{estimate}: {printed}"
        );
    }
    assert_close(outcome("reported pdf"), "/estimate", 0.02, 1e-3);
    assert_close(outcome("mean weight"), "/estimate", mean, 1e-9);
    assert_close(outcome("mean weight"), "/reference", 0.7, 1e-9);
    // A quarter of the azimuths in half of the rows contain everything: eight times the
    // expectation, or nothing.
    let histogram = outcomes
        .iter()
        .find(|o| o["statistic"] == "chi-square" && o["claim"] == 0.0)
        .expect("many cells");
    // The largest deviation of a cell.
    assert_close(histogram, "/estimate", 7.0, 0.5);
    let cells: f64 = histogram["name"]
        .as_str()
        .expect("a name")
        .replace(" cells", "")
        .parse()
        .expect("a number");
    assert_close(histogram, "/dof", cells - 1.0, 0.1);
    // Σ (o − e)²/e is n (Σ o²/e/n − 1): seven times n.
    assert_close(histogram, "/value", 7.0 * N as f64, 0.15);
}
