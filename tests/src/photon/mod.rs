//! Photon mapping and its stochastic progressive form, whole, with closed forms of what they should find:
//! their bias included.

mod equivalence;
mod faults;
mod replications;
pub mod scenes;

use whitefurnace::estimator::photon_map::Kept;
use whitefurnace::estimator::{Lookup, radius_squared};
use whitefurnace::harness::mean::NEARLY_SYMMETRIC;
use whitefurnace::scene::simple::{CAP_SHARE, Cap, cavity_cap, furnace_box};

use crate::photon::replications::{About, Flux, Mapping, Passes, family_trial};
use crate::prelude::*;
use crate::scenes::{lambert, sphere_furnace};

/// The families: with closed forms, and against the path tracer.
pub fn families() -> Vec<Box<dyn AnyFamily>> {
    vec![
        Box::new(Family {
            whole_estimator: true,
            trials: trials(),
            faults: faults::faults(),
            ..Family::new("photon", STANDARD)
        }),
        Box::new(Family {
            whole_estimator: true,
            trials: equivalence::trials(),
            faults: equivalence::faults(),
            ..Family::new("photon-equivalence", STANDARD)
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

const MAPPING: &str = "estimator::PhotonMapping";

fn trials() -> Vec<FamilyTrial<EstimatorSubject>> {
    let mut trials = floors();
    trials.extend(cavities());
    trials.extend(fluxes());
    trials.push(passes());
    trials
}

/// Particles per map of a floor: few do, since the mean does not depend on their number.
const FEW: u32 = 64;

fn floors() -> Vec<FamilyTrial<EstimatorSubject>> {
    let gather = Lookup::Gather { caustic_particles: FEW, caustic_radius: scenes::RADIUS };
    let whole = scenes::disc_average(scenes::RADIUS, f64::INFINITY);
    let cut = scenes::disc_average(scenes::RADIUS, scenes::WALL_AT);
    let point = scenes::at_point();
    let floor = |name, what: &str, scene, lookup, reference: f64, (rays, values)| {
        let about = About {
            name,
            property: format!("a floor reflects {reference:.6} {what}"),
            equation: &PHOTON_DENSITY,
            subject: MAPPING,
            reference,
            delta: SINGLE,
            values,
        };
        let mapping =
            Mapping { scene, lookup, particles: FEW, radius: scenes::RADIUS, rays: vec![scenes::at_origin(); rays] };
        family_trial(about, mapping)
    };
    vec![
        floor(
            "photon/disc",
            "in the mean over the disc around a point under a light",
            scenes::over_floor(),
            Lookup::Direct,
            whole,
            (1, 30_000),
        ),
        floor(
            "photon/shadow-rays",
            "of a light by shadow rays, and nothing by photons",
            scenes::over_floor(),
            gather,
            point,
            (16, 17_600),
        ),
        floor(
            "photon/index-matched",
            "of a light within glass that is air, all of it caustics, in the mean over the disc",
            scenes::matched(),
            gather,
            whole,
            (8, 40_000),
        ),
        floor(
            "photon/behind",
            "from above of a light below it",
            scenes::under_floor(),
            Lookup::Direct,
            0.0,
            (1, 27_000),
        ),
        floor(
            "photon/corner",
            "of a disc that a wall cuts, whose photons do not count",
            scenes::corner(),
            Lookup::Direct,
            cut,
            (1, 60_000),
        ),
    ]
}

fn cavities() -> Vec<FamilyTrial<EstimatorSubject>> {
    let albedo = 0.5;
    let rho = 0.75;
    let centred = |count| -> Vec<Ray> { spread(count).map(|w| Ray::new(DVec3::ZERO, w)).collect() };
    let off_cap = |count| -> Vec<Ray> {
        spread(count).filter(|w| w.z < 0.9 - 2.0 * CAP_SHARE).map(|w| Ray::new(DVec3::ZERO, w)).collect()
    };
    let cavity = |name, what: String, scene, lookup, rays, particles, reference: f64, values| {
        let about = About {
            name,
            property: format!("{what} the radiance is {reference:.6}"),
            equation: &PHOTON_DENSITY,
            subject: MAPPING,
            reference,
            delta: BOUNCES,
            values,
        };
        let mapping = Mapping { scene, lookup, particles, radius: 0.4, rays };
        family_trial(about, mapping)
    };
    let mut trials = vec![cavity(
        "photon/furnace",
        format!("in a spherical furnace of albedo {albedo}, where lookups on curved walls are exact,"),
        sphere_furnace(lambert(albedo), 0.0),
        Lookup::Direct,
        centred(64),
        256,
        1.0 / (1.0 - albedo),
        NEARLY_SYMMETRIC,
    )];
    if let Ok(scene) = cavity_cap(rho, Cap::Reflecting) {
        let gather = Lookup::Gather { caustic_particles: 1, caustic_radius: 0.4 };
        trials.push(cavity(
            "photon/gather",
            format!("by final gathering, off the reflecting cap of a cavity of albedo {rho},"),
            Arc::new(scene),
            gather,
            off_cap(128),
            512,
            rho * CAP_SHARE / (1.0 - rho),
            6_400,
        ));
    }
    trials
}

fn fluxes() -> Vec<FamilyTrial<EstimatorSubject>> {
    let about = |name, property, reference, delta, values| About {
        name,
        property,
        equation: &PHOTON_FLUX,
        subject: "estimator::photon_map::PhotonMap",
        reference,
        delta,
        values,
    };
    let caustic = scenes::flux_into_glass();
    let mut trials = vec![family_trial(
        about(
            "photon/flux-through-glass",
            format!("of a light beside a glass sphere {caustic:.6} arrive as caustics: what enters leaves"),
            caustic,
            SINGLE,
            18_000,
        ),
        Flux { scene: scenes::glass_in_cavity(), kept: Kept::Caustic, particles: 256 },
    )];
    let albedo = 0.3;
    if let Ok(scene) = furnace_box(albedo) {
        // A cube of side 2: π L A/(1 − a) arrive, a share a of them is reflected, the rest absorbed.
        let arriving = PI * 24.0 / (1.0 - albedo);
        trials.push(family_trial(
            about(
                "photon/flux-balance",
                format!("in a closed box of albedo {albedo} photons of {arriving:.6} arrive"),
                arriving,
                BOUNCES,
                13_000,
            ),
            Flux { scene: Arc::new(scene), kept: Kept::All, particles: 256 },
        ));
    }
    trials
}

/// The mean of the passes' disc averages, each of its own radius.
fn passes() -> FamilyTrial<EstimatorSubject> {
    let count = 12;
    let first = scenes::RADIUS;
    let disc = |index| {
        let radius = radius_squared(first * first, index).sqrt();
        scenes::disc_average(radius, f64::INFINITY)
    };
    let reference = (0..count).map(disc).sum::<f64>() / f64::from(count);
    let about = About {
        name: "photon/passes",
        property: format!("the first {count} passes reflect {reference:.6}, the mean over discs that shrink"),
        equation: &PHOTON_RADIUS,
        subject: "estimator::Sppm",
        reference,
        delta: SINGLE,
        values: NEARLY_SYMMETRIC,
    };
    family_trial(about, Passes { scene: scenes::point_camera(), passes: count, particles: FEW, radius: first })
}
