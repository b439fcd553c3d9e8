//! The check-up of a BSDF whose light goes into single directions, the lobes: mirrors, glass, and
//! choices among them.
//!
//! # Example: a mirror that absorbs a fifth
//!
//! ```
//! use glam::DVec3;
//! use whitefurnace::harness::bsdf_checkup::{CheckUp, Loss};
//! use whitefurnace::harness::lobe_checkup::{Lobe, LobeSample, LobeSubject, check_up_lobes};
//! use whitefurnace::harness::outcome::Verdict;
//! use whitefurnace::harness::trial::Context;
//!
//! let mirrored = |wo: DVec3| DVec3::new(-wo.x, -wo.y, wo.z);
//! // A fifth of the paths ends here; the others go on with all their light.
//! let lobes = move |wo| vec![Lobe { direction: mirrored(wo), probability: 0.8, share: 0.8 }];
//! let sample = move |wo, [r, ..]: [f64; 3]| {
//!     (r < 0.8).then(|| LobeSample { wi: mirrored(wo), weight: 1.0 })
//! };
//! let subject = LobeSubject::new(lobes, sample).loss(Loss::Declared(Box::new(|_| 0.2)));
//! let context = Context::new(2019, 1.0).unwrap().named("my mirror");
//! for outcome in check_up_lobes(&subject, &CheckUp::default(), &context) {
//!     assert_eq!(outcome.verdict(), Verdict::Holds, "{}: {}", outcome.name, outcome.worst);
//! }
//! ```

use glam::DVec3;

use super::bsdf_checkup::{CheckUp, Loss};
use super::chi_square::{CELL_DELTA, binomial};
use super::copied;
use super::mean::{Values, mean};
use super::outcome::{Claim, Outcome};
use super::pointwise::{
    LEAST_COSINE, Largest, POINTWISE, fuzzed_direction, fuzzed_number, inner_direction, relative, uniform3,
};
use super::trial::Context;
use crate::frame::from_spherical;

/// A direction into which light goes, for some wo.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lobe {
    /// The direction wi, unit, pointing away from the surface.
    pub direction: DVec3,
    /// With what probability the sampler picks it.
    pub probability: f64,
    /// What radiance that arrives from there is multiplied by on its way to wo: R for a mirror,
    /// (1 − R)(n₁/n₂)² for refraction.
    pub share: f64,
}

/// What the sampler returns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LobeSample {
    /// The picked direction, unit, pointing away from the surface.
    pub wi: DVec3,
    /// What the path's throughput is multiplied by: share / probability.
    pub weight: f64,
}

type Lobes = Box<dyn Fn(DVec3) -> Vec<Lobe> + Send + Sync>;
type Sample = Box<dyn Fn(DVec3, [f64; 3]) -> Option<LobeSample> + Send + Sync>;

/// A BSDF of lobes under trial, one colour channel. Directions are local unit vectors that point away
/// from the surface; the normal is z.
pub struct LobeSubject {
    /// The lobes for wo, derived apart from the sampler; lobes of probability 0 may be left out.
    pub lobes: Lobes,
    /// Picks one for wo from three uniform numbers in [0, 1).
    pub sample: Sample,
    /// Whether light may leave through the other side; wo then comes from both.
    pub transmits: bool,
    /// What the sampler may lose.
    pub loss: Loss,
    /// The shares may not sum to more than this for any wo. From inside glass of index n that is n².
    pub energy_bound: f64,
}

impl LobeSubject {
    /// A BSDF of the upper hemisphere whose sampler loses nothing, energy bound 1; the methods below
    /// change that.
    pub fn new(
        lobes: impl Fn(DVec3) -> Vec<Lobe> + Send + Sync + 'static,
        sample: impl Fn(DVec3, [f64; 3]) -> Option<LobeSample> + Send + Sync + 'static,
    ) -> Self {
        Self { lobes: Box::new(lobes), sample: Box::new(sample), transmits: false, loss: Loss::None, energy_bound: 1.0 }
    }

    /// Sets whether light may leave through the other side.
    pub fn transmits(self, transmits: bool) -> Self {
        Self { transmits, ..self }
    }

    /// Sets what the sampler may lose.
    pub fn loss(self, loss: Loss) -> Self {
        Self { loss, ..self }
    }

    /// Sets the bound of the sum of shares.
    pub fn energy_bound(self, energy_bound: f64) -> Self {
        Self { energy_bound, ..self }
    }

    fn lobes(&self, wo: DVec3) -> Vec<Lobe> {
        (self.lobes)(copied(wo))
    }

    fn sample(&self, wo: DVec3, random: [f64; 3]) -> Option<LobeSample> {
        (self.sample)(copied(wo), copied(random))
    }
}

/// The lobe that has this direction.
fn lobe_of(lobes: &[Lobe], wi: DVec3) -> Option<usize> {
    lobes.iter().position(|lobe| (lobe.direction - wi).length() <= POINTWISE)
}

/// Everything that can be asked of a BSDF of lobes without a scene. Pointwise, on random directions: no
/// NaN, infinite or negative value (on a fuzzed domain); probabilities that sum to one minus the loss;
/// samples in the direction of a lobe with weight share/probability; a lobe back to wo from every lobe's
/// direction, as light paths are reversible; shares within the energy bound. Then for each inclination
/// of `size` (on both sides, if it transmits) a binomial test of every lobe's probability, and the
/// furnace: the mean weight is the sum of the shares.
pub fn check_up_lobes(subject: &LobeSubject, size: &CheckUp, context: &Context) -> Vec<Outcome> {
    let mut outcomes = vec![sane(subject, size, context)];
    outcomes.extend(pointwise(subject, size, context));
    let sides: &[f64] = if subject.transmits { &[1.0, -1.0] } else { &[1.0] };
    for &side in sides {
        for (i, &degrees) in size.inclinations.iter().enumerate() {
            let wo = from_spherical(degrees.to_radians(), 0.7 + i as f64);
            let wo = wo.with_z(side * wo.z);
            let place = format!("{degrees} degrees{}", if side < 0.0 { " inside" } else { "" });
            outcomes.extend(at_direction(subject, size, context, wo, &place));
        }
    }
    outcomes
}

fn sane(subject: &LobeSubject, size: &CheckUp, context: &Context) -> Outcome {
    let mut rng = context.rng("sane");
    let mut worst = String::from("every value is finite and not negative");
    let mut bad = 0.0;
    let ok = |x: f64| x.is_finite() && x >= 0.0;
    let unit = |w: DVec3| (w.length() - 1.0).abs() < POINTWISE;
    for _ in 0..size.pairs {
        let wo = fuzzed_direction(&mut rng, subject.transmits);
        let random = [(); 3].map(|()| fuzzed_number(&mut rng));
        let (lobes, sample) = (subject.lobes(wo), subject.sample(wo, random));
        let lobe_ok = |l: &Lobe| ok(l.probability) && ok(l.share) && unit(l.direction);
        if !lobes.iter().all(lobe_ok) || !sample.is_none_or(|s| ok(s.weight) && unit(s.wi)) {
            bad = 1.0;
            worst = format!("wo = {wo}: {lobes:?}; random {random:?}: {sample:?}");
        }
    }
    Outcome::exact("finite and not negative", size.pairs, bad, 0.0, worst)
}

/// The checks on random directions.
fn pointwise(subject: &LobeSubject, size: &CheckUp, context: &Context) -> Vec<Outcome> {
    let mut rng = context.rng("pointwise");
    let [mut sums, mut weights, mut back, mut energy] = [(); 4].map(|()| Largest::default());
    let [mut sampled, mut returned] = [0; 2];
    for _ in 0..size.pairs {
        let wo = inner_direction(&mut rng, subject.transmits);
        let lobes = subject.lobes(wo);
        let sum: f64 = lobes.iter().map(|lobe| lobe.probability).sum();
        sums.see(subject.loss.error(sum, wo), || format!("probabilities sum to {sum} at wo = {wo}"));
        let albedo: f64 = lobes.iter().map(|lobe| lobe.share).sum();
        energy.see(albedo - subject.energy_bound, || format!("shares sum to {albedo} at wo = {wo}"));
        for lobe in &lobes {
            let wi = lobe.direction;
            if wi.z.abs() > LEAST_COSINE && lobe.probability > 0.0 {
                returned += 1;
                let returns = lobe_of(&subject.lobes(wi), wo).is_some();
                back.see(if returns { 0.0 } else { 1.0 }, || format!("no lobe leads from {wi} back to wo = {wo}"));
            }
        }
        if let Some(sample) = subject.sample(wo, uniform3(&mut rng)) {
            sampled += 1;
            match lobe_of(&lobes, sample.wi).map(|lobe| lobes[lobe]) {
                Some(lobe) => {
                    let error = relative(sample.weight * lobe.probability, lobe.share);
                    weights.see(error, || format!("{sample:?} of {lobe:?} at wo = {wo}"));
                }
                None => weights.see(1.0, || format!("{sample:?} has the direction of no lobe at wo = {wo}")),
            }
        }
    }
    [
        ("sum of probabilities", size.pairs, sums),
        ("weight = share/probability", sampled, weights),
        ("way back", returned, back),
        ("energy bound", size.pairs, energy),
    ]
    .map(|(name, n, l)| Outcome::exact(name, n, l.error, POINTWISE, l.place))
    .into()
}

/// δ of a lobe's probability is relative to it, but never below that of a lobe of this probability.
const LEAST_PROBABILITY: f64 = 0.1;

/// The checks by sampling for one wo.
fn at_direction(subject: &LobeSubject, size: &CheckUp, context: &Context, wo: DVec3, place: &str) -> Vec<Outcome> {
    let lobes = subject.lobes(wo);
    let albedo: f64 = lobes.iter().map(|lobe| lobe.share).sum();
    let n = context.n(size.samples);
    let mut rng = context.rng(&format!("samples at {place}"));
    let mut picked = vec![0; lobes.len()];
    let mut values = Values::new(albedo);
    let [mut strays, mut lost] = [0_u64; 2];
    for _ in 0..n {
        let sample = subject.sample(wo, uniform3(&mut rng));
        // A lost sample carries nothing, and counts.
        values.push(sample.map_or(0.0, |s| s.weight));
        match sample.map(|s| lobe_of(&lobes, s.wi)) {
            Some(Some(lobe)) => picked[lobe] += 1,
            Some(None) => strays += 1,
            None => lost += 1,
        }
    }
    let forbidden_loss = match subject.loss {
        Loss::None => lost,
        // How many may be lost follows from the lobes' probabilities, each of which is tested below.
        Loss::Declared(_) | Loss::Allowed => 0,
    };
    let at = |what: &str| format!("{what} at {place}");
    // Weights are share/probability, or 0 for what is lost: the same for all, or not.
    let lossless = lobes.iter().map(|lobe| lobe.probability).sum::<f64>() > 1.0 - POINTWISE;
    let constant = lossless && lobes.iter().all(|lobe| (lobe.share - albedo * lobe.probability).abs() <= POINTWISE);
    let claim = Claim::Exact { delta: if constant { 0.0 } else { size.delta * albedo } };
    let mut outcomes = vec![
        Outcome::exact(
            at("samples of no lobe"),
            n,
            (strays + forbidden_loss) as f64,
            0.0,
            format!("{strays} astray and {lost} lost of {n} samples"),
        ),
        mean(&at("furnace"), &values, albedo, claim),
    ];
    for (lobe, &k) in lobes.iter().zip(&picked) {
        let name = at(&format!("samples towards {:.3}", lobe.direction));
        let delta = CELL_DELTA * lobe.probability.max(LEAST_PROBABILITY);
        outcomes.push(binomial(&name, k, n, lobe.probability, delta));
    }
    outcomes
}
