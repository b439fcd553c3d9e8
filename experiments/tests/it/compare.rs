//! Tests of `compare`: right renderers agree, faults are named, few samples are undecided, and bad
//! input is refused.

use std::path::Path;
use std::process::Output;

use whitefurnace::image::read::decode;

use crate::{case, folder, renders, run, text};

pub fn compare(folder: &Path, options: &str) -> Output {
    run(env!("CARGO_BIN_EXE_compare"), folder, options)
}

/// Asserts an exit code, and that a line of the output contains the hint.
pub fn assert_output(folder: &Path, options: &str, code: i32, hint: &str) {
    let output = compare(folder, options);
    let lines = text(&output.stdout) + &text(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{options}: {lines}");
    assert!(
        lines.contains(hint) && lines.lines().count() <= 13,
        "{hint}: {lines}"
    );
    assert!(
        code != 3 || lines.starts_with("error: ") && lines.lines().count() == 1,
        "{lines}"
    );
}

/// Asserts the output of a [`case`].
pub fn assert_case(folder: &Path, text: &str) {
    let (code, options, hint) = case(text);
    assert_output(folder, options, code, hint);
}

/// Renders images `SIDE` pixels wide, with the seeds from `first` on.
pub fn images(folder: &Path, name: &str, first: u32, options: &str) {
    for seed in first..first + 8 {
        renders(
            folder,
            &format!("--size {SIDE}x{SIDE} {options} --seed {seed} --out {name}-{seed}.exr"),
        );
    }
}

pub const SIDE: usize = 32;

/// Applies a function to the channels of images, by index of the value, and writes PFM files.
pub fn changed(folder: &Path, from: &str, to: &str, first: u32, change: fn(&[f64], usize) -> f64) {
    for seed in first..first + 8 {
        let path = folder.join(format!("{from}-{seed}.exr"));
        let picture = decode(
            &path,
            &std::fs::read(&path).expect("there"),
            None,
            "--layer",
        )
        .expect("an image");
        let mut bytes = format!("PF\n{SIDE} {SIDE}\n-1.0\n").into_bytes();
        for y in (0..SIDE).rev() {
            for x in 0..SIDE {
                let value = |plane: &Vec<f64>| change(plane, y * SIDE + x) as f32;
                bytes.extend(
                    picture
                        .values
                        .iter()
                        .flat_map(|plane| value(plane).to_le_bytes()),
                );
            }
        }
        std::fs::write(folder.join(format!("{to}-{seed}.pfm")), bytes).expect("written");
    }
}

#[test]
fn right_renderers_agree_and_faults_are_named() {
    let folder = folder("compare");
    let sobol = "--scene cornell --spp 64 --adaptive no";
    images(&folder, "a", 1, sobol);
    images(&folder, "b", 11, &format!("{sobol} --estimator light"));
    // Gamma applied twice, and a shift by half a pixel.
    changed(&folder, "a", "gamma", 1, |plane, i| {
        plane[i].powf(1.0 / 2.2)
    });
    changed(&folder, "a", "shift", 1, |plane, i| {
        0.5 * (plane[i] + plane[if i % SIDE == 0 { i } else { i - 1 }])
    });
    for case in [
        "0 --a a-*.exr --b b-*.exr --out agree => AGREE: nothing that could be judged differs",
        "1 --a gamma-*.pfm --b b-*.exr --out gamma => DIFFER: the image mean in ",
        "1 --a shift-*.pfm --b b-*.exr --tile 4 --out shift => DIFFER: the ",
        // Few samples, and one image on either side, with its standard errors.
        "2 --a a-1.exr --b b-11.exr --out one => UNDECIDED: ",
        "2 --a a-1.exr a-2.exr --b b-*.exr --out two => give three or more",
    ] {
        assert_case(&folder, case);
    }
    let read = |file: &str| std::fs::read_to_string(folder.join(file)).expect("there");
    let numbers: serde_json::Value =
        serde_json::from_str(&read("agree/compare.json")).expect("JSON");
    assert_eq!(numbers["verdict"], "agree");
    assert_eq!(numbers["kinds"][3]["places"], 3 * SIDE * SIDE);
    let page = read("agree/report.html");
    assert!(page.contains("<h1>agree</h1>") && page.matches("data:image/png").count() == 6);
    assert!(!page.contains("http"), "the page needs no other file");
    // Without its script, too, it has a row for each tile and says what was read of each side.
    assert_eq!(page.matches("<tr id=\"tile-").count(), 4);
    for side in ["A, the first", "B, the second"] {
        let read = format!("<p>{side}: 8 images; channels R, G, B as RGB; not read: ");
        assert!(page.contains(&read), "{read}");
    }
}

#[test]
fn an_albedo_one_percent_off_is_named() {
    let folder = folder("compare-albedo");
    let options = "--scene furnace-box --spp 64";
    images(&folder, "a", 1, options);
    images(&folder, "b", 11, options);
    // In a closed room of albedo ρ all radiance is E/(1 − ρ): ρ = 0.7425 instead of 0.75 gives 2.9
    // % less.
    changed(&folder, "b", "dark", 11, |plane, i| {
        plane[i] * (1.0 - 0.75) / (1.0 - 0.7425)
    });
    for case in [
        "0 --a a-*.exr --b b-*.exr --margin 2 --out agree => AGREE",
        "1 --a dark-*.pfm --b a-*.exr --out differ => DIFFER: the image mean in ",
    ] {
        assert_case(&folder, case);
    }
    let numbers = std::fs::read(folder.join("differ/compare.json")).expect("there");
    let numbers: serde_json::Value = serde_json::from_slice(&numbers).expect("JSON");
    for mean in numbers["kinds"][0]["found"].as_array().expect("channels") {
        let [low, high] = [0, 1].map(|end| mean["interval"][end].as_f64().expect("a number"));
        assert!(
            low < -0.0291 && -0.0291 < high && high < -0.01,
            "{low} to {high}"
        );
    }
}

#[test]
fn bad_input_gets_one_line_and_exit_code_three() {
    let folder = folder("compare-bad");
    for (name, size, seed) in [("a", "8x6", 1), ("b", "8x6", 2), ("wide", "9x6", 3)] {
        renders(
            &folder,
            &format!("--size {size} --spp 4 --seed {seed} --out {name}.exr"),
        );
    }
    std::fs::copy(folder.join("a.exr"), folder.join("c.exr")).expect("copied");
    let grey = |value: f32| [&b"Pf\n1 1\n-1\n"[..], &value.to_le_bytes()].concat();
    for (name, value) in [("one", 1.0), ("two", 2.0), ("nan", f32::NAN)] {
        std::fs::write(folder.join(format!("{name}.pfm")), grey(value)).expect("written");
    }
    for (name, value) in [("grey", 1.0_f32), ("grey2", 2.0)] {
        let bytes = [&b"Pf\n8 6\n-1\n"[..], &value.to_le_bytes().repeat(48)].concat();
        std::fs::write(folder.join(format!("{name}.pfm")), bytes).expect("written");
    }
    std::fs::write(folder.join("text.exr"), "no image").expect("written");
    for case in [
        "3 --a a.exr => --b",
        "3 --a a.exr --b b.exr --reference b.exr => --reference",
        "3 --a a.exr --b none-*.exr => --b none-*.exr: no such file",
        "3 --a a.exr --reference none.exr => cannot read none.exr",
        "3 --a a.exr --b wide.exr => a.exr and wide.exr differ in size or place: 8 × 6 at (0, 0), 9 × 6 at (0, 0); --common",
        "3 --a a.exr --b c.exr => a.exr and c.exr have the same bytes, one is a copy",
        "3 --a a.exr c.exr --b b.exr => a.exr and c.exr have the same bytes, one is a copy",
        "3 --a a.exr --reference c.exr => a.exr and c.exr have the same bytes, one is a copy",
        "3 --a a.exr --b ./a.exr => ./a.exr is given twice",
        "3 --a a.exr b.exr --b one.pfm two.pfm => differ in size",
        "3 --a grey.pfm grey2.pfm --b a.exr b.exr => are different images: grey as one grey channel; R, G, B as RGB",
        "3 --a one.pfm --b two.pfm => --a has one image, one.pfm, without standard errors",
        "3 --a one.pfm nan.pfm --b two.pfm => cannot read nan.pfm: pixel (0, 0), grey, is NaN",
        "3 --a a.exr --b text.exr => cannot read text.exr: neither EXR nor PFM",
        "3 --a a.exr --b b.exr --layer none => choose by --layer among: R,G,B, albedo, normal, samples, stderr",
        "3 --a a.exr --b b.exr --b-layer depth => cannot read b.exr: no layer \"depth\"",
        "3 --a a.exr --b one.pfm --layer albedo => cannot read one.pfm: a PFM or Radiance picture has no layers: leave out --layer",
        "3 --a a.exr --b b.exr --region 0,0,9,6 => --region [0, 0, 9, 6] reaches beyond",
        "3 --a a.exr --b b.exr --region 3,0,3,6 => X0 < X1",
        "3 --a a.exr --b b.exr --level 1 => from 0.000000000001 to 0.5",
        "3 --a a.exr --b b.exr --out a.exr => a.exr",
    ] {
        assert_case(&folder, case);
    }
}
