//! Several paths at a time: the rays of all lanes, the surfaces that they meet, their random
//! numbers, and the loops over samples in which estimators follow them.
//!
//! All is generic over the numbers of a lane and over their count: eight in double precision,
//! sixteen in single precision, or one. A sample draws the same random numbers in any lane, and
//! arithmetic rounds lane by lane, so its value does not depend on the count. When a path ends, its
//! lane takes the next sample.

mod interaction;
mod rays;
mod row;
mod samples;
mod scattering;
mod scene;
mod state;
mod trace;
mod walls;

pub(crate) use interaction::{BsdfAt, ShadingPoint, SurfaceInteraction};
pub use rays::{EightRays, LaneRays};
pub(crate) use row::RowRenderer;
pub(crate) use samples::{LaneSampler, Sources};
pub(crate) use scattering::BsdfSample;
pub(crate) use scene::{IntersectionScratch, LaneScene, SceneData};
pub(crate) use state::{Arrival, Integrator, PathState};
pub(crate) use trace::radiances;

/// The lanes whose bits are set.
#[inline]
pub(crate) fn lanes_of(mut bits: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = bits.trailing_zeros() as usize;
        bits &= bits.wrapping_sub(1);
        (lane < 32).then_some(lane)
    })
}
