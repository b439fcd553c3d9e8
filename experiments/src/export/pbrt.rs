//! pbrt-v4: one text file. pbrt's camera is left-handed, hence the mirrored axis.

use std::fmt::Write as _;

use glam::DVec3;
use whitefurnace::material::Bsdf;
use whitefurnace::scene::Scene;

use super::{Shape, SurfaceGeometry, background, numbers, parts};

/// Bounce limit larger than the number of bounces of any path.
const MAX_DEPTH: u32 = 1_000_000;

pub(super) fn file(
    scene: &Scene,
    [width, height]: [u32; 2],
    spp: u32,
    bounces: Option<u32>,
) -> Result<String, String> {
    let depth = bounces.unwrap_or(MAX_DEPTH);
    let camera = scene.camera();
    let ([forward, _, up], half_height) = camera.frame();
    let [eye, target, up] = [camera.eye, camera.eye + forward, up].map(|v| numbers(v, " "));
    // pbrt's field of view is that of the image's shorter side.
    let half = half_height * f64::from(width.min(height)) / f64::from(height);
    let degrees = 2.0 * half.atan().to_degrees();
    let mut text = format!(
        r#"Scale -1 1 1
LookAt {eye}  {target}  {up}
Camera "perspective" "float fov" [ {degrees} ]
Film "rgb" "string filename" "scene.exr" "integer xresolution" [ {width} ] "integer yresolution" [ {height} ]
PixelFilter "box" "float xradius" [ 0.5 ] "float yradius" [ 0.5 ]
Sampler "independent" "integer pixelsamples" [ {spp} ]
Integrator "path" "integer maxdepth" [ {depth} ]
WorldBegin
"#
    );
    if let Some(background) = background(scene)? {
        let _ = writeln!(text, "LightSource \"infinite\" {}", grey("L", background)?);
    }
    for SurfaceGeometry { surface, shape } in parts(scene) {
        let _ = writeln!(text, "AttributeBegin\n{}", material(&surface.bsdf)?);
        if surface.emission != DVec3::ZERO {
            let _ = writeln!(
                text,
                "AreaLightSource \"diffuse\" {}",
                grey("L", surface.emission)?
            );
        }
        let shape = match shape {
            Shape::Triangles(triangles) => {
                let points: Vec<String> = triangles
                    .as_flattened()
                    .iter()
                    .map(|v| numbers(*v, " "))
                    .collect();
                let indices: Vec<String> = (0..points.len()).map(|i| i.to_string()).collect();
                let [points, indices] = [points.join("\n"), indices.join(" ")];
                format!(
                    "Shape \"trianglemesh\" \"point3 P\" [\n{points} ]\n\"integer indices\" [ {indices} ]"
                )
            }
            Shape::Sphere(sphere) => {
                let ([low, high], centre) = (sphere.heights(), numbers(sphere.centre, " "));
                let reverse = if sphere.inward {
                    "ReverseOrientation\n"
                } else {
                    ""
                };
                format!(
                    "Translate {centre}\n{reverse}Shape \"sphere\" \"float radius\" [ {} ] \"float zmin\" [ {low} ] \
                     \"float zmax\" [ {high} ]",
                    sphere.radius
                )
            }
        };
        let _ = writeln!(text, "{shape}\nAttributeEnd");
    }
    Ok(text)
}

/// Returns a colour whose channels are equal, as pbrt takes it. pbrt turns other colours into
/// spectra, and products of spectra differ from products of RGB channels.
fn grey(name: &str, colour: DVec3) -> Result<String, String> {
    if colour == DVec3::splat(colour.x) {
        return Ok(format!("\"rgb {name}\" [ {} ]", numbers(colour, " ")));
    }
    Err(format!(
        "it has the colour ({}), and pbrt is spectral: only equal channels mean the same",
        numbers(colour, ", ")
    ))
}

fn material(bsdf: &Bsdf) -> Result<String, String> {
    let diffuse = |albedo| {
        Ok(format!(
            "Material \"diffuse\" {}",
            grey("reflectance", albedo)?
        ))
    };
    let lacks = |model: &str| {
        Err(format!(
            "it has a surface of {model}, which pbrt does not have"
        ))
    };
    match *bsdf {
        Bsdf::Black => diffuse(DVec3::ZERO),
        Bsdf::Lambert { albedo } => diffuse(albedo),
        Bsdf::Glass { index } => Ok(format!("Material \"dielectric\" \"float eta\" [ {index} ]")),
        Bsdf::Mirror { .. } => lacks("a mirror whose reflectance is the same from all directions"),
        Bsdf::OrenNayar { .. } => lacks("the Oren-Nayar model"),
        Bsdf::Eon { .. } => lacks("the EON model"),
        Bsdf::RoughGlass(_) => {
            lacks("rough glass with height-correlated masking for opposite sides")
        }
        Bsdf::Model(_) => lacks("GGX with Schlick's Fresnel term"),
    }
}
