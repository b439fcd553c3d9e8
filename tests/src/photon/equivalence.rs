//! Photon mapping against the path tracer where no closed form is known: the same radiance within
//! the bias of photon mapping.

use whitefurnace::harness::mean::welch;
use whitefurnace::integrator::{Lookup, PhotonMapping};
use whitefurnace::sampling::rng::stream;
use whitefurnace::scene::room::diffuse;

use crate::photon::faults::HALVED;
use crate::photon::scenes;
use crate::prelude::*;
use crate::scenes::valid;
use crate::subject::{estimates, sample};

/// Compares the mean radiance along random rays by final gathering with that by the path tracer.
struct SameRadiance {
    scene: Arc<Scene>,
    ray: Rays,
    particles: u32,
    radius: f64,
    /// Number of maps, and of rays with each.
    maps: u64,
    rays: u64,
    /// Number of paths of the path tracer.
    paths: u64,
    margin: f64,
}

impl Property for SameRadiance {
    fn run(&self, context: &Context, setup: Configuration<'_>) -> Vec<Outcome> {
        let scene = &*self.scene;
        let path = Box::new(Path::default());
        let mut along = estimates(context.seed_of("paths"), scene, path, self.ray);
        let paths = Values::collect(0.0, context.n(self.paths), || along().x);
        let centre = paths.moments.mean();
        let seed = context.seed_of("maps");
        let lookup = Lookup::FinalGather {
            caustic_particles: self.particles,
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
                (seed, index),
            ) else {
                return f64::NAN;
            };
            let mut samples = (0..self.rays).map(|ray| {
                let mut rng = stream(seed, index, ray as u32);
                sample((self.ray)(&mut rng), rng)
            });
            let seen = photons.radiances(scene, &mut samples);
            index += 1;
            seen.iter().map(|radiance| radiance.x).sum::<f64>() / self.rays as f64
        });
        let claim = Claim::Equivalent {
            margin: self.margin * centre,
        };
        vec![welch("difference of the means", &maps, &paths, claim)]
    }
}

/// Samples a ray from the room's camera to a part of its floor away from objects and walls.
fn room_floor(rng: &mut Stream) -> Ray {
    let [u, v] = uniform2(rng);
    let eye = DVec3::new(12.5, 0.0, 0.0);
    let target = DVec3::new(7.0 + 3.0 * u, 4.0 * v - 2.0, -5.0);
    Ray::new(eye, (target - eye).normalize())
}

/// Samples a ray from just above to the disc that the caustic covers.
fn caustic_floor(rng: &mut Stream) -> Ray {
    let [u, v] = uniform2(rng);
    let (sin, cos) = (TAU * v).sin_cos();
    let radius = scenes::CAUSTIC * u.sqrt();
    Ray::new(DVec3::new(radius * cos, radius * sin, 0.01), -DVec3::Z)
}

pub(super) fn trials() -> Vec<FamilyTrial<EstimatorSubject>> {
    let caustic = SameRadiance {
        scene: scenes::caustic(1.5),
        ray: caustic_floor,
        particles: 512,
        radius: 0.05,
        maps: 8_500,
        rays: 128,
        paths: 3_100_000,
        // The blur of the caustic's edge costs about half a per cent.
        margin: 0.025,
    };
    let room = SameRadiance {
        scene: valid(diffuse()),
        ray: room_floor,
        particles: 1000,
        radius: 0.1,
        // So many that the skewness of so few photons within the radius does not matter.
        maps: 5_300,
        rays: 800,
        paths: 700_000,
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
