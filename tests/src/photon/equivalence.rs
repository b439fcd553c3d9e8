//! Photon mapping against the path tracer where no closed form is known: the same radiance within
//! the bias of photon mapping.

use whitefurnace::harness::mean::welch;
use whitefurnace::integrator::{Lookup, PhotonMapping};
use whitefurnace::scene::room::diffuse;

use crate::mean_radiance::{points, scramble_means};
use crate::photon::faults::HALVED;
use crate::photon::replications::sobol_pass;
use crate::photon::scenes;
use crate::prelude::*;
use crate::scenes::{mean_channel, valid};
use crate::subject::sample;

/// Rays of the path tracer per scramble.
const POINTS: u16 = 64;

/// Compares the mean radiance along random rays by final gathering with that by the path tracer.
struct SameRadiance {
    scene: Arc<Scene>,
    ray: Rays,
    particles: u32,
    /// Particles of the map of caustics.
    caustic_particles: u32,
    radius: f64,
    /// Number of maps, and of rays with each.
    maps: u64,
    rays: u16,
    /// Number of scrambles of rays of the path tracer.
    scrambles: u64,
    margin: f64,
}

impl Property for SameRadiance {
    fn run(&self, context: &Context, setup: Configuration<'_>) -> Vec<Outcome> {
        let scene = &*self.scene;
        let path = Box::new(Path::default());
        let means = scramble_means(context.seed_of("paths"), POINTS, scene, path, self.ray);
        let paths = Values::collect(0.0, context.n(self.scrambles), means);
        let centre = paths.moments.mean();
        let seed = context.seed_of("maps");
        let lookup = Lookup::FinalGather {
            caustic_particles: self.caustic_particles,
            caustic_radius: self.radius,
        };
        let mut index = 0;
        let maps = Values::collect(centre, context.n(self.maps), || {
            let Ok(photons) = PhotonMapping::new(
                setup.parts,
                scene,
                lookup,
                self.particles,
                self.radius,
                sobol_pass(seed, index),
            ) else {
                return f64::NAN;
            };
            let mut samples = points(seed, 1, index, self.rays).map(|point| {
                let mut rng = SampleStream::from(point);
                sample((self.ray)(&mut rng), rng)
            });
            let seen = photons.radiances(scene, &mut samples);
            index += 1;
            mean_channel(scene, seen.iter().sum()) / f64::from(self.rays)
        });
        let claim = Claim::Equivalent {
            margin: self.margin * centre,
        };
        vec![welch("difference of the means", &maps, &paths, claim)]
    }
}

/// Samples a ray from the room's camera to a part of its floor away from objects and walls.
fn room_floor(rng: &mut SampleStream) -> Ray {
    let [u, v] = uniform2(rng);
    let eye = DVec3::new(12.5, 0.0, 0.0);
    let target = DVec3::new(7.0 + 3.0 * u, 4.0 * v - 2.0, -5.0);
    Ray::new(eye, (target - eye).normalize())
}

/// Samples a ray from just above to the disc that the caustic covers.
fn caustic_floor(rng: &mut SampleStream) -> Ray {
    let [u, v] = uniform2(rng);
    let (sin, cos) = (TAU * v).sin_cos();
    let radius = scenes::CAUSTIC * u.sqrt();
    Ray::new(DVec3::new(radius * cos, radius * sin, 0.01), -DVec3::Z)
}

pub(super) fn trials() -> Vec<FamilyTrial<EstimatorSubject>> {
    let caustic = SameRadiance {
        scene: scenes::caustic(1.5),
        ray: caustic_floor,
        particles: 256,
        caustic_particles: 256,
        radius: 0.05,
        maps: 9_600,
        rays: 64,
        scrambles: 20_000,
        // The blur of the caustic's edge costs about half a per cent.
        margin: 0.025,
    };
    let room = SameRadiance {
        scene: valid(diffuse()),
        ray: room_floor,
        particles: 250,
        // Nothing in this room makes caustics.
        caustic_particles: 10,
        // So large that the skewness of so few photons within the radius does not matter. Near the
        // edges of the room it costs a third of a per cent.
        radius: 0.25,
        maps: 9_000,
        rays: 256,
        scrambles: 10_000,
        margin: 0.02,
    };
    [
        (
            "photon/caustic",
            "the caustic of a glass ball is much brighter or dimmer by photons than by paths",
            "in the caustic of a glass sphere",
            caustic,
        ),
        (
            "photon/diffuse-room",
            "a room by photons is visibly darker or brighter than by paths",
            "on the floor of the diffuse room",
            room,
        ),
    ]
    .into_iter()
    .map(|(name, consequence, place, same)| {
        let percent = 100.0 * same.margin;
        let property = format!(
            "photon mapping and the path tracer find the same light {place} within {percent} %"
        );
        trial(
            name,
            property,
            consequence,
            &PHOTON_DENSITY,
            "estimator::PhotonMapping",
            "Welch, equivalence",
            with_parts(same),
        )
    })
    .collect()
}

/// Faults that these trials must reject.
pub(super) fn faults() -> Vec<Fault<EstimatorSubject>> {
    vec![
        fault!("photons-halved", PHOTON_DENSITY, "albedo/2π for the BRDF of photons",
        = parts(HALVED), "photon/caustic", "photon/diffuse-room"),
    ]
}
