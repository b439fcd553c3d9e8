//! Words of other programs' scenes, and their equivalents here.

/// Keys of other programs, and keys or values of this one that may be meant: the first that is
/// valid at that place. Words are in lower case without `-`, `_` and blanks.
const SYNONYMS: [(&str, &[&str]); 32] = [
    (
        "ior eta refraction refractiveindex indexofrefraction intior n",
        &["index"],
    ),
    (
        "color colour diffuse diffusecolor kd rgb basecolor rho reflectance albedo diffusereflectance specular \
         specularreflectance ks tint f0",
        &["albedo", "reflectance"],
    ),
    (
        "roughness rough alpha sigma",
        &["alpha", "sigma", "roughness"],
    ),
    (
        "position pos centre center location origin",
        &["centre", "eye", "corner", "translate"],
    ),
    ("from lookfrom", &["eye"]),
    ("lookat to at interest", &["target"]),
    ("fov vfov yfov angle fieldofview", &["fov_deg"]),
    (
        "emit emits emissive emittance ke le emissioncolor radiance luminance intensity power strength",
        &["emission"],
    ),
    (
        "radiance sky environment envmap ambient world emission",
        &["background"],
    ),
    ("filename path src url mesh", &["file", "image"]),
    ("texture map file", &["image"]),
    ("rotation orientation", &["rotate"]),
    ("scaling size", &["scale"]),
    ("translation move offset", &["translate"]),
    ("r size", &["radius"]),
    ("type kind", &["model", "shape"]),
    ("bsdf brdf shader", &["model", "material"]),
    ("mat", &["material"]),
    ("verts points positions p", &["vertices"]),
    ("indices triangles tris polygons", &["faces"]),
    ("min max bounds aabb", &["corners"]),
    (
        "flip flipnormals reverse reverseorientation inside",
        &["inward"],
    ),
    ("shapes geometry primitives spheres meshes", &["objects"]),
    ("material bsdfs", &["materials"]),
    ("units", &["unit"]),
    ("matte lambertian diffuse", &["lambert"]),
    (
        "metal conductor roughconductor microfacet glossy metallic",
        &["ggx"],
    ),
    ("dielectric refractive water", &["glass"]),
    (
        "roughdielectric frosted frostedglass roughglass",
        &["rough-glass"],
    ),
    ("specular reflective perfectmirror", &["mirror"]),
    ("ball uvsphere icosphere", &["sphere"]),
    ("null none", &["black"]),
];

/// Words without an equivalent here, with advice.
const ADVICE: [(&str, &str); 8] = [
    (
        "plastic roughplastic principled disney uber pbr phong blinn blinnphong coated standard",
        "no model has a coat: take \"lambert\" or \"eon\" for the body, \"ggx\" for metal",
    ),
    (
        "emissive emitter light area arealight diffuselight emission",
        "take \"black\" with emission = a radiance",
    ),
    (
        "plane quad square rect ground parallelogram",
        "take \"rectangle\" with a corner and two edges",
    ),
    ("cube cuboid aabb", "take \"box\" with two corners"),
    (
        "triangle polygon tri trimesh trianglemesh polymesh",
        "take \"mesh\" with vertices and faces",
    ),
    (
        "disc disk circle cylinder cone torus curve tube capsule",
        "take a \"mesh\" or \"obj\" that approximates it; a face may have any number of corners",
    ),
    (
        "ply stl gltf glb fbx usd wavefront",
        "convert the file to Wavefront OBJ and take \"obj\"",
    ),
    (
        "file filename path src url obj",
        "take shape = \"obj\", which reads a file; \"vertices\" and \"faces\" stand in the scene",
    ),
];

pub(super) fn normalized(word: &str) -> String {
    word.chars()
        .filter(|c| !"-_ ".contains(*c))
        .take(64)
        .flat_map(char::to_lowercase)
        .collect()
}

pub(super) fn matches<T: Copy>(table: &[(&str, T)], word: &str) -> Vec<T> {
    let word = normalized(word);
    table
        .iter()
        .filter(|(words, _)| words.split(' ').any(|known| known == word))
        .map(|(_, meaning)| *meaning)
        .collect()
}

/// Returns the tail of a message about an invalid word, if other programs know it.
pub(super) fn advice(wrong: &str, valid: &[&str]) -> Option<String> {
    let meant = matches(&SYNONYMS, wrong)
        .concat()
        .into_iter()
        .find(|meant| valid.contains(meant));
    let Some(meant) = meant else {
        // Advice on models and shapes, not on keys.
        let takes = |instead: &&str| {
            valid
                .iter()
                .any(|valid| instead.contains(&format!("\"{valid}\"")))
        };
        return matches(&ADVICE, wrong)
            .into_iter()
            .find(takes)
            .map(|instead| format!("; {instead}"));
    };
    let more = match (normalized(wrong).as_str(), meant) {
        ("roughness" | "rough", "alpha") => {
            " It is the square of the roughness in Blender, glTF and Disney's model"
        }
        ("sigma" | "roughness" | "rough", "sigma") => " It is in radians",
        ("intensity" | "power" | "strength", "emission") => " It is a radiance: power / (π area)",
        (_, "fov_deg") => " It is the vertical angle in degrees",
        _ => "",
    };
    Some(format!("; did you mean \"{meant}\"?{more}"))
}
