//! Tests of the warnings of `compare` about noise that it cannot measure: shared photons, sums in
//! single precision, too few or too bright values.

use std::path::Path;

use crate::{folder, renders, run, text};

const SIDE: usize = 16;

/// Writes four images of this name; a function gives each value from the index of the image, the
/// index of the pixel, and a pseudo-random number from 0 to 1.
fn write(folder: &Path, name: &str, seed: u64, value: fn(usize, usize, f64) -> f64) {
    for image in 0..4 {
        let mut bytes = format!("Pf\n{SIDE} {SIDE}\n-1.0\n").into_bytes();
        for pixel in 0..SIDE * SIDE {
            let mixed =
                (seed + (image * SIDE * SIDE + pixel) as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            let mixed = (mixed ^ (mixed >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            let random = (mixed >> 11) as f64 / (1_u64 << 53) as f64;
            bytes.extend((value(image, pixel, random) as f32).to_le_bytes());
        }
        std::fs::write(folder.join(format!("{name}-{image}.pfm")), bytes).expect("written");
    }
}

/// Returns the output of `compare` for these sides, after asserting its exit code.
fn output_of(folder: &Path, sides: &str, code: i32) -> String {
    let output = run(env!("CARGO_BIN_EXE_compare"), folder, sides);
    let lines = text(&output.stdout) + &text(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{sides}: {lines}");
    lines
}

#[test]
fn a_single_image_whose_pixels_share_photons_is_refused() {
    let folder = folder("compare-photons");
    for estimator in ["photon", "sppm", "light-tracer", "bdpt", "mis"] {
        let options = if ["photon", "sppm"].contains(&estimator) {
            "--photons 1000"
        } else {
            ""
        };
        renders(
            &folder,
            &format!(
                "--scene cornell --size 8x8 --spp 8 --estimator {estimator} {options} --out {estimator}.exr"
            ),
        );
    }
    for estimator in ["photon", "sppm", "light-tracer", "bdpt"] {
        for sides in [
            format!("--a {estimator}.exr --b mis.exr"),
            format!("--a mis.exr --b {estimator}.exr"),
        ] {
            let lines = output_of(&folder, &sides, 3);
            assert!(
                lines.contains(&format!(
                    "of --estimator {estimator}, whose pixels share paths"
                )),
                "{lines}"
            );
        }
    }
}

#[test]
fn differences_that_single_precision_makes_are_told_from_larger_ones() {
    let folder = folder("compare-sums");
    write(&folder, "b", 1, |_, _, random| 1.0 + 1e-5 * random);
    write(&folder, "sums", 5000, |_, _, random| {
        1.0 - 4e-5 + 1e-5 * random
    });
    write(&folder, "wrong", 5000, |_, _, random| {
        1.0 - 1e-3 + 1e-5 * random
    });
    let lines = output_of(&folder, "--a sums-*.pfm --b b-*.pfm", 2);
    assert!(lines.contains("single precision"), "{lines}");
    let lines = output_of(&folder, "--a wrong-*.pfm --b b-*.pfm", 1);
    assert!(
        lines.contains("DIFFER") && !lines.contains("single precision"),
        "{lines}"
    );
}

#[test]
fn a_few_bright_values_are_warned_of() {
    let folder = folder("compare-bright");
    write(&folder, "b", 1, |_, _, random| 1.0 + 0.02 * random);
    write(&folder, "calm", 5000, |_, _, random| 1.0 + 0.02 * random);
    write(&folder, "bright", 5000, |image, pixel, random| {
        1.0 + 0.02 * random
            + if (image, pixel) == (2, 3 * SIDE + 5) {
                30.0
            } else {
                0.0
            }
    });
    assert!(!output_of(&folder, "--a calm-*.pfm --b b-*.pfm", 0).contains("warning"));
    let lines = output_of(&folder, "--a bright-*.pfm --b b-*.pfm", 2);
    // Rows of a PFM begin at the bottom.
    let place = format!("pixel (5, {}) of bright-2.pfm", SIDE - 1 - 3);
    assert!(
        lines.contains("warning: 1 of the first's values") && lines.contains(&place),
        "{lines}"
    );
    assert!(
        lines.contains("as far as these show their brightest paths"),
        "{lines}"
    );
}
