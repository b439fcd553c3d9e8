//! Every built-in scene against its table: shapes, materials, emitters, background and camera, whatever the
//! order in which the scene lists them. A constant that is off by 1e-9 of itself shows.

use whitefurnace::scene::room::Walls;

use crate::prelude::*;
use crate::scene::OUTLINE;

/// A surface as numbers: kind, colour, what else its model knows, emission, absorption.
type Look = (&'static str, [f64; 3], [f64; 2], [f64; 3], f64);

/// A shape as numbers: the corners of a triangle, or a sphere's centre, radius, zone and side.
#[derive(Clone, Debug)]
enum Shape {
    Triangle([[f64; 3]; 3]),
    Ball([f64; 3], f64, [f64; 2], bool),
}

/// What a scene should be.
struct Table {
    name: &'static str,
    background: [f64; 3],
    primitives: Vec<(Shape, Look)>,
    /// Shape, radiance, area and, of flat ones, the normal.
    emitters: Vec<(Lamp, [f64; 3], f64)>,
    /// Eye, forward, right, up, half the height at distance 1.
    camera: ([f64; 3], [f64; 3], [f64; 3], [f64; 3], f64),
}

#[derive(Clone, Debug)]
enum Lamp {
    /// Corner, edges, normal.
    Rectangle([f64; 3], [[f64; 3]; 2], [f64; 3]),
    Other(Shape),
}

const BLACK: [f64; 3] = [0.0; 3];
const ONES: [f64; 3] = [1.0; 3];
const WHOLE: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

fn close(a: f64, b: f64) -> bool {
    a == b || (a - b).abs() <= 1e-12 * (1.0 + a.abs())
}

fn all_close(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| close(*a, *b))
}

fn lambert(albedo: [f64; 3]) -> Look {
    ("lambert", albedo, [0.0; 2], BLACK, 0.0)
}

const MIRROR: Look = ("mirror", ONES, [0.0; 2], BLACK, 0.0);
const GLASS: Look = ("glass", ONES, [1.5, 0.0], BLACK, 0.0);

/// A surface of the scene as numbers.
fn look(surface: &Surface) -> Look {
    let (kind, colour, more) = match surface.bsdf {
        Bsdf::Black => ("black", BLACK, [0.0; 2]),
        Bsdf::Lambert { albedo } => ("lambert", albedo.to_array(), [0.0; 2]),
        Bsdf::Mirror { reflectance } => ("mirror", reflectance.to_array(), [0.0; 2]),
        Bsdf::Glass { index } => ("glass", ONES, [index, 0.0]),
        Bsdf::OrenNayar { albedo, constants, form } => (
            match form {
                OrenNayarForm::Corrected => "oren-nayar, corrected",
                OrenNayarForm::Printed => "oren-nayar, printed",
            },
            albedo.to_array(),
            [constants.a, constants.b],
        ),
        Bsdf::Eon { albedo, roughness } => ("eon", albedo.to_array(), [roughness, 0.0]),
        Bsdf::Model(_) => panic!("built-in scenes hold built-in models"),
    };
    let emission = surface.emission.to_array();
    (kind, colour, more, emission, surface.absorption)
}

fn same_look(a: &Look, b: &Look) -> bool {
    a.0 == b.0 && all_close(&a.1, &b.1) && all_close(&a.2, &b.2) && all_close(&a.3, &b.3) && close(a.4, b.4)
}

fn shape(geometry: Geometry) -> Shape {
    match geometry {
        Geometry::Triangle(corners) => Shape::Triangle(corners.map(|c| c.to_array())),
        Geometry::Sphere(sphere) => ball(&sphere),
    }
}

fn ball(sphere: &Sphere) -> Shape {
    let Sphere { centre, radius, zone, inward } = *sphere;
    Shape::Ball(centre.to_array(), radius, zone, inward)
}

/// Triangles are the same from whichever corner they start; their sense of rotation counts.
fn same_shape(a: &Shape, b: &Shape) -> bool {
    match (a, b) {
        (Shape::Triangle(a), Shape::Triangle(b)) => {
            (0..3).any(|turn| (0..3).all(|i| all_close(&a[i], &b[(i + turn) % 3])))
        }
        (Shape::Ball(c, r, zone, inward), Shape::Ball(c2, r2, zone2, inward2)) => {
            all_close(c, c2) && close(*r, *r2) && all_close(zone, zone2) && inward == inward2
        }
        _ => false,
    }
}

/// The triangles of convex polygons, counter-clockwise from the front, divided from the first corner.
fn faces<const N: usize>(corners: &[[f64; 3]], polygons: &[[usize; N]], look: Look) -> Vec<(Shape, Look)> {
    let triangles =
        polygons.iter().flat_map(|polygon| (1..N - 1).map(move |i| [polygon[0], polygon[i], polygon[i + 1]]));
    triangles.map(|triangle| (Shape::Triangle(triangle.map(|i| corners[i])), look)).collect()
}

fn sphere(centre: [f64; 3], radius: f64, look: Look) -> (Shape, Look) {
    (Shape::Ball(centre, radius, WHOLE, false), look)
}

/// Takes each expected item out of those that there are; none may be left on either side.
fn same_items<T: std::fmt::Debug, U: std::fmt::Debug>(
    scene: &str,
    mut found: Vec<T>,
    expected: &[U],
    same: impl Fn(&T, &U) -> bool,
) {
    for item in expected {
        let place = found.iter().position(|there| same(there, item));
        let Some(place) = place else {
            panic!("{scene} lacks {item:?}; left are {found:#?}");
        };
        found.swap_remove(place);
    }
    assert!(found.is_empty(), "{scene} has more than its table: {found:#?}");
}

fn check(scene: &Scene, table: &Table) {
    let name = table.name;
    assert_eq!(scene.name(), name);
    assert!(all_close(&scene.background().to_array(), &table.background));
    let found: Vec<_> = scene.primitives().map(|(geometry, surface)| (shape(geometry), look(surface))).collect();
    same_items(name, found, &table.primitives, |found, wanted| {
        same_shape(&found.0, &wanted.0) && same_look(&found.1, &wanted.1)
    });
    let found = scene.emitters().to_vec();
    same_items(name, found, &table.emitters, |found, (lamp, l, area)| {
        let shape = match (found.shape, lamp) {
            (EmitterShape::Rectangle { corner, edges }, Lamp::Rectangle(c, e, normal)) => {
                all_close(&corner.to_array(), c)
                    && (0..2).all(|i| all_close(&edges[i].to_array(), &e[i]))
                    && all_close(&found.sample([0.25, 0.5]).normal.to_array(), normal)
            }
            (EmitterShape::Triangle(corners), Lamp::Other(other)) => {
                same_shape(&Shape::Triangle(corners.map(|c| c.to_array())), other)
            }
            (EmitterShape::Sphere(sphere), Lamp::Other(other)) => same_shape(&ball(&sphere), other),
            _ => false,
        };
        shape && all_close(&found.radiance.to_array(), l) && close(found.area, *area)
    });
    check_camera(scene, table);
}

/// Rays through the corners of images of several shapes, and a point of no symmetry.
fn check_camera(scene: &Scene, table: &Table) {
    let (eye, forward, right, up, half) = table.camera;
    let [eye, forward, right, up] = [eye, forward, right, up].map(DVec3::from_array);
    for size in [[4, 3], [7, 7], [3, 8]] {
        let [width, height] = size.map(f64::from);
        for [x, y] in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0], [0.3, 0.8]] {
            let ray = scene.camera().ray(size, x * width, y * height);
            let across = (2.0 * x - 1.0) * half * width / height;
            let aim = forward + across * right + (1.0 - 2.0 * y) * half * up;
            let found = [ray.origin, ray.direction].map(|v| v.to_array());
            let wanted = [eye, aim / aim.length()].map(|v| v.to_array());
            assert!(
                (0..2).all(|i| all_close(&found[i], &wanted[i])),
                "{}: through ({x}, {y}) of {size:?} {found:?}, not {wanted:?}",
                table.name
            );
        }
    }
}

/// The frame of a camera that looks along a direction with z upright.
fn upright(eye: [f64; 3], [x, y, z]: [f64; 3], half: f64) -> Table {
    let flat = x.hypot(y);
    let all = flat.hypot(z);
    let right = [y / flat, -x / flat, 0.0];
    let up = [-x * z / (flat * all), -y * z / (flat * all), flat / all];
    let forward = [x, y, z].map(|v| v / all);
    Table {
        name: "",
        background: BLACK,
        primitives: Vec::new(),
        emitters: Vec::new(),
        camera: (eye, forward, right, up, half),
    }
}

/// The corners of the cube [−1, 1]³ and its faces, counter-clockwise from outside.
const CUBE: [[f64; 3]; 8] = [
    [-1.0, -1.0, -1.0],
    [1.0, -1.0, -1.0],
    [1.0, 1.0, -1.0],
    [-1.0, 1.0, -1.0],
    [-1.0, -1.0, 1.0],
    [1.0, -1.0, 1.0],
    [1.0, 1.0, 1.0],
    [-1.0, 1.0, 1.0],
];
const OUTSIDE: [[usize; 4]; 6] = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [3, 7, 6, 2], [0, 4, 7, 3], [1, 2, 6, 5]];

#[test]
fn environment() {
    let table = Table {
        name: "environment",
        background: ONES,
        primitives: vec![
            sphere([-2.5, 0.0, 0.0], 1.0, lambert(ONES)),
            sphere([0.0, 0.0, 0.0], 1.0, MIRROR),
            sphere([2.5, 0.0, 0.0], 1.0, GLASS),
        ],
        ..upright([0.0, -8.0, 0.0], [0.0, 1.0, 0.0], 0.36)
    };
    check(&simple::environment().expect("a scene"), &table);
}

#[test]
fn furnace_boxes() {
    for albedo in [0.0, 0.5, 0.75] {
        let wall: Look = ("lambert", [albedo; 3], [0.0; 2], ONES, 1.0 - albedo);
        let inside = OUTSIDE.map(|[a, b, c, d]| [a, d, c, b]);
        let primitives = faces(&CUBE, &inside, wall);
        let lamp = |(shape, _): &(Shape, Look)| (Lamp::Other(shape.clone()), ONES, 2.0);
        let table = Table {
            name: "furnace-box",
            emitters: primitives.iter().map(lamp).collect(),
            primitives,
            ..upright([-0.7, -0.4, 0.1], [1.3, 0.9, -0.3], 1.0)
        };
        check(&simple::furnace_box(albedo).expect("a scene"), &table);
    }
}

#[test]
fn cavities() {
    for (albedo, cap) in [(0.75, Cap::Reflecting), (0.5, Cap::Black)] {
        let dark: Look = ("lambert", [albedo; 3], [0.0; 2], BLACK, 1.0 - albedo);
        let lit: Look = match cap {
            Cap::Reflecting => ("lambert", [albedo; 3], [0.0; 2], ONES, 1.0 - albedo),
            Cap::Black => ("black", BLACK, [0.0; 2], ONES, 0.0),
        };
        // All within 60° of the pole of a unit sphere: above height 1/2.
        let lower = Shape::Ball(BLACK, 1.0, [f64::NEG_INFINITY, 0.5], true);
        let upper = Shape::Ball(BLACK, 1.0, [0.5, f64::INFINITY], true);
        let table = Table {
            name: "cavity-cap",
            primitives: vec![(lower, dark), (upper.clone(), lit)],
            emitters: vec![(Lamp::Other(upper), ONES, PI)],
            ..upright([0.3, -0.5, 0.1], [-0.3, 1.5, -0.9], 0.3)
        };
        check(&simple::cavity_cap(albedo, cap).expect("a scene"), &table);
    }
    assert_eq!(simple::CAP_SHARE, 0.25);
}

#[test]
fn glass_cubes() {
    for (inside, eye, direction) in
        [(false, [2.7, -3.9, 2.1], [-2.7, 3.9, -2.1]), (true, [0.09, -0.13, 0.07], [0.0, 1.0, 0.0])]
    {
        let table = Table {
            name: "glass-cube",
            background: ONES,
            primitives: faces(&CUBE, &OUTSIDE, GLASS),
            ..upright(eye, direction, 0.5)
        };
        check(&simple::glass_cube(inside).expect("a scene"), &table);
    }
}

/// Quadrilaterals of the Cornell box in millimetres, counter-clockwise from the front: surface and corners; floor,
/// ceiling, back, right, left, light, then the short and the tall block, top and sides.
const CORNELL: &str = "\
white 552.8 0 0  0 0 0  0 0 559.2  549.6 0 559.2
white 556 548.8 0  556 548.8 559.2  0 548.8 559.2  0 548.8 0
white 549.6 0 559.2  0 0 559.2  0 548.8 559.2  556 548.8 559.2
green 0 0 559.2  0 0 0  0 548.8 0  0 548.8 559.2
red 552.8 0 0  549.6 0 559.2  556 548.8 559.2  556 548.8 0
light 343 548.7 227  343 548.7 332  213 548.7 332  213 548.7 227
white 130 165 65  82 165 225  240 165 272  290 165 114
white 290 0 114  290 165 114  240 165 272  240 0 272
white 130 0 65  130 165 65  290 165 114  290 0 114
white 82 0 225  82 165 225  130 165 65  130 0 65
white 240 0 272  240 165 272  82 165 225  82 0 225
white 423 330 247  265 330 296  314 330 456  472 330 406
white 423 0 247  423 330 247  472 330 406  472 0 406
white 472 0 406  472 330 406  314 330 456  314 0 456
white 314 0 456  314 330 456  265 330 296  265 0 296
white 265 0 296  265 330 296  423 330 247  423 0 247";

/// The Cornell box as Cornell published it (Program of Computer Graphics, 1998): positions in
/// millimetres, here in decimetres, focal length 0.035 and image 0.025 × 0.025. Here the light hangs
/// 0.1 mm under the ceiling, which has no hole for it.
#[test]
fn cornell_box() {
    let white = lambert([0.73; 3]);
    let red = lambert([0.63, 0.065, 0.05]);
    let green = lambert([0.14, 0.45, 0.091]);
    let light: Look = ("lambert", [0.78; 3], [0.0; 2], [17.0, 12.0, 4.0], 0.0);
    let primitives = CORNELL
        .lines()
        .flat_map(|line| {
            let mut words = line.split_whitespace();
            let look = match words.next() {
                Some("red") => red,
                Some("green") => green,
                Some("light") => light,
                _ => white,
            };
            let decimetres = |word: &str| word.parse::<f64>().expect("a number") / 100.0;
            let numbers: Vec<f64> = words.map(decimetres).collect();
            let corners: Vec<[f64; 3]> = numbers.chunks(3).map(|c| [c[0], c[1], c[2]]).collect();
            faces(&corners, &[[0, 1, 2, 3]], look)
        })
        .collect();
    let edges = [[0.0, 0.0, 1.05], [-1.3, 0.0, 0.0]];
    let emitter = Lamp::Rectangle([3.43, 5.487, 2.27], edges, [0.0, -1.0, 0.0]);
    let table = Table {
        name: "cornell",
        background: BLACK,
        primitives,
        emitters: vec![(emitter, [17.0, 12.0, 4.0], 1.365)],
        // Looking along z with y up, the image's right is −x.
        camera: ([2.78, 2.73, -8.0], [0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], 0.0125 / 0.035),
    };
    check(&simple::cornell().expect("a scene"), &table);
}

/// The room as measured, with looks of mirror, glass and white objects, and of the eight surfaces: floor
/// and ceiling, then the walls as below.
fn room_table(name: &'static str, objects: [Look; 3], albedos: [[f64; 3]; 7]) -> Table {
    let ring = |z: f64| OUTLINE.map(|[x, y]| [x, y, z]);
    let corners = [ring(-5.0), ring(5.0)].concat();
    let wall = |albedo| -> Look { ("lambert", albedo, [0.0; 2], BLACK, 0.25) };
    let mut primitives = faces(&corners, &[[0, 1, 2, 3, 4, 5]], wall(albedos[0]));
    primitives.extend(faces(&corners, &[[6, 11, 10, 9, 8, 7]], wall(albedos[0])));
    for i in 0..6 {
        let next = (i + 1) % 6;
        let polygon = [i, i + 6, next + 6, next];
        primitives.extend(faces(&corners, &[polygon], wall(albedos[i + 1])));
    }
    let black: Look = ("black", BLACK, [0.0; 2], [50.0; 3], 0.0);
    let lamp = [[3.0, -1.0, 4.999], [3.0, 1.0, 4.999], [5.0, 1.0, 4.999], [5.0, -1.0, 4.999]];
    primitives.extend(faces(&lamp, &[[0, 1, 2, 3]], black));
    let [mirror, glass, white] = objects;
    primitives.push(sphere([2.5, 4.0, -2.0], 2.0, mirror));
    primitives.push(sphere([3.25, -0.5, -3.0], 2.0, glass));
    primitives.push(sphere([0.0, 1.5, 0.0], 1.5, white));
    let tetrahedron = [[0.0, -6.0, -5.0], [4.0, -6.0, -5.0], [0.0, -2.0, -5.0], [0.0, -6.0, -1.0]];
    let sides = [[1, 2, 3], [0, 2, 1], [0, 1, 3], [0, 3, 2]];
    primitives.extend(faces(&tetrahedron, &sides, mirror));
    let edges = [[0.0, 2.0, 0.0], [2.0, 0.0, 0.0]];
    let emitter = Lamp::Rectangle(lamp[0], edges, [0.0, 0.0, -1.0]);
    Table {
        name,
        primitives,
        emitters: vec![(emitter, [50.0; 3], 4.0)],
        ..upright([12.5, 0.0, 0.0], [-1.0, 0.0, 0.0], 0.77704)
    }
}

/// Albedos of floor and ceiling and of the walls: dark blue, red, green, magenta, cyan, yellow.
const COLOURED: [[f64; 3]; 7] = [
    [0.75, 0.75, 0.75],
    [0.11775, 0.156, 0.432],
    [0.75, 0.1875, 0.1875],
    [0.0, 0.75, 0.375],
    [0.75, 0.0, 0.75],
    [0.0, 0.75, 0.75],
    [0.75, 0.75, 0.0],
];

/// The same as grey of equal luminance: 0.2126, 0.7152 and 0.0722 of red, green and blue.
fn grey() -> [[f64; 3]; 7] {
    COLOURED.map(|[r, g, b]| [0.2126 * r + 0.7152 * g + 0.0722 * b; 3])
}

#[test]
fn the_reports_room() {
    let forms = [(OrenNayarForm::Corrected, "oren-nayar, corrected"), (OrenNayarForm::Printed, "oren-nayar, printed")];
    for (form, kind) in forms {
        // A and B of Oren and Nayar at σ = 0.3: σ² = 0.09.
        let [a, b] = [1.0 - 0.5 * 0.09 / 0.42, 0.45 * 0.09 / 0.18];
        let rough: Look = (kind, [0.55; 3], [a, b], BLACK, 0.0);
        let smooth: Look = (kind, ONES, [1.0, 0.0], BLACK, 0.0);
        for (convention, white) in
            [(Convention::Physical, rough), (Convention::Report, rough), (Convention::Published, smooth)]
        {
            for (walls, albedos) in [(Walls::Coloured, COLOURED), (Walls::Grey, grey())] {
                let scene = room::report_with(convention, form, walls).expect("a scene");
                check(&scene, &room_table("report", [MIRROR, GLASS, white], albedos));
            }
        }
    }
}

#[test]
fn the_diffuse_room() {
    let half = lambert([0.5; 3]);
    let objects = [half, half, lambert([0.55; 3])];
    for (walls, albedos) in [(Walls::Coloured, COLOURED), (Walls::Grey, grey())] {
        let scene = room::diffuse_with(walls).expect("a scene");
        check(&scene, &room_table("diffuse-room", objects, albedos));
    }
}
