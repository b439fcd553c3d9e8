//! Tests of interrupted work: resuming gives the film of an uninterrupted run, also through a file;
//! files that are not of unfinished work are refused.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use whitefurnace::image::read::decode;
use whitefurnace::integrator::Path as Paths;
use whitefurnace::render::checkpoint::{
    Attributes, decode_checkpoint, read_checkpoint, write_checkpoint,
};

use crate::prelude::*;

fn notes() -> Attributes {
    BTreeMap::from(
        [
            ("provenance", "seed=1\nspp=12\n"),
            ("replications", "0..3 of 9"),
        ]
        .map(|(a, b)| (a.into(), b.into())),
    )
}

/// Writes a film to a file and reads it back.
fn through(path: &Path, film: &Film) -> Film {
    write_checkpoint(path, film, &notes()).expect("written");
    let (read, said) = read_checkpoint(path).expect("read");
    assert_eq!(said, notes());
    read
}

#[test]
fn files_keep_every_bit_of_the_sums() {
    let path = folder().join("sums.exr");
    let radiance = prop_oneof![
        point(10.0),
        point(LARGEST),
        Just(DVec3::ZERO),
        Just(DVec3::splat(LARGEST))
    ];
    let pixel = (
        prop::collection::vec(radiance, 0..4),
        prop::collection::vec((point(1.0), 0.0..LARGEST), 0..3),
    );
    property(
        "unfinished",
        60,
        &prop::collection::vec(pixel, 2 * 35),
        |pixels| {
            let window = Window {
                corner: [5, 7],
                size: [35, 2],
            };
            let mut film = Film::new([40, 10], Some(window), 3).expect("a film");
            for (pixel, (radiances, features)) in film.pixels_mut().iter_mut().zip(pixels) {
                for radiance in radiances {
                    pixel
                        .push(radiance.abs().min(DVec3::splat(LARGEST)), 3)
                        .expect("legal");
                }
                for (vector, depth) in features {
                    let normal = (vector + DVec3::splat(1e-3)).normalize();
                    pixel
                        .push_features(&Features {
                            albedo: vector.abs().min(DVec3::ONE),
                            normal,
                            depth,
                        })
                        .expect("legal");
                }
            }
            assert!(through(&path, &film) == film);
        },
    );
}

/// Adds a range in several calls; each is stopped after so many calls of `done`, except those after
/// the last number.
fn in_pieces(
    renderer: &dyn Renderer,
    scene: &Scene,
    film: &mut Film,
    range: &Range<u32>,
    stops: &[u64],
    path: &Path,
) {
    let mut stops = stops.iter();
    while !film.has_exactly(range.end - range.start) {
        let left = AtomicU64::new(stops.next().copied().unwrap_or(u64::MAX));
        let done = |_| {
            left.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |n| n.checked_sub(1))
                .is_ok()
        };
        let had = film.replications();
        renderer
            .add(scene, film, range.start + had..range.end, &done)
            .expect("rendered");
        *film = through(path, film);
    }
}

#[test]
fn what_was_stopped_goes_on_to_the_same_film() {
    let scene = simple::cornell().expect("a scene");
    let sampling = |points| Sampling {
        silhouettes: true,
        ..sampling(Random, SamplerKind::Sobol(points), master())
    };
    let path = Paths::new(PathStrategy::Mis);
    let renderers: [(&str, Box<dyn Renderer>); 3] = [
        (
            "rays",
            Box::new(RayRenderer {
                estimator: path,
                sampling: sampling(2),
            }),
        ),
        // One pixel at a time.
        (
            "lanes",
            Box::new(lanes(
                LaneEstimator::Path(path),
                sampling(1 << 13),
                Precision::Double,
            )),
        ),
        (
            "passes",
            Box::new(ImageRenderer {
                estimator: Bdpt::new(Parts::default()),
                sampler: SamplerKind::Sobol(4),
                seed: master(),
            }),
        ),
    ];
    let range = 2..4;
    for (name, renderer) in &renderers {
        let empty = Film::new([4, 3], None, renderer.samples_per_replication()).expect("a film");
        let mut whole = empty.clone();
        assert!(
            renderer
                .add(&scene, &mut whole, range.clone(), &|_| true)
                .expect("rendered")
        );
        let path = folder().join(format!("{name}.exr"));
        property(name, 8, &prop::collection::vec(0..6_u64, 0..5), |stops| {
            let mut film = empty.clone();
            in_pieces(&**renderer, &scene, &mut film, &range, &stops, &path);
            assert!(film == whole, "{name}: {stops:?}");
        });
        // A replication that was only begun does not count.
        let mut begun = empty.clone();
        assert!(
            !renderer
                .add(&scene, &mut begun, range.clone(), &|_| false)
                .expect("stopped")
        );
        assert!(!begun.has_exactly(2) && begun.replications() == 0);
        assert_eq!(whole.merge(&begun).is_err(), *name == "passes");
    }
}

/// With any byte changed, or any length, a file gives the same film if the byte is not part of it,
/// or an error of one line.
#[test]
fn damaged_files_are_refused() {
    let path = folder().join("damaged.exr");
    let scene = simple::cornell().expect("a scene");
    let mut film = Film::new([2, 1], None, 4).expect("a film");
    let renderer = ImageRenderer {
        estimator: Bdpt::new(Parts::default()),
        sampler: SamplerKind::Sobol(4),
        seed: 1,
    };
    renderer
        .add(&scene, &mut film, 0..2, &|_| true)
        .expect("rendered");
    renderer
        .add(&scene, &mut film, 2..3, &|_| false)
        .expect("stopped");
    assert!(through(&path, &film) == film);
    let good = std::fs::read(&path).expect("a file");
    // Viewers and other programs read it as an image.
    let picture = decode(&path, &good, None, "--layer").expect("an image");
    assert_eq!(
        picture.values[1][1],
        f64::from(film.pixel(1, 0).mean().y as f32)
    );
    let mut refused = 0;
    let mut check = |bytes: &[u8]| match decode_checkpoint(bytes) {
        Ok(read) => assert!(read == (film.clone(), notes())),
        Err(message) => {
            assert_eq!(message.lines().count(), 1, "{message}");
            refused += 1;
        }
    };
    for at in 0..good.len() {
        check(&good[..at]);
        for mask in [0x01, 0x80, 0xff] {
            let mut bytes = good.clone();
            bytes[at] ^= mask;
            check(&bytes);
        }
    }
    // All lengths, and most of the bytes.
    assert!(refused > 2 * good.len(), "{refused} of {}", 4 * good.len());
    assert_refused(read_checkpoint(Path::new("nowhere.exr")), "nowhere");
}
