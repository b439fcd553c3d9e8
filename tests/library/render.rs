//! Tests of the rendering loop: the same bits however the work is divided.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::prelude::*;

const FRAME: [u32; 2] = [24, 18];

fn path() -> Path<'static> {
    Path::default()
}

fn independent(pixel: PixelSampling) -> Sampling {
    sampling(pixel, SamplerKind::Independent, master())
}

fn film(pixel: PixelSampling, window: Option<Window>) -> Film {
    Film::new(FRAME, window, pixel.samples_per_replication()).expect("a film")
}

/// Renders the given ranges of replications into a film.
fn divided(scene: &Scene, estimator: &dyn Estimator, ranges: &[Range<u32>]) -> Film {
    rendered(scene, estimator, FRAME, independent(Random), ranges).expect("legal radiance")
}

fn whole(scene: &Scene, estimator: &dyn Estimator, pixel: PixelSampling) -> Film {
    rendered(scene, estimator, FRAME, independent(pixel), &[0..4]).expect("legal radiance")
}

#[test]
fn divided_ranges_are_one_run() {
    let scene = report_room();
    let once = divided(&scene, &path(), &[0..7]);
    for ranges in [
        vec![0..3, 3..7],
        vec![4..7, 0..1, 1..4],
        vec![0..0, 0..7, 7..7],
    ] {
        assert!(divided(&scene, &path(), &ranges) == once);
    }
    // Separate films, merged in any order.
    let parts = [0..2, 2..3, 3..7].map(|range| divided(&scene, &path(), &[range]));
    for order in [[0, 1, 2], [2, 0, 1], [1, 2, 0]] {
        let mut sum = film(Random, None);
        for i in order {
            sum.merge(&parts[i]).expect("films of one kind");
        }
        assert!(sum == once, "merged as {order:?}");
    }
    let other = sampling(Random, SamplerKind::Independent, master() ^ 1);
    assert!(
        rendered(&scene, &path(), FRAME, other, &[0..7]).expect("legal radiance") != once,
        "seeds matter"
    );
}

#[test]
fn windows_are_crops() {
    let scene = report_room();
    for pixel in [Random, Jitter(2)] {
        let full = whole(&scene, &path(), pixel);
        for (corner, size) in [([0, 0], FRAME), ([5, 3], [7, 9]), ([23, 17], [1, 1])] {
            let window = Window { corner, size };
            let mut crop = film(pixel, Some(window));
            let done = render(
                &scene,
                &path(),
                independent(pixel),
                &mut crop,
                &(0..4),
                &|_| true,
            );
            assert!(matches!(done, Ok(true)));
            for y in 0..size[1] {
                for x in 0..size[0] {
                    let expected = full.pixel(corner[0] + x, corner[1] + y);
                    assert_eq!(crop.pixel(x, y), expected, "({x}, {y}) of {window:?}");
                }
            }
        }
    }
}

/// Returns where a ray passes the image plane, as its horizontal and vertical slope plus 2.
struct Slopes;

impl Estimator for Slopes {
    fn radiance(&self, scene: &Scene, ray: &Ray, hit: Option<Hit>, _: &mut dyn Sampler) -> DVec3 {
        assert_eq!(hit, scene.intersect(ray), "the hit belongs to the ray");
        let d = ray.direction / -ray.direction.x;
        DVec3::new(d.y + 2.0, d.z + 2.0, 0.0)
    }
}

#[test]
fn pixels_are_where_they_belong() {
    // Half height 0.77704 at distance 1: a pixel is 2 · 0.77704/18 wide. Values are rounded to
    // units of 2⁻³².
    let scene = report_room();
    let step = 2.0 * 0.77704 / 18.0;
    let numbers = [
        SamplerKind::Independent,
        SamplerKind::Sobol(1),
        SamplerKind::Sobol(4),
    ];
    let places = [Centre, Grid(2), Grid(3)];
    for (numbers, pixel) in numbers
        .iter()
        .flat_map(|&numbers| places.map(|pixel| (numbers, pixel)))
    {
        let sampling = sampling(pixel, numbers, master());
        let film = rendered(&scene, &Slopes, FRAME, sampling, &[0..4]).expect("legal radiance");
        for (x, y) in [(0, 0), (23, 0), (5, 11), (23, 17)] {
            let mean = film.pixel(x, y).mean();
            let expected = DVec3::new(
                2.0 + (f64::from(x) + 0.5 - 12.0) * step,
                2.0 + (9.0 - f64::from(y) - 0.5) * step,
                0.0,
            );
            assert!((mean - expected).abs().max_element() < 1.0 / (1u64 << 31) as f64);
            // Replications are whole grids, all alike.
            assert_eq!(film.pixel(x, y).standard_error(), DVec3::ZERO);
            assert_eq!(film.pixel(x, y).replications(), 4);
        }
    }
    for pixel in [Random, Jitter(2)] {
        let film = whole(&scene, &Slopes, pixel);
        let found = film.pixel(5, 11);
        assert_eq!(found.replications(), 4);
        assert!(found.standard_error().x > 0.0);
        // Never farther than half a pixel from the centre.
        assert!((found.mean().x - (2.0 - 6.5 * step)).abs() <= 0.5 * step);
        assert!((found.mean().y - (2.0 - 2.5 * step)).abs() <= 0.5 * step);
    }
}

/// A lamp that fills one pixel is seen in that pixel alone, by every estimator of whole images.
#[test]
fn passes_see_a_lamp_in_its_pixel() {
    let camera = Camera::new(DVec3::ZERO, DVec3::X, DVec3::Z, 0.5);
    let [x, y] = [3.0, 2.0];
    let place = |dx: f64, dy: f64| {
        let way = camera.ray(FRAME, x + dx, y + dy).direction;
        way / way.x
    };
    let (corner, right, below) = (place(0.0, 0.0), place(1.0, 0.0), place(0.0, 1.0));
    let scene = scene_from(camera, |scene| {
        panel(scene, corner, [below - corner, right - corner], lamp(2.0));
    });
    let sppm = sppm(Parts::default(), 1, 0.1);
    let tracer = LightTracer::default();
    let images = |index| {
        let bdpt = Bdpt::new(Parts::default()).pass(&scene, FRAME, master(), index);
        [
            bdpt,
            sppm.pass(&scene, FRAME, master(), index),
            tracer.pass(&scene, FRAME, master(), index),
        ]
    };
    for image in (0..8).flat_map(images) {
        for (i, value) in image.expect("legal radiance").into_iter().enumerate() {
            let known = if i == 2 * FRAME[0] as usize + 3 {
                2.0
            } else {
                0.0
            };
            assert_abs_diff_eq!(value, DVec3::splat(known), epsilon = 1e-6);
        }
    }
}

#[test]
fn features_are_those_of_the_first_hit() {
    let scene = report_room();
    let film = whole(&scene, &path(), Centre);
    for (x, y) in [(12, 2), (2, 9), (12, 13), (20, 4)] {
        let [px, py] = [x, y].map(|v| f64::from(v) + 0.5);
        let hit = scene
            .intersect(&scene.camera().ray(FRAME, px, py))
            .expect("closed");
        let found = film.pixel(x, y).features();
        let unit = 1.0 / (1u64 << 32) as f64;
        assert!(
            (found.albedo - scene.surface(&hit).bsdf.albedo())
                .abs()
                .max_element()
                <= unit
        );
        assert!((found.depth - hit.t).abs() <= unit);
        assert!(
            (found.normal - hit.normal).abs().max_element() <= unit,
            "the room's fronts"
        );
    }
    // Without a hit there are no features; from inside glass the normal faces the camera.
    let open = whole(&simple::environment().expect("a scene"), &path(), Centre);
    assert_eq!(open.pixel(0, 0).features().depth, 0.0);
    assert_eq!(open.pixel(0, 0).mean(), DVec3::ONE);
    let glass = simple::glass_cube(true).expect("a scene");
    let inside = whole(&glass, &path(), Centre);
    assert!(
        inside
            .pixel(12, 9)
            .features()
            .normal
            .dot(glass.camera().ray(FRAME, 12.5, 9.5).direction)
            < 0.0
    );
}

/// Compares albedo, normal and depth of two films, to the last bit.
fn same_features(a: &Film, b: &Film) -> bool {
    let shown = |film: &Film| -> Vec<[f64; 7]> {
        let values = |pixel: &Pixel| {
            let Features {
                albedo,
                normal,
                depth,
            } = pixel.features();
            let ([a, b, c], [x, y, z]) = (albedo.to_array(), normal.to_array());
            [a, b, c, x, y, z, depth]
        };
        film.pixels().iter().map(values).collect()
    };
    shown(a) == shown(b)
}

#[test]
fn features_are_the_same_for_every_estimator() {
    let scene = simple::cornell().expect("a scene");
    let ways = [Centre, Grid(2), Random, Jitter(2)];
    let mis = ways.map(|pixel| whole(&scene, &path(), pixel));
    let lookup = Lookup::DirectVisualization;
    let photons = PhotonMapping::new(
        Parts::default(),
        &scene,
        lookup,
        100,
        0.3,
        ImagePass::independent(1, 0),
    )
    .expect("a small map");
    let resolution = resolution(40, 0);
    let solved =
        Radiosity::new(Parts::default(), &scene, resolution, &|_| true).expect("it settles");
    for (pixel, mis) in ways.into_iter().zip(&mis) {
        for (name, film) in [
            ("report", whole(&scene, &Report::default(), pixel)),
            ("published", whole(&scene, &Published::default(), pixel)),
            (
                "whitted",
                whole(&scene, &Whitted::new(TransportRules::PHYSICAL), pixel),
            ),
            ("photon", whole(&scene, &photons, pixel)),
            ("radiosity", whole(&scene, &solved, pixel)),
        ] {
            assert!(same_features(&film, mis), "{name}, {pixel:?}");
        }
    }
    // Whole images at random points, with as many passes as there were replications.
    let images = |ranges: &[Range<u32>]| {
        let sppm = sppm(Parts::default(), 100, 0.3);
        [
            (
                "light tracer",
                passes(&scene, &LightTracer::default(), FRAME, ranges).expect("legal"),
            ),
            (
                "bdpt",
                passes(&scene, &Bdpt::new(Parts::default()), FRAME, ranges).expect("legal"),
            ),
            ("sppm", passes(&scene, &sppm, FRAME, ranges).expect("legal")),
        ]
    };
    let random = &mis[2];
    assert!(random.pixel(12, 9).features().depth > 0.0);
    for ((name, film), (_, divided)) in images(&[0..4]).into_iter().zip(images(&[2..4, 0..2])) {
        assert!(same_features(&film, random), "{name}");
        assert!(film == divided, "{name} in two runs");
    }
    assert!(!same_features(random, &mis[0]) && !same_features(random, &mis[3]));
}

/// Renderers fill films as the functions they stand for do, and report the samples done.
#[test]
fn renderers_fill_films_as_the_functions_do() {
    let scene = report_room();
    let tracer = LightTracer::default();
    let by_rays = RayRenderer {
        estimator: path(),
        sampling: independent(Jitter(2)),
    };
    let by_lanes = lanes(
        LaneEstimator::Path(path()),
        independent(Jitter(2)),
        Precision::Double,
    );
    let by_passes = ImageRenderer {
        estimator: tracer,
        sampler: SamplerKind::Independent,
        seed: master(),
    };
    let rays =
        rendered(&scene, &path(), FRAME, independent(Jitter(2)), &[2..6]).expect("legal radiance");
    let images = passes(&scene, &tracer, FRAME, &[2..6]).expect("legal radiance");
    let lanes = rays.clone();
    for (renderer, samples, expected) in [
        (&by_rays as &dyn Renderer, 4, rays),
        (&by_lanes, 4, lanes),
        (&by_passes, 1, images),
    ] {
        assert_eq!(renderer.samples_per_replication(), samples);
        let mut film = Film::new(FRAME, None, samples).expect("a film");
        let reported = AtomicU64::new(0);
        let done = renderer.add(&scene, &mut film, 2..6, &|samples| {
            reported.fetch_add(samples, Ordering::Relaxed);
            true
        });
        assert!(matches!(done, Ok(true)) && film == expected);
        assert_eq!(reported.into_inner(), 24 * 18 * 4 * u64::from(samples));
        assert!(matches!(
            renderer.add(&scene, &mut film, 6..7, &|_| false),
            Ok(false)
        ));
    }
}

#[test]
fn a_run_can_be_stopped_after_a_part() {
    let mut target = film(Random, None);
    let one_part = || {
        render(
            &report_room(),
            &path(),
            independent(Random),
            &mut target,
            &(0..1),
            &|_| false,
        )
    };
    let done = on_threads(1, one_part);
    assert!(matches!(done, Ok(false)));
    assert_eq!(
        target
            .pixels()
            .iter()
            .filter(|p| p.replications() > 0)
            .count(),
        24,
        "one row, then stop"
    );
}
