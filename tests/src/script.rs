//! Chosen numbers in the place of random ones.

use rand::TryRng;

use whitefurnace::sampling::sampler::Sampler;

/// Says which number comes next.
pub trait Script {
    /// A number of [0, 1).
    fn number(&mut self) -> f64;
    /// The next numbers belong to this block.
    fn block(&mut self, _block: u32) {}
}

/// A sampler that reads from a script: [`whitefurnace::sampling::rng::uniform`] returns the 53 leading bits
/// of its numbers.
pub struct Scripted<T>(pub T);

impl<T: Script> TryRng for Scripted<T> {
    type Error = std::convert::Infallible;
    fn try_next_u32(&mut self) -> Result<u32, Self::Error> {
        Ok((self.try_next_u64()? >> 32) as u32)
    }
    fn try_next_u64(&mut self) -> Result<u64, Self::Error> {
        let bits = (self.0.number() * (1u64 << 53) as f64) as u64;
        Ok(bits.min((1 << 53) - 1) << 11)
    }
    fn try_fill_bytes(&mut self, bytes: &mut [u8]) -> Result<(), Self::Error> {
        for chunk in bytes.chunks_mut(8) {
            let word = self.try_next_u64()?.to_be_bytes();
            chunk.copy_from_slice(&word[..chunk.len()]);
        }
        Ok(())
    }
}

impl<T: Script> Sampler for Scripted<T> {
    fn block(&mut self, block: u32) {
        self.0.block(block);
    }
}

/// Numbers in the order in which they are asked for; after the last, 0.
impl Script for std::slice::Iter<'_, f64> {
    fn number(&mut self) -> f64 {
        self.next().copied().unwrap_or(0.0)
    }
}
