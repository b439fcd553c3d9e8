//! Polygons of meshes: division into triangles, and removal of duplicates.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use glam::{DVec2, DVec3};
use spade::{
    ConstrainedDelaunayTriangulation, HasPosition, MIN_ALLOWED_VALUE, Point2, Triangulation as _,
};

/// Largest distance of a corner from the plane of a face that counts as flat, as a fraction of the
/// face's extent.
const FLAT: f64 = 1e-3;

/// The polygons of one mesh as triangles, each polygon once.
#[derive(Default)]
pub(super) struct Polygons {
    /// First vertex at each place, whose coordinates are given by their bits.
    places: HashMap<[u64; 3], u32>,
    /// For each vertex, the first at its place.
    first_vertices: Vec<u32>,
    /// Polygons added, and whether each goes against the direction of its [`cycle`]. Those of three
    /// corners, most of a mesh, are in a table of their own.
    seen_triangles: HashMap<[u32; 3], bool>,
    seen_others: HashMap<Vec<u32>, bool>,
    faces: usize,
    repeated: usize,
    turned_over: usize,
    bent: usize,
}

impl Polygons {
    /// Adds a polygon and returns its triangles, counter-clockwise as it is; none for one that was
    /// added before, whichever its side.
    ///
    /// # Errors
    /// A message for a polygon that crosses itself.
    pub fn add(&mut self, vertices: &[DVec3], corners: &[u32]) -> Result<Vec<[u32; 3]>, String> {
        let known = self.first_vertices.len();
        for (index, vertex) in (known as u32..).zip(&vertices[known..]) {
            let first = *self.places.entry(bits(*vertex)).or_insert(index);
            self.first_vertices.push(first);
        }
        self.faces += 1;
        if let Some(goes_round_alike) = self.see(corners) {
            self.repeated += 1;
            self.turned_over += usize::from(!goes_round_alike);
            return Ok(Vec::new());
        }
        if let &[a, b, c] = corners {
            return Ok(vec![[a, b, c]]);
        }
        let points: Vec<DVec3> = corners.iter().map(|&i| vertices[i as usize]).collect();
        self.bent += usize::from(is_bent(&points));
        let triangles = divide(&points)
            .ok_or("crosses itself or folds back on itself: divide it into triangles")?;
        Ok(triangles
            .iter()
            .map(|triangle| triangle.map(|i| corners[i]))
            .collect())
    }

    /// Records a polygon. If it was seen before, returns whether it goes round as it did then.
    fn see(&mut self, corners: &[u32]) -> Option<bool> {
        let first_vertex = |&i: &u32| self.first_vertices[i as usize];
        let (key, reversed) = cycle(corners.iter().map(first_vertex).collect());
        let before = match <[u32; 3]>::try_from(&key[..]) {
            Ok(triangle) => first_value(self.seen_triangles.entry(triangle), reversed),
            Err(_) => first_value(self.seen_others.entry(key), reversed),
        };
        before.map(|before| before == reversed)
    }

    /// Iterates over notes for the user about the polygons added.
    pub fn notes(&self) -> impl Iterator<Item = String> {
        let Self {
            faces,
            repeated,
            turned_over,
            bent,
            ..
        } = *self;
        let twice = (repeated > 0).then(|| {
            format!(
                "{repeated} of {faces} faces repeat an earlier one, {turned_over} of them turned over: the first of \
                 each is kept, and if it emits, it emits to the side of its own front only"
            )
        });
        let bent = (bent > 0).then(|| {
            format!("{bent} of {faces} faces are not flat: other programs may divide them into other triangles")
        });
        twice.into_iter().chain(bent)
    }
}

/// Returns the value of an entry, or inserts one.
fn first_value<K>(entry: Entry<'_, K, bool>, value: bool) -> Option<bool> {
    match entry {
        Entry::Occupied(first) => Some(*first.get()),
        Entry::Vacant(new) => {
            new.insert(value);
            None
        }
    }
}

/// Returns the coordinates' bits, with one zero for both signs.
fn bits(v: DVec3) -> [u64; 3] {
    v.to_array().map(|x| (x + 0.0).to_bits())
}

/// Returns a polygon's form that does not depend on its first corner, its direction and corners
/// repeated in a row; and whether that form goes the other way round.
fn cycle(mut corners: Vec<u32>) -> (Vec<u32>, bool) {
    corners.dedup();
    if corners.len() > 1 && corners.first() == corners.last() {
        corners.pop();
    }
    let rotated = |mut corners: Vec<u32>| {
        let next = |i: usize| corners[(i + 1) % corners.len()];
        let start = (0..corners.len()).min_by_key(|&i| (corners[i], next(i)));
        corners.rotate_left(start.unwrap_or(0));
        corners
    };
    let reversed = rotated(corners.iter().rev().copied().collect());
    let corners = rotated(corners);
    if reversed < corners {
        (reversed, true)
    } else {
        (corners, false)
    }
}

/// Returns the normal of the plane that fits a polygon, times twice the area within it (Newell's
/// sum).
fn newell(points: &[DVec3]) -> DVec3 {
    let from_first = |i: usize| points[i] - points[0];
    (1..points.len() - 1)
        .map(|i| from_first(i).cross(from_first(i + 1)))
        .sum()
}

fn is_bent(points: &[DVec3]) -> bool {
    let middle = points.iter().sum::<DVec3>() / points.len() as f64;
    let extent = points
        .iter()
        .map(|p| p.distance(middle))
        .fold(0.0, f64::max);
    let normal = newell(points).normalize_or_zero();
    points
        .iter()
        .any(|p| (*p - middle).dot(normal).abs() > FLAT * extent)
}

/// Returns the triangles of a polygon of four corners or more by their indices; `None` if it crosses
/// itself, seen along its normal.
///
/// A polygon whose triangles from its first corner cover it, and one without area are
/// divided from the first corner. For others the triangles are those of the constrained Delaunay
/// triangulation of the polygon in projection within which its winding number is 1; it must be 0 or
/// 1 everywhere, so that holes joined to the outside by an edge there and back are holes.
fn divide(points: &[DVec3]) -> Option<Vec<[usize; 3]>> {
    let fan: Vec<[usize; 3]> = (1..points.len() - 1).map(|i| [0, i, i + 1]).collect();
    let area = |[a, b, c]: [usize; 3]| (points[b] - points[a]).cross(points[c] - points[a]);
    let flat = flattened(points);
    if fan_covers(&flat) || fan.iter().all(|t| area(*t) == DVec3::ZERO) {
        return Some(fan);
    }
    let mut mesh = ConstrainedDelaunayTriangulation::<Corner>::new();
    let mut handles = Vec::with_capacity(points.len());
    for (index, at) in flat.iter().enumerate() {
        let [x, y] = at
            .to_array()
            .map(|x| if x.abs() < MIN_ALLOWED_VALUE { 0.0 } else { x });
        let handle = mesh
            .insert(Corner {
                index,
                at: Point2::new(x, y),
            })
            .ok()?;
        handles.push(handle);
    }
    // Corners that coincide in projection only.
    if handles
        .iter()
        .zip(points)
        .any(|(&handle, point)| points[mesh.vertex(handle).data().index] != *point)
    {
        return None;
    }
    let mut crossings = HashMap::<(usize, usize), i64>::new();
    for (k, &from) in handles.iter().enumerate() {
        let to = handles[(k + 1) % handles.len()];
        let edges = mesh.try_add_constraint(from, to);
        if edges.is_empty() && from != to {
            return None;
        }
        for edge in edges {
            let [a, b] = mesh.directed_edge(edge).vertices().map(|v| v.fix().index());
            *crossings.entry((a, b)).or_default() += 1;
            *crossings.entry((b, a)).or_default() -= 1;
        }
    }
    let mut windings = vec![None; mesh.num_all_faces()];
    windings[mesh.outer_face().fix().index()] = Some(0);
    let mut open: Vec<_> = mesh
        .directed_edges()
        .filter(|edge| edge.face().is_outer())
        .collect();
    while let Some(edge) = open.pop() {
        let [a, b] = edge.vertices().map(|v| v.fix().index());
        let across = edge.rev().face();
        if windings[across.fix().index()].is_some() {
            continue;
        }
        let winding =
            windings[edge.face().fix().index()]? - crossings.get(&(a, b)).copied().unwrap_or(0);
        windings[across.fix().index()] = Some(winding);
        open.extend(
            across
                .as_inner()
                .into_iter()
                .flat_map(|face| face.adjacent_edges()),
        );
    }
    if windings
        .iter()
        .any(|winding| !matches!(winding, Some(0 | 1)))
    {
        return None;
    }
    let inside = mesh
        .inner_faces()
        .filter(|face| windings[face.fix().index()] == Some(1));
    let triangles: Vec<_> = inside
        .map(|face| face.vertices().map(|v| v.data().index))
        .collect();
    (!triangles.is_empty()).then_some(triangles)
}

/// A corner of a polygon in projection.
struct Corner {
    index: usize,
    at: Point2<f64>,
}

impl HasPosition for Corner {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        self.at
    }
}

/// Projects a polygon along the axis nearest to its normal, so that it is counter-clockwise.
fn flattened(points: &[DVec3]) -> Vec<DVec2> {
    let normal = newell(points);
    let axis = normal.abs().max_position();
    let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
    let project = |p: &DVec3| {
        if normal[axis] < 0.0 {
            DVec2::new(p[v], p[u])
        } else {
            DVec2::new(p[u], p[v])
        }
    };
    points.iter().map(project).collect()
}

/// Returns whether the triangles from the first corner turn one way and all within half a turn, so
/// that they cover the polygon.
fn fan_covers(points: &[DVec2]) -> bool {
    let side = |i: usize, j: usize| (points[i] - points[0]).perp_dot(points[j] - points[0]);
    (2..points.len()).all(|i| side(i - 1, i) > 0.0 && side(1, i) > 0.0)
}
