//! GGX: its distributions by quadrature, its check-up, and a floor rendered under a white sky.

use whitefurnace::harness::bsdf_checkup::Loss;
use whitefurnace::harness::directions::Precision;
use whitefurnace::harness::directions::own_pdf::OwnPdfs;
use whitefurnace::harness::domain::MASS_TOLERANCE;
use whitefurnace::material::Model;
use whitefurnace::material::ggx::{
    Ggx, ndf, sample_visible_normal, smith_g2, smith_lambda, visible_normal_pdf,
};
use whitefurnace::math::frame::from_spherical;

use std::f64::consts::{FRAC_PI_2, FRAC_PI_3};

use crate::bsdf::{Cases, as_rendered, at_every_angle, check_up_sized, integrals};
use crate::mean_radiance::largest;
use crate::prelude::*;
use crate::scenes::{floor, ray_to_origin_at, scene};
use crate::subject::{self, estimates};

/// The functions of the model, so that each can be replaced.
#[derive(Clone, Copy, Debug)]
pub struct GgxParts {
    /// D(m) from α and m.
    pub ndf: fn(f64, DVec3) -> f64,
    /// D_o(m) from α, wo and m.
    pub visible: fn(f64, DVec3, DVec3) -> f64,
    /// Evaluates f_r.
    pub eval: fn(&Ggx, DVec3, DVec3) -> DVec3,
    /// Samples a direction.
    pub sample: fn(&Ggx, DVec3, [f64; 2]) -> Option<DVec3>,
    /// The pdf of a sampled direction.
    pub pdf: fn(&Ggx, DVec3, DVec3) -> f64,
}

/// The program's functions.
const CORRECT: GgxParts = GgxParts {
    ndf,
    visible: visible_normal_pdf,
    eval: Ggx::eval,
    sample: Ggx::sample,
    pdf: Ggx::pdf,
};

/// A reflection model that calls these functions.
#[derive(Debug)]
struct Assembled(Ggx, GgxParts);

impl Model for Assembled {
    fn eval(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        (self.1.eval)(&self.0, wo, wi)
    }
    fn sample(&self, wo: DVec3, random: [f64; 2]) -> Option<DVec3> {
        (self.1.sample)(&self.0, wo, random)
    }
    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        (self.1.pdf)(&self.0, wo, wi)
    }
    fn albedo(&self) -> DVec3 {
        self.0.albedo()
    }
}

fn ggx(reflectance: f64, alpha: f64) -> Ggx {
    Ggx {
        reflectance: DVec3::splat(reflectance),
        alpha,
    }
}

/// Smith's Λ, from the tangent of the inclination.
pub(super) fn lambda(alpha: f64, w: DVec3) -> f64 {
    let tan = w.truncate().length() / w.z;
    0.5 * ((alpha * tan).hypot(1.0) - 1.0)
}

/// Directional albedo as an integral over microfacet normals, not over directions, so that no
/// Jacobian of the half vector enters: ∫ F G₂ D (o · m)/cos θ_o dm, with D in the slope of the
/// microfacet.
pub fn reflected(Ggx { reflectance, alpha }: Ggx, wo: DVec3) -> f64 {
    let f0 = reflectance.x;
    let of_facet = |m: DVec3| {
        let cosine = wo.dot(m);
        let wi = 2.0 * cosine * m - wo;
        if cosine <= 0.0 || wi.z <= 0.0 {
            return 0.0;
        }
        let slope = m.truncate().length() / (alpha * m.z);
        let d = FRAC_1_PI / (alpha * m.z * m.z * (1.0 + slope * slope)).powi(2);
        let seen = 1.0 / (1.0 + lambda(alpha, wo) + lambda(alpha, wi));
        (f0 + (1.0 - f0) * (1.0 - cosine).powi(5)) * seen * d * cosine / wo.z
    };
    Domain::Hemisphere
        .integrate_all(MASS_TOLERANCE, &of_facet)
        .value
}

/// Symbol and values of α, and inclinations of wo in degrees.
const CASES: Cases = Cases {
    symbol: "α",
    parameters: [0.25, 0.8],
    degrees: [0.0, 50.0, 80.0],
};

/// Number of estimates of the floor's radiance.
const SAMPLES: u64 = 4_400_000;
/// Inclination of the view, radians.
const INCLINATION: f64 = 1.0;

/// Compares the radiance of a white floor under a sky of radiance 1, by the path tracer, with its
/// single scattering: it must reflect no more.
fn on_a_floor(context: &Context, parts: GgxParts) -> Vec<Outcome> {
    let metal = ggx(1.0, 0.8);
    let scene = scene("GGX floor", |s| {
        s.background(DVec3::ONE);
        floor(s, Bsdf::model(Assembled(metal, parts)));
    });
    let ray = ray_to_origin_at(INCLINATION);
    let path = Box::new(Path::new(Strategy::Bsdf));
    let wo = from_spherical(INCLINATION, 0.0);
    let reference = reflected(metal, wo);
    let mut radiance = estimates(context.seed_of("radiance"), &scene, path, |_| ray);
    vec![mean_of(
        "radiance",
        reference,
        BOUNCES_DELTA,
        context.n(SAMPLES),
        || radiance().x,
    )]
}

/// Smith's G₁ of GGX with α = 0.1 as Mitsuba 3 keeps it for its own tests, in single precision:
/// inclination in radians and G₁ (mitsuba3 at b45b0a930, src/render/tests/test_microfacet.py).
const MITSUBA_MASKING: [[f64; 2]; 20] = [
    [FRAC_PI_3, 0.99261039],
    [1.074755381491245, 0.99160647],
    [1.102313211785892, 0.99042398],
    [1.12987104208054, 0.98901933],
    [1.157428872375187, 0.98733366],
    [1.184986702669834, 0.98528832],
    [1.212544532964482, 0.98277503],
    [1.240102363259129, 0.97964239],
    [1.267660193553776, 0.97567332],
    [1.295218023848423, 0.97054905],
    [1.322775854143071, 0.9637875],
    [1.350333684437718, 0.95463598],
    [1.377891514732365, 0.94187391],
    [1.405449345027013, 0.92344058],
    [1.43300717532166, 0.8956942],
    [1.460565005616307, 0.85189372],
    [1.488122835910955, 0.77902949],
    [1.515680666205602, 0.65144652],
    [1.543238496500249, 0.41989169],
    [FRAC_PI_2, 3.2584082e-06],
];

/// Largest error that Mitsuba's own test of these numbers allows.
const MITSUBA_TOLERANCE: f64 = 1e-5;

/// Compares the masking factor G₁ = D_o(n)/D(n) with Mitsuba's numbers.
fn masking(_: &Context, parts: GgxParts) -> Vec<Outcome> {
    const ALPHA: f64 = 0.1;
    let error = |[inclination, reference]: [f64; 2]| {
        let wo = from_spherical(inclination, 0.0);
        let masking = (parts.visible)(ALPHA, wo, DVec3::Z) / (parts.ndf)(ALPHA, DVec3::Z);
        (masking - reference).abs()
    };
    let largest = largest(MITSUBA_MASKING.into_iter().map(error));
    vec![Outcome::identity(
        "G₁",
        MITSUBA_MASKING.len() as u64,
        largest,
        MITSUBA_TOLERANCE,
        "α = 0.1",
    )]
}

/// Number of directions that are judged by their own pdf: an interval of ±0.9 % in each region.
const OWN_PDF_SAMPLES: u64 = 5_000_000;
/// Number of draws among which neighbours are looked for: enough for a lobe as smooth as this.
const OWN_PDF_BLOCK: usize = 512;
/// Margin of the mean of a pdf in a region.
const OWN_PDF_MARGIN: f64 = 0.02;

/// Compares the pdf with the density of its own samples, which distances of neighbours tell.
fn own_pdf(context: &Context, parts: GgxParts) -> Vec<Outcome> {
    let (metal, wo) = (ggx(1.0, 0.4), from_spherical(FRAC_PI_3, 0.0));
    let mut rng = context.rng("own pdf");
    let mut own = OwnPdfs::new(Precision::DOUBLE).with_block_size(OWN_PDF_BLOCK);
    for _ in 0..context.n(OWN_PDF_SAMPLES) {
        let wi = (parts.sample)(&metal, wo, uniform2(&mut rng));
        own.push(wi, wi.map_or(0.0, |wi| (parts.pdf)(&metal, wo, wi)));
    }
    own.outcomes(OWN_PDF_MARGIN)
}

fn trials() -> Vec<FamilyTrial<GgxParts>> {
    vec![
        trial(
            "bsdf/ggx-own-pdf",
            "the pdf is the density of the sampled directions, by the distances of their neighbours",
            "multiple importance sampling with rough metal is too bright in one part of the lobe, too dark in another",
            &GGX_VISIBLE,
            "material::ggx::Ggx",
            "t",
            own_pdf,
        ),
        trial(
            "bsdf/ggx-masking",
            "Smith's masking factor has the values that Mitsuba 3 keeps for its own tests",
            "rough metal at grazing angles is brighter or darker than in Mitsuba",
            &GGX_MASKING,
            "material::ggx::visible_normal_pdf, ndf",
            "exact",
            masking,
        ),
        trial(
            "bsdf/ggx",
            "white GGX passes the check-up and has the directional albedo of its microfacets",
            "rough metal is too bright, too dark or full of fireflies",
            &GGX_VISIBLE,
            "material::ggx::Ggx, material::Scattering::sample_rough",
            "BSDF check-up",
            |context, parts: GgxParts| {
                let metal = ggx(1.0, 0.4);
                let model = Bsdf::model(Assembled(metal, parts));
                let subject = as_rendered(subject::CORRECT, model)
                    .energy_bound(1.0)
                    .loss(Loss::Allowed)
                    .albedo(move |wo| reflected(metal, wo));
                let sizes = [
                    (0.0, 3_450_000),
                    (40.0, 3_550_000),
                    (75.0, 2_700_000),
                    (85.0, 2_450_000),
                ];
                check_up_sized(&subject, &sizes, context)
            },
        ),
        trial(
            "bsdf/ggx-normals",
            "the projected areas of the microfacets sum to the surface's area",
            "highlights on rough metal are too strong or too weak at some roughness",
            &GGX_NORMALS,
            "material::ggx::normals",
            "exact",
            |_, parts: GgxParts| {
                integrals(
                    "facets",
                    CASES,
                    |alpha, _, m| (parts.ndf)(alpha, m) * m.z,
                    |_, _| 1.0,
                )
            },
        ),
        trial(
            "bsdf/ggx-visible",
            "the density of visible normals integrates to 1 from every side",
            "rough metal seen at a slant is too bright or dark: hidden facets are sampled",
            &GGX_VISIBLE,
            "material::ggx::visible_normals",
            "exact",
            |_, parts: GgxParts| {
                integrals(
                    "visible",
                    CASES,
                    |alpha, wo, m| (parts.visible)(alpha, wo, m),
                    |_, _| 1.0,
                )
            },
        ),
        trial(
            "bsdf/ggx-coloured",
            "GGX of reflectance 0.5 has the directional albedo of its microfacets",
            "rough metal reflects light that its own facets hide, or too little",
            &GGX_MASKING,
            "material::ggx::Ggx",
            "exact",
            |_, parts: GgxParts| {
                let f = |alpha, wo, wi: DVec3| (parts.eval)(&ggx(0.5, alpha), wo, wi).x * wi.z;
                integrals("coloured furnace", CASES, f, |alpha, wo| {
                    reflected(ggx(0.5, alpha), wo)
                })
            },
        ),
        trial(
            "furnace/ggx-floor",
            "a white rough metal, rendered with its own sampler, loses the light that meets a second microfacet",
            "a floor of rough metal glows under an even sky, or darkens more than facets explain",
            &GGX_MASKING,
            "integrator::Path, material::ggx::Ggx",
            "t",
            on_a_floor,
        ),
    ]
}

/// f_r with another masking-shadowing factor, given as `share`.
fn masked(metal: &Ggx, wo: DVec3, wi: DVec3, share: f64) -> DVec3 {
    metal.eval(wo, wi) * share / smith_g2(metal.alpha, wo, wi)
}

/// Direction into which a microfacet reflects wo; `None` if it is below the surface.
fn mirrored(wo: DVec3, m: DVec3) -> Option<DVec3> {
    let wi = 2.0 * wo.dot(m) * m - wo;
    (wi.z > 0.0).then_some(wi)
}

fn faults() -> Vec<Fault<GgxParts>> {
    vec![
        fault!("one-sided", GGX_MASKING, "masking towards the eye, no shadowing towards the light",
            GgxParts: { eval: |metal, wo, wi| masked(metal, wo, wi, 1.0 / (1.0 + smith_lambda(metal.alpha, wo))) },
            "bsdf/ggx: reciprocity", "bsdf/ggx-coloured", "furnace/ggx-floor"),
        fault!("uncorrelated", GGX_MASKING, "masking and shadowing independent of each other",
            GgxParts: { eval: |metal, wo, wi| {
                let [o, i] = [wo, wi].map(|w| 1.0 / (1.0 + smith_lambda(metal.alpha, w)));
                masked(metal, wo, wi, o * i)
            } },
            "bsdf/ggx: directional albedo at 75 degrees", "bsdf/ggx-coloured", "furnace/ggx-floor"),
        fault!("no-jacobian", GGX_VISIBLE, "the pdf is that of the half vector",
            GgxParts: { pdf: |metal, wo, wi| visible_normal_pdf(metal.alpha, wo, (wo + wi).normalize()) },
            at_every_angle!("bsdf/ggx", "furnace"),
            "bsdf/ggx-own-pdf: pdf in region 1 | pdf in region 2 | pdf in region 3 | pdf in region 4 \
             | pdf in region 5 | pdf in region 6 | pdf in region 7 | pdf in region 8 \
             | component 1 of the distances | component 2 of the distances"),
        fault!("all-normals", GGX_VISIBLE,
            "microfacets are sampled by their area, visible or not; the pdf is that of the visible ones",
            GgxParts: { sample: |metal, wo, [r1, r2]| {
                let tan = metal.alpha * (r1 / (1.0 - r1)).sqrt();
                mirrored(wo, from_spherical(tan.atan(), TAU * r2))
            } },
            "bsdf/ggx: chi-square of samples at 40 degrees | chi-square of samples at 75 degrees \
             | chi-square of samples at 85 degrees",
            "bsdf/ggx-own-pdf: component 1 of the distances"),
        fault!("roughness-squared-twice", GGX_NORMALS, "α² for α where microfacets are sampled",
            GgxParts: { sample: |metal, wo, random| {
                mirrored(wo, sample_visible_normal(metal.alpha * metal.alpha, wo, random))
            } },
            at_every_angle!("bsdf/ggx", "chi-square of samples"),
            "bsdf/ggx-own-pdf: component 1 of the distances"),
        fault!("pdf-too-high", GGX_VISIBLE, "a pdf that is 3 % too high",
            GgxParts: { pdf: |metal, wo, wi| 1.03 * metal.pdf(wo, wi) },
            at_every_angle!("bsdf/ggx", "furnace"), "furnace/ggx-floor"),
        fault!("fourth-power", GGX_MASKING, "Schlick's reflectance with the fourth power",
            GgxParts: { eval: |metal, wo, wi| {
                let cosine = wo.dot((wo + wi).normalize());
                let wrong = metal.reflectance + (1.0 - metal.reflectance) * (1.0 - cosine).powi(4);
                metal.eval(wo, wi) * wrong / metal.fresnel(cosine)
            } },
            "bsdf/ggx-coloured"),
        fault!("not-projected", GGX_NORMALS, "D normalised over solid angle, not over the projected area",
            GgxParts: { ndf: |alpha, m| ndf(alpha, m) * m.z }, "bsdf/ggx-normals"),
        fault!("cosine-forgotten", GGX_VISIBLE, "D_o without 1/cos θ_o",
            GgxParts: { visible: |alpha, wo, m| visible_normal_pdf(alpha, wo, m) * wo.z },
            "bsdf/ggx-visible", "bsdf/ggx-masking"),
    ]
}

/// Trials and faults of GGX.
pub fn families() -> Vec<Box<dyn AnyFamily>> {
    vec![Box::new(Family {
        trials: trials(),
        faults: faults(),
        ..Family::new("ggx", CORRECT)
    })]
}
