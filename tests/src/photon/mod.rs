//! Photon mapping and its stochastic progressive form as a whole, with closed forms that include
//! their bias.

mod equivalence;
pub(crate) mod faults;
mod replications;
pub mod scenes;

use whitefurnace::harness::mean::MIN_SYMMETRIC_VALUES;
use whitefurnace::integrator::photon::photon_map::PhotonMapKind;
use whitefurnace::integrator::{Lookup, radius_squared};
use whitefurnace::sampling::sampler::SamplerKind;
use whitefurnace::scene::simple::{CAP_SHARE, Cap, cavity_cap, furnace_box};

use crate::furnace::off_cap_radiance;
use crate::photon::replications::{Flux, Mapping, Mean, Passes, family_trial};
use crate::prelude::*;
use crate::scenes::{lambert, sphere_furnace, valid};

/// Trials and faults of photon mapping: with closed forms, and against the path tracer.
pub fn families() -> Vec<Box<dyn AnyFamily>> {
    vec![
        Box::new(Family {
            trials: trials(),
            faults: faults::faults(),
            ..Family::whole("photon", STANDARD)
        }),
        Box::new(Family {
            trials: equivalence::trials(),
            faults: equivalence::faults(),
            ..Family::whole("photon-equivalence", STANDARD)
        }),
    ]
}

/// Directions spread evenly over the sphere, on a spiral of golden angles.
fn spread(count: u32) -> impl Iterator<Item = DVec3> {
    let golden = PI * (3.0 - 5f64.sqrt());
    (0..count).map(move |i| {
        let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(count);
        let (sin, cos) = (golden * f64::from(i)).sin_cos();
        let radius = (1.0 - z * z).sqrt();
        DVec3::new(radius * cos, radius * sin, z)
    })
}

fn trials() -> Vec<FamilyTrial<EstimatorSubject>> {
    [floors(), cavities(), fluxes(), passes()]
        .into_iter()
        .flatten()
        .collect()
}

/// Particles per map of a floor: few are enough, since the mean does not depend on their number.
const PARTICLES: u32 = 64;

fn floors() -> Vec<FamilyTrial<EstimatorSubject>> {
    let gather = Lookup::FinalGather {
        caustic_particles: PARTICLES,
        caustic_radius: scenes::RADIUS,
    };
    let whole = scenes::disc_average(scenes::RADIUS, f64::INFINITY);
    let cut = scenes::disc_average(scenes::RADIUS, scenes::WALL_AT);
    let floor = |name, consequence, what: &str, scene, lookup, reference: f64, (rays, values)| {
        let property = format!("a floor reflects {reference:.6} {what}");
        let rays = vec![scenes::ray_to_origin(); rays];
        let mapping = Mapping {
            scene,
            lookup,
            particles: PARTICLES,
            radius: scenes::RADIUS,
            rays,
        };
        let mean = Mean {
            replication: mapping,
            reference,
            delta: CLOSED_FORM_DELTA,
            values,
        };
        family_trial(name, property, consequence, &PHOTON_DENSITY, mean)
    };
    vec![
        floor(
            "photon/disc",
            "lit floors are darker by a photon map, as in SirKero/RTProgressivePhotonMapper#1",
            "on average over the disc around a point under a light",
            scenes::over_floor(),
            Lookup::DirectVisualization,
            whole,
            (1, MIN_SYMMETRIC_VALUES),
        ),
        floor(
            "photon/shadow-rays",
            "direct light counts twice or not at all with final gathering",
            "of a light by shadow rays, and nothing by photons",
            scenes::over_floor(),
            gather,
            scenes::at_point(),
            (8, MIN_SYMMETRIC_VALUES),
        ),
        floor(
            "photon/index-matched",
            "light through glass counts twice or not at all with final gathering",
            "of a light within glass that is air, all of it caustics, on average over the disc",
            scenes::matched(),
            gather,
            whole,
            (8, 11_000),
        ),
        floor(
            "photon/behind",
            "photons leak through floors: their dark side is lit",
            "from above of a light below it",
            scenes::under_floor(),
            Lookup::DirectVisualization,
            0.0,
            (1, 27_000),
        ),
        floor(
            "photon/corner",
            "floors are too bright along walls, where photons of the wall count on them",
            "of a disc that a wall cuts, whose photons do not count",
            scenes::corner(),
            Lookup::DirectVisualization,
            cut,
            (1, 9_500),
        ),
    ]
}

fn cavities() -> Vec<FamilyTrial<EstimatorSubject>> {
    let (albedo, rho) = (0.5, 0.75);
    let rays = |count, below: f64| -> Vec<Ray> {
        spread(count)
            .filter(|w| w.z < below)
            .map(|w| Ray::new(DVec3::ZERO, w))
            .collect()
    };
    let cavity = |name, consequence, what: String, mapping, reference: f64, values| {
        let property = format!("{what} the radiance is {reference:.6}");
        let mean = Mean {
            replication: mapping,
            reference,
            delta: BOUNCES_DELTA,
            values,
        };
        family_trial(name, property, consequence, &PHOTON_DENSITY, mean)
    };
    let furnace = Mapping {
        scene: sphere_furnace(lambert(albedo), 0.0),
        lookup: Lookup::DirectVisualization,
        particles: 64,
        radius: 0.4,
        rays: rays(32, 1.0),
    };
    let gather = Mapping {
        scene: valid(cavity_cap(rho, Cap::Reflecting)),
        lookup: Lookup::FinalGather {
            caustic_particles: 1,
            caustic_radius: 0.4,
        },
        particles: 256,
        radius: 0.4,
        rays: rays(64, 0.9 - 2.0 * CAP_SHARE),
    };
    let in_furnace = format!(
        "in a spherical furnace of albedo {albedo}, where lookups on curved walls are exact,"
    );
    let off_cap =
        format!("by final gathering, off the reflecting cap of a cavity of albedo {rho},");
    vec![
        cavity(
            "photon/furnace",
            "rooms by a photon map are too dark or too bright after several bounces",
            in_furnace,
            furnace,
            1.0 / (1.0 - albedo),
            15_700,
        ),
        cavity(
            "photon/gather",
            "indirect light counts twice or not at all with final gathering",
            off_cap,
            gather,
            off_cap_radiance(rho, Cap::Reflecting),
            MIN_SYMMETRIC_VALUES,
        ),
    ]
}

fn fluxes() -> Vec<FamilyTrial<EstimatorSubject>> {
    let flux = |scene, kept, particles, reference, delta, values| Mean {
        replication: Flux {
            scene,
            kept,
            particles,
        },
        reference,
        delta,
        values,
    };
    let caustic = scenes::flux_into_glass();
    let through = format!(
        "of a light beside a glass sphere {caustic:.6} arrive as caustics: what enters leaves"
    );
    let glass = scenes::glass_in_cavity();
    // Photons of π L A/(1 − a) arrive in a cube of side 2: the fraction a is reflected, the rest
    // absorbed.
    let albedo = 0.3;
    let arriving = PI * 24.0 / (1.0 - albedo);
    let balance = format!("in a closed box of albedo {albedo} photons of {arriving:.6} arrive");
    let cube = valid(furnace_box(albedo));
    vec![
        family_trial(
            "photon/flux-through-glass",
            through,
            "caustics of glass are too bright or too dim in a photon map",
            &PHOTON_FLUX,
            flux(
                glass,
                PhotonMapKind::Caustic,
                160,
                caustic,
                CLOSED_FORM_DELTA,
                MIN_SYMMETRIC_VALUES,
            ),
        ),
        family_trial(
            "photon/flux-balance",
            balance,
            "the indirect light of a photon map is too bright or too dim everywhere",
            &PHOTON_FLUX,
            flux(
                cube,
                PhotonMapKind::All,
                128,
                arriving,
                BOUNCES_DELTA,
                20_000,
            ),
        ),
    ]
}

/// Trials of the mean over passes of averages over discs, each of its own radius: by independent
/// numbers, and by Sobol' points.
fn passes() -> Vec<FamilyTrial<EstimatorSubject>> {
    let (passes, radius) = (12, scenes::RADIUS);
    let disc =
        |index| scenes::disc_average(radius_squared(radius * radius, index).sqrt(), f64::INFINITY);
    let reference = (0..passes).map(disc).sum::<f64>() / f64::from(passes);
    let series = |name, consequence, sampler, particles| {
        let property = format!(
            "the first {passes} passes reflect {reference:.6}, the mean over discs that shrink"
        );
        let series = Passes {
            scene: scenes::point_camera(),
            passes,
            particles,
            radius,
            sampler,
        };
        let mean = Mean {
            replication: series,
            reference,
            delta: CLOSED_FORM_DELTA,
            values: 11_900,
        };
        family_trial(name, property, consequence, &PHOTON_RADIUS, mean)
    };
    vec![
        series(
            "photon/passes",
            "progressive photon mapping stays as blurred, or as noisy, after many passes",
            SamplerKind::Independent,
            32,
        ),
        series(
            "photon/sobol",
            "progressive photon mapping by Sobol' points settles on a wrong brightness",
            SamplerKind::Sobol(passes),
            8,
        ),
    ]
}
