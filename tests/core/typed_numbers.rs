//! Numbers as people type them: what has one meaning is read, what has two or none is refused with a reason.

use proptest::prelude::*;
use renderer_core::design::{Design, Shape, Shaped, preset, read_number};

#[track_caller]
fn assert_read(text: &str, unit: &str, expected: f64) {
    let read =
        read_number(text, unit, false).unwrap_or_else(|why| panic!("{text:?} {unit:?}: {why}"));
    let near = (read - expected).abs() <= 1e-12 * expected.abs();
    assert!(near, "{text:?} in {unit:?} is {read}, not {expected}");
}

#[test]
fn decimal_marks_groups_and_fractions_are_read() {
    for (text, expected) in [
        ("10,5", 10.5),
        ("10.5", 10.5),
        ("0,125", 0.125),
        ("1.234", 1.234),
        ("1.234,5", 1234.5),
        ("1,234.5", 1234.5),
        ("1,234,567", 1_234_567.0),
        ("1.234.567,25", 1_234_567.25),
        ("12 345,6", 12345.6),
        ("12\u{202f}345", 12345.0),
        ("1'234'567", 1_234_567.0),
        (".5", 0.5),
        (",5", 0.5),
        ("5.", 5.0),
        ("-2,5", -2.5),
        ("−2.5", -2.5),
        ("+3", 3.0),
        ("2.5e-3", 0.0025),
        ("1E3", 1000.0),
        ("1/4", 0.25),
        ("1 1/2", 1.5),
        ("1½", 1.5),
        ("¾", 0.75),
        ("25 %", 0.25),
        ("１０．５", 10.5),
        ("٣٫٥", 3.5),
        (" 7 ", 7.0),
    ] {
        assert_read(text, "", expected);
    }
}

#[test]
fn units_of_the_same_kind_are_read() {
    for (text, unit, expected) in [
        ("2.5 mm", "mm", 2.5),
        ("2,5mm", "mm", 2.5),
        ("70 cm", "mm", 700.0),
        ("1 m 40 cm", "mm", 1400.0),
        ("1 in", "mm", 25.4),
        ("1/4\"", "mm", 6.35),
        ("5' 6\"", "mm", 1676.4),
        ("500 µm", "mm", 0.5),
        ("200 mm", "cm", 20.0),
        ("33.8 /in", "/cm", 33.8 / 2.54),
        ("33.8 epi", "/cm", 33.8 / 2.54),
        ("13 ends/cm", "/cm", 13.0),
        ("2 /cm", "/mm", 0.2),
        ("700 turns/m", "turns/cm", 7.0),
        ("5 cycles/cm", "cycles/mm", 0.5),
        ("0.5 turns", "°", 180.0),
        ("45 deg", "°", 45.0),
        ("45°", "°", 45.0),
        ("118 /cm", "dpi", 299.72),
        ("90 s", "min", 1.5),
        ("1 h 30 min", "min", 90.0),
        ("2 min", "s", 120.0),
        ("0.5", "%", 0.5),
        ("0.5 %", "%", 0.5),
        ("12 yarns", "yarns", 12.0),
        ("1 yarn", "yarns", 1.0),
        ("2 EV", "EV", 2.0),
    ] {
        assert_read(text, unit, expected);
    }
}

#[test]
fn sums_and_products_are_worked_out() {
    for (text, unit, expected) in [
        ("70 + 5", "mm", 75.0),
        ("70-5", "mm", 65.0),
        ("2*3 cm", "mm", 60.0),
        ("140 cm / 3", "mm", 1400.0 / 3.0),
        ("140 cm/4", "mm", 350.0),
        ("1/4 in * 3", "mm", 19.05),
        ("1 1/2 in + 2 cm", "mm", 58.1),
        ("(12 + 8) cm", "mm", 200.0),
        ("(1 + 2) × (3 - 1)", "", 6.0),
        ("2 + 3 * 4", "", 14.0),
        ("-(2,5 + 0,5)", "", -3.0),
        ("3 * -2", "", -6.0),
        ("2e-3 + 1", "", 1.002),
        ("12 ÷ 5", "", 2.4),
        ("33 /in * 2", "/cm", 66.0 / 2.54),
        ("1 m - 40 cm", "mm", 600.0),
        ("5' + 6\"", "mm", 1676.4),
    ] {
        assert_read(text, unit, expected);
    }
    for (text, unit, why) in [
        (
            "70 cm + 5",
            "mm",
            "a unit in one part of the sum and none in another",
        ),
        (
            "2 cm * 3 cm",
            "mm",
            "multiplies with a number that has a unit",
        ),
        ("7 mm / 2 cm", "mm", "divides by a number that has a unit"),
        ("7 / (1 - 1)", "mm", "divides by 0"),
        ("(1 + 2", "mm", "lacks a )"),
        ("1 + ", "mm", "no number"),
        ("1 + 2 kg", "mm", "unit kg; units of lengths"),
        ("(1 cm + 2 cm) mm", "mm", "in parentheses and behind them"),
    ] {
        let error = read_number(text, unit, false).expect_err(text);
        assert!(
            error.contains(why),
            "{text:?} in {unit:?}: {error:?} does not tell {why:?}"
        );
    }
    assert_eq!(read_number("3 * 40", "yarns", true), Ok(120.0));
    assert!(read_number("7 / 2.0 + 1", "", true).is_err());
}

#[test]
fn what_is_not_understood_is_refused_with_a_reason() {
    for (text, unit, why) in [
        ("", "mm", "missing"),
        ("  ", "mm", "missing"),
        ("abc", "mm", "“abc” is no number"),
        ("1,234", "mm", "may be 1.234 or 1234"),
        ("10 kg", "mm", "unit kg; units of lengths are mm, cm, m"),
        ("10 mm", "°", "unit mm; units of angles"),
        ("10 mm", "", "unit mm"),
        ("10 mm", "yarns", "here it is yarns"),
        ("1 2", "mm", "more than one number"),
        ("1 cm 2", "mm", "more than one number"),
        ("1.2.3", "mm", "no number"),
        ("1,23,4", "mm", "no number"),
        ("1/0", "mm", "divides by 0"),
        ("1e400", "mm", "too large"),
        ("--5", "mm", "no number"),
        ("NaN", "mm", "no number"),
        ("inf", "mm", "no number"),
    ] {
        let error = read_number(text, unit, false).expect_err(text);
        assert!(
            error.contains(why),
            "{text:?} in {unit:?}: {error:?} does not tell {why:?}"
        );
    }
}

#[test]
fn whole_numbers_may_be_grouped_and_have_no_parts() {
    for (text, expected) in [
        ("1.024", 1024.0),
        ("1,024", 1024.0),
        ("1 024", 1024.0),
        ("12,0", 12.0),
    ] {
        assert_eq!(read_number(text, "", true), Ok(expected), "{text:?}");
    }
    for text in ["2.5", "1/3", "0,125"] {
        let error = read_number(text, "", true).expect_err(text);
        assert!(error.contains("no whole number"), "{error:?}");
    }
}

/// Units of all fields, and what a field of each is called.
fn units_of_fields() -> Vec<&'static str> {
    fn walk(shape: &Shape, units: &mut Vec<&'static str>) {
        match shape {
            Shape::Number(field) => units.push(field.unit),
            Shape::Table(entries) => entries.iter().for_each(|entry| walk(&entry.shape, units)),
            Shape::List { of, .. } | Shape::Optional(of) => walk(of, units),
            _ => {}
        }
    }
    let mut units = Vec::new();
    walk(&Design::shape(), &mut units);
    units.sort_unstable();
    units.dedup();
    units
}

proptest! {
    #[test]
    fn what_a_program_writes_is_read_as_it_is(value in proptest::num::f64::NORMAL | proptest::num::f64::ZERO) {
        for unit in units_of_fields() {
            prop_assert_eq!(read_number(&value.to_string(), unit, false), Ok(value));
            prop_assert_eq!(read_number(&format!("{value} {unit}"), unit, false), Ok(value));
        }
    }

    #[test]
    fn a_decimal_comma_is_a_decimal_point(whole in 0_u32..100_000, part in 0_u32..10_000) {
        // Three digits behind a comma may be thousands.
        prop_assume!(part.to_string().len() != 3);
        let comma = read_number(&format!("{whole},{part}"), "mm", false);
        prop_assert_eq!(&comma, &read_number(&format!("{whole}.{part}"), "mm", false));
        prop_assert_eq!(comma, Ok(format!("{whole}.{part}").parse().unwrap()));
    }

    #[test]
    fn no_text_makes_the_reader_panic(text in "\\PC*", integer: bool) {
        for unit in units_of_fields() {
            if let Ok(value) = read_number(&text, unit, integer) {
                prop_assert!(value.is_finite());
                prop_assert!(!integer || value.fract() == 0.0);
            }
        }
    }

    #[test]
    fn no_text_like_a_number_makes_the_reader_panic(text in "[-+*()0-9.,' /eE½%\"mcin°]{0,16}", integer: bool) {
        for unit in ["", "mm", "°", "min", "yarns"] {
            if let Ok(value) = read_number(&text, unit, integer) {
                prop_assert!(value.is_finite());
            }
        }
    }
}

#[test]
fn set_takes_numbers_as_they_are_typed() {
    let design = Design::default();
    let set = |path: &str, value: &str| preset::set(&design, path, value);
    assert_eq!(set("length.value", "1/8 in").unwrap().length.value, 3.175);
    assert_eq!(set("length.value", "2,5").unwrap().length.value, 2.5);
    assert_eq!(set("sheet.warps", "1.024 yarns").unwrap().sheet.warps, 1024);
    let error = set("length.value", "3 kg").unwrap_err().to_string();
    assert!(
        error.contains("kg") && error.contains("mm") && error.contains("0 to 100"),
        "{error}"
    );
    let error = set("length.value", "70 cm").unwrap_err().to_string();
    assert!(error.contains("0 to 100 mm"), "{error}");
}
