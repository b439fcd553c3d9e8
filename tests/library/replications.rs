//! Tests that replications are independent: every placement of samples draws random numbers of its
//! own, and the film's error bars are the spread of replications rendered one by one.

use std::collections::BTreeSet;
use std::sync::Mutex;

use whitefurnace::light::emitter::EmitterPoint;
use whitefurnace::sampling::sampler::MAX_POINTS;

use crate::prelude::*;

const FRAME: [u32; 2] = [7, 5];
const REPLICATIONS: u32 = 6;

/// Returns every sample placement in a pixel, with every kind of sampler.
fn samplings() -> Vec<Sampling> {
    let positions = [
        Centre,
        Grid(1),
        Grid(2),
        Grid(3),
        Random,
        Jitter(1),
        Jitter(2),
        Jitter(3),
    ];
    let numbers = [
        SamplerKind::Independent,
        SamplerKind::Sobol(1),
        SamplerKind::Sobol(8),
    ];
    let with = |pixel: PixelSampling| numbers.map(|numbers| sampling(pixel, numbers, master()));
    positions.into_iter().flat_map(with).collect()
}

/// Bits of two random numbers, which identify a draw: with 53 bits each, two draws are equal by
/// chance with probability 2^(−106).
type Draw = [u64; 2];

fn draw(random: [f64; 2]) -> Draw {
    random.map(f64::to_bits)
}

/// Records the estimator's first four random numbers, and returns two of them.
#[derive(Default)]
struct Recorder(Mutex<Vec<[u64; 4]>>);

impl Estimator for Recorder {
    fn radiance(&self, _: &Scene, _: &Ray, _: Option<Hit>, rng: &mut dyn Sampler) -> DVec3 {
        // The estimator's first numbers; those that placed the ray come from an earlier block.
        rng.block(1);
        let ([a, b], [c, d]) = (uniform2(rng), uniform2(rng));
        self.0
            .lock()
            .expect("no panic")
            .push([a, b, c, d].map(f64::to_bits));
        DVec3::new(a, b, 1.0)
    }
}

fn open() -> Scene {
    scene(|_| {})
}

/// Asserts that there are this many draws, all different.
fn assert_distinct<T: Ord>(draws: &[T], expected: usize, what: &str) {
    assert_eq!(draws.len(), expected, "{what}");
    let distinct: BTreeSet<&T> = draws.iter().collect();
    assert_eq!(
        distinct.len(),
        draws.len(),
        "{what}: some numbers were drawn twice"
    );
}

#[test]
fn every_sample_of_every_replication_draws_its_own_numbers() {
    for sampling in samplings() {
        let samples = sampling.samples_per_replication();
        let recorder = Recorder::default();
        // In ranges, as programs render.
        let ranges = [0..1, 1..2, 2..4, 4..REPLICATIONS];
        rendered(&open(), &recorder, FRAME, sampling, &ranges).expect("legal radiance");
        let draws = recorder.0.into_inner().expect("no panic");
        let expected = FRAME[0] * FRAME[1] * REPLICATIONS * samples;
        assert_distinct(&draws, expected as usize, &format!("{sampling:?}"));
        // The 23 leading bits alone, those of the scramble: 92 in four numbers.
        let leading = |bits: u64| (f64::from_bits(bits) * f64::from(1 << 23)) as u32;
        let leading: Vec<[u32; 4]> = draws.iter().map(|draw| draw.map(leading)).collect();
        assert_distinct(
            &leading,
            draws.len(),
            &format!("{sampling:?}, leading bits"),
        );
    }
}

/// The film has the mean of films of one replication each, and their standard error as its error
/// bar: the random numbers of a replication do not depend on others.
#[test]
fn error_bars_are_the_spread_of_replications_rendered_alone() {
    for sampling in samplings() {
        let film = |range: std::ops::Range<u32>| {
            rendered(&open(), &Recorder::default(), FRAME, sampling, &[range]).expect("legal")
        };
        let whole = film(0..REPLICATIONS);
        let alone: Vec<Film> = (0..REPLICATIONS).map(|r| film(r..r + 1)).collect();
        for (i, pixel) in whole.pixels().iter().enumerate() {
            let moments = [0, 1, 2].map(|c| {
                alone
                    .iter()
                    .map(|film| film.pixels()[i].mean()[c])
                    .collect::<Moments>()
            });
            let [mean, error] = [
                moments.map(|m| m.mean()),
                moments.map(|m| m.standard_error()),
            ]
            .map(DVec3::from);
            assert_abs_diff_eq!(pixel.mean(), mean, epsilon = 2.0 * FIXED_POINT_UNIT);
            assert_abs_diff_eq!(
                pixel.standard_error(),
                error,
                epsilon = 4.0 * FIXED_POINT_UNIT
            );
            // Independent uniform numbers differ; the third channel is 1 for all.
            assert_eq!(
                pixel.standard_error().to_array().map(|error| error > 0.0),
                [true, true, false],
                "{sampling:?}"
            );
            assert_eq!(pixel.replications(), REPLICATIONS);
        }
    }
}

/// The standard parts, which record the pairs of numbers that sample points on emitters and
/// directions.
#[derive(Clone, Copy)]
struct Watched<'a>(&'a Mutex<Vec<Draw>>);

impl Watched<'_> {
    fn keep(self, random: [f64; 2]) -> [f64; 2] {
        self.0.lock().expect("no panic").push(draw(random));
        random
    }
}

default_parts!(Watched<'_>: Roulette, Photons, Bidirectional, FiniteElements);

impl Scattering for Watched<'_> {
    fn cosine_hemisphere(&self, random: [f64; 2]) -> DVec3 {
        DefaultParts.cosine_hemisphere(self.keep(random))
    }
}

impl NextEvent for Watched<'_> {
    fn sample_emitter(&self, emitter: &Emitter, random: [f64; 2]) -> EmitterPoint {
        DefaultParts.sample_emitter(emitter, self.keep(random))
    }
}

#[test]
fn every_pass_draws_its_own_numbers() {
    fn check(name: &str, estimator: impl Fn(Parts<'_>) -> Box<dyn ImageEstimator + '_>) {
        let seen = Mutex::default();
        let parts = Watched(&seen);
        let estimator = estimator(Parts::replaced(&parts));
        passes(
            &furnace(0.5),
            &*estimator,
            FRAME,
            &[0..1, 1..3, 3..REPLICATIONS],
        )
        .expect("legal radiance");
        let draws = seen.lock().expect("no panic");
        // Each particle draws at least a point and a direction.
        assert!(
            draws.len() as u32 > 2 * FRAME[0] * FRAME[1] * REPLICATIONS,
            "{name}"
        );
        assert_distinct(&draws, draws.len(), name);
    }
    check("light tracer", |parts| Box::new(LightTracer { parts }));
    check("bdpt", |parts| Box::new(Bdpt::new(parts)));
    check("sppm", |parts| {
        Box::new(sppm(parts, FRAME[0] * FRAME[1], 0.3))
    });
}

#[test]
fn every_map_of_photons_draws_its_own_numbers() {
    let seen = Mutex::default();
    let scene = furnace(0.5);
    let lookup = final_gather(40, 0.1);
    // Programs identify replications by seed, passes by number.
    for (seed, pass) in [(1_u32, 0), (1, 1), (2, 0), (3, 7)] {
        let pass = ImagePass::independent(seed_for(master(), &seed.to_string()), pass);
        let watched = Watched(&seen);
        let parts = Parts::replaced(&watched);
        assert!(PhotonMapping::new(parts, &scene, lookup, 40, 0.1, pass).is_ok());
    }
    let draws = seen.into_inner().expect("no panic");
    assert!(draws.len() >= 4 * 2 * 2 * 40);
    assert_distinct(&draws, draws.len(), "photon maps");
}

/// Numbers of samples that 32 bits cannot index are refused, not wrapped.
#[test]
fn more_samples_than_can_be_named_are_refused() {
    let refused = |pixel, numbers, range: std::ops::Range<u32>, hint| {
        let sampling = sampling(pixel, numbers, 1);
        let found = rendered(&open(), &Path::default(), [1, 1], sampling, &[range]);
        assert_option_refused(found, hint);
    };
    let end = u32::MAX;
    refused(
        Jitter(2),
        SamplerKind::Independent,
        end - 1..end,
        "replications",
    );
    refused(Random, SamplerKind::Sobol(2), end - 1..end, "replications");
    refused(Grid(0), SamplerKind::Independent, 0..1, "at least 1");
    refused(Random, SamplerKind::Sobol(0), 0..1, "at least 1");
    refused(
        Jitter(1 << 17),
        SamplerKind::Independent,
        0..2,
        "replications",
    );
    refused(Random, SamplerKind::Sobol(MAX_POINTS + 1), 0..1, "points");
    refused(
        Jitter(2),
        SamplerKind::Sobol(MAX_POINTS / 4 + 1),
        0..1,
        "points",
    );
    refused(Jitter(1 << 17), SamplerKind::Sobol(1 << 17), 0..1, "points");
    // The longest sequence itself is accepted, in a film that has its length.
    let sampling = sampling(Random, SamplerKind::Sobol(MAX_POINTS), 1);
    let recorder = Recorder::default();
    assert!(rendered(&open(), &recorder, [1, 1], sampling, &[0..1]).is_ok());
    let mut other = Film::new([1, 1], None, 1).expect("a film");
    assert!(render(&open(), &recorder, sampling, &mut other, &(0..1), &|_| true).is_err());
    // All its points, once each: in 2^16 intervals.
    let draws = recorder.0.into_inner().expect("no panic");
    let strata: BTreeSet<u64> = draws
        .iter()
        .map(|[first, ..]| (f64::from_bits(*first) * f64::from(MAX_POINTS)) as u64)
        .collect();
    assert_eq!(strata.len(), MAX_POINTS as usize);
}

/// Half of the only pixel shows an emitter.
fn edge() -> Scene {
    scene(|scene| {
        panel(
            scene,
            DVec3::new(1.0, -9.0, -9.0),
            [18.0 * DVec3::Z, 9.0 * DVec3::Y],
            lamp(1.0),
        );
    })
}

/// Every pass of photon mapping samples a camera ray of its own. Of 200 fair coins fewer than 40
/// show one side with probability 1e-18.
#[test]
fn every_pass_of_photons_looks_through_a_point_of_its_own() {
    let sppm = sppm(Parts::default(), 1, 0.1);
    let pass = |index| {
        sppm.pass(&edge(), [1, 1], master(), index)
            .expect("an image")
    };
    let lit = (0..200)
        .filter(|&index| pass(index)[0] == DVec3::ONE)
        .count();
    assert!((40..=160).contains(&lit), "{lit}");
}
