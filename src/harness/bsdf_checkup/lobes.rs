//! Complete check of a BSDF whose light goes into single directions, its lobes: mirrors, glass, and
//! choices among them.

use super::*;
use crate::harness::chi_square::{CELL_DELTA, binomial};
use crate::harness::mean::{Values, mean};
use crate::harness::outcome::Claim;
use crate::harness::roundoff::MAX_ROUNDING_ERROR;

/// One direction of scattering for some wo.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lobe {
    /// Direction wi, unit, pointing away from the surface.
    pub direction: DVec3,
    /// Probability that the sampler picks it.
    pub probability: f64,
    /// Factor of radiance arriving from there on its way to wo: R for a mirror, (1 − R)(n₁/n₂)² for
    /// refraction.
    pub throughput: f64,
}

/// A lobe drawn by the sampler.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LobeSample {
    /// Picked direction, unit, pointing away from the surface.
    pub wi: DVec3,
    /// Factor of the path's throughput: that of the lobe over its probability.
    pub weight: f64,
}

type Lobes = Box<dyn Fn(DVec3) -> Vec<Lobe> + Send + Sync>;
type SampleLobe = Box<dyn Fn(DVec3, [f64; 3]) -> Option<LobeSample> + Send + Sync>;

/// A BSDF of lobes under trial, one colour channel. Directions are local unit vectors that point
/// away from the surface; the normal is z.
pub struct LobeSubject {
    /// Lobes for wo, derived independently of the sampler; lobes of probability 0 may be omitted.
    pub lobes: Lobes,
    /// Picks a lobe for wo from three uniform numbers in [0, 1).
    pub sample: SampleLobe,
    /// Whether light may leave through the other side; wo then comes from both.
    pub transmits: bool,
    /// How many samples the sampler may lose.
    pub loss: Loss,
    /// Bound of the sum of throughputs for any wo. From inside glass of index n it is n².
    pub energy_bound: f64,
}

impl LobeSubject {
    /// Creates a BSDF of the upper hemisphere whose sampler loses nothing, with energy bound 1; the
    /// methods below change that.
    pub fn new(
        lobes: impl Fn(DVec3) -> Vec<Lobe> + Send + Sync + 'static,
        sample: impl Fn(DVec3, [f64; 3]) -> Option<LobeSample> + Send + Sync + 'static,
    ) -> Self {
        Self {
            lobes: Box::new(lobes),
            sample: Box::new(sample),
            transmits: false,
            loss: Loss::None,
            energy_bound: 1.0,
        }
    }

    /// Sets whether light may leave through the other side.
    pub fn transmits(self, transmits: bool) -> Self {
        Self { transmits, ..self }
    }

    /// Sets how many samples the sampler may lose.
    pub fn loss(self, loss: Loss) -> Self {
        Self { loss, ..self }
    }

    /// Sets the bound of the sum of throughputs.
    pub fn energy_bound(self, energy_bound: f64) -> Self {
        Self {
            energy_bound,
            ..self
        }
    }

    fn lobes(&self, wo: DVec3) -> Vec<Lobe> {
        (self.lobes)(copied(wo))
    }

    fn sample(&self, wo: DVec3, random: [f64; 3]) -> Option<LobeSample> {
        (self.sample)(copied(wo), copied(random))
    }
}

/// Subject with the bounds for its precision.
struct RoundedSubject<'a> {
    subject: &'a LobeSubject,
    rounding: RoundoffBounds,
}

impl RoundedSubject<'_> {
    /// Returns the lobe with this direction, within `conditioning` and the rounding.
    fn lobe_of(&self, lobes: &[Lobe], wi: DVec3, conditioning: f64) -> Option<usize> {
        let radius = self.rounding.tolerance() + conditioning.min(MAX_ROUNDING_ERROR);
        lobes
            .iter()
            .position(|lobe| (lobe.direction - wi).length() <= radius)
    }

    fn sample(&self, wo: DVec3, random: [f64; 3]) -> Option<LobeSample> {
        self.subject
            .sample(wo, random.map(|u| self.rounding.round_down(u)))
    }

    /// Returns how far rounding may move lobes at wo: their directions, and their probabilities and
    /// throughputs, relative. Infinite where lobes appear or vanish nearby, as at the edge of total
    /// reflection; 0 in double precision.
    fn conditioning(&self, wo: DVec3) -> f64 {
        if !self.rounding.is_coarse() {
            return 0.0;
        }
        let lobes = self.subject.lobes(wo);
        let change = |moved: DVec3| {
            let others = self.subject.lobes(moved);
            let each = lobes.iter().zip(&others).map(|(a, b)| {
                let [probability, throughput] =
                    [(a.probability, b.probability), (a.throughput, b.throughput)]
                        .map(|(a, b)| self.rounding.relative(a, b));
                let turned = (a.direction - b.direction).length();
                turned.max(probability).max(throughput)
            });
            if others.len() == lobes.len() {
                each.fold(0.0, f64::max)
            } else {
                f64::INFINITY
            }
        };
        self.rounding
            .steps()
            .into_iter()
            .map(|step| change(wo + step))
            .fold(0.0, f64::max)
    }
}

/// Returns the unit roundoff found from the subject's values.
fn find_roundoff(subject: &LobeSubject, size: &CheckUp, context: &Context) -> f64 {
    let rng: &mut Stream = &mut context.rng("precision");
    let mut quantities: [Vec<[f64; 2]>; 6] = Default::default();
    for _ in 0..size.pairs.min(PRECISION_PAIRS) {
        let wo = inner_direction(rng, subject.transmits);
        let stepped = wo + DVec3::splat(ARGUMENT_STEP);
        for (a, b) in subject.lobes(wo).iter().zip(&subject.lobes(stepped)) {
            let values = |l: &Lobe| {
                let [x, y, z] = l.direction.to_array();
                [x, y, z, l.probability, l.throughput]
            };
            for ((quantity, a), b) in quantities.iter_mut().zip(values(a)).zip(values(b)) {
                quantity.push([a, b]);
            }
        }
        let random = uniform3(rng);
        if let [Some(a), Some(b)] = [wo, stepped].map(|wo| subject.sample(wo, random)) {
            quantities[5].push([a.wi.x, b.wi.x]);
        }
    }
    unit_roundoff(&quantities)
}

/// Checks all that can be asked of a BSDF of lobes without a scene. Pointwise, on random
/// directions: no NaN, infinite or negative value (on a fuzzed domain); probabilities that sum to
/// one minus the loss; samples in the direction of a lobe with weight throughput/probability; a
/// lobe back to wo from every lobe's direction, as light paths are reversible (except where rounding
/// makes lobes appear or vanish, as single precision does beside the critical angle); throughputs
/// within the energy bound. Then for each inclination of `size` (on both sides, if it transmits) a
/// binomial test of every lobe's probability, and the furnace: the mean weight is the sum of the
/// throughputs.
///
/// # Example: a mirror that absorbs a fifth
///
/// ```
/// use whitefurnace::glam::DVec3;
/// use whitefurnace::harness::bsdf_checkup::{
///     CheckUp, Lobe, LobeSample, LobeSubject, Loss, check_up_lobes,
/// };
/// use whitefurnace::harness::outcome::Verdict;
/// use whitefurnace::harness::trial::Context;
///
/// let mirrored = |wo: DVec3| DVec3::new(-wo.x, -wo.y, wo.z);
/// // A fifth of the paths ends here; the others go on with all their light.
/// let lobes = move |wo| vec![Lobe { direction: mirrored(wo), probability: 0.8, throughput: 0.8 }];
/// let sample = move |wo, [r, ..]: [f64; 3]| {
///     (r < 0.8).then(|| LobeSample { wi: mirrored(wo), weight: 1.0 })
/// };
/// let subject = LobeSubject::new(lobes, sample).loss(Loss::Declared(Box::new(|_| 0.2)));
/// let context = Context::new(2019, 1.0).unwrap().named("my mirror");
/// for outcome in check_up_lobes(&subject, &CheckUp::default(), &context) {
///     assert_eq!(outcome.verdict(), Verdict::Holds, "{}: {}", outcome.name, outcome.worst);
/// }
/// ```
pub fn check_up_lobes(subject: &LobeSubject, size: &CheckUp, context: &Context) -> Vec<Outcome> {
    let rounded = RoundedSubject {
        subject,
        rounding: size.rounding(|| find_roundoff(subject, size, context)),
    };
    let mut outcomes = vec![check_finite(&rounded, size, context)];
    outcomes.extend(check_pointwise(&rounded, size, context));
    let sides: &[f64] = if subject.transmits {
        &[1.0, -1.0]
    } else {
        &[1.0]
    };
    for &side in sides {
        for (i, &degrees) in size.inclinations.iter().enumerate() {
            let wo = from_spherical(degrees.to_radians(), 0.7 + i as f64);
            let wo = wo.with_z(side * wo.z);
            let place = format!(
                "{degrees} degrees{}",
                if side < 0.0 { " inside" } else { "" }
            );
            outcomes.extend(at_direction(&rounded, size, context, wo, &place));
        }
    }
    outcomes
}

fn check_finite(rounded: &RoundedSubject<'_>, size: &CheckUp, context: &Context) -> Outcome {
    let RoundedSubject { subject, rounding } = rounded;
    let mut rng = context.rng("sane");
    let mut worst = format!(
        "every value is finite and not negative; judged as {}",
        rounding.words()
    );
    let mut bad = 0.0;
    let ok = |x: f64| x.is_finite() && x >= 0.0;
    let unit = |w: DVec3| (w.length() - 1.0).abs() < rounding.tolerance();
    for _ in 0..size.pairs {
        let wo = fuzzed_direction(&mut rng, subject.transmits);
        let random = [(); 3].map(|()| fuzzed_number(&mut rng));
        let (lobes, sample) = (subject.lobes(wo), rounded.sample(wo, random));
        let lobe_ok = |l: &Lobe| ok(l.probability) && ok(l.throughput) && unit(l.direction);
        if !lobes.iter().all(lobe_ok) || !sample.is_none_or(|s| ok(s.weight) && unit(s.wi)) {
            bad = 1.0;
            worst = format!("wo = {wo}: {lobes:?}; random {random:?}: {sample:?}");
        }
    }
    Outcome::identity("finite and not negative", size.pairs, bad, 0.0, worst)
}

/// Runs the checks on random directions.
fn check_pointwise(
    rounded: &RoundedSubject<'_>,
    size: &CheckUp,
    context: &Context,
) -> Vec<Outcome> {
    let RoundedSubject { subject, rounding } = rounded;
    let mut rng = context.rng("pointwise");
    let [mut sums, mut weights, mut reversed, mut energy] =
        [(); 4].map(|()| LargestError::default());
    let [mut sampled, mut skipped, mut returned, mut one_way] = [0; 4];
    for _ in 0..size.pairs {
        let wo = inner_direction(&mut rng, subject.transmits);
        let lobes = subject.lobes(wo);
        let sum: f64 = lobes.iter().map(|lobe| lobe.probability).sum();
        sums.update(subject.loss.error(sum, wo), || {
            format!("probabilities sum to {sum} at wo = {wo}")
        });
        let albedo: f64 = lobes.iter().map(|lobe| lobe.throughput).sum();
        energy.update(albedo - subject.energy_bound, || {
            format!("throughputs sum to {albedo} at wo = {wo}")
        });
        for lobe in &lobes {
            let wi = lobe.direction;
            if wi.z.abs() > MIN_COSINE && lobe.probability > 0.0 {
                let reverse_lobes = subject.lobes(wi);
                let conditioning = rounded.conditioning(wi);
                let returns = [0.0, conditioning]
                    .into_iter()
                    .any(|bound| rounded.lobe_of(&reverse_lobes, wo, bound).is_some());
                // Where rounding makes lobes appear or vanish, the one back may be missing.
                match rounding.excess(if returns { 0.0 } else { 1.0 }, || conditioning) {
                    Some(excess) => {
                        returned += 1;
                        reversed.update(excess, || {
                            format!("no lobe leads from {wi} back to wo = {wo}")
                        });
                    }
                    None => one_way += 1,
                }
            }
        }
        if let Some(sample) = rounded.sample(wo, uniform3(&mut rng)) {
            sampled += 1;
            let exact = rounded.lobe_of(&lobes, sample.wi, 0.0);
            match exact.or_else(|| rounded.lobe_of(&lobes, sample.wi, rounded.conditioning(wo))) {
                Some(lobe) => {
                    let lobe = lobes[lobe];
                    let error =
                        rounding.relative(sample.weight * lobe.probability, lobe.throughput);
                    match rounding.excess(error, || rounded.conditioning(wo)) {
                        Some(excess) => {
                            weights.update(excess, || {
                                format!("{sample:?} of {lobe:?}, off by {error:.1e}, at wo = {wo}")
                            });
                        }
                        None => skipped += 1,
                    }
                }
                None => weights.update(1.0, || {
                    format!("{sample:?} has the direction of no lobe at wo = {wo}")
                }),
            }
        }
    }
    let judged = sampled - skipped;
    vec![
        rounding.outcome("sum of probabilities", size.pairs, 0, sums),
        rounding.outcome("weight = throughput/probability", judged, skipped, weights),
        rounding.outcome("way back", returned, one_way, reversed),
        rounding.outcome("energy bound", size.pairs, 0, energy),
    ]
}

/// Probability below which δ of a lobe's probability is no longer relative to it.
const MIN_PROBABILITY: f64 = 0.1;

/// Runs the checks by sampling for one wo.
fn at_direction(
    rounded: &RoundedSubject<'_>,
    size: &CheckUp,
    context: &Context,
    wo: DVec3,
    place: &str,
) -> Vec<Outcome> {
    let RoundedSubject { subject, rounding } = rounded;
    let conditioning = rounded.conditioning(wo);
    let lobes = subject.lobes(wo);
    let albedo: f64 = lobes.iter().map(|lobe| lobe.throughput).sum();
    let n = context.n(size.samples);
    let mut rng = context.rng(&format!("samples at {place}"));
    let mut picked = vec![0; lobes.len()];
    let mut values = Values::new(albedo);
    let [mut strays, mut lost] = [0_u64; 2];
    for _ in 0..n {
        let sample = rounded.sample(wo, uniform3(&mut rng));
        // A lost sample has weight 0, and counts.
        values.push(sample.map_or(0.0, |s| s.weight));
        match sample.map(|s| rounded.lobe_of(&lobes, s.wi, conditioning)) {
            Some(Some(lobe)) => picked[lobe] += 1,
            Some(None) => strays += 1,
            None => lost += 1,
        }
    }
    let forbidden_loss = match subject.loss {
        Loss::None => lost,
        // The number of losses follows from the lobes' probabilities, each of which is tested
        // below.
        Loss::Declared(_) | Loss::Allowed => 0,
    };
    let at = |what: &str| format!("{what} at {place}");
    // Whether all weights, throughput/probability or 0 for a loss, are the same.
    let lossless =
        lobes.iter().map(|lobe| lobe.probability).sum::<f64>() > 1.0 - rounding.tolerance();
    let same =
        |lobe: &Lobe| (lobe.throughput - albedo * lobe.probability).abs() <= rounding.tolerance();
    let constant = lossless && lobes.iter().all(same);
    let claim = Claim::Equal {
        delta: if constant { 0.0 } else { size.delta * albedo },
    };
    let furnace = if constant && rounding.is_coarse() {
        let [found, spread] = [values.moments.mean(), values.moments.variance().sqrt()];
        let worst =
            format!("mean weight {found}, varying by {spread:.1e}; each should be {albedo}");
        let error = (found - albedo).abs() + spread;
        let tolerance = rounding.tolerance() + conditioning.min(MAX_ROUNDING_ERROR);
        Outcome::identity(at("furnace"), n, error, tolerance, worst)
    } else {
        mean(&at("furnace"), &values, albedo, claim)
    };
    let mut outcomes = vec![
        Outcome::identity(
            at("samples of no lobe"),
            n,
            (strays + forbidden_loss) as f64,
            0.0,
            format!("{strays} astray and {lost} lost of {n} samples"),
        ),
        furnace,
    ];
    for (lobe, &k) in lobes.iter().zip(&picked) {
        let name = at(&format!("samples towards {:.3}", lobe.direction));
        let delta = CELL_DELTA * lobe.probability.max(MIN_PROBABILITY);
        outcomes.push(binomial(&name, k, n, lobe.probability, delta));
    }
    outcomes
}
