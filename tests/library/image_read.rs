//! Tests of images from other programs: PFM, Radiance pictures and EXR, and the errors of
//! unreadable ones.

mod layers; // which channels of an EXR are the image

use std::io::Cursor;
use std::path::Path;

use exr::prelude::{
    AnyChannel, AnyChannels, Compression, Encoding, FlatSamples, Image, ImageAttributes,
    IntegerBounds, Layer, LayerAttributes, WritableImage as _, f16,
};
use whitefurnace::image::read::{ChannelKind, LoadedImage, decode};

use crate::prelude::*;

fn read(bytes: &[u8], layer: Option<&str>) -> Result<LoadedImage, String> {
    decode(Path::new("a.any"), bytes, layer, "--layer").map_err(|error| error.to_string())
}

fn refused(bytes: &[u8], layer: Option<&str>, hint: &str) {
    let message = read(bytes, layer).expect_err(hint);
    assert!(
        message.starts_with("cannot read a.any: ") && message.contains(hint),
        "{hint}: {message}"
    );
    assert_eq!(message.lines().count(), 1, "{message}");
}

/// Returns a PFM of 2 × 3 pixels.
fn pfm(kind: &str, scale: &str, bytes: fn(f32) -> [u8; 4], values: &[f32]) -> Vec<u8> {
    let header = format!("{kind}\n2 3\n{scale}\n").into_bytes();
    header
        .into_iter()
        .chain(values.iter().flat_map(|&value| bytes(value)))
        .collect()
}

#[test]
fn pfm_is_read_from_the_bottom_in_both_orders() {
    let values: Vec<f32> = (0..18).map(|i| i as f32 - 0.5).collect();
    for (scale, bytes) in [
        ("-1.0", f32::to_le_bytes as fn(f32) -> [u8; 4]),
        ("1", f32::to_be_bytes),
    ] {
        let colour = read(&pfm("PF", scale, bytes, &values), None).expect("a PFM");
        assert_eq!((colour.size, colour.kind), ([2, 3], ChannelKind::Rgb));
        assert_eq!(colour.values[0], [11.5, 14.5, 5.5, 8.5, -0.5, 2.5]);
        assert_eq!(colour.values[2], [13.5, 16.5, 7.5, 10.5, 1.5, 4.5]);
        let grey = read(&pfm("Pf", scale, bytes, &values[..6]), None).expect("a PFM");
        assert_eq!(
            (grey.kind, &grey.values[0][..]),
            (ChannelKind::Grey, &[3.5, 4.5, 1.5, 2.5, -0.5, 0.5][..])
        );
    }
}

/// A scale of the wrong sign is refused where values cannot be those of an image, though all are
/// finite; values that are large in either order are read as stated.
#[test]
fn pfm_of_the_wrong_byte_order_is_refused() {
    let values = [0.25, 0.5, 1.0, 0.0, 3.0, 1e-3];
    for (scale, bytes, hint) in [
        (
            "-1",
            f32::to_be_bytes as fn(f32) -> [u8; 4],
            "write the scale 1.0",
        ),
        ("1.0", f32::to_le_bytes, "write the scale -1.0"),
    ] {
        refused(&pfm("Pf", scale, bytes, &values), None, hint);
    }
    let large = [1e20, 0.5, 1.0, 0.0, 3.0, 1e-20];
    let picture = read(&pfm("Pf", "-1", f32::to_le_bytes, &large), None).expect("a PFM");
    assert!(picture.values[0].contains(&f64::from(1e20_f32)));
}

/// Accepts lines that end as on Windows, comments, and an end of line after the pixels, also if
/// pixels have the bytes of a line end.
#[test]
fn pfm_is_read_with_other_lines() {
    // 10.0 is 0x41200000, and these begin and end with bytes of white space.
    let values = [
        f32::from_bits(0x3f80_000a),
        2.0,
        3.0,
        4.0,
        5.0,
        f32::from_bits(0x0a80_0000),
    ];
    let pixels: Vec<u8> = values
        .iter()
        .flat_map(|value| value.to_le_bytes())
        .collect();
    for header in [
        "Pf\n2 3\n-1\n",
        "Pf\r\n2 3\r\n-1.0\r\n",
        "Pf\n# made by a renderer\n2 3\n-1.000000\n",
        "Pf 2 3 -1\n",
        "Pf\n2\n3\n-1.0 \n",
        "Pf\r\n#\r\n# two\r\n2\t3\r\n-1\r\n",
    ] {
        for end in ["", "\n", "\r\n"] {
            let bytes = [header.as_bytes(), &pixels, end.as_bytes()].concat();
            let picture = read(&bytes, None).expect(header);
            let bottom: Vec<f64> = values[..2].iter().map(|&value| value.into()).collect();
            assert_eq!(
                (picture.size, &picture.values[0][4..]),
                ([2, 3], &bottom[..]),
                "{header:?} {end:?}"
            );
        }
    }
    refused(
        &[&b"Pf\n2 3\n-1\n"[..], &pixels, b"\n\n\n"].concat(),
        None,
        "27 bytes of pixels in place of 24",
    );
    refused(
        &[&b"Pf\n2 3\n-255\n"[..], &pixels].concat(),
        None,
        "the scale of the PFM is -255",
    );
    refused(b"Pf\n# without an end", None, "no header");
}

/// Returns a Radiance image with this header and these bytes.
fn radiance(header: &str, bytes: &[u8]) -> Vec<u8> {
    [format!("#?RADIANCE\n{header}").as_bytes(), bytes].concat()
}

/// A mantissa m with the exponent e is m 2^(e − 136), in flat rows and in both run-length codes.
#[test]
fn radiance_pictures_are_read() {
    let format = "# a comment\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=1.0\n\n";
    let flat = [
        128, 64, 32, 129, 255, 0, 1, 136, 9, 9, 9, 0, 128, 128, 128, 120,
    ];
    for (size, order) in [
        ("-Y 2 +X 2", [0, 1, 2, 3]),
        ("+Y 2 +X 2", [2, 3, 0, 1]),
        ("-Y 2 -X 2", [1, 0, 3, 2]),
    ] {
        let picture = read(&radiance(&format!("{format}{size}\n"), &flat), None).expect(size);
        let right = [
            [1.0, 255.0, 0.0, 1.0 / 512.0],
            [0.5, 0.0, 0.0, 1.0 / 512.0],
            [0.25, 1.0, 0.0, 1.0 / 512.0],
        ];
        let right = right.map(|plane| order.map(|i| plane[i]).to_vec());
        assert_eq!(
            (picture.size, picture.kind, &picture.values[..]),
            ([2, 2], ChannelKind::Rgb, &right[..]),
            "{size}"
        );
    }
    // Rows of eight pixels and more store each byte separately: runs of 128 + n, or n values.
    let rows = [
        &[2, 2, 0, 9][..],
        &[128 + 9, 128],
        &[4, 1, 2, 3, 4, 128 + 5, 5],
        &[128 + 8, 0, 1, 7],
        &[128 + 9, 136],
        // The older code repeats the last pixel 2 + 0 · 256 times, and the two rows differ in kind.
        &[1, 2, 3, 136, 1, 1, 1, 2, 4, 5, 6, 136, 1, 1, 1, 5],
    ];
    let bytes = radiance(&format!("{format}-Y 2 +X 9\n"), &rows.concat());
    let picture = read(&bytes, None).expect("a picture");
    let planes = [
        [[128.0; 9], [1.0, 1.0, 1.0, 4.0, 4.0, 4.0, 4.0, 4.0, 4.0]],
        [
            [1.0, 2.0, 3.0, 4.0, 5.0, 5.0, 5.0, 5.0, 5.0],
            [2.0, 2.0, 2.0, 5.0, 5.0, 5.0, 5.0, 5.0, 5.0],
        ],
        [
            [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 7.0],
            [3.0, 3.0, 3.0, 6.0, 6.0, 6.0, 6.0, 6.0, 6.0],
        ],
    ];
    assert_eq!(picture.values, planes.map(|rows| rows.concat()));
    refused(&bytes[..bytes.len() - 1], None, "truncated");
    for (header, hint) in [
        (
            "FORMAT=32-bit_rle_xyze\n\n-Y 2 +X 2\n",
            "FORMAT=32-bit_rle_xyze: write RGBE",
        ),
        ("EXPOSURE=2.5\n\n-Y 2 +X 2\n", "some programs change"),
        ("GAMMA=2.2\n\n-Y 2 +X 2\n", "some programs change"),
        ("\n+X 2 -Y 2\n", "write it row by row"),
        ("\n-Y 2 +X 99999999999999\n", "a size"),
        ("\n-Y 0 +X 2\n", "a size"),
        ("", "no header"),
    ] {
        refused(&radiance(header, &flat), None, hint);
    }
}

#[test]
fn what_is_no_image_is_refused() {
    let good = pfm("PF", "-1", f32::to_le_bytes, &[1.0; 18]);
    refused(
        &good[..good.len() - 1],
        None,
        "71 bytes of pixels in place of 72",
    );
    refused(&good, Some("a"), "no layers");
    for (bytes, hint) in [
        (&b"\x89PNG"[..], "neither EXR nor PFM"),
        (b"", "neither"),
        (b"PF", "no header"),
        (b"PF\n-2 3\n-1\n", "no header"),
        (b"PFM\n2 3\n-1\n", "no header"),
        (b"PF\n99999999999 99999999999\n-1\n", "a size"),
        (b"PF\n0 3\n-1\n", "a size"),
        (b"PF\n1 1\n-2\n", "some programs multiply"),
        (b"PF\n1 1\n0\n", "scale"),
    ] {
        refused(bytes, None, hint);
    }
    let mut values = [1.0; 18];
    values[7] = f32::NAN;
    refused(
        &pfm("PF", "-1", f32::to_le_bytes, &values),
        None,
        "pixel (0, 1), G, is NaN",
    );
    values[7] = f32::INFINITY;
    refused(
        &pfm("PF", "1", f32::to_be_bytes, &values),
        None,
        "pixel (0, 1), G, is inf",
    );
    let good = exr(&[("R", 1.0), ("G", 2.0), ("B", 3.0)], None);
    for length in [5, 40, good.len() / 2, good.len() - 1] {
        assert!(read(&good[..length], None).is_err(), "{length} bytes");
    }
}

/// Encodes an EXR of 2 × 1 pixels of 16-bit floats, from channels and the values of their first
/// pixel; the second pixel has half of each.
fn exr(channels: &[(&str, f32)], layer: Option<&str>) -> Vec<u8> {
    let channel = |&(name, value): &(&str, f32)| {
        AnyChannel::new(
            name,
            FlatSamples::F16(vec![f16::from_f32(value), f16::from_f32(value / 2.0)]),
        )
    };
    let attributes = layer.map_or_else(LayerAttributes::default, LayerAttributes::named);
    let channels = AnyChannels::sort(channels.iter().map(channel).collect());
    let mut bytes = Cursor::new(Vec::new());
    let image = Image::from_layer(Layer::new(
        (2, 1),
        attributes,
        Encoding::SMALL_LOSSLESS,
        channels,
    ));
    image.write().to_buffered(&mut bytes).expect("written");
    bytes.into_inner()
}

/// A compression that changes values is told, and the rounding of PXR24 is known.
#[test]
fn lossy_compression_is_told() {
    const FLOAT: f64 = 1e-5;
    const HALF: f64 = 1.0 / 2048.0;
    for (compression, is_half, lossy, rounding) in [
        (Compression::PIZ, false, None, FLOAT),
        (Compression::PXR24, false, None, FLOAT + 1.0 / 65_536.0),
        (Compression::PXR24, true, None, HALF),
        (Compression::B44, false, None, FLOAT),
        (Compression::B44, true, Some("B44"), HALF),
    ] {
        let values: Vec<f32> = (0..16).map(|i| (i as f32 + 1.0) / 3.0).collect();
        let samples = if is_half {
            FlatSamples::F16(values.iter().map(|value| f16::from_f32(*value)).collect())
        } else {
            FlatSamples::F32(values.clone())
        };
        let channels = AnyChannels::sort([AnyChannel::new("Y", samples)].into_iter().collect());
        let encoding = Encoding {
            compression,
            ..Encoding::SMALL_LOSSLESS
        };
        let mut bytes = Cursor::new(Vec::new());
        Image::from_layer(Layer::new(
            (4, 4),
            LayerAttributes::default(),
            encoding,
            channels,
        ))
        .write()
        .to_buffered(&mut bytes)
        .expect("written");
        let image = read(&bytes.into_inner(), None).expect("an image");
        assert_eq!((image.lossy_compression, image.rounding), (lossy, rounding));
        let worst = image.values[0].iter().zip(&values);
        let worst = worst.map(|(read, value)| (read / f64::from(*value) - 1.0).abs());
        let worst = worst.fold(0.0, f64::max);
        assert_eq!(worst > rounding, lossy.is_some(), "{compression}: {worst}");
        assert_eq!(image.describe().contains("compression"), lossy.is_some());
    }
}

#[test]
fn an_exr_that_ends_too_early_is_named_as_such() {
    let whole = exr(&[("R", 1.0), ("G", 2.0), ("B", 3.0)], None);
    for end in 8..whole.len() {
        refused(&whole[..end], None, "cut off");
    }
}

/// No file that begins like an image makes the reader panic.
#[test]
fn damaged_files_are_refused() {
    let files = [
        exr(&[("R", 1.0), ("G", 2.0), ("B", 3.0)], None),
        pfm("PF", "-1", f32::to_le_bytes, &[1.0; 18]),
        radiance(
            "\n-Y 1 +X 8\n",
            &[
                2, 2, 0, 8, 136, 1, 136, 2, 8, 1, 2, 3, 4, 5, 6, 7, 8, 136, 130,
            ],
        ),
    ];
    let damage = (0..3_usize, any::<prop::sample::Index>(), any::<u8>());
    property(
        "damaged images",
        context("").arguments(2000) as u32,
        &damage,
        |(file, at, byte)| {
            let mut bytes = files[file].clone();
            let at = at.index(bytes.len());
            bytes[at] = byte;
            // An image or an error; the test is that it returns.
            drop(read(&bytes, None));
        },
    );
}
