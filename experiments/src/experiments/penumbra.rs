//! Radiance across the penumbra of a shadow: path tracer against the closed form.

use trials::strategies::{penumbra_reference, penumbra_scene, to_floor};
use whitefurnace::light::emitter::LightSampling;

use crate::experiments::prelude::*;

pub(super) const PENUMBRA: Experiment = Experiment {
    id: "penumbra",
    title: "a floor across the penumbra of a rectangular light, against the closed form",
    headline: "across a penumbra radiance is at most {worst %.1f} standard errors from the closed form",
    version: 1,
    equations: &[&equation::GEOMETRY, &equation::LIGHT_RECTANGLE],
    run,
};

/// Number of points across the penumbra, which ends in full shadow at y = 2.
const PLACES: u32 = 42;

fn run(run: &mut Run) -> Result<(), Error> {
    let samples = run.count(run.by_tier(20_000, 500_000)) as u32;
    let scene = penumbra_scene();
    let path = Path {
        lights: LightSampling::SolidAngle,
        ..Path::new(Strategy::Mis)
    };
    let seed = seed_for(run.seed(), "penumbra");
    let at = |k: u32| -2.2 + 4.1 * f64::from(k) / f64::from(PLACES - 1);
    let measured = parallel_map(0..PLACES, |k| {
        radiance_along(&scene, &path, &to_floor(at(k)), seed, k, samples)
    })?;
    let z = normal_upper(0.5 * FAMILYWISE_LEVEL / f64::from(PLACES));
    let mut rows = Vec::new();
    let mut found = Vec::new();
    let mut worst = 0.0_f64;
    for (k, moments) in (0..).zip(&measured) {
        let (y, reference) = (at(k), penumbra_reference(at(k)));
        let (mean, error) = (moments.mean(), moments.standard_error());
        worst = worst.max((mean - reference).abs() / error);
        found.push([y, mean, z * error]);
        rows.push(format!("{y},{mean:e},{error:e},{reference:e}"));
    }
    run.number("worst", worst);
    let value = format!(
        "{PLACES} places, {samples} samples each: at most {worst:.2} standard errors off; {z:.2} \
         allowed at family-wise level {FAMILYWISE_LEVEL:.0e}"
    );
    run.claim("radiance across the penumbra", value, worst <= z);
    run.csv("penumbra.csv", "y,mean,standard error,closed form", &rows)?;
    let curve = Series::curve("closed form", 0, [-2.2, 2.0], 400, penumbra_reference);
    let brightest = curve
        .points
        .iter()
        .map(|[_, radiance]| *radiance)
        .fold(0.0, f64::max);
    let series = vec![
        curve,
        Series::measured("path tracer, with its error", 2, found),
    ];
    let title = "Radiance of the floor across the penumbra";
    let axes = [
        "y (the occluder hangs over all y > 0)",
        "radiance (that of the light is 3)",
    ];
    let chart = Chart::new(title, axes, [[-2.3, 2.1], [0.0, 1.08 * brightest]], series);
    let description =
        "The path tracer's points lie on the closed form from full light to full shadow.";
    charts(run, "penumbra.svg", description, 520, &[chart])
}
