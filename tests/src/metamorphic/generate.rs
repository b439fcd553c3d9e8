//! Random scenes: all shapes, models and kinds of light, in sizes from a millimetre to a kilometre.

use std::collections::BTreeMap;

use glam::{DQuat, DVec3};
use rand::RngExt as _;
use whitefurnace::material::MODELS;
use whitefurnace::material::named::ParameterKind;
use whitefurnace::sampling::rng::{Stream, stream, uniform};
use whitefurnace::scene::cuboid;

use crate::mean_radiance::any_direction;

use super::background::{Background, Sky};
use super::scene::{Material, Object, SceneText, Similarity, Triple, View};

/// Half the side of the cube in which objects stand, before the scene is scaled.
const ROOM: f64 = 1.0;
/// Distance from the centre to walls and floor: objects stand clear of them, but for those that
/// touch the floor.
const WALL: f64 = 1.1;
/// Room between objects that do not touch.
const CLEARANCE: f64 = 0.02;

/// Builds the random scene of a seed. Few seeds give one that programs refuse, such as a box on a
/// floor that ends below it.
pub fn generate(seed: u64) -> SceneText {
    let camera = View {
        eye: [0.0; 3],
        target: [0.0, 1.0, 0.0],
        up: [0.0, 0.0, 1.0],
        half_height: 1.0,
    };
    let scene = SceneText {
        background: Background::BLACK,
        camera,
        materials: BTreeMap::new(),
        objects: Vec::new(),
    };
    let mut builder = Generator {
        rng: stream(seed, 0, 0),
        scene,
        occupied: Vec::new(),
    };
    let mut scene = builder.all();
    if !scene.background.is_black() {
        // Numbers of their own, so that skies do not change the rest of the scene.
        builder.rng = stream(seed, 1, 0);
        if builder.chance(0.4) {
            scene.background = Background::Sky(builder.sky());
        }
    }
    scene
}

struct Generator {
    rng: Stream,
    scene: SceneText,
    /// Centre and radius of a ball around each object.
    occupied: Vec<(DVec3, f64)>,
}

impl Generator {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * uniform(&mut self.rng)
    }

    fn log_between(&mut self, low: f64, high: f64) -> f64 {
        self.between(low.ln(), high.ln()).exp()
    }

    fn chance(&mut self, probability: f64) -> bool {
        uniform(&mut self.rng) < probability
    }

    fn index(&mut self, count: usize) -> usize {
        self.rng.random_range(0..count)
    }

    fn direction(&mut self) -> DVec3 {
        any_direction(&mut self.rng)
    }

    fn rotation(&mut self) -> DQuat {
        DQuat::from_axis_angle(self.direction(), self.between(0.0, std::f64::consts::PI))
    }

    fn colour(&mut self, low: f64, high: f64) -> Triple {
        [0; 3].map(|_| self.between(low, high))
    }

    fn all(&mut self) -> SceneText {
        let enclosure = self.index(4);
        let is_open = enclosure < 2;
        match enclosure {
            0 => {}
            1 => self.floor(),
            2 => self.room(),
            _ => self.hollow(),
        }
        let objects = 1 + self.index(6);
        for _ in 0..objects {
            self.object();
        }
        if is_open && self.chance(0.6) {
            self.scene.background = Background::Uniform(self.colour(0.1, 1.0));
        }
        let dark = self.scene.background.is_black() && self.scene.emitters().next().is_none();
        for _ in 0..usize::from(dark) + self.index(2) {
            self.lamp();
        }
        self.camera();
        let size = self.log_between(1e-3, 1e3);
        self.scene.transformed(&Similarity {
            scale: size,
            ..Similarity::IDENTITY
        })
    }

    /// Draws an environment map in any position, half of them with a pixel as bright as a sun.
    fn sky(&mut self) -> Sky {
        let height = 1 + self.index(6);
        let mut pixels: Vec<Triple> = (0..2 * height * height)
            .map(|_| self.colour(0.0, 1.0))
            .collect();
        if self.chance(0.5) {
            let (at, factor) = (self.index(pixels.len()), self.log_between(3.0, 100.0));
            pixels[at] = pixels[at].map(|radiance| factor * radiance);
        }
        let single = |x: f64| f64::from(x as f32);
        Sky {
            image: "sky.pfm".to_owned(),
            up: self.direction().to_array(),
            front: self.direction().to_array(),
            size: [2 * height, height],
            pixels: pixels.into_iter().map(|pixel| pixel.map(single)).collect(),
        }
    }

    /// Adds a material of a random model; glass only where the shape is closed.
    fn material(&mut self, closed: bool) -> String {
        let model = loop {
            let lambert = self.chance(0.4);
            let model = MODELS[if lambert { 1 } else { self.index(MODELS.len()) }];
            if closed || !model.name.contains("glass") {
                break model;
            }
        };
        let mut parameters = toml::Table::new();
        for parameter in model.parameters {
            let value = match parameter.kind {
                ParameterKind::Colour => self.colour(0.05, 0.85).to_vec().into(),
                ParameterKind::Number(low, high) => {
                    let [low, high] = match parameter.name {
                        "index" => [0.6, 2.0],
                        "alpha" => [0.03, high],
                        _ => [low, high],
                    };
                    self.between(low, high).into()
                }
                ParameterKind::Choice(words) => words[self.index(words.len())].into(),
            };
            parameters.insert(parameter.name.to_owned(), value);
        }
        let emits = self.chance(0.15) && !model.name.contains("glass");
        let emission = if emits { self.emission() } else { [0.0; 3] };
        self.named(Material {
            model: model.name.to_owned(),
            emission,
            parameters,
        })
    }

    fn emission(&mut self) -> Triple {
        let factor = self.log_between(0.3, 30.0);
        self.colour(0.2, 1.0).map(|channel| channel * factor)
    }

    fn named(&mut self, material: Material) -> String {
        let name = format!("m{}", self.scene.materials.len());
        self.scene.materials.insert(name.clone(), material);
        name
    }

    /// Finds the centre of a ball of this radius that meets no other.
    fn spot(&mut self, radius: f64) -> Option<DVec3> {
        (0..64).find_map(|_| {
            let half = ROOM - radius;
            let centre = DVec3::from([0; 3].map(|_| self.between(-half, half)));
            let free = self
                .occupied
                .iter()
                .all(|(other, of_other)| centre.distance(*other) > radius + of_other + CLEARANCE);
            free.then_some(centre)
        })
    }

    fn object(&mut self) {
        let radius = self.log_between(0.08, 0.5);
        let Some(centre) = self.spot(radius) else {
            return;
        };
        self.occupied.push((centre, radius));
        match self.index(7) {
            0 => self.sphere(centre, radius, None),
            1 => {
                let [a, b] = [0; 2].map(|_| self.between(-radius, radius));
                let least = 0.1 * radius;
                self.sphere(centre, radius, Some([a.min(b) - least, a.max(b) + least]));
            }
            2 => {
                let rotation = self.rotation();
                let [x, y] = [DVec3::X, DVec3::Y].map(|axis| rotation * axis * radius);
                let skew = self.between(-0.4, 0.4);
                self.rectangle(centre, [x, 0.6 * (y + skew * x)]);
            }
            3 => {
                let rotation = self.rotation();
                self.cuboid(centre, DVec3::splat(0.57 * radius), rotation);
            }
            4 => self.standing_box(centre, radius),
            5 => self.polyhedron(centre, radius),
            _ => self.nested(centre, radius),
        }
    }

    fn sphere(&mut self, centre: DVec3, radius: f64, zone: Option<[f64; 2]>) {
        let material = self.material(zone.is_none());
        let inward = zone.is_some() && self.chance(0.3);
        self.scene.objects.push(Object::Sphere {
            material,
            centre: centre.to_array(),
            radius,
            zone,
            inward,
        });
    }

    /// Adds a parallelogram around a centre, of half these edges to each side.
    fn rectangle(&mut self, centre: DVec3, halves: [DVec3; 2]) {
        let material = self.material(false);
        let corner = centre - 0.7 * (halves[0] + halves[1]);
        let edges = halves.map(|half| (1.4 * half).to_array());
        self.scene.objects.push(Object::Rectangle {
            material,
            corner: corner.to_array(),
            edges,
        });
    }

    fn cuboid(&mut self, centre: DVec3, half: DVec3, rotation: DQuat) {
        let material = self.material(true);
        let (corners, triangles) = cuboid(-half, half, false);
        self.scene.objects.push(Object::Mesh {
            vertices: corners
                .map(|corner| (centre + rotation * corner).to_array())
                .to_vec(),
            faces: BTreeMap::from([(material, triangles.map(Vec::from).to_vec())]),
        });
    }

    /// Adds a box that stands on the floor, which it touches where there is one.
    fn standing_box(&mut self, centre: DVec3, radius: f64) {
        let angle = self.between(0.0, std::f64::consts::PI);
        let half = 0.5 * radius;
        let height = 0.5 * (centre.z - half + WALL).max(0.0) + half;
        let centre = DVec3::new(centre.x, centre.y, height - WALL);
        let blocked = self.occupied.iter().rev().skip(1).any(|(other, of_other)| {
            let across = (*other - centre).truncate().length();
            across < of_other + radius + CLEARANCE && other.z - of_other < centre.z + height
        });
        if !blocked {
            let half = DVec3::new(half, half, height);
            self.occupied.push((centre, half.length()));
            self.cuboid(centre, half, DQuat::from_rotation_z(angle));
        }
    }

    /// Adds a tetrahedron, or an open fan of triangles of two materials.
    fn polyhedron(&mut self, centre: DVec3, radius: f64) {
        let rotation = self.rotation();
        let corner = |x: f64, y: f64, z: f64| {
            (centre + rotation * (DVec3::new(x, y, z).normalize() * radius)).to_array()
        };
        if self.chance(0.6) {
            let vertices = vec![
                corner(1.0, 1.0, 1.0),
                corner(1.0, -1.0, -1.0),
                corner(-1.0, 1.0, -1.0),
                corner(-1.0, -1.0, 1.0),
            ];
            let material = self.material(true);
            let faces = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]].map(Vec::from);
            self.scene.objects.push(Object::Mesh {
                vertices,
                faces: BTreeMap::from([(material, faces.to_vec())]),
            });
        } else {
            let count = 3 + self.index(5) as u32;
            let height = self.between(-0.6, 0.6);
            let mut vertices = vec![centre.to_array()];
            vertices.extend((0..=count).map(|i| {
                let angle = std::f64::consts::PI * f64::from(i) / f64::from(count);
                corner(angle.cos(), angle.sin(), height)
            }));
            let names = [self.material(false), self.material(false)];
            let mut faces = BTreeMap::<_, Vec<_>>::new();
            for i in 1..=count {
                let name = names[i as usize % 2].clone();
                faces.entry(name).or_default().push(vec![0, i, i + 1]);
            }
            self.scene.objects.push(Object::Mesh { vertices, faces });
        }
    }

    /// Adds a sphere in a sphere, of which the outer is glass.
    fn nested(&mut self, centre: DVec3, radius: f64) {
        let index = self.between(1.1, 1.9);
        let glass = self.named(Material::new("glass", [("index", index.into())]));
        self.scene.objects.push(Object::Sphere {
            material: glass,
            centre: centre.to_array(),
            radius,
            zone: None,
            inward: false,
        });
        let inner = self.between(0.3, 0.8);
        self.sphere(centre, inner * radius, None);
    }

    fn floor(&mut self) {
        let material = self.material(false);
        self.scene.objects.push(Object::Rectangle {
            material,
            corner: [-3.0, -3.0, -WALL],
            edges: [[6.0, 0.0, 0.0], [0.0, 6.0, 0.0]],
        });
    }

    /// Adds a closed room with walls of two materials.
    fn room(&mut self) {
        let names = [self.material(false), self.material(false)];
        let (corners, triangles) = cuboid(DVec3::splat(-WALL), DVec3::splat(WALL), true);
        let mut faces = BTreeMap::<_, Vec<_>>::new();
        for (i, triangle) in triangles.into_iter().enumerate() {
            let name = names[i / 2 % 2].clone();
            faces.entry(name).or_default().push(triangle.to_vec());
        }
        self.scene.objects.push(Object::Mesh {
            vertices: corners.map(|corner| corner.to_array()).to_vec(),
            faces,
        });
    }

    /// Adds a hollow sphere around everything, in two zones.
    fn hollow(&mut self) {
        let radius = 3f64.sqrt() * WALL;
        let cut = self.between(-0.8, 0.8);
        for zone in [[-2.0 * radius, cut], [cut, 2.0 * radius]] {
            let material = self.material(false);
            self.scene.objects.push(Object::Sphere {
                material,
                centre: [0.0; 3],
                radius,
                zone: Some(zone),
                inward: true,
            });
        }
    }

    /// Adds a lamp: a rectangle, a sphere, or a tetrahedron.
    fn lamp(&mut self) {
        let radius = self.log_between(0.03, 0.3);
        let Some(centre) = self.spot(radius) else {
            return;
        };
        self.occupied.push((centre, radius));
        match self.index(3) {
            0 => {
                let rotation = self.rotation();
                let [x, y] = [DVec3::X, DVec3::Y].map(|axis| rotation * axis * radius);
                self.rectangle(centre, [x, 0.5 * y]);
            }
            1 => self.sphere(centre, radius, None),
            _ => self.polyhedron(centre, radius),
        }
        let emission = self.emission();
        let name = format!("m{}", self.scene.materials.len() - 1);
        let black = Material {
            emission,
            ..Material::new("black", [])
        };
        self.scene.materials.insert(name, black);
    }

    /// Places the camera at a free point; it looks at an object or anywhere.
    fn camera(&mut self) {
        let eye = self.spot(0.02).unwrap_or(DVec3::splat(ROOM));
        let target = match self.occupied.len() {
            0 => DVec3::ZERO,
            count => {
                let index = self.index(count);
                self.occupied[index].0
            }
        };
        let target = target + 0.1 * self.direction();
        self.scene.camera = View {
            eye: eye.to_array(),
            target: target.to_array(),
            up: self.direction().to_array(),
            half_height: self.log_between(0.15, 1.5),
        };
    }
}
