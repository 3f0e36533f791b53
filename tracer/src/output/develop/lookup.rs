//! The look-up tables of [`Developer`](super::Developer), from an f32 to a step.
//!
//! Both take the *steps*: `steps[k]`, k = 1 to the white of the picture, is the smallest f32 whose developed
//! value is k or more, so the developed value of x is the number of steps up to x. The bits of a positive float,
//! read as an integer, grow with it; their upper 16 name a *bucket*, 128 of which make an octave. A bucket is at
//! most 1/128 of its start wide.

/// The bits that a bucket's name leaves.
const LOW: u32 = 16;
const LOW_MASK: u32 = (1 << LOW) - 1;

/// The interval that holds all steps; values below it are black, above it white.
struct Span {
    /// The start of the bucket before or around the first step: a value that is still black.
    black: f32,
    /// The last step.
    white: f32,
}

impl Span {
    fn of(steps: &[f32]) -> Span {
        let below_the_first = steps[1].to_bits() - 1;
        Span { black: f32::from_bits(below_the_first >> LOW << LOW), white: steps[steps.len() - 1] }
    }

    /// Clamp x to the span, NaN to black, with two comparisons of one instruction each.
    #[inline(always)]
    fn clamp(&self, x: f32) -> f32 {
        let x = if x > self.black { x } else { self.black };
        if x < self.white { x } else { self.white }
    }

    /// Return the offset of x's bits from the start of the first bucket.
    #[inline(always)]
    fn offset(&self, x: f32) -> u32 {
        x.to_bits().wrapping_sub(self.black.to_bits())
    }

    /// Return the bits of the buckets' starts.
    fn buckets(&self) -> impl Iterator<Item = u32> {
        (self.black.to_bits()..=self.white.to_bits()).step_by(1 << LOW)
    }
}

/// The look-up for the 255 steps of 8 bits: one gather, one addition, one shift.
///
/// Two steps are at least 2.4 / (255 * 1.055) = 1/112 of their value apart under the plain curve, and farther
/// under the others (where those are steeper, by at most 1.6 on logarithmic scales, it is dark and the steps are
/// wide). So a bucket holds at most one, and
///
/// value = (entry + low) >> 16, entry = (steps before the bucket) << 16 | (2^16 - low of the step in it),
///
/// where the sum carries into the value exactly from the step on. The idea is that of F. Giesen's float to sRGB8
/// table (<https://gist.github.com/rygorous/2203834>), which interpolates in wider buckets and is not exact.
pub(super) struct Eight {
    span: Span,
    entries: Box<[u32; Eight::BUCKETS]>,
}

impl Eight {
    /// Reinhard's curve, the longest, has its steps on 21 octaves. A power of two, for a mask instead
    /// of a bounds check.
    const BUCKETS: usize = 1 << 12;

    pub(super) fn new(steps: &[f32]) -> Eight {
        let span = Span::of(steps);
        let mut entries = Box::new([0; Eight::BUCKETS]);
        for (entry, start) in entries.iter_mut().zip(span.buckets()) {
            let before = steps[1..].partition_point(|step| step.to_bits() < start) as u32;
            let next = steps.get(before as usize + 1).map_or(u32::MAX, |step| step.to_bits() - start);
            *entry = (before << LOW) + (1u32 << LOW).saturating_sub(next);
        }
        Eight { span, entries }
    }

    #[inline(always)]
    pub(super) fn value(&self, x: f32) -> u8 {
        let offset = self.span.offset(self.span.clamp(x));
        let entry = self.entries[(offset >> LOW) as usize & (Eight::BUCKETS - 1)];
        ((entry + (offset & LOW_MASK)) >> LOW) as u8
    }
}

/// The look-up for the 65,535 steps of 16 bits: a guess on a straight line, and one comparison that corrects it.
///
/// A bucket holds up to 225 steps, but within it the curve is nearly straight: a chord misses it by
/// (1/8) (1/2.4) (1 - 1/2.4) / 128^2 of the value, 0.12 steps at most. Half a step below the curve the chord is
/// therefore at most one value behind, never ahead, and the next step tells which. In units of 2^-16 steps,
///
/// guess = (start + rise * (low / 2^4)) >> 16, entry = start | rise,
///
/// the start of the chord rounded to 1/16 of a step in the upper 20 bits, its rise over the bucket in 1/16 steps
/// in the lower 12. That and the cut of low add 0.12 steps to the chord's error; half a step would be too much.
pub(super) struct Sixteen {
    span: Span,
    entries: Box<[u32; Sixteen::BUCKETS]>,
    /// `next[k]` is the step from k to k + 1.
    next: Box<[f32; 1 << 16]>,
}

impl Sixteen {
    /// Reinhard's curve, the longest, has its steps on 37 octaves. A power of two, as above.
    const BUCKETS: usize = 1 << 13;

    /// The bits of an entry that hold the rise.
    const RISE: u32 = 12;

    /// `srgb` is the curve whose steps these are: from x to sRGB, 0..1, but not clipped at white.
    pub(super) fn new(steps: &[f32], srgb: impl Fn(f64) -> f64) -> Sixteen {
        let span = Span::of(steps);
        // The value is round(65535 srgb); half a step less, rounded, is 65535 srgb without its fraction.
        let sixteenths = |bits: u32| 16.0 * 65535.0 * srgb(f64::from(f32::from_bits(bits)));
        let mut entries = Box::new([0; Sixteen::BUCKETS]);
        for (entry, start) in entries.iter_mut().zip(span.buckets()) {
            let (from, to) = (sixteenths(start), sixteenths(start + (1 << LOW)));
            *entry = (from.round() as u32) << Sixteen::RISE | (to - from).round() as u32;
        }
        let mut next = Box::new([f32::INFINITY; 1 << 16]);
        next[..steps.len() - 1].copy_from_slice(&steps[1..]);
        Sixteen { span, entries, next }
    }

    #[inline(always)]
    pub(super) fn value(&self, x: f32) -> u16 {
        const RISE_MASK: u32 = (1 << Sixteen::RISE) - 1;
        let x = self.span.clamp(x);
        let offset = self.span.offset(x);
        let entry = self.entries[(offset >> LOW) as usize & (Sixteen::BUCKETS - 1)];
        let along = (offset & LOW_MASK) >> (LOW - Sixteen::RISE);
        let guess = ((entry & !RISE_MASK) + (entry & RISE_MASK) * along) >> LOW;
        guess as u16 + u16::from(x >= self.next[guess as usize & 0xFFFF])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_lies_below_the_first_step_is_black_even_if_a_bucket_starts_with_it() {
        for first in [0.5, 0.5f32.next_up(), 0.5f32.next_down()] {
            let eight = Eight::new(&[0.0, first, 1.0]);
            let values = [0.0, first.next_down(), first, 1.0, 2.0].map(|x| eight.value(x));
            assert_eq!(values, [0, 0, 1, 2, 2], "for a first step at {first}");
        }
    }
}
