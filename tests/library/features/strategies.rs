//! Tests that every strategy of bidirectional path tracing finds the same densities for a path, so
//! that all weights of one path sum to one.

use std::sync::Mutex;

use whitefurnace::integrator::{Density, weight};
use whitefurnace::light::emitter::EmitterPoint;
use whitefurnace::material::{BsdfSample, Vertex};

use super::scenes::{SCENE, scene_of};
use super::{supports_images, table::table};
use crate::prelude::*;

/// A path made by a connection: its densities, the points from the connection's other end to the
/// emitter, and how many of them the camera's walk has reached.
#[derive(Default)]
struct ConnectedPath {
    path: Vec<Density>,
    points: Vec<DVec3>,
    met: usize,
}

#[derive(Default)]
struct Events {
    /// Whether the particle's walk is over and the camera's has begun.
    eye: bool,
    /// Vertices of the particle, and the end of the last shadow ray.
    light: Vec<DVec3>,
    fresh: DVec3,
    /// Connections from the present vertex of the camera's walk, and the one that the walk follows.
    connected: Vec<ConnectedPath>,
    followed: Option<ConnectedPath>,
    /// Number of strategies that were compared on the same paths.
    compared: usize,
    finished: usize,
}

/// Parts whose walk from the camera follows a connected path to the emitter: all strategies with
/// fewer light vertices then make the path as well.
#[derive(Default)]
struct PathRetracer(Mutex<Events>);

impl PathRetracer {
    fn events(&self) -> std::sync::MutexGuard<'_, Events> {
        self.0.lock().expect("no thread has panicked")
    }

    fn start(&self, point: DVec3) {
        let mut events = self.events();
        events.fresh = point;
        if !events.eye {
            events.light = vec![point];
        }
    }
}

default_parts!(PathRetracer: Photons, FiniteElements);

impl Bidirectional for PathRetracer {
    fn importance(&self, camera: &Camera, size: [u32; 2], direction: DVec3) -> f64 {
        // Called at the start of a walk, or for a point that the camera sees.
        self.events().eye = true;
        DefaultParts.importance(camera, size, direction)
    }
    fn strategy_weight(&self, path: &[Density], s: usize) -> f64 {
        let mut events = self.events();
        if s == path.len() {
            events.eye = false;
            return weight(path, s);
        }
        if events.followed.is_none() && events.finished == 0 && s > 0 {
            let points = if s == 1 {
                vec![events.fresh]
            } else {
                events.light[..s].iter().rev().copied().collect()
            };
            events.connected.push(ConnectedPath {
                path: path.to_vec(),
                points,
                met: 0,
            });
        }
        // With one light vertex there is another one.
        if let Some(ConnectedPath {
            path: other,
            points,
            met,
        }) = &events.followed
            && path.len() == other.len()
            && s + met + 1 == points.len()
            && s != 1
        {
            let finished = s == 0;
            for k in 0..=path.len() {
                let [a, b] = [path, other].map(|path| weight(path, k));
                assert!(
                    (a - b).abs() <= 1e-6,
                    "{a} and {b} of {k}, {s} after {met}: {path:?} {other:?}"
                );
            }
            events.compared += 1;
            if finished {
                (events.followed, events.finished) = (None, events.finished + 1);
            }
        }
        weight(path, s)
    }
}

impl NextEvent for PathRetracer {
    fn sample_emitter(&self, emitter: &Emitter, random: [f64; 2]) -> EmitterPoint {
        let sampled = DefaultParts.sample_emitter(emitter, random);
        self.start(sampled.point);
        sampled
    }
    fn sample_solid_angle(
        &self,
        emitter: &Emitter,
        from: DVec3,
        random: [f64; 2],
    ) -> Option<(EmitterPoint, f64)> {
        let sampled = DefaultParts.sample_solid_angle(emitter, from, random);
        self.events().fresh = sampled.map_or(DVec3::NAN, |(sampled, _)| sampled.point);
        sampled
    }
}

impl Roulette for PathRetracer {
    fn survives(&self, r: f64, survival: f64) -> bool {
        let events = self.events();
        events.followed.is_some() || events.finished == 0 && DefaultParts.survives(r, survival)
    }
    fn roulette_weight(&self, survival: f64) -> f64 {
        match &self.events().followed {
            Some(_) => 1.0,
            None => DefaultParts.roulette_weight(survival),
        }
    }
}

impl Scattering for PathRetracer {
    fn sample(&self, bsdf: &Bsdf, at: &Vertex, rng: &mut dyn Rng) -> Option<BsdfSample> {
        let mut events = self.events();
        let Events {
            eye,
            light,
            connected,
            followed,
            ..
        } = &mut *events;
        let sample = DefaultParts.sample(bsdf, at, rng);
        if !*eye {
            light.push(at.point);
            return sample;
        }
        let followed = match followed {
            None if !connected.is_empty() => {
                let one = (uniform(rng) * connected.len() as f64) as usize;
                followed.insert(connected.swap_remove(one))
            }
            Some(connected) => {
                connected.met += 1;
                connected
            }
            None => return sample,
        };
        connected.clear();
        let direction = (followed.points.get(followed.met)? - at.point).normalize();
        match *bsdf {
            Bsdf::Mirror { .. } => sample,
            Bsdf::Glass { index } => {
                let passes = at.frame.z.dot(direction) < 0.0;
                Some(self.sample_glass(index, at, f64::from(u8::from(passes))))
            }
            _ => {
                let wi = at.frame.local(direction);
                let weighted =
                    DefaultParts.weighted(bsdf, at.wo, wi, DefaultParts.pdf(bsdf, at.wo, wi));
                Some(BsdfSample {
                    direction,
                    ..weighted
                })
            }
        }
    }
}

#[test]
fn all_strategies_of_a_path_find_its_densities() {
    let mut counts = [0; 3];
    for row in table(&SCENE, supports_images)
        .iter()
        .filter(|row| !row.is("emitter", "none") || row.get("background").starts_with("closed"))
    {
        let scene = scene_of(row);
        for index in 0..(1000.0 * context("features").scale) as u32 {
            let parts = PathRetracer::default();
            Bdpt::new(Parts::replaced(&parts))
                .pass(&scene, [1, 1], master(), index)
                .expect("legal values");
            let events = parts.0.into_inner().expect("no thread has panicked");
            if let Some(ConnectedPath { points, met, path }) = events.followed {
                panic!("the walk from the camera reached {met} of {points:?} {path:?}: {row}");
            }
            counts[0] += events.finished;
            counts[1] += events.compared;
            counts[2] += 1;
        }
    }
    let [paths, strategies, walks] = counts;
    assert!(
        5 * paths > walks && 20 * (strategies - paths) > walks,
        "{counts:?} paths, strategies of theirs, walks"
    );
}
