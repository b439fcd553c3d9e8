//! Tests of `compare`: right renderers agree, faults are named, few samples are undecided, and bad
//! input is refused.

use std::path::Path;
use std::process::Output;

use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, Vec2,
    WritableImage as _,
};
use sha2::{Digest as _, Sha256};
use whitefurnace::image::read::decode;

use crate::{folder, renders, run, text};

fn compare(folder: &Path, options: &str) -> Output {
    run(env!("CARGO_BIN_EXE_compare"), folder, options)
}

/// Asserts an exit code, and that a line of the output contains the hint.
fn assert_output(folder: &Path, options: &str, code: i32, hint: &str) {
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

/// Renders images `SIDE` pixels wide, with the seeds from `first` on.
fn images(folder: &Path, name: &str, first: u32, options: &str) {
    for seed in first..first + 8 {
        renders(
            folder,
            &format!("--size {SIDE}x{SIDE} {options} --seed {seed} --out {name}-{seed}.exr"),
        );
    }
}

const SIDE: usize = 32;

/// Applies a function to the channels of images, by index of the value, and writes PFM files.
fn changed(folder: &Path, from: &str, to: &str, first: u32, change: fn(&[f64], usize) -> f64) {
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
    assert_output(
        &folder,
        "--a a-*.exr --b b-*.exr --out agree",
        0,
        "AGREE: nothing that could be judged differs",
    );
    let read = |file: &str| std::fs::read_to_string(folder.join(file)).expect("there");
    let numbers: serde_json::Value =
        serde_json::from_str(&read("agree/compare.json")).expect("JSON");
    assert_eq!(numbers["verdict"], "agree");
    assert_eq!(numbers["kinds"][3]["places"], 3 * SIDE * SIDE);
    let page = read("agree/report.html");
    assert!(page.contains("<h1>agree</h1>") && page.matches("data:image/png").count() == 6);
    assert!(!page.contains("http"), "the page needs no other file");
    // Gamma applied twice, and a shift by half a pixel.
    changed(&folder, "a", "gamma", 1, |plane, i| {
        plane[i].powf(1.0 / 2.2)
    });
    assert_output(
        &folder,
        "--a gamma-*.pfm --b b-*.exr --out gamma",
        1,
        "DIFFER: the image mean in ",
    );
    changed(&folder, "a", "shift", 1, |plane, i| {
        0.5 * (plane[i] + plane[if i % SIDE == 0 { i } else { i - 1 }])
    });
    assert_output(
        &folder,
        "--a shift-*.pfm --b b-*.exr --tile 4 --out shift",
        1,
        "DIFFER: the ",
    );
    // Few samples, and one image on either side, with its standard errors.
    assert_output(
        &folder,
        "--a a-1.exr --b b-11.exr --out one",
        2,
        "UNDECIDED: ",
    );
    assert_output(
        &folder,
        "--a a-1.exr a-2.exr --b b-*.exr --out two",
        2,
        "give three or more",
    );
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
    assert_output(
        &folder,
        "--a a-*.exr --b b-*.exr --margin 2 --out agree",
        0,
        "AGREE",
    );
    assert_output(
        &folder,
        "--a dark-*.pfm --b a-*.exr --out differ",
        1,
        "DIFFER: the image mean in ",
    );
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
    for (options, hint) in [
        ("--a a.exr", "--b"),
        ("--a a.exr --b b.exr --reference b.exr", "--reference"),
        ("--a a.exr --b none-*.exr", "--b none-*.exr: no such file"),
        ("--a a.exr --reference none.exr", "cannot read none.exr"),
        (
            "--a a.exr --b wide.exr",
            "a.exr and wide.exr differ in size or place: 8 × 6 at (0, 0), 9 × 6 at (0, 0); --common",
        ),
        (
            "--a a.exr --b c.exr",
            "a.exr and c.exr have the same bytes, one is a copy",
        ),
        (
            "--a a.exr c.exr --b b.exr",
            "a.exr and c.exr have the same bytes, one is a copy",
        ),
        (
            "--a a.exr --reference c.exr",
            "a.exr and c.exr have the same bytes, one is a copy",
        ),
        ("--a a.exr --b ./a.exr", "./a.exr is given twice"),
        ("--a a.exr b.exr --b one.pfm two.pfm", "differ in size"),
        (
            "--a grey.pfm grey2.pfm --b a.exr b.exr",
            "are different images: grey as one grey channel; R, G, B as RGB",
        ),
        (
            "--a one.pfm --b two.pfm",
            "--a has one image, one.pfm, without standard errors",
        ),
        (
            "--a one.pfm nan.pfm --b two.pfm",
            "cannot read nan.pfm: pixel (0, 0), grey, is NaN",
        ),
        (
            "--a a.exr --b text.exr",
            "cannot read text.exr: neither EXR nor PFM",
        ),
        (
            "--a a.exr --b b.exr --layer none",
            "choose by --layer among: R,G,B, albedo, normal, samples, stderr",
        ),
        (
            "--a a.exr --b b.exr --b-layer depth",
            "cannot read b.exr: no layer \"depth\"",
        ),
        (
            "--a a.exr --b one.pfm --layer albedo",
            "cannot read one.pfm: a PFM or Radiance picture has no layers: leave out --layer",
        ),
        (
            "--a a.exr --b b.exr --region 0,0,9,6",
            "--region [0, 0, 9, 6] reaches beyond",
        ),
        ("--a a.exr --b b.exr --region 3,0,3,6", "X0 < X1"),
        (
            "--a a.exr --b b.exr --level 1",
            "from 0.000000000001 to 0.5",
        ),
        ("--a a.exr --b b.exr --out a.exr", "a.exr"),
    ] {
        assert_output(&folder, options, 3, hint);
    }
}

/// Writes an EXR of 32-bit floats: position of the first pixel, width, and channels by name.
fn exr(path: &Path, corner: [i32; 2], width: usize, channels: &[(&str, &[f32])]) {
    let channel =
        |&(name, values): &(&str, &[f32])| AnyChannel::new(name, FlatSamples::F32(values.to_vec()));
    let height = channels[0].1.len() / width;
    let attributes = LayerAttributes {
        layer_position: Vec2(corner[0], corner[1]),
        ..LayerAttributes::default()
    };
    let channels = AnyChannels::sort(channels.iter().map(channel).collect());
    let layer = Layer::new(
        (width, height),
        attributes,
        Encoding::SMALL_LOSSLESS,
        channels,
    );
    Image::from_layer(layer)
        .write()
        .to_file(path)
        .expect("written");
}

/// Returns a value that is unique to the pixel, with noise that differs between seeds.
fn noisy(x: i32, y: i32, seed: u32) -> f32 {
    let noise = Sha256::digest(format!("{x} {y} {seed}"))[0];
    2.0 + (0.7 * x as f32).sin() + 0.1 * y as f32 + 0.0002 * f32::from(noise)
}

/// Writes such images as `name-0.exr` to `name-3.exr`, of a window of the frame, in channels of
/// these names.
fn windows(
    folder: &Path,
    name: &str,
    first: u32,
    [left, top, width, height]: [i32; 4],
    names: [&str; 3],
) {
    for seed in 0..4 {
        let pixel = |i: i32| noisy(left + i % width, top + i / width, first + seed);
        let [red, green, blue] = [1.0, 2.0, 3.0].map(|c| {
            (0..width * height)
                .map(|i| c * pixel(i))
                .collect::<Vec<f32>>()
        });
        let channels = [(names[0], &red[..]), (names[1], &green), (names[2], &blue)];
        exr(
            &folder.join(format!("{name}-{seed}.exr")),
            [left, top],
            width as usize,
            &channels,
        );
    }
}

const RGB: [&str; 3] = ["R", "G", "B"];

fn json(folder: &Path, out: &str) -> serde_json::Value {
    let numbers = std::fs::read(folder.join(out).join("compare.json")).expect("there");
    serde_json::from_slice(&numbers).expect("JSON")
}

/// The output says which channels were read on each side and how they were interpreted; X, Y and Z
/// are three channels.
#[test]
fn what_was_read_is_told() {
    let folder = folder("compare-layers");
    let frame = [0, 0, 32, 24];
    let programs = [
        ("plain", RGB),
        ("vray", ["rgb.red", "rgb.green", "rgb.blue"]),
        (
            "blender",
            [
                "ViewLayer.Combined.R",
                "ViewLayer.Combined.G",
                "ViewLayer.Combined.B",
            ],
        ),
        ("xyz", ["X", "Y", "Z"]),
        ("swapped", ["Z", "Y", "X"]),
        ("odd", ["c0", "c1", "c2"]),
    ];
    for (i, (name, names)) in programs.into_iter().enumerate() {
        windows(&folder, name, 10 * i as u32, frame, names);
    }
    let agree = |options: &str, line: &str| assert_output(&folder, options, 0, line);
    agree(
        "--a vray-*.exr --b plain-*.exr --out vray",
        "\nchannels of the first: rgb.red, rgb.green, rgb.blue as RGB\nchannels of the second: R, G, B as RGB\n",
    );
    let numbers = json(&folder, "vray");
    assert_eq!(
        numbers["a"][0]["read"],
        "rgb.red, rgb.green, rgb.blue as RGB"
    );
    assert_eq!(
        numbers["b"][3]["channels"],
        serde_json::json!(["R", "G", "B"])
    );
    let page = std::fs::read_to_string(folder.join("vray/report.html")).expect("there");
    assert!(page.contains("channels of the first: rgb.red, rgb.green, rgb.blue as RGB."));
    agree(
        "--a blender-*.exr --b plain-*.exr --a-layer ViewLayer.Combined",
        "ViewLayer.Combined.B as RGB",
    );
    agree(
        "--a blender-*.exr --reference plain-0.exr --b-layer R,G,B --margin 3",
        "channels of the second: R, G, B as RGB",
    );
    agree(
        "--a odd-*.exr --b plain-*.exr --a-layer c0,c1,c2",
        "channels of the first: c0, c1, c2 as three channels",
    );
    assert_output(
        &folder,
        "--a odd-*.exr --b plain-*.exr",
        3,
        "choose one or three channels, with commas, by --a-layer among: c0, c1, c2",
    );
    // Y is the same in both; X and Z are not.
    agree(
        "--a xyz-0.exr xyz-1.exr xyz-2.exr --b swapped-*.exr --layer Y",
        "channels of both: Y as luminance; not read: X, Z",
    );
    assert_output(
        &folder,
        "--a xyz-*.exr --b swapped-*.exr",
        1,
        "channels of both: X, Y, Z as X, Y, Z\n",
    );
    assert_output(
        &folder,
        "--a xyz-*.exr --b plain-*.exr",
        3,
        "are different images: X, Y, Z as X, Y, Z; R, G, B as RGB",
    );
}

/// On request, the part of the frame that all images share is compared.
#[test]
fn the_common_part_is_compared() {
    let folder = folder("compare-common");
    for (name, first, window) in [
        ("whole", 0, [0, 0, 32, 24]),
        ("overscan", 10, [-4, -4, 40, 32]),
        ("crop", 20, [8, 6, 16, 12]),
        ("moved", 30, [5, 7, 32, 24]),
        ("away", 40, [32, 0, 32, 24]),
    ] {
        windows(&folder, name, first, window, RGB);
    }
    for (name, frame, common) in [
        ("overscan", "40 × 32 at (-4, -4)", "32 × 24 at (0, 0)"),
        ("crop", "16 × 12 at (8, 6)", "16 × 12 at (8, 6)"),
        ("moved", "32 × 24 at (5, 7)", "27 × 17 at (5, 7)"),
    ] {
        let options = format!("--a {name}-*.exr --b whole-*.exr --out {name}");
        assert_output(
            &folder,
            &options,
            3,
            &format!(
                "{frame}, 32 × 24 at (0, 0); --common judges the part that all have, {common}"
            ),
        );
        assert_output(&folder, &format!("{options} --common"), 0, "AGREE");
        let size: Vec<String> = json(&folder, name)["size"]
            .as_array()
            .expect("two")
            .iter()
            .map(ToString::to_string)
            .collect();
        assert!(common.starts_with(&size.join(" × ")), "{size:?}");
    }
    assert_output(
        &folder,
        "--a away-*.exr --b whole-*.exr --common",
        3,
        "no pixel is common to all",
    );
    // The whole frame, which the file places elsewhere; and a part that does lie there.
    windows(&folder, "laid", 50, [0, 0, 32, 24], RGB);
    for seed in 0..4 {
        let path = folder.join(format!("laid-{seed}.exr"));
        let picture =
            decode(&path, &std::fs::read(&path).expect("there"), None, "").expect("an image");
        let planes = picture
            .values
            .iter()
            .map(|plane| plane.iter().map(|&value| value as f32).collect());
        let [red, green, blue] = planes
            .collect::<Vec<Vec<f32>>>()
            .try_into()
            .expect("three channels");
        exr(
            &path,
            [5, 7],
            32,
            &[("R", &red), ("G", &green), ("B", &blue)],
        );
    }
    assert_output(
        &folder,
        "--a laid-*.exr --b whole-*.exr",
        3,
        "; --ignore-place lays their upper left pixels on one another",
    );
    assert_output(
        &folder,
        "--a laid-*.exr --b whole-*.exr --ignore-place",
        0,
        "AGREE",
    );
    assert_output(
        &folder,
        "--a laid-*.exr --b whole-*.exr --common",
        1,
        "DIFFER",
    );
    assert_output(
        &folder,
        "--a moved-*.exr --b whole-*.exr --ignore-place",
        1,
        "DIFFER",
    );
    assert_output(
        &folder,
        "--a crop-*.exr --b whole-*.exr --ignore-place --common",
        1,
        "DIFFER",
    );
}

/// A change that makes the sides agree is printed with the verdict that they differ.
#[test]
fn a_hint_tells_what_makes_them_agree() {
    type Change = fn(i32, i32, u32) -> [f32; 3];
    let folder = folder("compare-hint");
    let write = |name: &str, first: u32, change: Change| {
        for seed in 0..4 {
            let pixels: Vec<[f32; 3]> = (0..24 * 24)
                .map(|i| change(i % 24, i / 24, first + seed))
                .collect();
            let [red, green, blue] =
                [0, 1, 2].map(|c| pixels.iter().map(|pixel| pixel[c]).collect::<Vec<f32>>());
            exr(
                &folder.join(format!("{name}-{seed}.exr")),
                [0, 0],
                24,
                &[("R", &red), ("G", &green), ("B", &blue)],
            );
        }
    };
    fn plain(x: i32, y: i32, seed: u32) -> [f32; 3] {
        [1.0, 2.0, 3.0].map(|factor| factor * noisy(x, y, seed))
    }
    fn mean(one: [f32; 3], other: [f32; 3]) -> [f32; 3] {
        [0, 1, 2].map(|c| 0.5 * (one[c] + other[c]))
    }
    write("right", 0, plain);
    let changes: [(&str, Change, &str); 12] = [
        (
            "flipped",
            |x, y, s| plain(x, 23 - y, s),
            "they agree when the first is flipped upside down",
        ),
        (
            "mirrored",
            |x, y, s| plain(23 - x, y, s),
            "they agree when the first is mirrored left to right",
        ),
        (
            "turned",
            |x, y, s| plain(23 - x, 23 - y, s),
            "they agree when the first is turned by half a turn",
        ),
        (
            "columns",
            |x, y, s| plain(y, x, s),
            "they agree when rows and columns of the first are exchanged",
        ),
        (
            "moved",
            |x, y, s| plain(x - 1, y, s),
            "they agree when the first is moved by one pixel to the left",
        ),
        (
            "corner",
            |x, y, s| plain(x + 1, y + 1, s),
            "they agree when the first is moved by one pixel to the right and one pixel down",
        ),
        (
            "half",
            |x, y, s| mean(plain(x, y, s), plain(x + 1, y, s)),
            "they agree when the first is moved by half a pixel to the right",
        ),
        (
            "bgr",
            |x, y, s| {
                let [r, g, b] = plain(x, y, s);
                [b, g, r]
            },
            "they agree when red and blue of the first are swapped",
        ),
        (
            "exposure",
            |x, y, s| plain(x, y, s).map(|v| 0.25 * v),
            "they agree when the first is multiplied by ",
        ),
        (
            "gamma",
            |x, y, s| plain(x, y, s).map(|v| v.powf(1.0 / 2.2)),
            "they agree when the first is decoded from gamma 2.2",
        ),
        (
            "slip",
            |x, y, s| plain(x, y, s).map(|v| if x < 12 { 1.1 * v } else { v }),
            "DIFFER",
        ),
        ("same", |x, y, s| plain(x, y, s), "AGREE"),
    ];
    for (i, (name, change, hint)) in changes.into_iter().enumerate() {
        write(name, 10 * (i as u32 + 1), change);
        let options = format!("--a {name}-*.exr --b right-*.exr --out {name}");
        let hinted = name != "slip" && name != "same";
        assert_output(
            &folder,
            &options,
            i32::from(name != "same"),
            &format!("{}{hint}", if hinted { "\nhint: " } else { "" }),
        );
        assert_eq!(json(&folder, name)["hint"].is_string(), hinted, "{name}");
    }
    assert_output(
        &folder,
        "--a right-*.exr --reference gamma-0.exr",
        1,
        "hint: they agree when the second is decoded from gamma 2.2",
    );
}

/// Images without noise are compared exactly; copies of noisy ones are refused.
#[test]
fn images_without_noise_are_compared_as_they_stand() {
    let folder = folder("compare-noiseless");
    let scene = "background = 1\ncamera = { eye = [0, -4, 0], target = [0, 0, 0], up = [0, 0, 1], fov_deg = 40 }\n\
                 materials.ball = { model = \"lambert\", albedo = 1 }\n\
                 objects = [{ shape = \"sphere\", material = \"ball\", centre = [0, 0, 0], radius = 1 }]\n";
    std::fs::write(folder.join("furnace.toml"), scene).expect("written");
    std::fs::write(
        folder.join("darker.toml"),
        scene.replace("background = 1", "background = 0.99"),
    )
    .expect("written");
    for (name, scene, seed) in [
        ("f-1", "furnace", 1),
        ("f-2", "furnace", 2),
        ("g-1", "furnace", 3),
        ("g-2", "furnace", 4),
        ("d-1", "darker", 5),
        ("d-2", "darker", 6),
    ] {
        renders(
            &folder,
            &format!("--scene {scene}.toml --size 16x12 --spp 8 --seed {seed} --out {name}.exr"),
        );
    }
    let agree = "AGREE: neither side has noise, and no value differs by more than rounding";
    let differ =
        "DIFFER: the image mean in red is −1.00 % off the second's (and neither side has noise)";
    for (options, code, line) in [
        ("--a f-1.exr --b g-1.exr", 0, agree),
        ("--a f-*.exr --b g-*.exr", 0, agree),
        ("--a f-*.exr --reference g-1.exr", 0, agree),
        ("--a f-1.exr --b g-*.exr", 0, agree),
        ("--a d-1.exr --b g-1.exr", 1, differ),
        ("--a d-*.exr --b g-*.exr", 1, differ),
        ("--a d-1.exr --reference g-1.exr", 1, differ),
    ] {
        assert_output(&folder, options, code, line);
    }
    // Also without standard errors.
    let plain = |name: &str, value: f32| {
        let bytes = [
            &b"PF\n16 16\n-1\n"[..],
            &value.to_le_bytes().repeat(3 * 256),
        ]
        .concat();
        std::fs::write(folder.join(format!("{name}.pfm")), bytes).expect("written");
    };
    for (name, value) in [
        ("one", 1.0),
        ("other", 1.0),
        ("dark", 0.99),
        ("black", 0.0),
        ("night", 0.0),
    ] {
        plain(name, value);
    }
    assert_output(
        &folder,
        "--a one.pfm --b other.pfm",
        0,
        "\nnote: one.pfm and other.pfm have the same bytes: renders without noise, or one a copy",
    );
    assert_output(&folder, "--a dark.pfm --b one.pfm other.pfm", 1, differ);
    assert_output(&folder, "--a dark.pfm --reference one.pfm", 1, differ);
    assert_output(
        &folder,
        "--a dark.pfm --reference one.pfm",
        1,
        "\nhint: they agree when the first is multiplied by 1.01010\n",
    );
    assert_output(
        &folder,
        "--a black.pfm night.pfm --b one.pfm other.pfm",
        1,
        "DIFFER: the image mean in red is −100.0 % off",
    );
    assert_output(
        &folder,
        "--a black.pfm --b night.pfm",
        0,
        "differs by more than rounding: all are black",
    );
    // One channel without noise next to two with noise.
    let half = |name: &str, seed: u32, red: f32| {
        let plane: Vec<f32> = (0..256).map(|i| noisy(i % 16, i / 16, seed)).collect();
        exr(
            &folder.join(name),
            [0, 0],
            16,
            &[("R", &[red; 256]), ("G", &plane), ("B", &plane)],
        );
    };
    for seed in 0..4 {
        half(&format!("half-{seed}.exr"), seed, 1.0);
        half(&format!("alike-{seed}.exr"), seed + 10, 1.0);
        half(&format!("off-{seed}.exr"), seed + 20, 0.998);
    }
    assert_output(
        &folder,
        "--a half-*.exr --b alike-*.exr",
        0,
        "AGREE: nothing that could be judged differs",
    );
    assert_output(
        &folder,
        "--a off-*.exr --b alike-*.exr",
        1,
        "DIFFER: the image mean in red is −0.200 % off",
    );
    // A seed used twice: with other bytes, on one side or both.
    let plane: Vec<f32> = (0..256).map(|i| noisy(i % 16, i / 16, 1)).collect();
    let channels = [
        ("R", &[1.0; 256][..]),
        ("G", &plane),
        ("B", &plane),
        ("A", &[1.0; 256]),
    ];
    exr(&folder.join("again.exr"), [0, 0], 16, &channels);
    assert_output(
        &folder,
        "--a half-*.exr again.exr --b alike-*.exr",
        3,
        "half-1.exr and again.exr have the same pixels, a seed used twice",
    );
    assert_output(
        &folder,
        "--a half-*.exr --b alike-*.exr again.exr",
        3,
        "half-1.exr and again.exr have the same pixels, a seed used twice",
    );
    // Rare events: all is black except one pixel of one image.
    let rare = |name: &str, at: Option<usize>| {
        let mut plane = [0.0_f32; 256];
        at.into_iter().for_each(|at| plane[at] = 300.0);
        exr(
            &folder.join(name),
            [0, 0],
            16,
            &[("R", &plane), ("G", &plane), ("B", &plane)],
        );
    };
    for (i, at) in [None, None, Some(77), None].into_iter().enumerate() {
        rare(&format!("rare-{i}.exr"), at);
        rare(&format!("none-{i}.exr"), None);
    }
    assert_output(&folder, "--a rare-*.exr --b none-*.exr", 2, "UNDECIDED");
    rare("rare-4.exr", Some(77));
    assert_output(
        &folder,
        "--a rare-*.exr --b none-*.exr",
        3,
        "rare-2.exr and rare-4.exr have the same bytes, one is a copy",
    );
}
