//! Passes of floats as levels of PNG files, to look at and to read back.

use std::iter::zip;

use crate::memory::{OutOfMemory, collect, filled};
use crate::output::develop::BitDepth;
use crate::output::film::Pass;

const MOST: f64 = 65_535.0;

/// A 16-bit pass reaches at most this many times as far as half of its pixels do: those keep 12 bits, even where a
/// floor extends to the horizon. Values beyond that are clipped, and counted.
const REACH: f64 = 16.0;

/// Named in the error if memory runs out.
const PASS: &str = "a pass";

/// A pass as levels of a picture.
#[derive(Debug)]
pub struct PassPicture {
    /// The levels, row by row, with as many channels as the pass: 8 bits, or 16 with the high byte first.
    pub levels: Vec<u8>,
    /// Their depth.
    pub bits: BitDepth,
    /// How to get values from levels.
    pub decode: Decode,
}

/// How to get values from the levels of a pass.
#[derive(Clone, Debug, PartialEq)]
pub enum Decode {
    /// scale * level; the level 0 is nothing.
    Length {
        /// The length of a level.
        scale: f64,
        /// The number of pixels that are farther away than the highest level.
        clipped: usize,
    },
    /// low + scale * level, on each axis; three levels 0 are nothing.
    Position {
        /// What the level 0 would be.
        low: [f64; 3],
        /// The length of a level.
        scale: [f64; 3],
        /// The number of pixels that are outside of the levels.
        clipped: usize,
    },
    /// level / 127.5 - 1; three levels 128 are nothing.
    Direction,
    /// level / 65,535.
    Share,
}

/// From levels to values, as files state it: the quantity of a pass, as `rtcli.tracer.passes` names it, and a formula.
pub const FORMULAS: [(&str, &str); 4] = [LENGTH, POSITION, DIRECTION, SHARE];

const LENGTH: (&str, &str) = ("length", "scale * level");
const POSITION: (&str, &str) = ("position", "low + scale * level");
const DIRECTION: (&str, &str) = ("direction", "level / 127.5 - 1");
const SHARE: (&str, &str) = ("share", "level / 65535");

impl Decode {
    /// Return the formula from levels to values.
    pub const fn formula(&self) -> &'static str {
        match self {
            Decode::Length { .. } => LENGTH.1,
            Decode::Position { .. } => POSITION.1,
            Decode::Direction => DIRECTION.1,
            Decode::Share => SHARE.1,
        }
    }
}

/// Return a pass of floats as a picture; None of another. `scale` is the length of one level of a depth or distance; None
/// to fit it to the values.
///
/// # Errors
///
/// If memory runs out.
pub fn pass_picture(pass: Pass, values: &[f32], scale: Option<f64>) -> Result<Option<PassPicture>, OutOfMemory> {
    let points = values.as_chunks().0;
    Ok(Some(match pass {
        Pass::Depth | Pass::Distance => lengths(values, scale)?,
        Pass::Position => positions(points)?,
        // 255 (n + 1) / 2, the usual colors of normals.
        Pass::Normal => PassPicture {
            levels: collect(values.iter().map(|n| ((n + 1.0) * 127.5).round_ties_even() as u8), PASS)?,
            bits: BitDepth::Eight,
            decode: Decode::Direction,
        },
        Pass::Albedo => {
            let level = |share: &f32| (share * MOST as f32).round_ties_even() as u16;
            PassPicture {
                levels: in_bytes(values.iter().map(level))?,
                bits: BitDepth::Sixteen,
                decode: Decode::Share,
            }
        }
        Pass::Radiance | Pass::Alpha | Pass::ObjectId => return Ok(None),
    }))
}

/// Length / scale in 16 bits, from 1 on; 0 where nothing is hit.
fn lengths(lengths: &[f32], scale: Option<f64>) -> Result<PassPicture, OutOfMemory> {
    let seen = || lengths.iter().filter(|length| length.is_finite()).copied().map(f64::from);
    let (scale, farthest) = match scale {
        Some(scale) => (scale, scale * MOST),
        None => {
            let farthest = match median(&mut collect(seen(), PASS)?) {
                Some(median) => seen().fold(f64::NEG_INFINITY, f64::max).min(REACH * median),
                None => 0.0,
            };
            (if farthest / MOST == 0.0 { 1.0 } else { farthest / MOST }, farthest)
        }
    };
    let level = |&length: &f32| {
        if !length.is_finite() {
            return 0;
        }
        (f64::from(length).min(farthest) / scale).round_ties_even().clamp(1.0, MOST) as u16
    };
    let clipped = seen().filter(|&length| length > farthest).count();
    Ok(PassPicture {
        levels: in_bytes(lengths.iter().map(level))?,
        bits: BitDepth::Sixteen,
        decode: Decode::Length { scale, clipped },
    })
}

/// (Point - low) / scale in 16 bits, each axis from its lowest value at 1 to its highest; where nothing is hit, all three
/// are 0. A point at the origin counts as nothing: the pass has no other mark.
fn positions(points: &[[f32; 3]]) -> Result<PassPicture, OutOfMemory> {
    let is_hit = |point: &&[f32; 3]| point.iter().any(|&x| x != 0.0);
    let seen: Vec<[f64; 3]> = collect(points.iter().filter(is_hit).map(|point| point.map(f64::from)), PASS)?;
    let (mut low, high) = extent(&seen)?;
    let scale = [0, 1, 2].map(|i| if high[i] > low[i] { (high[i] - low[i]) / (MOST - 1.0) } else { 1.0 });
    for (low, scale) in zip(&mut low, scale) {
        *low -= scale;
    }
    let level = |point: &[f32; 3], i: usize| ((f64::from(point[i]) - low[i]) / scale[i]).round_ties_even();
    let levels = |point: &[f32; 3]| {
        if is_hit(&point) { [0, 1, 2].map(|i| level(point, i).clamp(1.0, MOST) as u16) } else { [0; 3] }
    };
    let is_clipped = |point: &&[f64; 3]| (0..3).any(|i| point[i] < low[i] + scale[i] || point[i] > high[i]);
    let mut bytes = filled(6 * points.len(), 0, PASS)?;
    for (bytes, point) in zip(bytes.as_chunks_mut::<6>().0, points) {
        bytes.copy_from_slice(levels(point).map(u16::to_be_bytes).as_flattened());
    }
    Ok(PassPicture {
        levels: bytes,
        bits: BitDepth::Sixteen,
        decode: Decode::Position { low, scale, clipped: seen.iter().filter(is_clipped).count() },
    })
}

/// The lowest and highest value on each axis, at most `REACH` times as far as half of them.
fn extent(points: &[[f64; 3]]) -> Result<([f64; 3], [f64; 3]), OutOfMemory> {
    let axes = [0, 1, 2].map(|i| collect(points.iter().map(|point| point[i]), PASS));
    let mut middle = [0.0; 3];
    for (middle, axis) in zip(&mut middle, axes) {
        let Some(median) = median(&mut axis?) else { return Ok(([0.0; 3], [0.0; 3])) };
        *middle = median;
    }
    let way = |point: &[f64; 3]| zip(point, middle).map(|(x, middle)| (x - middle).abs()).fold(0.0, f64::max);
    let reach = REACH * median(&mut collect(points.iter().map(way), PASS)?).unwrap_or(0.0);
    let low = points.iter().fold([f64::INFINITY; 3], |low, p| [0, 1, 2].map(|i| low[i].min(p[i])));
    let high = points.iter().fold([f64::NEG_INFINITY; 3], |high, p| [0, 1, 2].map(|i| high[i].max(p[i])));
    Ok(([0, 1, 2].map(|i| low[i].max(middle[i] - reach)), [0, 1, 2].map(|i| high[i].min(middle[i] + reach))))
}

/// The median, the mean of the middle two of an even number; None of nothing.
fn median(values: &mut [f64]) -> Option<f64> {
    let half = values.len() / 2;
    let is_even = values.len().is_multiple_of(2);
    let (below, &mut middle, _) = if values.is_empty() {
        return None;
    } else {
        values.select_nth_unstable_by(half, f64::total_cmp)
    };
    let before = below.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    Some(if is_even { (before + middle) / 2.0 } else { middle })
}

fn in_bytes(levels: impl ExactSizeIterator<Item = u16>) -> Result<Vec<u8>, OutOfMemory> {
    let mut bytes = filled(2 * levels.len(), 0, PASS)?;
    for (bytes, level) in zip(bytes.as_chunks_mut().0, levels) {
        *bytes = level.to_be_bytes();
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::{Decode, median, pass_picture};
    use crate::output::film::Pass;
    use proptest::prelude::*;

    fn levels(bytes: &[u8]) -> Vec<u16> {
        bytes.as_chunks().0.iter().map(|&level| u16::from_be_bytes(level)).collect()
    }

    #[test]
    fn the_median_is_the_mean_of_the_middle() {
        assert_eq!(median(&mut [3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(&mut [4.0, 1.0, 2.0, 9.0]), Some(3.0));
        assert_eq!(median(&mut []), None);
    }

    #[test]
    fn ids_and_light_are_no_levels() {
        for pass in [Pass::Radiance, Pass::Alpha, Pass::ObjectId] {
            assert!(pass_picture(pass, &[0.5], None).unwrap().is_none());
        }
    }

    #[test]
    fn lengths_far_beyond_most_are_clipped() {
        let picture = pass_picture(Pass::Depth, &[1.0, 1.0, 1.0, 90.0, f32::INFINITY], None).unwrap().unwrap();
        assert_eq!(levels(&picture.levels)[3..], [65_535, 0]);
        assert_eq!(picture.decode, Decode::Length { scale: 16.0 / 65_535.0, clipped: 1 });
        let none = pass_picture(Pass::Depth, &[f32::INFINITY], None).unwrap().unwrap();
        assert_eq!((levels(&none.levels), none.decode), (vec![0], Decode::Length { scale: 1.0, clipped: 0 }));
    }

    #[test]
    fn directions_are_the_usual_colors() {
        let picture = pass_picture(Pass::Normal, &[0.0, 1.0, -1.0, 0.0, 0.0, 0.0], None).unwrap().unwrap();
        assert_eq!(picture.levels, [128, 255, 0, 128, 128, 128]);
    }

    proptest! {
        #[test]
        fn lengths_come_back(lengths in prop::collection::vec(1.0_f32..9.0, 1..40)) {
            let picture = pass_picture(Pass::Distance, &lengths, None).unwrap().unwrap();
            let Decode::Length { scale, clipped } = picture.decode else { unreachable!() };
            prop_assert_eq!(clipped, 0);
            for (level, length) in levels(&picture.levels).into_iter().zip(lengths) {
                prop_assert!((scale * f64::from(level) - f64::from(length)).abs() <= scale / 2.0 + 1e-12);
            }
        }

        #[test]
        fn points_come_back(points in prop::collection::vec(prop::array::uniform3(1.0_f32..2.0), 1..40)) {
            let picture = pass_picture(Pass::Position, points.as_flattened(), None).unwrap().unwrap();
            let Decode::Position { low, scale, clipped } = picture.decode else { unreachable!() };
            let levels = levels(&picture.levels);
            for (i, (level, x)) in levels.into_iter().zip(points.as_flattened()).enumerate() {
                let error = low[i % 3] + scale[i % 3] * f64::from(level) - f64::from(*x);
                prop_assert!(clipped > 0 || error.abs() <= scale[i % 3] / 2.0 + 1e-12);
            }
        }
    }
}
