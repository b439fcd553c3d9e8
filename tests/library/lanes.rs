//! The lane engine has the bits of the readable one: each function that both use, and whole images.

use std::array::from_fn;

use whitefurnace::bsdf::ggx::Ggx;
use whitefurnace::bsdf::{Model, oren_nayar};
use whitefurnace::estimator::{Heuristic, Path, Strategy as Finds, Whitted};
use whitefurnace::fresnel::{mirror, radiance_factor, reflectance, reflectance_p, reflectance_s, refracted};
use whitefurnace::lanes::EightRays;
use whitefurnace::light_pick::{pick, share, share_all};
use whitefurnace::radiometry::{balance, cosine, power, reflected, solid_angle_per_area};
use whitefurnace::real::{
    EightSingles, LANES, Lanes, Lanes3, Mask, Real, SINGLES, Singles, Vector, Wide, WideMask, WideVector,
    sin_cos_of_turn,
};
use whitefurnace::render::{LaneEstimator, OneRayPerHit, render_lanes};
use whitefurnace::roulette;
use whitefurnace::sampling::{sphere_zone, triangle, uniform_hemisphere_pdf};
use whitefurnace::shape::{sphere_roots, triangle_point};
use whitefurnace::watertight::{Shear, Turn};

use crate::prelude::*;

/// A function of up to 16 numbers, for one ray or for several.
pub trait Kernel {
    fn run<R: Real>(x: &[R]) -> Vec<R>
    where
        R::Vector: Turn;
}

/// What is asked of every kernel.
pub trait Question {
    fn ask<K: Kernel>(&mut self, name: &str);
}

macro_rules! kernels {
    ($($name:ident: |$x:ident| $body:expr;)*) => {
        $(
            struct $name;
            impl Kernel for $name {
                fn run<R: Real>($x: &[R]) -> Vec<R>
                where
                    R::Vector: Turn,
                {
                    $body.into_iter().collect()
                }
            }
        )*
        /// Asks this of every kernel.
        pub fn of_every_kernel(question: &mut impl Question) {
            $(question.ask::<$name>(stringify!($name));)*
        }
    };
}

fn v<R: Real>(x: &[R]) -> R::Vector {
    R::Vector::of([x[0], x[1], x[2]])
}

fn ray<R: Real>(x: &[R]) -> Ray<R::Vector> {
    Ray::new(v(x), v(&x[3..]))
}

fn truth<R: Real>(mask: R::Mask) -> R {
    R::choose(mask, R::splat(1.0), R::splat(0.0))
}

fn zone() -> Sphere {
    Sphere { centre: DVec3::new(0.3, -0.2, 0.1), radius: 0.7, zone: [-0.4, 0.5], inward: true }
}

const CORNERS: [DVec3; 3] = [DVec3::new(-0.4, 0.1, 0.3), DVec3::new(0.9, -0.2, 0.0), DVec3::new(0.2, 0.8, -0.5)];

kernels! {
    Operations: |x| [x[0].abs(), x[0].copysign(x[1]), x[0].floor(), x[0].at_least(x[1]), x[0].at_most(x[1]),
        x[0].recip(), x[0].sqrt(), truth(x[0].below(x[1])), truth(x[0].above(x[1])), truth(x[0].equals(x[1])),
        truth(!x[0].below(x[1]) & (x[0].equals(x[2]) | x[1].above(x[2])))];
    Turns: |x| { let (sin, cos) = sin_cos_of_turn(x[0]); [sin, cos] };
    Interface: |x| [reflectance_s(x[0], x[1], x[2]), reflectance_p(x[0], x[1], x[2]), reflectance(x[0], x[1], x[2]),
        radiance_factor(x[1], x[2])];
    Mirror: |x| mirror(v(x), v(&x[3..])).components();
    Refracted: |x| {
        let (direction, passes) = refracted(v(x), v(&x[3..]), x[6], x[7]);
        [direction.components(), [truth(passes); 3]].concat()
    };
    Measures: |x| [cosine(v(x), v(&x[3..])), solid_angle_per_area(x[0], x[1]), balance(x[0], x[1]), power(x[0], x[1])];
    Reflected: |x| reflected::<R::Vector>(v(x), v(&x[3..]), x[6], x[7]).components();
    Directions: |x| [uniform_hemisphere([x[0], x[1]]).components(),
        cosine_hemisphere([x[0], x[1]]).components(), sphere_zone([x[0], x[1]], 0.7, [-0.3, 0.6]).components(),
        [uniform_hemisphere_pdf(x[0]), cosine_hemisphere_pdf(x[0]), x[0]]].concat();
    Triangle: |x| { let [u, w] = triangle([x[0], x[1]]); [&[u, w][..], &triangle_point(CORNERS, u, w).components()].concat() };
    Roulettes: |x| [roulette::by_throughput(v(x), x[3].below(x[4])), roulette::by_absorption(x[0]), roulette::weight(x[0]),
        truth(roulette::survives(x[0], x[1]))];
    Diffuse: |x| {
        let constants = || OrenNayar { a: x[6], b: x[7] };
        let bracket = |form| oren_nayar(constants(), form, v(x), v(&x[3..]));
        [&lambert(v(x)).components()[..], &[bracket(OrenNayarForm::Corrected), bracket(OrenNayarForm::Printed)]].concat()
    };
    Frames: |x| {
        let frame = Frame::<R::Vector>::new(v(x));
        [frame.x, frame.y, frame.z, frame.local(v(&x[3..])), frame.world(v(&x[3..]))].map(Vector::components).concat()
    };
    Cameras: |x| {
        let camera = Camera::new(DVec3::new(-2.0, 0.1, 0.2), DVec3::ZERO, DVec3::Z, 0.4);
        let ray = camera.ray([40, 30], x[0], x[1]);
        [ray.origin, ray.direction, ray.at(x[2])].map(Vector::components).concat()
    };
    Spheres: |x| {
        let (roots, meets) = sphere_roots(&ray(x), DVec3::new(0.3, -0.2, 0.1), 0.7);
        [&roots[..], &[truth(meets), zone().distance(&ray(x))], &zone().normal::<R::Vector>(v(x)).components()].concat()
    };
    Watertight: |x| {
        let shear = Shear::new(&ray(x));
        let corner = |c: DVec3| shear.project(&[c.x, c.y, c.z, 0.0].map(R::splat));
        let [a, b, c] = CORNERS.map(corner);
        let hit = shear.hit([&a, &b, &c]);
        // A miss has no weights.
        let hits = hit.t.below(R::splat(f64::INFINITY));
        [&[hit.t][..], &hit.weights.map(|w| R::choose(hits, w, R::splat(0.0)))].concat()
    };
    Emitters: |x| {
        let shapes = [EmitterShape::Rectangle { corner: CORNERS[0], edges: [DVec3::X, DVec3::new(0.1, 0.9, 0.2)] },
            EmitterShape::Triangle(CORNERS), EmitterShape::Sphere(zone())];
        let points = shapes.map(|shape| Emitter::new(shape, DVec3::ONE).sample([x[0], x[1]]));
        points.map(|p| [p.point.components(), p.normal.components()].concat()).concat()
    };
    Picks: |x| {
        let emitters = [EmitterShape::Rectangle { corner: CORNERS[0], edges: [DVec3::X, DVec3::new(0.1, 0.9, 0.2)] },
            EmitterShape::Triangle(CORNERS), EmitterShape::Sphere(zone())].map(|shape| Emitter::new(shape, DVec3::ONE));
        let from = v(&x[1..]);
        let mut shares = [x[0]; 3];
        share_all(|i| emitters[i].contribution(from), &mut shares);
        let (index, picked) = pick(&shares, x[0]);
        [index, picked, share(|i| emitters[i].contribution(from), 3, x[4].floor()), shares[0], shares[1], shares[2]]
    };
}

/// Whether a kernel has the same bits for a ray alone and for the same ray in a lane.
struct SameBits([[f64; 16]; LANES]);

impl Question for SameBits {
    fn ask<K: Kernel>(&mut self, name: &str) {
        let lanes: [Lanes; 16] = from_fn(|i| Lanes::new(from_fn(|lane| self.0[lane][i])));
        let together = K::run(&lanes);
        for (lane, x) in self.0.iter().enumerate() {
            for (i, (alone, together)) in K::run(x).into_iter().zip(&together).enumerate() {
                let together = together.to_array()[lane];
                let same = alone.to_bits() == together.to_bits() || alone.is_nan() && together.is_nan();
                assert!(same, "{name}: result {i} is {alone:e} alone and {together:e} in lane {lane}, at {x:?}");
            }
        }
    }
}

/// Numbers at the edges of what equations expect, and beyond.
const EDGES: [[f64; 7]; 2] = [
    [0.0, 0.125, 0.375, 0.5, 1.0, 1.5, 2.5e-17],
    [5e-324, 1e-300, 1e300, f64::EPSILON, 1.0 - f64::EPSILON, f64::INFINITY, f64::NAN],
];

#[test]
fn functions_have_the_same_bits_in_every_lane() {
    let mut rng = rng("lanes");
    for round in 0..4_000 {
        // A third of all rounds draws from the edges, a third mixes, a third is of unit vectors and shares.
        let arguments = from_fn(|_| {
            let edges = [1.0, 0.3, 0.0][round % 3];
            let mut x = [0.0; 16].map(|_: f64| {
                let [row, place, sign] = [2.0, 7.0, 2.0].map(|n: f64| (uniform(&mut rng) * n) as usize);
                let edge = EDGES[row][place] * [1.0, -1.0][sign];
                if uniform(&mut rng) < edges { edge } else { between(&mut rng, -1.2, 1.2) }
            });
            if round % 3 == 2 {
                let [a, b] = [unit_vector(&mut rng), unit_vector(&mut rng)];
                x[..3].copy_from_slice(&a.to_array());
                x[3..6].copy_from_slice(&b.to_array());
                (x[6], x[7]) = (between(&mut rng, 1.0, 2.0), 1.0);
            }
            x
        });
        of_every_kernel(&mut SameBits(arguments));
    }
}

/// A share of a turn: against the library of the platform over the whole domain.
#[test]
fn sines_of_turns_are_within_their_bound() {
    let bound = 4e-16;
    let shares = (0..=1_000_000).map(|i| f64::from(i) / 1_000_000.0);
    let mut worst = 0.0_f64;
    for share in shares {
        let (sin, cos) = sin_cos_of_turn(share);
        // The platform's argument is rounded; near a quarter turn it is taken from there.
        let quarter = (share * 4.0).round();
        let (s, c) = ((share - quarter / 4.0) * TAU).sin_cos();
        let (s, c) = match quarter as u32 % 4 {
            0 => (s, c),
            1 => (c, -s),
            2 => (-s, -c),
            _ => (-c, s),
        };
        worst = worst.max((sin - s).abs()).max((cos - c).abs());
    }
    assert!(worst <= bound, "{worst:e}");
    assert_eq!(sin_cos_of_turn(0.25), (1.0, 0.0));
}

#[test]
fn masks_are_lane_by_lane() {
    fn check<R: Wide<N>, const N: usize>() {
        let all = u32::MAX >> (32 - N);
        for bits in 0..=all {
            let mask = R::Mask::from_bits(bits);
            assert_eq!((mask.bits(), (!mask).bits(), mask.any()), (bits, all - bits, bits != 0));
            assert_eq!(R::Mask::from_fn(|lane| bits >> lane & 1 == 1).bits(), bits);
            let chosen = R::choose(mask, R::from_lanes(|lane| lane as f64), R::splat(-1.0));
            assert!((0..N).all(|i| chosen.lane(i) == if bits >> i & 1 == 1 { i as f64 } else { -1.0 }));
        }
        assert_eq!((R::Mask::splat(true).bits(), R::Mask::splat(false).bits()), (all, 0));
    }
    check::<Lanes, LANES>();
    check::<EightSingles, LANES>();
    check::<Singles, SINGLES>();
}

/// A room with every kind of surface and light: the report's walls, mirror and glass, a rough metal, EON, a light that
/// is a triangle, one that is a sphere, and a background through a gap.
fn crowded() -> Scene {
    let mut s = SceneBuilder::new("crowded");
    s.background(DVec3::new(0.1, 0.2, 0.3));
    let walls = [
        Bsdf::Lambert { albedo: DVec3::new(0.7, 0.5, 0.3) },
        Bsdf::oren_nayar(DVec3::splat(0.8), 0.5, OrenNayarForm::Corrected),
        Bsdf::oren_nayar(DVec3::splat(0.6), 0.3, OrenNayarForm::Printed),
        Bsdf::Eon { albedo: DVec3::new(0.9, 0.8, 0.2), roughness: 0.7 },
        Bsdf::Black,
    ];
    let corners = [
        (DVec3::new(-1.0, -1.0, -1.0), [2.0 * DVec3::X, 2.0 * DVec3::Y]),
        (DVec3::new(-1.0, -1.0, -1.0), [2.0 * DVec3::Y, 2.0 * DVec3::Z]),
        (DVec3::new(-1.0, 1.0, -1.0), [2.0 * DVec3::X, 2.0 * DVec3::Z]),
        (DVec3::new(1.0, -1.0, -1.0), [2.0 * DVec3::Z, 2.0 * DVec3::Y]),
        (DVec3::new(-1.0, -1.0, 1.0), [DVec3::X, 2.0 * DVec3::Y]),
    ];
    for (bsdf, (corner, edges)) in walls.into_iter().zip(corners) {
        let surface = s.surface(Surface::new(bsdf));
        s.rectangle(corner, edges, surface);
    }
    let light = s.surface(Surface::new(Bsdf::Black).emitting(DVec3::new(9.0, 8.0, 7.0)));
    s.mesh(&[DVec3::new(0.2, 0.0, 0.9), DVec3::new(0.2, 0.4, 0.9), DVec3::new(0.6, 0.0, 0.8)], &[[0, 1, 2]], light);
    s.sphere(Sphere::new(DVec3::new(-0.6, 0.5, 0.5), 0.1), light);
    s.rectangle(DVec3::new(0.4, 0.7, 0.2), [0.2 * DVec3::X, 0.2 * DVec3::Z], light);
    // It stands before a light.
    let blind = s.surface(Surface::new(walls[0]));
    s.mesh(&[DVec3::new(0.2, 0.1, 0.8), DVec3::new(0.2, 0.4, 0.8), DVec3::new(0.5, 0.1, 0.7)], &[[0, 1, 2]], blind);
    for (x, bsdf) in [
        (-0.5, Bsdf::Mirror { reflectance: DVec3::splat(0.9) }),
        (0.1, Bsdf::Glass { index: 1.5 }),
        (0.6, Bsdf::model(Ggx { reflectance: DVec3::new(0.9, 0.6, 0.3), alpha: 0.3 })),
    ] {
        let surface = s.surface(Surface::new(bsdf));
        s.sphere(Sphere::new(DVec3::new(x, -0.1, -0.6), 0.28), surface);
    }
    s.build(Camera::new(DVec3::new(0.0, -3.5, 0.0), DVec3::ZERO, DVec3::Z, 0.4)).expect("a legal scene")
}

/// A ball of so many triangles that shine that they are in groups, and a lamp.
fn glowing() -> Scene {
    let mut s = SceneBuilder::new("glowing");
    let grey = s.surface(Surface::new(Bsdf::Lambert { albedo: DVec3::splat(0.6) }));
    let [glow, lamp] = [0.5, 9.0].map(|l| s.surface(Surface::new(Bsdf::Black).emitting(DVec3::splat(l))));
    let at = |i: u32, j: u32| {
        let [theta, phi] = [PI * f64::from(i) / 6.0, TAU * f64::from(j) / 10.0];
        0.5 * from_spherical(theta, phi)
    };
    let vertices: Vec<DVec3> = (0..=6).flat_map(|i| (0..10).map(move |j| at(i, j))).collect();
    let face = |i: u32, j: u32| {
        let [a, b] = [10 * i + j, 10 * i + (j + 1) % 10];
        if i == 0 { vec![[a, a + 10, b + 10]] } else { vec![[a, a + 10, b], [b, a + 10, b + 10]] }
    };
    let faces: Vec<[u32; 3]> = (0..5).flat_map(|i| (0..10).flat_map(move |j| face(i, j))).collect();
    s.mesh(&vertices, &faces, glow);
    s.rectangle(DVec3::new(-1.0, -1.0, -1.0), [2.0 * DVec3::X, 2.0 * DVec3::Y], grey);
    s.rectangle(DVec3::new(-0.3, -0.3, 1.0), [0.6 * DVec3::Y, 0.6 * DVec3::X], lamp);
    s.build(Camera::new(DVec3::new(0.0, -3.5, 0.0), DVec3::ZERO, DVec3::Z, 0.4)).expect("a legal scene")
}

/// So many triangles that the lanes leave them to the hierarchy, and a ball of glass.
fn many(count: u32) -> Scene {
    let mut s = SceneBuilder::new("many");
    let [grey, light] = [
        Surface::new(Bsdf::Lambert { albedo: DVec3::splat(0.6) }),
        Surface::new(Bsdf::Black).emitting(DVec3::splat(4.0)),
    ]
    .map(|surface| s.surface(surface));
    let glass = s.surface(Surface::new(Bsdf::Glass { index: 1.5 }));
    s.sphere(Sphere::new(DVec3::new(0.1, 0.0, 0.7), 0.35), glass);
    let (mut rng, size) = (rng("many"), 3.0 / f64::from(count).sqrt());
    for _ in 0..count {
        let corner = in_cube(&mut rng, 1.0);
        s.mesh(
            &[corner, corner + size * in_cube(&mut rng, 1.0), corner + size * in_cube(&mut rng, 1.0)],
            &[[0, 1, 2]],
            grey,
        );
    }
    s.sphere(Sphere::new(DVec3::new(0.0, 0.0, 1.5), 0.4), light);
    s.build(Camera::new(DVec3::new(0.0, -3.5, 0.0), DVec3::ZERO, DVec3::Z, 0.4)).expect("a legal scene")
}

/// A net of triangles that shine differently, whose edges and vertices are met by the rays through the centres of
/// pixels. A sphere, before or after them in the scene, touches it at the vertex that the middle ray meets.
fn net(sphere_first: bool) -> Scene {
    let mut s = SceneBuilder::new("net");
    let emitting = |radiance: f64| Surface::new(Bsdf::Black).emitting(DVec3::splat(radiance));
    let grey = s.surface(Surface::new(Bsdf::Lambert { albedo: DVec3::splat(0.5) }));
    let touching = Sphere::new(DVec3::new(0.0, 0.5, 0.0), 0.5);
    if sphere_first {
        s.sphere(touching, grey);
    }
    let place = |i: u32| f64::from(i) / 8.0 - 0.25;
    let vertices: Vec<DVec3> = (0..36).map(|i| DVec3::new(place(i % 6), 0.0, place(i / 6))).collect();
    for (cell, shine) in (0..36).filter(|cell| cell % 6 < 5 && cell / 6 < 5).zip(1..) {
        for (triangle, more) in [([cell, cell + 1, cell + 7], 0.0), ([cell, cell + 7, cell + 6], 0.5)] {
            let surface = s.surface(emitting(f64::from(shine) + more));
            s.mesh(&vertices, &[triangle], surface);
        }
    }
    if !sphere_first {
        s.sphere(touching, grey);
    }
    s.build(Camera::new(DVec3::new(0.0, -1.0, 0.0), DVec3::ZERO, DVec3::Z, 8.5 / 16.0)).expect("a legal scene")
}

fn assert_same_film(scene: &Scene, lanes: LaneEstimator, sampling: Sampling, window: Option<Window>) {
    let film = Film::new([23, 17], window, sampling.samples_per_replication()).expect("a legal size");
    assert_same(scene, lanes, sampling, film.clone());
    if matches!(sampling.numbers, Numbers::Sobol(_)) {
        let mut film = film;
        film.set_sample_counts((0..film.pixels().len() as u32).map(|at| 1 + at % 7).collect());
        assert_same(scene, lanes, sampling, film);
    }
}

/// The same of an empty film.
fn assert_same(scene: &Scene, lanes: LaneEstimator, sampling: Sampling, empty: Film) {
    let (mut alone, mut together) = (empty.clone(), empty);
    let replications = 5;
    for range in [0..1, 1..replications] {
        match lanes {
            LaneEstimator::Path(path) => render(scene, &path, sampling, &mut alone, &range, &|_| true),
            LaneEstimator::Report(OneRayPerHit { segments, rules }) => {
                let report = Report { parts: Standard, rays: 1, segments, rules };
                render(scene, &report, sampling, &mut alone, &range, &|_| true)
            }
            LaneEstimator::Whitted(whitted) => render(scene, &whitted, sampling, &mut alone, &range, &|_| true),
        }
        .expect("legal values");
        render_lanes(scene, lanes, sampling, &mut together, &range, &|_| true).expect("legal values");
    }
    assert!(alone == together, "{} by {lanes:?}, {sampling:?}", scene.name());
    // A window may see nothing.
    assert!(alone.size() != alone.frame() || alone.mean() > 0.0, "{} by {lanes:?}, {sampling:?}", scene.name());
}

/// Lights that are seen in mirrors that face each other, in one that shines, and in a sphere.
fn mirrors() -> Scene {
    let mut s = SceneBuilder::new("mirrors");
    s.background(DVec3::new(0.1, 0.2, 0.3));
    let light = s.surface(Surface::new(Bsdf::Black).emitting(DVec3::new(3.0, 2.0, 1.0)));
    let grey = s.surface(Surface::new(Bsdf::Lambert { albedo: DVec3::splat(0.5) }));
    let mirror = |r: f64| Surface::new(Bsdf::Mirror { reflectance: DVec3::new(r, 0.9, 0.8) });
    let [dark, bright] = [mirror(0.7), mirror(0.9).emitting(DVec3::splat(0.2))].map(|surface| s.surface(surface));
    let across = [4.0 * DVec3::X, 2.0 * DVec3::Z];
    s.rectangle(DVec3::new(-2.0, 1.5, -1.0), across, dark);
    s.rectangle(DVec3::new(-2.0, -1.5, -1.0), across, dark);
    s.rectangle(DVec3::new(-2.0, -1.5, -1.0), [4.0 * DVec3::X, 3.0 * DVec3::Y], grey);
    s.rectangle(DVec3::new(1.0, -0.5, -1.0), [DVec3::Y, DVec3::Z], bright);
    s.rectangle(DVec3::new(-0.4, -1.0, 0.9), [0.8 * DVec3::Y, 0.7 * DVec3::X], light);
    s.sphere(Sphere::new(DVec3::new(-0.6, 0.9, -0.6), 0.4), dark);
    s.build(Camera::new(DVec3::new(0.1, -0.2, 0.0), DVec3::Y, DVec3::Z, 0.8)).expect("a legal scene")
}

/// Scenes with every surface, light and shape, in all ways in which lanes search for hits.
pub fn scenes() -> Vec<Scene> {
    vec![
        crowded(),
        many(100),
        glowing(),
        many(1600),
        net(false),
        net(true),
        mirrors(),
        room::report(Convention::Physical, OrenNayarForm::Corrected).expect("a scene"),
        room::diffuse().expect("a scene"),
        simple::environment().expect("a scene"),
        simple::cornell().expect("a scene"),
        simple::cavity_cap(0.75, Cap::Reflecting).expect("a scene"),
        simple::glass_cube(false).expect("a scene"),
        simple::furnace_box(0.75).expect("a scene"),
    ]
}

#[test]
fn images_have_the_same_bits() {
    let scenes = scenes();
    let seed = seed_for(master(), "lanes");
    let plain = Sampling { pixel: Random, numbers: Numbers::Independent, seed, outlines: false };
    for scene in &scenes {
        for strategy in [Finds::Bsdf, Finds::Light, Finds::Mis] {
            for (lights, heuristic) in [
                (LightSampling::Area, Heuristic::Balance),
                (LightSampling::SolidAngle, Heuristic::Power),
                (LightSampling::ByContribution, Heuristic::Power),
            ] {
                let path = Path { lights, heuristic, ..Path::new(Standard, strategy) };
                assert_same_film(scene, LaneEstimator::Path(path), plain, None);
            }
        }
        let path = LaneEstimator::Path(Path { early: 2, ..Path::new(Standard, Finds::Mis) });
        let report = |segments, rules| LaneEstimator::Report(OneRayPerHit { segments, rules });
        let whitted = |segments, rules| LaneEstimator::Whitted(Whitted { segments, ..Whitted::new(rules) });
        for segments in [0, 1, 2, 7] {
            assert_same_film(scene, report(segments, LightRules::PHYSICAL), plain, None);
            assert_same_film(scene, whitted(segments, LightRules::PHYSICAL), plain, None);
        }
        assert_same_film(scene, report(7, LightRules::REPORT), plain, None);
        assert_same_film(scene, whitted(7, LightRules::REPORT), plain, None);
        // Under the other rules behind glass.
        for (shadows_pass_glass, caustics) in [(true, true), (false, false)] {
            let rules = LightRules { shadows_pass_glass, caustics, ..LightRules::PHYSICAL };
            assert_same_film(scene, report(20, rules), plain, None);
        }
        for (pixel, numbers, outlines) in [
            (Random, Numbers::Sobol(4), false),
            (Random, Numbers::Sobol(3), true),
            (Centre, Numbers::Independent, false),
            (Grid(2), Numbers::Independent, false),
            (Jitter(3), Numbers::Independent, true),
        ] {
            for lanes in [path, report(7, LightRules::PHYSICAL), whitted(7, LightRules::PHYSICAL)] {
                assert_same_film(scene, lanes, Sampling { pixel, numbers, seed, outlines }, None);
            }
        }
        assert_same_film(scene, path, plain, Some(Window { corner: [3, 4], size: [9, 2] }));
    }
}

/// A model whose f_r is this number where light arrives from negative x, and 1 elsewhere.
#[derive(Debug)]
struct Broken(f64);

impl Model for Broken {
    fn eval(&self, _: DVec3, wi: DVec3) -> DVec3 {
        DVec3::splat(if wi.x < 0.0 { self.0 } else { 1.0 })
    }
    fn sample(&self, _: DVec3, random: [f64; 2]) -> Option<DVec3> {
        Some(cosine_hemisphere(random))
    }
    fn pdf(&self, _: DVec3, wi: DVec3) -> f64 {
        cosine_hemisphere_pdf(wi.z)
    }
    fn albedo(&self) -> DVec3 {
        DVec3::ONE
    }
}

/// Of one sample, too, that the mean of its replication would hide.
#[test]
fn what_is_no_radiance_is_an_error_at_its_pixel() {
    for wrong in [f64::NAN, 6e6] {
        let mut s = SceneBuilder::new("broken");
        s.background(DVec3::ONE);
        let surface = s.surface(Surface::new(Bsdf::model(Broken(wrong))));
        s.sphere(Sphere::new(DVec3::ZERO, 1.0), surface);
        let camera = Camera::new(DVec3::new(0.0, -3.5, 0.0), DVec3::ZERO, DVec3::Z, 0.2);
        let scene = s.build(camera).expect("a legal scene");
        let sampling = Sampling { pixel: Jitter(4), numbers: Numbers::Independent, seed: 1, outlines: false };
        let path = Path::new(Standard, Finds::Mis);
        let film = || Film::new([1, 1], None, 16).expect("a legal size");
        let alone = render(&scene, &path, sampling, &mut film(), &(0..1), &|_| true).expect_err("a wrong value");
        let together = render_lanes(&scene, LaneEstimator::Path(path), sampling, &mut film(), &(0..1), &|_| true)
            .expect_err("a wrong value");
        assert_eq!(together.to_string(), alone.to_string());
        assert!(alone.to_string().contains("at pixel (0, 0), replication 0"), "{alone}");
    }
}

/// Rows are counted as they are done, a run that is stopped says so, and a film of another kind is refused.
#[test]
fn rows_are_reported() {
    let (scene, path) = (crowded(), LaneEstimator::Path(Path::new(Standard, Finds::Mis)));
    let sampling = Sampling { pixel: Random, numbers: Numbers::Independent, seed: 1, outlines: false };
    let mut film = Film::new([8, 6], None, 1).expect("a legal size");
    let done = |samples| samples == 8 * 3;
    assert!(matches!(render_lanes(&scene, path, sampling, &mut film, &(0..3), &done), Ok(true)));
    assert!(matches!(render_lanes(&scene, path, sampling, &mut film, &(3..4), &|_| false), Ok(false)));
    let wrong = Sampling { pixel: Grid(2), ..sampling };
    assert!(matches!(render_lanes(&scene, path, wrong, &mut film, &(4..5), &|_| true), Err(Error::Option(_))));
}

/// Eight rays at once are as far from what they meet as each alone.
#[test]
fn eight_rays_meet_what_each_meets() {
    let scene = simple::cornell().expect("a legal scene");
    let mut eight = EightRays::new(&scene).expect("few triangles");
    for k in 0..100 {
        let rays: [Ray; LANES] = from_fn(|i| {
            let mut rng = stream(9, k, i as u32);
            scene.camera().ray([8, 6], 8.0 * uniform(&mut rng), 6.0 * uniform(&mut rng))
        });
        let [origins, directions] = [Lanes3::from_fn(|i| rays[i].origin), Lanes3::from_fn(|i| rays[i].direction)];
        let together = eight.closest(&Ray::new(origins, directions));
        let alone = rays.map(|ray| scene.intersect(&ray).map_or(f64::INFINITY, |hit| hit.t));
        assert_eq!(together.to_array(), alone);
    }
}

/// Of a tetrahedron a ray meets two faces, one after the other for all lanes meet both, four vertices and six edges; if
/// it passes by it meets no face.
#[test]
fn operations_are_counted() {
    let vertices = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    let mut s = SceneBuilder::new("tetrahedron");
    let surface = s.surface(Surface::new(Bsdf::Black));
    s.mesh(&vertices, &[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], surface);
    let scene = s.build(Camera::new(DVec3::new(3.0, 3.0, 3.0), DVec3::ZERO, DVec3::Z, 0.2)).expect("a legal scene");
    let mut eight = EightRays::new(&scene).expect("few triangles");
    let towards = |target: DVec3| {
        let origin = DVec3::new(0.2, 0.3, 5.0);
        Ray::new(Lanes3::splat_vector(origin), Lanes3::splat_vector((target - origin).normalize()))
    };
    let all = 4 + 4 * 8 + 6 * 3;
    assert_eq!(eight.operations(&towards(DVec3::new(0.2, 0.3, 0.0))), all + 2 * (3 + 14));
    assert_eq!(eight.operations(&towards(DVec3::new(9.0, 0.3, 0.0))), all);
}
