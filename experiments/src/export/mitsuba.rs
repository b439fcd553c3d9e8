//! Mitsuba 3: one XML file, and an OBJ mesh for each surface that has triangles.
//!
//! Our surfaces scatter on both sides, like Mitsuba's `twosided` BSDFs. In both renderers lights
//! emit from the front only, and radiance scales with the square of the refractive index inside
//! glass.

use std::fmt::Write as _;

use glam::DVec3;
use whitefurnace::material::Bsdf;
use whitefurnace::scene::Scene;

use super::{Shape, SurfaceGeometry, background, is_unclipped, numbers, parts};

pub(super) fn files(
    scene: &Scene,
    [width, height]: [u32; 2],
    spp: u32,
    bounces: Option<u32>,
) -> Result<Vec<(String, String)>, String> {
    // Mitsuba's `max_depth` counts segments; -1 is no limit.
    let depth = bounces.map_or(-1, |bounces| i64::from(bounces) + 1);
    let camera = scene.camera();
    let ([forward, _, up], half_height) = camera.frame();
    let vector = |v| numbers(v, ", ");
    let [eye, target, up] = [camera.eye, camera.eye + forward, up].map(vector);
    let degrees = 2.0 * half_height.atan().to_degrees();
    let (near, far) = distances(scene);
    let mut xml = format!(
        r#"<scene version="3.0.0">
    <default name="spp" value="{spp}"/>
    <integrator type="path">
        <integer name="max_depth" value="{depth}"/>
    </integrator>
    <sensor type="perspective">
        <string name="fov_axis" value="y"/>
        <float name="fov" value="{degrees}"/>
        <float name="near_clip" value="{near}"/>
        <float name="far_clip" value="{far}"/>
        <transform name="to_world">
            <lookat origin="{eye}" target="{target}" up="{up}"/>
        </transform>
        <sampler type="independent">
            <integer name="sample_count" value="$spp"/>
        </sampler>
        <film type="hdrfilm">
            <integer name="width" value="{width}"/>
            <integer name="height" value="{height}"/>
            <string name="pixel_format" value="rgb"/>
            <string name="component_format" value="float32"/>
            <rfilter type="box"/>
        </film>
    </sensor>
"#
    );
    if let Some(background) = background(scene)? {
        let radiance = rgb("radiance", background);
        let _ = writeln!(xml, "    <emitter type=\"constant\">{radiance}</emitter>");
    }
    let mut meshes = Vec::new();
    for SurfaceGeometry { surface, shape } in parts(scene) {
        let bsdf = bsdf(&surface.bsdf)?;
        let emitter = if surface.emission == DVec3::ZERO {
            String::new()
        } else {
            format!(
                "\n        <emitter type=\"area\">{}</emitter>",
                rgb("radiance", surface.emission)
            )
        };
        let (kind, geometry) = match shape {
            Shape::Sphere(sphere) if !is_unclipped(&sphere) => {
                return Err("it has a zone of a sphere, and there are whole ones only".to_owned());
            }
            Shape::Sphere(sphere) => {
                let [x, y, z] = sphere.centre.to_array();
                let geometry = format!(
                    "<point name=\"center\" x=\"{x}\" y=\"{y}\" z=\"{z}\"/>\n        \
                     <float name=\"radius\" value=\"{}\"/>\n        \
                     <boolean name=\"flip_normals\" value=\"{}\"/>",
                    sphere.radius, sphere.inward
                );
                ("sphere", geometry)
            }
            Shape::Triangles(triangles) => {
                let name = format!("mesh-{}.obj", meshes.len());
                let mut obj = String::new();
                for (i, corners) in triangles.iter().enumerate() {
                    corners
                        .iter()
                        .for_each(|corner| obj += &format!("v {}\n", numbers(*corner, " ")));
                    let _ = writeln!(obj, "f {} {} {}", 3 * i + 1, 3 * i + 2, 3 * i + 3);
                }
                let geometry = format!(
                    "<string name=\"filename\" value=\"{name}\"/>\n        \
                     <boolean name=\"face_normals\" value=\"true\"/>"
                );
                meshes.push((name, obj));
                ("obj", geometry)
            }
        };
        let _ = writeln!(
            xml,
            "    <shape type=\"{kind}\">\n        {geometry}\n        {bsdf}{emitter}\n    </shape>"
        );
    }
    xml += "</scene>\n";
    Ok([("scene.xml".to_owned(), xml)]
        .into_iter()
        .chain(meshes)
        .collect())
}

/// Returns the near and far clip distances. Rays start at the near one, which is so small that
/// nothing is lost in front of it.
fn distances(scene: &Scene) -> (f64, f64) {
    let eye = scene.camera().eye;
    let extent = parts(scene)
        .iter()
        .fold(1e-3, |extent: f64, part| match &part.shape {
            Shape::Sphere(sphere) => extent.max(sphere.centre.distance(eye) + sphere.radius),
            Shape::Triangles(triangles) => triangles
                .as_flattened()
                .iter()
                .fold(extent, |e, v| e.max(v.distance(eye))),
        });
    (1e-4 * extent, 10.0 * extent)
}

fn rgb(name: &str, colour: DVec3) -> String {
    format!("<rgb name=\"{name}\" value=\"{}\"/>", numbers(colour, ", "))
}

fn bsdf(bsdf: &Bsdf) -> Result<String, String> {
    let on_both_sides = |inner: String| Ok(format!("<bsdf type=\"twosided\">{inner}</bsdf>"));
    let diffuse = |albedo| {
        format!(
            "<bsdf type=\"diffuse\">{}</bsdf>",
            rgb("reflectance", albedo)
        )
    };
    let lacks = |model: &str, why: &str| Err(format!("it has a surface of {model}, {why}"));
    match *bsdf {
        Bsdf::Black => on_both_sides(diffuse(DVec3::ZERO)),
        Bsdf::Lambert { albedo } => on_both_sides(diffuse(albedo)),
        Bsdf::Mirror { reflectance } => on_both_sides(format!(
            "<bsdf type=\"conductor\"><string name=\"material\" value=\"none\"/>{}</bsdf>",
            rgb("specular_reflectance", reflectance)
        )),
        Bsdf::Glass { index } => Ok(format!(
            "<bsdf type=\"dielectric\"><float name=\"int_ior\" value=\"{index}\"/>\
             <float name=\"ext_ior\" value=\"1\"/></bsdf>"
        )),
        Bsdf::OrenNayar { .. } => lacks("the Oren-Nayar model", "which Mitsuba does not have"),
        Bsdf::Eon { .. } => lacks("the EON model", "which Mitsuba does not have"),
        Bsdf::RoughGlass(_) => lacks(
            "rough glass with height-correlated masking",
            "which Mitsuba does not have",
        ),
        Bsdf::Model(_) => lacks(
            "GGX with Schlick's Fresnel term and height-correlated masking",
            "of which Mitsuba has neither",
        ),
    }
}
