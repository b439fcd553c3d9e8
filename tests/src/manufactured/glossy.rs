//! A glossy patch in a field of light that is a known function of direction.
//!
//! Under an even sky only the sum of a lobe shows. Here the patch is at the centre of a black
//! spherical cavity in three zones, each of which emits in a channel of its own, and is tilted
//! against them: each channel shows the part of the lobe that falls into one zone.

use std::any::Any;
use std::sync::LazyLock;

use whitefurnace::material::Model as _;
use whitefurnace::material::ggx::Ggx;
use whitefurnace::material::rough_glass::RoughGlass;
use whitefurnace::sampling::sampler::{ImagePass, SamplerKind};

use crate::image_mean::ImageEstimatorKind;
use crate::images::not_a_film;
use crate::mean_radiance::{path, points};
use crate::prelude::*;

use super::patch::{GLASS, METAL, Patch};

/// Radiance that each zone sends along the view by way of the patch, integrated once for all
/// faults.
static BY_METAL: LazyLock<[f64; 3]> = LazyLock::new(|| METAL.radiances());
static BY_GLASS: LazyLock<[f64; 3]> = LazyLock::new(|| GLASS.radiances());

/// An outcome: its name, and the weight of each zone, whose light is in units of its answer.
type Judged = (&'static str, [f64; 3]);

const ALL: Judged = ("all zones", [1.0 / 3.0; 3]);
const FIRST: Judged = ("zone 1", [1.0, 0.0, 0.0]);
const SECOND: Judged = ("zone 2", [0.0, 1.0, 0.0]);
const THIRD: Judged = ("zone 3", [0.0, 0.0, 1.0]);

/// How a value is drawn.
#[derive(Clone, Copy)]
enum By {
    /// The mean of rays to the centre of the patch, [`POINTS`] of one scrambled Sobol' sequence.
    Rays(EstimatorKind),
    /// The mean of an image of the patch by bidirectional path tracing.
    Image,
}

/// Rays per value.
const POINTS: u16 = 64;
/// Width and height of an image.
const SIDE: u32 = 4;
/// Passes per image.
const PASSES: u32 = 4;

/// Compares the light of the zones by way of the patch with its integral.
struct InZones<const N: usize> {
    scene: Arc<Scene>,
    ray: Ray,
    answers: fn() -> [f64; 3],
    by: By,
    judged: [Judged; N],
    count: u64,
}

impl<const N: usize> InZones<N> {
    /// Returns one value of the radiance; `None` if no film can hold it, which is a fault.
    fn value(&self, setup: Configuration<'_>, seed: u64, number: u32) -> Option<DVec3> {
        match self.by {
            By::Rays(kind) => {
                let rays = points(seed, 0, number, POINTS).map(|numbers| (self.ray, numbers));
                let radiances = kind.radiances(setup, &self.scene, rays);
                Some(radiances.iter().sum::<DVec3>() / f64::from(POINTS))
            }
            By::Image => {
                let mut sum = DVec3::ZERO;
                for index in number * PASSES..(number + 1) * PASSES {
                    let pass = ImagePass {
                        sampler: SamplerKind::Sobol(PASSES),
                        seed,
                        index,
                    };
                    let frame = [SIDE; 2];
                    let image =
                        ImageEstimatorKind::Bdpt.pass(setup.parts, &self.scene, frame, pass)?;
                    sum += image.iter().sum::<DVec3>();
                }
                Some(sum / f64::from(SIDE * SIDE * PASSES))
            }
        }
    }
}

impl<const N: usize> Property for InZones<N> {
    fn run(&self, context: &Context, setup: Configuration<'_>) -> Vec<Outcome> {
        let (seed, answers) = (
            context.seed_of("patch"),
            DVec3::from_array((self.answers)()),
        );
        let mut values = [Values::new(1.0); N];
        for number in 0..context.n(self.count) as u32 {
            let Some(value) = self.value(setup, seed, number) else {
                return not_a_film("image");
            };
            for (values, (_, weights)) in values.iter_mut().zip(self.judged) {
                values.push((value / answers).dot(DVec3::from_array(weights)));
            }
        }
        let outcome = |((name, _), values): (Judged, &Values)| {
            mean(name, values, 1.0, Claim::Equal { delta: IMAGE_DELTA })
        };
        self.judged.into_iter().zip(&values).map(outcome).collect()
    }
}

/// Returns a trial of a patch.
fn of_patch<const N: usize>(
    [name, property, consequence]: [&'static str; 3],
    equation: &'static Equation,
    by: By,
    patch: &Patch,
    answers: fn() -> [f64; 3],
    judged: [Judged; N],
    count: u64,
) -> FamilyTrial<EstimatorSubject> {
    let in_zones = InZones {
        scene: patch.scene(),
        ray: patch.ray(),
        answers,
        by,
        judged,
        count,
    };
    let subject = match by {
        By::Rays(kind) => path(kind),
        By::Image => "integrator::Bdpt",
    };
    trial(
        name,
        property,
        consequence,
        equation,
        subject,
        "t",
        with_parts(in_zones),
    )
}

/// Trials of the patches.
pub(super) fn trials() -> Vec<FamilyTrial<EstimatorSubject>> {
    let metal = || *BY_METAL;
    vec![
        of_patch(
            [
                "manufactured/glossy/path",
                "rough metal reflects of each zone of a cavity the integral of its lobe over that zone",
                "highlights on rough metal are too wide, too narrow, off their place or of another hue",
            ],
            &GGX_MASKING,
            By::Rays(EstimatorKind::Path),
            &METAL,
            metal,
            [FIRST, SECOND, THIRD],
            13_500,
        ),
        of_patch(
            [
                "manufactured/glossy/report",
                "shadow rays find the integrals of a metal's lobe over the zones of a cavity",
                "the report's method gives rough metal a highlight of another width or place",
            ],
            &GGX_MASKING,
            By::Rays(EstimatorKind::Report(2)),
            &METAL,
            metal,
            [ALL],
            9_500,
        ),
        of_patch(
            [
                "manufactured/glossy/bdpt",
                "images of rough metal show the integrals of its lobe over the zones of a cavity",
                "rough metal in bidirectional images has a highlight of another width or place",
            ],
            &GGX_MASKING,
            By::Image,
            &METAL,
            metal,
            [ALL],
            6_600,
        ),
        of_patch(
            [
                "manufactured/glossy/rough-glass",
                "rough glass shows of each zone of a cavity the integral of its lobes over that zone",
                "what is behind frosted glass is blurred too much or too little, or shifted",
            ],
            &ROUGH_GLASS,
            By::Rays(EstimatorKind::Path),
            &GLASS,
            || *BY_GLASS,
            [FIRST, SECOND, ALL],
            10_800,
        ),
    ]
}

/// Evaluates the lobe of a metal or of rough glass with changes; other surfaces keep theirs.
fn changed(
    bsdf: &Bsdf,
    [wo, wi]: [DVec3; 2],
    metal: fn(&Ggx, DVec3, DVec3) -> DVec3,
    glass: fn(&RoughGlass, DVec3, DVec3) -> f64,
) -> DVec3 {
    let right = DefaultParts.brdf(bsdf, wo, wi);
    if right == DVec3::ZERO {
        return right;
    }
    match bsdf {
        Bsdf::RoughGlass(found) => DVec3::splat(glass(found, wo, wi)),
        Bsdf::Model(model) => {
            let model: &dyn Any = *model;
            let found = model.downcast_ref::<Ggx>();
            found.map_or(right, |found| metal(found, wo, wi))
        }
        _ => right,
    }
}

/// Returns a direction turned by 90° about the normal.
fn turned(w: DVec3) -> DVec3 {
    DVec3::new(-w.y, w.x, w.z)
}

/// Faults that the patches show.
pub(super) fn faults() -> Vec<Fault<EstimatorSubject>> {
    vec![
        fault!("lobe-turned", GGX_NORMALS, "the lobe is turned about the normal by a right angle",
            { brdf: |bsdf, wo, wi| changed(bsdf, [wo, turned(wi)], Ggx::eval, RoughGlass::eval) },
            "manufactured/glossy/path: zone 1 | zone 2 | zone 3", "manufactured/glossy/report",
            "manufactured/glossy/rough-glass: zone 2"),
        fault!("lobe-narrow", GGX_NORMALS, "eval has a roughness that is a tenth lower",
            { brdf: |bsdf, wo, wi| changed(bsdf, [wo, wi],
                |metal, wo, wi| Ggx { alpha: 0.9 * metal.alpha, ..*metal }.eval(wo, wi),
                |glass, wo, wi| RoughGlass { alpha: 0.9 * glass.alpha, ..*glass }.eval(wo, wi)) },
            "manufactured/glossy/path: zone 1 | zone 2 | zone 3", "manufactured/glossy/report",
            "manufactured/glossy/bdpt", "manufactured/glossy/rough-glass: zone 1 | zone 2 | all zones"),
        fault!("fresnel-of-the-normal", GGX_MASKING, "Schlick's reflectance at the surface's normal, not the facet's",
            { brdf: |bsdf, wo, wi| changed(bsdf, [wo, wi],
                |metal, wo, wi| {
                    let cosine = wo.dot((wo + wi).normalize());
                    metal.eval(wo, wi) * metal.fresnel(wo.z) / metal.fresnel(cosine)
                },
                RoughGlass::eval) },
            "manufactured/glossy/path: zone 3"),
        fault!("channels-of-the-metal", GGX_MASKING, "red and blue are exchanged in the reflectance of rough metal",
            { brdf: |bsdf, wo, wi| changed(bsdf, [wo, wi],
                |metal, wo, wi| {
                    let DVec3 { x, y, z } = metal.reflectance;
                    Ggx { reflectance: DVec3::new(z, y, x), ..*metal }.eval(wo, wi)
                },
                RoughGlass::eval) },
            "manufactured/glossy/path: zone 1 | zone 3", "manufactured/glossy/report",
            "manufactured/glossy/bdpt"),
        fault!("refracted-by-the-inverse", ROUGH_GLASS_REFRACTION, "light from behind is weighted with facets of the inverse index",
            { brdf: |bsdf, wo, wi| changed(bsdf, [wo, wi], Ggx::eval, |glass, wo, wi| {
                let index = if wi.z < 0.0 { glass.index.recip() } else { glass.index };
                RoughGlass { index, ..*glass }.eval(wo, wi)
            }) },
            "manufactured/glossy/rough-glass: zone 1 | zone 2"),
    ]
}
