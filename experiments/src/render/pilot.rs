//! Decides how many samples a run takes for a given time or error. A pilot run measures, and its
//! samples are thrown away: the number then depends on no sample of the image, so stopping there
//! introduces no bias.

use std::time::{Duration, Instant};

use whitefurnace::error::Error;
use whitefurnace::sampling::rng::seed_for;

use super::defaults::{MAX_POINTS_PER_SCRAMBLE, MIN_SCRAMBLES};
use super::{Job, SamplerName};

/// Target from which the number of samples follows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Target {
    /// Duration of the run, counted from this moment.
    Time(Instant, Duration),
    /// Mean relative standard error of the pixels.
    Error(f64),
}

/// Limits of a pilot: its longest duration, and 1/[`PILOT_DIVISOR`] of the time asked for. Both
/// apply, unless the fewest samples take longer.
const LONGEST_PILOT: Duration = Duration::from_secs(8);
const PILOT_DIVISOR: u32 = 10;

/// Share of the time asked for that is kept as a reserve, and time per pixel kept for writing the
/// files.
const RESERVE_FRACTION: f64 = 0.02;
const WRITE_TIME_PER_PIXEL: Duration = Duration::from_nanos(1000);

/// Parses "90s", "10m" or "1.5h".
pub fn parse_time(text: &str) -> Result<Duration, String> {
    let units = [('s', 1.0), ('m', 60.0), ('h', 3600.0)];
    let found = units
        .iter()
        .find_map(|&(unit, seconds)| Some(seconds * text.strip_suffix(unit)?.parse::<f64>().ok()?));
    let valid = found.filter(|seconds| (1.0..=3.6e7).contains(seconds));
    valid.map(Duration::from_secs_f64).ok_or_else(|| {
        "must be seconds, minutes or hours such as 90s, 10m or 1.5h, from 1s to 10000h".to_owned()
    })
}

/// Parses a percentage such as "1%".
pub fn parse_percentage(text: &str) -> Result<f64, String> {
    let found = text
        .strip_suffix('%')
        .and_then(|number| number.parse::<f64>().ok());
    let valid = found.filter(|percent| (1e-4..=100.0).contains(percent));
    valid
        .map(|percent| percent / 100.0)
        .ok_or_else(|| "must be a percentage such as 1%, from 0.0001% to 100%".to_owned())
}

impl Job {
    /// Returns the next valid number of samples, but at least as many as an error bar needs.
    pub(super) fn round_to_valid(&self, samples: f64, round: fn(f64) -> f64) -> u32 {
        let step = match self.sampler {
            SamplerName::Independent => 2 * self.sampling().pixel.samples_per_replication(),
            SamplerName::Sobol => self.scrambles.unwrap_or_else(|| {
                MIN_SCRAMBLES.max((samples / f64::from(MAX_POINTS_PER_SCRAMBLE)).ceil() as u32)
            }),
        };
        step * round(samples / f64::from(step)).clamp(1.0, f64::from(u32::MAX / step)) as u32
    }

    /// Returns the job with `spp` samples per pixel and a seed of its own.
    pub fn pilot(&self, spp: u32) -> Self {
        Self {
            seed: seed_for(self.seed, "pilot"),
            spp,
            ..*self
        }
    }

    /// Returns the samples per pixel that reach the target.
    pub fn decide(&self, target: Target) -> Result<u32, Error> {
        let (budget, round): (_, fn(f64) -> f64) = match target {
            Target::Time(_, time) => (LONGEST_PILOT.min(time / PILOT_DIVISOR), f64::floor),
            Target::Error(_) => (LONGEST_PILOT / 2, f64::ceil),
        };
        let begin = Instant::now();
        let mut spp = self.round_to_valid(1.0, f64::ceil);
        loop {
            let pilot = self.pilot(spp);
            pilot.check()?;
            let setting_up = Instant::now();
            let scene = pilot.build_scene()?;
            let renderer = pilot.renderer(&scene, "pilot")?;
            let (setup, sampling) = (setting_up.elapsed(), Instant::now());
            let film = pilot
                .render_all(&scene, &*renderer, "pilot")?
                .into_complete()?;
            let (took, all) = (sampling.elapsed(), setting_up.elapsed());

            let done = f64::from(spp);
            let wanted = match target {
                Target::Time(start, time) => {
                    let pixels = film.pixels().len() as u32;
                    let spent = start.elapsed()
                        + setup
                        + WRITE_TIME_PER_PIXEL * pixels
                        + time.mul_f64(RESERVE_FRACTION);
                    done * time.saturating_sub(spent).as_secs_f64() / took.as_secs_f64()
                }
                Target::Error(goal) => {
                    // The square root of an unbiased variance is too small by this factor on
                    // average.
                    let n = f64::from(film.replications());
                    let error = film.relative_error() * (4.0 * n - 3.0) / (4.0 * n - 4.0);
                    if !error.is_finite() {
                        return Err(Error::Option(
                            "--target-error: the pilot has no relative error, because it found no light or has only one scramble: use --spp"
                                .into(),
                        ));
                    }
                    // The error falls at least this fast.
                    done * (error / goal).powi(2)
                }
            };
            if wanted > f64::from(u32::MAX) {
                return Err(Error::Option(format!(
                    "this asks for {wanted:.1e} samples per pixel: at most {} are possible",
                    u32::MAX
                )));
            }
            if matches!(target, Target::Error(_)) && wanted <= done {
                return Ok(spp);
            }
            // The next pilot takes two thirds of the remaining time.
            let left = budget.saturating_sub(begin.elapsed()).as_secs_f64();
            let factor = (left / all.as_secs_f64() / 1.5).min(8.0);
            if factor < 2.0 {
                return Ok(self.round_to_valid(wanted, round));
            }
            spp = self.round_to_valid((done * factor).min(wanted), round);
        }
    }
}
