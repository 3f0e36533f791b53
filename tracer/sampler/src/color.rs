//! Hue, saturation and value as a linear color, to the bits of `rtcli.scene.colors`.

/// Five steps lead from 1 down to 0.38, the smallest root; five more double the correct digits up to float64's.
const NEWTON_STEPS: usize = 12;

/// Returns the linear color of a hue, a saturation and a value from 0 to 1, in sRGB.
///
/// A. R. Smith, Color gamut transform pairs (SIGGRAPH 1978).
pub fn linear_from_hsv(hue: f64, saturation: f64, value: f64) -> [f64; 3] {
    let sextant = (hue * 6.0).trunc();
    let fraction = hue * 6.0 - sextant;
    let low = value * (1.0 - saturation);
    let falling = value * (1.0 - saturation * fraction);
    let rising = value * (1.0 - saturation * (1.0 - fraction));
    let srgb = match sextant as u64 % 6 {
        _ if saturation == 0.0 => [value; 3],
        0 => [value, rising, low],
        1 => [falling, value, low],
        2 => [low, value, rising],
        3 => [low, falling, value],
        4 => [rising, low, value],
        _ => [value, low, falling],
    };
    srgb.map(linear_from_srgb)
}

/// Returns the linear value of a component of sRGB.
///
/// IEC 61966-2-1: v / 12.92 up to 0.04045, else ((v + 0.055) / 1.055)^2.4.
fn linear_from_srgb(value: f64) -> f64 {
    if value <= 0.04045 {
        return value / 12.92;
    }
    let x = (value + 0.055) / 1.055;
    x * x * fifth_root(x * x) // x^2.4 = x^2 (x^2)^(1/5)
}

/// Returns the fifth root of a value from 0.008 to 1.
fn fifth_root(value: f64) -> f64 {
    let mut root = 1.0;
    for _ in 0..NEWTON_STEPS {
        // Newton's method for r^5 = value: r - (r^5 - value) / (5 r^4)
        let fourth = root * root * root * root;
        root -= (root - value / fourth) / 5.0;
    }
    root
}

#[cfg(test)]
mod tests {
    use super::linear_from_hsv;

    #[test]
    fn corners_of_the_cube_are_themselves() {
        assert_eq!(linear_from_hsv(0.0, 1.0, 1.0), [1.0, 0.0, 0.0]);
        assert_eq!(linear_from_hsv(1.0, 1.0, 1.0), [1.0, 0.0, 0.0]);
        assert_eq!(linear_from_hsv(0.5, 1.0, 1.0), [0.0, 1.0, 1.0]);
        assert_eq!(linear_from_hsv(0.7, 0.0, 1.0), [1.0; 3]);
    }
}
