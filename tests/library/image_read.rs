//! Images of other programs: what is read of them, and what is said of those that cannot be read.

use std::io::Cursor;
use std::path::Path;

use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, WritableImage as _, f16,
};
use whitefurnace::image::read::{Picture, decode};

use crate::prelude::*;

fn read(bytes: &[u8], layer: Option<&str>) -> Result<Picture, String> {
    decode(Path::new("a.any"), bytes, layer).map_err(|error| error.to_string())
}

fn refused(bytes: &[u8], layer: Option<&str>, hint: &str) {
    let message = read(bytes, layer).expect_err(hint);
    assert!(message.starts_with("cannot read a.any: ") && message.contains(hint), "{hint}: {message}");
    assert_eq!(message.lines().count(), 1, "{message}");
}

/// A PFM of 2 × 3 pixels.
fn pfm(kind: &str, scale: &str, bytes: fn(f32) -> [u8; 4], values: &[f32]) -> Vec<u8> {
    let header = format!("{kind}\n2 3\n{scale}\n").into_bytes();
    header.into_iter().chain(values.iter().flat_map(|&value| bytes(value))).collect()
}

#[test]
fn pfm_is_read_from_the_bottom_in_both_orders() {
    let values: Vec<f32> = (0..18).map(|i| i as f32 - 0.5).collect();
    for (scale, bytes) in [("-1.0", f32::to_le_bytes as fn(f32) -> [u8; 4]), ("1", f32::to_be_bytes)] {
        let colour = read(&pfm("PF", scale, bytes, &values), None).expect("a PFM");
        assert_eq!((colour.size, &colour.channels[..]), ([2, 3], &["R", "G", "B"][..]));
        assert_eq!(colour.values[0], [11.5, 14.5, 5.5, 8.5, -0.5, 2.5]);
        assert_eq!(colour.values[2], [13.5, 16.5, 7.5, 10.5, 1.5, 4.5]);
        let grey = read(&pfm("Pf", scale, bytes, &values[..6]), None).expect("a PFM");
        assert_eq!((&grey.channels[..], &grey.values[0][..]), (&["Y"][..], &[3.5, 4.5, 1.5, 2.5, -0.5, 0.5][..]));
    }
}

#[test]
fn what_is_no_image_is_refused() {
    let good = pfm("PF", "-1", f32::to_le_bytes, &[1.0; 18]);
    refused(&good[..good.len() - 1], None, "71 bytes of pixels in place of 72");
    refused(&good, Some("a"), "no layers");
    for (bytes, hint) in [
        (&b"\x89PNG"[..], "neither EXR nor PFM"),
        (b"", "neither"),
        (b"PF", "no header"),
        (b"PF\n-2 3\n-1\n", "no header"),
        (b"PFM\n2 3\n-1\n", "no header"),
        (b"PF\n99999999999 99999999999\n-1\n", "a size"),
        (b"PF\n0 3\n-1\n", "a size"),
        (b"PF\n1 1\n-2\n", "scale"),
    ] {
        refused(bytes, None, hint);
    }
    let mut values = [1.0; 18];
    values[7] = f32::NAN;
    refused(&pfm("PF", "-1", f32::to_le_bytes, &values), None, "pixel (0, 1), G, is NaN");
    values[7] = f32::INFINITY;
    refused(&pfm("PF", "1", f32::to_be_bytes, &values), None, "pixel (0, 1), G, is inf");
    let good = exr(&[("R", 1.0), ("G", 2.0), ("B", 3.0)], None);
    for length in [5, 40, good.len() / 2, good.len() - 1] {
        assert!(read(&good[..length], None).is_err(), "{length} bytes");
    }
}

/// An EXR of 2 × 1 pixels of 16-bit floats: channels and their first value, of which the second is the half.
fn exr(channels: &[(&str, f32)], layer: Option<&str>) -> Vec<u8> {
    let channel = |&(name, value): &(&str, f32)| {
        AnyChannel::new(name, FlatSamples::F16(vec![f16::from_f32(value), f16::from_f32(value / 2.0)]))
    };
    let attributes = layer.map_or_else(LayerAttributes::default, LayerAttributes::named);
    let channels = AnyChannels::sort(channels.iter().map(channel).collect());
    let mut bytes = Cursor::new(Vec::new());
    let image = Image::from_layer(Layer::new((2, 1), attributes, Encoding::SMALL_LOSSLESS, channels));
    image.write().to_buffered(&mut bytes).expect("written");
    bytes.into_inner()
}

#[test]
fn layers_are_found_by_their_names() {
    let layered = exr(
        &[
            ("view.r", 1.0),
            ("view.g", 2.0),
            ("view.b", 3.0),
            ("view.a", 4.0),
            ("far.R", 5.0),
            ("far.G", 6.0),
            ("far.B", 7.0),
            // Names are in order, and groups not in one piece.
            ("far.C.x", 8.0),
            ("far.Z", 9.0),
        ],
        None,
    );
    refused(&layered, None, "--layer among: far, far.C, view");
    assert_eq!(read(&layered, Some("far")).expect("a layer").values[0], [5.0, 2.5]);
    refused(&layered, Some("near"), "no layer \"near\"");
    let picture = read(&layered, Some("view")).expect("a layer");
    assert_eq!(picture.values, [[1.0, 0.5], [2.0, 1.0], [3.0, 1.5]]);
    assert_eq!((picture.size, picture.rounding), ([2, 1], 1.0 / 2048.0));
    let beside =
        exr(&[("R", 1.0), ("G", 2.0), ("B", 3.0), ("A", 1.0), ("far.R", 5.0), ("far.G", 6.0), ("far.B", 7.0)], None);
    assert_eq!(read(&beside, None).expect("the unnamed").values[0], [1.0, 0.5]);
    // The name of the part is the layer's, too; standard errors belong to it.
    let errors = [("Y", 1.0), ("stderr.Y", 0.25)];
    let part = exr(&errors, Some("beauty"));
    let picture = read(&part, Some("beauty")).expect("a layer");
    assert_eq!((&picture.channels[..], picture.standard_errors), (&["Y"][..], Some(vec![vec![0.25, 0.125]])));
    refused(&exr(&[("depth.Z", 1.0)], None), None, "among: depth");
    refused(&exr(&[("Y", 1.0), ("stderr.Y", -1.0)], None), None, "pixel (0, 0), stderr.Y, is -1");
}

/// Nothing that begins like an image brings the reader down.
#[test]
fn damaged_files_are_refused() {
    let files = [exr(&[("R", 1.0), ("G", 2.0), ("B", 3.0)], None), pfm("PF", "-1", f32::to_le_bytes, &[1.0; 18])];
    let damage = (0..2_usize, any::<prop::sample::Index>(), any::<u8>());
    property("damaged images", context("").arguments(2000) as u32, &damage, |(file, at, byte)| {
        let mut bytes = files[file].clone();
        let at = at.index(bytes.len());
        bytes[at] = byte;
        // An image or an error: what counts is that it returns.
        drop(read(&bytes, None));
    });
}
