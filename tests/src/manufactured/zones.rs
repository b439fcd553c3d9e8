//! A cavity in zones of known radiance.
//!
//! A furnace has one albedo and one emission, so it cannot tell surfaces from each other. In a
//! spherical cavity every point sees every area under the same form factor. Its walls can therefore
//! be cut in zones, each with an albedo ρ and an emission e of its own in every channel, and the
//! radiance of zone i is Lᵢ = eᵢ + ρᵢ Σ h e/(1 − Σ h ρ), where h are the zones' shares of the area.

use glam::Vec3Swizzles;
use whitefurnace::integrator::NextEvent;
use whitefurnace::sampling::sampler::SamplerKind;
use whitefurnace::sampling::warp::sphere_zone;

use crate::image_mean::{ImageEstimatorKind, Passes, Region, image_of_regions};
use crate::mean_radiance::{any_direction, path};
use crate::prelude::*;
use crate::scenes::{mean_channel, seen_by};

use super::{add_zone, with_altered_albedo};

/// A zone of the cavity.
struct Zone {
    /// Lowest and highest z on the unit sphere.
    z: [f64; 2],
    albedo: DVec3,
    /// Radiance emitted in each channel.
    emission: DVec3,
}

/// The zones from the lowest to the highest. No two have colours in the same proportion, and one
/// does not emit. Albedos are so low that the report's estimator has a third moment.
const ZONES: [Zone; 4] = [
    Zone {
        z: [-1.0, -0.6],
        albedo: DVec3::new(0.6, 0.2, 0.4),
        emission: DVec3::new(1.0, 0.5, 2.0),
    },
    Zone {
        z: [-0.6, 0.0],
        albedo: DVec3::new(0.1, 0.5, 0.6),
        emission: DVec3::ZERO,
    },
    Zone {
        z: [0.0, 0.5],
        albedo: DVec3::new(0.4, 0.6, 0.2),
        emission: DVec3::new(0.3, 1.5, 0.5),
    },
    Zone {
        z: [0.5, 1.0],
        albedo: DVec3::new(0.5, 0.1, 0.3),
        emission: DVec3::new(0.5, 0.2, 0.8),
    },
];

/// Absorption of all zones, which ends the report's paths.
const ABSORPTION: f64 = 0.25;
/// Segments of the report's estimator: the remainder is below 0.6³⁰, 2·10⁻⁷ of the whole.
const SEGMENTS: u32 = 30;

/// Names of the outcomes, a zone each.
const NAMES: [&str; 4] = ["zone 1", "zone 2", "zone 3", "zone 4"];

/// Builds the cavity, seen from its centre along the border of the second and the third zone, which
/// fill the lower and the upper half of the image.
fn cavity() -> Arc<Scene> {
    let camera = Camera::new(DVec3::ZERO, DVec3::new(0.6, 0.8, 0.0), DVec3::Z, 0.3);
    seen_by(camera, "cavity in zones", |s| {
        for zone in &ZONES {
            let surface = Surface::new(Bsdf::Lambert {
                albedo: zone.albedo,
            })
            .emitting(zone.emission)
            .absorbing(ABSORPTION);
            add_zone(s, zone.z, surface);
        }
    })
}

/// Returns the radiance of each zone.
fn radiances() -> [DVec3; 4] {
    let sum = |of: fn(&Zone) -> DVec3| {
        let share = |zone: &Zone| 0.5 * (zone.z[1] - zone.z[0]);
        ZONES
            .iter()
            .map(|zone| share(zone) * of(zone))
            .sum::<DVec3>()
    };
    let incident = sum(|zone| zone.emission) / (DVec3::ONE - sum(|zone| zone.albedo));
    [0, 1, 2, 3].map(|i| ZONES[i].emission + ZONES[i].albedo * incident)
}

/// Samples a ray from within the cavity to a point uniform on a zone.
fn to_zone<const I: usize>(rng: &mut SampleStream) -> Ray {
    let origin = 0.4 * uniform(rng) * any_direction(rng);
    let target = sphere_zone(uniform2(rng), 1.0, ZONES[I].z);
    Ray::new(origin, (target - origin).normalize())
}

const RAYS: [Rays; 4] = [to_zone::<0>, to_zone::<1>, to_zone::<2>, to_zone::<3>];

/// Compares the mean radiance of rays to each zone with its closed form.
struct ZoneRadiances {
    scene: Arc<Scene>,
    kind: EstimatorKind,
    /// Rays to each zone at scale 1.
    rays: u64,
}

impl Property for ZoneRadiances {
    fn run(&self, context: &Context, setup: Configuration<'_>) -> Vec<Outcome> {
        let zone = |((name, ray), radiance): ((&str, Rays), DVec3)| {
            let reference = mean_channel(&self.scene, radiance);
            let probe = Probe {
                scene: Arc::clone(&self.scene),
                kind: self.kind,
                ray,
            };
            let mut radiance = probe.radiances(setup, context.seed_of(name));
            mean_of(name, reference, IMAGE_DELTA, context.n(self.rays), || {
                mean_channel(&self.scene, radiance())
            })
        };
        NAMES
            .into_iter()
            .zip(RAYS)
            .zip(radiances())
            .filter(|((name, _), _)| context.asks_for(name))
            .map(zone)
            .collect()
    }
}

/// Returns a trial of rays to each zone.
fn by_rays(
    name: &'static str,
    consequence: &'static str,
    kind: EstimatorKind,
    rays: u64,
) -> FamilyTrial<EstimatorSubject> {
    let scene = cavity();
    trial(
        name,
        "each zone of a cavity has the radiance e + ρ Σhe/(1 − Σhρ) in all channels",
        consequence,
        &RENDERING,
        path(kind),
        "t",
        with_parts(ZoneRadiances { scene, kind, rays }),
    )
}

/// Returns a trial of images by bidirectional path tracing, of which each half shows one zone.
fn by_images() -> FamilyTrial<EstimatorSubject> {
    let scene = cavity();
    let [_, lower, upper, _] = radiances().map(|radiance| mean_channel(&scene, radiance));
    let half = |name, holds| Region {
        name,
        holds,
        delta: IMAGE_DELTA,
    };
    let passes = Passes {
        scene,
        kind: ImageEstimatorKind::Bdpt,
        frame: [12, 8],
        sampler: SamplerKind::Independent,
        count: 13_000,
    };
    let regions = vec![
        (half(NAMES[1], |[_, y], [_, height]| 2 * y >= height), lower),
        (half(NAMES[2], |[_, y], [_, height]| 2 * y < height), upper),
    ];
    image_of_regions(
        "manufactured/zones/bdpt",
        "the halves of an image of a cavity show the radiance of two of its zones",
        "a wall has its neighbour's brightness or hue in bidirectional images",
        &RENDERING,
        &passes,
        regions,
    )
}

/// Evaluates the BRDF of a zone with the albedo that `altered` gives it.
fn altered(bsdf: &Bsdf, wo: DVec3, wi: DVec3, altered: fn(usize) -> DVec3) -> DVec3 {
    let zones = ZONES.each_ref().map(|zone| zone.albedo);
    let bsdf = with_altered_albedo(bsdf, &zones, altered);
    DefaultParts.brdf(&bsdf, wo, wi)
}

/// Trials of the cavity.
pub(super) fn trials() -> Vec<FamilyTrial<EstimatorSubject>> {
    vec![
        by_rays(
            "manufactured/zones/path",
            "walls exchange their albedos or lamps are lost, which no even furnace shows",
            EstimatorKind::Path,
            340_000,
        ),
        by_rays(
            "manufactured/zones/report",
            "the report's method confuses walls or lamps of different brightness",
            EstimatorKind::Report(SEGMENTS),
            450_000,
        ),
        by_images(),
    ]
}

/// Faults that the cavity shows.
pub(super) fn faults() -> Vec<Fault<EstimatorSubject>> {
    vec![
        fault!("albedos-swapped", RENDERING, "two neighbouring zones have each other's albedo",
            { brdf: |bsdf, wo, wi| altered(bsdf, wo, wi, |i| ZONES[[1, 0, 2, 3][i]].albedo) },
            "manufactured/zones/path: zone 1 | zone 2",
            "manufactured/zones/report: zone 1 | zone 2",
            "manufactured/zones/bdpt: zone 2"),
        fault!("albedo-of-the-last", RENDERING, "the last but one zone has the albedo of the last",
            { brdf: |bsdf, wo, wi| altered(bsdf, wo, wi, |i| ZONES[[0, 1, 3, 3][i]].albedo) },
            "manufactured/zones/path: zone 3", "manufactured/zones/report: zone 3",
            "manufactured/zones/bdpt: zone 3"),
        fault!("channels-of-one-zone", RENDERING, "red and green are exchanged in the albedo of one zone",
            { brdf: |bsdf, wo, wi| altered(bsdf, wo, wi, |i| {
                let albedo = ZONES[i].albedo;
                if i == 0 { albedo.yxz() } else { albedo }
            }) },
            "manufactured/zones/path: zone 1", "manufactured/zones/report: zone 1"),
        fault!("wall-lost", RENDERING, "one zone reflects nothing",
            { brdf: |bsdf, wo, wi| altered(bsdf, wo, wi, |i| {
                if i == 3 { DVec3::ZERO } else { ZONES[i].albedo }
            }) },
            "manufactured/zones/path: zone 4", "manufactured/zones/report: zone 4"),
        fault!("emitter-lost", LIGHT_PICK, "the last emitter is never sampled; another is in its place",
            { pick_emitter: |r, picks| DefaultParts.pick_emitter(r, picks).min(1) },
            "manufactured/zones/bdpt: zone 2 | zone 3"),
        fault!("picked-evenly", LIGHT_PICK, "emitters are picked by power, with the pdf of an even pick",
            { pdf_of_pick: |pdf, _| pdf / 3.0 },
            "manufactured/zones/path: zone 2 | zone 3", "manufactured/zones/report: zone 2 | zone 3"),
    ]
}
