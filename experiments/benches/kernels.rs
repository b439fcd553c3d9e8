//! Time per kernel: `cargo bench -p experiments --bench kernels`, or with `-- NAME` those of a
//! name. The experiment `speed` times whole estimators and the rays of the room.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use glam::DVec3;
use whitefurnace::film::{Features, Pixel};
use whitefurnace::geometry::bvh::{Bvh, Primitive};
use whitefurnace::geometry::shape::{Ray, Sphere, moller_trumbore};
use whitefurnace::geometry::watertight::Shear;
use whitefurnace::material::{OrenNayar, OrenNayarForm, fresnel, oren_nayar};
use whitefurnace::math::frame::from_spherical;
use whitefurnace::sampling::rng::{stream, uniform, uniform2};
use whitefurnace::sampling::warp;

fn main() {
    divan::main();
}

/// Inputs per iteration: enough to defeat branch prediction, few enough for the cache.
const COUNT: u32 = 1024;

/// Runs `kernel` over the same random inputs again and again.
fn bench<I, O>(bencher: Bencher, input: impl Fn(u32) -> I, kernel: impl Fn(&I) -> O) {
    let inputs: Vec<I> = (0..COUNT).map(input).collect();
    bencher
        .counter(ItemsCount::new(COUNT))
        .bench_local(|| inputs.iter().for_each(|i| drop(black_box(kernel(i)))));
}

fn unit_vector(i: u32) -> DVec3 {
    let [r1, r2] = uniform2(&mut stream(1, 0, i));
    warp::sphere_zone([r1, r2], 1.0, [-1.0, 1.0])
}

fn upper(i: u32, high: u32) -> DVec3 {
    warp::uniform_hemisphere(uniform2(&mut stream(2, high, i)))
}

fn square(i: u32) -> [f64; 2] {
    uniform2(&mut stream(3, 0, i))
}

/// Rays towards the middle, of which about half meet a primitive of radius 1 there.
fn ray(i: u32) -> Ray {
    let mut rng = stream(4, 0, i);
    let target = DVec3::from_array([0; 3].map(|_| 2.0 * uniform(&mut rng) - 1.0));
    let origin = 3.0 * unit_vector(i);
    Ray::new(origin, (target - origin).normalize())
}

const TRIANGLE: [DVec3; 3] = [
    DVec3::new(-1.0, -1.0, 0.1),
    DVec3::new(1.0, -0.8, -0.2),
    DVec3::new(0.0, 1.0, 0.3),
];

#[divan::bench]
fn triangle_watertight(bencher: Bencher) {
    bench(bencher, ray, |ray| {
        Shear::new(ray).intersect(black_box(TRIANGLE), f64::INFINITY)
    });
}

#[divan::bench]
fn triangle_moller_trumbore(bencher: Bencher) {
    bench(bencher, ray, |ray| {
        moller_trumbore(ray, black_box(TRIANGLE))
    });
}

#[divan::bench]
fn sphere(bencher: Bencher) {
    let sphere = Sphere::new(DVec3::ZERO, 1.0);
    bench(bencher, ray, |ray| {
        black_box(&sphere).intersect(ray, f64::INFINITY)
    });
}

/// A wavy sphere of about 100 000 triangles.
fn large_mesh() -> Vec<Primitive> {
    const SIDE: u32 = 224;
    let at = |row: u32, column: u32| {
        let theta = std::f64::consts::PI * f64::from(row) / f64::from(SIDE);
        let phi = std::f64::consts::TAU * f64::from(column % SIDE) / f64::from(SIDE);
        from_spherical(theta, phi) * (1.0 + 0.1 * (8.0 * theta).sin() * (9.0 * phi).cos())
    };
    (0..SIDE * SIDE)
        .flat_map(|i| {
            let (row, column) = (i / SIDE, i % SIDE);
            let [a, b] = [at(row, column), at(row, column + 1)];
            let [c, d] = [at(row + 1, column), at(row + 1, column + 1)];
            [[a, c, d], [a, d, b]]
        })
        .map(Primitive::Triangle)
        .collect()
}

#[divan::bench]
fn large_mesh_closest(bencher: Bencher) {
    let bvh = Bvh::new(&large_mesh());
    bench(bencher, ray, |ray| bvh.closest(ray, f64::INFINITY));
}

#[divan::bench(sample_count = 5, sample_size = 1)]
fn large_mesh_build(bencher: Bencher) {
    let mesh = large_mesh();
    bencher
        .counter(ItemsCount::new(mesh.len()))
        .bench_local(|| Bvh::new(black_box(&mesh)));
}

#[divan::bench]
fn uniform_hemisphere(bencher: Bencher) {
    bench(bencher, square, |&r| warp::uniform_hemisphere(r));
}

#[divan::bench]
fn cosine_hemisphere(bencher: Bencher) {
    bench(bencher, square, |&r| warp::cosine_hemisphere(r));
}

#[divan::bench]
fn fresnel_reflectance(bencher: Bencher) {
    bench(bencher, square, |r| {
        let n2 = if r[1] < 0.5 { 1.0 } else { 1.5 };
        fresnel::reflectance(r[0], 2.5 - n2, n2)
    });
}

#[divan::bench(args = [OrenNayarForm::Corrected, OrenNayarForm::Printed])]
fn oren_nayar_bracket(bencher: Bencher, form: OrenNayarForm) {
    let constants = OrenNayar::new(0.3);
    bench(
        bencher,
        |i| (upper(i, 0), upper(i, 1)),
        |&(wo, wi)| oren_nayar(black_box(constants), form, wo, wi),
    );
}

#[divan::bench]
fn stream_start(bencher: Bencher) {
    bench(bencher, |i| i, |&i| uniform(&mut stream(1, 2, i)));
}

/// Pushes random inputs onto one pixel, which begins empty.
fn fill<I>(bencher: Bencher, input: impl Fn(u32) -> I, push: impl Fn(&mut Pixel, &I)) {
    let inputs: Vec<I> = (0..COUNT).map(input).collect();
    bencher.counter(ItemsCount::new(COUNT)).bench_local(|| {
        let mut pixel = Pixel::default();
        inputs.iter().for_each(|input| push(&mut pixel, input));
        black_box(pixel)
    });
}

#[divan::bench]
fn film_push(bencher: Bencher) {
    fill(
        bencher,
        |i| upper(i, 0).abs(),
        |pixel, &value| pixel.push(value, 1).expect("finite radiance"),
    );
}

#[divan::bench]
fn film_push_features(bencher: Bencher) {
    let features = |i| Features {
        albedo: upper(i, 0).abs(),
        normal: unit_vector(i),
        depth: f64::from(i),
    };
    fill(bencher, features, |pixel, f| {
        pixel.push_features(f).expect("legal features");
    });
}

/// The same for several at once; items are single ones.
macro_rules! at_once {
    ($module:ident, $number:ty, $count:expr) => {
        mod $module {
            use std::array::from_fn;
            use std::cell::RefCell;

            use divan::{Bencher, black_box};
            use glam::DVec3;
            use whitefurnace::geometry::bvh::{Bvh, PacketStack};
            use whitefurnace::geometry::shape::{Ray, Sphere};
            use whitefurnace::geometry::watertight::Shear;
            use whitefurnace::material::{OrenNayar, OrenNayarForm, fresnel, oren_nayar};
            use whitefurnace::math::real::{Mask, Real, Vector};
            use whitefurnace::math::simd::Lanes3;
            use whitefurnace::sampling::warp;

            use super::{COUNT, ItemsCount, TRIANGLE, large_mesh, square, upper};

            fn bench<I, O>(bencher: Bencher, input: impl Fn(u32) -> I, kernel: impl Fn(&I) -> O) {
                let inputs: Vec<I> = (0..COUNT / $count as u32).map(input).collect();
                bencher
                    .counter(ItemsCount::new(COUNT))
                    .bench_local(|| inputs.iter().for_each(|i| drop(black_box(kernel(i)))));
            }

            fn numbers<const N: usize>(
                of: impl Fn(u32) -> [f64; N],
            ) -> impl Fn(u32) -> [$number; N] {
                move |i| {
                    let all: [[f64; N]; $count] =
                        from_fn(|lane| of(i * $count as u32 + lane as u32));
                    from_fn(|k| <$number>::from_lanes(|lane| all[lane][k]))
                }
            }

            fn vectors(of: impl Fn(u32) -> DVec3) -> impl Fn(u32) -> Lanes3<$number> {
                move |i| Lanes3::from_fn(|lane| of(i * $count as u32 + lane as u32))
            }

            fn ray(i: u32) -> Ray<Lanes3<$number>> {
                let [origin, direction] = [|ray: Ray| ray.origin, |ray: Ray| ray.direction];
                Ray::new(
                    vectors(|i| origin(super::ray(i)))(i),
                    vectors(|i| direction(super::ray(i)))(i),
                )
            }

            #[divan::bench]
            fn triangle_watertight(bencher: Bencher) {
                let vertices = TRIANGLE.map(|v| v.to_array().map(<$number>::splat));
                bench(bencher, ray, |ray| {
                    let shear = Shear::new(ray);
                    let [a, b, c] = black_box(&vertices).map(|vertex| shear.project(vertex));
                    shear.hit([&a, &b, &c])
                });
            }

            #[divan::bench]
            fn sphere(bencher: Bencher) {
                let sphere = Sphere::new(DVec3::ZERO, 1.0);
                bench(bencher, ray, |ray| black_box(&sphere).distance(ray));
            }

            /// Rays with nothing in common, the worst of packets.
            #[divan::bench]
            fn large_mesh_closest(bencher: Bencher) {
                let (bvh, stack) = (
                    Bvh::new(&large_mesh()),
                    RefCell::new(PacketStack::default()),
                );
                let all = <$number as Real>::Mask::splat(true);
                bench(bencher, ray, |ray| {
                    bvh.closest_of_packet::<$number, { $count }>(ray, all, &mut stack.borrow_mut())
                });
            }

            #[divan::bench]
            fn uniform_hemisphere(bencher: Bencher) {
                bench(bencher, numbers(square), |&r| warp::uniform_hemisphere(r));
            }

            #[divan::bench]
            fn cosine_hemisphere(bencher: Bencher) {
                bench(bencher, numbers(square), |&r| warp::cosine_hemisphere(r));
            }

            #[divan::bench]
            fn fresnel_reflectance(bencher: Bencher) {
                bench(bencher, numbers(square), |&[cosine, side]| {
                    let n2 = <$number as Real>::select(
                        side.cmplt(<$number>::splat(0.5)),
                        <$number>::splat(1.0),
                        <$number>::splat(1.5),
                    );
                    fresnel::reflectance(cosine, -n2 + 2.5, n2)
                });
            }

            #[divan::bench(args = [OrenNayarForm::Corrected, OrenNayarForm::Printed])]
            fn oren_nayar_bracket(bencher: Bencher, form: OrenNayarForm) {
                let constants = OrenNayar::new(0.3);
                let constants = OrenNayar {
                    a: <$number>::splat(constants.a),
                    b: <$number>::splat(constants.b),
                };
                let [first, second] = [0, 1].map(|high| vectors(move |i| upper(i, high)));
                bench(
                    bencher,
                    |i| (first(i), second(i)),
                    |&(wo, wi)| oren_nayar(black_box(constants), form, wo, wi),
                );
            }
        }
    };
}

at_once!(
    eight,
    whitefurnace::math::simd::Lanes,
    whitefurnace::math::simd::LANES
);
at_once!(
    sixteen_single,
    whitefurnace::math::simd::Singles,
    whitefurnace::math::simd::SINGLES
);
