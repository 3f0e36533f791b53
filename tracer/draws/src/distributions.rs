//! A random word as a number of a distribution. The same bits on every machine: only `+ - * /`, `sqrt` and the crate
//! `libm`.

use crate::philox::philox;

const TWO_TO_MINUS_52: f64 = f64::EPSILON;

/// A random word: the first of the four that Philox4x64-10 makes of a key and a counter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Draw(pub u64);

impl Draw {
    /// Return the draw of a sample's index, an attempt, and the number of an object in its group.
    pub fn new(key: [u64; 2], index: u64, attempt: u64, element: u64) -> Draw {
        Draw(philox(key, [index, attempt, element, 0])[0])
    }

    /// Return a number with `low <= x < high`; the only one if both are equal.
    ///
    /// u = floor(x / 2^11) 2^-53,  low + (high - low) u
    pub fn uniform(self, low: f64, high: f64) -> f64 {
        below(low + (high - low) * self.unit(), low, high)
    }

    /// Return a number with `low <= x < high` whose logarithm is uniform.
    ///
    /// exp(ln low + (ln high - ln low) u)
    pub fn log_uniform(self, low: f64, high: f64) -> f64 {
        let (start, end) = (libm::log(low), libm::log(high));
        below(libm::exp(start + (end - start) * self.unit()), low, high)
    }

    /// Return a number of a normal distribution, truncated to `low <= x < high`.
    ///
    /// With the distribution function F of the standard normal distribution, u = (floor(x / 2^12) + 1/2) 2^-52,
    /// a = (low - mean) / deviation, b = (high - mean) / deviation:
    ///
    /// mean + deviation F^-1(F(a) + (F(b) - F(a)) u)
    pub fn normal(self, mean: f64, deviation: f64, low: f64, high: f64) -> f64 {
        let u = ((self.0 >> 12) as f64 + 0.5) * TWO_TO_MINUS_52;
        let (a, b) = ((low - mean) / deviation, (high - mean) / deviation);
        // Close to 1, F has no digits left: an interval of the upper tail is mirrored.
        let mirrored = a > 0.0;
        let (start, end) =
            if mirrored { (cumulative(-b), cumulative(-a)) } else { (cumulative(a), cumulative(b)) };
        let u = if mirrored { 1.0 - u } else { u };
        let z = quantile(start + (end - start) * u);
        below(mean + deviation * if mirrored { -z } else { z }, low, high)
    }

    /// Return an integer from 0 to `count - 1`: the high 64 bits of x times `count`.
    pub fn below(self, count: u64) -> u64 {
        ((u128::from(self.0) * u128::from(count)) >> 64) as u64
    }

    /// A number from 0 to 1, without 1: a multiple of 2^-53.
    fn unit(self) -> f64 {
        (self.0 >> 11) as f64 * (TWO_TO_MINUS_52 / 2.0)
    }
}

/// Keep what rounding moved out of an interval inside.
fn below(x: f64, low: f64, high: f64) -> f64 {
    if x >= high && low < high { high.next_down().max(low) } else { x.max(low) }
}

/// The distribution function of the standard normal distribution.
fn cumulative(z: f64) -> f64 {
    0.5 * libm::erfc(-z / std::f64::consts::SQRT_2)
}

/// Its inverse: Wichura, algorithm AS 241 (PPND16), Applied Statistics 37 (1988), exact to about 1e-16.
fn quantile(p: f64) -> f64 {
    let q = p - 0.5;
    if q.abs() <= 0.425 {
        let r = 0.180625 - q * q;
        return q * ratio(r, &CENTER);
    }
    let r = libm::sqrt(-libm::log(if q < 0.0 { p } else { 1.0 - p }));
    let z = if r <= 5.0 { ratio(r - 1.6, &MIDDLE) } else { ratio(r - 5.0, &TAIL) };
    if q < 0.0 { -z } else { z }
}

/// Coefficients of a numerator and a denominator, the constants first, with the digits that are published.
type Rational = [[f64; 8]; 2];

fn ratio(r: f64, [numerator, denominator]: &Rational) -> f64 {
    let value = |coefficients: &[f64; 8]| coefficients.iter().rev().fold(0.0, |sum, c| sum * r + c);
    value(numerator) / value(denominator)
}

#[allow(clippy::excessive_precision)]
const CENTER: Rational = [
    [
        3.3871328727963666080,
        1.3314166789178437745e2,
        1.9715909503065514427e3,
        1.3731693765509461125e4,
        4.5921953931549871457e4,
        6.7265770927008700853e4,
        3.3430575583588128105e4,
        2.5090809287301226727e3,
    ],
    [
        1.0,
        4.2313330701600911252e1,
        6.8718700749205790830e2,
        5.3941960214247511077e3,
        2.1213794301586595867e4,
        3.9307895800092710610e4,
        2.8729085735721942674e4,
        5.2264952788528545610e3,
    ],
];
#[allow(clippy::excessive_precision)]
const MIDDLE: Rational = [
    [
        1.42343711074968357734,
        4.63033784615654529590,
        5.76949722146069140550,
        3.64784832476320460504,
        1.27045825245236838258,
        2.41780725177450611770e-1,
        2.27238449892691845833e-2,
        7.74545014278341407640e-4,
    ],
    [
        1.0,
        2.05319162663775882187,
        1.67638483018380384940,
        6.89767334985100004550e-1,
        1.48103976427480074590e-1,
        1.51986665636164571966e-2,
        5.47593808499534494600e-4,
        1.05075007164441684324e-9,
    ],
];
#[allow(clippy::excessive_precision)]
const TAIL: Rational = [
    [
        6.65790464350110377720,
        5.46378491116411436990,
        1.78482653991729133580,
        2.96560571828504891230e-1,
        2.65321895265761230930e-2,
        1.24266094738807843860e-3,
        2.71155556874348757815e-5,
        2.01033439929228813265e-7,
    ],
    [
        1.0,
        5.99832206555887937690e-1,
        1.36929880922735805310e-1,
        1.48753612908506148525e-2,
        7.86869131145613259100e-4,
        1.84631831751005468180e-5,
        1.42151175831644588870e-7,
        2.04426310338993978564e-15,
    ],
];

#[cfg(test)]
mod tests;
