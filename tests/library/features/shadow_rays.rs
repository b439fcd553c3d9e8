//! Tests that shadow rays and paths find the same light: along the same path, with pdfs on which
//! both agree.
//!
//! If that holds for every path, weights that sum to one leave the mean unchanged. It is tested
//! path by path, without noise, so that errors are detected that are far too small or too rare for
//! the mean of an image.

use std::sync::Mutex;

use whitefurnace::geometry::specular_connection::{CasterKind, SpecularConnection};
use whitefurnace::light::emitter::EmitterPoint;
use whitefurnace::light::environment::EnvironmentMap;
use whitefurnace::material::{BsdfSample, Vertex};
use whitefurnace::scene::specular_casters::SpecularCaster;

use super::scenes::{SCENE, scene_of};
use super::table::{Row, table};
use super::{by_area, path_of, path_rows};
use crate::prelude::*;

/// An unoccluded shadow ray: the direction in which it left, the kind of specular caster on its
/// path, and its pdf and that of a path in this direction.
#[derive(Clone, Copy, Debug)]
struct ShadowRay {
    direction: DVec3,
    by: Option<CasterKind>,
    pdfs: [f64; 2],
}

/// Pdf, with respect to solid angle, that occurs only where the cosine at the light is zero up to
/// rounding.
const EDGE_ON: f64 = 1e10;

/// Events of one path.
#[derive(Default)]
struct Events {
    /// Whether a shadow ray is being sent, and whether by specular next-event estimation.
    sends: bool,
    direct: DVec3,
    /// The specular connection that was asked for last, and the connection once it is unoccluded.
    connection: Option<(DVec3, CasterKind)>,
    free: Option<(DVec3, CasterKind)>,
    /// Shadow rays from the present vertex.
    shadow_rays: Vec<ShadowRay>,
    /// The shadow ray that the path follows, and the number of mirror and glass surfaces ahead.
    followed: Option<(ShadowRay, u32)>,
    /// Point and normal where the path left a surface that is neither a mirror nor smooth glass,
    /// and whether that was rough glass.
    left: Option<(DVec3, DVec3, bool)>,
    /// Point and normal where the path left its last surface, and the number of mirror and glass
    /// surfaces in between.
    last: (DVec3, DVec3),
    between: u32,
    /// Whether the path was absorbed.
    ended: bool,
    found: Vec<Found>,
}

/// A fact about one path.
#[derive(Debug)]
enum Found {
    /// The path met the light that a shadow ray had found: the shadow ray, and the pdfs that weight
    /// the hit.
    Followed(ShadowRay, [f64; 2]),
    /// A path hit something through mirrors and glass: whether the hit was weighted, and whether a
    /// shadow ray finds it.
    Hit { weighted: bool, specular_nee: bool },
}

/// Parts whose path follows, if `follows`, the last shadow ray of its vertex, and which record the
/// calls of the path tracer.
struct ShadowRayFollower<'a> {
    scene: &'a Scene,
    follows: bool,
    events: Mutex<Events>,
}

impl ShadowRayFollower<'_> {
    fn events(&self) -> std::sync::MutexGuard<'_, Events> {
        self.events.lock().expect("no thread has panicked")
    }

    /// Records a hit, which the path tracer weights by pdfs, or not.
    fn hit(&self, pdfs: Option<[f64; 2]>) {
        let mut events = self.events();
        if events.ended {
            return;
        }
        if let (Some(pdfs), Some((sent, 0))) = (pdfs, events.followed) {
            events.followed = None;
            events.found.push(Found::Followed(sent, pdfs));
        }
        let (from, onward) = events.last;
        let offset = 1e-7;
        if let Some((start, direction, rough_glass)) = events.left
            && events.between > 0
            && let Some(hit) = self
                .scene
                .intersect(&Ray::new(from + offset * onward, onward))
        {
            let takes = |caster: &SpecularCaster| {
                caster.kind.bounces() == events.between
                    && caster
                        .connections(start, hit.point)
                        .any(|(_, connection)| connection.direction.distance(direction) < 1e-5)
            };
            let specular_nee =
                !rough_glass && self.scene.specular_casters().all().iter().any(takes);
            events.found.push(Found::Hit {
                weighted: pdfs.is_some(),
                specular_nee,
            });
        }
    }
}

default_parts!(ShadowRayFollower<'_>: Photons, Bidirectional, FiniteElements);

impl NextEvent for ShadowRayFollower<'_> {
    fn sample_emitter(&self, emitter: &Emitter, random: [f64; 2]) -> EmitterPoint {
        self.events().sends = true;
        DefaultParts.sample_emitter(emitter, random)
    }
    fn sample_solid_angle(
        &self,
        emitter: &Emitter,
        from: DVec3,
        random: [f64; 2],
    ) -> Option<(EmitterPoint, f64)> {
        self.events().sends = true;
        DefaultParts.sample_solid_angle(emitter, from, random)
    }
    fn sample_map(&self, map: &EnvironmentMap, random: [f64; 2]) -> (DVec3, f64) {
        let (direction, pdf) = DefaultParts.sample_map(map, random);
        let mut events = self.events();
        (events.sends, events.direct) = (true, direction);
        (direction, pdf)
    }
    fn visible(&self, scene: &Scene, x: SurfacePoint, y: SurfacePoint, glass: bool) -> bool {
        let mut events = self.events();
        if events.connection.is_none() {
            events.direct = (y.point - x.point).normalize();
        }
        DefaultParts.visible(scene, x, y, glass)
    }
    fn connection(
        &self,
        caster: &SpecularCaster,
        number: usize,
        connection: SpecularConnection<DVec3>,
    ) -> Option<SpecularConnection<DVec3>> {
        self.events().connection = Some((connection.direction, caster.kind));
        DefaultParts.connection(caster, number, connection)
    }
    fn caster_throughput(&self, caster: &SpecularCaster, cosine: f64) -> (DVec3, f64) {
        let mut events = self.events();
        events.free = events.connection;
        DefaultParts.caster_throughput(caster, cosine)
    }
    fn mis_weight(&self, pdf: f64, other: f64) -> f64 {
        let mut events = self.events();
        if events.sends {
            let (direction, by) = events
                .free
                .take()
                .map_or((events.direct, None), |(d, kind)| (d, Some(kind)));
            // Light seen along its own plane, up to rounding, adds nothing.
            if pdf < EDGE_ON {
                events.shadow_rays.push(ShadowRay {
                    direction,
                    by,
                    pdfs: [pdf, other],
                });
            }
        } else {
            drop(events);
            self.hit(Some([pdf, other]));
        }
        DefaultParts.mis_weight(pdf, other)
    }
    fn mis_power_weight(&self, pdf: f64, other: f64) -> f64 {
        self.mis_weight(pdf, other)
    }
    fn counts_emission(&self, strategy: PathStrategy, sampled: bool) -> bool {
        self.hit(None);
        DefaultParts.counts_emission(strategy, sampled)
    }
}

impl Roulette for ShadowRayFollower<'_> {
    fn survival_by_throughput(&self, _: DVec3, _: bool) -> f64 {
        0.8
    }
    fn survives(&self, r: f64, survival: f64) -> bool {
        let mut events = self.events();
        events.ended = r >= survival && events.followed.is_none();
        !events.ended
    }
    fn roulette_weight(&self, _: f64) -> f64 {
        1.0
    }
}

/// Positions of objects in the scenes, at which paths that follow no shadow ray are aimed.
const OBJECTS: [DVec3; 6] = [
    DVec3::new(-0.75, 0.0, 0.0),
    DVec3::new(0.75, 0.0, 0.0),
    DVec3::new(0.0, -0.2, 1.0),
    DVec3::new(0.0, -0.7, -0.4),
    DVec3::new(0.0, 0.7, -0.2),
    DVec3::new(0.0, 1.4, 0.2),
];

/// Transmits through glass half of the time. Weights do not matter here.
impl Scattering for ShadowRayFollower<'_> {
    fn sample(&self, bsdf: &Bsdf, at: &Vertex, rng: &mut dyn Rng) -> Option<BsdfSample> {
        let mut guard = self.events();
        let Events {
            shadow_rays,
            mut followed,
            left,
            between,
            found,
            ..
        } = std::mem::take(&mut *guard);
        let [coin, which] = uniform2(rng);
        let mut sample = match *bsdf {
            Bsdf::Glass { index } => {
                let passes = followed.map_or(coin < 0.5, |(sent, _)| {
                    sent.by == Some(CasterKind::Refraction)
                });
                Some(self.sample_glass(index, at, f64::from(u8::from(passes))))
            }
            _ => DefaultParts.sample(bsdf, at, rng),
        };
        if bsdf.is_non_delta()
            && let Some(sample) = &mut sample
        {
            let pick = |count: usize| (which * count as f64) as usize;
            if self.follows && !shadow_rays.is_empty() {
                let sent = shadow_rays[pick(shadow_rays.len())];
                followed = Some((sent, sent.by.map_or(0, CasterKind::bounces)));
                sample.direction = sent.direction;
            } else {
                let direction =
                    (OBJECTS[pick(OBJECTS.len())] + in_cube(rng, 0.5) - at.point).normalize();
                if bsdf.is_rough_glass() || direction.dot(at.frame.z) > 0.0 {
                    sample.direction = direction;
                }
            }
            let oriented = match *bsdf {
                Bsdf::RoughGlass(glass) => Bsdf::RoughGlass(glass.oriented(at.outside)),
                other => other,
            };
            sample.pdf = Some(DefaultParts.pdf(&oriented, at.wo, at.frame.local(sample.direction)));
        } else if let Some((_, left @ 1..)) = &mut followed {
            *left -= 1;
        }
        let direction = sample.map_or(DVec3::ZERO, |sample| sample.direction);
        *guard = Events {
            followed,
            found,
            ended: sample.is_none(),
            last: (at.point, direction),
            ..Events::default()
        };
        (guard.left, guard.between) = if bsdf.is_non_delta() {
            (Some((at.point, direction, bsdf.is_rough_glass())), 0)
        } else {
            (left, between + 1)
        };
        sample
    }
}

/// Passes the events of some paths of each scene of the table to `check`, with the settings of its
/// row.
fn watch(follows: bool, mut check: impl FnMut(&Row, &Path<'_>, Found)) {
    let mut rng = rng("features");
    for row in path_rows() {
        let row = row.with("finds", "mis");
        let scene = scene_of(&row);
        let settings = path_of(&row);
        let parts = ShadowRayFollower {
            scene: &scene,
            follows,
            events: Mutex::default(),
        };
        let path = settings.with_parts(Parts::replaced(&parts));
        for _ in 0..(2000.0 * context("features").scale) as u32 {
            let [x, y] = uniform2(&mut rng);
            let ray = scene.camera().ray([1, 1], x, y);
            path.radiance(&scene, &ray, scene.intersect(&ray), &mut rng);
            let events = std::mem::take(&mut *parts.events());
            assert!(
                events.followed.is_none(),
                "a shadow ray found {:?}, no path hits it: {row}",
                events.followed
            );
            events
                .found
                .into_iter()
                .for_each(|found| check(&row, &settings, found));
        }
    }
}

/// Paths that follow a shadow ray, direct, to a map, or along a specular connection, hit the light
/// that it found, and both weight it by the same pdfs.
#[test]
fn paths_hit_what_shadow_rays_find() {
    let mut counts = [0; 5];
    watch(true, |row, _, found| {
        let Found::Followed(sent, [pdf, other]) = found else {
            return;
        };
        let [by_light, by_path] = sent.pdfs;
        // On a caustic pdfs have rounding errors of any size, which change no weight.
        let weights = [by_light / (by_light + by_path), pdf / (pdf + other)];
        assert!(
            (weights[0] + weights[1] - 1.0).abs() < 1e-6,
            "{sent:?} and [{pdf}, {other}]: {row}"
        );
        counts[sent.by.map_or(3, |kind| kind as usize)] += 1;
        counts[4] += usize::from(row.is("background", "map"));
    });
    assert!(
        counts.iter().all(|&count| count > 50),
        "{counts:?} flat, reflected, refracted, direct; with a map"
    );
}

/// Light that paths hit through mirrors and glass is weighted if and only if a shadow ray finds it.
#[test]
fn shadow_rays_find_what_paths_weight() {
    let mut counts = [0; 2];
    watch(false, |row, path, found| {
        let Found::Hit {
            weighted,
            specular_nee,
        } = found
        else {
            return;
        };
        let specular_nee = specular_nee && path.specular_nee && !row.is("background", "map");
        assert_eq!(weighted, specular_nee, "{row}");
        counts[usize::from(weighted)] += 1;
    });
    assert!(
        counts.iter().all(|&count| count > 50),
        "{counts:?} not weighted and weighted"
    );
}

/// Whether the last surface that a path of the report's estimator left scatters diffusely, and
/// whether any before did.
struct LastScatteringRecorder {
    rules: TransportRules,
    last_and_any: Mutex<[bool; 2]>,
}

default_parts!(LastScatteringRecorder: Roulette, Photons, Bidirectional, FiniteElements);

impl NextEvent for LastScatteringRecorder {
    fn counts_emission(&self, strategy: PathStrategy, sampled: bool) -> bool {
        let [last, any] = *self.last_and_any.lock().expect("no thread has panicked");
        assert_eq!(sampled, if self.rules.caustics { last } else { any });
        DefaultParts.counts_emission(strategy, sampled)
    }
}

impl Scattering for LastScatteringRecorder {
    fn sample(&self, bsdf: &Bsdf, at: &Vertex, rng: &mut dyn Rng) -> Option<BsdfSample> {
        self.last_and_any.lock().expect("no thread has panicked")[0] = false;
        DefaultParts.sample(bsdf, at, rng)
    }
    fn sample_uniform(&self, bsdf: &Bsdf, wo: DVec3, random: [f64; 2]) -> BsdfSample {
        *self.last_and_any.lock().expect("no thread has panicked") = [true; 2];
        DefaultParts.sample_uniform(bsdf, wo, random)
    }
}

/// The report's estimator counts the emission of a hit if no shadow ray looked for it, whatever is
/// in between: by its own rules until a path has left a diffuse surface, by physical rules wherever
/// the last surface was a mirror or glass.
#[test]
fn the_report_counts_hits_that_its_shadow_rays_do_not_find() {
    let mut rng = rng("features");
    for row in table(&SCENE, by_area) {
        let scene = scene_of(&row);
        for rules in [
            TransportRules::PHYSICAL,
            TransportRules {
                shadows_pass_glass: false,
                ..TransportRules::REPORT
            },
        ] {
            let parts = LastScatteringRecorder {
                rules,
                last_and_any: Mutex::default(),
            };
            let report = Report {
                parts: Parts::replaced(&parts),
                rules,
                segments: 30,
                rays: 1,
            };
            for _ in 0..(500.0 * context("features").scale) as u32 {
                *parts.last_and_any.lock().expect("no thread has panicked") = [false; 2];
                let [x, y] = uniform2(&mut rng);
                let ray = scene.camera().ray([1, 1], x, y);
                report.radiance(&scene, &ray, scene.intersect(&ray), &mut rng);
            }
        }
    }
}
