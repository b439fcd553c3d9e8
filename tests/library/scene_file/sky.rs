//! Tests of skies: images of all directions as backgrounds.

use super::*;

/// Skies: two rows and one column in each channel, scaled; and files that are refused.
#[test]
fn a_sky_is_an_image_of_all_directions() {
    let folder = folder();
    let floats = [4.0f32, 5.0, 6.0, 1.0, 2.0, 3.0].map(f32::to_le_bytes);
    fs::write(
        folder.join("sky.pfm"),
        [&b"PF\n1 2\n-1.0\n"[..], floats.as_flattened()].concat(),
    )
    .expect("written");
    let load = |sky: &str| {
        let text = EVERY_KEY.replace(
            "background = [0.25, 0.5, 1]",
            &format!("background = {{ {sky} }}"),
        );
        fs::write(folder.join("scene.toml"), text).expect("written");
        fs::write(folder.join("pyramid.obj"), PYRAMID).expect("written");
        SceneFile::load(&folder.join("scene.toml"))
    };
    let pixels = [DVec3::new(1.0, 2.0, 3.0), DVec3::new(4.0, 5.0, 6.0)];
    let map = |scale, up, front| {
        EnvironmentMap::new([1, 2], pixels.map(|p| p * scale).to_vec(), up, front)
            .map(Environment::Map)
    };
    let plain = load("image = 'sky.pfm'").expect("a scene");
    assert_eq!(
        Ok(plain.description.background),
        map(1.0, DVec3::Z, DVec3::X)
    );
    let shape = "sky.pfm is 1 × 2 pixels and read by longitude and latitude, as the whole sphere, which is twice as wide";
    assert!(plain.notes[0].contains(shape), "{:?}", plain.notes);
    let turned =
        load("image = 'sky.pfm', scale = 0.5, up = [0, 1, 0], front = [0, 0, 2]").expect("a scene");
    assert_eq!(
        Ok(turned.description.background),
        map(0.5, DVec3::Y, DVec3::Z)
    );
    // Radiance pictures as well: 128 · 2^(129 − 136) is 1. This sky needs no note.
    let bytes = [
        &b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n"[..],
        &[128, 64, 0, 129, 64, 64, 64, 130],
    ]
    .concat();
    fs::write(folder.join("sky.hdr"), bytes).expect("written");
    let radiance = load("image = 'sky.hdr'").expect("a scene");
    let pixels = vec![DVec3::new(1.0, 0.5, 0.0), DVec3::ONE];
    let right = EnvironmentMap::new([2, 1], pixels, DVec3::Z, DVec3::X).map(Environment::Map);
    assert_eq!(Ok(radiance.description.background), right);
    assert!(
        !radiance.notes.iter().any(|note| note.contains("sky.hdr")),
        "{:?}",
        radiance.notes
    );
    // A key selects a layer; invalid radiance is refused.
    let sky = |names: &[&str], attributes: ImageAttributes, environment_map| {
        let channel =
            |(i, &name): (usize, &&str)| AnyChannel::new(name, FlatSamples::F32(vec![i as f32; 2]));
        let channels = AnyChannels::sort(names.iter().enumerate().map(channel).collect());
        let own = LayerAttributes {
            environment_map,
            ..LayerAttributes::default()
        };
        let layer = Layer::new((2, 1), own, Encoding::UNCOMPRESSED, channels);
        Image::new(attributes, layer)
            .write()
            .to_file(folder.join("sky.exr"))
            .expect("written");
    };
    let plain_attributes = || ImageAttributes::new(IntegerBounds::from_dimensions((2, 1)));
    sky(
        &[
            "day.R",
            "day.G",
            "day.B",
            "night.red",
            "night.green",
            "night.blue",
        ],
        plain_attributes(),
        None,
    );
    let night = load("image = 'sky.exr', layer = 'night'")
        .expect("a scene")
        .description
        .background;
    let pixels = vec![DVec3::new(3.0, 4.0, 5.0); 2];
    assert_eq!(
        Ok(night),
        EnvironmentMap::new([2, 1], pixels, DVec3::Z, DVec3::X).map(Environment::Map)
    );
    let refused = |sky: &str, hint: &str| {
        let message = refusal(load(sky), hint);
        assert!(
            message.contains(hint) && message.contains("scene.toml, line "),
            "{message}"
        );
    };
    refused("image = 'sky.exr'", "choose by layer among: day, night");
    sky(&["X", "Y", "Z"], plain_attributes(), None);
    refused(
        "image = 'sky.exr'",
        "is no radiance in R, G, B, or of one channel: X, Y, Z as X, Y, Z",
    );
    sky(
        &["R", "G", "B"],
        plain_attributes(),
        Some(exr::meta::attribute::EnvironmentMap::Cube),
    );
    refused("image = 'sky.exr'", "is a cube map");
    let aces = [
        (0.7347, 0.2653),
        (0.0, 1.0),
        (0.0001, -0.077),
        (0.32168, 0.33767),
    ]
    .map(|(x, y)| Vec2(x, y));
    let chromaticities = Some(Chromaticities {
        red: aces[0],
        green: aces[1],
        blue: aces[2],
        white: aces[3],
    });
    sky(
        &["R", "G", "B"],
        ImageAttributes {
            chromaticities,
            ..plain_attributes()
        },
        None,
    );
    refused("image = 'sky.exr'", "not those of Rec. 709 and sRGB");
    fs::write(
        folder.join("sky.pfm"),
        [&b"PF\n1 1\n-1.0\n"[..], floats[..3].as_flattened()].concat(),
    )
    .expect("written");
    assert_ne!(
        load("image = 'sky.pfm'").expect("a scene").digest,
        plain.digest
    );
    for (sky, hint) in [
        (
            "image = 'none.pfm'",
            "background.image \"none.pfm\" cannot be read",
        ),
        ("image = 'pyramid.obj'", "neither EXR nor PFM"),
        (
            "image = 'sky.pfm', scale = 0",
            "background.scale must be a number from 0.000000001",
        ),
        (
            "image = 'sky.pfm', front = [0, 0, 1]",
            "up and front must not be along one line",
        ),
    ] {
        refused(sky, hint);
    }
}
