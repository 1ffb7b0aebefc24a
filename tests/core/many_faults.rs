//! Presets with very many faults: the first hundred are reported and the rest counted, in the time that reading takes.

use std::fmt::Write as _;

use renderer_core::design::preset::{self, MOST_FAULTS, PresetFault};

const MANY: usize = 30_000;

fn faults(text: &str) -> Vec<PresetFault> {
    preset::parse(text).expect_err("faults")
}

/// The first hundred of many faults, each on a line of its own behind the first line, and how many more there are.
#[track_caller]
fn assert_cut_off(text: &str, what: &str) {
    let faults = faults(text);
    assert_eq!(faults.len(), MOST_FAULTS + 1, "{what}");
    for (index, fault) in faults[..MOST_FAULTS].iter().enumerate() {
        assert_eq!(fault.line, index + 2, "{what}: {fault}");
    }
    let more = format!("and {} more faults", MANY - MOST_FAULTS);
    assert!(
        faults[MOST_FAULTS].message.contains(&more),
        "{what}: {}",
        faults[MOST_FAULTS]
    );
}

fn lines(first: &str, line: impl Fn(usize) -> String) -> String {
    let mut text = format!("{first}\n");
    for index in 0..MANY {
        let _ = writeln!(text, "{}", line(index));
    }
    text
}

#[test]
fn many_unknown_fields_are_cut_off() {
    assert_cut_off(
        &lines("format = 1", |index| format!("x{index} = 1")),
        "unknown fields",
    );
    // In the order of their names, which is the one they are found in, the last lines come first.
    assert_cut_off(
        &lines("format = 1", |index| format!("x{:05} = 1", MANY - index)),
        "backwards",
    );
}

#[test]
fn many_values_at_fault_are_cut_off() {
    let text = format!(
        "format = 1\n{}",
        "[[light.sun]]\nelevation = 1000\n".repeat(MANY)
    );
    let faults = faults(&text);
    assert_eq!(faults.len(), MOST_FAULTS + 1);
    // One is that there are so many suns.
    let of_suns = faults
        .iter()
        .filter(|fault| fault.path.ends_with("elevation"));
    let lines: Vec<usize> = of_suns.map(|fault| fault.line).collect();
    assert_eq!(
        lines,
        (1..MOST_FAULTS).map(|sun| 2 * sun + 1).collect::<Vec<_>>()
    );
}

#[test]
fn many_lines_that_are_no_toml_are_cut_off() {
    let faults = faults(&lines("format = 1", |_| "= =".into()));
    assert_eq!(faults.len(), MOST_FAULTS + 1);
    assert!(faults[MOST_FAULTS].message.contains("more faults"));
    assert!(faults.windows(2).all(|pair| pair[0].line <= pair[1].line));
}

#[test]
fn a_few_faults_are_told_to_the_last() {
    let mut text = "format = 1\n".to_owned();
    for index in 0..MOST_FAULTS {
        let _ = writeln!(text, "x{index} = 1");
    }
    let faults = faults(&text);
    assert_eq!(faults.len(), MOST_FAULTS);
    assert!(faults.iter().all(|fault| fault.path.starts_with('x')));
}

#[test]
fn a_backslash_in_double_quotes_is_explained() {
    for path in [r"C:\Users\me\chart.png", r"charts\chart.png", r"\x.png"] {
        let found = faults(&format!("format = 1\n[chart]\nimage = \"{path}\"\n"));
        assert!(found[0].message.contains("backslash"), "{}", found[0]);
        assert_eq!(found[0].line, 3);
    }
    // None elsewhere.
    let found = faults("format = 1\n[chart\n");
    assert!(!found[0].message.contains("backslash"), "{}", found[0]);
}
