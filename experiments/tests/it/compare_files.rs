//! Tests of `compare` on files as other programs write them: channels, windows, hints, images
//! without noise.

use std::path::Path;

use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, Vec2,
    WritableImage as _,
};
use sha2::{Digest as _, Sha256};
use whitefurnace::image::read::decode;

use crate::compare::{assert_case, assert_output};
use crate::folder;

/// Writes an EXR of 32-bit floats: position of the first pixel, width, and channels by name.
pub fn exr(path: &Path, corner: [i32; 2], width: usize, channels: &[(&str, &[f32])]) {
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
pub fn noisy(x: i32, y: i32, seed: u32) -> f32 {
    let noise = Sha256::digest(format!("{x} {y} {seed}"))[0];
    2.0 + (0.7 * x as f32).sin() + 0.1 * y as f32 + 0.0002 * f32::from(noise)
}

/// Writes such images as `name-0.exr` to `name-3.exr`, of a window of the frame, in channels of
/// these names.
pub fn windows(
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

pub const RGB: [&str; 3] = ["R", "G", "B"];

pub fn json(folder: &Path, out: &str) -> serde_json::Value {
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
    for case in [
        "0 --a vray-*.exr --b plain-*.exr --out vray => \nchannels of the first: rgb.red, rgb.green, rgb.blue as RGB\n\
         channels of the second: R, G, B as RGB\n",
        "0 --a blender-*.exr --b plain-*.exr --a-layer ViewLayer.Combined => ViewLayer.Combined.B as RGB",
        "0 --a blender-*.exr --reference plain-0.exr --b-layer R,G,B --margin 3 => channels of the second: R, G, B as RGB",
        "0 --a odd-*.exr --b plain-*.exr --a-layer c0,c1,c2 => channels of the first: c0, c1, c2 as three channels",
        "3 --a odd-*.exr --b plain-*.exr => choose one or three channels, with commas, by --a-layer among: c0, c1, c2",
        // Y is the same in both; X and Z are not.
        "0 --a xyz-0.exr xyz-1.exr xyz-2.exr --b swapped-*.exr --layer Y => channels of both: Y as luminance; not read: X, Z",
        "1 --a xyz-*.exr --b swapped-*.exr => channels of both: X, Y, Z as X, Y, Z\n",
        "3 --a xyz-*.exr --b plain-*.exr => are different images: X, Y, Z as X, Y, Z; R, G, B as RGB",
    ] {
        assert_case(&folder, case);
    }
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
    for read in ["rgb.red, rgb.green, rgb.blue as RGB", "R, G, B as RGB"] {
        assert!(page.contains(&format!("; channels {read}.</p>")), "{read}");
    }
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
    for case in [
        "3 --a away-*.exr --b whole-*.exr --common => no pixel is common to all",
        "3 --a laid-*.exr --b whole-*.exr => ; --ignore-place lays their upper left pixels on one another",
        "0 --a laid-*.exr --b whole-*.exr --ignore-place => AGREE",
        "1 --a laid-*.exr --b whole-*.exr --common => DIFFER",
        "1 --a moved-*.exr --b whole-*.exr --ignore-place => DIFFER",
        "1 --a crop-*.exr --b whole-*.exr --ignore-place --common => DIFFER",
    ] {
        assert_case(&folder, case);
    }
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
    assert_case(
        &folder,
        "1 --a right-*.exr --reference gamma-0.exr => hint: they agree when the second is decoded from gamma 2.2",
    );
}
