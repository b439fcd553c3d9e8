//! Tests of layers and channels of EXR images by other programs: which are read, and which of them
//! must be chosen.

use super::*;

/// Encodes channels with the names in this text, each with its own value.
fn named(names: &str) -> Vec<u8> {
    let names = names.split(' ').enumerate();
    let channels: Vec<(&str, f32)> = names.map(|(i, name)| (name, 1.0 + i as f32)).collect();
    exr(&channels, None)
}

/// Other programs' channel names for an image, and for the data beside it.
#[test]
fn the_image_is_found_by_the_names_that_programs_use() {
    let beside = "ViewLayer.Depth.Z ViewLayer.Normal.X ViewLayer.Normal.Y ViewLayer.Normal.Z";
    let combined =
        "ViewLayer.Combined.R ViewLayer.Combined.G ViewLayer.Combined.B ViewLayer.Combined.A";
    for (names, meaning, first) in [
        ("R G B A", ChannelKind::Rgb, "R"),
        ("b g r", ChannelKind::Rgb, "r"),
        ("red green blue", ChannelKind::Rgb, "red"),
        (".R .G .B", ChannelKind::Rgb, ".R"),
        (
            "beauty.[red] beauty.[green] beauty.[blue]",
            ChannelKind::Rgb,
            "beauty.[red]",
        ),
        ("rgb.blue rgb.green rgb.red", ChannelKind::Rgb, "rgb.red"),
        (
            "rgba.Red rgba.Green rgba.Blue rgba.Alpha Z",
            ChannelKind::Rgb,
            "rgba.Red",
        ),
        (
            "R G B Albedo.R Albedo.G Albedo.B Variance.R Variance.G Variance.B",
            ChannelKind::Rgb,
            "R",
        ),
        ("R G B left.R left.G left.B", ChannelKind::Rgb, "R"),
        (
            &format!("{combined} {beside}"),
            ChannelKind::Rgb,
            "ViewLayer.Combined.R",
        ),
        ("Y", ChannelKind::Luminance, "Y"),
        ("Y A Z", ChannelKind::Luminance, "Y"),
        (
            "Y albedo.R albedo.G albedo.B Normal.X Normal.Y Normal.Z",
            ChannelKind::Luminance,
            "Y",
        ),
        ("X Y Z A", ChannelKind::Xyz, "X"),
        (
            "X Y Z crypto_object00.r crypto_object00.g crypto_object00.b",
            ChannelKind::Xyz,
            "X",
        ),
    ] {
        let picture = read(&named(names), None).expect("an image");
        let place = names
            .split(' ')
            .position(|name| name == first)
            .expect("there");
        assert_eq!(
            (picture.kind, &picture.channels[0][..]),
            (meaning, first),
            "{names:?}"
        );
        assert_eq!(picture.values[0][0], 1.0 + place as f64, "{names:?}");
        assert_eq!(
            picture.channels.len(),
            if meaning == ChannelKind::Luminance {
                1
            } else {
                3
            }
        );
    }
    let picture = read(&named(&format!("{combined} {beside}")), None).expect("an image");
    let reading = "ViewLayer.Combined.R, ViewLayer.Combined.G, ViewLayer.Combined.B as RGB; not read: \
                   ViewLayer.Combined.A, ViewLayer.Depth, ViewLayer.Normal";
    assert_eq!(picture.describe(), reading);
}

/// Ambiguous images are refused with a list of all that could be read by name.
#[test]
fn what_may_be_another_image_is_refused() {
    for (names, hint) in [
        (
            "Combined.R Combined.G Combined.B DiffDir.R DiffDir.G DiffDir.B",
            "among: Combined, DiffDir",
        ),
        // Only data that accompanies images.
        ("albedo.R albedo.G albedo.B", "among: albedo"),
        ("Normal.X Normal.Y Normal.Z Depth.Z", "among: Normal"),
        ("foo.X foo.Y foo.Z", "among: foo"),
        // The image is spectral, and the data beside it have three colours.
        (
            "S0.400nm S0.500nm direct.R direct.G direct.B",
            "among: direct",
        ),
        ("X Y Z beauty.R beauty.G beauty.B", "among: X,Y,Z, beauty"),
        ("Y beauty.R beauty.G beauty.B", "among: Y, beauty"),
        ("Y RY BY", "luminance and chroma"),
        ("Y RY BY albedo.R albedo.G albedo.B", "luminance and chroma"),
        (
            "motion.X motion.Y",
            "one or three channels, with commas, by --layer among: motion.X, motion.Y",
        ),
        (
            "R A",
            "one or three channels, with commas, by --layer among: A, R",
        ),
        (
            "R red G B",
            "one or three channels, with commas, by --layer among: B, G, R, red",
        ),
    ] {
        refused(&named(names), None, hint);
    }
    // Chroma with half the columns: the header says so after the name, four bytes of type and four
    // others.
    let mut chroma = named("Y RY BY");
    let at = chroma
        .windows(3)
        .position(|bytes| bytes == b"RY\0")
        .expect("there")
        + 3
        + 8;
    chroma[at] = 2;
    refused(
        &chroma,
        None,
        "channel RY has fewer values than pixels: write R, G and B of full size",
    );
    // Every layer that the message offers can be read.
    let layered = "X Y Z beauty.R beauty.G beauty.B depth.Z ao.Y";
    for (layer, meaning, first) in [
        ("X,Y,Z", ChannelKind::Xyz, 1.0),
        ("beauty", ChannelKind::Rgb, 4.0),
        ("ao", ChannelKind::Luminance, 8.0),
        ("depth.Z", ChannelKind::Grey, 7.0),
        ("ao.Y, X, Z", ChannelKind::Three, 8.0),
        ("beauty.B,beauty.G,beauty.R", ChannelKind::Three, 6.0),
    ] {
        let picture = read(&named(layered), Some(layer)).expect(layer);
        assert_eq!(
            (picture.kind, picture.values[0][0]),
            (meaning, first),
            "{layer}"
        );
    }
    for layer in ["depth", "X,Y", "none", "beauty.R,beauty.G,beauty.X"] {
        refused(
            &named(layered),
            Some(layer),
            "choose by --layer among: X,Y,Z, ao, beauty",
        );
    }
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
            // Names are in order, but groups are not contiguous.
            ("far.C.x", 8.0),
            ("far.Z", 9.0),
        ],
        None,
    );
    refused(&layered, None, "--layer among: far, view");
    assert_eq!(
        read(&layered, Some("far")).expect("a layer").values[0],
        [5.0, 2.5]
    );
    refused(&layered, Some("near"), "no layer \"near\"");
    let picture = read(&layered, Some("view")).expect("a layer");
    assert_eq!(picture.values, [[1.0, 0.5], [2.0, 1.0], [3.0, 1.5]]);
    assert_eq!((picture.size, picture.rounding), ([2, 1], 1.0 / 2048.0));
    assert_eq!(picture.skipped_channels, ["far", "far.C", "view.a"]);
    // The only part has a name, by which it may be selected; standard errors belong to it.
    let errors = [("Y", 1.0), ("stderr.Y", 0.25)];
    for layer in [None, Some("beauty"), Some("Y")] {
        let picture = read(&exr(&errors, Some("beauty")), layer).expect("a layer");
        assert_eq!(
            (picture.kind, picture.standard_errors),
            (ChannelKind::Luminance, Some(vec![vec![0.25, 0.125]]))
        );
    }
    refused(&exr(&[("depth.Z", 1.0)], None), None, "among: depth.Z");
    refused(
        &exr(&[("Y", 1.0), ("stderr.Y", -1.0)], None),
        None,
        "pixel (0, 0), the standard error of Y, is -1",
    );
    // After one sample the standard error is unknown.
    let infinite = exr(&[("Y", 1.0), ("stderr.Y", f32::INFINITY)], None);
    assert_eq!(
        read(&infinite, None).expect("an image").standard_errors,
        None
    );
}

/// Parts have names of their own; channels may repeat them.
#[test]
fn parts_are_layers() {
    let layer = |name: &str, channels: &[&str], size: (usize, usize)| {
        let channel = |&name: &&str| {
            AnyChannel::new(
                name,
                FlatSamples::F32(vec![name.len() as f32; size.0 * size.1]),
            )
        };
        let channels = AnyChannels::sort(channels.iter().map(channel).collect());
        Layer::new(
            size,
            LayerAttributes::named(name),
            Encoding::SMALL_LOSSLESS,
            channels,
        )
    };
    let file = |layers: Vec<Layer<AnyChannels<FlatSamples>>>| {
        let mut bytes = Cursor::new(Vec::new());
        let bounds = IntegerBounds::from_dimensions((2, 1));
        let image = Image::from_layers(ImageAttributes::new(bounds), layers);
        image.write().to_buffered(&mut bytes).expect("written");
        bytes.into_inner()
    };
    let colours = ["R", "G", "B"];
    let repeated = ["depth.R", "depth.G", "depth.B"];
    let bytes = file(vec![
        layer("depth", &repeated, (2, 1)),
        layer("rgba", &colours, (2, 1)),
    ]);
    let picture = read(&bytes, None).expect("an image");
    assert_eq!(
        (&picture.channels[0][..], picture.values[0][0]),
        ("rgba.R", 1.0)
    );
    assert_eq!(
        read(&bytes, Some("depth")).expect("a layer").values[0][0],
        7.0
    );
    let views = file(vec![
        layer("rgba.left", &colours, (2, 1)),
        layer("rgba.right", &colours, (2, 1)),
    ]);
    refused(&views, None, "among: rgba.left, rgba.right");
    let sizes = file(vec![
        layer("small", &["v"], (1, 1)),
        layer("large", &["v", "w"], (2, 1)),
    ]);
    refused(
        &sizes,
        Some("small.v,large.v,large.w"),
        "channels small.v and large.v differ in size or place",
    );
}
