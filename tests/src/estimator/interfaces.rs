//! Faults of mirrors and glass, (10)-(12) and refraction.

use whitefurnace::material::fresnel::{
    radiance_factor, reflect, reflectance, reflectance_p, reflectance_s, refract,
};

use crate::fresnel::{no_total_reflection, schlick};
use crate::prelude::*;

pub(super) fn faults() -> Vec<Fault<EstimatorSubject>> {
    vec![
        fault!("only-s", FRESNEL_S, "(10) alone",
            { fresnel: reflectance_s }, "glass/reflects-60", "glass/snell-aim", "glass/slab"),
        fault!("only-p", FRESNEL_P, "(11) alone", { fresnel: reflectance_p }, "glass/reflects-75", "glass/reflects-60"),
        fault!("schlick", FRESNEL, "Schlick's approximation",
            { fresnel: schlick }, "glass/reflects-60", "glass/vanishing"),
        fault!("indices-swapped", FRESNEL, "n₁ and n₂ exchanged in (12)",
            { fresnel: |c, n1, n2| reflectance(c, n2, n1) }, "glass/reflects-60", "glass/reflects-85"),
        fault!("no-total-reflection", FRESNEL,
            "past the critical angle a finite R, and light that leaves straight on",
            { fresnel: no_total_reflection, refract: |d, n, n1, n2| Some(refract(d, n, n1, n2).unwrap_or(d)) },
            "glass/total-reflection", "glass/cube-trapped", "glass/prism"),
        fault!("no-radiance-factor", REFRACTION, "T = 1 − R is all that refraction does, as the report has it",
            { radiance_factor: |_, _| 1.0 }, "glass/cube-inside", "glass/lit-from-below", "furnace/rough-glass",
            "glass/rough-by-both", "sky/rough-glass"),
        fault!("radiance-factor-inverted", REFRACTION, "(n₂/n₁)² for (n₁/n₂)²",
            { radiance_factor: |n1, n2| radiance_factor(n2, n1) }, "glass/cube-inside", "glass/lit-from-below",
            "furnace/rough-glass", "glass/rough-by-both", "sky/rough-glass"),
        fault!("radiance-factor-twice", REFRACTION, "(n₁/n₂)⁴ for (n₁/n₂)²",
            { radiance_factor: |n1, n2| radiance_factor(n1, n2).powi(2) }, "glass/lit-from-below",
            "furnace/rough-glass", "glass/rough-by-both", "sky/rough-glass"),
        fault!("nothing-from-behind", ROUGH_GLASS, "light from behind a rough surface is not seen",
            { brdf: |bsdf, wo, wi| if wi.z > 0.0 { bsdf.eval(wo, wi) } else { DVec3::ZERO } },
            "furnace/rough-glass", "glass/rough-by-both", "sky/rough-glass"),
        fault!("snell-inverted", REFRACTION, "n₂/n₁ for n₁/n₂ in Snell's law",
            { refract: |d, n, n1, n2| refract(d, n, n2, n1) }, "glass/snell-aim"),
        fault!("not-refracted", REFRACTION, "light goes straight on into the glass",
            { refract: |d, n, n1, n2| refract(d, n, n1, n2).map(|_| d) }, "glass/snell-aim"),
        fault!("mirror-sign", REFRACTION,
            "the mirror direction with the wrong sign: back to where it came from",
            { mirror: |d, n| -reflect(d, n) }, "glass/mirror-aim"),
        fault!("mirror-half", REFRACTION, "the mirror direction without its factor 2: along the surface",
            { mirror: |d, n| (d - d.dot(n) * n).normalize() }, "glass/mirror-aim"),
    ]
}
