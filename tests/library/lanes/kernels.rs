//! Tests that functions of one ray and of several have the same bits; also masks and sines of
//! turns.

use std::array::from_fn;

use whitefurnace::geometry::radiometry::{cosine, reflected, solid_angle_per_area};
use whitefurnace::geometry::shape::{sphere_roots, triangle_point};
use whitefurnace::geometry::watertight::Shear;
use whitefurnace::light::light_sampler::{pick, probabilities, probability};
use whitefurnace::material::fresnel::{
    radiance_factor, reflect, reflectance, reflectance_p, reflectance_s, refracted,
};
use whitefurnace::material::oren_nayar;
use whitefurnace::math::real::{Mask, Real, Vector, sin_cos_of_turn};
use whitefurnace::math::simd::{EightSingles, LANES, Lanes, PermuteAxes, SINGLES, Singles, Wide};
use whitefurnace::sampling::mis::{balance, power};
use whitefurnace::sampling::roulette;
use whitefurnace::sampling::warp::{sphere_zone, triangle, uniform_hemisphere_pdf};

use crate::prelude::*;

/// A function of up to 16 numbers, for one ray or for several.
pub trait Kernel {
    fn run<R: Real>(x: &[R]) -> Vec<R>
    where
        R::Vector: PermuteAxes;
}

/// A test to be made of every kernel.
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
                    R::Vector: PermuteAxes,
                {
                    $body.into_iter().collect()
                }
            }
        )*
        /// Applies a test to every kernel.
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
    R::select(mask, R::splat(1.0), R::splat(0.0))
}

fn zone() -> Sphere {
    Sphere {
        centre: DVec3::new(0.3, -0.2, 0.1),
        radius: 0.7,
        zone: [-0.4, 0.5],
        inward: true,
    }
}

const CORNERS: [DVec3; 3] = [
    DVec3::new(-0.4, 0.1, 0.3),
    DVec3::new(0.9, -0.2, 0.0),
    DVec3::new(0.2, 0.8, -0.5),
];

kernels! {
    Operations: |x| [x[0].abs(), x[0].copysign(x[1]), x[0].floor(), x[0].maximum(x[1]), x[0].minimum(x[1]),
        x[0].recip(), x[0].sqrt(), truth(x[0].cmplt(x[1])), truth(x[0].cmpgt(x[1])), truth(x[0].cmpeq(x[1])),
        truth(!x[0].cmplt(x[1]) & (x[0].cmpeq(x[2]) | x[1].cmpgt(x[2])))];
    Turns: |x| { let (sin, cos) = sin_cos_of_turn(x[0]); [sin, cos] };
    Interface: |x| [reflectance_s(x[0], x[1], x[2]), reflectance_p(x[0], x[1], x[2]), reflectance(x[0], x[1], x[2]),
        radiance_factor(x[1], x[2])];
    Mirror: |x| reflect(v(x), v(&x[3..])).components();
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
    Roulettes: |x| [roulette::by_throughput(v(x), x[3].cmplt(x[4])), roulette::by_absorption(x[0]), roulette::weight(x[0]),
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
        let corner = |c: DVec3| shear.project(c.to_array().map(R::splat));
        let [a, b, c] = CORNERS.map(corner);
        let hit = shear.hit([&a, &b, &c]);
        // A miss has no weights.
        let hits = hit.t.cmplt(R::splat(f64::INFINITY));
        [&[hit.t][..], &hit.weights.map(|w| R::select(hits, w, R::splat(0.0)))].concat()
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
        probabilities(|i| emitters[i].importance(from), &mut shares);
        let (index, picked) = pick(&shares, x[0]);
        [index, picked, probability(|i| emitters[i].importance(from), 3, x[4].floor()), shares[0], shares[1], shares[2]]
    };
}

/// Tests that a kernel has the same bits for a single ray and for that ray in a lane.
struct SameBits([[f64; 16]; LANES]);

impl Question for SameBits {
    fn ask<K: Kernel>(&mut self, name: &str) {
        let lanes: [Lanes; 16] = from_fn(|i| Lanes::new(from_fn(|lane| self.0[lane][i])));
        let together = K::run(&lanes);
        for (lane, x) in self.0.iter().enumerate() {
            for (i, (alone, together)) in K::run(x).into_iter().zip(&together).enumerate() {
                let together = together.to_array()[lane];
                let same =
                    alone.to_bits() == together.to_bits() || alone.is_nan() && together.is_nan();
                assert!(
                    same,
                    "{name}: result {i} is {alone:e} alone and {together:e} in lane {lane}, at {x:?}"
                );
            }
        }
    }
}

/// Numbers at the limits of the domains of equations, and beyond.
const EDGES: [[f64; 7]; 2] = [
    [0.0, 0.125, 0.375, 0.5, 1.0, 1.5, 2.5e-17],
    [
        5e-324,
        1e-300,
        1e300,
        f64::EPSILON,
        1.0 - f64::EPSILON,
        f64::INFINITY,
        f64::NAN,
    ],
];

#[test]
fn functions_have_the_same_bits_in_every_lane() {
    let mut rng = rng("lanes");
    for round in 0..4_000 {
        // A third of all rounds draws from the edges, a third mixes, and a third has unit vectors
        // and numbers from 0 to 1.
        let arguments = from_fn(|_| {
            let edges = [1.0, 0.3, 0.0][round % 3];
            let mut x = [0.0; 16].map(|_: f64| {
                let [row, place, sign] =
                    [2.0, 7.0, 2.0].map(|n: f64| (uniform(&mut rng) * n) as usize);
                let edge = EDGES[row][place] * [1.0, -1.0][sign];
                if uniform(&mut rng) < edges {
                    edge
                } else {
                    between(&mut rng, -1.2, 1.2)
                }
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

/// Compares sine and cosine of a fraction of a turn with the platform's library over the whole
/// domain.
#[test]
fn sines_of_turns_are_within_their_bound() {
    let bound = 4e-16;
    let shares = (0..=1_000_000).map(|i| f64::from(i) / 1_000_000.0);
    let mut worst = 0.0_f64;
    for share in shares {
        let (sin, cos) = sin_cos_of_turn(share);
        // The platform's argument is rounded, so it is reduced to the nearest quarter turn.
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
            assert_eq!(
                (mask.bits(), (!mask).bits(), mask.any()),
                (bits, all - bits, bits != 0)
            );
            assert_eq!(R::Mask::from_fn(|lane| bits >> lane & 1 == 1).bits(), bits);
            let chosen = R::select(mask, R::from_lanes(|lane| lane as f64), R::splat(-1.0));
            assert!(
                (0..N).all(|i| chosen.lane(i) == if bits >> i & 1 == 1 { i as f64 } else { -1.0 })
            );
        }
        assert_eq!(
            (R::Mask::splat(true).bits(), R::Mask::splat(false).bits()),
            (all, 0)
        );
    }
    check::<Lanes, LANES>();
    check::<EightSingles, LANES>();
    check::<Singles, SINGLES>();
}
