//! Tests of EXR and PNG files: their content, byte for byte, and that failed writes leave nothing
//! behind.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::Path;

use exr::prelude::{AttributeValue, FlatSamples, read_all_flat_layers_from_file};
use whitefurnace::image::{Display, check_writable, srgb, write_atomically, write_exr, write_png};

use crate::prelude::*;

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder");
    entries
        .map(|entry| {
            entry
                .expect("an entry")
                .file_name()
                .to_string_lossy()
                .into_owned()
        })
        .collect()
}

/// Returns a film of 3 × 2 pixels with different values in every channel.
fn film() -> Film {
    let mut film = Film::new([3, 2], None, 4).expect("a film");
    for (i, pixel) in film.pixels_mut().iter_mut().enumerate() {
        let value = DVec3::new(0.1, 10.0, 0.0) * i as f64;
        // Standard errors differ from channel to channel as well.
        for shift in [0.0, 0.5, 2.0] {
            let shift = shift * DVec3::new(1.0, 2.0, 0.3);
            pixel.push(value + shift, 4).expect("legal");
        }
        let features = Features {
            albedo: DVec3::new(0.25, 0.5, 0.75),
            normal: DVec3::new(0.0, -0.6, 0.8),
            depth: 3.0 + i as f64,
        };
        pixel.push_features(&features).expect("legal");
    }
    film
}

#[test]
fn exr_holds_every_channel() {
    let path = folder().join("film.exr");
    let film = film();
    let camera = Camera::new(DVec3::ZERO, DVec3::Y, DVec3::Z, 0.5);
    write_exr(&path, &film, &camera, "seed=1\nspp=12\n").expect("written");
    let image = read_all_flat_layers_from_file(&path).expect("readable");
    let [layer] = image.layer_data.as_slice() else {
        panic!("one part");
    };
    assert_eq!((layer.size.0, layer.size.1), (3, 2));
    // Three channels each, in the order of their names.
    type Vectors = (&'static str, &'static str, fn(&Pixel) -> DVec3);
    let vectors: [Vectors; 4] = [
        ("", "RGB", Pixel::mean),
        ("albedo.", "RGB", |pixel| pixel.features().albedo),
        ("normal.", "XYZ", |pixel| pixel.features().normal),
        ("stderr.", "RGB", Pixel::standard_error),
    ];
    let pixels = film.pixels();
    let mut expected: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for (group, axes, value) in vectors {
        for (axis, name) in axes.chars().enumerate() {
            expected.insert(
                format!("{group}{name}"),
                pixels.iter().map(|pixel| value(pixel)[axis]).collect(),
            );
        }
    }
    expected.insert(
        "depth.Z".to_owned(),
        pixels.iter().map(|pixel| pixel.features().depth).collect(),
    );
    expected.insert("samples.Y".to_owned(), vec![12.0; pixels.len()]);
    let channels = &layer.channel_data.list;
    assert!(
        channels
            .iter()
            .map(|channel| channel.name.to_string())
            .eq(expected.keys().cloned())
    );
    for (channel, (name, values)) in channels.iter().zip(&expected) {
        let FlatSamples::F32(samples) = &channel.sample_data else {
            panic!("{name} is not of 32-bit floats");
        };
        assert!(
            samples
                .iter()
                .copied()
                .eq(values.iter().map(|value| *value as f32)),
            "{name}"
        );
    }
    // Compares with the values that were pushed, not only with the film.
    let FlatSamples::F32(green) = &channels[1].sample_data else {
        unreachable!("checked above");
    };
    assert!((green[5] - (50.0 + 5.0 / 3.0)).abs() < 1e-5);
    // One attribute is the library's own.
    let other: Vec<_> = layer.attributes.other.iter().collect();
    let [(name, AttributeValue::Text(text))] = other.as_slice() else {
        panic!("{other:?}");
    };
    assert_eq!(
        (name.to_string(), text.to_string()),
        ("provenance".into(), "seed=1\nspp=12\n".into())
    );
    assert!(image.attributes.other.is_empty());
}

/// A wall at distance 2 from a camera that looks along y, seen in a window of an image of square
/// pixels of half the distance.
#[test]
fn exr_says_where_the_camera_is_and_what_features_measure() {
    let path = folder().join("wall.exr");
    let camera = Camera::new(
        DVec3::new(1.0, 2.0, 3.0),
        DVec3::new(1.0, 9.0, 3.0),
        DVec3::Z,
        1.0,
    );
    let wall = |scene: &mut SceneBuilder| {
        let albedo = DVec3::new(0.25, 0.5, 0.75);
        panel(
            scene,
            DVec3::new(-9.0, 4.0, -9.0),
            [30.0 * DVec3::X, 30.0 * DVec3::Z],
            Surface::new(Bsdf::Lambert { albedo }),
        );
    };
    let scene = scene_from(camera, wall);
    let window = Window {
        corner: [2, 1],
        size: [2, 2],
    };
    let mut film = Film::new([6, 4], Some(window), 1).expect("a film");
    let sampling = sampling(Centre, SamplerKind::Independent, 1);
    render(
        &scene,
        &whitefurnace::integrator::Path::default(),
        sampling,
        &mut film,
        &(0..1),
        &|_| true,
    )
    .expect("legal");
    write_exr(&path, &film, &camera, &camera.text()).expect("written");
    let image = read_all_flat_layers_from_file(&path).expect("readable");
    let [layer] = image.layer_data.as_slice() else {
        panic!("one part")
    };
    // The four pixels around the optical axis: 1/4 beside it and 1/4 above or below, at distance 1.
    let distance = 2.0 * (1.0_f64 + 2.0 / 16.0).sqrt();
    for (name, value) in [
        ("albedo.R", 0.25),
        ("albedo.G", 0.5),
        ("albedo.B", 0.75),
        ("normal.X", 0.0),
        ("normal.Y", -1.0),
        ("normal.Z", 0.0),
        ("depth.Z", distance),
    ] {
        let channel = layer
            .channel_data
            .list
            .iter()
            .find(|channel| channel.name.eq(name))
            .expect("a channel");
        let values: Vec<f32> = channel.sample_data.values_as_f32().collect();
        assert_eq!(values.len(), 4);
        values
            .iter()
            .for_each(|&found| assert_abs_diff_eq!(f64::from(found), value, epsilon = 1e-6));
    }
    let row_times = |matrix: Option<[f32; 16]>, point: [f64; 4]| -> [f64; 4] {
        let matrix = matrix.expect("a matrix").map(f64::from);
        std::array::from_fn(|column| {
            (0..4)
                .map(|row| point[row] * matrix[4 * row + column])
                .sum()
        })
    };
    // 3 to the right, 4 up and 5 ahead of the camera.
    let point = [4.0, 7.0, 7.0, 1.0];
    assert_eq!(
        row_times(layer.attributes.world_to_camera, point),
        [3.0, 4.0, 5.0, 1.0]
    );
    // At distance 1 the window covers 1/2 to each side.
    let [x, y, z, w] = row_times(layer.attributes.world_to_normalized_device, point);
    for (found, known) in [(x / w, 0.5 + 0.6), (y / w, 0.5 - 0.8), (z / w, 0.2)] {
        assert_abs_diff_eq!(found, known, epsilon = 1e-6);
    }
    let comments = layer
        .attributes
        .comments
        .as_ref()
        .expect("comments")
        .to_string();
    assert!(
        comments.contains("world space") && comments.contains("along the ray"),
        "{comments}"
    );
    let Some(AttributeValue::Text(text)) = layer.attributes.other.values().next() else {
        panic!("a text")
    };
    assert_eq!(
        text.to_string(),
        "eye=1 2 3\nforward=0 1 0\nright=1 0 0\nup=0 0 1\nhalf-height=1\n"
    );
}

#[test]
fn cameras_are_what_their_texts_say() {
    property(
        "camera text",
        200,
        &(point(5.0), point(5.0), 0.1..2.0),
        |(eye, target, half)| {
            let camera = Camera::new(eye, target, DVec3::new(0.1, 0.2, 0.9), half);
            assert_eq!(
                Camera::parse(&format!("seed=1\n{}spp=2\n", camera.text())),
                Some(camera)
            );
        },
    );
    let text = Camera::new(DVec3::ZERO, DVec3::Y, DVec3::Z, 0.5).text();
    for (from, to) in [
        ("eye=0 0 0\n", ""),
        ("0 0 1", "0 0 NaN"),
        ("0 0 1", "0 1"),
        ("0 0 1", "0 0 1 1"),
        ("=0.5", "=0"),
    ] {
        assert!(
            text.contains(from) && Camera::parse(&text.replace(from, to)).is_none(),
            "{to}"
        );
    }
}

fn read_png(path: &Path) -> ([u32; 2], Vec<u8>) {
    let file = std::io::BufReader::new(File::open(path).expect("a file"));
    let mut reader = png::Decoder::new(file).read_info().expect("a PNG");
    let mut bytes = vec![0; reader.output_buffer_size().expect("a size")];
    let info = reader.next_frame(&mut bytes).expect("a frame");
    assert_eq!(
        (info.color_type, info.bit_depth),
        (png::ColorType::Rgb, png::BitDepth::Eight)
    );
    ([info.width, info.height], bytes)
}

#[test]
fn png_holds_the_encoded_mean() {
    let path = folder().join("film.png");
    for display in [Display::Truncated, Display::Srgb { exposure: -3.0 }] {
        let film = film();
        write_png(&path, &film, display, 1).expect("written");
        let (size, bytes) = read_png(&path);
        assert_eq!(size, [3, 2]);
        let expected: Vec<u8> = film
            .pixels()
            .iter()
            .flat_map(|pixel| pixel.mean().to_array().map(|value| display.encode(value)))
            .collect();
        assert_eq!(bytes, expected);
    }
    // Magnified by 2, every pixel becomes four equal ones.
    let film = film();
    write_png(&path, &film, Display::Truncated, 2).expect("written");
    let (size, bytes) = read_png(&path);
    assert_eq!(size, [6, 4]);
    for (i, rgb) in bytes.chunks_exact(3).enumerate() {
        let mean = film
            .pixel(i as u32 % 6 / 2, i as u32 / 6 / 2)
            .mean()
            .to_array();
        assert_eq!(rgb, mean.map(|value| Display::Truncated.encode(value)));
    }
}

#[test]
fn displays_encode_as_they_say() {
    let truncated = |x| Display::Truncated.encode(x);
    for (radiance, value) in [
        (0.0, 0),
        (1.0 / 255.0, 1),
        (0.999 / 255.0, 0),
        (0.5, 127),
        (0.9999, 254),
        (1.0, 255),
        (50.0, 255),
    ] {
        assert_eq!(truncated(radiance), value, "{radiance}");
    }
    // 25-digit values of IEC 61966-2-1. The last term of the power law loses 8 U in all.
    for (linear, encoded) in [
        (0.0, 0.0),
        (0.001, 0.01292),
        (0.0031308, 0.040449936),
        (0.01, 0.09985282273412834),
        (0.18, 0.46135612950044164),
        (0.5, 0.7353569830524495),
        (0.75, 0.8808250210902998),
        (1.0, 1.0),
    ] {
        assert_abs_diff_eq!(srgb(linear), encoded, epsilon = 8.0 * UNIT_ROUNDOFF);
        let display = Display::Srgb { exposure: 0.0 };
        assert_eq!(f64::from(display.encode(linear)), (255.0 * encoded).round());
        // One stop doubles the value.
        assert_eq!(
            Display::Srgb { exposure: 2.0 }.encode(linear / 4.0),
            display.encode(linear)
        );
        assert_eq!(display.encode(1.0 + linear), 255);
    }
    assert!(
        srgb(0.0031308f64.next_up()) >= srgb(0.0031308) - 1e-7,
        "no step back at the joint"
    );
}

#[test]
fn nothing_is_left_behind_on_failure() {
    let folder = folder();
    let film = film();
    let camera = Camera::new(DVec3::ZERO, DVec3::Y, DVec3::Z, 0.5);
    let taken = folder.join("taken");
    fs::create_dir(&taken).expect("a folder");
    let file = folder.join("file");
    fs::write(&file, "kept").expect("a file");
    for path in [
        taken.clone(),
        folder.join("missing/film.exr"),
        file.join("film.exr"),
    ] {
        for result in [
            write_exr(&path, &film, &camera, ""),
            write_png(&path, &film, Display::Truncated, 1),
            write_atomically(&path, |_| Ok(())),
        ] {
            assert!(matches!(result, Err(Error::File { .. })), "{result:?}");
            assert_refused(result, &path.to_string_lossy());
        }
    }
    let mut found = names(&folder);
    found.sort();
    assert_eq!(found, ["file", "taken"]);
    assert!(names(&taken).is_empty());
    // A failed write leaves the earlier file as it was.
    assert!(write_atomically(&file, |_| Err(Error::Option("no".to_owned()))).is_err());
    assert_eq!(fs::read_to_string(&file).expect("a file"), "kept");
    assert!(write_exr(&file, &film, &camera, "not Latin-1: \u{4e00}").is_err());
    assert_eq!(fs::read_to_string(&file).expect("a file"), "kept");
}

#[test]
fn paths_are_checked_beforehand() {
    let folder = folder();
    let file = folder.join("file");
    fs::write(&file, "kept").expect("a file");
    assert!(check_writable(&folder.join("new/deep/film.exr")).is_ok());
    assert!(
        names(&folder.join("new/deep")).is_empty(),
        "no trace but the folder"
    );
    assert!(check_writable(&file).is_ok());
    assert_eq!(fs::read_to_string(&file).expect("a file"), "kept");
    assert!(check_writable(&folder).is_err());
    assert!(check_writable(&file.join("film.exr")).is_err());
}

/// Each pixel is rounded down, clipped at 1 and then averaged; samples of a pixel are averaged
/// before.
#[test]
fn means_of_images_are_of_8_bit_values() {
    let grey = |value: f64| value / 255.0;
    let mut film = Film::new([2, 1], None, 1).expect("a film");
    // Pixels of means 1.9, 4, 510 and 2.9, 4.5, 0 in units of 1/255.
    for (pixel, values) in film.pixels_mut().iter_mut().zip([
        [[1.0, 2.5, 1020.0], [2.8, 5.5, 0.0]],
        [[2.9, 0.5, 0.0], [2.9, 8.5, 0.0]],
    ]) {
        for value in values {
            pixel.push(DVec3::from(value.map(grey)), 1).expect("legal");
        }
    }
    assert_eq!(Display::Truncated.encoded_mean(&film), [1.5, 4.0, 127.5]);
    let srgb = Display::Srgb { exposure: 0.0 };
    let encoded = |value: f64| f64::from(srgb.encode(grey(value)));
    let expected =
        [[1.9, 2.9], [4.0, 4.5], [510.0, 0.0]].map(|[a, b]| 0.5 * (encoded(a) + encoded(b)));
    assert_eq!(srgb.encoded_mean(&film), expected);
}
