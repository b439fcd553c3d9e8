//! Samplers that return chosen numbers in place of random ones.

use rand::TryRng;

use whitefurnace::sampling::sampler::Sampler;

/// A source of chosen numbers.
pub trait Script {
    /// Returns the next number, in [0, 1).
    fn number(&mut self) -> f64;
    /// Begins this block: the next numbers belong to it.
    fn block(&mut self, _block: u32) {}
}

/// A sampler that reads from a script. [`whitefurnace::sampling::rng::uniform`] returns the 53
/// leading bits of its numbers.
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

/// The numbers of a slice in their order, then 0.
impl Script for std::slice::Iter<'_, f64> {
    fn number(&mut self) -> f64 {
        self.next().copied().unwrap_or(0.0)
    }
}
