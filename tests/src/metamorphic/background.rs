//! Backgrounds of random scenes: one radiance, or an image of all directions.

use glam::DVec3;
use serde::{Deserialize, Serialize};
use whitefurnace::image::read::decode;
use whitefurnace::light::environment::{Environment, EnvironmentMap};

use super::scene::{Similarity, Triple};

/// Radiance of rays that hit nothing, as scene files describe it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(
    untagged,
    expecting = "background needs three radiances, such as [1.0, 1.0, 1.0], or a map with image, up and front"
)]
pub enum Background {
    /// The same from all directions.
    Uniform(Triple),
    /// That of an environment map.
    Sky(Sky),
}

/// An environment map. A scene file names its image, which is a file of its own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sky {
    /// Name of the image's file.
    pub image: String,
    /// Direction of the image's upper edge.
    pub up: Triple,
    /// Direction of the image's middle.
    pub front: Triple,
    /// Width and height in pixels.
    #[serde(skip)]
    pub size: [usize; 2],
    /// Radiance of each pixel, row by row from the top, in numbers of single precision.
    #[serde(skip)]
    pub pixels: Vec<Triple>,
}

impl Background {
    /// No radiance.
    pub const BLACK: Self = Self::Uniform([0.0; 3]);

    /// Returns whether no light comes from the background.
    pub fn is_black(&self) -> bool {
        match self {
            Self::Uniform(radiance) => *radiance == [0.0; 3],
            Self::Sky(sky) => sky.pixels.iter().all(|pixel| *pixel == [0.0; 3]),
        }
    }

    /// Applies a function to every radiance. A sky that turns black becomes [`Self::BLACK`], since
    /// programs refuse black maps.
    pub fn map_radiances(&mut self, change: impl Fn(&mut Triple)) {
        match self {
            Self::Uniform(radiance) => change(radiance),
            Self::Sky(sky) => sky.pixels.iter_mut().for_each(change),
        }
        if self.is_black() {
            *self = Self::BLACK;
        }
    }

    /// Rotates and mirrors a sky. A mirrored image is read from right to left.
    pub(super) fn transform(&mut self, by: &Similarity) {
        if let Self::Sky(sky) = self {
            [sky.up, sky.front] = [sky.up, sky.front].map(|axis| by.direction(axis));
            if by.mirrored {
                sky.pixels
                    .chunks_mut(sky.size[0])
                    .for_each(<[Triple]>::reverse);
            }
        }
    }

    /// Returns the background of a scene.
    ///
    /// # Errors
    /// Those of [`EnvironmentMap::new`].
    pub fn environment(&self) -> Result<Environment, String> {
        match self {
            Self::Uniform(radiance) => Ok(Environment::Uniform(DVec3::from(*radiance))),
            Self::Sky(sky) => {
                let pixels = sky.pixels.iter().copied().map(DVec3::from).collect();
                EnvironmentMap::new(sky.size, pixels, sky.up.into(), sky.front.into())
                    .map(Environment::Map)
            }
        }
    }
}

impl Sky {
    /// Returns the image as a PFM file.
    pub fn file(&self) -> Vec<u8> {
        let [width, height] = self.size;
        // Its rows are stored from the bottom; a negative scale says that bytes are little-endian.
        let mut bytes = format!("PF\n{width} {height}\n-1.0\n").into_bytes();
        for row in self.pixels.chunks(width).rev() {
            let values = row.as_flattened().iter();
            bytes.extend(values.flat_map(|value| (*value as f32).to_le_bytes()));
        }
        bytes
    }

    /// Reads the image from the bytes of its file.
    ///
    /// # Errors
    /// A message if it is no image, or none of three channels.
    pub(super) fn read(&mut self, bytes: &[u8]) -> Result<(), String> {
        let path = std::path::Path::new(&self.image);
        let image = decode(path, bytes, None, "layer").map_err(|error| error.to_string())?;
        let [red, green, blue] = &image.values[..] else {
            return Err(format!("{} has no channels R, G, B", self.image));
        };
        self.size = image.size;
        self.pixels = red
            .iter()
            .zip(green)
            .zip(blue)
            .map(|((r, g), b)| [*r, *g, *b])
            .collect();
        Ok(())
    }
}
