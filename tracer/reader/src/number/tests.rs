use super::{Notation, number};

fn value(text: &str, notation: Notation) -> Option<(f64, bool, usize)> {
    number(text.as_bytes(), notation).map(|(number, length)| (number.value, number.is_integer, length))
}

#[test]
fn yaml_has_numbers_that_json_has_not() {
    for (text, expected) in [("+1", 1.0), (".5", 0.5), ("5.", 5.0), ("-.5e1", -5.0), ("007", 7.0), ("1.e2", 100.0)]
    {
        assert_eq!(value(text, Notation::Yaml).map(|(value, ..)| value), Some(expected), "{text}");
        assert_eq!(value(text, Notation::Json), None, "{text}");
    }
}

#[test]
fn a_text_without_digits_is_no_number() {
    for text in ["", "-", ".", "+.", "e5", "1e", "1e+", "-.e1", ".inf"] {
        assert_eq!(value(text, Notation::Yaml), None, "{text}");
    }
}

#[test]
fn a_number_ends_where_its_digits_do() {
    assert_eq!(value("12:30", Notation::Yaml), Some((12.0, true, 2)));
    assert_eq!(value("1.5]", Notation::Json), Some((1.5, false, 3)));
}

#[test]
fn only_a_float_has_a_negative_zero() {
    for notation in [Notation::Json, Notation::Yaml] {
        let sign = |text| value(text, notation).map(|(value, ..)| value.is_sign_negative());
        assert_eq!((sign("-0"), sign("-0.0"), sign("-0e0")), (Some(false), Some(true), Some(true)));
    }
}

#[test]
fn a_number_beyond_float64_is_none() {
    assert_eq!(value("1e309", Notation::Json), None);
    assert_eq!(value(&"9".repeat(400), Notation::Yaml), None);
    assert_eq!(value("1e-400", Notation::Json), Some((0.0, false, 6)));
}

proptest::proptest! {
    #[test]
    fn a_number_is_the_nearest_float64(whole in "[1-9][0-9]{0,24}", fraction in "[0-9]{0,24}", exponent in -330..300) {
        let text = format!("{whole}.{fraction}0e{exponent}");
        let expected: f64 = text.parse().unwrap();
        let read = value(&text, Notation::Json);
        proptest::prop_assert_eq!(read, expected.is_finite().then_some((expected, false, text.len())));
    }
}
