//! Dependence of the speed on threads, samples, pixels and triangles.

use std::f64::consts::{PI, TAU};

use whitefurnace::camera::Camera;
use whitefurnace::math::frame::from_spherical;
use whitefurnace::render::{LaneEstimator, LaneRenderer, Precision, check_single_precision};
use whitefurnace::scene::simple::closed_cube;

use super::memory::resident;
use super::{least_seconds, pool, record_rate, rendered, samples};
use crate::experiments::prelude::*;

/// Records samples per second with 1, 2, 4 ... threads and all, and the ratio of all to one.
pub(super) fn with_threads(run: &mut Run) -> Result<(), Error> {
    let all = rayon::current_num_threads();
    let job = Job {
        size: run.by_tier([64, 48], [256, 192]),
        spp: 16,
        ..Job::default()
    };
    let mut one = None;
    let powers = (0..)
        .map(|power| 1 << power)
        .take_while(|&threads| threads < all);
    for threads in powers.chain([all]) {
        let (film, seconds) = rendered(run, &pool(threads)?, job, "threads")?;
        let rate = samples(&film) / seconds;
        let ratio = rate / *one.get_or_insert(rate);
        record_rate(run, &format!("scaling.{threads}"), rate);
        run.number(&format!("scaling.{threads}.ratio"), ratio);
        if threads == all {
            run.number("scaling.all.ratio", ratio);
        }
    }
    Ok(())
}

/// Records microseconds per sample on one thread, at several numbers of samples and of pixels.
pub(super) fn with_samples(run: &mut Run) -> Result<(), Error> {
    let pool = pool(1)?;
    let sides = run.by_tier(
        [[16, 12], [32, 24], [64, 48]],
        [[64, 48], [256, 192], [1024, 768]],
    );
    let of = |size, spp| Job {
        size,
        spp,
        ..Job::default()
    };
    let by_samples = [1, 8, 64].map(|spp| (format!("samples.{spp}"), of(sides[1], spp)));
    let by_size = ["small", "middle", "large"].into_iter().zip(sides);
    let by_size = by_size.map(|(size, side)| (format!("pixels.{size}"), of(side, 4)));
    for (key, job) in by_samples.into_iter().chain(by_size) {
        let (film, seconds) = rendered(run, &pool, job, "growth")?;
        let microseconds = 1e6 * seconds / samples(&film);
        let pixels = film.pixels().len() as f64;
        run.numbers(
            &key,
            [
                ("pixels", pixels),
                ("spp", f64::from(job.spp)),
                ("microseconds", microseconds),
            ],
        );
        run.note(
            &key,
            format!(
                "{microseconds:.3} µs/sample, {pixels} pixels, {} spp",
                job.spp
            ),
        );
    }
    Ok(())
}

/// Records for scenes with growing numbers of triangles the build time, the program's memory, and
/// samples per second on one thread by the engines.
pub(super) fn with_triangles(run: &mut Run) -> Result<(), Error> {
    let pool = pool(1)?;
    let mut rates = [Vec::new(), Vec::new()];
    for about in [24, 60, 100, 1_000, 10_000, 100_000, 1_000_000]
        .into_iter()
        .take(run.by_tier(5, 7))
    {
        let (vertices, triangles) = waves(about);
        let (scene, seconds) = least_seconds(run, || in_a_room(&vertices, &triangles))?;
        let count = scene.primitives().count() as f64;
        let key = format!("triangles.{about}");
        run.numbers(&key, [("count", count), ("seconds", seconds)]);
        let memory = resident();
        run.numbers(&key, memory.map(|megabytes| ("megabytes", megabytes)));
        let memory = memory.map_or(String::new(), |megabytes| {
            format!(", the program has {megabytes:.0} MB")
        });
        run.note(
            &key,
            format!("{count} triangles, built in {seconds:.4} s{memory}"),
        );
        let lanes = |precision| LaneRenderer {
            estimator: LaneEstimator::Path(Path::new(Strategy::Mis)),
            sampling: random_points(run.seed()),
            precision,
        };
        let [double, single] = [Precision::Double, Precision::Single].map(lanes);
        for ((engine, renderer), points) in [("mis", double), ("mis-single", single)]
            .into_iter()
            .zip(&mut rates)
        {
            // With very many triangles they are too small for single precision.
            if engine == "mis-single" && check_single_precision(&scene).is_err() {
                continue;
            }
            let job = run.with_run_options(Job {
                size: run.by_tier([48, 36], [192, 144]),
                ..Job::default()
            });
            let (film, seconds) = least_seconds(run, || {
                let film = Film::new(job.size, None, 1)?;
                pool.install(|| render_film(&renderer, &scene, film, 8))
            })?;
            let rate = samples(&film) / seconds;
            record_rate(run, &format!("{key}.{engine}"), rate);
            points.push([count, rate / 1e6]);
        }
    }
    chart(run, &rates)
}

fn chart(run: &mut Run, rates: &[Vec<[f64; 2]>; 2]) -> Result<(), Error> {
    let points = || rates.iter().flatten();
    let largest = points().map(|point| point[0]).fold(0.0, f64::max);
    let [low, high] =
        [f64::min, f64::max].map(|of| points().map(|point| point[1]).reduce(of).unwrap_or(1.0));
    let ranges = [[10.0, 2.0 * largest], [low / 2.0, 2.0 * high]];
    let labels = [
        ("eight paths at a time", 2),
        ("sixteen in single precision", 1),
    ];
    let series = labels
        .into_iter()
        .zip(rates)
        .flat_map(|((label, colour), points)| {
            [Mark::Line, Mark::Points].map(|mark| {
                Series::new(
                    if mark == Mark::Line { label } else { "" },
                    colour,
                    mark,
                    points.iter().copied(),
                )
            })
        });
    let axes = [
        "triangles of the scene",
        "million camera samples per second",
    ];
    let title = "A scene of many triangles, on one thread";
    let chart = Chart::new(title, axes, ranges, series.collect()).log([true, true]);
    let description = "Two falling curves on logarithmic axes: sixteen paths in single precision are faster than eight in double \
               precision. Up to 64 triangles all are tested; among more, rays go through the hierarchy, and both curves \
               fall slowly.";
    charts(run, "triangles.svg", description, 520, &[chart])
}

/// Returns a wavy sphere with about `triangles` triangles less those of its room.
pub(crate) fn waves(triangles: u32) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let wanted = f64::from(triangles.saturating_sub(OF_THE_ROOM).max(10));
    let bands = (wanted / 4.0).sqrt() as u32;
    let columns = (wanted / f64::from(2 * bands)).round() as u32;
    let ring = |band: u32| {
        let theta = PI * f64::from(band) / f64::from(bands + 1);
        (0..columns).map(move |column| {
            let phi = TAU * f64::from(column) / f64::from(columns);
            from_spherical(theta, phi) * (2.0 + 0.2 * (8.0 * theta).sin() * (9.0 * phi).cos())
        })
    };
    let poles = [2.0, -2.0].map(|z| DVec3::new(0.0, 0.0, z));
    let vertices = poles
        .into_iter()
        .chain((1..=bands).flat_map(ring))
        .collect();
    let at = |band: u32, column: u32| 2 + band * columns + column % columns;
    let caps = (0..columns).flat_map(|c| {
        [
            [0, at(0, c), at(0, c + 1)],
            [1, at(bands - 1, c + 1), at(bands - 1, c)],
        ]
    });
    let quads = (0..bands - 1).flat_map(|b| (0..columns).map(move |c| (b, c)));
    let sides = quads.flat_map(|(b, c)| {
        let [p, q, r, s] = [at(b, c), at(b, c + 1), at(b + 1, c), at(b + 1, c + 1)];
        [[p, r, s], [p, s, q]]
    });
    (vertices, caps.chain(sides).collect())
}

/// Number of triangles of walls and light.
const OF_THE_ROOM: u32 = 12 + 2;

/// Builds a closed room with a mesh under a square light.
pub(crate) fn in_a_room(vertices: &[DVec3], triangles: &[[u32; 3]]) -> Result<Scene, Error> {
    let mut scene = SceneBuilder::new("waves");
    let [wall, clay] = [0.5, 0.8].map(|albedo| {
        scene.surface(Surface::new(Bsdf::Lambert {
            albedo: DVec3::splat(albedo),
        }))
    });
    let light = scene.surface(Surface::new(Bsdf::Black).emitting(DVec3::splat(4.0)));
    closed_cube(&mut scene, 5.0, true, wall);
    scene.rectangle(
        DVec3::new(-2.0, -2.0, 4.9),
        [4.0 * DVec3::Y, 4.0 * DVec3::X],
        light,
    );
    scene.mesh(vertices, triangles, clay);
    scene.build(Camera::new(
        DVec3::new(0.0, -4.9, 1.0),
        DVec3::ZERO,
        DVec3::Z,
        0.7,
    ))
}
